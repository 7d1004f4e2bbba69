//! The one optimization over a whole clip: its cost, a sum of squares.

mod contact;
mod likeness;
mod limits;
mod room;
mod sum;
mod width;

use paid_lanes::{Quat, Vec3};

use super::figure::{Figure, Frame};
use super::momentum::pushes;
use super::plan::Plan;
use super::rows::{Band, Row};
use crate::generate::Pose;
use sum::Sum;

pub(super) struct Problem<'a> {
    pub figure: &'a Figure<'a>,
    pub plan: &'a Plan,
    /// Share of the torque limits that may be used.
    pub torque_share: f64,
    /// Weight of the conditions, as a factor of what `width` says.
    pub stress: f64,
    /// Bodies beyond each joint.
    beyond: Vec<Vec<bool>>,
    /// How the feet share the floor's force in each frame.
    carried: Vec<[f64; 2]>,
    /// The original's bodies.
    goal: Vec<Frame>,
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

    /// Sets the weight of the conditions, and from `poses` how the feet share the floor's force. Both stay as they are
    /// until the next call, so that the cost is smooth.
    pub fn set(&mut self, stress: f64, poses: &[Pose]) {
        self.stress = stress;
        let each = |(t, pose): (usize, &Pose)| carried(self.figure, self.plan, &self.figure.frame(pose), t);
        self.carried = poses.iter().enumerate().map(each).collect();
    }

    /// The sum of squares, not half of it. With a band also its normal equations.
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
