//! Motion files of any format: distinguished by their content, then by their name.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use paid_robot::{RobotModel, RobotSpec};

use crate::foreign::refuse_by_head;
use crate::gmr::{begins_as_pickle, read_gmr};
use crate::read::read_npz;
use crate::{Clip, KickLeg, MotionError, QuatOrder, fastest_kick, read_csv, write_csv, write_npz};

/// Endings of the names of files that [`read_motion`] reads.
pub const EXTENSIONS: [&str; 4] = ["npz", "csv", "pkl", "pickle"];

/// Order of the joints in a CSV file without column names.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum JointOrder {
    /// Depth-first, as in the MJCF: what Unitree's and BeyondMimic's files have.
    #[default]
    Model,
    /// That of policies and NPZ files (`policy_joint_order` in the robot's TOML): breadth-first.
    Policy,
}

impl std::str::FromStr for JointOrder {
    type Err = String;

    /// Accepts `model` and `policy`.
    fn from_str(name: &str) -> Result<Self, String> {
        match name {
            "model" => Ok(Self::Model),
            "policy" => Ok(Self::Policy),
            other => Err(format!("expected 'model' or 'policy', found '{other}'")),
        }
    }
}

/// What a file may leave open.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReadOptions {
    /// Frames a second of a CSV or pickle file that does not state it; another than a file's own is an error.
    pub fps: Option<f64>,
    /// The kicking leg; wins over what the file states. Without either, the leg with the faster foot.
    pub kick_leg: Option<KickLeg>,
    /// Joint order of a CSV file without column names or of a pickle; wins over what the file states. Without either, [`JointOrder::Model`].
    /// An error with an NPZ file, which has its own.
    pub joint_order: Option<JointOrder>,
    /// Order of the base's quaternion in a CSV file without column names or in a pickle; wins over what the file states. Without either,
    /// [`QuatOrder::Xyzw`], and a file that stands only in the other order is an error. NPZ files have their own.
    pub quat: Option<QuatOrder>,
}

/// Reads a motion file of any known format (NPZ, CSV, GMR's pickle), at its own frame rate. A zip archive is taken for NPZ and a pickle for
/// GMR's whatever its name is.
///
/// # Errors
/// Names the file, the place, what was expected and what was found.
pub fn read_motion(
    path: &Path,
    model: &RobotModel,
    spec: &RobotSpec,
    options: &ReadOptions,
) -> Result<Clip, MotionError> {
    let io = |source| MotionError::Io { path: path.to_owned(), source };
    let mut head = Vec::new();
    File::open(path).map_err(io)?.take(32).read_to_end(&mut head).map_err(io)?;
    refuse_by_head(path, &head)?;
    if head.starts_with(b"PK\x03\x04") || has_extension(path, "npz") {
        let (mut clip, labeled) = read_npz(path, model, spec, options)?;
        let fastest = || fastest_kick(&clip, model, spec).map(|kick| kick.leg);
        let leg = if labeled { options.kick_leg } else { options.kick_leg.or_else(fastest) };
        clip.kick_leg = leg.unwrap_or(clip.kick_leg);
        Ok(clip)
    } else if has_extension(path, "csv") {
        read_csv(path, model, spec, options)
    } else if begins_as_pickle(&head) || has_extension(path, "pkl") || has_extension(path, "pickle") {
        read_gmr(path, model, spec, options)
    } else {
        Err(MotionError::Extension { path: path.to_owned() })
    }
}

/// Writes a motion in the format of the file's name (`.npz`, `.csv`). Its folder is made; the file appears under its name only
/// when it is whole.
///
/// # Errors
/// Another name, names that do not match the robot's, a file that cannot be written.
pub fn write_motion(
    path: &Path,
    clip: &Clip,
    model: &RobotModel,
    spec: &RobotSpec,
) -> Result<(), MotionError> {
    let (npz, csv) = (has_extension(path, "npz"), has_extension(path, "csv"));
    if !npz && !csv {
        return Err(MotionError::Extension { path: path.to_owned() });
    }
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder)
            .map_err(|source| MotionError::Io { path: path.to_owned(), source })?;
    }
    if npz { write_npz(path, clip, model, spec) } else { write_csv(path, clip) }
}

pub(crate) fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension))
}
