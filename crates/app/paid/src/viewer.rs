//! `--rerun`: recordings for the viewer Rerun, if the program was built with it.

#[cfg(feature = "rerun")]
pub use paid_eval::footage::Target;
#[cfg(not(feature = "rerun"))]
pub use without::Target;

#[cfg(not(feature = "rerun"))]
mod without {
    use std::convert::Infallible;

    use paid_eval::footage::{Footage, Shows};

    use crate::failure::Failure;

    /// Where a recording goes. There is none without the feature.
    #[derive(Debug)]
    pub struct Target(Infallible);

    impl Target {
        /// Refuses, before anything runs.
        ///
        /// # Errors
        /// Always.
        pub fn new(wanted: &str) -> Result<Self, Failure> {
            Err(Failure::input(format!(
                "--rerun {wanted}: this program was built without Rerun; build it with `cargo build --release --features rerun`, or \
                 record images with --record"
            )))
        }

        /// Never called: there is no target.
        pub fn send(&self, _: &Footage, _: Shows) -> Result<String, Failure> {
            match self.0 {}
        }
    }
}
