//! Whether the records of a recording fit into what holds them: the crate `mcap` 0.25 takes their lengths on trust and panics on a record
//! that is longer than its chunk.

use crate::cdr::Wrong;

/// Bytes that an MCAP file begins with.
const MAGIC: usize = 8;
/// A record's kind and its length.
const HEAD: usize = 9;
/// The kind that holds other records.
const CHUNK: u8 = 6;

/// Checks the records of each chunk that is not compressed.
pub(crate) fn fit(file: &[u8]) -> Result<(), Wrong> {
    let mut rest = file.get(MAGIC..).unwrap_or_default();
    while let Some((kind, content, after)) = record(rest) {
        if kind == CHUNK
            && let Some(mut inner) = records_of(content)
        {
            while !inner.is_empty() {
                let Some((_, _, next)) = record(inner) else {
                    let expected = "records that end within their chunk".to_owned();
                    return Err((expected, format!("one of {} bytes that does not", inner.len())));
                };
                inner = next;
            }
        }
        rest = after;
    }
    // What is left is the magic at the end, or a cut file, which the reader says itself.
    Ok(())
}

/// The first record: kind, content, what follows.
fn record(bytes: &[u8]) -> Option<(u8, &[u8], &[u8])> {
    let (head, rest) = bytes.split_first_chunk::<HEAD>()?;
    let mut length = [0; 8];
    length.copy_from_slice(&head[1..]);
    let (content, after) = rest.split_at_checked(usize::try_from(u64::from_le_bytes(length)).ok()?)?;
    Some((head[0], content, after))
}

/// The records in a chunk without compression: behind two times, a size (8 bytes each), a check sum and the name of the compression.
fn records_of(chunk: &[u8]) -> Option<&[u8]> {
    let (length, rest) = chunk.get(28..)?.split_first_chunk::<4>()?;
    if *length != [0; 4] {
        return None;
    }
    let (length, rest) = rest.split_first_chunk::<8>()?;
    rest.get(..usize::try_from(u64::from_le_bytes(*length)).ok()?)
}
