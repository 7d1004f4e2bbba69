//! Identification of the ball's contact with the ground (paper, appendix "Details of contact dynamic identification").
//!
//! A ball is dropped and rolled before a camera; [`csv`] reads what was seen, [`trial`] turns it into experiments with initial
//! conditions, [`lab`] repeats them in the batched engine, one ball per SIMD lane, [`search`] adjusts five parameters by
//! [`cmaes`] until both agree, [`confidence`] says which of the five the experiments have seen at all. [`simulate`] makes
//! measurements where the truth is known.

pub mod cmaes;
pub mod confidence;
pub mod csv;
mod error;
pub mod identify;
pub mod lab;
pub mod options;
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
