//! Products of matrices in bfloat16 with sums in f32.
//!
//! Both operands are rounded to bfloat16 (8 bits of mantissa, nearest even) and packed: [`Rows`] for the left one, [`Panels`] for
//! the right one. [`Kernel::multiply`] then adds products pair by pair along the inner dimension. [`Kernel::avx512`] and
//! [`Kernel::PORTABLE`] give equal bits; [`Kernel::amx`] adds in another order.

#[cfg(target_arch = "x86_64")]
mod amx;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod choice;
mod kernel;
mod panels;
mod portable;
mod round;
mod rows;

pub use choice::{Precision, Speed, speeds};
pub use kernel::Kernel;
pub use panels::Panels;
pub use round::{round, widen};
pub use rows::Rows;

/// Columns of a panel: three 512-bit vectors of sums.
pub(crate) const PANEL: usize = 48;
/// Rows are padded with zeros to a multiple of this, the height of an AMX tile.
pub(crate) const ROW_STEP: usize = 16;
/// The inner dimension is padded with zeros to a multiple of this many pairs, the depth of an AMX tile.
pub(crate) const PAIR_STEP: usize = 16;

/// Packed operands of one product, kept so that products need not allocate them.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    /// The left operand.
    pub rows: Rows,
    /// The right operand.
    pub panels: Panels,
}
