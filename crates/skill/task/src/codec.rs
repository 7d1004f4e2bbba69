//! Snapshots as bytes: a version, then values as `postcard` writes them. Floats keep every bit.

use serde::Serialize;
use serde::de::DeserializeOwned;

/// `bytes` followed by `value`.
pub(crate) fn append<T: Serialize>(bytes: Vec<u8>, value: &T) -> Vec<u8> {
    postcard::to_extend(value, bytes).expect("plain data has no reason to fail in memory")
}

/// Bytes that are being read.
#[derive(Debug)]
pub(crate) struct Reader<'a> {
    bytes: &'a [u8],
    left: &'a [u8],
}

impl<'a> Reader<'a> {
    /// Reads behind `magic`.
    ///
    /// # Errors
    /// If the bytes begin otherwise: they are something else, or of another version.
    pub(crate) fn new(bytes: &'a [u8], magic: &[u8]) -> Result<Self, String> {
        match bytes.strip_prefix(magic) {
            Some(left) => Ok(Self { bytes, left }),
            None => Err("task snapshot: it does not begin as one of this version of the program should; \
                         train on with the program that wrote it, or begin with its policy (--from)"
                .into()),
        }
    }

    /// The next value.
    ///
    /// # Errors
    /// If the bytes end before it does, or cannot be one.
    pub(crate) fn value<T: DeserializeOwned>(&mut self) -> Result<T, String> {
        let (value, left) = postcard::take_from_bytes(self.left).map_err(|error| match error {
            postcard::Error::DeserializeUnexpectedEnd => {
                format!("task snapshot: it ends after {} bytes, before its data does", self.bytes.len())
            }
            error => {
                let at = self.bytes.len() - self.left.len();
                format!("task snapshot: the data from byte {at} on are damaged: {error}")
            }
        })?;
        self.left = left;
        Ok(value)
    }

    /// Nothing may be left.
    ///
    /// # Errors
    /// If something is.
    pub(crate) fn end(&self) -> Result<(), String> {
        match self.left.len() {
            0 => Ok(()),
            n => Err(format!("task snapshot: {n} bytes are left over")),
        }
    }
}

/// Refuses a number that is not the expected one; `what` is for the error.
pub(crate) fn expect<T: PartialEq + core::fmt::Display>(
    what: &str,
    expected: T,
    found: T,
) -> Result<(), String> {
    if found == expected {
        Ok(())
    } else {
        Err(format!("task snapshot: {what}: expected {expected}, found {found}"))
    }
}

/// Arrays of any length, which serde itself does not write.
pub(crate) mod array {
    use serde::de::{DeserializeOwned, Error};
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub(crate) fn serialize<S: Serializer, T: Serialize, const N: usize>(
        values: &[T; N],
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        values.as_slice().serialize(serializer)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>, T: DeserializeOwned, const N: usize>(
        deserializer: D,
    ) -> Result<[T; N], D::Error> {
        let values = Vec::<T>::deserialize(deserializer)?;
        values
            .try_into()
            .map_err(|v: Vec<T>| D::Error::invalid_length(v.len(), &"as many as there are names"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MAGIC: &[u8] = b"magic\x07";

    #[test]
    fn floats_come_back_bit_for_bit() {
        let values = [0.1, -0.0, f64::NAN, f64::from_bits(0x7ff8_0000_0000_1234), 1e-310, f64::INFINITY];
        let bytes = append(MAGIC.to_vec(), &values.to_vec());
        let mut reader = Reader::new(&bytes, MAGIC).expect("its own");
        let back: Vec<f64> = reader.value().expect("whole");
        reader.end().expect("nothing left");
        assert_eq!(back.iter().map(|x| x.to_bits()).collect::<Vec<_>>(), values.map(f64::to_bits));
    }

    #[test]
    fn damaged_and_foreign_bytes_say_what_is_wrong() {
        let bytes = append(MAGIC.to_vec(), &vec![1.5_f64; 4]);
        let error = |bytes: &[u8]| -> String {
            let mut reader = match Reader::new(bytes, MAGIC) {
                Ok(reader) => reader,
                Err(error) => return error,
            };
            reader.value::<Vec<f64>>().and_then(|_| reader.end()).expect_err("not whole")
        };
        assert!(error(b"magic\x06").contains("does not begin"));
        assert!(error(&bytes[..bytes.len() - 3]).contains("it ends after 36 bytes"), "{}", bytes.len());
        assert!(error(&[&bytes[..], &[0]].concat()).contains("1 bytes are left over"));
        // A length that no memory holds.
        assert!(error(&[MAGIC, &[0xff; 9], &[1]].concat()).contains("it ends after"));
        assert!(error(&[MAGIC, &[0xff; 12]].concat()).contains("from byte 6 on are damaged"));
        assert_eq!(
            expect("lanes", 8, 16).expect_err("differs"),
            "task snapshot: lanes: expected 8, found 16"
        );
    }
}
