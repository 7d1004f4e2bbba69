//! Whole-body balance of a clip: center of mass, zero-moment point, support polygon.

use paid_lanes::{Mat3, Quat, Vec3};
use paid_robot::RobotModel;

use crate::{Clip, rotation_log};

/// Standard gravity `[m/s^2]`.
pub const GRAVITY: f64 = 9.81;

/// Balance of one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Balance {
    /// Center of mass of the whole robot, world `[m]`.
    pub com: [f64; 3],
    /// Force that the ground must give, world axes `[N]`.
    pub force: [f64; 3],
    /// Zero-moment point on the floor (z = 0), world x, y `[m]`; the center of pressure if it is inside the support.
    pub zmp: [f64; 2],
    /// Moment about the vertical through `zmp` that the ground must give `[N m]`.
    pub yaw_moment: f64,
}

/// Balance of every frame, from masses, inertias and second differences of the body poses (Newton and Euler for all bodies
/// together; the zero-moment point is where the ground's moment has no horizontal part, Vukobratovic 1972). Before its
/// first and after its last frame the robot is taken to stand still.
pub fn balance(clip: &Clip, model: &RobotModel) -> Vec<Balance> {
    let dt = 1.0 / clip.fps;
    let coms: Vec<Vec<Vec3<f64>>> = (0..clip.frames).map(|t| centers(clip, model, t)).collect();
    // Angular momentum about each body's own center, between frames t and t + 1.
    let spins: Vec<Vec3<f64>> = (0..clip.frames - 1).map(|t| spin(clip, model, t, dt)).collect();
    (0..clip.frames)
        .map(|t| {
            let (before, after) = (&coms[t.saturating_sub(1)], &coms[(t + 1).min(clip.frames - 1)]);
            let spin_before = if t > 0 { spins[t - 1] } else { Vec3::zero() };
            let spin_after = spins.get(t).copied().unwrap_or(Vec3::zero());
            let mut moment = (spin_after - spin_before).scale(1.0 / dt);
            let (mut force, mut com, mut mass) = (Vec3::zero(), Vec3::zero(), 0.0);
            for (i, body) in model.bodies.iter().enumerate() {
                let c = coms[t][i];
                let acc = (after[i] - c - (c - before[i])).scale(1.0 / (dt * dt));
                let f = (acc + Vec3([0.0, 0.0, GRAVITY])).scale(body.mass);
                force += f;
                moment = c.cross_add(f, moment);
                com += c.scale(body.mass);
                mass += body.mass;
            }
            // moment = p x force + yaw moment, with p on the floor.
            let [fx, fy, fz] = force.0;
            let lift = if fz.abs() > 1e-6 { fz } else { 1e-6 };
            let zmp = [-moment.y() / lift, moment.x() / lift];
            let yaw_moment = moment.z() - (zmp[0] * fy - zmp[1] * fx);
            Balance { com: com.scale(1.0 / mass).0, force: force.0, zmp, yaw_moment }
        })
        .collect()
}

fn centers(clip: &Clip, model: &RobotModel, t: usize) -> Vec<Vec3<f64>> {
    let (pos, quat) = (clip.body_pos(t), clip.body_quat(t));
    model
        .bodies
        .iter()
        .enumerate()
        .map(|(i, body)| Quat(quat[i]).rotate(Vec3(body.com)) + Vec3(pos[i]))
        .collect()
}

fn spin(clip: &Clip, model: &RobotModel, t: usize, dt: f64) -> Vec3<f64> {
    let (from, to) = (clip.body_quat(t), clip.body_quat(t + 1));
    let mut total = Vec3::zero();
    for (i, body) in model.bodies.iter().enumerate() {
        let omega = Vec3(rotation_log(from[i], to[i])).scale(1.0 / dt);
        let [xx, yy, zz, xy, xz, yz] = body.inertia;
        let inertia = Mat3([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]);
        for q in [from[i], to[i]] {
            let rot = Quat(q).to_mat();
            total += rot.mul_vec(inertia.mul_vec(rot.tr_mul_vec(omega))).scale(0.5);
        }
    }
    total
}

