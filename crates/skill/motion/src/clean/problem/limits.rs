//! What joints and motors can do.

use paid_lanes::Vec3;

use super::super::figure::Frame;
use super::super::momentum::{Functional, Push, pushes};
use super::sum::Sum;
use super::{Problem, room, width};
use crate::generate::Pose;

impl Problem<'_> {
    /// Ranges and speeds of the joints.
    pub(super) fn limits(&self, poses: &[Pose], t: usize, sum: &mut Sum<'_>) {
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

    /// Torques of the joints: inverse dynamics, with the floor's force at the feet that stand.
    pub(super) fn torques(
        &self,
        poses: &[Pose],
        frames: &[Frame],
        pushes: &[Push],
        t: usize,
        sum: &mut Sum<'_>,
    ) {
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
    pub(super) fn shares(&self, t: usize, j: usize) -> Vec<f64> {
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
}
