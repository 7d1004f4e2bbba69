//! How episodes begin, which motion and phase they draw, and what disturbs them.

use serde::{Deserialize, Serialize};

use crate::TaskError;
use crate::preset::numbers::{ANGLE, COUNT, LENGTH, POSITIVE_TIME, SHARE, SPEED, TIME, TURN_RATE, check};
use crate::preset::{Range, ReferenceSource, value_error};

/// Uniform noise on velocities, half-widths.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VelocityNoise {
    /// x and y `[m/s]`.
    pub xy: f64,
    /// z `[m/s]`.
    pub z: f64,
    /// About x and y `[rad/s]`.
    pub roll_pitch: f64,
    /// About z `[rad/s]`.
    pub yaw: f64,
}

impl VelocityNoise {
    fn check(&self, table: &str) -> Result<(), TaskError> {
        check(
            table,
            &[
                ("xy", self.xy.into(), SPEED),
                ("z", self.z.into(), SPEED),
                ("roll_pitch", self.roll_pitch.into(), TURN_RATE),
                ("yaw", self.yaw.into(), TURN_RATE),
            ],
        )
    }
}

/// Noise on the reference frame that an episode begins with, half-widths of uniform distributions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ResetPreset {
    /// Base x and y `[m]`.
    pub xy_m: f64,
    /// Base z `[m]`.
    pub z_m: f64,
    /// Base roll and pitch `[rad]`.
    pub roll_pitch_rad: f64,
    /// Base yaw `[rad]`.
    pub yaw_rad: f64,
    /// Base velocity.
    pub velocity: VelocityNoise,
    /// Joint angles `[rad]`, clipped to the soft limits.
    pub joint_rad: f64,
    /// True: the base is raised by the height of the ground under the higher foot, so that no episode begins inside it.
    pub lift_to_ground: bool,
}

impl ResetPreset {
    pub(crate) fn check(&self) -> Result<(), TaskError> {
        check(
            "resets",
            &[
                ("xy_m", self.xy_m.into(), LENGTH),
                ("z_m", self.z_m.into(), LENGTH),
                ("roll_pitch_rad", self.roll_pitch_rad.into(), ANGLE),
                ("yaw_rad", self.yaw_rad.into(), ANGLE),
                ("joint_rad", self.joint_rad.into(), ANGLE),
            ],
        )?;
        self.velocity.check("resets.velocity")
    }
}

/// Choice of motion and phase.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SamplingPreset {
    /// Share of the draws that is uniform over all (motion, bin) pairs. Release: 0.1, which starved the starts of the
    /// clips in the pilot; with 0.6 the evaluation reward grew several times faster.
    pub uniform_mass: f64,
    /// Weight of the newest failure counts in their exponential average.
    pub alpha: f64,
    /// Bins of the smoothing kernel, looking ahead: a failure raises its own bin and the ones before it.
    pub kernel_size: usize,
    /// Ratio of successive kernel weights.
    pub kernel_ratio: f64,
    /// Share of the episodes that begin at the first frame of the drawn motion.
    pub first_frame_share: f64,
    /// Latest start of an episode, seconds before the reference's strike; negative: no limit. The ball lies in front of
    /// the first frame, so an episode that began after the strike would begin on top of the ball.
    pub latest_start_before_strike_s: f64,
    /// What an episode that ends without a shot on target counts as, against 1 for a failure; it counts in the bin of the strike.
    /// More than 0 draws episodes to the motions whose shots miss: by the workspace rule half of the episodes from the first
    /// frame then take their motion from the sampler instead of from a uniform ball.
    pub miss_sampling_weight: f64,
    /// Time after the first contact with the ball at which an episode times out `[s]`; 0: never. The outcome is decided by
    /// then, and almost half of a clip is follow-through and recovery.
    pub stop_after_kick_s: f64,
    /// Share of the environments in which it does; the others continue, so that the recovery stays in training.
    pub stop_share: f64,
    /// Share of the episodes that begin after the strike, at a frame between it and the end of holding, with the ball on its way to
    /// the goal. What they do is no kick and counts as none.
    #[serde(default)]
    pub after_strike_share: f64,
    /// Share of the starts at the first frame whose robot has the last pose of another motion instead, at rest at the first frame's
    /// place, its heading off by up to 0.15 rad.
    #[serde(default)]
    pub from_last_pose_share: f64,
    /// Share of the starts at the first frame whose robot has the state in which a held episode of the same shard ended, in the same
    /// way. Needs `hold_s`; a start before there is such a state is the first frame's.
    #[serde(default)]
    pub from_end_state_share: f64,
    /// Motions are drawn equally often, and failures only choose the phase within them; for ablations.
    #[serde(default)]
    pub phase_only: bool,
}

impl SamplingPreset {
    /// Refuses numbers out of range, and starts that do not exist. `hold_s` is how long last frames are held `[s]`.
    pub(crate) fn check(&self, reference: ReferenceSource, hold_s: Range) -> Result<(), TaskError> {
        let latest = ([-3600.0, 3600.0], "-3600 to 3600 s");
        check(
            "sampling",
            &[
                ("uniform_mass", self.uniform_mass.into(), SHARE),
                ("alpha", self.alpha.into(), SHARE),
                ("kernel_size", self.kernel_size.into(), COUNT),
                ("kernel_ratio", self.kernel_ratio.into(), SHARE),
                ("first_frame_share", self.first_frame_share.into(), SHARE),
                ("latest_start_before_strike_s", self.latest_start_before_strike_s.into(), latest),
                ("miss_sampling_weight", self.miss_sampling_weight.into(), ([0.0, 1000.0], "0 to 1000")),
                ("stop_after_kick_s", self.stop_after_kick_s.into(), TIME),
                ("stop_share", self.stop_share.into(), SHARE),
            ],
        )?;
        let shares = [
            ("after_strike_share", self.after_strike_share),
            ("from_last_pose_share", self.from_last_pose_share),
            ("from_end_state_share", self.from_end_state_share),
        ];
        for (name, share) in shares {
            check("sampling", &[(name, share.into(), SHARE)])?;
            if share > 0.0 && reference == ReferenceSource::None {
                let key = format!("sampling.{name}");
                return Err(value_error(&key, "0 in a task without a reference", share.to_string()));
            }
        }
        let both = self.from_last_pose_share + self.from_end_state_share;
        if both > 1.0 {
            let keys = "sampling.from_last_pose_share + from_end_state_share";
            return Err(value_error(keys, "at most 1", both.to_string()));
        }
        if self.from_end_state_share > 0.0 && hold_s[1] <= 0.0 {
            let expected = "0 while hold_s is [0, 0]: no episode is held to its end";
            let found = self.from_end_state_share.to_string();
            return Err(value_error("sampling.from_end_state_share", expected, found));
        }
        Ok(())
    }
}

/// Sudden changes of the base velocity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PushPreset {
    /// True to push.
    pub enabled: bool,
    /// Range of the time between pushes `[s]`.
    pub interval_s: Range,
    /// Half-widths of the change.
    pub velocity: VelocityNoise,
}

impl PushPreset {
    pub(crate) fn check(&self) -> Result<(), TaskError> {
        check("pushes", &[("interval_s", self.interval_s.into(), POSITIVE_TIME)])?;
        self.velocity.check("pushes.velocity")
    }
}
