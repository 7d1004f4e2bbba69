//! What tests share: skips that are seen, and damaged files ([`damaged`]). A dev-dependency only.
//!
//! Some tests need what the repository may not hold: recorded motions, other people's policies, the MuJoCo library.
//! Where it is missing, such a test returns early, and the test harness counts it as passed. So each skip is written past
//! the harness's capture to standard error, and appended to the file that `PAID_SKIP_LOG` names; `.ci/run` prints that
//! file at its end.
//!
//! With `CI=true` a skip is a failure, unless `PAID_ALLOW_SKIPS=1`.
//!
//! ```
//! # fn a_motion_is_read() {
//! let Some(motions) = paid_testing::shared_data("a_motion_is_read", "data/motions/paid") else { return };
//! assert!(motions.exists());
//! # }
//! ```

mod mutate;

use std::fmt::Display;
use std::fs::OpenOptions;
use std::io::Write;
use std::path::{Path, PathBuf};

pub use mutate::damaged;

/// The file or folder `path` of the shared data, or `None` (the test is skipped) if this machine does not have it.
///
/// The data lie in the folder `PAID_SHARED`, by default in `shared` next to the checkout.
///
/// # Panics
/// If it is missing where skips are failures.
#[must_use]
pub fn shared_data(test: &str, path: &str) -> Option<PathBuf> {
    Settings::from_env().shared_data(test, path, &mut std::io::stderr())
}

/// MuJoCo, as `found` by the caller, or `None` (the test is skipped) if it is missing.
///
/// # Panics
/// If it is missing where skips are failures.
#[must_use]
pub fn mujoco<T, E: Display>(test: &str, found: Result<T, E>) -> Option<T> {
    found.map_err(|error| skipped(test, &format!("MuJoCo: {error}"))).ok()
}

/// Records that `test`, or a part of it, does not run because it needs `reason`.
///
/// # Panics
/// Where skips are failures, or if the file that `PAID_SKIP_LOG` names cannot be written.
pub fn skipped(test: &str, reason: &str) {
    // Not `eprintln!`, which the test harness captures.
    Settings::from_env().skipped(test, reason, &mut std::io::stderr());
}

/// Records that `test` does not run because the machine lacks `program`, which no package of Cargo or pip brings, such as a browser. A
/// skip that is seen, and never a failure.
///
/// # Panics
/// If the file that `PAID_SKIP_LOG` names cannot be written.
pub fn without_program(test: &str, program: &str) {
    Settings { skips_fail: false, ..Settings::from_env() }.skipped(test, program, &mut std::io::stderr());
}

/// Data and skips, by the environment's variables.
struct Settings {
    shared: PathBuf,
    log: Option<PathBuf>,
    skips_fail: bool,
    /// The crate under test, as Cargo names it to the test program.
    package: String,
}

impl Settings {
    fn from_env() -> Self {
        let is = |name: &str, value: &str| std::env::var_os(name).is_some_and(|v| v == value);
        // An empty variable is none.
        let path = |name: &str| std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
        let sibling = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../../shared");
        Self {
            shared: path("PAID_SHARED").unwrap_or(sibling),
            log: path("PAID_SKIP_LOG"),
            skips_fail: is("CI", "true") && !is("PAID_ALLOW_SKIPS", "1"),
            package: std::env::var("CARGO_PKG_NAME").unwrap_or_default(),
        }
    }

    fn shared_data(&self, test: &str, path: &str, out: &mut impl Write) -> Option<PathBuf> {
        let full = self.shared.join(path);
        if full.exists() {
            return Some(full);
        }
        self.skipped(test, &format!("shared data: {path}"), out);
        None
    }

    fn skipped(&self, test: &str, reason: &str, out: &mut impl Write) {
        let Self { package, .. } = self;
        assert!(!self.skips_fail, "{package} {test} needs {reason} (PAID_ALLOW_SKIPS=1 allows skips)");
        let line = format!("{package} {test}: needs {reason}\n");
        // Nothing is lost if standard error is closed.
        let _ = out.write_all(format!("SKIPPED {line}").as_bytes());
        if let Some(log) = &self.log {
            // One write to a file opened for appending: lines of parallel tests do not mix.
            let file = OpenOptions::new().create(true).append(true).open(log);
            let written = file.and_then(|mut file| file.write_all(line.as_bytes()));
            written.unwrap_or_else(|error| panic!("PAID_SKIP_LOG={}: {error}", log.display()));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings(folder: &Path, skips_fail: bool) -> Settings {
        Settings {
            shared: folder.join("shared"),
            log: Some(folder.join("skips")),
            skips_fail,
            package: "crate".to_owned(),
        }
    }

    #[test]
    fn each_skip_is_shown_and_is_a_line_of_the_log() {
        let folder = tempfile::tempdir().expect("a folder");
        let (settings, mut shown) = (settings(folder.path(), false), Vec::new());
        assert_eq!(settings.shared_data("one", "data/a.npz", &mut shown), None);
        settings.skipped("two", "a camera", &mut shown);
        let log = std::fs::read_to_string(folder.path().join("skips")).expect("a log");
        assert_eq!(log, "crate one: needs shared data: data/a.npz\ncrate two: needs a camera\n");
        assert!(shown.starts_with(b"SKIPPED crate one: "));
    }

    #[test]
    fn data_that_are_there_are_found_and_nothing_is_logged() {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::create_dir_all(folder.path().join("shared/data")).expect("a folder");
        let found = settings(folder.path(), true).shared_data("one", "data", &mut Vec::new());
        assert_eq!(found, Some(folder.path().join("shared/data")));
        assert!(!folder.path().join("skips").exists());
    }

    #[test]
    #[should_panic(expected = "crate one needs shared data: data")]
    fn where_skips_fail_missing_data_is_a_failure() {
        let folder = tempfile::tempdir().expect("a folder");
        let _ = settings(folder.path(), true).shared_data("one", "data", &mut Vec::new());
    }

    #[test]
    fn what_was_found_is_handed_on() {
        assert_eq!(mujoco("one", Ok::<_, String>(3)), Some(3));
    }
}
