//! The floor under the standing soles.

use paid_lanes::Vec3;

use super::super::figure::Figure;
use super::super::stance::Span;
use super::FootGoal;
use crate::hull;

/// Half the depth of the floor's contact with heel or toes alone `[m]`: the check lets the pressure be 2 cm outside of the balls.
const EDGE: f64 = 0.012;
/// Standing longer than this needs a wider margin of the pressure `[s]`.
const LONG: f64 = 0.4;
/// Margin of the center of pressure inside the soles: in passing, on one foot for long, on two for long `[m]`.
const MARGINS: [f64; 3] = [0.004, 0.008, 0.015];

/// The floor under the standing soles.
#[derive(Clone, Debug)]
pub(in super::super) struct Support {
    /// Counterclockwise, world x, y `[m]`.
    pub corners: Vec<[f64; 2]>,
    /// `[m]`.
    pub margin: f64,
}

/// The floor under the feet of each frame. A foot that has only just come down, or is about to leave, counts only if no other stands.
pub(super) fn support(figure: &Figure<'_>, feet: &[Vec<FootGoal>; 2], fps: f64) -> Vec<Option<Support>> {
    let long = (LONG * fps).round() as usize;
    let length = feet[0].len();
    let stance = |side: usize, t: usize| {
        let goals = &feet[side];
        let from = (0..=t).rev().find(|&s| !goals[s].stands).map_or(0, |s| s + 1);
        let to = (t..length).find(|&s| !goals[s].stands).unwrap_or(length);
        [from, to]
    };
    let corners = |side: usize, goal: &FootGoal| -> Vec<[f64; 2]> {
        let place = |p: Vec3<f64>| {
            let at = goal.pos + goal.quat.rotate(p - goal.pivot);
            [at.x(), at.y()]
        };
        let balls = figure.soles[side].iter().map(|(p, _)| *p);
        if goal.rolls {
            let near = balls.filter(|p| (p.x() - goal.pivot.x()).abs() < 1e-6);
            near.flat_map(|p| [-EDGE, EDGE].map(|d| place(p + Vec3([d, 0.0, 0.0])))).collect()
        } else {
            balls.map(place).collect()
        }
    };
    (0..length)
        .map(|t| {
            let standing: Vec<(usize, Span)> =
                (0..2).filter(|&s| feet[s][t].stands).map(|s| (s, stance(s, t))).collect();
            let firm = |span: Span| (span[0] == 0 || t > span[0]) && (span[1] == length || t + 1 < span[1]);
            let mut found: Vec<_> = standing.iter().copied().filter(|(_, span)| firm(*span)).collect();
            if found.is_empty() {
                found = standing;
            }
            let enduring = found.iter().all(|(s, span)| span[1] - span[0] >= long && !feet[*s][t].rolls);
            let margin = match (enduring, found.len()) {
                (_, 0) => return None,
                (false, _) => MARGINS[0],
                (true, 1) => MARGINS[1],
                (true, _) => MARGINS[2],
            };
            let points: Vec<[f64; 2]> = found.iter().flat_map(|(s, _)| corners(*s, &feet[*s][t])).collect();
            Some(Support { corners: hull(&points), margin })
        })
        .collect()
}
