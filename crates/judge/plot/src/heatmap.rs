//! Values over the grid of ball places.

use crate::{Anchor, Figure, Rgb};

/// Side of a cell in pixels.
const CELL: i64 = 56;
/// Space for titles and axes.
const MARGIN: i64 = 64;

const INK: Rgb = [30, 30, 30];

/// A grid of values, seen from above: the robot is at the bottom and looks up, its left is the plot's left.
#[derive(Clone, Debug)]
pub struct HeatMap {
    /// Title.
    pub title: String,
    /// Places ahead `[m]`, near to far.
    pub x: Vec<f64>,
    /// Places to the left `[m]`, right to left.
    pub y: Vec<f64>,
    /// Values `[x][y]`; `None` where there is none.
    pub values: Vec<Vec<Option<f64>>>,
    /// The value of the coldest color.
    pub low: f64,
    /// The value of the hottest color.
    pub high: f64,
    /// Factor and decimals of the printed numbers.
    pub print: (f64, usize),
}

/// The color of a share between 0 and 1: dark blue, green, yellow.
pub fn color_of(share: f64) -> Rgb {
    const STOPS: [[f64; 3]; 5] = [
        [50.0, 20.0, 90.0],
        [50.0, 90.0, 140.0],
        [35.0, 145.0, 140.0],
        [110.0, 200.0, 90.0],
        [250.0, 230.0, 40.0],
    ];
    let position = share.clamp(0.0, 1.0) * (STOPS.len() - 1) as f64;
    let i = (position as usize).min(STOPS.len() - 2);
    let s = position - i as f64;
    [0, 1, 2].map(|k| (STOPS[i][k] + s * (STOPS[i + 1][k] - STOPS[i][k])).round() as u8)
}

impl HeatMap {
    /// The plot.
    pub fn figure(&self) -> Figure {
        let (rows, columns) = (self.x.len() as i64, self.y.len() as i64);
        let (width, height) = (columns * CELL + 2 * MARGIN, rows * CELL + 2 * MARGIN);
        let mut figure = Figure::new(width, height);
        figure.text([MARGIN, 32], 20, Anchor::Start, &self.title);
        // Column 0 (rightmost place) goes to the right edge, row 0 (nearest place) to the bottom.
        let left = |j: i64| MARGIN + (columns - 1 - j) * CELL;
        let top = |i: i64| MARGIN + (rows - 1 - i) * CELL;
        for (i, row) in (0..).zip(&self.values) {
            for (j, value) in (0..).zip(row) {
                let (color, ink, text) = self.cell(*value);
                figure.rect([left(j), top(i)], [CELL - 1, CELL - 1], color);
                let at = [left(j) + CELL / 2, top(i) + CELL / 2 + 7];
                figure.colored_text(at, 19, Anchor::Middle, ink, &text);
            }
        }
        for (i, x) in (0..).zip(&self.x) {
            figure.text([MARGIN - 8, top(i) + CELL / 2 + 5], 14, Anchor::End, &format!("{x:.2}"));
        }
        for (j, y) in (0..).zip(&self.y) {
            let at = [left(j) + CELL / 2, MARGIN + rows * CELL + 20];
            figure.text(at, 14, Anchor::Middle, &format!("{y:.2}"));
        }
        figure.text([12, MARGIN - 8], 14, Anchor::Start, "x [m]");
        figure.text([width - MARGIN + 8, MARGIN + rows * CELL + 20], 14, Anchor::Start, "y [m]");
        figure
    }

    /// Color, ink and text of a cell.
    fn cell(&self, value: Option<f64>) -> (Rgb, Rgb, String) {
        let Some(v) = value else { return ([200; 3], INK, "-".to_owned()) };
        let share = (v - self.low) / (self.high - self.low).max(1e-12);
        let (factor, digits) = self.print;
        let ink = if share > 0.6 { INK } else { [255; 3] };
        (color_of(share), ink, format!("{:.digits$}", v * factor))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_left_of_the_robot_is_on_the_left_and_far_is_up() {
        let map = HeatMap {
            title: "T".into(),
            x: vec![0.5, 1.0],
            y: vec![-1.0, 1.0],
            // Only the place far ahead to the left (x 1.0, y 1.0) is hot.
            values: vec![vec![Some(0.0), None], vec![Some(0.0), Some(1.0)]],
            low: 0.0,
            high: 1.0,
            print: (100.0, 0),
        };
        let image = map.figure().canvas();
        let (m, c) = (MARGIN as usize, CELL as usize);
        assert_eq!(image.get(m + 1, m + 1), color_of(1.0), "top left");
        assert_eq!(image.get(m + c + 1, m + 1), color_of(0.0), "top right");
        assert_eq!(image.get(m + 1, m + c + 1), [200; 3], "bottom left has no value");
    }

    #[test]
    fn the_svg_has_a_cell_a_value_and_its_number() {
        let map = HeatMap {
            title: "success <static>".into(),
            x: vec![0.5],
            y: vec![-1.0, 1.0],
            values: vec![vec![Some(0.25), None]],
            low: 0.0,
            high: 1.0,
            print: (100.0, 0),
        };
        let svg = map.figure().svg();
        assert_eq!(svg.matches("<rect").count(), 3, "background and two cells: {svg}");
        assert!(svg.contains(">25</text>") && svg.contains(">-</text>"), "{svg}");
        assert!(svg.contains("success &lt;static&gt;"), "{svg}");
    }

    #[test]
    fn colors_are_bounded() {
        assert_eq!(color_of(-3.0), color_of(0.0));
        assert_eq!(color_of(7.0), [250, 230, 40]);
    }
}
