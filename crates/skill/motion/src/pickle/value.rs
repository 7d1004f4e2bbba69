//! The objects of a pickle.

/// Index of an object of the [`Machine`].
pub(crate) type Id = usize;

/// Type of the numbers of an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Kind {
    /// numpy's letter: f, i, u or b.
    pub letter: u8,
    /// Bytes.
    pub size: usize,
    pub big_endian: bool,
}

/// An object.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value {
    None,
    Int(i64),
    Float(f64),
    Text(String),
    Bytes(Vec<u8>),
    List(Vec<Id>),
    Dict(Vec<(Id, Id)>),
    Tuple(Vec<Id>),
    /// A built-in function or class.
    Function(Function),
    Kind(Kind),
    /// Shape, type, Fortran order, bytes; empty until it is built.
    Array(Vec<usize>, Option<(Kind, bool, Id)>),
}

/// What may be called.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Function {
    Reconstruct,
    Scalar,
    FromBuffer,
    NdArray,
    DType,
    Encode,
}

/// The built-in function of that name.
pub(crate) fn function(module: &str, name: &str) -> Option<Function> {
    match (module, name) {
        ("numpy.core.multiarray" | "numpy._core.multiarray", "_reconstruct") => Some(Function::Reconstruct),
        ("numpy.core.multiarray" | "numpy._core.multiarray", "scalar") => Some(Function::Scalar),
        ("numpy.core.numeric" | "numpy._core.numeric", "_frombuffer") => Some(Function::FromBuffer),
        ("numpy", "ndarray") => Some(Function::NdArray),
        ("numpy", "dtype") => Some(Function::DType),
        ("_codecs", "encode") => Some(Function::Encode),
        _ => None,
    }
}

impl Kind {
    /// The numbers that bytes of this type stand for.
    pub fn numbers(self, bytes: &[u8]) -> Vec<f64> {
        let number = |chunk: &[u8]| {
            let mut all = [0u8; 8];
            all[..self.size].copy_from_slice(chunk);
            if self.big_endian {
                all[..self.size].reverse();
            }
            let unsigned = u64::from_le_bytes(all);
            let shift = 64 - 8 * self.size as u32;
            match (self.letter, self.size) {
                (b'f', 4) => f64::from(f32::from_bits(unsigned as u32)),
                (b'f', _) => f64::from_bits(unsigned),
                (b'i', _) => ((unsigned << shift) as i64 >> shift) as f64,
                _ => unsigned as f64,
            }
        };
        bytes.chunks_exact(self.size).map(number).collect()
    }
}

impl Value {
    pub fn name(&self) -> &'static str {
        match self {
            Self::None => "None",
            Self::Int(_) | Self::Float(_) => "a number",
            Self::Text(_) => "a text",
            Self::Bytes(_) => "bytes",
            Self::List(_) => "a list",
            Self::Dict(_) => "a dictionary",
            Self::Tuple(_) => "a tuple",
            Self::Function(_) => "a function",
            Self::Kind(_) => "a numpy type",
            Self::Array(..) => "a numpy array",
        }
    }
}
