//! Surfaces and domain randomization, as typed values.

use paid_lanes::rng::Rng;
use paid_physics::{BallParams, Material};
use serde::{Deserialize, Serialize};

use crate::TaskError;
use crate::preset::numbers::{DAMPING, FACTOR, FRICTION, MASS, SHARE, check, check_material};
use crate::preset::{Range, value_error};

/// Where these values are in a task.
const TABLE: &str = "randomization";

/// The ball's contact on a ground, as `paid sysid` finds it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SurfacePreset {
    /// Name of the surface.
    pub name: String,
    /// Coulomb coefficient up to which the ball sticks.
    pub static_friction: f64,
    /// Coulomb coefficient while it slides.
    pub dynamic_friction: f64,
    /// Share of the normal approach speed that is returned.
    pub restitution: f64,
    /// Linear damping `[1/s]`.
    pub linear_damping: f64,
    /// Angular damping `[1/s]`.
    pub angular_damping: f64,
}

impl SurfacePreset {
    /// The surface of a ball.
    pub fn of(name: &str, ball: &BallParams) -> Self {
        Self {
            name: name.to_owned(),
            static_friction: ball.material.static_friction,
            dynamic_friction: ball.material.dynamic_friction,
            restitution: ball.material.restitution,
            linear_damping: ball.linear_damping,
            angular_damping: ball.angular_damping,
        }
    }

    /// Friction and restitution.
    fn material(&self) -> Material {
        let Self { static_friction, dynamic_friction, restitution, .. } = *self;
        Material { static_friction, dynamic_friction, restitution }
    }

    /// `ball` on this surface.
    pub fn apply(&self, ball: &mut BallParams) {
        ball.material = self.material();
        ball.linear_damping = self.linear_damping;
        ball.angular_damping = self.angular_damping;
    }

    /// Each parameter times (1 + `deviation` x a normal number), in its physical range: nothing below zero, restitution up
    /// to one, dynamic friction up to the static one.
    pub(crate) fn perturbed(&self, deviation: f64, rng: &mut Rng) -> Self {
        let mut near = |value: f64| (value * (1.0 + deviation * rng.normal())).max(0.0);
        let static_friction = near(self.static_friction);
        Self {
            name: String::new(),
            static_friction,
            dynamic_friction: near(self.dynamic_friction).min(static_friction),
            restitution: near(self.restitution).min(1.0),
            linear_damping: near(self.linear_damping),
            angular_damping: near(self.angular_damping),
        }
    }
}

/// Ranges from which physical parameters are drawn at every reset.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RandomizationPreset {
    /// True: each environment lies at a random place of the terrain, drawn at every reset.
    pub terrain_offset: bool,
    /// True: robot parameters below are drawn.
    pub robot: bool,
    /// Static friction.
    pub static_friction: Range,
    /// Dynamic friction, limited to the static one.
    pub dynamic_friction: Range,
    /// Restitution.
    pub restitution: Range,
    /// Error of the default joint angles `[rad]`.
    pub joint_default_rad: Range,
    /// Offset of the base's center of mass along x `[m]`.
    pub base_com_x_m: Range,
    /// Offset of the base's center of mass along y and z `[m]`.
    pub base_com_yz_m: Range,
    /// True: ball parameters below are drawn.
    pub ball: bool,
    /// Ball mass `[kg]`.
    pub ball_mass_kg: Range,
    /// Ball static friction.
    pub ball_static_friction: Range,
    /// Ball dynamic friction.
    pub ball_dynamic_friction: Range,
    /// Ball restitution.
    pub ball_restitution: Range,
    /// Ball linear damping `[1/s]`.
    pub ball_linear_damping: Range,
    /// Ball angular damping `[1/s]`.
    pub ball_angular_damping: Range,
    /// Surfaces that the environments are split between by their number; none: the ball of `ball_params`, or of the ranges
    /// above.
    pub surfaces: Vec<SurfacePreset>,
    /// Relative standard deviation of every parameter of a surface. The paper writes a unit variance, which cannot be right:
    /// a restitution of 0.75 would leave [0, 1] in 53% of the draws.
    pub surface_deviation: f64,
    /// Factor of the joint controllers' stiffness, and another of their damping; [1, 1] is none.
    pub gain_scale: Range,
    /// Robots that episodes are drawn from, by their `mode_machine` in the robot's file: motors, gains, and masses of links. Empty: the robot
    /// as its files have it.
    #[serde(default)]
    pub mode_machines: Vec<u8>,
    /// Factor of the armature (reflected inertia) of every joint, drawn for each joint; [1, 1] is none.
    #[serde(default = "unit")]
    pub armature_scale: Range,
    /// The same of the dry friction.
    #[serde(default = "unit")]
    pub joint_friction_scale: Range,
    /// Factor of mass and inertia of every body but the base, drawn for each body; [1, 1] is none.
    pub link_mass_scale: Range,
    /// Factor of mass and inertia of the base; [1, 1] is none.
    pub base_mass_scale: Range,
    /// Time constant of the ball's contacts with ground and robot `[s]`, up to 50 ms; below 2 ms (so also at [0, 0]) they are hard: one
    /// step long. A soft contact returns the restitution that the surfaces have, but at least 0.135.
    #[serde(default = "none")]
    pub ball_contact_time_s: Range,
    /// The same of the soles' contacts.
    #[serde(default = "none")]
    pub sole_contact_time_s: Range,
    /// Share of the environments whose ball bounces as a filmed match ball does, off robot and ground: 0.80 to 0.89 of the speed in 5.8 to
    /// 7.0 ms.
    #[serde(default)]
    pub real_ball_share: f64,
    /// Torsional friction of the ball `[m]`: moment about the normal over normal force. MuJoCo's scene has 0.01.
    #[serde(default = "none")]
    pub ball_torsional_friction_m: Range,
    /// Rolling friction of the ball `[m]`. MuJoCo's scene has 0.0001.
    #[serde(default = "none")]
    pub ball_rolling_friction_m: Range,
    /// Share of the environments whose ball has a friction pyramid instead of a circular cone.
    #[serde(default)]
    pub pyramid_share: f64,
    /// Share of the environments in which sliding on the ball lifts, as in MuJoCo, instead of Coulomb's law.
    #[serde(default)]
    pub convex_share: f64,
    /// Factor on the soles' length, and another on their width; [1, 1] is none.
    #[serde(default = "unit")]
    pub sole_scale: Range,
    /// Added to the radius of the soles' points `[m]`; the lowest points stay.
    #[serde(default = "none")]
    pub sole_rounding_m: Range,
    /// Shape of the feet as the ball meets them: 0 the model's capsule, 1 a thin plate at the height of the sole; [0, 0] is none.
    #[serde(default = "none")]
    pub foot_flatness: Range,
    /// Joint control between explicit (0: torques of a physics step's start) and implicit (1: of its end); [1, 1] is the engine's
    /// own. Explicit control at steps of 2 ms, as in MuJoCo's scene, is near 0.4 at steps of 5 ms.
    #[serde(default = "unit")]
    pub pd_implicitness: Range,
    /// Delay between policy and joint targets `[s]`, up to a control period: until then the last ones hold. It replaces the task's
    /// `action_delay_s`.
    pub action_delay_s: Range,
    /// Age of gravity, angular velocity, joint angles and velocities in the policy's observation `[s]`, up to a control period:
    /// interpolated between two control steps.
    pub observation_delay_s: Range,
}

