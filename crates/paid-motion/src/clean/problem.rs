//! The one optimization over a whole clip: what is wanted of it, as squares.

use paid_lanes::{Quat, Vec3};

use super::collide;
use super::figure::{Figure, Frame};
use super::momentum::{Functional, Push, pushes};
use super::plan::Plan;
use super::rows::{Band, Row};
use crate::generate::Pose;
use crate::{GRAVITY, rotation_log};

/// How far things may be from what is wanted for a square of one. Wishes are wide, conditions are narrow.
mod width {
    /// Base from the original `[m]`: along the floor and up.
    pub const BASE: [f64; 3] = [0.08, 0.08, 0.04];
    /// Base from the original `[rad]`.
    pub const TILT: f64 = 0.10;
    /// Joint from the original `[rad]`.
    pub const JOINT: f64 = 0.25;
    /// Acceleration of those differences `[m/s^2, rad/s^2]`.
    pub const BASE_ACC: f64 = 3.0;
    pub const TILT_ACC: f64 = 12.0;
    pub const JOINT_ACC: f64 = 30.0;
    /// A foot in the air, the kicking foot near the kick, and a hand from the original `[m]`.
    pub const SWING: f64 = 0.03;
    pub const STRIKE: f64 = 0.006;
    pub const HAND: f64 = 0.06;
    /// A foot in the air, orientation `[rad]`.
    pub const SWING_TURN: f64 = 0.25;
    /// A foot that stands, from its foothold `[m, rad]`.
    pub const HOLD: f64 = 0.003;
    pub const HOLD_TURN: f64 = 0.012;
    /// Speed of a foot that stands `[m/s]`.
    pub const SLIDE: f64 = 0.012;
    /// On heel or toes alone `[rad]`.
    pub const ROLL_TURN: f64 = 0.1;
    /// Conditions: angle beyond the range `[rad]`, shares of speed limit and torque, depth `[m]`.
    pub const RANGE: f64 = 0.002;
    pub const SPEED: f64 = 0.01;
    pub const TORQUE: f64 = 0.04;
    pub const DEPTH: f64 = 0.003;
    pub const APART: f64 = 0.001;
    /// Pressure outside of its margin `[m]`; force as a share of the weight.
    pub const PRESSURE: f64 = 0.002;
    pub const FORCE: f64 = 0.03;
    /// Force in the air as a share of the weight.
    pub const FLIGHT: f64 = 0.25;
    /// Speed at the two ends `[m/s, rad/s]`.
    pub const REST: f64 = 0.01;
}

/// Room inside the limits, so that what is nearly kept is kept.
mod room {
    /// Joint from the end of its range `[rad]`.
    pub const RANGE: f64 = 0.003;
    /// Share of the speed limit; the check warns above 0.9.
    pub const SPEED: f64 = 0.86;
    /// Change of a joint's velocity in a frame as a share of its limit; the check warns above 0.5.
    pub const JUMP: f64 = 0.42;
    /// Height of a swinging foot above the floor, and the highest that the lower foot flies `[m]`.
    pub const CLEAR: f64 = 0.004;
    pub const HIGH: f64 = 0.02;
    /// Parts of the robot from each other `[m]`.
    pub const APART: f64 = 0.004;
    /// Force that holds along the floor as a share of that upwards; soles are sure to give 0.8.
    pub const FRICTION: f64 = 0.7;
    /// Least force of the floor while a foot stands, as a share of the weight.
    pub const WEIGHT: f64 = 0.15;
}

pub(super) struct Problem<'a> {
    pub figure: &'a Figure<'a>,
    pub plan: &'a Plan,
    /// Share of the torque limits that may be used.
    pub torque_share: f64,
    /// Conditions weigh this many times as much as written above.
    pub stress: f64,
    /// Bodies beyond each joint.
    beyond: Vec<Vec<bool>>,
    /// How the feet share the floor's force in each frame.
    carried: Vec<[f64; 2]>,
    /// The original's bodies.
    goal: Vec<Frame>,
}

/// Adds squares up, and, if there is a band, their normal equations.
struct Sum<'b> {
    cost: f64,
    band: Option<&'b mut Band>,
    row: Row,
}

