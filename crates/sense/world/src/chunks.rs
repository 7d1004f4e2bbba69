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
            && let Some((length, inner)) = records_of(content)
        {
            let Some(mut inner) = usize::try_from(length).ok().and_then(|length| inner.get(..length)) else {
                let expected = "a chunk that is as long as it says".to_owned();
                return Err((expected, format!("one of {} bytes", content.len())));
            };
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
    // What is left of a whole file is the magic at its end. A record that is cut would be read as far as it goes.
    if rest.len() >= HEAD {
        let expected = "records that end within the file".to_owned();
        return Err((expected, format!("one of {} bytes that does not", rest.len())));
    }
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
/// Their length as it states it, and the actual one; `None` of a compressed chunk and one without this head.
fn records_of(chunk: &[u8]) -> Option<(u64, &[u8])> {
    let (length, rest) = chunk.get(28..)?.split_first_chunk::<4>()?;
    if *length != [0; 4] {
        return None;
    }
    let (length, rest) = rest.split_first_chunk::<8>()?;
    Some((u64::from_le_bytes(*length), rest))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file's begin, a chunk without compression around `records` that states `length` bytes of them, and the file's end.
    fn file(records: &[u8], length: u64) -> Vec<u8> {
        let mut chunk = vec![0; 28 + 4];
        chunk.extend(length.to_le_bytes());
        chunk.extend(records);
        let mut out = vec![1; MAGIC];
        out.push(CHUNK);
        out.extend((chunk.len() as u64).to_le_bytes());
        out.extend(chunk);
        out.extend([1; MAGIC]);
        out
    }

    #[test]
    fn records_that_are_longer_than_their_chunk_and_cut_files_are_refused() {
        // Kind 5 and two bytes.
        let record = [5, 2, 0, 0, 0, 0, 0, 0, 0, 7, 7];
        assert_eq!(fit(&file(&record, 11)), Ok(()));
        for wrong in [10, 12, u64::MAX] {
            assert!(fit(&file(&record, wrong)).is_err(), "{wrong}");
        }
        let whole = file(&record, 11);
        let (expected, _) = fit(&whole[..whole.len() - MAGIC - 1]).expect_err("cut within the chunk");
        assert_eq!(expected, "records that end within the file");
    }
}
