//! Kicks made from scratch: foot steps, balance, inverse kinematics. No recorded motion is involved.
//!
//! A kick is planned as footholds with times ([`Plan`]), a path of the center of pressure through the standing soles, and the
//! path of the kicking toe through the ball. The path of the center of mass follows from the pressure ([`sway()`]), the joints
//! from all of it together ([`solve()`]). The pressure that this whole-body motion really has ([`crate::balance`]) differs
//! from that of a point mass, mostly by the leg that is thrown forward; the difference is subtracted from the plan and
//! everything solved again, a few times (the dynamic filter of Kajita et al. 2003).

mod biped;
mod builtin;
mod plan;
mod posture;
mod solve;
mod spline;
mod style;
mod sway;
#[cfg(test)]
mod tests;
mod walk;

pub use biped::Biped;
pub use builtin::{BUILTIN_LICENSE, BuiltinKick, Look, builtin_kicks, builtin_kicks_of, generate_builtin};
pub use plan::{BALL_RADIUS, FPS, Foothold, GOAL_DISTANCE, KickTimes, Plan, Swing};
pub use posture::Posture;
pub use solve::{FootTarget, Pose, Target, solve};
pub use spline::{Knot, Track, bump, min_jerk};
pub use style::KickStyle;
pub use sway::sway;

use paid_lanes::{Quat, Vec3};
use paid_robot::{RobotModel, RobotSpec, kinematics};
use plan::{KICK, PLANT};
use thiserror::Error;

use crate::{Balance, Clip, KickLeg, balance, rotation_log, support_margin};

/// Rounds of correcting the center of mass by the whole body's pressure.
const ROUNDS: usize = 5;
/// How far a foot `[m]` and the base `[m, rad]` may be from their targets; more means that the legs do not reach or a joint is at
/// its limit.
const TOLERANCES: [f64; 2] = [1e-3, 5e-4];
/// Steps beyond the fewest that are tried.
const EXTRA_STEPS: usize = 3;
/// By how much a follow-through that is beyond the leg is shortened, in turn `[m]`.
const SHORTER: [f64; 3] = [0.0, 0.04, 0.08];

/// Why a kick cannot be made.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum GenerateError {
    /// The robot is not a humanoid that the generator understands.
    #[error("this robot has no built-in kicks, give motion files instead: {0}")]
    Robot(String),
    /// The ball is out of reach of a kick.
    #[error(
        "ball: expected {near} to {far} m from the start and at most {degrees:.0} degrees off the heading, \
         found ({:.2}, {:.2}) m", ball[0], ball[1]
    )]
    Ball {
        /// Asked for `[m]`.
        ball: [f64; 2],
        /// Nearest `[m]`.
        near: f64,
        /// Farthest `[m]`.
        far: f64,
        /// Largest angle off the heading `[degrees]`.
        degrees: f64,
    },
    /// The legs cannot follow the plan.
    #[error(
        "ball ({:.2}, {:.2}) m: the legs do not follow the plan at {time_s:.2} s, {error:.1} times what is allowed",
        ball[0], ball[1]
    )]
    Reach {
        /// Asked for `[m]`.
        ball: [f64; 2],
        /// When `[s]`.
        time_s: f64,
        /// Largest error of feet and base, as a share of the allowed one.
        error: f64,
    },
}

impl GenerateError {
    /// The same error with the requested ball: left-footed kicks are planned for its mirror image.
    fn asked(mut self, asked: [f64; 2]) -> Self {
        if let Self::Ball { ball, .. } | Self::Reach { ball, .. } = &mut self {
            *ball = asked;
        }
        self
    }
}

/// What to make.
#[derive(Clone, Debug, PartialEq)]
pub struct KickRequest {
    /// Name of the clip.
    pub name: String,
    /// Ball, from where the anchor (torso) starts: x forward, y left `[m]`.
    pub ball: [f64; 2],
    /// Kicking leg.
    pub leg: KickLeg,
    /// Shape and speed.
    pub style: KickStyle,
}