impl Sum<'_> {
    /// A residual `r`, of which `width` counts one; `fill` writes its derivatives.
    fn square(&mut self, r: f64, width: f64, fill: impl FnOnce(&mut Row)) {
        let w2 = 1.0 / (width * width);
        self.cost += w2 * r * r;
        if let Some(band) = self.band.as_deref_mut() {
            self.row.clear();
            fill(&mut self.row);
            band.add(&mut self.row, r, w2);
        }
    }

    /// As [`Sum::square`] where `r` is negative; nothing where it is not.
    fn at_least_zero(&mut self, r: f64, width: f64, fill: impl FnOnce(&mut Row)) {
        if r < 0.0 {
            self.square(r, width, fill);
        }
    }
}

impl<'a> Problem<'a> {
    pub fn new(figure: &'a Figure<'a>, plan: &'a Plan, torque_share: f64) -> Self {
        let beyond = |j: usize| figure.paths.iter().map(|path| path.contains(&j)).collect();
        let goal: Vec<Frame> = plan.poses.iter().map(|p| figure.frame(p)).collect();
        Self {
            figure,
            plan,
            torque_share,
            stress: 1.0,
            beyond: (0..figure.model.joints.len()).map(beyond).collect(),
            carried: goal.iter().enumerate().map(|(t, f)| carried(figure, plan, f, t)).collect(),
            goal,
        }
    }

    /// Takes conditions as seriously as `stress` says, and how the feet share the floor's force from `poses`. Both stay as they are
    /// until the next call, so that the cost is smooth.
    pub fn set(&mut self, stress: f64, poses: &[Pose]) {
        self.stress = stress;
        let each = |(t, pose): (usize, &Pose)| carried(self.figure, self.plan, &self.figure.frame(pose), t);
        self.carried = poses.iter().enumerate().map(each).collect();
    }

    /// Half the sum of squares is not wanted by anybody: this is the whole of it. With a band also its normal equations.
    pub fn cost(&self, poses: &[Pose], band: Option<&mut Band>) -> f64 {
        let frames: Vec<Frame> = poses.iter().map(|p| self.figure.frame(p)).collect();
        let pushes = pushes(self.figure, &frames, self.plan.fps);
        let mut sum = Sum { cost: 0.0, band, row: Row::default() };
        if let Some(band) = sum.band.as_deref_mut() {
            band.clear();
        }
        for t in 0..poses.len() {
            self.likeness(poses, &frames, t, &mut sum);
            self.smoothness(poses, t, &mut sum);
            self.limits(poses, t, &mut sum);
            self.feet(&frames, t, &mut sum);
            self.apart(&frames[t], t, &mut sum);
            self.ground(&frames, &pushes[t], t, &mut sum);
            self.torques(poses, &frames, &pushes[t], t, &mut sum);
        }
        self.ends(poses, &mut sum);
        sum.cost
    }

    fn likeness(&self, poses: &[Pose], frames: &[Frame], t: usize, sum: &mut Sum<'_>) {
        let (pose, goal, first) = (&poses[t], &self.plan.poses[t], t * self.figure.n);
        // What was added is nobody's motion.
        let ease = if self.plan.is_rest(t) {
            0.5
        } else if self.plan.is_added(t) {
            2.0
        } else {
            1.0
        };
        for k in 0..3 {
            let off = pose.base_pos[k] - goal.base_pos[k];
            sum.square(off, ease * width::BASE[k], |row| row.add(first + k, 1.0));
        }
        let turn = rotation_log(goal.base_quat, pose.base_quat);
        for k in 0..3 {
            let slope = turn_slope(turn, k);
            sum.square(turn[k], ease * width::TILT, |row| {
                (0..3).for_each(|c| row.add(first + 3 + c, slope.0[c]));
            });
        }
        for j in 0..goal.joints.len() {
            let off = pose.joints[j] - goal.joints[j];
            sum.square(off, ease * width::JOINT, |row| row.add(first + 6 + j, 1.0));
        }
        if self.plan.is_added(t) {
            return;
        }
        let (frame, aim) = (&frames[t], &self.goal[t]);
        for &hand in &self.figure.hands {
            let off = frame.pos[hand] - aim.pos[hand];
            for k in 0..3 {
                let dir = unit(k);
                sum.square(off.0[k], width::HAND, |row| {
                    self.figure.add_point(frame, hand, frame.pos[hand], dir, first, row);
                });
            }
        }
    }

