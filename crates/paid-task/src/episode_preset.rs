//! How episodes begin, which motion and phase they draw, and what disturbs them.

use serde::{Deserialize, Serialize};

use crate::preset::Range;

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
    /// Share of the environments in which it does; the others go on, so that the recovery stays in training.
    pub stop_share: f64,
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
