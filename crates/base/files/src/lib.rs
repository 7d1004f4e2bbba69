//! The one writer of files: a file appears whole under its name or not at all; [`FileSet`]: all of several files or none. And what all
//! readers say of a file that they cannot read ([`GIT_LFS_POINTER`], [`compressed_chunks`]).
//!
//! ```
//! # fn main() -> std::io::Result<()> {
//! let folder = tempfile::tempdir()?;
//! let path = folder.path().join("score.json");
//! paid_files::write_atomically(&path, b"{}")?;
//! assert_eq!(std::fs::read(&path)?, b"{}");
//! # Ok(())
//! # }
//! ```

mod foreign;
mod set;

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use thiserror::Error;

pub use foreign::{GIT_LFS_POINTER, compressed_chunks, is_git_lfs_pointer};
pub use set::FileSet;

/// A file or folder that the system does not read or write.
#[derive(Debug, Error)]
#[error("{path}: {source}")]
pub struct FileError {
    /// The file or folder.
    pub path: PathBuf,
    /// The system's answer.
    pub source: io::Error,
}

impl FileError {
    /// The system's answer about this file or folder.
    pub fn at(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self { path, source }
    }
}

/// Writes a file whole or not at all, as [`write_atomically`]; makes the folder if it is missing.
///
/// # Errors
/// If the file cannot be written; an earlier file of that name is then untouched.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty());
    folder
        .map_or(Ok(()), fs::create_dir_all)
        .and_then(|()| write_atomically(path, bytes))
        .map_err(FileError::at(path))
}

/// Writes to a temporary file next to `path`, flushes it to the disk and renames it.
///
/// # Errors
/// If the file system refuses; the temporary file is removed then and an older file under `path` stays as it was.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> io::Result<()> {
    replace(path, |file| file.write_all(bytes))
}

/// As [`write_atomically`], for files that are written piece by piece: `write` fills the temporary file.
///
/// # Errors
/// If `write` or the file system fails; the temporary file is removed then and an older file under `path` stays as it was.
pub fn replace(path: &Path, write: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut prefix = path.file_name().unwrap_or_default().to_owned();
    prefix.push(".");
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).suffix(".part");
    // Temporary files are private by default; this one becomes an ordinary file, so the umask decides.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut temporary = builder.tempfile_in(folder)?;
    write(temporary.as_file_mut())?;
    temporary.as_file().sync_all()?;
    temporary.persist(path).map_err(|error| error.error)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).expect("a folder");
        entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned()).collect()
    }

    #[test]
    fn a_file_is_replaced_and_nothing_else_stays() {
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("a.txt");
        write_atomically(&path, b"one").expect("writes");
        write_atomically(&path, b"two").expect("replaces");
        assert_eq!(fs::read(&path).expect("reads"), b"two");
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[test]
    fn a_failure_leaves_the_earlier_file_and_no_part() {
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("a.txt");
        write_atomically(&path, b"one").expect("writes");
        let error = replace(&path, |file| {
            file.write_all(b"half")?;
            Err(io::Error::other("the disk is full"))
        });
        assert_eq!(error.expect_err("refused").to_string(), "the disk is full");
        assert_eq!(fs::read(&path).expect("reads"), b"one");
        // A folder stands where the file should go.
        let taken = folder.path().join("taken");
        fs::create_dir(&taken).expect("folder");
        assert!(write_atomically(&taken, b"three").is_err());
        let mut left = names(folder.path());
        left.sort();
        assert_eq!(left, ["a.txt", "taken"]);
        assert!(write_atomically(&folder.path().join("absent/a.txt"), b"four").is_err());
    }

    #[cfg(unix)]
    #[test]
    fn a_written_file_has_the_rights_of_any_other() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().expect("folder");
        let [ours, plain] = ["ours", "plain"].map(|name| folder.path().join(name));
        write_atomically(&ours, b"x").expect("writes");
        fs::write(&plain, b"x").expect("writes");
        let mode = |path: &Path| fs::metadata(path).expect("exists").permissions().mode();
        assert_eq!(mode(&ours), mode(&plain));
    }

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