    /// Accelerations of the differences from the original.
    fn smoothness(&self, poses: &[Pose], t: usize, sum: &mut Sum<'_>) {
        if t == 0 || t + 1 == poses.len() {
            return;
        }
        let (n, fps) = (self.figure.n, self.plan.fps);
        let (k, goal) = (fps * fps, &self.plan.poses);
        let fill = |variable: usize| {
            move |row: &mut Row| {
                for (t, x) in [(t - 1, 1.0), (t, -2.0), (t + 1, 1.0)] {
                    row.add(t * n + variable, x * k);
                }
            }
        };
        // What was added shall be smooth itself.
        let original = f64::from(u8::from(!self.plan.is_added(t)));
        let second = |off: &dyn Fn(usize) -> f64| k * (off(t + 1) - 2.0 * off(t) + off(t - 1));
        for c in 0..3 {
            let off = |t: usize| poses[t].base_pos[c] - original * goal[t].base_pos[c];
            sum.square(second(&off), width::BASE_ACC, fill(c));
        }
        let from = |s: usize| if original > 0.0 { goal[s].base_quat } else { goal[t].base_quat };
        let turns = [t - 1, t, t + 1].map(|t| rotation_log(from(t), poses[t].base_quat));
        for c in 0..3 {
            let acc = k * (turns[2][c] - 2.0 * turns[1][c] + turns[0][c]);
            sum.square(acc, width::TILT_ACC, |row| {
                for (i, (t, x)) in [(t - 1, k), (t, -2.0 * k), (t + 1, k)].into_iter().enumerate() {
                    let slope = turn_slope(turns[i], c);
                    (0..3).for_each(|d| row.add(t * n + 3 + d, x * slope.0[d]));
                }
            });
        }
        for j in 0..goal[t].joints.len() {
            let off = |t: usize| poses[t].joints[j] - original * goal[t].joints[j];
            sum.square(second(&off), width::JOINT_ACC, fill(6 + j));
        }
    }

    /// Ranges and speeds of the joints.
    fn limits(&self, poses: &[Pose], t: usize, sum: &mut Sum<'_>) {
        let (n, fps, s) = (self.figure.n, self.plan.fps, self.stress);
        for (j, joint) in self.figure.model.joints.iter().enumerate() {
            let (q, at) = (poses[t].joints[j], t * n + 6 + j);
            let room = room::RANGE.min(0.25 * (joint.range[1] - joint.range[0]));
            sum.at_least_zero(q - joint.range[0] - room, width::RANGE / s, |row| row.add(at, 1.0));
            sum.at_least_zero(joint.range[1] - room - q, width::RANGE / s, |row| row.add(at, -1.0));
            let k = fps / self.figure.speed_limit[j];
            if t + 1 < poses.len() {
                let speed = k * (poses[t + 1].joints[j] - q);
                let sign = speed.signum();
                sum.at_least_zero(room::SPEED - sign * speed, width::SPEED / s, |row| {
                    row.add(at, sign * k);
                    row.add(at + n, -sign * k);
                });
            }
            if t > 0 && t + 1 < poses.len() {
                let jump = k * (poses[t + 1].joints[j] - 2.0 * q + poses[t - 1].joints[j]);
                let sign = jump.signum();
                sum.at_least_zero(room::JUMP - sign * jump, width::SPEED / s, |row| {
                    row.add(at - n, -sign * k);
                    row.add(at, 2.0 * sign * k);
                    row.add(at + n, -sign * k);
                });
            }
        }
    }

