//! A contact of the built-in engine in MuJoCo's terms.
//!
//! This is the one conversion; the evaluation and the tests of both engines use it. MuJoCo's contact is a spring and
//! damper with one friction coefficient, so the conversion has limits:
//!
//! - **Friction.** MuJoCo does not distinguish sticking from sliding. The contact gets the dynamic coefficient: a kicked
//!   ball slides, and at the static one the damping of its spin would stop it before the goal.
//! - **Restitution.** A spring with damping ratio `z` returns the share `exp(-pi z / sqrt(1 - z^2))` of the approach speed.
//!   The ratio is kept within [`DAMPING_RATIOS`]; nothing returns more than 97%. The formula is that of a linear spring
//!   that may also pull. MuJoCo's lets go when its force ends, so a dropped ball returns more than the formula says. At
//!   steps of 2 ms: 0.13 for 0, 0.40 for 0.3, 0.66 for 0.6, 0.85 for 0.75, 0.98 for 0.9. There is no threshold of speed
//!   below which nothing bounces.
//! - **Duration.** The built-in engine's impact takes one step; the spring's takes `pi t z / sqrt(1 - z^2)` with the time
//!   constant `t`, some 10 ms for the ball. It must be at least two physics steps, or MuJoCo returns arbitrary speeds: the
//!   time constant is raised where it is too short.
//! - **Pairs.** The ball's surface decides every contact of the ball (geom priority), so it bounces off the robot as off the
//!   ground. In the built-in engine the robot's surface counts too.
//! - **Damping.** `c` of the built-in engine multiplies the velocity by `1 - c dt`; here it is the viscous force `-c m v`.

use std::f64::consts::PI;

use paid_physics::{BallParams, Compliance, ContactCompliance, ContactKind, Material, SceneConfig};

use crate::scene::{BallOptions, Cone, FloorOptions, PdControl, SceneOptions};

/// Smallest and largest damping ratio of a contact.
pub const DAMPING_RATIOS: [f64; 2] = [0.01, 1.0];

/// Damping ratio of a spring whose impact returns the share `restitution` of the approach speed, within
/// [`DAMPING_RATIOS`].
///
/// ```
/// use paid_mujoco::contact::{damping_ratio, restitution};
///
/// assert!((damping_ratio(0.6) - 0.1605).abs() < 1e-4);
/// assert!((restitution(damping_ratio(0.6)) - 0.6).abs() < 1e-12);
/// assert_eq!(damping_ratio(0.0), 1.0);
/// ```
pub fn damping_ratio(restitution: f64) -> f64 {
    if restitution <= 0.0 {
        return DAMPING_RATIOS[1];
    }
    let log = restitution.min(1.0).ln();
    (-log / log.hypot(PI)).clamp(DAMPING_RATIOS[0], DAMPING_RATIOS[1])
}

/// Share of the approach speed that a spring with this damping ratio returns; 0 for a ratio of 1 or more.
pub fn restitution(damping_ratio: f64) -> f64 {
    let z = damping_ratio;
    if z >= 1.0 { 0.0 } else { (-PI * z / (1.0 - z * z).sqrt()).exp() }
}

/// A contact in MuJoCo's terms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpringContact {
    /// Sliding friction.
    pub friction: f64,
    /// Damping ratio of the spring.
    pub damping_ratio: f64,
}

impl SpringContact {
    /// The conversion. See the [module](self) for its limits.
    pub fn of(contact: &Material) -> Self {
        Self { friction: contact.dynamic_friction, damping_ratio: damping_ratio(contact.restitution) }
    }
}

/// The shortest time constant `[s]` with which a contact of this damping ratio lasts two physics steps of `dt_s`.
pub fn least_time_constant(damping_ratio: f64, dt_s: f64) -> f64 {
    let two_steps = 2.0 * dt_s;
    let z = damping_ratio;
    // At critical damping and above there is no half period; MuJoCo itself requires a time constant of two steps.
    if z >= 1.0 { two_steps } else { two_steps.max(two_steps * (1.0 - z * z).sqrt() / (PI * z)) }
}

