//! How soft a contact is, and what else may differ in kind between contacts.

use serde::{Deserialize, Serialize};

/// Spring and damper between two surfaces: the gap `x` of a contact obeys `x'' = -2 x'/t - x/(t z)^2` as long as that pushes,
/// with time constant `t` and damping ratio `z`.
///
/// The masses do not enter: the same numbers give a light and a heavy ball the same motion, as in MuJoCo, whose `solref` has nearly
/// this meaning. At a ratio of 1 a contact lasts `2 t` and returns `e^-2` of the approach speed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Compliance {
    /// Time constant `[s]`; below [`Compliance::LEAST_TIME_S`] the contact is hard: one step long, with the restitution and the
    /// friction of the [`Material`](crate::Material)s.
    pub time_constant_s: f64,
    /// Damping ratio, within [`Compliance::RATIOS`]; smaller ones bounce more. The restitution of the materials does not count.
    pub damping_ratio: f64,
}

impl Compliance {
    /// One step long, the engine's usual contact.
    pub const HARD: Self = Self { time_constant_s: 0.0, damping_ratio: 1.0 };
    /// The shortest time constant that is not hard `[s]`: shorter contacts end within one physics step.
    pub const LEAST_TIME_S: f64 = 0.002;
    /// Damping ratios; values beyond count as the nearest. A ratio of 0.01 returns 97% of the approach speed, and one above 1
    /// would only lengthen the contact.
    pub const RATIOS: [f64; 2] = [0.01, 1.0];

    /// The formulas divide by the angular frequency, which a ratio of 1 makes zero.
    const LARGEST_RATIO: f64 = 0.999;

    /// The contact of time constant `time_constant_s` `[s]` that returns the share `restitution` of the approach speed, as near as
    /// [`Compliance::RATIOS`] allow.
    ///
    /// ```
    /// use paid_physics::Compliance;
    ///
    /// let bouncing = Compliance::returning(0.02, 0.6);
    /// assert!((bouncing.restitution() - 0.6).abs() < 1e-6);
    /// // A spring without bounce still pushes while the surfaces part.
    /// assert!((Compliance::returning(0.02, 0.0).restitution() - 0.135).abs() < 1e-3);
    /// ```
    #[must_use]
    pub fn returning(time_constant_s: f64, restitution: f64) -> Self {
        let of = |damping_ratio| Self { time_constant_s: 1.0, damping_ratio }.restitution();
        let [mut bouncing, mut dead] = Self::RATIOS;
        for _ in 0..40 {
            let middle = 0.5 * (bouncing + dead);
            if of(middle) < restitution {
                dead = middle;
            } else {
                bouncing = middle;
            }
        }
        Self { time_constant_s, damping_ratio: 0.5 * (bouncing + dead) }
    }

    /// The contact that returns the share `restitution` of the approach speed after `time_s` `[s]`, see [`Compliance::lasts_s`].
    ///
    /// ```
    /// use paid_physics::Compliance;
    ///
    /// // A match ball on a wall.
    /// let filmed = Compliance::lasting(0.0065, 0.845);
    /// assert!((filmed.lasts_s() - 0.0065).abs() < 1e-9 && (filmed.restitution() - 0.845).abs() < 1e-6);
    /// ```
    #[must_use]
    pub fn lasting(time_s: f64, restitution: f64) -> Self {
        let unit = Self::returning(1.0, restitution);
        Self { time_constant_s: time_s / unit.lasts_s(), ..unit }
    }

    /// True if the contact takes time.
    pub fn is_soft(&self) -> bool {
        self.time_constant_s >= Self::LEAST_TIME_S
    }

    /// Rate of decay `a = 1/t` and angular frequency `w = a sqrt(1/z^2 - 1)` `[1/s]` of a soft contact.
    pub(crate) fn rates(&self) -> [f64; 2] {
        let ratio = self.damping_ratio.clamp(Self::RATIOS[0], Self::LARGEST_RATIO);
        let a = 1.0 / self.time_constant_s;
        [a, a * (1.0 / (ratio * ratio) - 1.0).sqrt()]
    }

    /// Time from first contact until the spring lets go `[s]`; 0 if it is hard.
    ///
    /// From `x = 0` at speed `v` the speed is `x' = v e^(-a s) (cos w s - a/w sin w s)`; the force ends where `x'' = 0`, that is where
    /// `tan w s = 2 a w / (a^2 - w^2)`.
    pub fn lasts_s(&self) -> f64 {
        if self.time_constant_s <= 0.0 {
            return 0.0;
        }
        let [a, w] = self.rates();
        (2.0 * a * w).atan2(a * a - w * w) / w
    }

