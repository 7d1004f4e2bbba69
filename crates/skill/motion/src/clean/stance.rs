//! When which foot stands, as the recording means it: less strict than [`crate::check`], which rates the clip as it is.

use paid_lanes::Vec3;

use super::figure::{Figure, Frame};

/// A foot whose lowest point is higher than this above the floor is in the air `[m]`.
const NEAR: f64 = 0.06;
/// The lowest points of a foot that stands are slower than this `[m/s]`.
const SLOW: f64 = 0.55;
/// Gaps shorter than this are no swing, and stances shorter than this are none `[s]`.
const BRIEF: f64 = 0.07;
/// Points within this of a foot's lowest are its lowest points `[m]`.
const LEVEL: f64 = 0.03;

/// A span of frames, first and one past the last.
pub(super) type Span = [usize; 2];

/// For each foot the frames in which it stands.
pub(super) fn find(figure: &Figure<'_>, frames: &[Frame], fps: f64, floor: f64) -> [Vec<Span>; 2] {
    [0, 1].map(|side| {
        let points: Vec<Vec<Vec3<f64>>> = frames.iter().map(|f| figure.sole_points(f, side)).collect();
        let last = frames.len() - 1;
        let stands: Vec<bool> = (0..frames.len())
            .map(|t| {
                let (a, b) = (t.saturating_sub(1), (t + 1).min(last));
                let rate = fps / (b - a).max(1) as f64;
                let lowest = points[t].iter().map(Vec3::z).fold(f64::INFINITY, f64::min);
                let slowest = points[t]
                    .iter()
                    .enumerate()
                    .filter(|(_, p)| p.z() < lowest + LEVEL)
                    .map(|(i, _)| (points[b][i] - points[a][i]).scale(rate).norm())
                    .fold(f64::INFINITY, f64::min);
                lowest < floor + NEAR && slowest < SLOW
            })
            .collect();
        let brief = (BRIEF * fps).round() as usize;
        let mut out: Vec<Span> = Vec::new();
        for (t, _) in stands.iter().enumerate().filter(|(_, s)| **s) {
            match out.last_mut() {
                Some(span) if t <= span[1] + brief => span[1] = t + 1,
                _ => out.push([t, t + 1]),
            }
        }
        out.retain(|span| span[1] - span[0] > brief);
        out
    })
}

/// Height of the lowest sole point while a foot is slow: the median over both feet `[m]`.
pub(super) fn floor(figure: &Figure<'_>, frames: &[Frame], fps: f64) -> f64 {
    let mut heights = Vec::new();
    for side in 0..2 {
        for pair in frames.windows(2) {
            let (a, b) = (figure.sole_points(&pair[0], side), figure.sole_points(&pair[1], side));
            let low = |points: &[Vec3<f64>]| points.iter().map(Vec3::z).fold(f64::INFINITY, f64::min);
            let slow = a.iter().zip(&b).map(|(p, q)| (*q - *p).norm() * fps).fold(f64::INFINITY, f64::min);
            if slow < 0.5 * SLOW {
                heights.push(low(&a));
            }
        }
    }
    heights.sort_by(f64::total_cmp);
    heights.get(heights.len() / 2).copied().unwrap_or(0.0)
}

/// Whether a foot stands in a frame.
pub(super) fn stands(spans: &[Span], t: usize) -> bool {
    spans.iter().any(|s| (s[0]..s[1]).contains(&t))
}
