//! `--rerun` in a program that was built without Rerun: refused before anything runs.

use std::convert::Infallible;

use super::{Footage, Shows};
use crate::failure::Failure;

/// Where a recording goes. There is none without the feature.
#[derive(Debug)]
pub struct Target(Infallible);

impl Target {
    /// # Errors
    /// Always.
    pub fn new(wanted: &str) -> Result<Self, Failure> {
        Err(Failure::input(format!(
            "--rerun {wanted}: this program was built without Rerun; build it with `cargo build --release --features rerun`, or \
             record pictures with --record"
        )))
    }

    /// Never called: there is no target.
    pub fn send(&self, _: &Footage, _: Shows) -> Result<String, Failure> {
        match self.0 {}
    }
}
