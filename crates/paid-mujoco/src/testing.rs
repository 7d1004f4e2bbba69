//! For tests that run MuJoCo itself.

use std::io::Write;

use crate::library::Library;

/// The library; without it a visible note that the test was skipped, and under `CI=true` a failure.
///
/// # Panics
/// If MuJoCo is missing and the environment variable `CI` is `true`.
pub fn mujoco_or_skip(test: &str) -> Option<&'static Library> {
    match Library::get() {
        Ok(library) => Some(library),
        Err(error) => {
            let ci = std::env::var("CI").is_ok_and(|v| v == "true");
            assert!(!ci, "{test}: {error}");
            // Written past the capture of the test harness, so that it is seen.
            let _ =
                writeln!(std::io::stderr(), "SKIPPED (needs MuJoCo: run `cargo mujoco`): {test}: {error}");
            None
        }
    }
}
