//! What the robot is rewarded for: one term a file.
//!
//! A term is a struct of typed parameters and an inlined function over lanes. The list below makes from the terms the preset
//! (`rewards.<name> = { weight = 1.0, ... }`), names, weights, validation, the sums in the log and the table of terms.
//! To add one to this crate: write its file, add it to the list, give it a weight in a preset. Another crate adds its own with
//! [`crate::TermSet`].

mod kernel;

mod action_rate;
mod anchor_ori;
mod anchor_pos;
#[expect(clippy::approx_constant, reason = "3.14 rad/s is the release's own number")]
mod ang_vel;
mod ball_prox;
mod body_ori;
mod body_pos;
mod contact;
mod fall;
mod feet_vel;
mod foot_pos;
mod foot_sep;
mod hand_pos;
mod joint_limit;
mod kick_foot_pos;
mod kick_foot_vel;
mod lin_vel;
mod side_kick;
mod speed;
mod undesired_contact;
mod upright;
mod vel_align;
mod waist_rate;
mod z_speed;

use std::sync::OnceLock;

use paid_lanes::Real;
use serde::{Deserialize, Serialize};

pub use ball_prox::ProximityPoint;
pub use kernel::BodyKernel;

use crate::config::TaskConfig;
use crate::terms::parameters::{Parameters, Requirement};
use crate::terms::table::TermInfo;
use crate::terms::{OwnRewards, TermInput, own_reward_names, own_reward_table};
use crate::{KickPreset, TaskError};

/// A reward term: its parameters with a weight, and its value over lanes. [`reward_term!`](crate::reward_term) declares the parameters.
pub trait RewardTerm: Weighted {
    /// SI unit of what the term measures; empty for pure numbers.
    const UNIT: &'static str;
    /// Frame in which it measures.
    const FRAME: &'static str;
    /// What it needs.
    const NEEDS: &'static [Requirement] = &[];

    /// The value before weight and control period. Mark it `#[inline(always)]`: it is compiled for each lane type and instruction set.
    fn value<V: Real>(&self, input: &TermInput<'_, V>) -> V;
}

/// Parameters with a weight.
pub trait Weighted: Parameters {
    /// Factor on the value, per second; a term of weight 0 is not computed.
    fn weight(&self) -> f64;
}

/// Declares a reward term's parameters: those of [`parameters!`](crate::parameters) and a weight of 0.
///
/// ```
/// paid_task::reward_term! {
///     /// Height of the base above `least_m`.
///     pub struct Height {
///         /// Height from which the term is above 0.
///         least_m: f64 = 0.6, "m", positive, "below it the robot has fallen";
///     }
/// }
///
/// assert_eq!(Height::default(), Height { weight: 0.0, least_m: 0.6 });
/// ```
#[macro_export]
macro_rules! reward_term {
    ($(#[doc = $summary:literal])+ pub struct $Term:ident { $($rest:tt)* }) => {
        $crate::parameters! {
            $(#[doc = $summary])+
            pub struct $Term {
                /// Factor on the value, per second; negative for a penalty. At 0 the term is not computed.
                weight: f64 = 0.0, "", finite, "a term that a preset leaves out is off";
                $($rest)*
            }
        }

        impl $crate::Weighted for $Term {
            fn weight(&self) -> f64 {
                self.weight
            }
        }
    };
}

/// As in the paper.
fn aligned() -> bool {
    true
}

/// Makes the preset and everything that runs over the terms, in the order of the list.
macro_rules! reward_terms {
    ($($name:ident: $Term:ident),+ $(,)?) => {
        $(pub use $name::$Term;)+

        /// All reward terms. A term that a preset leaves out has weight 0 and its default parameters.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        pub struct RewardPreset {
            /// Form of the kernels over bodies.
            pub body_kernel: BodyKernel,
            /// Bodies are compared with the reference turned into the robot's heading. False, for ablations: with the reference as it is
            /// turned, still placed at the robot's anchor.
            #[serde(default = "aligned")]
            pub align_yaw: bool,
            /// What counts as a kick.
            pub kick: KickPreset,
            $(
                #[doc = concat!("The term `", stringify!($Term), "`.")]
                #[serde(default)]
                pub $name: $Term,
            )+
            /// The terms of other crates, under their names; unknown keys are refused here.
            #[serde(flatten)]
            pub own: OwnRewards,
        }

        /// Names of the built-in terms.
        pub(crate) const REWARD_NAMES: [&str; REWARD_TERMS] = [$(stringify!($name)),+];

        /// Number of built-in terms.
        pub(crate) const REWARD_TERMS: usize = [$(stringify!($name)),+].len();

        impl RewardPreset {
            pub(crate) fn validate(&self) -> Result<(), TaskError> {
                $(self.$name.validate(concat!("rewards.", stringify!($name)))?;)+
                self.own.validate()
            }

            /// Each term that is on, with what it needs.
            pub(crate) fn active(&self) -> impl Iterator<Item = (&'static str, &'static [Requirement])> {
                let terms = [$((stringify!($name), self.$name.weight, $Term::NEEDS)),+];
                let active = terms.into_iter().filter(|(_, weight, _)| *weight != 0.0);
                active.map(|(name, _, needs)| (name, needs)).chain(self.own.active())
            }

            /// Rows of the table of terms.
            pub(crate) fn table() -> Vec<TermInfo> {
                let builtin = [$(TermInfo::new::<$Term>("reward", stringify!($name), [$Term::UNIT, $Term::FRAME], $Term::NEEDS)),+];
                builtin.into_iter().chain(own_reward_table()).collect()
            }

            /// Writes value x weight x control period of every built-in term, 0 where it is off, and returns their sum.
            #[inline(always)]
            pub(crate) fn evaluate<V: Real>(&self, input: &TermInput<'_, V>, terms: &mut [V; REWARD_TERMS]) -> V {
                let mut total = V::zero();
                let mut places = terms.iter_mut();
                $(
                    let place = places.next().expect("a place for each term");
                    *place = V::zero();
                    if is_on(self.$name.weight, $Term::NEEDS, input.config) {
                        *place = self.$name.value(input) * V::c(self.$name.weight * input.config.dt_s);
                        total += *place;
                    }
                )+
                total
            }
        }
    };
}

// The 19 terms of the paper's table, then those of this project.
reward_terms! {
    anchor_pos: AnchorPos,
    anchor_ori: AnchorOri,
    body_pos: BodyPos,
    body_ori: BodyOri,
    lin_vel: LinVel,
    ang_vel: AngVel,
    foot_pos: FootPos,
    ball_prox: BallProx,
    contact: Contact,
    side_kick: SideKick,
    vel_align: VelAlign,
    speed: Speed,
    z_speed: ZSpeed,
    action_rate: ActionRate,
    joint_limit: JointLimit,
    undesired_contact: UndesiredContact,
    foot_sep: FootSep,
    waist_rate: WaistRate,
    upright: Upright,
    kick_foot_vel: KickFootVel,
    feet_vel: FeetVel,
    kick_foot_pos: KickFootPos,
    hand_pos: HandPos,
    fall: Fall,
}

/// Names of the reward terms: the keys under `rewards`, in the order in which they are added up.
pub fn reward_names() -> &'static [&'static str] {
    static NAMES: OnceLock<Vec<&str>> = OnceLock::new();
    NAMES.get_or_init(|| REWARD_NAMES.into_iter().chain(own_reward_names()).collect())
}

/// Every key under `rewards`.
pub(crate) fn keys() -> &'static [&'static str] {
    static KEYS: OnceLock<Vec<&str>> = OnceLock::new();
    let others = ["body_kernel", "align_yaw", "kick"];
    KEYS.get_or_init(|| others.into_iter().chain(reward_names().iter().copied()).collect())
}

