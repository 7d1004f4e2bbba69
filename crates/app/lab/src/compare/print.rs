//! Which policy and which clips scores are of: a print of their contents.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use paid_eval::EvalError;
use paid_eval::subject::PolicySource;
use paid_motion::motion_files;
use paid_play::POLICY_FILE;
use paid_train::folder::latest_checkpoint;

use super::contender::Contender;

/// Hash of contents (FNV-1a, 64 bits) that should be equal: a difference is an accident, not an attack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Print(u64);

impl std::fmt::Display for Print {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:016x}", self.0)
    }
}

impl Print {
    const EMPTY: Self = Self(0xcbf2_9ce4_8422_2325);

    /// With these bytes after the others.
    fn with(self, bytes: &[u8]) -> Self {
        Self(bytes.iter().fold(self.0, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3)))
    }

    /// With the contents of a file after the others, and their length.
    fn with_file(self, path: &Path) -> Result<Self, EvalError> {
        let bytes = fs::read(path).map_err(paid_files::FileError::at(path))?;
        Ok(self.with(&(bytes.len() as u64).to_le_bytes()).with(&bytes))
    }
}

impl Contender {
    /// The motions that its shots are made with: its clip's, `asked`, or those of its training. `None`: the policy's own, or the built-in kicks.
    pub fn motions(&self, asked: Option<&Path>) -> Option<PathBuf> {
        let trained = self.stages.last().map(|stage| stage.run.motions.as_str());
        let trained = trained.filter(|motions| !motions.is_empty()).map(Path::new);
        self.clip.as_deref().or(asked).or(trained).map(Path::to_owned)
    }

    /// What its scores depend on, as text: the contents of the policy that it is or starts from, names and contents of the clips, and how it is scored.
    /// `asked` is the folder of motions that all are scored with, if there is one.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn print(&self, asked: Option<&Path>) -> Result<String, EvalError> {
        let mut out = String::new();
        for (thing, path) in [("policy", &self.policy), ("from", &self.from)] {
            if let Some(path) = path {
                let _ = write!(out, "{thing} {}, ", print_of_policy(path)?);
            }
        }
        let clips = match (self.motions(asked), &self.policy) {
            (Some(folder), _) => folder,
            // One that cannot be read, or whose motions are not here, is refused before it is scored.
            (None, Some(policy)) => {
                PolicySource::read(policy).and_then(|source| source.motions_here()).unwrap_or_default()
            }
            (None, None) => PathBuf::new(),
        };
        out.push_str(&print_of_clips(&clips)?);
        if self.tracks {
            out.push_str(", follows clips");
        }
        Ok(out)
    }
}

/// Names and contents of the clips in a folder, as text; an empty path stands for the built-in kicks.
pub(super) fn print_of_clips(clips: &Path) -> Result<String, EvalError> {
    if clips.as_os_str().is_empty() {
        return Ok("the built-in kicks".to_owned());
    }
    let files = motion_files(clips)?;
    let mut print = Print::EMPTY;
    for file in &files {
        print = print.with(name_in(file, clips).as_bytes()).with_file(file)?;
    }
    Ok(format!("clips {} {print}", files.len()))
}

/// Of a run folder the newest checkpoint and the policy file, which says how it is played; each where it is.
pub(super) fn print_of_policy(path: &Path) -> Result<Print, EvalError> {
    let file = path.join(POLICY_FILE);
    let mut print = Print::EMPTY;
    match latest_checkpoint(path) {
        Ok(checkpoint) => print = print.with_file(&checkpoint)?,
        Err(_) if file.is_file() => {}
        Err(error) => return Err(error.into()),
    }
    if file.is_file() { print.with_file(&file) } else { Ok(print) }
}

/// The path of a file below a folder, with `/` on every machine; the file's name if it is the folder itself.
fn name_in(file: &Path, folder: &Path) -> String {
    let below = file.strip_prefix(folder).ok().filter(|path| !path.as_os_str().is_empty());
    let below = below.or_else(|| file.file_name().map(Path::new)).unwrap_or(file);
    below.iter().map(|part| part.to_string_lossy()).collect::<Vec<_>>().join("/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_print_is_the_published_hash() {
        // Test vectors of FNV-1a, 64 bits.
        let of = |text: &str| Print::EMPTY.with(text.as_bytes()).0;
        assert_eq!(
            [of(""), of("a"), of("foobar")],
            [0xcbf2_9ce4_8422_2325, 0xaf63_dc4c_8601_ec8c, 0x8594_4171_f739_67e8]
        );
    }

    #[test]
    fn another_policy_other_clips_or_another_judgment_is_told() {
        let folder = tempfile::tempdir().expect("folder");
        let write = |name: &str, text: &str| {
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().expect("a folder")).expect("made");
            fs::write(&path, text).expect("writes");
            path
        };
        write("clips/standard/a.csv", "1");
        write("clips/standard/b.csv", "2");
        let file = write("policy.onnx", "weights");
        let clips = folder.path().join("clips");
        let contender = Contender {
            name: "it".to_owned(),
            paper: None,
            seed: None,
            folder: PathBuf::from("it"),
            stages: Vec::new(),
            from: None,
            policy: Some(file),
            tracks: false,
            clip: None,
        };
        let told = |contender: &Contender| contender.print(Some(&clips)).expect("reads");
        let first = told(&contender);
        assert!(first.starts_with("policy ") && first.contains(", clips 2 "), "{first}");
        let tracks = Contender { tracks: true, ..contender.clone() };
        assert_eq!(told(&tracks), format!("{first}, follows clips"));

        write("policy.onnx", "weightt");
        let other = told(&contender);
        assert_ne!(other, first);
        // The same clips in another folder are the same.
        let moved = folder.path().join("moved");
        fs::rename(&clips, &moved).expect("renamed");
        assert_eq!(contender.print(Some(&moved)).expect("reads"), other);
        write("moved/standard/b.csv", "3");
        let changed = contender.print(Some(&moved)).expect("reads");
        assert_ne!(changed, other);
        fs::rename(moved.join("standard/b.csv"), moved.join("standard/c.csv")).expect("renamed");
        assert_ne!(contender.print(Some(&moved)).expect("reads"), changed);
        let clip = Contender { clip: Some(moved.join("standard/a.csv")), ..contender.clone() };
        assert!(clip.print(Some(&moved)).expect("reads").contains(", clips 1 "));
        assert!(contender.print(None).expect("reads").ends_with("the built-in kicks"));

        let gone = Contender { policy: Some(folder.path().join("moved")), ..contender };
        let error = gone.print(None).expect_err("no policy").to_string();
        assert!(error.contains("moved"), "{error}");
    }
}
