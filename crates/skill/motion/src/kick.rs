//! What a kick in a clip looks like, in numbers that a task and an evaluation share.

use paid_lanes::{Quat, Vec3};
use paid_robot::{Body, RobotModel, RobotSpec, Shape};

use crate::Clip;

/// Derived quantities of a clip.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct KickFacts {
    /// Displacement of the anchor from the first to the last frame, x forward and y left in the first frame's heading
    /// of the anchor `[m]`.
    pub anchor_displacement: [f64; 2],
    /// Largest speed of the kicking foot's center of mass `[m/s]`.
    pub peak_foot_speed: f64,
    /// The frame of that speed.
    pub kick_frame: usize,
    /// That frame as a share of the clip, 0 to 1.
    pub kick_phase: f64,
    /// How far the kicking foot's origin rises from its lowest to its highest point over the clip `[m]`.
    pub lift_m: f64,
    /// Height of the lowest contact shape over the clip; negative below the floor `[m]`.
    pub lowest_point_m: f64,
}

/// `to - from` in the heading of the orientation `quat` (x forward, y left) `[m]`.
pub fn displacement_in_heading(quat: [f64; 4], from: [f64; 3], to: [f64; 3]) -> [f64; 2] {
    let forward = Quat(quat).rotate(Vec3([1.0, 0.0, 0.0]));
    let norm = forward.x().hypot(forward.y());
    // A torso that points straight up or down has no heading; its displacement is left in world axes.
    let (c, s) = if norm > 1e-9 { (forward.x() / norm, forward.y() / norm) } else { (1.0, 0.0) };
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    [c * dx + s * dy, c * dy - s * dx]
}

/// The derived quantities of a clip; `None` if the robot lacks a body that its TOML names.
pub fn kick_facts(clip: &Clip, model: &RobotModel, spec: &RobotSpec) -> Option<KickFacts> {
    let anchor = model.body_index(&spec.anchor_body)?;
    let foot = model.body_index(&spec.feet[clip.kick_leg.index()])?;
    let last = clip.frames - 1;
    let (mut kick_frame, mut peak) = (0, 0.0);
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for t in 0..clip.frames {
        let speed = Vec3(clip.body_lin_vel(t)[foot]).norm();
        if speed > peak {
            (kick_frame, peak) = (t, speed);
        }
        let height = clip.body_pos(t)[foot][2];
        (low, high) = (low.min(height), high.max(height));
    }
    Some(KickFacts {
        anchor_displacement: displacement_in_heading(
            clip.body_quat(0)[anchor],
            clip.body_pos(0)[anchor],
            clip.body_pos(last)[anchor],
        ),
        peak_foot_speed: peak,
        kick_frame,
        kick_phase: kick_frame as f64 / last.max(1) as f64,
        lift_m: high - low,
        lowest_point_m: (0..clip.frames)
            .map(|t| lowest_point(model, clip.body_pos(t), clip.body_quat(t)))
            .fold(f64::INFINITY, f64::min),
    })
}

/// How far a contact shape of a body in this pose reaches along a unit vector, from the world's origin `[m]`.
fn reach(shape: &Shape, pos: [f64; 3], quat: [f64; 4], way: Vec3<f64>) -> f64 {
    let along = |p: [f64; 3]| (Quat(quat).rotate(Vec3(p)) + Vec3(pos)).dot(way);
    match *shape {
        Shape::Sphere { center, radius } => along(center) + radius,
        Shape::Capsule { ends, radius } => along(ends[0]).max(along(ends[1])) + radius,
        Shape::Box { center, half_size, quat: tilt } => {
            // The support of a box: the sum of its half extents' shares along the way.
            let local = Quat(quat).mul(Quat(tilt)).to_mat().tr_mul_vec(way);
            along(center) + (0..3).map(|k| (local.0[k] * half_size[k]).abs()).sum::<f64>()
        }
    }
}

/// Height of the lowest point of all contact shapes that the robot trains with (of the body origins if it has none) `[m]`.
/// Poses are in model order.
pub fn lowest_point(model: &RobotModel, pos: &[[f64; 3]], quat: &[[f64; 4]]) -> f64 {
    let lowest = model.bodies.iter().enumerate().map(|(i, body)| lowest_point_of(body, pos[i], quat[i]));
    let lowest = lowest.fold(f64::INFINITY, f64::min);
    if lowest.is_finite() { lowest } else { pos.iter().map(|p| p[2]).fold(lowest, f64::min) }
}

/// The same of one body in this pose; infinite if it has no shape.
pub(crate) fn lowest_point_of(body: &Body, pos: [f64; 3], quat: [f64; 4]) -> f64 {
    let shapes = body.geoms.iter().filter(|g| g.class != "referee");
    shapes.map(|g| -reach(&g.shape, pos, quat, Vec3([0.0, 0.0, -1.0]))).fold(f64::INFINITY, f64::min)
}

