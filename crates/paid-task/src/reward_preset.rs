//! Weights and parameters of the reward terms.

use serde::{Deserialize, Serialize};

use crate::TaskError;
use crate::preset::value_error;

/// Mean and exponential, in which order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BodyKernel {
    /// `exp(-mean over bodies of e^2 / sigma^2)`: release and BeyondMimic. One body far off lowers the whole term, so
    /// the swinging leg counts even while the other bodies track well.
    ExpOfMean,
    /// `mean over bodies of exp(-e^2 / sigma^2)`: as printed in the paper's table.
    MeanOfExp,
}

/// Which point of the robot a distance is measured from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ProximityPoint {
    /// The anchor (torso): release.
    Anchor,
    /// The base (pelvis): paper.
    Base,
}

/// A term without parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plain {
    /// Weight; zero switches the term off.
    pub weight: f64,
}

/// A kernel `exp(-e^2 / sigma^2)`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Kernel {
    /// Weight; zero switches the term off.
    pub weight: f64,
    /// Width, in the unit of the error.
    pub sigma: f64,
}

/// A kernel on the kicking foot, over the whole motion or around its strike.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StrikeKernel {
    /// Weight; zero switches the term off.
    pub weight: f64,
    /// Width, in the unit of the error.
    pub sigma: f64,
    /// The term pays within this time of the reference's strike, before and after it [s]; 0: over the whole motion.
    #[serde(default)]
    pub around_s: f64,
}

/// The body position kernel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BodyPosition {
    /// Weight; zero switches the term off.
    pub weight: f64,
    /// Width [m].
    pub sigma: f64,
    /// True: the feet are left out (Stage II, where they have a term of their own).
    pub exclude_feet: bool,
}

/// Nearness to the ball.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Proximity {
    /// Weight; zero switches the term off.
    pub weight: f64,
    /// Width [m].
    pub sigma: f64,
    /// Where the distance begins.
    pub from: ProximityPoint,
}

/// A squared rate of actions, limited.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rate {
    /// Weight, negative for a penalty.
    pub weight: f64,
    /// Largest value before weighting.
    pub clip: f64,
}

/// Distance of the feet from one another.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Separation {
    /// Weight; zero switches the term off.
    pub weight: f64,
    /// Distance from which the term is 1 [m].
    pub distance_m: f64,
    /// Width relative to the distance.
    pub sigma: f64,
}

/// Contacts that should not be.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct UndesiredContact {
    /// Weight, negative for a penalty.
    pub weight: f64,
    /// Force from which a contact counts [N].
    pub force_n: f64,
}

/// What counts as a kick, and for how long its outcome is paid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KickPreset {
    /// Force of the robot on the ball from which a contact counts [N].
    pub contact_force_n: f64,
    /// Control steps for which direction and speed are paid after a correct-foot contact, the contact's own included.
    pub window_steps: usize,
    /// Control steps for which vertical speed is charged once the ball is faster than `z_min_speed`.
    pub z_window_steps: usize,
    /// Ball speed that opens the vertical-speed window [m/s].
    pub z_min_speed: f64,
    /// Horizontal ball speed below which direction and speed pay nothing [m/s] (paper: outcome terms are gated by a
    /// minimum ball speed; release: 0).
    pub min_ball_speed: f64,
    /// Horizontal ball speed from which direction pays in full; below it pays in proportion to the speed [m/s]. 0: in full
    /// from `min_ball_speed` on, so that a ball that will not reach the goal pays as much as one that will.
    #[serde(default)]
    pub full_ball_speed: f64,
    /// How long before the reference's strike the first contact may come and still pay [s]; 0: at any time. A touch in walking
    /// otherwise pays a little, and is learned where the ball lies in the way of a step.
    #[serde(default)]
    pub early_s: f64,
}

/// All reward terms; `weight = 0` switches one off. Every term is multiplied by its weight and by the control period.
///
/// The 19 terms of the paper's table, then four of this project's (`kick_foot_vel`, `feet_vel`, `kick_foot_pos`,
/// `hand_pos`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RewardPreset {
    /// Form of the body kernels.
    pub body_kernel: BodyKernel,
    /// Detection of the kick.
    pub kick: KickPreset,
    /// Anchor position in the world [m].
    pub anchor_pos: Kernel,
    /// Anchor orientation [rad].
    pub anchor_ori: Kernel,
    /// Positions of the tracked bodies, yaw-aligned [m].
    pub body_pos: BodyPosition,
    /// Orientations of the tracked bodies, yaw-aligned [rad].
    pub body_ori: Kernel,
    /// Center-of-mass velocities of the tracked bodies [m/s].
    pub lin_vel: Kernel,
    /// Angular velocities of the tracked bodies [rad/s].
    pub ang_vel: Kernel,
    /// Positions of the feet, yaw-aligned [m].
    pub foot_pos: Kernel,
    /// Nearness to the ball, frozen at the first contact.
    pub ball_prox: Proximity,
    /// First contact, if it is with the labeled foot.
    pub contact: Plain,
    /// Lateral share of the kicking foot's velocity at that contact.
    pub side_kick: Plain,
    /// Direction of the ball against the goal [rad].
    pub vel_align: Kernel,
    /// Horizontal ball speed [m/s].
    pub speed: Kernel,
    /// Vertical ball speed; `sigma` is the scale of the tanh [m/s].
    pub z_speed: Kernel,
    /// Squared change of the action.
    pub action_rate: Rate,
    /// Summed distance of joints outside their soft limits [rad].
    pub joint_limit: Plain,
    /// Number of bodies that touch something they should not.
    pub undesired_contact: UndesiredContact,
    /// Distance of the feet.
    pub foot_sep: Separation,
    /// Squared change of the waist's action.
    pub waist_rate: Rate,
    /// Squared horizontal part of gravity in the base frame.
    pub upright: Plain,
    /// Center-of-mass velocity of the labeled kicking foot [m/s] (ours; off by default). The mean over all bodies gives one ankle
    /// 1/14 of the pull that the action rate costs at the strike.
    pub kick_foot_vel: StrikeKernel,
    /// Center-of-mass velocity of both feet [m/s] (ours; off by default).
    pub feet_vel: Kernel,
    /// Yaw-aligned position of the labeled kicking foot [m] (ours; off by default).
    pub kick_foot_pos: StrikeKernel,
    /// Yaw-aligned positions of the end effectors that are not feet [m] (ours; off by default). Once the feet are in place, the arms
    /// hold most of what is left of the mean error over the bodies.
    #[serde(default = "off")]
    pub hand_pos: Kernel,
}

