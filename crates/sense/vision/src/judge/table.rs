//! What a detector found, by distance, partial view and blur.

use std::fmt::Write;

use serde::Serialize;

use super::{Bad, Case, unseen};

/// Balls of a group.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Which balls.
    pub group: String,
    /// How many there were.
    pub balls: usize,
    /// How many were found.
    pub found: usize,
    /// How many of these got a place from depth.
    pub placed: usize,
    /// Distance of the found place from the true one, median and 95th percentile `[m]`.
    pub error_m: Option<[f64; 2]>,
}

/// A judgment.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// Images, half of them without a ball.
    pub pictures: u32,
    /// All balls, then groups.
    pub rows: Vec<Row>,
    /// Things taken for a ball.
    pub false_balls: u32,
    /// The same in 1000 images.
    pub false_per_1000: f64,
    /// False balls in 1000 images that get a place: their depths fit to a ball, and one that is not in the floor.
    pub false_places_per_1000: f64,
    /// Processor time to render an image, color and depth `[ms]`.
    pub render_ms: f64,
    /// Processor time to detect balls in it `[ms]`.
    pub detect_ms: f64,
    /// The worst images: balls that were missed, then things that were taken for one, worst first.
    #[serde(skip)]
    pub worst: Vec<Bad>,
}

impl Row {
    fn of(group: String, cases: &[&Case]) -> Self {
        let mut errors: Vec<f64> = cases.iter().filter_map(|case| case.error_m).collect();
        errors.sort_by(f64::total_cmp);
        let at = |percent: usize| errors[(errors.len() * percent).div_ceil(100).max(1) - 1];
        let error_m = (!errors.is_empty()).then(|| [at(50), at(95)]);
        let found = cases.iter().filter(|case| case.found).count();
        Self { group, balls: cases.len(), found, placed: errors.len(), error_m }
    }

    /// Share of the balls that were found; 0 of none.
    pub fn recall(&self) -> f64 {
        if self.balls == 0 { 0.0 } else { self.found as f64 / self.balls as f64 }
    }
}

/// The rows of a report.
pub(super) fn rows(cases: &[Case]) -> Vec<Row> {
    let mut rows = Vec::new();
    let mut add = |group: &str, belongs: &dyn Fn(&Case) -> bool| {
        let of_group: Vec<&Case> = cases.iter().filter(|case| belongs(case)).collect();
        rows.push(Row::of(group.to_owned(), &of_group));
    };
    add("all", &|_| true);
    for (name, low, high) in
        [("0.3 to 1 m", 0.0, 1.0), ("1 to 2 m", 1.0, 2.0), ("2 to 3 m", 2.0, 3.0), ("3 to 4 m", 3.0, 9.0)]
    {
        add(name, &|case| (low..high).contains(&case.ball.distance));
    }
    for (name, low, high) in [
        ("25 to 50% in view", 0.0, 0.5),
        ("50 to 75% in view", 0.5, 0.75),
        ("75 to 95% in view", 0.75, 0.95),
        ("whole", 0.95, 2.0),
    ] {
        add(name, &|case| (low..high).contains(&case.shown));
    }
    for (name, low, high) in
        [("blur below 1 px", 0.0, 1.0), ("blur of 1 to 4 px", 1.0, 4.0), ("blur above 4 px", 4.0, 1e9)]
    {
        add(name, &|case| (low..high).contains(&case.ball.blur_px));
    }
    add("pattern not in training", &|case| unseen(&case.ball));
    rows
}

impl Report {
    /// The report as a table.
    pub fn text(&self) -> String {
        let mut out = format!(
            "{:<24} {:>6} {:>6} {:>8} {:>7} {:>10} {:>8}\n",
            "balls", "number", "found", "recall", "placed", "error 50%", "95%"
        );
        for row in &self.rows {
            let errors = row
                .error_m
                .map_or_else(String::new, |[a, b]| format!("{:>8.1}cm {:>6.1}cm", 100.0 * a, 100.0 * b));
            // Writing to a string cannot fail.
            let _ = writeln!(
                out,
                "{:<24} {:>6} {:>6} {:>7.1}% {:>7} {errors}",
                row.group,
                row.balls,
                row.found,
                100.0 * row.recall(),
                row.placed
            );
        }
        let _ = writeln!(
            out,
            "false balls: {} in {} images, {:.1} in 1000; with a place where a ball can be {:.1} in 1000\nprocessor time per image: rendering {:.1} ms, detection {:.1} ms",
            self.false_balls,
            self.pictures,
            self.false_per_1000,
            self.false_places_per_1000,
            self.render_ms,
            self.detect_ms
        );
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::BallPattern;
    use crate::scatter::TrueBall;

    #[test]
    fn rows_count_and_take_percentiles() {
        let case = |distance: f64, shown: f64, error_m: Option<f64>| Case {
            ball: TrueBall {
                center: [0.0; 3],
                radius: 0.11,
                distance,
                outline: None,
                blur_px: 0.5,
                pattern: BallPattern::Plain,
            },
            shown,
            found: error_m.is_some(),
            error_m,
        };
        let cases = [
            case(0.5, 1.0, Some(0.01)),
            case(1.5, 1.0, Some(0.03)),
            case(1.7, 0.3, None),
            case(3.9, 0.6, Some(0.02)),
        ];
        let rows = rows(&cases);
        let row = |group: &str| rows.iter().find(|row| row.group == group).expect("a row");
        assert_eq!((row("all").balls, row("all").found, row("all").error_m), (4, 3, Some([0.02, 0.03])));
        assert!((row("1 to 2 m").recall() - 0.5).abs() < 1e-12);
        assert_eq!((row("25 to 50% in view").found, row("whole").balls, row("2 to 3 m").balls), (0, 2, 0));
        assert_eq!(row("pattern not in training").balls, 0);
    }
}
