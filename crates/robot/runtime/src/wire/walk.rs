//! A walk over a message's fields, in either layout.

use thiserror::Error;

/// Bytes that are no such message.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{message}: expected {expected} bytes, found {found}")]
pub struct WireError {
    /// Name of the message.
    pub message: &'static str,
    /// Its length.
    pub expected: usize,
    /// What came.
    pub found: usize,
}

/// How fields lie in the bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Layout {
    /// The vendor's C struct.
    C,
    /// Plain CDR, little-endian, without its header of four bytes.
    Cdr,
}

/// Visits fields in order.
pub(crate) trait Walk {
    /// A nested struct begins.
    fn group(&mut self);
    fn bytes<const N: usize>(&mut self, align: usize, value: [u8; N]) -> [u8; N];

    fn u8(&mut self, value: &mut u8) {
        [*value] = self.bytes(1, [*value]);
    }
    fn i16(&mut self, value: &mut i16) {
        *value = i16::from_le_bytes(self.bytes(2, value.to_le_bytes()));
    }
    fn u16(&mut self, value: &mut u16) {
        *value = u16::from_le_bytes(self.bytes(2, value.to_le_bytes()));
    }
    fn i32(&mut self, value: &mut i32) {
        *value = i32::from_le_bytes(self.bytes(4, value.to_le_bytes()));
    }
    fn u32(&mut self, value: &mut u32) {
        *value = u32::from_le_bytes(self.bytes(4, value.to_le_bytes()));
    }
    fn u32s(&mut self, values: &mut [u32]) {
        for value in values {
            self.u32(value);
        }
    }
    fn f32(&mut self, value: &mut f32) {
        *value = f32::from_le_bytes(self.bytes(4, value.to_le_bytes()));
    }
    fn f32s(&mut self, values: &mut [f32]) {
        for value in values {
            self.f32(value);
        }
    }
}

/// No message is longer `[bytes]`: a state in C has 2092.
const LONGEST: usize = 2096;

/// A message's bytes.
#[derive(Clone, Debug)]
pub(crate) struct Packed {
    bytes: [u8; LONGEST],
    length: usize,
}

impl core::ops::Deref for Packed {
    type Target = [u8];
    fn deref(&self) -> &[u8] {
        &self.bytes[..self.length]
    }
}

/// A message.
pub(crate) trait Message: Clone + Default {
    const NAME: &'static str;
    fn walk(&mut self, walk: &mut impl Walk);

    /// The message's bytes, without an allocation: the writer calls it 500 times a second.
    fn packed(&self, layout: Layout) -> Packed {
        let mut put = Put { out: Packed { bytes: [0; LONGEST], length: 0 }, layout };
        self.clone().walk(&mut put);
        put.out
    }

    /// The message's bytes.
    fn to_bytes(&self, layout: Layout) -> Vec<u8> {
        self.packed(layout).to_vec()
    }

    /// The message in `bytes`, which must be as long as it. Up to 3 bytes of padding at the end of a CDR stream are allowed.
    fn from_bytes(bytes: &[u8], layout: Layout) -> Result<Self, WireError> {
        let mut take = Take { bytes, at: 0, layout };
        let mut message = Self::default();
        message.walk(&mut take);
        let (expected, found) = (take.at, bytes.len());
        let padding = if layout == Layout::Cdr { 3 } else { 0 };
        if (expected..=expected + padding).contains(&found) {
            Ok(message)
        } else {
            Err(WireError { message: Self::NAME, expected, found })
        }
    }
}

/// What users call of a message with a checksum `crc` at its end: its two forms, there and back.
macro_rules! forms {
    ($message:ident) => {
        impl $message {
            /// The vendor's C struct.
            pub fn to_c(&self) -> Vec<u8> {
                self.to_bytes($crate::wire::walk::Layout::C)
            }
            /// CDR, little-endian, without the header.
            pub fn to_cdr(&self) -> Vec<u8> {
                self.to_bytes($crate::wire::walk::Layout::Cdr)
            }
            /// From [`Self::to_cdr`]'s bytes; the checksum is not looked at.
            ///
            /// # Errors
            /// If the length is another.
            pub fn from_cdr(bytes: &[u8]) -> Result<Self, $crate::wire::WireError> {
                Self::from_bytes(bytes, $crate::wire::walk::Layout::Cdr)
            }
            /// From the bytes of the C struct; the checksum is not looked at.
            ///
            /// # Errors
            /// If the length is another.
            pub fn from_c(bytes: &[u8]) -> Result<Self, $crate::wire::WireError> {
                Self::from_bytes(bytes, $crate::wire::walk::Layout::C)
            }
            /// The checksum that the message should have.
            pub fn expected_crc(&self) -> u32 {
                $crate::wire::crc32(&self.packed($crate::wire::walk::Layout::C)[..Self::C_SIZE - 4])
            }
            /// With its checksum.
            #[must_use]
            pub fn sealed(mut self) -> Self {
                self.crc = self.expected_crc();
                self
            }
        }
    };
}
pub(crate) use forms;

struct Put {
    out: Packed,
    layout: Layout,
}

impl Walk for Put {
    fn group(&mut self) {
        if self.layout == Layout::C {
            self.out.length = self.out.length.next_multiple_of(4);
        }
    }
    fn bytes<const N: usize>(&mut self, align: usize, value: [u8; N]) -> [u8; N] {
        let from = self.out.length.next_multiple_of(align);
        self.out.length = from + N;
        self.out.bytes[from..from + N].copy_from_slice(&value);
        value
    }
}

/// Reads on beyond the end, where everything keeps its value, so that the length comes out.
struct Take<'a> {
    bytes: &'a [u8],
    at: usize,
    layout: Layout,
}

impl Walk for Take<'_> {
    fn group(&mut self) {
        if self.layout == Layout::C {
            self.at = self.at.next_multiple_of(4);
        }
    }
    fn bytes<const N: usize>(&mut self, align: usize, value: [u8; N]) -> [u8; N] {
        let from = self.at.next_multiple_of(align);
        self.at = from + N;
        self.bytes.get(from..self.at).and_then(|found| found.try_into().ok()).unwrap_or(value)
    }
}
