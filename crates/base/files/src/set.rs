//! Several results at once: all of them or none.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use crate::{FileError, write_whole};

/// Files to be written together.
#[derive(Clone, Debug, Default)]
pub struct FileSet(Vec<(PathBuf, Vec<u8>)>);

impl FileSet {
    /// Adds a file.
    pub fn add(&mut self, path: PathBuf, bytes: Vec<u8>) {
        self.0.push((path, bytes));
    }

    /// Writes all files under temporary names, then renames them. Returns their paths.
    ///
    /// # Errors
    /// If a file cannot be written; the earlier files of those names are then untouched.
    pub fn write(self) -> Result<Vec<PathBuf>, FileError> {
        let aside = |path: &Path| {
            let mut name = path.as_os_str().to_owned();
            name.push(".new");
            PathBuf::from(name)
        };
        let clean = |files: &[(PathBuf, Vec<u8>)]| {
            for (path, _) in files {
                // Nothing more can be done if the leftover cannot be removed either.
                let _ = fs::remove_file(aside(path));
            }
        };
        for (i, (path, bytes)) in self.0.iter().enumerate() {
            let written = if path.is_dir() {
                Err(FileError { path: path.clone(), source: ErrorKind::IsADirectory.into() })
            } else {
                // The error names the requested file, not the temporary one.
                write_whole(&aside(path), bytes).map_err(|error| FileError { path: path.clone(), ..error })
            };
            if let Err(error) = written {
                clean(&self.0[..=i]);
                return Err(error);
            }
        }
        for (path, _) in &self.0 {
            if let Err(source) = fs::rename(aside(path), path) {
                clean(&self.0);
                return Err(FileError { path: path.clone(), source });
            }
        }
        Ok(self.0.into_iter().map(|(path, _)| path).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_cannot_be_written_leaves_the_others_as_they_were() {
        let folder = tempfile::tempdir().expect("a folder");
        let (good, taken) = (folder.path().join("a.txt"), folder.path().join("taken"));
        fs::write(&good, b"before").expect("writes");
        fs::create_dir(&taken).expect("a folder in the way");
        let mut files = FileSet::default();
        files.add(good.clone(), b"after".to_vec());
        files.add(taken, Vec::new());
        let error = files.clone().write().expect_err("a folder is in the way").to_string();
        assert!(error.contains("taken"), "{error}");
        assert_eq!(fs::read(&good).expect("reads"), b"before");
        assert_eq!(fs::read_dir(folder.path()).expect("lists").count(), 2, "no temporary file is left");
        files.0.pop();
        assert_eq!(files.write().expect("writes"), std::slice::from_ref(&good));
        assert_eq!(fs::read(&good).expect("reads"), b"after");
    }
}
