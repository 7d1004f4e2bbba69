//! Results on disk: whole or not at all.

use std::fs;
use std::path::Path;

use crate::EvalError;

/// Writes a file whole or not at all ([`paid_files::write_atomically`]); makes the folder if it is missing.
///
/// # Errors
/// If the file cannot be written; an earlier file of that name is then untouched.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), EvalError> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty());
    folder
        .map_or(Ok(()), fs::create_dir_all)
        .and_then(|()| paid_files::write_atomically(path, bytes))
        .map_err(|source| EvalError::Write { path: path.to_owned(), source })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_cannot_be_written_leaves_no_part_and_names_itself() {
        let dir = tempfile::tempdir().expect("a temporary folder");
        let good = dir.path().join("deep/er/a.txt");
        write_whole(&good, b"one").expect("writes");
        write_whole(&good, b"two").expect("replaces");
        assert_eq!(fs::read(&good).expect("reads"), b"two");
        // A folder stands where the file should go.
        let taken = dir.path().join("deep");
        let error = write_whole(&taken, b"three").expect_err("a folder is in the way").to_string();
        assert!(error.contains("deep"), "{error}");
        assert_eq!(fs::read_dir(dir.path()).expect("reads").count(), 1);
    }
}
