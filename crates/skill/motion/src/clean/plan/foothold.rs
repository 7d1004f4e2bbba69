//! Where a foot stands, and where it shall be in a frame.

use paid_lanes::{Quat, Vec3};

use paid_lanes::stats::quantile;

use super::super::figure::{Figure, Frame};
use super::super::stance::Span;
use super::Swing;

/// Where a foot shall be in a frame.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct FootGoal {
    /// The point of the foot that is meant, foot frame `[m]`.
    pub pivot: Vec3<f64>,
    /// Where it shall be, world `[m]`.
    pub pos: Vec3<f64>,
    pub quat: Quat<f64>,
    pub stands: bool,
    /// It stands on its heel or its toes alone.
    pub rolls: bool,
    pub width: Swing,
}

/// A foot flat on the floor.
#[derive(Clone, Copy, Debug)]
pub(super) struct Foothold {
    /// World `[m]`.
    pub pos: Vec3<f64>,
    /// Heading `[rad]`.
    pub yaw: f64,
}

impl Foothold {
    /// Where a foot stands in a span: the median of its places while it is flattest.
    pub fn of(figure: &Figure<'_>, frames: &[Frame], side: usize, span: Span) -> Self {
        let foot = figure.feet[side];
        let tilt = |t: &usize| frames[*t].quat[foot].rotate(Vec3([0.0, 0.0, 1.0])).z();
        let mut order: Vec<usize> = (span[0]..span[1]).collect();
        order.sort_by(|a, b| tilt(b).total_cmp(&tilt(a)));
        order.truncate(order.len().div_ceil(2));
        let median = |of: &dyn Fn(usize) -> f64| {
            let mut values: Vec<f64> = order.iter().map(|t| of(*t)).collect();
            quantile(&mut values, 0.5).unwrap_or(0.0)
        };
        // Angles about that of one frame, so that none wraps.
        let yaw = |t: usize| frames[t].quat[foot].to_mat().yaw();
        let about = order.first().map_or(0.0, |t| yaw(*t));
        let turn = median(&|t| {
            let (s, c) = (yaw(t) - about).sin_cos();
            s.atan2(c)
        });
        let at = |k: usize| median(&|t| frames[t].pos[foot].0[k]);
        Self { pos: Vec3([at(0), at(1), figure.sole_height(side)]), yaw: about + turn }
    }

    pub fn quat(&self) -> Quat<f64> {
        Quat::from_axis_angle(Vec3([0.0, 0.0, 1.0]), self.yaw)
    }

    /// The foot on this place, toes down by `pitch` about its toes or up about its heel.
    pub fn goal(&self, figure: &Figure<'_>, side: usize, pitch: f64) -> FootGoal {
        let rolls = pitch != 0.0;
        let pivot = if rolls { edge(figure, side, pitch > 0.0) } else { Vec3::zero() };
        let quat = Quat::from_roll_pitch_yaw(0.0, pitch, self.yaw);
        let pos = self.pos + self.quat().rotate(pivot);
        FootGoal { pivot, pos, quat, stands: true, rolls, width: Swing::Near }
    }
}

/// The middle of the toes' or the heel's balls, foot frame `[m]`.
fn edge(figure: &Figure<'_>, side: usize, toes: bool) -> Vec3<f64> {
    let soles = figure.soles[side].iter().map(|(p, _)| *p);
    let (low, high) =
        soles.clone().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p.x()), h.max(p.x())));
    let x = if toes { high } else { low };
    let z = soles.map(|p| p.z()).fold(f64::INFINITY, f64::min);
    Vec3([x, 0.0, z])
}