/// False for a term of weight 0, and for one about the ball in a scene without it.
#[inline(always)]
fn is_on(weight: f64, needs: &[Requirement], config: &TaskConfig) -> bool {
    weight != 0.0 && (config.preset.scene.ball || !needs.contains(&Requirement::Ball))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::TaskPreset;
    use crate::fixture::Fixture;

    #[test]
    fn only_terms_with_a_weight_are_computed_and_they_add_up() {
        let mut fixture = Fixture::new();
        let rewards = &mut fixture.config.preset.rewards;
        *rewards = toml::from_str(&format!(
            "body_kernel = 'exp_of_mean'\nkick = {}\nupright = {{ weight = -2.0 }}\nspeed = {{ weight = 3.0, sigma = 1.0 }}",
            toml::Value::try_from(&rewards.kick).expect("writes")
        ))
        .expect("valid");
        // Not a number where a term that is off would read it.
        fixture.tracking.anchor_pos2 = f64::NAN;
        let mut terms = [9.0; REWARD_TERMS];
        let preset = fixture.config.preset.rewards.clone();
        // Upright, and no kick: nothing.
        assert_eq!(preset.evaluate(&fixture.input(), &mut terms), 0.0);
        assert_eq!(terms, [0.0; REWARD_TERMS]);
        // Lying: -2 x 1 x 0.02 s.
        fixture.state.bodies[0].rot = paid_lanes::Mat3([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]);
        assert_eq!(preset.evaluate(&fixture.input(), &mut terms), -0.04);
        assert_eq!(preset.active().map(|(name, _)| name).collect::<Vec<_>>(), ["speed", "upright"]);
    }

    #[test]
    fn a_term_that_a_preset_leaves_out_is_off_and_an_unknown_one_is_refused() {
        let preset = TaskPreset::builtin("paper_stage2").expect("valid").rewards;
        let kick = toml::Value::try_from(&preset.kick).expect("writes");
        let text = format!("body_kernel = 'exp_of_mean'\nkick = {kick}\n");
        let bare: RewardPreset = toml::from_str(&text).expect("valid");
        assert_eq!(bare.active().count(), 0);
        assert_eq!((bare.hand_pos.sigma, bare.foot_sep.distance_m), (0.1, 0.24));
        let error = toml::from_str::<RewardPreset>(&format!("{text}foot_pose = {{ weight = 1.0 }}"))
            .expect_err("unknown");
        assert!(error.to_string().contains("foot_pose"), "{error}");
    }

    #[test]
    fn a_width_of_zero_is_named() {
        let mut preset = TaskPreset::builtin("paper_stage2").expect("valid").rewards;
        preset.kick_foot_pos.sigma = 0.0;
        let error = preset.validate().expect_err("zero").to_string();
        assert_eq!(error, "preset: rewards.kick_foot_pos.sigma is 0.0, expected a positive number");
    }
}
