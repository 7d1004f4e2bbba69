//! Several results at once: all of them or none.

use std::fs;
use std::path::{Path, PathBuf};

use paid_eval::file::write_whole;

use crate::failure::Failure;

/// Files to be written together.
#[derive(Default)]
pub struct Files(Vec<(PathBuf, Vec<u8>)>);

impl Files {
    /// Adds a file.
    pub fn add(&mut self, path: PathBuf, bytes: Vec<u8>) {
        self.0.push((path, bytes));
    }

    /// Writes all files under temporary names, then gives them their own: what fails leaves the earlier files whole.
    pub fn write(self) -> Result<Vec<PathBuf>, Failure> {
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
            let taken = path.is_dir().then(|| format!("{}: expected a file, found a folder", path.display()));
            let written = taken.map_or_else(
                || write_whole(&aside(path), bytes).map_err(|e| e.to_string().replacen(".new", "", 1)),
                Err,
            );
            if let Err(message) = written {
                clean(&self.0[..=i]);
                return Err(Failure::input(message));
            }
        }
        for (path, _) in &self.0 {
            if let Err(e) = fs::rename(aside(path), path) {
                clean(&self.0);
                return Err(Failure::input(format!("{}: {e}", path.display())));
            }
        }
        Ok(self.0.into_iter().map(|(path, _)| path).collect())
    }
}
