//! Networks, PPO, normaliser, checkpoints, ONNX.
//!
//! Batches are *feature-major*: element (feature `f`, environment `e`) of an `[F, N]` matrix is at `f * N + e`, so that SIMD
//! lanes (environments) are contiguous from the physics to the matrix products.

pub mod env;

pub use env::{StepBuffers, VecEnv};