    /// Footholds, ways through the air, the floor.
    fn feet(&self, frames: &[Frame], t: usize, sum: &mut Sum<'_>) {
        let (frame, first, s) = (&frames[t], t * self.figure.n, self.stress);
        for side in 0..2 {
            let foot = self.figure.feet[side];
            let goal = self.plan.feet[side][t];
            let at = frame.pos[foot] + frame.quat[foot].rotate(goal.pivot);
            let off = at - goal.pos;
            let turn = rotation_log(goal.quat.0, frame.quat[foot].0);
            let (near, level) = match goal.width {
                _ if goal.rolls => (width::HOLD, width::ROLL_TURN),
                _ if goal.stands => (width::HOLD, width::HOLD_TURN),
                super::plan::Swing::Strike => (width::STRIKE, width::SWING_TURN),
                super::plan::Swing::Free => (width::SWING, width::SWING_TURN),
                super::plan::Swing::Near => (3.0 * width::SWING, 2.0 * width::SWING_TURN),
            };
            for k in 0..3 {
                let dir = unit(k);
                sum.square(off.0[k], near, |row| self.figure.add_point(frame, foot, at, dir, first, row));
                let slope = turn_slope(turn, k);
                sum.square(turn[k], level, |row| self.figure.add_turn(frame, foot, slope, first, row));
            }
        }
        self.still(frames, t, sum);
        let points = [0, 1].map(|side| self.figure.sole_points(frame, side));
        let mut lowest = (f64::INFINITY, 0, Vec3::zero());
        for side in 0..2 {
            let clear = if self.plan.feet[side][t].stands { -room::CLEAR } else { room::CLEAR };
            for &point in &points[side] {
                if point.z() < lowest.0 {
                    lowest = (point.z(), side, point);
                }
                sum.at_least_zero(point.z() - clear, width::DEPTH / s, |row| {
                    self.figure.add_point(frame, self.figure.feet[side], point, unit(2), first, row);
                });
            }
        }
        sum.at_least_zero(room::HIGH - lowest.0, width::DEPTH / s, |row| {
            let foot = self.figure.feet[lowest.1];
            self.figure.add_point(frame, foot, lowest.2, unit(2).scale(-1.0), first, row);
        });
        // Knees, hands and all else.
        for (body, rods) in self.figure.rods.iter().enumerate() {
            if self.figure.feet.contains(&body) {
                continue;
            }
            for rod in rods {
                for end in rod.ends {
                    let point = frame.pos[body] + frame.quat[body].rotate(end);
                    sum.at_least_zero(point.z() - rod.radius - room::CLEAR, width::DEPTH / s, |row| {
                        self.figure.add_point(frame, body, point, unit(2), first, row);
                    });
                }
            }
        }
    }

    /// A flat foot that stands does not move.
    fn still(&self, frames: &[Frame], t: usize, sum: &mut Sum<'_>) {
        if t + 1 == frames.len() {
            return;
        }
        let (n, fps) = (self.figure.n, self.plan.fps);
        for side in 0..2 {
            let flat = |t: usize| self.plan.feet[side][t].stands && !self.plan.feet[side][t].rolls;
            if !(flat(t) && flat(t + 1)) {
                continue;
            }
            let foot = self.figure.feet[side];
            let way = frames[t + 1].pos[foot] - frames[t].pos[foot];
            for k in 0..3 {
                sum.square(fps * way.0[k], width::SLIDE, |row| {
                    for (at, sign) in [(t, -fps), (t + 1, fps)] {
                        let frame = &frames[at];
                        self.figure.add_point(frame, foot, frame.pos[foot], unit(k).scale(sign), at * n, row);
                    }
                });
            }
        }
    }

    /// Parts of the robot out of each other.
    fn apart(&self, frame: &Frame, t: usize, sum: &mut Sum<'_>) {
        collide::near(self.figure, frame, room::APART, |near| {
            let width = width::APART / self.stress;
            sum.at_least_zero(near.gap - room::APART, width, |row| {
                let [a, b] = near.bodies;
                self.figure.add_point(frame, a, near.points[0], near.normal, t * self.figure.n, row);
                self.figure.add_point(
                    frame,
                    b,
                    near.points[1],
                    near.normal.scale(-1.0),
                    t * self.figure.n,
                    row,
                );
            });
        });
    }