/// The convex hull of points on the floor, counterclockwise (Andrew's monotone chain).
pub fn hull(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    sorted.dedup();
    if sorted.len() < 3 {
        return sorted;
    }
    let half = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for p in points {
            while let [.., a, b] = chain[..] {
                if (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) > 0.0 {
                    break;
                }
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let mut chain = half(&mut sorted.iter().copied());
    chain.extend(half(&mut sorted.iter().rev().copied()));
    chain
}

/// How far a point of the floor is inside the convex hull of `support`; negative: the distance outside `[m]`.
/// Minus infinity without any support.
pub fn support_margin(support: &[[f64; 2]], point: [f64; 2]) -> f64 {
    let corners = hull(support);
    let mut inside = f64::INFINITY;
    let mut distance = f64::INFINITY;
    for (i, &a) in corners.iter().enumerate() {
        let b = corners[(i + 1) % corners.len()];
        let (ex, ey) = (b[0] - a[0], b[1] - a[1]);
        let (px, py) = (point[0] - a[0], point[1] - a[1]);
        let length2 = ex * ex + ey * ey;
        let along = if length2 > 0.0 { ((px * ex + py * ey) / length2).clamp(0.0, 1.0) } else { 0.0 };
        distance = distance.min((px - along * ex).hypot(py - along * ey));
        inside = inside.min((ex * py - ey * px) / length2.sqrt().max(1e-12));
    }
    if corners.len() > 2 && inside >= 0.0 { inside } else { -distance }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{model, steady_clip};

    #[test]
    fn a_robot_at_constant_velocity_presses_below_its_center_of_mass() {
        let clip = steady_clip(21, 50.0, 0.0);
        for b in &balance(&clip, &model())[1..20] {
            assert!((b.zmp[0] - b.com[0]).abs() < 1e-9 && (b.zmp[1] - b.com[1]).abs() < 1e-9);
            assert!((b.force[2] - 3.0 * GRAVITY).abs() < 1e-6 && b.yaw_moment.abs() < 1e-9);
        }
    }

    #[test]
    fn acceleration_moves_the_pressure_backwards_by_height_over_gravity() {
        let mut clip = steady_clip(21, 50.0, 0.0);
        for t in 0..21 {
            for i in 0..3 {
                let time = t as f64 / 50.0;
                clip.body_pos[t * 3 + i] = [0.5 * 2.0 * time * time, 0.0, 0.5];
            }
        }
        let b = balance(&clip, &model())[10];
        assert!((b.zmp[0] - (b.com[0] - b.com[2] * 2.0 / GRAVITY)).abs() < 1e-9, "{b:?}");
        assert!((b.force[0] - 6.0).abs() < 1e-9);
    }

    #[test]
    fn a_rotor_that_speeds_up_needs_a_moment() {
        let mut clip = steady_clip(21, 50.0, 0.0);
        for t in 0..21 {
            let angle = 0.5 * 3.0 * (t as f64 / 50.0_f64).powi(2);
            for i in 0..3 {
                clip.body_pos[t * 3 + i] = [0.0, 0.0, 0.5];
                // Turn only the trunk, whose center of mass lies on the axis.
                let about_z = [(0.5 * angle).cos(), 0.0, 0.0, (0.5 * angle).sin()];
                clip.body_quat[t * 3 + i] = if i == 0 { about_z } else { [1.0, 0.0, 0.0, 0.0] };
            }
        }
        let b = balance(&clip, &model())[10];
        assert!((b.yaw_moment - 0.01 * 3.0).abs() < 1e-9, "inertia 0.01 at 3 rad/s^2: {b:?}");
    }

    #[test]
    fn the_margin_is_positive_inside_and_a_distance_outside() {
        let square = [[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0], [1.0, 1.0]];
        assert_eq!(hull(&square).len(), 4);
        assert!((support_margin(&square, [0.5, 1.0]) - 0.5).abs() < 1e-12);
        assert!((support_margin(&square, [3.0, 3.0]) + 2.0_f64.sqrt()).abs() < 1e-12);
        assert!(
            (support_margin(&square[..2], [0.0, 2.0]) + 2.0_f64.sqrt()).abs() < 1e-12,
            "a line holds nothing"
        );
        assert_eq!(support_margin(&[], [0.0, 0.0]), f64::NEG_INFINITY);
    }
}
