//! Where a human's feet and hands are, beside those of the clip that was made of it.

use paid_lanes::{Quat, Vec3};
use paid_motion::Clip;
use paid_motion::clean::CleanReport;
use paid_robot::RobotModel;
use serde::Serialize;

use crate::{Goals, Role, Table};

/// The way of a part of the human.
#[derive(Clone, Debug, PartialEq)]
struct Way {
    role: Role,
    /// The robot's body that follows it, and the point of it that does `[m, body frame]`.
    body: usize,
    point: [f64; 3],
    /// World, each frame `[m]`.
    pos: Vec<[f64; 3]>,
}

/// Where a human, scaled to the robot's size, has its feet and hands, in the clip's world and at its frame rate.
#[derive(Clone, Debug, PartialEq)]
pub struct Ends(Vec<Way>);

/// Distances of a cleaned clip from the scaled human, mean and largest over the human's frames that were kept `[m]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct EndDistance {
    /// Of both feet.
    pub feet_m: [f64; 2],
    /// Of both hands.
    pub hands_m: [f64; 2],
}

const FEET: [Role; 2] = [Role::LeftFoot, Role::RightFoot];
const HANDS: [Role; 2] = [Role::LeftHand, Role::RightHand];

impl Ends {
    pub(crate) fn new(model: &RobotModel, table: &Table, goals: &Goals) -> Self {
        let ends = table.tasks.iter().enumerate();
        let ends = ends.filter(|(_, task)| FEET.contains(&task.role) || HANDS.contains(&task.role));
        let way = |(k, task): (usize, &crate::BodyTask)| {
            let pos = (0..goals.frames).filter_map(|t| goals.frame(t).get(k).map(|goal| goal.pos[1]));
            let body = model.body_index(task.body)?;
            Some(Way { role: task.role, body, point: task.point, pos: pos.collect() })
        };
        Self(ends.filter_map(way).collect())
    }

    /// What was at `p` is then at `turn` applied to `p - from`.
    pub(crate) fn moved(&mut self, (turn, from): (Quat<f64>, Vec3<f64>)) {
        self.each(|p| turn.rotate(p - from));
    }

    pub(crate) fn lower(&mut self, by: f64) {
        self.each(|p| p - Vec3([0.0, 0.0, by]));
    }

    fn each(&mut self, change: impl Fn(Vec3<f64>) -> Vec3<f64>) {
        for p in self.0.iter_mut().flat_map(|way| &mut way.pos) {
            *p = change(Vec3(*p)).0;
        }
    }

    /// How far the clip `cleaned`, made of the retargeted one of `fps` `[Hz]`, is from the human. `report` says which frames it has of it.
    pub fn distance(&self, fps: f64, cleaned: &Clip, report: &CleanReport) -> EndDistance {
        let kept = report.added[0]..cleaned.frames.saturating_sub(report.added[1]);
        let of = |roles: [Role; 2]| {
            let (mut sum, mut count, mut most) = (0.0, 0, 0.0_f64);
            for way in self.0.iter().filter(|way| roles.contains(&way.role)) {
                for t in kept.clone() {
                    let frame =
                        (t - report.added[0] + report.cut[0]) as f64 / cleaned.fps * fps / report.slow;
                    let Some(human) = between(&way.pos, frame) else { continue };
                    let turn = Quat(cleaned.body_quat(t)[way.body]);
                    let robot = Vec3(cleaned.body_pos(t)[way.body]) + turn.rotate(Vec3(way.point));
                    let off = (robot - human + Vec3([0.0, 0.0, report.floor_m])).norm();
                    (sum, count, most) = (sum + off, count + 1, most.max(off));
                }
            }
            [sum / f64::from(count.max(1)), most]
        };
        EndDistance { feet_m: of(FEET), hands_m: of(HANDS) }
    }
}

/// The place at a frame that need not be whole, held at the end.
fn between(way: &[[f64; 3]], frame: f64) -> Option<Vec3<f64>> {
    let last = way.len().checked_sub(1)?;
    let at = (frame.max(0.0) as usize).min(last);
    let share = (frame - at as f64).clamp(0.0, 1.0);
    let (a, b) = (Vec3(way[at]), Vec3(way[(at + 1).min(last)]));
    Some((b - a).scale_add(share, a))
}
