//! All motions of a folder.

use std::fs;
use std::path::{Path, PathBuf};

use paid_robot::{RobotModel, RobotSpec};

use crate::format::has_extension;
use crate::generate::{Look, generate_builtin};
use crate::{Clip, EXTENSIONS, MotionError, ReadOptions, read_clip, read_motion, resample};

/// Clips at one frame rate, in the order of their paths.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionLibrary {
    /// At least one clip.
    pub clips: Vec<Clip>,
}

impl MotionLibrary {
    /// The motions of `dir`, or, if `dir` is the empty path, the built-in ones: what every command does that takes motions.
    ///
    /// # Errors
    /// As [`MotionLibrary::load`] and [`MotionLibrary::builtin`].
    pub fn open(
        dir: &Path,
        model: &RobotModel,
        spec: &RobotSpec,
        control_rate_hz: f64,
    ) -> Result<Self, MotionError> {
        if dir.as_os_str().is_empty() {
            Self::builtin(model, spec, control_rate_hz)
        } else {
            Self::load(dir, model, spec, control_rate_hz)
        }
    }

    /// The kicks that the program makes by itself ([`crate::generate`]): ten standard and three powerful ones.
    ///
    /// # Errors
    /// A robot that the generator does not understand, a bad rate.
    pub fn builtin(model: &RobotModel, spec: &RobotSpec, control_rate_hz: f64) -> Result<Self, MotionError> {
        check_rate(control_rate_hz)?;
        let clips = generate_builtin(model, spec, Look::default())?
            .into_iter()
            .map(|kick| at_rate(kick.clip, model, control_rate_hz))
            .collect();
        Ok(Self { clips })
    }

    /// Reads every motion file below `dir` in sorted order ([`motion_files`]), checks every key, permutes to model order by name, and
    /// resamples what is not at `control_rate_hz`.
    ///
    /// # Errors
    /// The first problem found, naming the file, the key, what was expected and what was found.
    pub fn load(
        dir: &Path,
        model: &RobotModel,
        spec: &RobotSpec,
        control_rate_hz: f64,
    ) -> Result<Self, MotionError> {
        check_rate(control_rate_hz)?;
        let mut library = Self::load_unchanged(dir, model, spec)?;
        library.clips = library.clips.into_iter().map(|c| at_rate(c, model, control_rate_hz)).collect();
        Ok(library)
    }

    /// As [`MotionLibrary::load`], each clip at its file's own frame rate.
    ///
    /// # Errors
    /// As [`MotionLibrary::load`].
    pub fn load_unchanged(dir: &Path, model: &RobotModel, spec: &RobotSpec) -> Result<Self, MotionError> {
        let paths = motion_files(dir)?;
        let read = |path: &PathBuf| {
            if has_extension(path, "npz") {
                // These state the leg that kicks; elsewhere the faster foot decides.
                read_clip(path, model, spec)
            } else {
                read_motion(path, model, spec, &ReadOptions::default())
            }
        };
        let clips = paths.iter().map(read).collect::<Result<_, MotionError>>()?;
        Ok(Self { clips })
    }

    /// Frames of the longest clip.
    pub fn longest(&self) -> usize {
        self.clips.iter().map(|c| c.frames).max().unwrap_or(0)
    }
}

/// The motion files ([`EXTENSIONS`]) below the folder `dir` in sorted order; `dir` itself if it is such a file.
///
/// # Errors
/// A folder that cannot be read or has none.
pub fn motion_files(dir: &Path) -> Result<Vec<PathBuf>, MotionError> {
    let mut paths = Vec::new();
    if dir.is_file() && is_motion(dir) {
        paths.push(dir.to_owned());
    } else {
        collect(dir, &mut paths)?;
    }
    paths.sort();
    if paths.is_empty() {
        return Err(MotionError::Empty { path: dir.to_owned() });
    }
    Ok(paths)
}

fn is_motion(path: &Path) -> bool {
    EXTENSIONS.iter().any(|e| has_extension(path, e))
}

fn check_rate(control_rate_hz: f64) -> Result<(), MotionError> {
    let good = control_rate_hz.is_finite() && control_rate_hz > 0.0;
    if good { Ok(()) } else { Err(MotionError::Rate(control_rate_hz)) }
}

fn at_rate(clip: Clip, model: &RobotModel, rate_hz: f64) -> Clip {
    let same = (clip.fps - rate_hz).abs() < 1e-9 * rate_hz;
    if same { clip } else { resample(&clip, model, rate_hz) }
}

fn collect(dir: &Path, paths: &mut Vec<PathBuf>) -> Result<(), MotionError> {
    let io = |source| MotionError::Io { path: dir.to_owned(), source };
    for entry in fs::read_dir(dir).map_err(io)? {
        let entry = entry.map_err(io)?;
        let path = entry.path();
        // The type of the entry itself: a link to a folder is not followed, so a loop cannot trap us.
        if entry.file_type().map_err(io)?.is_dir() {
            collect(&path, paths)?;
        } else if is_motion(&path) {
            paths.push(path);
        }
    }
    Ok(())
}