/// Delays that can be simulated.
pub(super) const fn delay_range(control_dt_s: f64) -> (Range, &'static str) {
    ([0.0, control_dt_s + 1e-9], "0 to the control period")
}

/// The range of what is off.
fn none() -> Range {
    [0.0; 2]
}

/// The range of a factor that changes nothing.
fn unit() -> Range {
    [1.0; 2]
}

impl RandomizationPreset {
    /// True if contacts or controllers differ in kind between environments.
    pub(crate) fn kinds(&self) -> bool {
        let off = [
            self.ball_contact_time_s,
            self.sole_contact_time_s,
            self.ball_torsional_friction_m,
            self.ball_rolling_friction_m,
            self.sole_rounding_m,
            self.foot_flatness,
        ];
        off.iter().any(|range| *range != none())
            || [self.sole_scale, self.pd_implicitness].iter().any(|range| *range != unit())
            || self.pyramid_share > 0.0
            || self.real_ball_share > 0.0
            || self.convex_share > 0.0
    }

    /// Checks what makes contacts and controllers differ in kind.
    fn check_kinds(&self) -> Result<(), TaskError> {
        let spin = ([0.0, 0.1], "0 to 0.1");
        let ones = ([0.0, 1.0], "0 to 1");
        check(
            TABLE,
            &[
                ("ball_contact_time_s", self.ball_contact_time_s.into(), ([0.0, 0.05], "0 to 0.05")),
                ("sole_contact_time_s", self.sole_contact_time_s.into(), ([0.0, 0.025], "0 to 0.025")),
                ("ball_torsional_friction_m", self.ball_torsional_friction_m.into(), spin),
                ("ball_rolling_friction_m", self.ball_rolling_friction_m.into(), spin),
                ("real_ball_share", self.real_ball_share.into(), SHARE),
                ("pyramid_share", self.pyramid_share.into(), SHARE),
                ("convex_share", self.convex_share.into(), SHARE),
                ("sole_scale", self.sole_scale.into(), ([0.5, 1.5], "0.5 to 1.5")),
                ("sole_rounding_m", self.sole_rounding_m.into(), ([0.0, 0.03], "0 to 0.03")),
                ("foot_flatness", self.foot_flatness.into(), ones),
                ("pd_implicitness", self.pd_implicitness.into(), ones),
            ],
        )
    }

    /// True if actions or observations are delayed.
    pub(crate) fn delays(&self) -> bool {
        self.action_delay_s[1] > 0.0 || self.observation_delay_s[1] > 0.0
    }

