//! Paths from above: where robot and ball went.

use crate::{Anchor, Figure, Rgb};

/// Pixels a meter.
const SCALE: f64 = 90.0;
/// Space around the paths in pixels.
const MARGIN: f64 = 30.0;
/// A point that is nearer than this to the line between its neighbors is left out, in pixels.
const APART: f64 = 0.7;

const INK: Rgb = [30, 30, 30];
const ROBOT: Rgb = [90, 110, 200];
const GOAL: Rgb = [30, 150, 60];
const MISS: Rgb = [210, 60, 50];

/// One trial, in the goal's axes: past the goal plane (negative in front of it) and left of the goal's center `[m]`.
#[derive(Clone, Debug)]
pub struct Path<'a> {
    /// Base and ball after every step.
    pub points: &'a [[[f64; 2]; 2]],
    /// True if it scored.
    pub goal: bool,
}

/// All trials in one plot: goal plane at the top, ball paths green for goals and red for the rest, robots blue. `half_width` is
/// that of the goal `[m]`.
pub fn plot_paths(paths: &[Path], half_width: f64) -> Figure {
    let shown = |p: &[f64; 2]| p[0].abs() < 8.0 && p[1].abs() < 6.0;
    let points = || paths.iter().flat_map(|p| p.points.iter().flatten()).filter(|p| shown(p));
    let near = points().map(|p| p[0]).fold(-1.0, f64::min);
    let wide = points().map(|p| p[1].abs()).fold(half_width + 0.5, f64::max);
    let far = 0.5;
    let width = (2.0 * (wide * SCALE + MARGIN)) as i64;
    let height = ((far - near) * SCALE + 2.0 * MARGIN) as i64;
    let place = |p: [f64; 2]| [width as f64 / 2.0 - p[1] * SCALE, MARGIN + (far - p[0]) * SCALE];
    let mut figure = Figure::new(width, height);
    for meter in 0..=8 {
        let y = place([-f64::from(meter), 0.0])[1];
        figure.line(vec![[0.0, y], [width as f64, y]], 1, [225; 3]);
        figure.colored_text([4, y as i64 + 13], 14, Anchor::Start, [150; 3], &format!("{meter} m"));
    }
    // Few paths are lines, hundreds a cloud that is darkest where most of them are; misses lie on top.
    let cover = (12.0 / paths.len().max(1) as f64).sqrt().clamp(0.12, 1.0);
    let color_of = |path: &Path| if path.goal { GOAL } else { MISS };
    let layers = [(0, true), (0, false), (1, true), (1, false)];
    for (k, goal) in layers {
        for path in paths.iter().filter(|path| path.goal == goal) {
            let (color, cover) = match (k, goal) {
                (0, _) => (ROBOT, 0.6 * cover),
                (_, true) => (GOAL, cover),
                (_, false) => (MISS, cover.max(0.7)),
            };
            // A ball past the goal, or far from everything, is of no interest: the path is cut there.
            let pieces = path.points.split(|p| p[k][0] >= far || !shown(&p[k]));
            for piece in pieces {
                let line = thinned(piece.iter().map(|p| place(p[k])));
                if line.len() > 1 {
                    figure.trace(line, if k == 1 { 2 } else { 1 }, color, cover);
                }
            }
        }
    }
    for path in paths {
        if let Some([robot, ball]) = path.points.first() {
            figure.disc(place(*robot), 2.0, ROBOT);
            figure.disc(place(*ball), 2.0, color_of(path));
        }
    }
    figure.line(vec![place([0.0, half_width]), place([0.0, -half_width])], 5, INK);
    figure
}

/// The path with as few points as stay within [`APART`] of it (Douglas and Peucker): hundreds of trials with hundreds of steps must stay a
/// small file.
fn thinned(points: impl Iterator<Item = [f64; 2]>) -> Vec<[f64; 2]> {
    let points: Vec<[f64; 2]> = points.collect();
    let Some(last) = points.len().checked_sub(1) else { return points };
    let mut kept = vec![false; points.len()];
    (kept[0], kept[last]) = (true, true);
    let mut spans = vec![(0, last)];
    while let Some((a, b)) = spans.pop() {
        let [from, to] = [points[a], points[b]];
        let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
        let squared = dx * dx + dy * dy;
        let off = |p: &[f64; 2]| {
            let (x, y) = (p[0] - from[0], p[1] - from[1]);
            let along = if squared > 0.0 { ((x * dx + y * dy) / squared).clamp(0.0, 1.0) } else { 0.0 };
            (x - along * dx).hypot(y - along * dy)
        };
        let farthest = (a + 1..b).max_by(|i, j| off(&points[*i]).total_cmp(&off(&points[*j])));
        if let Some(k) = farthest.filter(|k| off(&points[*k]) > APART) {
            kept[k] = true;
            spans.extend([(a, k), (k, b)]);
        }
    }
    points.into_iter().zip(kept).filter_map(|(point, kept)| kept.then_some(point)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_goal_is_green_and_reaches_the_line() {
        let points: Vec<_> = (0..50).map(|i| [[-5.0, 0.0], [-4.0 + 0.1 * f64::from(i), 0.4]]).collect();
        let figure = plot_paths(&[Path { points: &points, goal: true }], 1.0);
        let image = figure.canvas();
        let column = |x: usize| (0..image.height()).filter(|&y| image.get(x, y) == GOAL).count();
        let x = (image.width() as f64 / 2.0 - 0.4 * SCALE).round() as usize;
        assert!(column(x) > 300, "four meters of ball path at 90 pixels a meter, found {}", column(x));
        assert_eq!(
            (0..image.width())
                .map(|x| (0..image.height()).filter(|&y| image.get(x, y) == MISS).count())
                .sum::<usize>(),
            0
        );
    }

    #[test]
    fn a_path_of_many_steps_is_thinned_but_keeps_its_ends() {
        let still: Vec<_> = (0..500).map(|_| [[-5.0, 0.0], [-4.0, 0.4]]).collect();
        let svg = plot_paths(&[Path { points: &still, goal: false }], 1.0).svg();
        assert!(svg.len() < 5000, "{} bytes for a robot and a ball at rest", svg.len());
        let line: Vec<_> = (0..=100).map(|i| [0.1 * f64::from(i), 0.0]).collect();
        assert_eq!(thinned(line.into_iter()), [[0.0, 0.0], [10.0, 0.0]]);
        let corner: Vec<_> = (0..=20).map(|i| [f64::from(i.min(10)), f64::from((i - 10).max(0))]).collect();
        assert_eq!(thinned(corner.into_iter()), [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0]]);
        assert_eq!(thinned(std::iter::once([1.0, 2.0])), [[1.0, 2.0]]);
    }
}
