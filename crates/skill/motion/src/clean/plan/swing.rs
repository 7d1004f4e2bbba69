//! A foot's way through the whole motion.

use paid_lanes::{Quat, Vec3};

use super::super::figure::{Figure, Frame};
use super::super::stance::Span;
use super::FootGoal;
use super::foothold::Foothold;
use crate::generate::{Pose, bump, min_jerk};
use crate::slerp;

/// Height of an added step `[m]`.
const STEP_HEIGHT: f64 = 0.05;
/// Height over the floor that a foot in the air keeps `[m]`.
const CLEAR: f64 = 0.006;
/// Distance in which a step passes the other foot `[m]`.
const PASSING: f64 = 0.16;
/// A foot that the original tilts by less is flat, and the most by which it is tilted while it stands `[rad]`.
const FLAT: f64 = 0.12;
const ROLL: f64 = 0.6;
/// Time about the kick in which the foot's path is kept exactly `[s]`.
const STRIKE: f64 = 0.10;
/// Time before and after a stance in which a foot may leave its path `[s]`.
const BLEND: f64 = 0.06;

/// How closely a foot in the air follows the original.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in super::super) enum Swing {
    /// At the kick.
    Strike,
    /// Elsewhere in the air.
    Free,
    /// Just before or after it stands.
    Near,
}

/// Pitch of a foot that stands in `span`: flat, but on its toes before it leaves and on its heel after it comes down for as long as the
/// original is.
fn roll_over(pitches: &[f64], span: Span, t: usize) -> f64 {
    let most = |pitch: f64| (pitch - FLAT).min(ROLL);
    if span[1] < pitches.len() && pitches[t..span[1]].iter().all(|p| *p > FLAT) {
        most(pitches[t])
    } else if span[0] > 0 && pitches[span[0]..=t].iter().all(|p| *p < -FLAT) {
        -most(-pitches[t])
    } else {
        0.0
    }
}

/// How far the middle of a step goes to the side, so that it passes the foot that stands.
fn around(from: Vec3<f64>, to: Vec3<f64>, other: Vec3<f64>) -> Vec3<f64> {
    let way = Vec3([to.x() - from.x(), to.y() - from.y(), 0.0]);
    let off = Vec3([other.x() - from.x(), other.y() - from.y(), 0.0]);
    let along = (off.dot(way) / way.norm2().max(1e-9)).clamp(0.0, 1.0);
    let near = way.scale(along) - off;
    // The side on which it ends is the side on which it passes.
    let end = Vec3([to.x() - other.x(), to.y() - other.y(), 0.0]);
    let distance = near.norm();
    if distance >= PASSING {
        return Vec3::zero();
    }
    let left = Vec3([-way.y(), way.x(), 0.0]);
    let left = left.scale(1.0 / left.norm().max(1e-9));
    let sign = if end.dot(left) + near.dot(left) >= 0.0 { 1.0 } else { -1.0 };
    left.scale(sign * (PASSING - sign * near.dot(left)))
}

/// A foot's way: its footholds, and between them the original, moved by as much as the footholds were.
pub(super) fn goals(
    figure: &Figure<'_>,
    poses: &[Pose],
    side: usize,
    all_holds: &[Vec<(Span, Foothold)>; 2],
    strike: Option<usize>,
    kept: Span,
    fps: f64,
) -> Vec<FootGoal> {
    let foot = figure.feet[side];
    let holds = &all_holds[side];
    // The other foot, which stands while this one takes an added step.
    let beside = |t: usize| {
        let others = &all_holds[1 - side];
        others.iter().find(|(span, _)| span[1] > t).or(others.last()).map_or(holds[0].1, |(_, hold)| *hold)
    };
    let frames: Vec<Frame> = poses.iter().map(|p| figure.frame(p)).collect();
    let [blend, near] = [BLEND, STRIKE].map(|s| (s * fps).round() as usize);
    let pitches: Vec<f64> = frames
        .iter()
        .map(|f| {
            let ahead = f.quat[foot].rotate(Vec3([1.0, 0.0, 0.0]));
            (-ahead.z()).atan2(ahead.x().hypot(ahead.y()))
        })
        .collect();
    (0..poses.len())
        .map(|t| {
            if let Some((span, hold)) = holds.iter().find(|(span, _)| (span[0]..span[1]).contains(&t)) {
                let pitch = roll_over(&pitches, *span, t);
                return hold.goal(figure, side, pitch);
            }
            let before = holds.iter().rev().find(|(span, _)| span[1] <= t);
            let after = holds.iter().find(|(span, _)| span[0] > t);
            // An added step is not in the recording.
            if let (Some((a, from)), Some((b, to))) = (before, after)
                && (b[0] <= kept[0] || a[1] >= kept[1])
            {
                let s = (t + 1 - a[1]) as f64 / (b[0] + 1 - a[1]) as f64;
                let mut pos = from.pos + (to.pos - from.pos).scale(min_jerk(s));
                pos.0[2] += STEP_HEIGHT * bump(s);
                pos += (around(from.pos, to.pos, beside(t).pos)).scale(bump(s));
                let quat = Quat(slerp(from.quat().0, to.quat().0, min_jerk(s)));
                return FootGoal {
                    pivot: Vec3::zero(),
                    pos,
                    quat,
                    stands: false,
                    rolls: false,
                    width: Swing::Free,
                };
            }
            let off = |at: usize, hold: &Foothold| {
                let off = hold.pos - frames[at].pos[foot];
                // Heights are the original's: a heel that rises is no reason to lower the whole way.
                Vec3([off.x(), off.y(), 0.0])
            };
            let shift = match (before, after) {
                (Some((a, from)), Some((b, to))) => {
                    let (x, y) = (off(a[1] - 1, from), off(b[0], to));
                    let s = min_jerk((t + 1 - a[1]) as f64 / (b[0] + 1 - a[1]) as f64);
                    x + (y - x).scale(s)
                }
                (Some((a, hold)), None) => off(a[1] - 1, hold),
                (None, Some((b, hold))) => off(b[0], hold),
                (None, None) => Vec3::zero(),
            };
            let close = before.is_some_and(|(a, _)| t < a[1] + blend)
                || after.is_some_and(|(b, _)| t + blend >= b[0]);
            let width = match strike {
                Some(kick) if t.abs_diff(kick) <= near => Swing::Strike,
                _ if close => Swing::Near,
                _ => Swing::Free,
            };
            let (mut pos, quat) = (frames[t].pos[foot] + shift, frames[t].quat[foot]);
            let lowest =
                figure.sole_points(&frames[t], side).iter().map(Vec3::z).fold(f64::INFINITY, f64::min);
            pos.0[2] += (CLEAR - lowest).max(0.0);
            FootGoal { pivot: Vec3::zero(), pos, quat, stands: false, rolls: false, width }
        })
        .collect()
}