    /// Share of the approach speed that a soft contact returns; 0 if it is hard.
    pub fn restitution(&self) -> f64 {
        if self.time_constant_s <= 0.0 {
            return 0.0;
        }
        let ([a, w], time) = (self.rates(), self.lasts_s());
        let (s, c) = (w * time).sin_cos();
        (-a * time).exp() * (a / w * s - c)
    }
}

impl Default for Compliance {
    fn default() -> Self {
        Self::HARD
    }
}

/// Softness of the contacts of one environment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ContactCompliance {
    /// Ball and robot.
    pub ball_robot: Compliance,
    /// Ball and ground.
    pub ball_ground: Compliance,
    /// Soles and ground.
    pub sole_ground: Compliance,
}

/// The friction cone of the ball's contacts; the default is Coulomb's.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Cone {
    /// The sum of the two tangential forces is limited instead of their length; the axes are those of MuJoCo's pyramid.
    pub pyramid: bool,
    /// Sliding lifts, as in MuJoCo and all engines whose contacts minimize energy: surfaces that slip at `u` part at
    /// friction times `u`.
    pub convex: bool,
}

/// How the soles of one environment differ from the model's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SoleShape {
    /// Factor on the distances of a sole's points from their mean, along the foot.
    pub length_scale: f64,
    /// The same across the foot.
    pub width_scale: f64,
    /// Added to the radius of the points `[m]`; their centers rise as much, so that the lowest points stay.
    pub rounding_m: f64,
}

impl Default for SoleShape {
    fn default() -> Self {
        Self { length_scale: 1.0, width_scale: 1.0, rounding_m: 0.0 }
    }
}

/// What differs in kind between the contacts and controllers of environments; the default is the engine's usual kind.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ContactKind {
    /// Softness.
    pub compliance: ContactCompliance,
    /// Torsional and rolling friction of the ball `[m]`: the greatest moment about the contact's normal and across it, per normal
    /// force. The robot does not feel these moments.
    pub ball_spin_friction_m: [f64; 2],
    /// Friction cone of the ball.
    pub cone: Cone,
    /// Shape of the soles.
    pub sole: SoleShape,
    /// Shape of a foot as the ball meets it: 0 is the model's `collision` capsule, 1 the flat plate that its sole's points span
    /// (the largest rectangle within them, rounded by their radius); between them every length is mixed.
    pub foot_flatness: f64,
    /// Share of the coming step that joint controllers know of: 1 implicit (torques of the step's end), 0 explicit (of its
    /// start). Explicit control of 2 ms steps is near 0.4 at steps of 5 ms.
    pub pd_implicitness: f64,
}

impl Default for ContactKind {
    fn default() -> Self {
        Self {
            compliance: ContactCompliance::default(),
            ball_spin_friction_m: [0.0; 2],
            cone: Cone::default(),
            sole: SoleShape::default(),
            foot_flatness: 0.0,
            pd_implicitness: 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_critically_damped_contact_lasts_twice_its_time_and_returns_the_square_of_1_over_e() {
        let contact = Compliance { time_constant_s: 0.02, damping_ratio: 1.0 };
        assert!((contact.lasts_s() - 0.04).abs() < 1e-4, "{}", contact.lasts_s());
        assert!((contact.restitution() - (-2.0_f64).exp()).abs() < 1e-3, "{}", contact.restitution());
        assert_eq!((Compliance::HARD.lasts_s(), Compliance::HARD.restitution()), (0.0, 0.0));
    }

    #[test]
    fn a_wanted_restitution_is_found_within_the_range() {
        for e in [0.2, 0.6, 0.85, 0.95] {
            assert!((Compliance::returning(0.01, e).restitution() - e).abs() < 1e-6, "{e}");
        }
        assert!(Compliance::returning(0.01, 0.0).damping_ratio > 0.999);
        assert!(Compliance::returning(0.01, 1.0).damping_ratio < 0.011);
    }

    #[test]
    fn a_kind_of_an_earlier_version_is_the_usual_one() {
        let kind: ContactKind = serde_json::from_str("{}").expect("every value has a default");
        assert_eq!(kind, ContactKind::default());
    }
}
