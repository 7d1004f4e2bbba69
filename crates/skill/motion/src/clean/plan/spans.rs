//! Which frames are kept, and stances prolonged into flights.

use super::super::figure::{Figure, Frame};
use super::super::stance::{self, Span};
use crate::GRAVITY;

/// A base slower than this stands `[m/s]`.
const CALM: f64 = 0.15;
/// A stance is prolonged by at most this to shorten a flight `[s]`.
const FILL: f64 = 0.04;

/// The frames that are kept, at most `lead_s` before the kick: from the first calm stand (or the first frame) to the first stand after the kick that can be held.
pub(super) fn keep(
    figure: &Figure<'_>,
    frames: &[Frame],
    spans: &[Vec<Span>; 2],
    fps: f64,
    (lead_s, kick): (f64, usize),
) -> Span {
    let both = |t: usize| stance::stands(&spans[0], t) && stance::stands(&spans[1], t);
    let speed = |t: usize| {
        let (a, b) = (t.saturating_sub(1), (t + 1).min(frames.len() - 1));
        (frames[b].pos[0] - frames[a].pos[0]).scale(fps / (b - a).max(1) as f64)
    };
    let earliest = kick.saturating_sub((lead_s * fps) as usize);
    let latest = kick.saturating_sub((0.4 * fps) as usize);
    let start = (earliest..latest)
        .find(|&t| both(t) && speed(t).norm() < CALM)
        .filter(|&t| t < earliest + (1.5 * fps) as usize)
        .or_else(|| (earliest..latest).find(|&t| both(t)).filter(|&t| t < earliest + (0.5 * fps) as usize))
        .unwrap_or(earliest);
    // How far the point at which the robot comes to rest (LIPM) is from the middle of the feet.
    let reach = |t: usize| {
        let pos = frames[t].pos[0];
        let rest = pos + speed(t).scale((pos.z().max(0.1) / GRAVITY).sqrt());
        let [a, b] = figure.feet.map(|foot| frames[t].pos[foot]);
        let middle = (a + b).scale(0.5);
        let spread = 0.5 * (a - b).norm();
        (rest.x() - middle.x()).hypot(rest.y() - middle.y()) - spread
    };
    let after = (kick + (0.1 * fps) as usize).min(frames.len() - 1);
    let candidates: Vec<usize> = (after..frames.len()).filter(|&t| both(t)).collect();
    let end = candidates
        .iter()
        .copied()
        .find(|&t| reach(t) < 0.02)
        .or_else(|| candidates.iter().copied().min_by(|a, b| reach(*a).total_cmp(&reach(*b))))
        .unwrap_or(frames.len() - 1);
    [start, end + 1]
}

/// Prolongs stances into flights.
pub(super) fn fill(mut spans: [Vec<Span>; 2], kept: Span, fps: f64) -> [Vec<Span>; 2] {
    let most = (FILL * fps).round() as usize;
    let stands = |spans: &[Vec<Span>; 2], t: usize| (0..2).any(|s| stance::stands(&spans[s], t));
    let mut t = kept[0];
    while t < kept[1] {
        if stands(&spans, t) {
            t += 1;
            continue;
        }
        let from = t;
        while t < kept[1] && !stands(&spans, t) {
            t += 1;
        }
        // Two frames of both feet, if it is short enough.
        let each = ((t - from).div_ceil(2) + 1).min(most);
        for list in &mut spans {
            for span in list {
                if span[1] == from {
                    span[1] = (from + each).min(kept[1]);
                }
                if span[0] == t {
                    span[0] = t.saturating_sub(each).max(kept[0]);
                }
            }
        }
    }
    // The same foot's stances may have met.
    spans.map(|list| {
        let mut out: Vec<Span> = Vec::new();
        for span in list {
            match out.last_mut() {
                Some(before) if before[1] + 1 >= span[0] => before[1] = before[1].max(span[1]),
                _ => out.push(span),
            }
        }
        out
    })
}
