//! All motions of a folder.

use std::fs;
use std::path::{Path, PathBuf};

use paid_robot::{RobotModel, RobotSpec};

use crate::{Clip, MotionError, read_clip, resample};

/// Clips at one frame rate, in the order of their paths.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionLibrary {
    /// At least one clip.
    pub clips: Vec<Clip>,
}

impl MotionLibrary {
    /// Reads every `*.npz` below `dir` in sorted order, checks every key, permutes to model order by name, and
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
        if !(control_rate_hz.is_finite() && control_rate_hz > 0.0) {
            return Err(MotionError::Rate(control_rate_hz));
        }
        let mut paths = Vec::new();
        collect(dir, &mut paths)?;
        paths.sort();
        if paths.is_empty() {
            return Err(MotionError::Empty { path: dir.to_owned() });
        }
        let clips = paths
            .iter()
            .map(|path| {
                let clip = read_clip(path, model, spec)?;
                let same = (clip.fps - control_rate_hz).abs() < 1e-9 * control_rate_hz;
                Ok(if same { clip } else { resample(&clip, model, control_rate_hz) })
            })
            .collect::<Result<_, MotionError>>()?;
        Ok(Self { clips })
    }

    /// Frames of the longest clip.
    pub fn longest(&self) -> usize {
        self.clips.iter().map(|c| c.frames).max().unwrap_or(0)
    }
}

fn collect(dir: &Path, paths: &mut Vec<PathBuf>) -> Result<(), MotionError> {
    let io = |source| MotionError::Io { path: dir.to_owned(), source };
    for entry in fs::read_dir(dir).map_err(io)? {
        let entry = entry.map_err(io)?;
        let path = entry.path();
        // The type of the entry itself: a link to a folder is not followed, so a loop cannot trap us.
        if entry.file_type().map_err(io)?.is_dir() {
            collect(&path, paths)?;
        } else if path.extension().is_some_and(|e| e == "npz") {
            paths.push(path);
        }
    }
    Ok(())
}
