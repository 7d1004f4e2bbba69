//! Which soles stand, from the poses alone.

use paid_lanes::stats::quantile;
use paid_lanes::{Quat, Vec3};
use paid_robot::{RobotModel, Shape};

use crate::Clip;

/// Sole points lower than this above the foot's own floor may stand `[m]`.
const NEAR: f64 = 0.02;
/// Sole points that move faster do not stand `[m/s]`.
const SLOW: f64 = 0.35;

/// One foot over a clip.
#[derive(Clone, Debug, PartialEq)]
pub struct FootContact {
    /// For each frame the sole points that stand, world x, y `[m]`.
    pub standing: Vec<Vec<[f64; 2]>>,
    /// For each frame the speed at which the stillest of the low points moves along the floor, 0 in the air `[m/s]`.
    pub slide: Vec<f64>,
    /// Where the lowest point of the sole is while the foot rests: the median of the frames in which it is slow `[m]`. Other than
    /// zero in clips that hover.
    pub floor: f64,
}

/// The lowest points of a foot: below the balls of class `sole`, else of all that is of class `collision`.
fn sole_points(model: &RobotModel, foot: usize) -> Vec<([f64; 3], f64)> {
    let points = |class: &str| -> Vec<([f64; 3], f64)> {
        let geoms = model.bodies[foot].geoms.iter().filter(|g| g.class == class);
        geoms
            .flat_map(|g| match g.shape {
                Shape::Sphere { center, radius } => vec![(center, radius)],
                Shape::Capsule { ends, radius } => ends.map(|end| (end, radius)).to_vec(),
                Shape::Box { center, .. } => vec![(center, 0.0)],
            })
            .collect()
    };
    let soles = points("sole");
    if soles.is_empty() { points("collision") } else { soles }
}

/// Contact of the feet, in the order given.
pub fn foot_contacts(clip: &Clip, model: &RobotModel, feet: &[usize]) -> Vec<FootContact> {
    feet.iter().map(|&foot| contact(clip, model, foot)).collect()
}

fn contact(clip: &Clip, model: &RobotModel, foot: usize) -> FootContact {
    let soles = sole_points(model, foot);
    let place = |t: usize| -> Vec<Vec3<f64>> {
        let (pos, quat) = (Vec3(clip.body_pos(t)[foot]), Quat(clip.body_quat(t)[foot]));
        let point = |&(p, r): &([f64; 3], f64)| pos + quat.rotate(Vec3(p)) - Vec3([0.0, 0.0, r]);
        soles.iter().map(point).collect()
    };
    let places: Vec<Vec<Vec3<f64>>> = (0..clip.frames).map(place).collect();
    let floor = resting_height(clip, foot, &places);
    let (mut standing, mut slide) = (Vec::new(), Vec::new());
    for t in 0..clip.frames {
        let (a, b) = (t.saturating_sub(1), (t + 1).min(clip.frames - 1));
        let rate = clip.fps / (b - a).max(1) as f64;
        let mut down = Vec::new();
        let mut stillest = f64::INFINITY;
        for (i, point) in places[t].iter().enumerate() {
            if point.z() > floor + NEAR {
                continue;
            }
            let velocity = (places[b][i] - places[a][i]).scale(rate);
            stillest = stillest.min(velocity.x().hypot(velocity.y()));
            if velocity.norm() < SLOW {
                down.push([point.x(), point.y()]);
            }
        }
        standing.push(down);
        // Faster than this a low foot swings, it does not stand and slide.
        slide.push(if stillest < 2.0 * SLOW { stillest } else { 0.0 });
    }
    FootContact { standing, slide, floor }
}

fn resting_height(clip: &Clip, foot: usize, places: &[Vec<Vec3<f64>>]) -> f64 {
    let lowest = |t: usize| places[t].iter().map(Vec3::z).fold(f64::INFINITY, f64::min);
    let still = |t: &usize| Vec3(clip.body_lin_vel(*t)[foot]).norm() < 0.5 * SLOW;
    let mut heights: Vec<f64> = (0..clip.frames).filter(still).map(lowest).collect();
    quantile(&mut heights, 0.5).unwrap_or_else(|| (0..clip.frames).map(lowest).fold(f64::INFINITY, f64::min))
}

impl FootContact {
    /// The longest distance of sliding in one stance `[m]` and the frame where that stance ends.
    pub fn longest_slide(&self, fps: f64) -> (f64, usize) {
        let (mut worst, mut way) = ((0.0, 0), 0.0);
        for t in 0..self.slide.len() {
            way = if self.standing[t].is_empty() { 0.0 } else { way + self.slide[t] / fps };
            if way > worst.0 {
                worst = (way, t);
            }
        }
        worst
    }
}