/// Where the center of a ball is, seen from above, that touches a body in this pose from ahead of its motion, world `[m]`: on the line
/// from the body's origin along its horizontal velocity (its own x axis where there is none), a radius beyond the farthest point of its contact
/// shapes. A shape that is lower or higher than the ball's center touches it a little later.
pub fn ball_ahead(body: &Body, pos: [f64; 3], quat: [f64; 4], velocity: [f64; 3], radius_m: f64) -> [f64; 2] {
    let flat = |v: [f64; 3]| Vec3([v[0], v[1], 0.0]);
    let ahead = [flat(velocity), flat(Quat(quat).rotate(Vec3([1.0, 0.0, 0.0])).0), Vec3([1.0, 0.0, 0.0])];
    let way = ahead.into_iter().find(|v| v.norm() > 1e-6).map_or(ahead[2], |v| v.scale(1.0 / v.norm()));
    let origin = Vec3(pos).dot(way);
    let shapes = body.geoms.iter().filter(|g| g.class != "referee");
    let toe = shapes.map(|g| reach(&g.shape, pos, quat, way)).fold(origin, f64::max);
    let distance = toe - origin + radius_m;
    [pos[0] + distance * way.x(), pos[1] + distance * way.y()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{model, spec, steady_clip};

    #[test]
    fn displacement_is_seen_from_the_first_heading() {
        // Facing -y, two meters toward -y is two meters forward; one toward +x is one meter to the left.
        let facing_minus_y = [0.5_f64.sqrt(), 0.0, 0.0, -(0.5_f64.sqrt())];
        let d = displacement_in_heading(facing_minus_y, [1.0, 1.0, 0.0], [2.0, -1.0, 5.0]);
        assert!((d[0] - 2.0).abs() < 1e-12 && (d[1] - 1.0).abs() < 1e-12, "{d:?}");
    }

    #[test]
    fn the_kick_is_where_the_labeled_foot_is_fastest() {
        let mut clip = steady_clip(11, 50.0, 0.0);
        let foot = 2; // spec().feet[1], the label is right
        for t in 0..11 {
            clip.body_lin_vel[t * clip.bodies + foot] = [0.0, -(t as f64) * (10 - t) as f64, 0.0];
            clip.body_pos[t * clip.bodies + foot][2] = 0.05 + 0.03 * (t % 7) as f64;
        }
        let facts = kick_facts(&clip, &model(), &spec()).expect("bodies exist");
        assert_eq!(facts.kick_frame, 5);
        assert_eq!(facts.peak_foot_speed, 25.0);
        assert_eq!(facts.kick_phase, 0.5);
        assert!((facts.lift_m - 0.18).abs() < 1e-12);
        assert!((facts.anchor_displacement[0] - 0.2).abs() < 1e-12, "1 m/s for 0.2 s");
    }

    #[test]
    fn the_lowest_point_of_a_tilted_box_is_its_corner() {
        let mut robot = model();
        for body in &mut robot.bodies {
            body.geoms.retain(|g| matches!(g.shape, Shape::Box { .. }));
        }
        let tilt = [(0.125 * std::f64::consts::PI).cos(), (0.125 * std::f64::consts::PI).sin(), 0.0, 0.0];
        let low = lowest_point(&robot, &[[0.0, 0.0, 1.0]; 3], &[tilt; 3]);
        // Half sizes 0.1, 0.2, 0.3 turned by 45 degrees about x reach (0.2 + 0.3) / sqrt 2 down.
        assert!((low - (1.0 - 0.5 * 0.5_f64.sqrt())).abs() < 1e-12, "{low}");
    }

    #[test]
    fn the_ball_lies_a_radius_ahead_of_the_toe() {
        let foot = &model().bodies[2]; // a capsule along x: ends 0.1 m from the middle, 0.04 m thick
        let level = [1.0, 0.0, 0.0, 0.0];
        let at = |quat, velocity| ball_ahead(foot, [1.0, 2.0, 0.3], quat, velocity, 0.11);
        let close = |a: [f64; 2], b: [f64; 2]| {
            assert!((a[0] - b[0]).abs() < 1e-12 && (a[1] - b[1]).abs() < 1e-12, "{a:?} {b:?}");
        };
        close(at(level, [3.0, 0.0, 1.0]), [1.25, 2.0]);
        // Moved sideways, it meets the ball with its side.
        close(at(level, [0.0, -2.0, 0.0]), [1.0, 1.85]);
        // At rest it looks where the foot looks: here along y.
        let left = [0.5_f64.sqrt(), 0.0, 0.0, 0.5_f64.sqrt()];
        close(at(left, [0.0, 0.0, 4.0]), [1.0, 2.25]);
    }
}
