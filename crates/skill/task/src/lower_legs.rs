//! The shapes of feet and shins, for the gap between the legs.

use paid_lanes::{Real, Vec3};
use paid_motion::check::{lower_leg, rod};
use paid_physics::{GroupState, nearest_points};
use paid_robot::RobotModel;

/// A `collision` shape of a body as a segment with a radius, in the body's frame `[m]`.
#[derive(Clone, Debug)]
struct LegShape {
    body: usize,
    ends: [[f64; 3]; 2],
    radius: f64,
    length2: f64,
    inv_length2: f64,
}

/// The `collision` shapes of both lower legs.
#[derive(Clone, Debug)]
pub(crate) struct LowerLegs([Vec<LegShape>; 2]);

impl LowerLegs {
    /// Of the legs that end in these bodies.
    pub(crate) fn new(robot: &RobotModel, feet: [usize; 2]) -> Self {
        Self(
            feet.map(|foot| {
                lower_leg(robot, foot).into_iter().flat_map(|body| shapes(robot, body)).collect()
            }),
        )
    }

    /// The least distance of the legs' surfaces `[m]`, negative where they overlap; infinite if one has no shapes.
    #[inline(always)]
    pub(crate) fn gap<V: Real>(&self, state: &GroupState<V>) -> V {
        let ends = |shape: &LegShape| {
            let body = &state.bodies[shape.body];
            shape.ends.map(|end| body.pos + body.rot.mul_vec(Vec3(end.map(V::c))))
        };
        let mut least = V::c(f64::INFINITY);
        for a in &self.0[0] {
            let on_left = ends(a);
            for b in &self.0[1] {
                let length2 = [V::c(a.length2), V::c(b.length2)];
                let inv_length2 = [V::c(a.inv_length2), V::c(b.inv_length2)];
                let [p, q] = nearest_points(&on_left, &ends(b), length2, inv_length2);
                least = least.min((p - q).norm() - V::c(a.radius + b.radius));
            }
        }
        least
    }
}

fn shapes(robot: &RobotModel, body: usize) -> impl Iterator<Item = LegShape> {
    let collides = robot.bodies[body].geoms.iter().filter(|geom| geom.class == "collision");
    collides.map(move |geom| {
        let (a, b, radius) = rod(&geom.shape);
        let length2 = (Vec3(b) - Vec3(a)).norm2();
        let inv_length2 = if length2 < 1e-12 { 0.0 } else { 1.0 / length2 };
        LegShape { body, ends: [a, b], radius, length2, inv_length2 }
    })
}
