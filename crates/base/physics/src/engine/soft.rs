//! Ground under everything but the soles: implicit springs and dampers for falls and for lying.

use paid_lanes::{Mask, Real, Vec3};

use super::articulated::Articulated;
use super::forces::BodyForces;
use super::group::Group;
use super::layout::ModelLayout;
use super::solver::SOLVER;
use super::spatial::Motion;
use super::step::Constants;

/// Adds the ground's reaction on a body's shapes to its articulated inertia, and the estimated force to `forces`.
#[allow(clippy::too_many_arguments)]
#[inline(always)]
pub(crate) fn ground_contact<V: Real>(
    layout: &ModelLayout<V::Scalar>,
    constants: &Constants<V>,
    g: &Group<V>,
    body: usize,
    range: [usize; 2],
    ends: &[[Vec3<V>; 2]],
    vel: Motion<V>,
    art: &mut Articulated<V>,
    forces: &mut BodyForces<V>,
) {
    let zero = V::zero();
    let h = constants.dt;
    for i in range[0]..range[1] {
        let capsule = &layout.capsules[i];
        let radius = V::splat(capsule.radius);
        let count = if capsule.sphere { 1 } else { 2 };
        for end in 0..count {
            let center = ends[i][end];
            let lowest = g.pos.0[2] + center.0[2] - radius;
            let low = lowest.lt(constants.highest_ground);
            if !low.any() {
                continue;
            }
            let (height, n) =
                constants.ground.at(center.0[0] + g.pos.0[0], center.0[1] + g.pos.0[1], &g.params);
            let depth = radius - (g.pos.0[2] + center.0[2] - height) * n.0[2];
            let touching = low.and(zero.lt(depth));
            if !touching.any() {
                continue;
            }
            let p = center - n.scale(radius);
            let v = vel.at(p);
            let vn = v.dot(n);
            let stiffness = V::c(SOLVER.body_ground_stiffness);
            let ahead = stiffness.mul_add(h, V::c(SOLVER.body_ground_damping));
            let normal = ahead.neg_mul_add(vn, stiffness * depth).max(zero);
            let pressed = touching.and(zero.lt(normal));
            let normal = V::select(pressed, normal, zero);
            let slide = v - n.scale(vn);
            let speed2 =
                slide.norm2() + V::c(SOLVER.body_ground_slide_speed * SOLVER.body_ground_slide_speed);
            let viscosity = (g.params.robot_ground.dynamic_friction * normal * speed2.rsqrt())
                .min(V::c(SOLVER.body_ground_max_viscosity));
            let f = n.scale(normal) - slide.scale(viscosity);
            let along = V::select(pressed, ahead * h, zero);
            art.add_point(p, n, along, viscosity * h, f);
            forces.add(body, f, V::one());
        }
    }
}
