//! The engine against MuJoCo: recorded values, and MuJoCo itself where it is present.
//!
//! One test program, since every one that steps the engine compiles it again.

mod common;
mod golden;
mod live;
