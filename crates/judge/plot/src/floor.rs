//! The floor seen from above.

use crate::{Anchor, Figure, Rgb};

/// Space around the floor: left, top, right, bottom, in pixels.
const MARGIN: [i64; 4] = [64, 64, 24, 56];
/// Least distance of the grid's lines `[m]`.
const GRID_M: f64 = 0.5;
/// Most cells of the grid along the floor's longer side.
const CELLS: f64 = 100.0;

const INK: Rgb = [30, 30, 30];
const GRID: Rgb = [225, 228, 232];

/// A piece of floor, seen from above: the robot looks up, its left is the plot's left.
#[derive(Clone, Debug, PartialEq)]
pub struct Floor {
    /// Range ahead `[m]`.
    pub ahead: [f64; 2],
    /// Range to the left `[m]`.
    pub left: [f64; 2],
    /// Pixels a meter.
    pub scale: f64,
}

impl Floor {
    /// The least floor with whole cells of half a meter around points (ahead, left) `[m]`, `pixels` high or wide at most.
    pub fn around(points: impl Iterator<Item = [f64; 2]>, pixels: f64) -> Self {
        let (mut lo, mut hi) = ([-GRID_M; 2], [GRID_M; 2]);
        for point in points.filter(|p| p.iter().all(|x| x.is_finite())) {
            for k in 0..2 {
                lo[k] = lo[k].min((point[k] / GRID_M).floor() * GRID_M);
                hi[k] = hi[k].max((point[k] / GRID_M).ceil() * GRID_M);
            }
        }
        let longest = (0..2).map(|k| hi[k] - lo[k]).fold(GRID_M, f64::max);
        Self { ahead: [lo[0], hi[0]], left: [lo[1], hi[1]], scale: pixels / longest }
    }

    /// Where a point (ahead, left) `[m]` is in the plot.
    pub fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [
            MARGIN[0] as f64 + (self.left[1] - y) * self.scale,
            MARGIN[1] as f64 + (self.ahead[1] - x) * self.scale,
        ]
    }

    /// Distance of the grid's lines: 0.5, 1, 2, 5, 10, ... `[m]`.
    fn step(&self) -> f64 {
        let longest = (self.ahead[1] - self.ahead[0]).max(self.left[1] - self.left[0]);
        let mut step = GRID_M;
        for factor in [2.0, 2.0, 2.5].into_iter().cycle() {
            if longest <= CELLS * step || !longest.is_finite() {
                break;
            }
            step *= factor;
        }
        step
    }

    /// Where lines cross a range of the floor `[m]`.
    fn lines(&self, [from, to]: [f64; 2]) -> impl Iterator<Item = f64> {
        let step = self.step();
        ((from / step).ceil() as i64..=(to / step + 1e-9).floor() as i64).map(move |i| i as f64 * step)
    }

    /// The empty floor with its grid and axes.
    pub fn figure(&self, title: &str) -> Figure {
        let [right, bottom] = self.place([self.ahead[0], self.left[0]]).map(|n| n.round() as i64);
        let mut figure = Figure::new(right + MARGIN[2], bottom + MARGIN[3]);
        figure.text([12, 28], 20, Anchor::Start, title);
        for x in self.lines(self.ahead) {
            let ends = [self.left[1], self.left[0]].map(|y| self.place([x, y]));
            let [px, py] = ends[0].map(|n| n.round() as i64);
            figure.line(ends.to_vec(), 1, if x == 0.0 { INK } else { GRID });
            figure.text([px - 8, py + 5], 14, Anchor::End, &format!("{x:.1}"));
        }
        for y in self.lines(self.left) {
            let ends = [self.ahead[1], self.ahead[0]].map(|x| self.place([x, y]));
            let [px, py] = ends[1].map(|n| n.round() as i64);
            figure.line(ends.to_vec(), 1, if y == 0.0 { INK } else { GRID });
            figure.text([px, py + 20], 14, Anchor::Middle, &format!("{y:.1}"));
        }
        figure.text([12, MARGIN[1] - 14], 14, Anchor::Start, "ahead [m]");
        figure.text([right, bottom + 44], 14, Anchor::End, "to the left [m]");
        figure
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ahead_is_up_and_left_is_left() {
        let floor = Floor::around([[1.2, -0.7], [0.3, 0.1]].into_iter(), 600.0);
        assert_eq!((floor.ahead, floor.left, floor.scale), ([-0.5, 1.5], [-1.0, 0.5], 300.0));
        let at = |p| floor.place(p);
        assert_eq!(at([1.5, 0.5]), [64.0, 64.0], "the far left corner");
        assert_eq!(at([-0.5, -1.0]), [64.0 + 450.0, 64.0 + 600.0], "the near right corner");
        let svg = floor.figure("a < b").svg();
        assert!(svg.contains("a &lt; b") && svg.contains("ahead [m]") && svg.contains("to the left [m]"));
    }

    #[test]
    fn a_wide_floor_has_a_wide_grid() {
        let small = Floor::around([[1.2, 0.0]].into_iter(), 600.0);
        assert_eq!(small.lines(small.ahead).collect::<Vec<_>>(), [-0.5, 0.0, 0.5, 1.0, 1.5]);
        let step = |far: f64| Floor::around([[far, 0.0]].into_iter(), 600.0).step();
        // Half a meter behind the origin belongs to the floor: 100 cells of 0.5 m reach to 49.5 m.
        assert_eq!([step(49.5), step(50.0), step(199.5), step(200.0)], [0.5, 1.0, 2.0, 5.0]);
        let wide = Floor::around([[1000.0, 0.0]].into_iter(), 600.0);
        assert_eq!(wide.step(), 20.0, "1000.5 m are more than 100 cells of 10 m");
        assert_eq!((wide.lines(wide.ahead).count(), wide.lines(wide.left).count()), (51, 1));
        let far = Floor::around([[1e11, -1e11]].into_iter(), 600.0);
        assert!(far.lines(far.ahead).count() + far.lines(far.left).count() <= 202);
    }
}