/// A kernel that pays nothing, for presets written before it existed.
fn off() -> Kernel {
    Kernel { weight: 0.0, sigma: 0.1 }
}

/// Number of reward terms.
pub const REWARD_TERMS: usize = 23;

/// Names of the reward terms: the keys under `rewards`, in the order of [`RewardPreset::weights`].
pub const REWARD_NAMES: [&str; REWARD_TERMS] = [
    "anchor_pos",
    "anchor_ori",
    "body_pos",
    "body_ori",
    "lin_vel",
    "ang_vel",
    "foot_pos",
    "ball_prox",
    "contact",
    "side_kick",
    "vel_align",
    "speed",
    "z_speed",
    "action_rate",
    "joint_limit",
    "undesired_contact",
    "foot_sep",
    "waist_rate",
    "upright",
    "kick_foot_vel",
    "feet_vel",
    "kick_foot_pos",
    "hand_pos",
];

impl RewardPreset {
    /// The weights in the order of [`REWARD_NAMES`].
    pub fn weights(&self) -> [f64; REWARD_TERMS] {
        [
            self.anchor_pos.weight,
            self.anchor_ori.weight,
            self.body_pos.weight,
            self.body_ori.weight,
            self.lin_vel.weight,
            self.ang_vel.weight,
            self.foot_pos.weight,
            self.ball_prox.weight,
            self.contact.weight,
            self.side_kick.weight,
            self.vel_align.weight,
            self.speed.weight,
            self.z_speed.weight,
            self.action_rate.weight,
            self.joint_limit.weight,
            self.undesired_contact.weight,
            self.foot_sep.weight,
            self.waist_rate.weight,
            self.upright.weight,
            self.kick_foot_vel.weight,
            self.feet_vel.weight,
            self.kick_foot_pos.weight,
            self.hand_pos.weight,
        ]
    }

    pub(crate) fn validate(&self) -> Result<(), TaskError> {
        for (name, weight) in REWARD_NAMES.iter().zip(self.weights()) {
            if !weight.is_finite() {
                return Err(value_error(
                    &format!("rewards.{name}.weight"),
                    "a finite number",
                    weight.to_string(),
                ));
            }
        }
        let widths = [
            ("anchor_pos.sigma", self.anchor_pos.sigma),
            ("anchor_ori.sigma", self.anchor_ori.sigma),
            ("body_pos.sigma", self.body_pos.sigma),
            ("body_ori.sigma", self.body_ori.sigma),
            ("lin_vel.sigma", self.lin_vel.sigma),
            ("ang_vel.sigma", self.ang_vel.sigma),
            ("foot_pos.sigma", self.foot_pos.sigma),
            ("ball_prox.sigma", self.ball_prox.sigma),
            ("vel_align.sigma", self.vel_align.sigma),
            ("speed.sigma", self.speed.sigma),
            ("z_speed.sigma", self.z_speed.sigma),
            ("foot_sep.sigma", self.foot_sep.sigma),
            ("foot_sep.distance_m", self.foot_sep.distance_m),
            ("kick_foot_vel.sigma", self.kick_foot_vel.sigma),
            ("feet_vel.sigma", self.feet_vel.sigma),
            ("kick_foot_pos.sigma", self.kick_foot_pos.sigma),
            ("hand_pos.sigma", self.hand_pos.sigma),
        ];
        for (name, value) in widths {
            if !(value > 0.0 && value.is_finite()) {
                return Err(value_error(&format!("rewards.{name}"), "a positive number", value.to_string()));
            }
        }
        for (name, value) in [
            ("kick_foot_vel.around_s", self.kick_foot_vel.around_s),
            ("kick_foot_pos.around_s", self.kick_foot_pos.around_s),
        ] {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(value_error(&format!("rewards.{name}"), "zero or more", value.to_string()));
            }
        }
        Ok(())
    }
}
