//! Forces and moments that a motion needs, and how they change with its frames.

use paid_lanes::Vec3;

use super::figure::{Figure, Frame};
use super::rows::Row;
use crate::{GRAVITY, rotation_log};

/// What moves a body: force at its center of mass `[N]` and moment about it `[N m]`, world axes, gravity's share included.
#[derive(Clone, Copy)]
pub(super) struct Push {
    pub force: Vec3<f64>,
    pub moment: Vec3<f64>,
}

/// Newton and Euler for every body of every frame, by second differences as [`crate::balance()`] has them. Before the first and
/// after the last frame the robot stands still.
pub(super) fn pushes(figure: &Figure<'_>, frames: &[Frame], fps: f64) -> Vec<Vec<Push>> {
    let bodies = &figure.model.bodies;
    let spin = |i: usize, a: &Frame, b: &Frame| {
        let omega = Vec3(rotation_log(a.quat[i].0, b.quat[i].0)).scale(fps);
        let about = |f: &Frame| f.quat[i].rotate(figure.inertia[i].mul_vec(f.quat[i].conj().rotate(omega)));
        (about(a) + about(b)).scale(0.5)
    };
    let spins: Vec<Vec<Vec3<f64>>> =
        frames.windows(2).map(|w| (0..bodies.len()).map(|i| spin(i, &w[0], &w[1])).collect()).collect();
    let last = frames.len() - 1;
    (0..frames.len())
        .map(|t| {
            let (before, now, after) = (&frames[t.saturating_sub(1)], &frames[t], &frames[(t + 1).min(last)]);
            bodies
                .iter()
                .enumerate()
                .map(|(i, body)| {
                    let acc = (after.com[i] - now.com[i].scale(2.0) + before.com[i]).scale(fps * fps);
                    let came = if t > 0 { spins[t - 1][i] } else { Vec3::zero() };
                    let goes = if t < last { spins[t][i] } else { Vec3::zero() };
                    Push {
                        force: (acc + Vec3([0.0, 0.0, GRAVITY])).scale(body.mass),
                        moment: (goes - came).scale(fps),
                    }
                })
                .collect()
        })
        .collect()
}

/// A number that the motion's forces decide: `turn . (moment about point) + shift . force`, of the bodies by their shares.
pub(super) struct Functional<'a> {
    pub turn: Vec3<f64>,
    pub point: Vec3<f64>,
    pub shift: Vec3<f64>,
    /// For each body.
    pub share: &'a [f64],
}

impl Functional<'_> {
    pub fn value(&self, frame: &Frame, pushes: &[Push]) -> f64 {
        let mut sum = 0.0;
        for (i, push) in pushes.iter().enumerate() {
            if self.share[i] != 0.0 {
                let about = (frame.com[i] - self.point).cross(push.force) + push.moment;
                sum += self.share[i] * (self.turn.dot(about) + self.shift.dot(push.force));
            }
        }
        sum
    }

    /// Force and moment about the point, summed up `[N, N m]`.
    pub fn total(&self, frame: &Frame, pushes: &[Push]) -> [Vec3<f64>; 2] {
        let mut sum = [Vec3::zero(); 2];
        for (i, push) in pushes.iter().enumerate() {
            let about = (frame.com[i] - self.point).cross(push.force) + push.moment;
            sum[0] += push.force.scale(self.share[i]);
            sum[1] += about.scale(self.share[i]);
        }
        sum
    }

    /// Adds the derivatives by the frames before, at and after `t` to a row. The change of the inertias with the pose is left out: it
    /// is small compared with that of the accelerations.
    pub fn add(
        &self,
        figure: &Figure<'_>,
        frames: &[Frame],
        pushes: &[Push],
        t: usize,
        fps: f64,
        row: &mut Row,
    ) {
        let last = frames.len() - 1;
        let mut now = Lever::new(figure);
        let (mut before, mut after) = (Lever::new(figure), Lever::new(figure));
        for (i, body) in figure.model.bodies.iter().enumerate() {
            if self.share[i] == 0.0 {
                continue;
            }
            let k = self.share[i] * fps * fps;
            let arm = frames[t].com[i] - self.point;
            let along = (self.turn.cross(arm) + self.shift).scale(k * body.mass);
            let quat = frames[t].quat[i];
            let about = quat.rotate(figure.inertia[i].mul_vec(quat.conj().rotate(self.turn))).scale(k);
            let lean = pushes[i].force.cross(self.turn).scale(self.share[i]);
            // Outside of the clip the robot stands as at its end, so there the end takes both parts.
            let ends = f64::from(u8::from(t == 0) + u8::from(t == last));
            now.push(i, frames[t].com[i], lean + along.scale(ends - 2.0), about.scale(ends - 2.0));
            if t > 0 {
                before.push(i, frames[t - 1].com[i], along, about);
            }
            if t < last {
                after.push(i, frames[t + 1].com[i], along, about);
            }
        }
        now.add(figure, &frames[t], t, row);
        if t > 0 {
            before.add(figure, &frames[t - 1], t - 1, row);
        }
        if t < last {
            after.add(figure, &frames[t + 1], t + 1, row);
        }
    }
}

/// Directions in which the bodies' centers and orientations count, summed up towards the base.
struct Lever {
    /// Sum of the directions.
    along: Vec<Vec3<f64>>,
    /// Sum of position x direction and of the turning directions.
    about: Vec<Vec3<f64>>,
}

impl Lever {
    fn new(figure: &Figure<'_>) -> Self {
        let zero = vec![Vec3::zero(); figure.model.bodies.len()];
        Self { along: zero.clone(), about: zero }
    }

    fn push(&mut self, body: usize, at: Vec3<f64>, along: Vec3<f64>, turn: Vec3<f64>) {
        self.along[body] += along;
        self.about[body] += at.cross(along) + turn;
    }

    fn add(mut self, figure: &Figure<'_>, frame: &Frame, t: usize, row: &mut Row) {
        for i in (1..self.along.len()).rev() {
            if let Some(parent) = figure.model.bodies[i].parent {
                let (along, about) = (self.along[i], self.about[i]);
                self.along[parent] += along;
                self.about[parent] += about;
            }
        }
        let first = t * figure.n;
        let about = |body: usize| self.about[body] - frame.pos[body].cross(self.along[body]);
        for k in 0..3 {
            row.add(first + k, self.along[0].0[k]);
            row.add(first + 3 + k, about(0).0[k]);
        }
        for (j, joint) in figure.model.joints.iter().enumerate() {
            row.add(first + 6 + j, frame.axis[j].dot(about(joint.body)));
        }
    }
}
