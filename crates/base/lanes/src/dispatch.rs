//! Choice of the instruction set at run time.

use core::fmt;
use core::str::FromStr;

use crate::{F32Array, Real};

/// An instruction set that the engine is compiled for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Isa {
    /// 16 lanes, x86-64 with AVX-512 F, DQ, VL.
    Avx512,
    /// 8 lanes, x86-64 with AVX2 and FMA.
    Avx2,
    /// 8 lanes without requirements.
    Portable,
}

/// An instruction set that does not exist or that this CPU lacks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct IsaError(String);

impl fmt::Display for IsaError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}
impl std::error::Error for IsaError {}

/// Something to be done with the lane type of a chosen [`Isa`].
pub trait IsaVisitor {
    /// What it returns.
    type Output;
    /// Does it.
    fn visit<V: Real<Scalar = f32>>(self) -> Self::Output;
}

impl Isa {
    /// The widest instruction set of this CPU.
    pub fn detect() -> Self {
        [Isa::Avx512, Isa::Avx2].into_iter().find(|isa| isa.available()).unwrap_or(Isa::Portable)
    }

    /// True if this CPU can run it.
    pub fn available(self) -> bool {
        match self {
            #[cfg(target_arch = "x86_64")]
            Isa::Avx512 => crate::F32x16::available(),
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2 => crate::F32x8::available(),
            #[cfg(not(target_arch = "x86_64"))]
            Isa::Avx512 | Isa::Avx2 => false,
            Isa::Portable => true,
        }
    }

    /// Lanes of a group.
    pub fn lanes(self) -> usize {
        if self == Isa::Avx512 { 16 } else { 8 }
    }

    /// Calls the visitor with the lane type.
    ///
    /// # Panics
    /// If this CPU lacks the instruction set.
    pub fn dispatch<T: IsaVisitor>(self, visitor: T) -> T::Output {
        assert!(self.available(), "this CPU cannot run {self}");
        match self {
            #[cfg(target_arch = "x86_64")]
            Isa::Avx512 => visitor.visit::<crate::F32x16>(),
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2 => visitor.visit::<crate::F32x8>(),
            #[cfg(not(target_arch = "x86_64"))]
            Isa::Avx512 | Isa::Avx2 => unreachable!("not available"),
            Isa::Portable => visitor.visit::<F32Array<8>>(),
        }
    }
}

impl fmt::Display for Isa {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Isa::Avx512 => "avx512",
            Isa::Avx2 => "avx2",
            Isa::Portable => "portable",
        })
    }
}

impl FromStr for Isa {
    type Err = IsaError;

    /// Accepts `auto`, `avx512`, `avx2`, `portable`; refuses what this CPU lacks.
    fn from_str(name: &str) -> Result<Self, IsaError> {
        let isa = match name {
            "auto" => Isa::detect(),
            "avx512" => Isa::Avx512,
            "avx2" => Isa::Avx2,
            "portable" => Isa::Portable,
            other => {
                return Err(IsaError(format!(
                    "instruction set '{other}': expected auto, avx512, avx2 or portable"
                )));
            }
        };
        if isa.available() {
            Ok(isa)
        } else {
            Err(IsaError(format!("instruction set '{isa}': this CPU lacks it")))
        }
    }
}