impl BallOptions {
    /// This ball with friction, bounce and damping of the built-in engine's ball `params` on the ground of `scene`. Time
    /// constant, impedance, torsional and rolling friction stay.
    #[must_use]
    pub fn like_builtin(self, params: BallParams, scene: &SceneConfig) -> Self {
        let contact = SpringContact::of(&scene.contact_with_ground(params.material));
        let [_, torsional, rolling] = self.friction;
        Self {
            params,
            friction: [contact.friction, torsional, rolling],
            solref: [self.solref[0], contact.damping_ratio],
            damped: true,
            ..self
        }
    }
}

impl SceneOptions {
    /// Raises the time constants of ball and floor where their contacts would last less than two physics steps.
    pub fn resolve_contacts(&mut self) {
        let dt = self.physics_dt_s;
        let resolve = |solref: &mut [f64; 2]| solref[0] = solref[0].max(least_time_constant(solref[1], dt));
        resolve(&mut self.floor.solref);
        if let Some(ball) = &mut self.ball {
            resolve(&mut ball.solref);
        }
    }

    /// This scene with the built-in engine's ball on its ground: [`BallOptions::like_builtin`], in contacts that last at
    /// least two physics steps.
    #[must_use]
    pub fn with_builtin_ball(mut self, params: BallParams, scene: &SceneConfig) -> Self {
        self.ball = Some(self.ball.unwrap_or_default().like_builtin(params, scene));
        self.resolve_contacts();
        self
    }
}

impl FloorOptions {
    /// This floor with friction and bounce that `robot` has on the ground of `scene` in the built-in engine.
    #[must_use]
    pub fn like_builtin(self, robot: Material, scene: &SceneConfig) -> Self {
        let contact = SpringContact::of(&scene.contact_with_ground(robot));
        let [_, torsional, rolling] = self.friction;
        Self {
            friction: [contact.friction, torsional, rolling],
            solref: [self.solref[0], contact.damping_ratio],
        }
    }
}

/// The surface that gives contacts of ball and robot the friction of MuJoCo's ball in the built-in engine, and no bounce where
/// they are hard. It is the surface of both.
pub fn builtin_surface(scene: &SceneOptions) -> Material {
    let [friction, ..] = scene.ball.unwrap_or_default().friction;
    Material { static_friction: friction, dynamic_friction: friction, restitution: 0.0 }
}

/// The built-in engine's spring and damper for a contact of MuJoCo with this `solref` and this impedance at full depth.
///
/// MuJoCo's reference acceleration is `-b v - k x` with `b = 2 / (d t)` and `k = 1 / (d t^2 z^2)` at full depth (MuJoCo's documentation,
/// "Computation: constraint model"), the built-in engine's `b = 2 / t` and `k = 1 / (t z)^2`.
pub fn builtin_compliance([time_constant_s, damping_ratio]: [f64; 2], impedance: f64) -> Compliance {
    Compliance {
        time_constant_s: impedance * time_constant_s,
        damping_ratio: (damping_ratio / impedance.sqrt()).clamp(Compliance::RATIOS[0], Compliance::RATIOS[1]),
    }
}

/// The kind of contacts and controllers with which the built-in engine at physics steps of `dt_s` comes nearest to `scene`.
pub fn builtin_kind(scene: &SceneOptions, dt_s: f64) -> ContactKind {
    /// MuJoCo's impedance at full depth where a geom does not say another.
    const IMPEDANCE: f64 = 0.95;
    let ball = scene.ball.unwrap_or_default();
    let on_ball = builtin_compliance(ball.solref, ball.solimp[1]);
    let compliance = ContactCompliance {
        ball_robot: on_ball,
        ball_ground: on_ball,
        sole_ground: builtin_compliance(scene.floor.solref, IMPEDANCE),
    };
    ContactKind {
        compliance,
        ball_spin_friction_m: [ball.friction[1], ball.friction[2]],
        cone: paid_physics::Cone { pyramid: scene.cone == Cone::Pyramidal, convex: true },
        pd_implicitness: match scene.pd {
            PdControl::Implicit => 1.0,
            PdControl::Explicit => explicit_share(scene.physics_dt_s, dt_s),
        },
        ..ContactKind::default()
    }
}

