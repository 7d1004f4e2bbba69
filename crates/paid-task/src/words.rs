//! Little-endian 64-bit words, the bytes of a snapshot.

/// Bytes being written.
#[derive(Debug, Default)]
pub struct Writer(pub Vec<u8>);

impl Writer {
    /// One number.
    pub fn u64(&mut self, x: u64) {
        self.0.extend(x.to_le_bytes());
    }

    /// One number, exactly.
    pub fn f64(&mut self, x: f64) {
        self.u64(x.to_bits());
    }

    /// Numbers whose count the reader knows.
    pub fn all(&mut self, values: &[f64]) {
        for x in values {
            self.f64(*x);
        }
    }

    /// Numbers behind their count.
    pub fn list(&mut self, values: &[f64]) {
        self.u64(values.len() as u64);
        self.all(values);
    }
}

/// Bytes being read.
#[derive(Debug)]
pub struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Reader<'a> {
    /// From byte `at` on.
    pub fn new(bytes: &'a [u8], at: usize) -> Self {
        Self { bytes, at }
    }

    /// Bytes that were not read.
    pub fn left(&self) -> usize {
        self.bytes.len() - self.at
    }

    /// One number.
    pub fn u64(&mut self) -> Result<u64, String> {
        let end = self.at + 8;
        let bytes = self.bytes.get(self.at..end).ok_or_else(|| {
            format!("task snapshot: it ends after {} bytes, before its data does", self.bytes.len())
        })?;
        self.at = end;
        let mut word = [0; 8];
        word.copy_from_slice(bytes);
        Ok(u64::from_le_bytes(word))
    }

    /// One number.
    pub fn f64(&mut self) -> Result<f64, String> {
        Ok(f64::from_bits(self.u64()?))
    }

    /// A count.
    pub fn usize(&mut self) -> Result<usize, String> {
        Ok(self.u64()? as usize)
    }

    /// A small number.
    pub fn u32(&mut self) -> Result<u32, String> {
        u32::try_from(self.u64()?).map_err(|_| "task snapshot: a number is out of range".to_owned())
    }

    /// Numbers whose count is known.
    pub fn array<const N: usize>(&mut self) -> Result<[f64; N], String> {
        let mut out = [0.0; N];
        for x in &mut out {
            *x = self.f64()?;
        }
        Ok(out)
    }

    /// Numbers behind their count.
    pub fn list(&mut self) -> Result<Vec<f64>, String> {
        let len = self.usize()?;
        if len > self.bytes.len() / 8 {
            return Err(format!("task snapshot: a list of {len} numbers does not fit"));
        }
        (0..len).map(|_| self.f64()).collect()
    }

    /// Reads a count that must be `expected`; `what` is for the error.
    pub fn expect(&mut self, what: &str, expected: usize) -> Result<(), String> {
        let found = self.usize()?;
        if found == expected {
            Ok(())
        } else {
            Err(format!("task snapshot: {what}: expected {expected}, found {found}"))
        }
    }
}
