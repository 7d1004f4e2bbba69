//! All motions of a folder.

use std::fs;
use std::path::{Path, PathBuf};

use paid_robot::{RobotModel, RobotSpec};

use crate::format::has_extension;
use crate::generate::{Look, generate_builtin};
use crate::implausible::Implausible;
use crate::points::refuse_points;
use crate::{Clip, EXTENSIONS, MotionError, ReadOptions, read_motion, resample};

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
    /// resamples what is not at `control_rate_hz`. Where a file does not state the kicking leg, the faster foot decides. What cannot be a
    /// motion of the robot is refused: upside down, in degrees or centimeters, with feet faster than any robot's.
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
        library.refuse_implausible(model, spec)?;
        library.clips = library.clips.into_iter().map(|c| at_rate(c, model, control_rate_hz)).collect();
        Ok(library)
    }

    /// As [`MotionLibrary::load`], each clip at its file's own frame rate.
    ///
    /// # Errors
    /// As [`MotionLibrary::load`].
    pub fn load_unchanged(dir: &Path, model: &RobotModel, spec: &RobotSpec) -> Result<Self, MotionError> {
        Self::load_with(dir, model, spec, &ReadOptions::default())
    }

    /// As [`MotionLibrary::load_unchanged`], with what the files may leave open.
    ///
    /// # Errors
    /// As [`MotionLibrary::load`].
    pub fn load_with(
        dir: &Path,
        model: &RobotModel,
        spec: &RobotSpec,
        options: &ReadOptions,
    ) -> Result<Self, MotionError> {
        let paths = motion_files(dir)?;
        let clips = paths.iter().map(|path| Self::read(path, model, spec, options));
        Ok(Self { clips: clips.collect::<Result<_, _>>()? })
    }

    /// One file of a library. As [`read_motion`], but an archive of a human's points is recognized as one.
    ///
    /// # Errors
    /// As [`read_motion`]; a human's points.
    pub fn read(
        path: &Path,
        model: &RobotModel,
        spec: &RobotSpec,
        options: &ReadOptions,
    ) -> Result<Clip, MotionError> {
        refuse_points(path)?;
        read_motion(path, model, spec, options)
    }

    /// Refuses the first clip that cannot be a motion of the robot, as [`MotionLibrary::load`] does.
    ///
    /// # Errors
    /// [`MotionError::Implausible`].
    pub fn refuse_implausible(&self, model: &RobotModel, spec: &RobotSpec) -> Result<(), MotionError> {
        let found = |clip: &Clip| Some((clip.path.clone(), Implausible::of(clip, model, spec)?.to_string()));
        match self.clips.iter().find_map(found) {
            Some((path, what)) => Err(MotionError::Implausible { path, what }),
            None => Ok(()),
        }
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
    // Fewer show no kick, and more than files may have fill the memory.
    let good = (10.0..=2000.0).contains(&control_rate_hz);
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

#[cfg(test)]
mod tests {
    use std::fs::File;

    use super::*;
    use crate::KickLeg;
    use crate::testing::{model, spec};
    use crate::write::numbers;

    /// A motion of the test robot that states no kicking leg.
    fn unlabeled(path: &Path) {
        let mut zip = zip::ZipWriter::new(File::create(path).expect("made"));
        numbers(&mut zip, "fps", &[1], &[50_i64]).expect("written");
        let arrays: [(&str, &[u64]); 6] = [
            ("joint_pos", &[4, 2]),
            ("joint_vel", &[4, 2]),
            ("body_pos_w", &[4, 3, 3]),
            ("body_quat_w", &[4, 3, 4]),
            ("body_lin_vel_w", &[4, 3, 3]),
            ("body_ang_vel_w", &[4, 3, 3]),
        ];
        for (key, shape) in arrays {
            // Quaternions of four halves are unit.
            let values = vec![0.5_f32; shape.iter().product::<u64>() as usize];
            numbers(&mut zip, key, shape, &values).expect("written");
        }
        zip.finish().expect("written");
    }

    #[test]
    fn a_folder_is_read_with_the_options_that_its_files_would_be() {
        let folder = tempfile::tempdir().expect("a folder");
        unlabeled(&folder.path().join("kick.npz"));
        // Both feet are as fast: the left one comes first.
        let library =
            MotionLibrary::load_unchanged(folder.path(), &model(), &spec()).expect("the faster foot");
        assert_eq!(library.clips[0].kick_leg, KickLeg::Left);
        let given = ReadOptions { kick_leg: Some(KickLeg::Right), ..ReadOptions::default() };
        let library = MotionLibrary::load_with(folder.path(), &model(), &spec(), &given).expect("loads");
        assert_eq!(library.clips[0].kick_leg, KickLeg::Right);
    }

    #[test]
    fn what_cannot_be_a_motion_is_refused_before_it_is_trained_on() {
        let folder = tempfile::tempdir().expect("a folder");
        // Quaternions of four halves: the robot lies.
        unlabeled(&folder.path().join("kick.npz"));
        let error =
            MotionLibrary::load(folder.path(), &model(), &spec(), 50.0).expect_err("lies").to_string();
        assert!(
            error.contains("kick.npz: expected a robot that stands") && error.contains("motion check"),
            "{error}"
        );
    }

    #[test]
    fn a_humans_points_in_a_folder_are_called_so() {
        let folder = tempfile::tempdir().expect("a folder");
        let points =
            crate::Points { names: vec!["hip".to_owned()], fps: None, frames: 2, pos: vec![[0.0; 3]; 2] };
        crate::write_points(&folder.path().join("human.npz"), &points).expect("written");
        let error = MotionLibrary::load(folder.path(), &model(), &spec(), 50.0).expect_err("a human");
        let error = error.to_string();
        assert!(error.contains("human.npz") && error.contains("`paid motion retarget`"), "{error}");
    }
}
