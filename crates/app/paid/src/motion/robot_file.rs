//! What a robot's motion file may leave out, and the folder that files go to.

use std::path::Path;

use paid_motion::{Clip, JointOrder, KickLeg, QuatOrder, ReadOptions};

use crate::failure::{Failure, first_given};

/// Refuses a file where `--out` needs a folder; one that is missing will be made.
pub fn expect_folder(out: &Path) -> Result<(), Failure> {
    if out.exists() && !out.is_dir() {
        return Err(Failure::input(format!("--out {}: expected a folder, found a file", out.display())));
    }
    Ok(())
}

/// Options of commands that read a robot's motion and write it.
#[derive(Clone, Debug, clap::Args)]
pub struct RobotFile {
    /// Joint order of a CSV file that does not state it: model or policy.
    ///
    /// model is depth-first, policy is breadth-first.
    #[arg(long, value_name = "ORDER")]
    joint_order: Option<JointOrder>,
    /// Order of the base's quaternion in a CSV or pickle file: xyzw or wxyz [default: xyzw].
    #[arg(long, value_name = "ORDER")]
    quat: Option<QuatOrder>,
    /// Kicking leg [default: as the file states, else the leg with the faster foot].
    #[arg(long)]
    leg: Option<KickLeg>,
    /// Terms of use to state in the file [default: those of the input].
    #[arg(long)]
    license: Option<String>,
}

impl RobotFile {
    /// For the reader; `fps` is the rate of a file that does not state it `[Hz]`.
    pub fn options(&self, fps: Option<f64>) -> ReadOptions {
        ReadOptions { fps, kick_leg: self.leg, joint_order: self.joint_order, quat: self.quat }
    }

    /// The clip with the terms of use that the file shall state.
    pub fn licensed(&self, clip: Clip) -> Clip {
        Clip { license: self.license.clone().or(clip.license), ..clip }
    }

    /// The first option that is given.
    pub fn given(&self) -> Option<&'static str> {
        first_given(&[
            ("--joint-order", self.joint_order.is_some()),
            ("--quat", self.quat.is_some()),
            ("--leg", self.leg.is_some()),
            ("--license", self.license.is_some()),
        ])
    }
}
