//! Physical parameters, one value a lane, and how two surfaces become one contact.

use paid_lanes::{Real, Vec3};

use super::block::Friction;
use crate::{BallParams, Combine, EnvParams, Material, SceneConfig};

/// Coefficients of a contact between two surfaces.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surface<V> {
    pub static_friction: V,
    pub dynamic_friction: V,
    pub restitution: V,
}

impl<V: Real> Surface<V> {
    /// Coulomb friction of a contact of one point.
    #[inline(always)]
    pub fn friction(&self) -> Friction<V> {
        Friction { stick: self.static_friction, slide: self.dynamic_friction }
    }
    fn new(m: Material) -> Self {
        Self {
            static_friction: V::c(m.static_friction),
            dynamic_friction: V::c(m.dynamic_friction),
            restitution: V::c(m.restitution),
        }
    }
    fn set_lane(&mut self, lane: usize, m: Material) {
        self.static_friction.set_lane(lane, m.static_friction);
        self.dynamic_friction.set_lane(lane, m.dynamic_friction);
        self.restitution.set_lane(lane, m.restitution);
    }
}

fn combine_values(rule: Combine, a: f64, b: f64) -> f64 {
    match rule {
        Combine::Average => 0.5 * (a + b),
        Combine::Min => a.min(b),
        Combine::Multiply => a * b,
        Combine::Max => a.max(b),
    }
}

/// The surface of a contact: friction and restitution combined by their rules; a dynamic coefficient above the static
/// one raises it.
pub(crate) fn combine(a: Material, b: Material, friction: Combine, restitution: Combine) -> Material {
    let raised = |m: Material| m.static_friction.max(m.dynamic_friction);
    let dynamic_friction = combine_values(friction, a.dynamic_friction, b.dynamic_friction);
    Material {
        static_friction: combine_values(friction, raised(a), raised(b)).max(dynamic_friction),
        dynamic_friction,
        restitution: combine_values(restitution, a.restitution, b.restitution),
    }
}

/// Ball constants, one value a lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BallLanes<V> {
    pub radius: V,
    pub inv_mass: V,
    pub inv_inertia: V,
    /// Velocity factors of a physics step.
    pub linear_keep: V,
    pub angular_keep: V,
}

/// [`EnvParams`] of a group, prepared for stepping.
#[derive(Clone, Debug)]
pub(crate) struct GroupParams<V> {
    pub lanes: Vec<EnvParams>,
    pub base_com_offset: Vec3<V>,
    /// Per body; `None` while every lane has the model's masses.
    pub mass_scale: Option<Vec<V>>,
    pub gain_scale: [V; 2],
    pub terrain_offset: [V; 2],
    pub ball: BallLanes<V>,
    pub robot_ground: Surface<V>,
    pub ball_ground: Surface<V>,
    pub ball_robot: Surface<V>,
}

impl<V: Real> GroupParams<V> {
    pub fn new(scene: &SceneConfig, bodies: usize) -> Self {
        let zero = Material { static_friction: 0.0, dynamic_friction: 0.0, restitution: 0.0 };
        let z = V::zero();
        let ball = BallLanes {
            radius: V::one(),
            inv_mass: V::one(),
            inv_inertia: V::one(),
            linear_keep: V::one(),
            angular_keep: V::one(),
        };
        let mut params = Self {
            lanes: vec![EnvParams::default(); V::LANES],
            base_com_offset: Vec3::zero(),
            mass_scale: None,
            gain_scale: [V::one(); 2],
            terrain_offset: [z; 2],
            ball,
            robot_ground: Surface::new(zero),
            ball_ground: Surface::new(zero),
            ball_robot: Surface::new(zero),
        };
        for lane in 0..V::LANES {
            params.set_lane(lane, &EnvParams::default(), scene, bodies);
        }
        params
    }

    fn set_ball(&mut self, lane: usize, b: &BallParams, dt: f64) {
        let ball = &mut self.ball;
        ball.radius.set_lane(lane, b.radius_m);
        ball.inv_mass.set_lane(lane, 1.0 / b.mass_kg);
        ball.inv_inertia.set_lane(lane, 1.0 / (b.inertia_factor * b.mass_kg * b.radius_m * b.radius_m));
        ball.linear_keep.set_lane(lane, (1.0 - b.linear_damping * dt).max(0.0));
        ball.angular_keep.set_lane(lane, (1.0 - b.angular_damping * dt).max(0.0));
    }

    /// Takes over the parameters of one lane. `mass_scale` must be empty or have one value a body.
    pub fn set_lane(&mut self, lane: usize, p: &EnvParams, scene: &SceneConfig, bodies: usize) {
        assert!(
            p.mass_scale.is_empty() || p.mass_scale.len() == bodies,
            "mass_scale: expected 0 or {bodies} values, found {}",
            p.mass_scale.len()
        );
        self.base_com_offset.set_lane(lane, p.base_com_offset);
        for k in 0..2 {
            self.gain_scale[k].set_lane(lane, p.gain_scale[k]);
            self.terrain_offset[k].set_lane(lane, p.terrain_offset[k]);
        }
        if !p.mass_scale.is_empty() || self.mass_scale.is_some() {
            let scale = self.mass_scale.get_or_insert_with(|| vec![V::one(); bodies]);
            for (b, s) in scale.iter_mut().enumerate() {
                s.set_lane(lane, p.mass_scale.get(b).copied().unwrap_or(1.0));
            }
        }
        self.set_ball(lane, &p.ball, scene.physics_dt_s);
        // The robot's and the ball's rule is `average`, the lowest: the ground's always holds against it.
        let with_ground =
            |m| combine(m, scene.ground, scene.ground_friction_combine, scene.ground_restitution_combine);
        self.robot_ground.set_lane(lane, with_ground(p.robot));
        self.ball_ground.set_lane(lane, with_ground(p.ball.material));
        let average = Combine::Average;
        self.ball_robot.set_lane(lane, combine(p.ball.material, p.robot, average, average));
        self.lanes[lane] = p.clone();
    }
}

#[cfg(test)]
mod tests {
    use super::combine;
    use crate::{Combine, Material};

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
            let got = combine(A, B, rule, rule);
            assert!((got.static_friction - static_friction).abs() < 1e-12, "{rule:?}: {got:?}");
            assert!((got.dynamic_friction - dynamic_friction).abs() < 1e-12, "{rule:?}: {got:?}");
            assert!((got.restitution - restitution).abs() < 1e-12, "{rule:?}: {got:?}");
        }
    }

    #[test]
    fn friction_and_restitution_follow_their_own_rules() {
        let got = combine(A, B, Combine::Min, Combine::Multiply);
        assert!((got.dynamic_friction - 0.4).abs() < 1e-12);
        assert!((got.restitution - 0.4).abs() < 1e-12);
    }
}
