//! Whether the records of a recording fit into what holds them: the crate `mcap` 0.25 takes their lengths on trust and panics on a record
//! that is longer than its chunk. And where a recording that was cut off ends.

use std::ops::Range;

use crate::cdr::Wrong;

/// Bytes that an MCAP file begins with.
const MAGIC: usize = 8;
/// A record's kind and its length.
const HEAD: usize = 9;
/// The kind that holds other records.
const CHUNK: u8 = 6;

/// Where a file that was cut off ends.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Cut {
    /// Bytes up to the end of the last whole record or chunk.
    whole: usize,
    /// The whole records of a chunk behind it that is cut; empty if there is none.
    inner: Range<usize>,
}

impl Cut {
    /// Where the last whole record ends.
    pub fn end(&self) -> usize {
        self.whole.max(self.inner.end)
    }

    /// What is whole: records of the cut chunk stand for themselves.
    pub fn repaired(&self, file: &[u8]) -> Vec<u8> {
        [&file[..self.whole], &file[self.inner.clone()]].concat()
    }
}

/// Checks the records of each chunk. If the file is cut off, where.
pub(crate) fn fit(file: &[u8]) -> Result<Option<Cut>, Wrong> {
    let Some((magic, mut rest)) = file.split_at_checked(MAGIC) else { return Ok(None) };
    while let Some((kind, content, after)) = record(rest) {
        if kind == CHUNK
            && let Some((length, inner)) = records_of(content)?
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
    // What is left of a whole file is the magic at its end.
    if rest == magic {
        return Ok(None);
    }
    let whole = file.len() - rest.len();
    let chunk = rest.get(HEAD..).filter(|_| rest[0] == CHUNK).unwrap_or_default();
    let records = records_of(chunk)?.map_or(&[][..], |(_, records)| records);
    let (mut rest, begin) = (records, file.len() - records.len());
    while let Some((_, _, after)) = record(rest) {
        rest = after;
    }
    let end = file.len() - rest.len();
    Ok(Some(Cut { whole, inner: if begin < end { begin..end } else { whole..whole } }))
}

/// The first record: kind, content, what follows.
fn record(bytes: &[u8]) -> Option<(u8, &[u8], &[u8])> {
    let (head, rest) = bytes.split_first_chunk::<HEAD>()?;
    let mut length = [0; 8];
    length.copy_from_slice(&head[1..]);
    let (content, after) = rest.split_at_checked(usize::try_from(u64::from_le_bytes(length)).ok()?)?;
    Some((head[0], content, after))
}

/// The records in a chunk: behind two times, a size (8 bytes each), a check sum and the name of the compression. Their length as it states
/// it, and the actual one; `None` of one without this head. A compressed chunk is refused.
fn records_of(chunk: &[u8]) -> Result<Option<(u64, &[u8])>, Wrong> {
    let Some((length, rest)) = chunk.get(28..).and_then(<[u8]>::split_first_chunk::<4>) else {
        return Ok(None);
    };
    if *length != [0; 4] {
        let name = rest.get(..u32::from_le_bytes(*length) as usize).unwrap_or_default();
        let name: String =
            String::from_utf8_lossy(name).chars().take(32).flat_map(char::escape_debug).collect();
        let [expected, found] = paid_files::compressed_chunks(&name);
        return Err((expected, found));
    }
    Ok(rest.split_first_chunk::<8>().map(|(length, rest)| (u64::from_le_bytes(*length), rest)))
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
    fn records_that_are_longer_than_their_chunk_are_refused_and_a_cut_file_is_whole_up_to_its_last_record() {
        // Kind 5 and two bytes.
        let record = [5, 2, 0, 0, 0, 0, 0, 0, 0, 7, 7];
        assert_eq!(fit(&file(&record, 11)), Ok(None));
        for wrong in [10, 12, u64::MAX] {
            assert!(fit(&file(&record, wrong)).is_err(), "{wrong}");
        }
        let whole = file(&record, 11);
        let end = whole.len() - MAGIC;
        let cut = |length: usize| fit(&whole[..length]).expect("fits").expect("cut off");
        assert_eq!(
            (cut(end - 1).end(), cut(end - 1).repaired(&whole)),
            (MAGIC, vec![1; MAGIC]),
            "in the chunk's record"
        );
        assert_eq!(
            (cut(end).end(), cut(end + 3).end()),
            (end, end),
            "behind the chunk, and within the last magic"
        );
        assert_eq!(cut(end).repaired(&whole), whole[..end]);
        let two = file(&[record, record].concat(), 22);
        let end = two.len() - MAGIC - 4;
        let cut = fit(&two[..end]).expect("fits").expect("cut off");
        assert_eq!(cut.repaired(&two), [&[1; MAGIC][..], &record].concat(), "in the chunk's second record");
        assert_eq!(cut.end(), end - 7);
    }

    #[test]
    fn a_compressed_chunk_is_named_with_what_to_do() {
        let mut chunk = vec![0; 28];
        chunk.extend(4_u32.to_le_bytes());
        chunk.extend(b"zstd\x04\0\0\0\0\0\0\0abcd");
        let (expected, found) = records_of(&chunk).expect_err("compressed");
        assert_eq!(expected, "chunks without compression");
        assert!(
            found.starts_with("chunks compressed with zstd; `mcap decompress IN.mcap -o OUT.mcap`"),
            "{found}"
        );
    }
}