    /// Pressure within the soles, upward force, friction; in the air no force at all.
    fn ground(&self, frames: &[Frame], pushes: &[Push], t: usize, sum: &mut Sum<'_>) {
        let (figure, fps, s) = (self.figure, self.plan.fps, self.stress);
        let weight = figure.mass * GRAVITY;
        let all = vec![1.0; figure.model.bodies.len()];
        let of = |turn: Vec3<f64>, point: Vec3<f64>, shift: Vec3<f64>| Functional {
            turn: turn.scale(1.0 / weight),
            point,
            shift: shift.scale(1.0 / weight),
            share: &all,
        };
        let mut condition = |f: &Functional<'_>, over: f64, width: f64, always: bool| {
            let r = f.value(&frames[t], pushes) - over;
            let fill = |row: &mut Row| f.add(figure, frames, pushes, t, fps, row);
            if always {
                sum.square(r, width, fill);
            } else {
                sum.at_least_zero(r, width, fill);
            }
        };
        let zero = Vec3::zero();
        let Some(support) = &self.plan.support[t] else {
            for k in 0..3 {
                condition(&of(zero, zero, unit(k)), 0.0, width::FLIGHT, true);
            }
            return;
        };
        for (i, &a) in support.corners.iter().enumerate() {
            let b = support.corners[(i + 1) % support.corners.len()];
            let length = (b[0] - a[0]).hypot(b[1] - a[1]).max(1e-9);
            // Inward normal of a counterclockwise polygon; the pressure's distance from the edge times the force upwards.
            let (nx, ny) = (-(b[1] - a[1]) / length, (b[0] - a[0]) / length);
            let inside = of(Vec3([ny, -nx, 0.0]), Vec3([a[0], a[1], 0.0]), Vec3([0.0, 0.0, -support.margin]));
            condition(&inside, 0.0, width::PRESSURE / s, false);
        }
        condition(&of(zero, zero, unit(2)), room::WEIGHT, width::FORCE / s, false);
        let force: Vec3<f64> = pushes.iter().fold(zero, |f, p| f + p.force);
        let along = force.x().hypot(force.y()).max(1e-9);
        let grip = Vec3([-force.x() / along, -force.y() / along, room::FRICTION]);
        condition(&of(zero, zero, grip), 0.0, width::FORCE / s, false);
    }

    /// Torques of the joints: inverse dynamics, with the floor's force at the feet that stand.
    fn torques(&self, poses: &[Pose], frames: &[Frame], pushes: &[Push], t: usize, sum: &mut Sum<'_>) {
        let (figure, n, fps) = (self.figure, self.figure.n, self.plan.fps);
        for (j, joint) in figure.model.joints.iter().enumerate() {
            let share = self.shares(t, j);
            let scale = 1.0 / (joint.effort_limit * self.torque_share);
            let functional = Functional {
                turn: frames[t].axis[j].scale(scale),
                point: frames[t].pos[joint.body],
                shift: Vec3::zero(),
                share: &share,
            };
            let rotor = scale * joint.armature * fps * fps;
            let acc =
                |d: [usize; 3]| poses[d[2]].joints[j] - 2.0 * poses[d[1]].joints[j] + poses[d[0]].joints[j];
            let inner = t > 0 && t + 1 < poses.len();
            let torque = functional.value(&frames[t], pushes)
                + if inner { rotor * acc([t - 1, t, t + 1]) } else { 0.0 };
            let sign = torque.signum();
            sum.at_least_zero(1.0 - sign * torque, width::TORQUE, |row| {
                let Functional { turn, point, shift, share } = functional;
                let down = Functional { turn: turn.scale(-sign), point, shift, share };
                down.add(figure, frames, pushes, t, fps, row);
                // The joint's axis and place move as well.
                let [force, moment] = down.total(&frames[t], pushes);
                let (body, first) = (joint.body, t * n);
                figure.add_turn(&frames[t], body, down.turn.cross(moment), first, row);
                figure.add_point(&frames[t], body, point, down.turn.cross(force), first, row);
                if inner {
                    for (t, x) in [(t - 1, 1.0), (t, -2.0), (t + 1, 1.0)] {
                        row.add(t * n + 6 + j, -sign * rotor * x);
                    }
                }
            });
        }
    }

    /// Each body's share in the torque of a joint: bodies beyond it, less what the floor carries at the feet beyond it.
    fn shares(&self, t: usize, j: usize) -> Vec<f64> {
        let carried = self.carried[t];
        let floor: f64 =
            (0..2).filter(|&side| self.beyond[j][self.figure.feet[side]]).map(|side| carried[side]).sum();
        self.beyond[j].iter().map(|&beyond| f64::from(u8::from(beyond)) - floor).collect()
    }

    /// Torques of all joints of a frame over their limits.
    pub fn torque_shares(&self, poses: &[Pose]) -> Vec<Vec<f64>> {
        let frames: Vec<Frame> = poses.iter().map(|p| self.figure.frame(p)).collect();
        let pushes = pushes(self.figure, &frames, self.plan.fps);
        let last = poses.len() - 1;
        (0..poses.len())
            .map(|t| {
                let joints = self.figure.model.joints.iter().enumerate();
                joints
                    .map(|(j, joint)| {
                        let share = self.shares(t, j);
                        let functional = Functional {
                            turn: frames[t].axis[j],
                            point: frames[t].pos[joint.body],
                            shift: Vec3::zero(),
                            share: &share,
                        };
                        let (a, b) = (t.saturating_sub(1), (t + 1).min(last));
                        let acc = poses[b].joints[j] - 2.0 * poses[t].joints[j] + poses[a].joints[j];
                        let rotor = joint.armature * acc * self.plan.fps * self.plan.fps;
                        (functional.value(&frames[t], &pushes[t]) + rotor).abs() / joint.effort_limit
                    })
                    .collect()
            })
            .collect()
    }

    /// At rest at both ends.
    fn ends(&self, poses: &[Pose], sum: &mut Sum<'_>) {
        let (n, fps) = (self.figure.n, self.plan.fps);
        let last = poses.len() - 1;
        for (a, b) in [(0, 1), (1, 2), (last - 2, last - 1), (last - 1, last)] {
            let fill = |variable: usize| {
                move |row: &mut Row| {
                    row.add(a * n + variable, -fps);
                    row.add(b * n + variable, fps);
                }
            };
            let turn = rotation_log(poses[a].base_quat, poses[b].base_quat);
            for k in 0..3 {
                let off = poses[b].base_pos[k] - poses[a].base_pos[k];
                sum.square(fps * off, width::REST, fill(k));
                sum.square(fps * turn[k], width::REST, fill(3 + k));
            }
            for j in 0..poses[a].joints.len() {
                sum.square(fps * (poses[b].joints[j] - poses[a].joints[j]), width::REST, fill(6 + j));
            }
        }
    }
}

