//! SIMD lanes: one numeric source for `f64` and N-lane `f32`.
//!
//! A simulation environment occupies one lane. Code is written once over [`Real`] and instantiated for
//! AVX-512 (16 lanes), AVX2 (8 lanes), a portable array (8 lanes) and scalar `f64` (validation, MuJoCo).
//! [`Isa::detect`] chooses at run time; [`Real::run`] enters a [`Kernel`] with the instruction set enabled.
//!
//! Kernels are fast only if everything below their `run` carries `#[inline(always)]` and uses plain loops:
//! closures and `array::map` may stay outlined without the CPU feature and cost a factor of two.
//! `benches/outlined.sh` lists what a release build has of them.
//!
//! ```
//! use paid_lanes::{F32Array, Real};
//!
//! /// Height of a thrown body after `t`, in every lane type.
//! fn height<V: Real>(speed: V, t: V) -> V {
//!     (V::c(-0.5 * 9.81) * t).mul_add(t, speed * t) // `[m]`
//! }
//!
//! let one = height(3.0_f64, 0.2);
//! let eight = height(F32Array([3.0; 8]), F32Array::c(0.2));
//! assert!((one - f64::from(eight.0[7])).abs() < 1e-6);
//! ```

mod array;
#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod convert;
mod dispatch;
mod functions;
pub mod math;
mod ops;
mod per_lane;
mod real;
pub mod rng;
mod scalar;
pub mod stats;

pub use array::F32Array;
#[cfg(target_arch = "x86_64")]
pub use avx2::F32x8;
#[cfg(target_arch = "x86_64")]
pub use avx512::F32x16;
pub use convert::{load_f32, store_f32};
pub use dispatch::{Isa, IsaError, IsaVisitor};
pub use math::{Mat3, Quat, Vec3};
pub use per_lane::{LaneTable, PerLane};
pub use real::{Kernel, MAX_LANES, Mask, Real, Scalar};
