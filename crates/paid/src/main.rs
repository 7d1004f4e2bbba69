//! Command line of PAiD.
fn main() {}
