//! Arrays in a zip archive: reading with checks, and nothing about motions.

use std::fs::File;
use std::io::{BufRead, BufReader, Cursor, Read, Seek};
use std::path::{Path, PathBuf};

use npyz::{DType, Deserialize, NpyFile, Order, TypeChar};
use zip::ZipArchive;

use crate::MotionError;
use crate::foreign::refuse_by_head;

/// An array of more bytes than this is no motion [bytes]: an hour of a humanoid at 50 Hz is a tenth of it.
const LARGEST_ENTRY: u64 = 1 << 30;

/// Where an archive comes from.
trait Source: Read + Seek {}
impl<T: Read + Seek> Source for T {}

/// An opened archive.
pub(crate) struct Npz {
    path: PathBuf,
    archive: ZipArchive<Box<dyn Source>>,
}

/// A numeric array of any float or integer type, as `f64`, row-major.
pub(crate) struct Numbers {
    pub shape: Vec<usize>,
    pub values: Vec<f64>,
}

impl Npz {
    pub fn open(path: &Path) -> Result<Self, MotionError> {
        let file = File::open(path).map_err(|source| MotionError::Io { path: path.to_owned(), source })?;
        let mut reader = BufReader::new(file);
        let head = reader.fill_buf().map_err(|source| MotionError::Io { path: path.to_owned(), source })?;
        refuse_by_head(path, head)?;
        Self::new(path, Box::new(reader))
    }

    /// From the bytes of a file; `path` names it.
    pub fn from_bytes(path: &Path, bytes: Vec<u8>) -> Result<Self, MotionError> {
        Self::new(path, Box::new(Cursor::new(bytes)))
    }

    fn new(path: &Path, source: Box<dyn Source>) -> Result<Self, MotionError> {
        let archive = ZipArchive::new(source)
            .map_err(|e| MotionError::Archive { path: path.to_owned(), problem: e.to_string() })?;
        Ok(Self { path: path.to_owned(), archive })
    }

    pub fn has(&self, key: &str) -> bool {
        self.archive.index_for_name(&format!("{key}.npy")).is_some()
    }

    /// The error that `key` is not as expected.
    pub fn error(
        &self,
        key: &'static str,
        expected: impl Into<String>,
        found: impl Into<String>,
    ) -> MotionError {
        MotionError::Key { path: self.path.clone(), key, expected: expected.into(), found: found.into() }
    }

    fn keys(&self) -> String {
        let mut keys: Vec<String> = self
            .archive
            .file_names_raw()
            .map(|name| String::from_utf8_lossy(name).trim_end_matches(".npy").to_owned())
            .collect();
        keys.sort();
        if keys.is_empty() { "no key".to_owned() } else { keys.join(", ") }
    }

    /// A numeric array of any shape.
    pub fn numbers(&mut self, key: &'static str) -> Result<Numbers, MotionError> {
        let bytes = self.bytes(key)?;
        let array = self.array(key, &bytes)?;
        match self.scalar_type(key, &array)? {
            (TypeChar::Float, 4) => self.convert(key, array, |v: f32| f64::from(v)),
            (TypeChar::Float, 8) => self.convert(key, array, |v: f64| v),
            (TypeChar::Int, 4) => self.convert(key, array, |v: i32| f64::from(v)),
            (TypeChar::Int, 8) => self.convert(key, array, |v: i64| v as f64),
            (kind, size) => Err(self.error(
                key,
                "numbers of type f4, f8, i4 or i8",
                format!("type '{}{size}'", kind.to_str()),
            )),
        }
    }

    /// A text array; a single text has one element.
    pub fn texts(&mut self, key: &'static str) -> Result<Vec<String>, MotionError> {
        let bytes = self.bytes(key)?;
        let array = self.array(key, &bytes)?;
        let (kind, size) = self.scalar_type(key, &array)?;
        if kind != TypeChar::UnicodeStr {
            return Err(self.error(key, "text (type 'U')", format!("type '{}{size}'", kind.to_str())));
        }
        array.into_vec().map_err(|e| self.broken(key, e.to_string()))
    }

