//! Files that are no motion, but known: what they are and what to do with them.

use std::path::Path;

use paid_files::{GIT_LFS_POINTER, is_git_lfs_pointer};

use crate::MotionError;

/// A known kind of file.
struct Kind {
    found: &'static str,
    remedy: &'static str,
}

const GIT_LFS: Kind = Kind { found: GIT_LFS_POINTER[0], remedy: GIT_LFS_POINTER[1] };
const JOBLIB: Kind = Kind {
    found: "a pickle that joblib wrote, with its arrays outside of the pickle",
    remedy: "load it in Python with joblib.load and write each clip as a dictionary of fps, root_pos, root_rot and dof_pos with pickle.dump",
};
const COMPRESSED: Kind = Kind {
    found: "a compressed file (as joblib writes with compress=)",
    remedy: "load it in Python and write each clip as a dictionary of fps, root_pos, root_rot and dof_pos with pickle.dump",
};
const SMPL: Kind = Kind {
    found: "an AMASS archive: rotations of an SMPL body (keys poses, trans, betas)",
    remedy: "retarget it with GMR, whose .pkl is read here, or write the body's joint positions as an .npz with the keys positions, \
             joint_names and fps for `paid motion retarget`",
};

impl Kind {
    fn error(&self, path: &Path) -> MotionError {
        MotionError::Foreign { path: path.to_owned(), found: self.found, remedy: self.remedy }
    }
}

/// Refuses a file that Git LFS has left as a pointer, by its first bytes.
///
/// # Errors
/// [`MotionError::Foreign`].
pub fn refuse_git_lfs(path: &Path, head: &[u8]) -> Result<(), MotionError> {
    if is_git_lfs_pointer(head) { Err(GIT_LFS.error(path)) } else { Ok(()) }
}

/// Refuses a known file by its first bytes.
pub(crate) fn refuse_by_head(path: &Path, head: &[u8]) -> Result<(), MotionError> {
    refuse_git_lfs(path, head)?;
    match head {
        [0x78, 0x01 | 0x5e | 0x9c | 0xda, ..] | [0x1f, 0x8b, ..] => Err(COMPRESSED.error(path)),
        _ => Ok(()),
    }
}

/// Refuses a pickle whose arrays lie outside of it.
pub(crate) fn refuse_joblib(path: &Path, bytes: &[u8]) -> Result<(), MotionError> {
    let name = b"joblib.numpy_pickle";
    if bytes.windows(name.len()).any(|window| window == name) { Err(JOBLIB.error(path)) } else { Ok(()) }
}

/// Refuses an archive with the keys of AMASS.
pub(crate) fn refuse_smpl(path: &Path, has: impl Fn(&str) -> bool) -> Result<(), MotionError> {
    if has("poses") && has("trans") { Err(SMPL.error(path)) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_known_file_is_called_what_it_is() {
        let path = Path::new("kick.pkl");
        let said = |result: Result<(), MotionError>| result.expect_err("refused").to_string();
        assert!(
            said(refuse_by_head(path, b"version https://git-lfs.github.com/spec/v1\n"))
                .contains("git lfs pull")
        );
        assert!(said(refuse_by_head(path, &[0x78, 0x5e, 0xed])).contains("compressed"));
        refuse_by_head(path, b"PK\x03\x04").expect("a zip archive");
        assert!(
            said(refuse_joblib(path, b"\x80\x04cjoblib.numpy_pickle\nNumpyArrayWrapper"))
                .contains("joblib.load")
        );
        refuse_joblib(path, b"\x80\x04}.").expect("a plain pickle");
        assert!(said(refuse_smpl(path, |key| ["poses", "trans", "betas"].contains(&key))).contains("AMASS"));
        refuse_smpl(path, |key| key == "poses").expect("something else");
    }
}
