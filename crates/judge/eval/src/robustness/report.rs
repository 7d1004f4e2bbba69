//! The scores of a series of rows.

use std::fmt::Write;

use paid_lanes::stats::mean;
use paid_plot::{Table, number};
use serde::Serialize;

use super::{RobustnessOptions, Trouble};
use crate::shooting::CellScore;

/// One trouble's score.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RobustnessRow {
    /// What went wrong.
    pub trouble: Trouble,
    /// In words.
    pub name: String,
    /// Scores.
    pub score: CellScore,
}

/// Everything.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RobustnessReport {
    /// What was run.
    pub options: RobustnessOptions,
    /// Scene and knowledge in words, with MuJoCo's version.
    pub title: String,
    /// One row for each trouble.
    pub rows: Vec<RobustnessRow>,
    /// Mean share of goals over the troubles, the first row left out.
    pub mean: Option<f64>,
    /// The least share of goals, and with which trouble.
    pub worst: Option<(f64, String)>,
}

/// Titles of the table and of the CSV behind the row's name.
const COLUMNS: [&str; 6] = ["trials", "success", "95% interval", "accuracy", "contact", "falls"];

impl RobustnessRow {
    fn cells(&self) -> [String; 7] {
        let share = |share: f64| format!("{:.1}%", 100.0 * share);
        let s = &self.score;
        [
            self.name.clone(),
            s.success.trials.to_string(),
            share(s.success.share),
            format!("{:.1} to {:.1}%", 100.0 * s.success.low, 100.0 * s.success.high),
            s.accuracy.map_or("-".to_owned(), |v| number(v, 3)),
            share(s.contact.share),
            share(s.falls_ever.share),
        ]
    }
}

impl RobustnessReport {
    pub(super) fn new(options: RobustnessOptions, title: String, rows: Vec<RobustnessRow>) -> Self {
        let wrong = || rows.iter().filter(|row| !row.trouble.is_usual());
        let goals = |row: &RobustnessRow| row.score.success.share;
        let worst = wrong().min_by(|a, b| goals(a).total_cmp(&goals(b)));
        Self {
            options,
            title,
            mean: mean(wrong().map(goals)),
            worst: worst.map(|row| (goals(row), row.name.clone())),
            rows,
        }
    }

    fn columns(&self) -> [&'static str; 7] {
        let [a, b, c, d, e, f] = COLUMNS;
        [self.options.series.column(), a, b, c, d, e, f]
    }

    /// The rows, mean and worst as text. Writing to a string cannot fail.
    pub fn table(&self) -> String {
        let mut out = format!("{}\n\n", self.title);
        let mut table = Table::new(&self.columns());
        self.rows.iter().for_each(|row| table.row(row.cells()));
        let _ = write!(out, "{table}");
        if let (Some(mean), Some((worst, name))) = (self.mean, &self.worst) {
            let _ = writeln!(out, "mean {:.1}%, worst {:.1}% ({name})", 100.0 * mean, 100.0 * worst);
        }
        out
    }

    /// One line per trouble.
    pub fn csv(&self) -> String {
        let mut out = format!("{}\n", self.columns().join(","));
        for row in &self.rows {
            let _ = writeln!(out, "{}", row.cells().join(","));
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::super::Series;
    use super::*;

    #[test]
    fn the_worst_is_named_and_nothing_wrong_does_not_count() {
        let row = |trouble: Trouble, goals: &[bool]| {
            let mut score = CellScore::of(None, &[]);
            score.success = crate::metrics::statistics::Share::of(goals.iter().copied());
            RobustnessRow { trouble, name: trouble.name(), score }
        };
        let rows = vec![
            row(Trouble::None, &[false, false]),
            row(Trouble::Late(0.02), &[true, false]),
            row(Trouble::WeakKnee(1, 0.8), &[true, true]),
        ];
        let options =
            RobustnessOptions { series: Series::Robustness, trials: 1, rolling: None, limit_s: 12.0 };
        let report = RobustnessReport::new(options, "title".into(), rows);
        assert_eq!(report.mean, Some(0.75));
        assert!(
            report.table().ends_with("mean 75.0%, worst 50.0% (targets 20 ms later)\n"),
            "{}",
            report.table()
        );
        assert!(
            report.csv().contains("\nright knee with 80% of its torque,2,100.0%,34.2 to 100.0%,"),
            "{}",
            report.csv()
        );
    }
}