    fn broken(&self, key: &'static str, found: String) -> MotionError {
        self.error(key, "a whole NPY array", found)
    }

    /// The whole entry: only reading it to its end checks the archive's checksum.
    fn bytes(&mut self, key: &'static str) -> Result<Vec<u8>, MotionError> {
        if !self.has(key) {
            return Err(MotionError::MissingKey { path: self.path.clone(), key, found: self.keys() });
        }
        let mut bytes = Vec::new();
        let read = self.archive.by_name(&format!("{key}.npy")).map_err(|e| e.to_string()).and_then(|entry| {
            entry.take(LARGEST_ENTRY + 1).read_to_end(&mut bytes).map_err(|e| e.to_string())
        });
        match read {
            Err(found) => Err(self.broken(key, found)),
            Ok(n) if n as u64 > LARGEST_ENTRY => {
                Err(self.broken(key, format!("more than {LARGEST_ENTRY} bytes")))
            }
            Ok(_) => Ok(bytes),
        }
    }

    fn array<'b>(&self, key: &'static str, bytes: &'b [u8]) -> Result<NpyFile<&'b [u8]>, MotionError> {
        let array = NpyFile::new(bytes).map_err(|e| self.broken(key, e.to_string()))?;
        // A header that promises more than is stored must not make the reader reserve memory for it: a text of no letters takes memory too.
        let count = array.shape().iter().try_fold(1u64, |n, size| n.checked_mul(*size));
        let size = array.dtype().num_bytes().map(|n| (n as u64).max(1));
        let promised = count.zip(size).and_then(|(count, size)| count.checked_mul(size));
        if promised.is_none_or(|n| n > bytes.len() as u64) {
            return Err(self.broken(key, format!("shape {:?} in {} bytes", array.shape(), bytes.len())));
        }
        Ok(array)
    }

    fn scalar_type(&self, key: &'static str, array: &NpyFile<&[u8]>) -> Result<(TypeChar, u64), MotionError> {
        match array.dtype() {
            DType::Plain(plain) => Ok((plain.type_char(), plain.size_field())),
            other => Err(self.error(key, "a plain type", format!("type {}", other.descr()))),
        }
    }

    fn convert<T: Deserialize>(
        &self,
        key: &'static str,
        array: NpyFile<&[u8]>,
        convert: fn(T) -> f64,
    ) -> Result<Numbers, MotionError> {
        let shape: Vec<usize> = array.shape().iter().map(|&n| n as usize).collect();
        let row_major = array.order() == Order::C;
        let values = array.into_vec::<T>().map_err(|e| self.broken(key, e.to_string()))?;
        let values = values.into_iter().map(convert).collect();
        Ok(Numbers { values: if row_major { values } else { to_row_major(&shape, &values) }, shape })
    }
}

/// The numbers of a column-major array (the first index runs fastest, as in Fortran and MATLAB) in row-major order.
fn to_row_major(shape: &[usize], values: &[f64]) -> Vec<f64> {
    let strides: Vec<usize> = (0..shape.len()).map(|axis| shape[..axis].iter().product()).collect();
    let at = |mut rest: usize| {
        let steps = shape.iter().zip(&strides).rev().map(|(&n, stride)| {
            let index = rest % n;
            rest /= n;
            index * stride
        });
        values[steps.sum::<usize>()]
    };
    (0..values.len()).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_major_array_is_read_by_its_indices() {
        // a[i][j] = 10 i + j, three rows of two.
        assert_eq!(
            to_row_major(&[3, 2], &[0.0, 10.0, 20.0, 1.0, 11.0, 21.0]),
            [0.0, 1.0, 10.0, 11.0, 20.0, 21.0]
        );
        assert_eq!(to_row_major(&[4], &[1.0, 2.0, 3.0, 4.0]), [1.0, 2.0, 3.0, 4.0]);
    }
}
