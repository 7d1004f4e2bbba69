//! Paths from above: where robot and ball went.

use super::{Canvas, Rgb};

/// Pixels a metre.
const SCALE: f64 = 90.0;
/// Space around the paths in pixels.
const MARGIN: f64 = 30.0;

const INK: Rgb = [30, 30, 30];
const ROBOT: Rgb = [90, 110, 200];
const GOAL: Rgb = [30, 150, 60];
const MISS: Rgb = [210, 60, 50];

/// One trial, in the goal's axes: past the goal plane (negative in front of it) and left of the goal's centre [m].
#[derive(Clone, Debug)]
pub struct Path<'a> {
    /// Base and ball after every step.
    pub points: &'a [[[f64; 2]; 2]],
    /// True if it scored.
    pub goal: bool,
}

/// All trials in one picture: goal plane at the top, ball paths green for goals and red for the rest, robots blue. `half_width` is
/// that of the goal [m].
pub fn plot_paths(paths: &[Path], half_width: f64) -> Canvas {
    let shown = |p: &[f64; 2]| p[0].abs() < 8.0 && p[1].abs() < 6.0;
    let points = || paths.iter().flat_map(|p| p.points.iter().flatten()).filter(|p| shown(p));
    let near = points().map(|p| p[0]).fold(-1.0, f64::min);
    let wide = points().map(|p| p[1].abs()).fold(half_width + 0.5, f64::max);
    let far = 0.5;
    let width = (2.0 * (wide * SCALE + MARGIN)) as usize;
    let height = ((far - near) * SCALE + 2.0 * MARGIN) as usize;
    let place = |p: [f64; 2]| [width as f64 / 2.0 - p[1] * SCALE, MARGIN + (far - p[0]) * SCALE];
    let mut image = Canvas::new(width, height, [255; 3]);
    for metre in 0..=8 {
        let y = place([-f64::from(metre), 0.0])[1];
        image.line([0.0, y], [width as f64, y], 1, [225; 3]);
        image.text(4, y as i64 + 3, 2, [150; 3], &format!("{metre} M"));
    }
    for path in paths {
        let ball_color = if path.goal { GOAL } else { MISS };
        for (k, color) in [(0, ROBOT), (1, ball_color)] {
            for pair in path.points.windows(2) {
                // A ball far past the goal is of no interest.
                if pair[1][k][0] < far && shown(&pair[0][k]) && shown(&pair[1][k]) {
                    image.line(place(pair[0][k]), place(pair[1][k]), 1, color);
                }
            }
        }
        if let Some([robot, ball]) = path.points.first() {
            image.disc(place(*robot), 3.0, ROBOT);
            image.disc(place(*ball), 3.0, ball_color);
        }
    }
    image.line(place([0.0, half_width]), place([0.0, -half_width]), 5, INK);
    image
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_goal_is_green_and_reaches_the_line() {
        let points: Vec<_> = (0..50).map(|i| [[-5.0, 0.0], [-4.0 + 0.1 * f64::from(i), 0.4]]).collect();
        let image = plot_paths(&[Path { points: &points, goal: true }], 1.0);
        let column = |x: usize| (0..image.height()).filter(|&y| image.get(x, y) == GOAL).count();
        let x = (image.width() as f64 / 2.0 - 0.4 * SCALE).round() as usize;
        assert!(column(x) > 300, "four metres of ball path at 90 pixels a metre, found {}", column(x));
        assert_eq!(
            (0..image.width())
                .map(|x| (0..image.height()).filter(|&y| image.get(x, y) == MISS).count())
                .sum::<usize>(),
            0
        );
    }
}
