//! Bars: figures of many things side by side.

use crate::{Anchor, Figure, Rgb};

/// Pixels from the left edge to the bars.
const LEFT: i64 = 260;
/// Length of the longest bar in pixels.
const LENGTH: f64 = 520.0;
/// Height of a bar in pixels.
const BAR: i64 = 12;
const COLORS: [Rgb; 2] = [[50, 90, 140], [110, 200, 90]];

/// Panels of horizontal bars over the same labels, two bars a label.
#[derive(Clone, Debug)]
pub struct Bars {
    /// What a pair of bars is about.
    pub labels: Vec<String>,
    /// Names of the first and second bar of each pair.
    pub series: [&'static str; 2],
    /// Title and values of each panel, a pair a label; `None` draws no bar.
    pub panels: Vec<(String, Vec<[Option<f64>; 2]>)>,
}

impl Bars {
    /// The plot.
    pub fn figure(&self) -> Figure {
        let pair = 2 * BAR + 6;
        let panel = pair * self.labels.len() as i64 + 44;
        let mut figure = Figure::new(LEFT + LENGTH as i64 + 80, panel * self.panels.len() as i64 + 34);
        for (k, (name, color)) in self.series.iter().zip(COLORS).enumerate() {
            let x = LEFT + 240 * k as i64;
            figure.rect([x, 10], [14, 14], color);
            figure.text([x + 20, 22], 14, Anchor::Start, name);
        }
        for (p, (title, values)) in (0..).zip(&self.panels) {
            let top = 34 + p * panel;
            figure.text([LEFT, top + 24], 16, Anchor::Start, title);
            let largest = values.iter().flatten().flatten().copied().fold(1e-9, f64::max);
            for (i, (label, pair_values)) in (0..).zip(self.labels.iter().zip(values)) {
                let y = top + 34 + i * pair;
                figure.text([LEFT - 8, y + BAR + 4], 13, Anchor::End, label);
                for ((k, value), color) in (0..).zip(pair_values).zip(COLORS) {
                    let Some(value) = value else { continue };
                    let length = (value / largest * LENGTH).round() as i64;
                    figure.rect([LEFT, y + k * BAR], [length.max(1), BAR - 1], color);
                    let at = [LEFT + length + 4, y + k * BAR + BAR - 1];
                    figure.text(at, 13, Anchor::Start, &format!("{value:.1}"));
                }
            }
        }
        figure
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_bar_fills_the_panel_and_half_is_half() {
        let bars = Bars {
            labels: vec!["a".into(), "b & c".into()],
            series: ["one", "two"],
            panels: vec![("error".into(), vec![[Some(10.0), Some(5.0)], [None, Some(2.5)]])],
        };
        let svg = bars.figure().svg();
        assert!(
            svg.contains("width=\"520\" height=\"11\"") && svg.contains("width=\"260\" height=\"11\""),
            "{svg}"
        );
        assert!(svg.contains(">b &amp; c</text>") && svg.contains(">2.5</text>"), "{svg}");
    }
}