/// The implicitness with which a step of `dt_s` damps a joint as explicit steps of `fine_s` do.
///
/// For a joint without load whose controller has damping ratio 2 and natural frequency 10 Hz (`c = 4 w`): `n` explicit steps leave
/// `(1 - c h / n)^n` of its speed, one step with implicitness `s` leaves `(1 - (1 - s) c h) / (1 + s c h)`.
fn explicit_share(fine_s: f64, dt_s: f64) -> f64 {
    let rate = 4.0 * std::f64::consts::TAU * 10.0;
    let keep = (1.0 - rate * fine_s).max(0.0).powf(dt_s / fine_s);
    let x = rate * dt_s;
    ((keep - 1.0 + x) / (x * (1.0 - keep))).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use paid_physics::Combine;

    #[test]
    fn the_damping_ratio_returns_the_restitution() {
        for e in [0.1, 0.5, 0.6, 0.75, 0.9] {
            assert!((restitution(damping_ratio(e)) - e).abs() < 1e-12, "{e}");
        }
        // A spring with ratio 0.5 gives back exp(-pi 0.5 / sqrt(0.75)) = 0.163.
        assert!((damping_ratio(0.163) - 0.5).abs() < 1e-3);
    }

    #[test]
    fn out_of_range_restitutions_give_the_ends_of_the_range() {
        assert_eq!([1.0, 2.0].map(damping_ratio), [0.01; 2]);
        assert_eq!([0.0, -1.0].map(damping_ratio), [1.0; 2]);
        assert!(damping_ratio(1e-300) < 1.0);
    }

    #[test]
    fn a_contact_lasts_at_least_two_steps() {
        let duration = |t: f64, z: f64| PI * t * z / (1.0 - z * z).sqrt();
        for z in [0.01, 0.0912, 0.16, 0.3] {
            let t = least_time_constant(z, 0.002);
            assert!((duration(t, z) - 0.004).abs() < 1e-12, "{z}: {t}");
        }
        assert_eq!([0.5, 1.0].map(|z| least_time_constant(z, 0.002)), [0.004; 2]);
    }

    #[test]
    fn a_scene_resolves_its_contacts_and_leaves_long_ones() {
        let mut scene = SceneOptions::default();
        scene.resolve_contacts();
        assert_eq!(scene, SceneOptions::default());
        scene.physics_dt_s = 0.02;
        scene.resolve_contacts();
        assert_eq!((scene.floor.solref[0], scene.ball.map(|b| b.solref[0])), (0.04, Some(0.04)));
    }

    #[test]
    fn the_ball_takes_the_contact_that_it_has_on_the_ground() {
        let mut scene = SceneConfig {
            ground_friction_combine: Combine::Multiply,
            ground_restitution_combine: Combine::Multiply,
            ..SceneConfig::default()
        };
        scene.ground = Material { static_friction: 1.0, dynamic_friction: 0.5, restitution: 0.8 };
        let params = BallParams::default();
        let ball = BallOptions::default().like_builtin(params, &scene);
        assert_eq!(ball.friction[0], 0.07 * 0.5);
        assert!((restitution(ball.solref[1]) - 0.75 * 0.8).abs() < 1e-12);
        let usual = BallOptions::default();
        assert_eq!(
            (ball.solref[0], &ball.friction[1..], ball.solimp),
            (usual.solref[0], &usual.friction[1..], usual.solimp)
        );
        assert!(ball.damped);
        let steel = Material { static_friction: 1.0, dynamic_friction: 0.6, restitution: 0.0 };
        let floor = FloorOptions::default().like_builtin(steel, &scene);
        assert_eq!((floor.friction[0], floor.solref), (0.6 * 0.5, [0.01, 1.0]));
    }
}
