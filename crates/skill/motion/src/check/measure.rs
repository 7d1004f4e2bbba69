//! The numbers that a verdict rests on.

use paid_lanes::{Quat, Vec3};
use paid_robot::{RobotModel, RobotSpec, SpecError, kinematics};
use serde::Serialize;

use super::shapes::{deepest, leg_pairs, rods};
use super::{collision_pairs, foot_contacts};
use crate::generate::BALL_RADIUS;
use crate::kick::lowest_point_of;
use crate::resample::differentiate;
use crate::{Clip, GRAVITY, balance, ball_ahead, lowest_point, support_margin};

/// The largest value of something, the frame and (if it belongs to one) the joint or body.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Worst {
    /// The value.
    pub value: f64,
    /// Its frame.
    pub frame: usize,
    /// Name of the joint, body or bodies.
    pub part: String,
}

impl Worst {
    fn least() -> Self {
        Self { value: f64::NEG_INFINITY, ..Self::default() }
    }
    fn see(&mut self, value: f64, frame: usize, part: impl FnOnce() -> String) {
        if value > self.value || value.is_nan() {
            *self = Self { value, frame, part: part() };
        }
    }
}

/// What is measured of a clip.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Measures {
    /// First to last frame `[s]`.
    pub duration_s: f64,
    /// Largest speed of the labeled foot's center of mass `[m/s]`.
    pub foot_speed: Worst,
    /// Largest speed of the other foot `[m/s]`.
    pub other_foot_speed: Worst,
    /// Angle between the anchor's first heading and the way of the labeled foot at its fastest `[rad]`.
    pub shot_angle: f64,
    /// Angle between the anchor's first and last heading `[rad]`.
    pub turn: f64,
    /// Stored bodies against forward kinematics of the stored joints `[m]`.
    pub kinematics_m: Worst,
    /// Stored joint velocities against differences `[rad/s]`.
    pub joint_rate: Worst,
    /// Stored body velocities against differences `[m/s]`.
    pub body_rate: Worst,
    /// Joint angle beyond its range (negative: room left) `[rad]`.
    pub joint_range: Worst,
    /// Joint speed as a share of its limit.
    pub joint_speed: Worst,
    /// Change of joint velocity between frames as a share of the joint's speed limit.
    pub joint_jump: Worst,
    /// Speed of the base `[m/s]`.
    pub base_speed: Worst,
    /// Lowest point below the floor (negative: above) `[m]`.
    pub penetration_m: Worst,
    /// Lowest point above the floor `[m]`.
    pub floating_m: Worst,
    /// Way of a foot in one stance `[m]`.
    pub sliding_m: Worst,
    /// Depth of parts in each other `[m]`; 0 if nothing touches.
    pub overlap_m: Worst,
    /// Depth of one leg's foot or shin in the other's (negative: apart) `[m]`.
    pub legs_m: Worst,
    /// Share of frames with the center of pressure inside the standing soles.
    pub pressure_inside: f64,
    /// Share of frames with the center of pressure more than 2 cm outside.
    pub unbalanced: f64,
    /// Least distance of the center of pressure from the edge of the standing soles while any stands, negative outside `[m]`.
    pub pressure_margin_m: f64,
    /// Share of frames that need friction above 0.8.
    pub slippery: f64,
    /// Largest joint speed in the last frame `[rad/s]`.
    pub end_joint_speed: Worst,
    /// Speed of the base in the last frame `[m/s]`.
    pub end_base_speed: f64,
    /// Tilt of the base in the last frame `[rad]`.
    pub end_tilt: f64,
    /// Feet that stand in the last frame.
    pub end_feet: usize,
    /// Height of the kicking foot's lowest point in the frame of the strike `[m]`.
    pub strike_height_m: f64,
    /// From where the torso ends to a ball that the kicking foot meets in the frame of the strike ([`ball_ahead`]), along the floor `[m]`.
    pub end_to_ball_m: f64,
}

/// Friction coefficient that soles are sure to have (the task's floor has 1.0).
pub const FRICTION: f64 = 0.8;
/// Distance outside of the soles that still counts as balanced [m]: a real sole is larger than its contact points.
const OUTSIDE: f64 = 0.02;

/// With less than this share of its weight on the floor a robot counts as in the air: its center of pressure means nothing.
const PRESSED: f64 = 0.2;

