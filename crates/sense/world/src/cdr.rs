//! ROS 2's wire format, as far as these messages need it: little-endian CDR (OMG XCDR1) with a header of four bytes.

/// Little-endian CDR.
const HEADER: [u8; 4] = [0, 1, 0, 0];

/// Writes values one after the other.
#[derive(Debug)]
pub(crate) struct CdrWriter {
    out: Vec<u8>,
}

impl CdrWriter {
    pub fn new() -> Self {
        Self { out: HEADER.to_vec() }
    }

    pub fn finish(self) -> Vec<u8> {
        self.out
    }

    fn align(&mut self, size: usize) {
        while !(self.out.len() - HEADER.len()).is_multiple_of(size) {
            self.out.push(0);
        }
    }

    pub fn u8(&mut self, value: u8) {
        self.out.push(value);
    }

    pub fn bool(&mut self, value: bool) {
        self.out.push(u8::from(value));
    }

    pub fn u32(&mut self, value: u32) {
        self.align(4);
        self.out.extend(value.to_le_bytes());
    }

    pub fn f64(&mut self, value: f64) {
        self.align(8);
        self.out.extend(value.to_le_bytes());
    }

    pub fn f64s(&mut self, values: &[f64]) {
        values.iter().for_each(|value| self.f64(*value));
    }

    /// A sequence of numbers, its length first.
    pub fn f64_list(&mut self, values: &[f64]) {
        self.length(values.len());
        self.f64s(values);
    }

    /// A sequence of bytes, its length first.
    pub fn bytes(&mut self, values: &[u8]) {
        self.length(values.len());
        self.out.extend(values);
    }

    pub fn string(&mut self, text: &str) {
        self.length(text.len() + 1);
        self.out.extend(text.as_bytes());
        self.out.push(0);
    }

    pub fn length(&mut self, length: usize) {
        self.u32(u32::try_from(length).unwrap_or(u32::MAX));
    }

    /// `std_msgs/Header`.
    pub fn header(&mut self, stamp_ns: u64, frame: &str) {
        self.u32((stamp_ns / 1_000_000_000) as u32);
        self.u32((stamp_ns % 1_000_000_000) as u32);
        self.string(frame);
    }
}

/// Reads them again. Nothing is read beyond the end.
#[derive(Debug)]
pub(crate) struct CdrReader<'a> {
    data: &'a [u8],
    at: usize,
}

/// What was expected and what was found.
pub(crate) type Wrong = (String, String);

impl<'a> CdrReader<'a> {
    pub fn new(data: &'a [u8]) -> Result<Self, Wrong> {
        match data.split_first_chunk::<4>() {
            Some((header, data)) if header[1] == HEADER[1] => Ok(Self { data, at: 0 }),
            _ => Err(("little-endian CDR".to_owned(), format!("{:?}", &data[..data.len().min(4)]))),
        }
    }

    fn take(&mut self, size: usize, align: usize) -> Result<&'a [u8], Wrong> {
        let at = self.at.next_multiple_of(align);
        let end = at.checked_add(size).filter(|end| *end <= self.data.len());
        let Some(end) = end else {
            return Err((format!("{size} bytes at {at}"), format!("the end at {}", self.data.len())));
        };
        self.at = end;
        Ok(&self.data[at..end])
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], Wrong> {
        let mut out = [0; N];
        out.copy_from_slice(self.take(N, N)?);
        Ok(out)
    }

    pub fn u8(&mut self) -> Result<u8, Wrong> {
        Ok(self.array::<1>()?[0])
    }

    pub fn u32(&mut self) -> Result<u32, Wrong> {
        Ok(u32::from_le_bytes(self.array()?))
    }

    pub fn f64(&mut self) -> Result<f64, Wrong> {
        Ok(f64::from_le_bytes(self.array()?))
    }

    pub fn f64s<const N: usize>(&mut self) -> Result<[f64; N], Wrong> {
        let mut out = [0.0; N];
        for value in &mut out {
            *value = self.f64()?;
        }
        Ok(out)
    }

    pub fn f64_list(&mut self) -> Result<Vec<f64>, Wrong> {
        let length = self.length(8)?;
        (0..length).map(|_| self.f64()).collect()
    }

    pub fn bytes(&mut self) -> Result<&'a [u8], Wrong> {
        let length = self.length(1)?;
        self.take(length, 1)
    }

    pub fn string(&mut self) -> Result<String, Wrong> {
        let bytes = self.bytes()?;
        let text = bytes.strip_suffix(&[0]).unwrap_or(bytes);
        String::from_utf8(text.to_vec()).map_err(|_| ("text".to_owned(), "bytes that are none".to_owned()))
    }

    /// The length of a sequence of items of `size` bytes or more: there must be room for them.
    pub fn length(&mut self, size: usize) -> Result<usize, Wrong> {
        let length = self.u32()? as usize;
        let room = (self.data.len() - self.at) / size;
        if length > room {
            return Err((format!("a list of at most {room}"), length.to_string()));
        }
        Ok(length)
    }

    /// `std_msgs/Header`: time `[ns]` and frame.
    pub fn header(&mut self) -> Result<(u64, String), Wrong> {
        let (seconds, ns) = (self.u32()?, self.u32()?);
        Ok((u64::from(seconds) * 1_000_000_000 + u64::from(ns), self.string()?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_aligned_to_their_size_behind_the_header() {
        let mut out = CdrWriter::new();
        out.u8(7);
        out.f64(1.5);
        out.string("ab");
        let bytes = out.finish();
        // Header 4, byte 1, padding 7, number 8, length 4, text with its end 3.
        assert_eq!(bytes.len(), 4 + 1 + 7 + 8 + 4 + 3);
        assert_eq!(&bytes[12..20], &1.5_f64.to_le_bytes());
        let mut back = CdrReader::new(&bytes).expect("a header");
        assert_eq!((back.u8(), back.f64()), (Ok(7), Ok(1.5)));
        assert_eq!(back.string().as_deref(), Ok("ab"));
        assert_eq!(back.u32().expect_err("nothing more").0, "4 bytes at 24");
    }

    #[test]
    fn a_length_beyond_the_end_is_refused_before_memory_is_taken() {
        let mut out = CdrWriter::new();
        out.u32(4_000_000_000);
        let bytes = out.finish();
        let wrong = CdrReader::new(&bytes).and_then(|mut r| r.f64_list()).expect_err("no room");
        assert_eq!(wrong, ("a list of at most 0".to_owned(), "4000000000".to_owned()));
        assert!(CdrReader::new(&[0, 9]).is_err());
    }
}