/// A kick and what was planned.
#[derive(Clone, Debug)]
pub struct GeneratedKick {
    /// The motion at [`FPS`]; the anchor starts above the origin with heading +x and ends above the ball's place.
    pub clip: Clip,
    /// Ball, world `[m]`.
    pub ball: [f64; 2],
    /// Heading from ball to goal `[rad]`.
    pub aim: f64,
    /// The frame in which the toe touches the ball.
    pub contact_frame: usize,
    /// Soles that stand, a list of corner points for each frame, world `[m]`.
    pub support: Vec<Vec<[f64; 2]>>,
    /// Balance of each frame.
    pub balance: Vec<Balance>,
}

impl GeneratedKick {
    /// How far the center of pressure is inside the standing soles, for each frame; negative outside `[m]`.
    pub fn margins(&self) -> Vec<f64> {
        self.support.iter().zip(&self.balance).map(|(s, b)| support_margin(s, b.zmp)).collect()
    }
}

/// Makes a kick. The result depends on nothing but the arguments; a left-footed kick is the mirror image of the
/// right-footed one for the mirrored ball.
///
/// # Errors
/// A robot without the needed parts, a ball that cannot be reached.
pub fn generate_kick(
    model: &RobotModel,
    spec: &RobotSpec,
    request: &KickRequest,
) -> Result<GeneratedKick, GenerateError> {
    make(model, spec, request).map_err(|error| error.asked(request.ball))
}

fn make(model: &RobotModel, spec: &RobotSpec, request: &KickRequest) -> Result<GeneratedKick, GenerateError> {
    let figure = Biped::new(model, spec)?;
    let side = if request.leg == KickLeg::Left { -1.0 } else { 1.0 };
    let ball = [request.ball[0], side * request.ball[1]];

    // Stand once to learn where the anchor is above the feet.
    let trial = Plan::new(&figure, &request.style, ball, 0.0, 0)?;
    let stand = Course::new(&figure, trial, &request.style).first();
    let anchor = poses(&figure, &stand)[figure.anchor].pos.x();
    // The plan knows strides, not joints: where the legs do not reach, one more step helps, and then a shorter follow-through.
    let attempt = |shorter: f64, extra: usize| {
        let style = KickStyle { through: request.style.through - shorter, ..request.style };
        let plan = Plan::new(&figure, &style, ball, -anchor, extra)?;
        let (frames, plan) = Course::new(&figure, plan, &style).run()?;
        in_balance(&figure, &frames, &plan, request)?;
        Ok((frames, plan))
    };
    let mut made = attempt(0.0, 0);
    for (shorter, extra) in
        SHORTER.into_iter().flat_map(|s| (0..=EXTRA_STEPS).map(move |extra| (s, extra))).skip(1)
    {
        if !matches!(made, Err(GenerateError::Reach { .. })) {
            break;
        }
        made = attempt(shorter, extra);
    }
    let (mut frames, plan) = made?;
    let contact_frame = (plan.kick.contact * FPS).round() as usize;
    let mut support: Vec<Vec<[f64; 2]>> =
        (0..frames.len()).map(|k| plan.support(&figure, k as f64 / FPS)).collect();
    if request.leg == KickLeg::Left {
        frames.iter_mut().for_each(|pose| *pose = mirrored(&figure, pose));
        support.iter_mut().flatten().for_each(|p| p[1] = -p[1]);
    }
    let mut clip = clip_of(&figure, &frames, request);
    clip.kick_frame = Some(contact_frame);
    let balance = balance(&clip, model);
    Ok(GeneratedKick { clip, ball: request.ball, aim: side * plan.aim, contact_frame, support, balance })
}

/// Refuses a motion whose pressure leaves the planned soles: the legs jumped between frames, though each frame is near its targets.
fn in_balance(
    figure: &Biped<'_>,
    frames: &[Pose],
    plan: &Plan,
    request: &KickRequest,
) -> Result<(), GenerateError> {
    let now = balance(&clip_of(figure, frames, request), figure.model);
    for (k, b) in now.iter().enumerate() {
        let time_s = k as f64 / FPS;
        let margin = support_margin(&plan.support(figure, time_s), b.zmp);
        if margin < 0.0 {
            let error = 1.0 - margin / TOLERANCES[0];
            return Err(GenerateError::Reach { ball: request.ball, time_s, error });
        }
    }
    Ok(())
}

