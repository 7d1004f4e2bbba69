//! Identification of the ball's contact with the ground (paper, appendix "Details of contact dynamic identification").
//!
//! A ball is dropped and rolled before a camera; [`csv`] reads what was seen, [`trial`] turns it into experiments with initial
//! conditions, [`lab`] repeats them in the batched engine, one ball per SIMD lane, [`search`] adjusts five parameters by
//! [`cmaes`] until both agree, [`confidence`] says which of the five the experiments have seen at all. [`simulate`] makes
//! measurements where the truth is known.
//!
//! ```
//! use paid_lanes::Isa;
//! use paid_physics::SceneConfig;
//! use paid_sysid::Surface;
//! use paid_sysid::lab::{Launch, Start, engine_lab};
//!
//! // How far does the paper's ball roll on grass within a second, at 2 m/s?
//! let ball = Surface::load("grass")?.ball_params;
//! let mut lab = engine_lab(Isa::detect(), &SceneConfig::default())?;
//! let start = Start::Roll { speed: 2.0, offset_m: 0.0, spin: 1.0 };
//! let distance = lab.run(&[Launch { ball, start, times: &[0.0, 1.0] }])[0][1]; // `[m]`
//! assert!((0.5..2.0).contains(&distance));
//! # Ok::<(), paid_sysid::SysidError>(())
//! ```

pub mod cmaes;
pub mod confidence;
pub mod csv;
mod error;
pub mod identify;
pub mod lab;
pub mod options;
pub mod plausible;
pub mod search;
pub mod simulate;
mod stand_in;
pub mod surface;
mod symmetric;
pub mod table;
pub mod trial;

pub use error::SysidError;
pub use identify::{Identification, identify};
pub use options::{Options, Repeats};
pub use surface::Surface;
