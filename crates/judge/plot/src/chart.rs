//! Lines and dots over two axes.

use crate::{Anchor, Figure, Rgb};

/// Size of a diagram and its margins (left, top, right, bottom) in pixels.
pub const SIZE: [i64; 2] = [900, 600];
const MARGIN: [f64; 4] = [90.0, 50.0, 30.0, 60.0];

const INK: Rgb = [30, 30, 30];
const GRID: Rgb = [225, 228, 232];
/// A line or a row of dots.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Points (x, y).
    pub points: Vec<[f64; 2]>,
    /// Their color.
    pub color: Rgb,
    /// Dots, else a line.
    pub dots: bool,
}

/// Axes with their data.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart<'a> {
    /// Above it.
    pub title: &'a str,
    /// Below the x axis.
    pub x_label: &'a str,
    /// Above the y axis.
    pub y_label: &'a str,
    /// Ticks of y are powers of ten: the values are logarithms.
    pub logarithmic: bool,
    /// The data; later series lie over earlier ones.
    pub series: Vec<Series>,
}

/// Distance of ticks: 1, 2 or 5 times a power of ten, about `count` on `span`.
fn tick_step(span: f64, count: f64) -> f64 {
    let rough = (span / count).max(1e-12);
    let power = 10_f64.powf(rough.log10().floor());
    let times = [1.0, 2.0, 5.0, 10.0].into_iter().find(|t| t * power >= rough * 0.999).unwrap_or(10.0);
    times * power
}

impl Chart<'_> {
    /// Lowest and highest value of a coordinate, a little wider.
    fn span(&self, k: usize) -> [f64; 2] {
        let all = || self.series.iter().flat_map(|s| s.points.iter().map(|p| p[k])).filter(|x| x.is_finite());
        let (lo, hi) = (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
        if lo > hi {
            return [0.0, 1.0];
        }
        let room = 0.04 * (hi - lo).max(1e-3);
        [if k == 0 { lo } else { lo - room }, hi + room]
    }

    /// The drawing.
    pub fn draw(&self) -> Figure {
        let [width, height] = SIZE.map(|n| n as f64);
        let [left, top, right, bottom] = MARGIN;
        let mut figure = Figure::new(SIZE[0], SIZE[1]);
        let spans = [self.span(0), self.span(1)];
        let place = |p: [f64; 2]| {
            let share = |k: usize| (p[k] - spans[k][0]) / (spans[k][1] - spans[k][0]);
            let x = left + share(0) * (width - left - right);
            let y = height - bottom - share(1) * (height - top - bottom);
            [x, y]
        };
        for k in 0..2 {
            let step = tick_step(spans[k][1] - spans[k][0], 8.0);
            let step = if k == 1 && self.logarithmic { step.max(1.0).round() } else { step };
            let digits = (-step.log10().floor()).clamp(0.0, 6.0) as usize;
            let first = (spans[k][0] / step).ceil() as i64;
            for i in first.. {
                let value = step * i as f64;
                if value > spans[k][1] {
                    break;
                }
                let text = if k == 1 && self.logarithmic {
                    format!("1e{value:.0}")
                } else {
                    format!("{value:.digits$}")
                };
                let (from, to) = if k == 0 {
                    (place([value, spans[1][0]]), place([value, spans[1][1]]))
                } else {
                    (place([spans[0][0], value]), place([spans[0][1], value]))
                };
                figure.line(vec![from, to], 1, GRID);
                let (x, y) = (from[0] as i64, from[1] as i64);
                let (at, anchor) =
                    if k == 0 { ([x, y + 22], Anchor::Middle) } else { ([x - 8, y + 5], Anchor::End) };
                figure.text(at, 14, anchor, &text);
            }
        }
        let corners = [[0, 0], [1, 0], [1, 1], [0, 1], [0, 0]];
        let corners = corners.map(|[i, j]: [usize; 2]| place([spans[0][i], spans[1][j]]));
        figure.line(corners.to_vec(), 1, INK);
        for one in &self.series {
            let points: Vec<[f64; 2]> = one.points.iter().map(|p| place(*p)).collect();
            if one.dots {
                points.into_iter().for_each(|p| figure.disc(p, 4.0, one.color));
            } else {
                figure.line(points, 2, one.color);
            }
        }
        let (left, top) = (left as i64, top as i64);
        figure.text([left, 30], 20, Anchor::Start, self.title);
        figure.text([8, top - 6], 14, Anchor::Start, self.y_label);
        figure.text([SIZE[0] - right as i64, SIZE[1] - 14], 14, Anchor::End, self.x_label);
        figure
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_numbers() {
        for (span, want) in [(2.0, 0.5), (2.1, 0.5), (1.0, 0.2), (0.9, 0.2), (300.0, 50.0)] {
            let step = tick_step(span, 8.0);
            assert!((step - want).abs() < 1e-9, "{span}: {step}");
        }
    }
}
