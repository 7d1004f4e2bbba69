//! The tests of `paid-onnx` as one program: one link instead of one a file. `cargo test -p paid-onnx --test all FILE::` runs a file's.

mod onnx;
mod released;