/// The mirror image of a pose in the x-z plane.
pub fn mirrored(figure: &Biped<'_>, pose: &Pose) -> Pose {
    let mut joints = vec![0.0; pose.joints.len()];
    for (angle, &(image, sign)) in pose.joints.iter().zip(&figure.mirror) {
        joints[image] = sign * angle;
    }
    let ([x, y, z], [qw, qx, qy, qz]) = (pose.base_pos, pose.base_quat);
    Pose { base_pos: [x, -y, z], base_quat: [qw, -qx, qy, -qz], joints }
}

fn poses(figure: &Biped<'_>, pose: &Pose) -> Vec<paid_robot::BodyPose<f64>> {
    kinematics::forward::<f64>(figure.model, Vec3(pose.base_pos), Quat(pose.base_quat), &pose.joints)
}

/// Forward kinematics of all frames, velocities as differences.
fn clip_of(figure: &Biped<'_>, frames: &[Pose], request: &KickRequest) -> Clip {
    Clip {
        name: request.name.clone(),
        path: format!("{}.npz", request.name).into(),
        kick_leg: request.leg,
        license: Some(BUILTIN_LICENSE.to_owned()),
        ..Clip::of_poses(figure.model, FPS, frames)
    }
}

/// A plan on its way to joint angles.
struct Course<'f, 'm> {
    figure: &'f Biped<'m>,
    plan: Plan,
    posture: Posture,
    toe: Track<3>,
    pressure: Track<2>,
}

impl<'f, 'm> Course<'f, 'm> {
    fn new(figure: &'f Biped<'m>, plan: Plan, style: &KickStyle) -> Self {
        Self {
            figure,
            posture: Posture::new(figure, &plan, style),
            toe: plan.toe_way(figure, style),
            pressure: plan.pressure(figure),
            plan,
        }
    }

    /// The pose of the first frame.
    fn first(&self) -> Pose {
        let mut pose = Pose {
            base_pos: [0.0, 0.0, self.figure.stance().0],
            base_quat: [1.0, 0.0, 0.0, 0.0],
            joints: self.figure.default_pos.clone(),
        };
        self.frame(&mut pose, 0, self.pressure.at(0.0));
        pose
    }

    /// Solves frame `k` from a pose nearby; returns the largest error as a share of its tolerance.
    fn frame(&self, pose: &mut Pose, k: usize, com: [f64; 2]) -> f64 {
        let t = k as f64 / FPS;
        let angles = self.posture.joints(self.figure, t);
        for j in 0..angles.len() {
            if !self.figure.legs.iter().flatten().any(|&leg| leg == j) {
                pose.joints[j] = angles[j];
            }
        }
        let [roll, pitch, yaw] = self.posture.turn.at(t);
        let free = core::array::from_fn(|foot| {
            core::array::from_fn(|i| {
                let (joint, course) = &self.posture.free[i];
                if foot == KICK { (*joint, course.at(t)[0]) } else { (self.figure.free[foot][i], 0.0) }
            })
        });
        let target = Target {
            com,
            height: self.posture.height.at(t)[0],
            base_quat: Quat::from_roll_pitch_yaw(roll, pitch, yaw).0,
            feet: [self.foot(PLANT, t), self.foot(KICK, t)],
            free,
        };
        solve(self.figure, pose, &target);
        let bodies = poses(self.figure, pose);
        let mut error: f64 = 0.0;
        for (side, foot) in target.feet.iter().enumerate() {
            let toe = bodies[self.figure.feet[side]].point(Vec3(self.figure.toe[side]));
            error = error.max((toe - Vec3(foot.toe)).norm() / TOLERANCES[0]);
        }
        let turn = Vec3(rotation_log(pose.base_quat, target.base_quat)).norm();
        error = error.max(turn.max((pose.base_pos[2] - target.height).abs()) / TOLERANCES[1]);
        error
    }