    pub(crate) fn check(&self, control_dt_s: f64) -> Result<(), TaskError> {
        let delay = delay_range(control_dt_s);
        let com = ([-1.0, 1.0], "-1 to 1 m");
        let angle = ([-3.15, 3.15], "-3.15 to 3.15 rad");
        check(
            TABLE,
            &[
                ("static_friction", self.static_friction.into(), FRICTION),
                ("dynamic_friction", self.dynamic_friction.into(), FRICTION),
                ("restitution", self.restitution.into(), SHARE),
                ("joint_default_rad", self.joint_default_rad.into(), angle),
                ("base_com_x_m", self.base_com_x_m.into(), com),
                ("base_com_yz_m", self.base_com_yz_m.into(), com),
                ("ball_mass_kg", self.ball_mass_kg.into(), MASS),
                ("ball_static_friction", self.ball_static_friction.into(), FRICTION),
                ("ball_dynamic_friction", self.ball_dynamic_friction.into(), FRICTION),
                ("ball_restitution", self.ball_restitution.into(), SHARE),
                ("ball_linear_damping", self.ball_linear_damping.into(), DAMPING),
                ("ball_angular_damping", self.ball_angular_damping.into(), DAMPING),
                ("surface_deviation", self.surface_deviation.into(), SHARE),
                ("gain_scale", self.gain_scale.into(), FACTOR),
                ("armature_scale", self.armature_scale.into(), FACTOR),
                ("joint_friction_scale", self.joint_friction_scale.into(), FACTOR),
                ("link_mass_scale", self.link_mass_scale.into(), FACTOR),
                ("base_mass_scale", self.base_mass_scale.into(), FACTOR),
                ("action_delay_s", self.action_delay_s.into(), delay),
                ("observation_delay_s", self.observation_delay_s.into(), delay),
            ],
        )?;
        self.check_kinds()?;
        if self.ball && !self.surfaces.is_empty() {
            let expected = "none while randomization.ball draws the same parameters";
            return Err(value_error(&format!("{TABLE}.surfaces"), expected, self.surfaces.len().to_string()));
        }
        for (i, s) in self.surfaces.iter().enumerate() {
            let table = format!("{TABLE}.surfaces.{i}");
            let damping = [
                ("linear_damping", s.linear_damping.into(), DAMPING),
                ("angular_damping", s.angular_damping.into(), DAMPING),
            ];
            check(&table, &damping)?;
            check_material(&table, &s.material())?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::TaskPreset;

    fn surface() -> SurfacePreset {
        SurfacePreset::of("hard", &BallParams::default())
    }

    #[test]
    fn surfaces_scatter_by_the_relative_deviation_and_stay_physical() {
        let (mut rng, n) = (Rng::new(3, 0, 0), 4000);
        let draws: Vec<_> = (0..n).map(|_| surface().perturbed(0.1, &mut rng)).collect();
        let spread = |of: fn(&SurfacePreset) -> f64| {
            let mean = draws.iter().map(of).sum::<f64>() / f64::from(n);
            let variance = draws.iter().map(|s| (of(s) - mean).powi(2)).sum::<f64>() / f64::from(n);
            (mean, variance.sqrt() / mean)
        };
        for (of, nominal) in [(|s: &SurfacePreset| s.angular_damping) as fn(&_) -> f64, |s| s.static_friction]
            .into_iter()
            .zip([4.28, 0.77])
        {
            let (mean, relative) = spread(of);
            assert!(
                (mean / nominal - 1.0).abs() < 0.01 && (relative - 0.1).abs() < 0.005,
                "{mean} {relative}"
            );
        }
        for s in (0..2000).map(|_| surface().perturbed(1.0, &mut rng)) {
            assert!((0.0..=1.0).contains(&s.restitution) && s.dynamic_friction <= s.static_friction);
            assert!(s.dynamic_friction >= 0.0 && s.angular_damping >= 0.0 && s.linear_damping >= 0.0);
        }
    }

    #[test]
    fn values_out_of_range_are_refused_by_key() {
        for (set, hint) in [
            ("randomization.action_delay_s=[0, 0.03]", "randomization.action_delay_s"),
            ("action_delay_s=0.03", "action_delay_s is 0.03, expected 0 to the control period"),
            ("randomization.real_ball_share=2", "real_ball_share"),
            ("randomization.gain_scale=[0, 1]", "randomization.gain_scale"),
            ("randomization.surface_deviation=-1", "surface_deviation"),
            ("randomization.ball_contact_time_s=[0, 0.06]", "expected 0 to 0.05"),
            ("randomization.foot_flatness=[0, 2]", "foot_flatness"),
            ("randomization.pd_implicitness=[-0.1, 1]", "pd_implicitness"),
            ("randomization.convex_share=2", "convex_share"),
            ("randomization.sole_scale=[1.2, 0.9]", "sole_scale"),
            ("randomization.surfaces=[{name=\"x\"}]", "static_friction"),
        ] {
            let error =
                TaskPreset::builtin_with("paper_stage2", &[set.to_owned()]).expect_err(set).to_string();
            assert!(error.contains(hint), "{set}: {error}");
        }
    }
}