/// How the feet share the floor's force: by where the center of mass is between them.
fn carried(figure: &Figure<'_>, plan: &Plan, frame: &Frame, t: usize) -> [f64; 2] {
    match [0, 1].map(|side| plan.feet[side][t].stands) {
        [false, false] => [0.0; 2],
        [true, false] => [1.0, 0.0],
        [false, true] => [0.0, 1.0],
        [true, true] => {
            let [a, b] = figure.feet.map(|foot| frame.pos[foot]);
            let com = frame.com.iter().zip(&figure.model.bodies);
            let com = com.fold(Vec3::zero(), |c, (p, body)| p.scale_add(body.mass / figure.mass, c));
            let way = Vec3([b.x() - a.x(), b.y() - a.y(), 0.0]);
            let share = ((com - a).dot(way) / way.norm2().max(1e-9)).clamp(0.0, 1.0);
            [1.0 - share, share]
        }
    }
}

/// What component `k` of a rotation vector `r` gains by a small turn in world axes: row `k` of the inverse left Jacobian of rotations, to
/// second order.
fn turn_slope(r: [f64; 3], k: usize) -> Vec3<f64> {
    let (r, e) = (Vec3(r), unit(k));
    let once = r.cross(e);
    r.cross(once).scale_add(1.0 / 12.0, once.scale_add(0.5, e))
}

/// A pose moved by its variables' step.
pub(super) fn moved(pose: &Pose, step: &[f64]) -> Pose {
    let turn = Vec3([step[3], step[4], step[5]]);
    let angle = turn.norm();
    let base_quat = if angle > 1e-12 {
        let by = Quat::from_axis_angle(turn.scale(1.0 / angle), angle);
        by.mul(Quat(pose.base_quat)).normalize().0
    } else {
        pose.base_quat
    };
    Pose {
        base_pos: std::array::from_fn(|k| pose.base_pos[k] + step[k]),
        base_quat,
        joints: pose.joints.iter().zip(&step[6..]).map(|(q, s)| q + s).collect(),
    }
}

fn unit(k: usize) -> Vec3<f64> {
    let mut dir = [0.0; 3];
    dir[k] = 1.0;
    Vec3(dir)
}
