//! As the original is, as smooth, and at rest at its ends.

use super::super::figure::Frame;
use super::super::rows::Row;
use super::sum::Sum;
use super::{Problem, turn_slope, unit, width};
use crate::generate::Pose;
use crate::rotation_log;

impl Problem<'_> {
    pub(super) fn likeness(&self, poses: &[Pose], frames: &[Frame], t: usize, sum: &mut Sum<'_>) {
        let (pose, goal, first) = (&poses[t], &self.plan.poses[t], t * self.figure.n);
        // Added frames are not in the recording.
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
    pub(super) fn smoothness(&self, poses: &[Pose], t: usize, sum: &mut Sum<'_>) {
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

    /// At rest at both ends.
    pub(super) fn ends(&self, poses: &[Pose], sum: &mut Sum<'_>) {
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
