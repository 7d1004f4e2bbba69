//! Feet, floor, the parts of the robot and what the floor carries.

use paid_lanes::Vec3;

use super::super::collide;
use super::super::figure::Frame;
use super::super::momentum::{Functional, Push};
use super::super::plan::Swing;
use super::super::rows::Row;
use super::sum::Sum;
use super::{Problem, room, turn_slope, unit, width};
use crate::{GRAVITY, rotation_log};

impl Problem<'_> {
    /// Footholds, ways through the air, the floor.
    pub(super) fn feet(&self, frames: &[Frame], t: usize, sum: &mut Sum<'_>) {
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
                Swing::Strike => (width::STRIKE, width::SWING_TURN),
                Swing::Free => (width::SWING, width::SWING_TURN),
                Swing::Near => (3.0 * width::SWING, 2.0 * width::SWING_TURN),
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
    pub(super) fn still(&self, frames: &[Frame], t: usize, sum: &mut Sum<'_>) {
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
    pub(super) fn apart(&self, frame: &Frame, t: usize, sum: &mut Sum<'_>) {
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
    pub(super) fn ground(&self, frames: &[Frame], pushes: &[Push], t: usize, sum: &mut Sum<'_>) {
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
}
