//! Where the tests find data that is not part of the project.

use std::path::{Path, PathBuf};

/// The folder of shared data, or nothing if this machine has none. With `CI=true` its absence is a failure.
pub fn shared(test: &str) -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared");
    let folder = std::env::var_os("PAID_SHARED").map_or(beside, PathBuf::from);
    if folder.join("data").is_dir() {
        return Some(folder);
    }
    let ci = std::env::var("CI").is_ok_and(|v| v == "true");
    assert!(!ci, "no shared data at {}", folder.display());
    println!("SKIPPED (needs shared data): {test}");
    None
}