    fn foot(&self, foot: usize, t: f64) -> FootTarget {
        let kick = self.plan.kick;
        if foot == KICK && t > kick.lift && t < kick.land {
            let leaves = 1.0 - min_jerk((t - kick.lift) / (0.75 * (kick.back - kick.lift)));
            let lands = min_jerk((t - kick.through) / (0.85 * (kick.land - kick.through)));
            let swing = self.plan.kick_swing();
            return FootTarget {
                toe: self.toe.at(t),
                yaw: if t < kick.contact { swing.from.yaw } else { swing.to.yaw },
                pitch: 0.0,
                flat: [leaves.max(lands); 3],
            };
        }
        let mut hold = self.plan.start[foot];
        let (mut rise, mut pitch, mut free) = (0.0, 0.0, 0.0);
        for swing in self.plan.swings.iter().filter(|s| s.foot == foot && t > s.lift) {
            let s = (t - swing.lift) / (swing.land - swing.lift);
            let share = min_jerk(s);
            let way = (swing.to.xy[0] - swing.from.xy[0]).hypot(swing.to.xy[1] - swing.from.xy[1]);
            rise = bump(s) * (0.045 + 0.05 * way);
            // The heel leaves the floor before the toe: a foot behind the body could not bend so far as to stay level.
            free = min_jerk(5.0 * s) * min_jerk(5.0 * (1.0 - s));
            pitch = 0.55 * bump(1.0 - (1.0 - s.min(1.0)).powf(1.5));
            let mix = |a: f64, b: f64| a + share * (b - a);
            hold = Foothold {
                xy: [mix(swing.from.xy[0], swing.to.xy[0]), mix(swing.from.xy[1], swing.to.xy[1])],
                yaw: mix(swing.from.yaw, swing.to.yaw),
            };
        }
        let [x, y, z] = self.figure.toe[foot];
        let [px, py] = hold.point([x, y]);
        FootTarget {
            toe: [px, py, self.figure.sole_height() + z + rise + self.figure.dip(foot, pitch)],
            yaw: hold.yaw,
            pitch,
            flat: [1.0 - free, 1.0, 1.0],
        }
    }

    /// All frames, with the whole body's pressure brought to the plan.
    fn run(self) -> Result<(Vec<Pose>, Plan), GenerateError> {
        let count = self.plan.frames();
        let planned: Vec<[f64; 2]> = (0..count).map(|k| self.pressure.at(k as f64 / FPS)).collect();
        let mut wanted = planned.clone();
        let first = self.first();
        let height = {
            let bodies = poses(self.figure, &first);
            let sum: f64 = self
                .figure
                .model
                .bodies
                .iter()
                .zip(&bodies)
                .map(|(body, pose)| body.mass * pose.point(Vec3(body.com)).z())
                .sum();
            sum / self.figure.model.mass()
        };
        let mut pull = vec![height / crate::GRAVITY; count];
        let mut frames = Vec::new();
        let request = KickRequest {
            name: String::new(),
            ball: self.plan.ball,
            leg: KickLeg::Right,
            style: KickStyle::standard(),
        };
        for round in 0..ROUNDS {
            let axis = |i: usize| {
                let line: Vec<f64> = wanted.iter().map(|p| p[i]).collect();
                sway(&line, &pull, [planned[0][i], planned[count - 1][i]], 1.0 / FPS)
            };
            let (x, y) = (axis(0), axis(1));
            let mut pose = first.clone();
            frames.clear();
            for k in 0..count {
                let error = self.frame(&mut pose, k, [x[k], y[k]]);
                // Only the last round must be good; one that has diverged is not worth continuing.
                let worst = if round + 1 == ROUNDS { 1.0 } else { 30.0 };
                if error > worst || error.is_nan() {
                    return Err(GenerateError::Reach { ball: self.plan.ball, time_s: k as f64 / FPS, error });
                }
                frames.push(pose.clone());
            }
            if round + 1 == ROUNDS {
                break;
            }
            let now = balance(&clip_of(self.figure, &frames, &request), self.figure.model);
            for (k, b) in now.iter().enumerate() {
                pull[k] = b.com[2] * self.figure.model.mass() / b.force[2];
                for i in 0..2 {
                    // What angular momentum adds to the pressure of a point mass.
                    let extra = b.zmp[i] - (b.com[i] - b.com[2] * b.force[i] / b.force[2]);
                    wanted[k][i] = planned[k][i] - extra;
                }
            }
        }
        Ok((frames, self.plan))
    }
}