/// Measures a clip.
///
/// # Errors
/// If the robot's TOML names what its MJCF lacks.
pub fn measure(clip: &Clip, model: &RobotModel, spec: &RobotSpec) -> Result<Measures, SpecError> {
    let indices = spec.indices(model)?;
    let control = spec.resolve(model)?;
    let foot = indices.feet[clip.kick_leg.index()];
    let other = indices.feet[1 - clip.kick_leg.index()];
    let last = clip.frames - 1;
    let mut again = clip.clone();
    differentiate(&mut again, model);

    let [mut foot_speed, mut other_foot_speed] = [Worst::least(), Worst::least()];
    let [mut kinematics_m, mut joint_rate, mut body_rate] = [Worst::least(), Worst::least(), Worst::least()];
    let [mut joint_range, mut joint_speed, mut joint_jump] =
        [Worst::least(), Worst::least(), Worst::default()];
    let [mut penetration_m, mut floating_m, mut base_speed] =
        [Worst::least(), Worst::least(), Worst::least()];
    let mut overlap_m = Worst::default();
    let mut legs_m = Worst::least();
    let mut end_joint_speed = Worst::least();
    let pairs = collision_pairs(model);
    let legs = leg_pairs(model, indices.feet);
    let body_name = |i: usize| model.bodies[i].name.clone();
    for t in 0..clip.frames {
        foot_speed.see(Vec3(again.body_lin_vel(t)[foot]).norm(), t, || body_name(foot));
        other_foot_speed.see(Vec3(again.body_lin_vel(t)[other]).norm(), t, || body_name(other));
        base_speed.see(Vec3(again.body_lin_vel(t)[0]).norm(), t, || body_name(0));
        let poses = kinematics::forward::<f64>(
            model,
            Vec3(clip.body_pos(t)[0]),
            Quat(clip.body_quat(t)[0]),
            clip.joint_pos(t),
        );
        for (i, pose) in poses.iter().enumerate() {
            kinematics_m.see((pose.pos - Vec3(clip.body_pos(t)[i])).norm(), t, || body_name(i));
            // The ends are one-sided differences, which files need not share.
            if t > 0 && t < last {
                let off = Vec3(again.body_lin_vel(t)[i]) - Vec3(clip.body_lin_vel(t)[i]);
                body_rate.see(off.norm(), t, || body_name(i));
            }
        }
        for (j, joint) in model.joints.iter().enumerate() {
            let (angle, speed, limit) =
                (clip.joint_pos(t)[j], again.joint_vel(t)[j], control.velocity_limit[j]);
            let name = || joint.name.clone();
            joint_range.see((joint.range[0] - angle).max(angle - joint.range[1]), t, name);
            joint_speed.see(speed.abs() / limit, t, name);
            if t == last {
                end_joint_speed.see(speed.abs(), t, name);
            }
            if t > 0 && t < last {
                joint_rate.see((speed - clip.joint_vel(t)[j]).abs(), t, name);
                let step = clip.joint_pos(t + 1)[j] - 2.0 * angle + clip.joint_pos(t - 1)[j];
                joint_jump.see((step * clip.fps).abs() / limit, t, name);
            }
        }
        let low = lowest_point(model, clip.body_pos(t), clip.body_quat(t));
        penetration_m.see(-low, t, String::new);
        floating_m.see(low, t, String::new);
        let both = |[a, b]: [usize; 2]| format!("{} and {}", body_name(a), body_name(b));
        let rods = rods(model, clip.body_pos(t), clip.body_quat(t));
        if let Some(overlap) = deepest(&rods, &pairs) {
            overlap_m.see(overlap.depth, t, || both(overlap.bodies));
        }
        if let Some(nearest) = deepest(&rods, &legs) {
            legs_m.see(nearest.depth, t, || both(nearest.bodies));
        }
    }

    let contacts = foot_contacts(clip, model, &indices.feet);
    let mut sliding_m = Worst::default();
    for (contact, &body) in contacts.iter().zip(&indices.feet) {
        let (way, frame) = contact.longest_slide(clip.fps);
        sliding_m.see(way, frame, || body_name(body));
    }
    let balance = balance(clip, model);
    let margins: Vec<f64> = (0..clip.frames)
        .map(|t| {
            let support: Vec<[f64; 2]> = contacts.iter().flat_map(|c| c.standing[t].clone()).collect();
            support_margin(&support, balance[t].zmp)
        })
        .collect();
    let share = |count: usize| count as f64 / clip.frames as f64;
    let heading = |t: usize| {
        let x = Quat(clip.body_quat(t)[indices.anchor]).rotate(Vec3([1.0, 0.0, 0.0]));
        x.y().atan2(x.x())
    };
    let up = Quat(clip.body_quat(last)[0]).rotate(Vec3([0.0, 0.0, 1.0])).z();
    let shot = again.body_lin_vel(foot_speed.frame)[foot];
    let strike = clip.kick_frame.unwrap_or(foot_speed.frame);
    let (pos, quat) = (clip.body_pos(strike)[foot], clip.body_quat(strike)[foot]);
    let [x, y] = ball_ahead(&model.bodies[foot], pos, quat, again.body_lin_vel(strike)[foot], BALL_RADIUS);
    let end = clip.body_pos(last)[indices.anchor];
    Ok(Measures {
        duration_s: clip.duration_s(),
        shot_angle: between(shot[1].atan2(shot[0]), heading(0)),
        turn: between(heading(last), heading(0)),
        pressure_inside: share(margins.iter().filter(|m| **m >= 0.0).count()),
        unbalanced: share(margins.iter().filter(|m| **m < -OUTSIDE).count()),
        pressure_margin_m: margins
            .iter()
            .zip(&balance)
            .filter(|(m, b)| m.is_finite() && b.force[2] > PRESSED * model.mass() * GRAVITY)
            .map(|(m, _)| *m)
            .fold(f64::INFINITY, f64::min),
        slippery: share(
            balance.iter().filter(|b| b.force[0].hypot(b.force[1]) > FRICTION * b.force[2]).count(),
        ),
        foot_speed,
        other_foot_speed,
        kinematics_m,
        joint_rate,
        body_rate,
        joint_range,
        joint_speed,
        joint_jump,
        base_speed,
        penetration_m,
        floating_m,
        sliding_m,
        overlap_m,
        legs_m,
        end_joint_speed,
        end_base_speed: Vec3(again.body_lin_vel(last)[0]).norm(),
        end_tilt: up.clamp(-1.0, 1.0).acos(),
        end_feet: contacts.iter().filter(|c| !c.standing[last].is_empty()).count(),
        strike_height_m: lowest_point_of(&model.bodies[foot], pos, quat),
        end_to_ball_m: (x - end[0]).hypot(y - end[1]),
    })
}

/// The angle between two headings, 0 to pi `[rad]`.
fn between(a: f64, b: f64) -> f64 {
    let (s, c) = (a - b).sin_cos();
    s.atan2(c).abs()
}
