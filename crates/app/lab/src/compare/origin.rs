//! What a training run started from, kept next to its runs: another policy or other clips under the same names are not accepted.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use paid_eval::EvalError;
use paid_files::{FileError, write_whole};

use super::print::{print_of_clips, print_of_policy};

/// Name of the file.
const ORIGIN_FILE: &str = "origin.txt";

/// Hashes of the policy and of the clips that a training run starts from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Origin(String);

impl Origin {
    /// `from` is a policy, and `clips` a folder of motions; an empty path stands for the built-in kicks.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn of(from: Option<&Path>, clips: &Path) -> Result<Self, EvalError> {
        let mut text = String::new();
        if let Some(path) = from {
            // Writing to a string cannot fail.
            let _ = write!(text, "from {}, ", print_of_policy(path)?);
        }
        text.push_str(&print_of_clips(clips)?);
        Ok(Self(text))
    }

    /// Refuses a folder whose runs began with something else. One without the file is taken: its runs were carried here.
    ///
    /// # Errors
    /// If they did, or the file cannot be read.
    pub fn refuse_another(&self, folder: &Path) -> Result<(), EvalError> {
        let file = folder.join(ORIGIN_FILE);
        let found = match fs::read_to_string(&file) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(()),
            Err(source) => return Err(FileError { path: file, source }.into()),
        };
        if found.trim_end() == self.0 {
            return Ok(());
        }
        Err(EvalError::Origin { path: file, expected: self.0.clone(), found: found.trim_end().to_owned() })
    }

    /// Keeps it in a folder, which is made if it is missing.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn keep(&self, folder: &Path) -> Result<(), EvalError> {
        Ok(write_whole(&folder.join(ORIGIN_FILE), format!("{}\n", self.0).as_bytes())?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_that_began_with_another_policy_or_other_clips_are_refused() {
        let folder = tempfile::tempdir().expect("folder");
        let write = |name: &str, text: &str| {
            let path = folder.path().join(name);
            write_whole(&path, text.as_bytes()).expect("writes");
            path
        };
        let (policy, out) = (write("policy.safetensors", "weights"), folder.path().join("out"));
        write("clips/a.csv", "1");
        let clips = folder.path().join("clips");
        let origin = || Origin::of(Some(&policy), &clips).expect("reads");
        let first = origin();
        assert!(first.refuse_another(&out).is_ok(), "nothing is there");
        first.keep(&out).expect("kept");
        assert!(first.refuse_another(&out).is_ok());

        write("policy.safetensors", "weightt");
        let error = origin().refuse_another(&out).expect_err("another policy").to_string();
        assert!(error.contains("origin.txt: expected runs of the origin 'from "), "{error}");
        assert!(error.ends_with(&format!("found '{}'; use another --out", first.0)), "{error}");
        write("policy.safetensors", "weights");
        write("clips/a.csv", "2");
        assert!(origin().refuse_another(&out).is_err(), "other clips");
        let none = Origin::of(None, Path::new("")).expect("nothing to read");
        assert_eq!(none.0, "the built-in kicks");
    }
}
