//! Surfaces, and how two of them make a contact.

use serde::{Deserialize, Serialize};

/// Coefficients of a surface, or of the contact that two surfaces make (PhysX's material model).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// Coulomb coefficient up to which a contact sticks.
    pub static_friction: f64,
    /// Coulomb coefficient while sliding. If it is above the static one, it raises the static one.
    pub dynamic_friction: f64,
    /// Share of the normal approach speed that a bounce returns.
    pub restitution: f64,
}

/// How the coefficients of two touching surfaces become one. Of two surfaces' rules, the later variant wins, as in PhysX.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Combine {
    /// (a + b) / 2.
    Average,
    /// The smaller.
    Min,
    /// a b.
    Multiply,
    /// The larger.
    Max,
}

impl Combine {
    /// One coefficient from those of two surfaces.
    pub fn apply(self, a: f64, b: f64) -> f64 {
        match self {
            Self::Average => 0.5 * (a + b),
            Self::Min => a.min(b),
            Self::Multiply => a * b,
            Self::Max => a.max(b),
        }
    }
}

impl Material {
    /// The contact of this surface with `other`, friction and restitution each by their rule.
    ///
    /// ```
    /// use paid_physics::{Combine, Material};
    ///
    /// let ball = Material { static_friction: 0.77, dynamic_friction: 0.07, restitution: 0.75 };
    /// let turf = Material { static_friction: 1.0, dynamic_friction: 1.0, restitution: 0.8 };
    /// let contact = ball.against(turf, Combine::Multiply, Combine::Multiply);
    /// assert_eq!(contact.static_friction, 0.77);
    /// assert!((contact.restitution - 0.6).abs() < 1e-12);
    /// ```
    #[must_use]
    pub fn against(self, other: Self, friction: Combine, restitution: Combine) -> Self {
        let raised = |m: Self| m.static_friction.max(m.dynamic_friction);
        let dynamic_friction = friction.apply(self.dynamic_friction, other.dynamic_friction);
        Self {
            static_friction: friction.apply(raised(self), raised(other)).max(dynamic_friction),
            dynamic_friction,
            restitution: restitution.apply(self.restitution, other.restitution),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: Material = Material { static_friction: 0.8, dynamic_friction: 0.6, restitution: 0.5 };
    const B: Material = Material { static_friction: 0.2, dynamic_friction: 0.4, restitution: 0.8 };

    #[test]
    fn every_rule_combines_two_surfaces() {
        // B's dynamic coefficient of 0.4 raises its static one.
        for (rule, static_friction, dynamic_friction, restitution) in [
            (Combine::Average, 0.6, 0.5, 0.65),
            (Combine::Min, 0.4, 0.4, 0.5),
            (Combine::Multiply, 0.32, 0.24, 0.4),
            (Combine::Max, 0.8, 0.6, 0.8),
        ] {
            let got = A.against(B, rule, rule);
            assert!((got.static_friction - static_friction).abs() < 1e-12, "{rule:?}: {got:?}");
            assert!((got.dynamic_friction - dynamic_friction).abs() < 1e-12, "{rule:?}: {got:?}");
            assert!((got.restitution - restitution).abs() < 1e-12, "{rule:?}: {got:?}");
        }
    }

    #[test]
    fn friction_and_restitution_follow_their_own_rules() {
        let got = A.against(B, Combine::Min, Combine::Multiply);
        assert!((got.dynamic_friction - 0.4).abs() < 1e-12);
        assert!((got.restitution - 0.4).abs() < 1e-12);
    }
}
