//! Plots of shooting reports, and comparison with the paper's figures.

use paid_plot::{Figure, HeatMap, Path, plot_paths};
use paid_plot::{Table, number};

use super::{CellScore, ShootingReport};
use crate::knowledge;

/// Methods of the paper with success `[%]` and accuracy in MuJoCo (section IV-B): static, then rolling ball.
pub const PAPER: [(&str, [[f64; 2]; 2]); 4] = [
    ("Pure RL", [[33.0, 0.524], [23.5, 0.359]]),
    ("AMP", [[46.8, 0.715], [35.5, 0.531]]),
    ("Single-Stage", [[78.1, 0.922], [54.3, 0.798]]),
    ("PAiD", [[91.3, 0.969], [71.9, 0.889]]),
];

/// Trials in a plot of paths: more would be unreadable and take many megabytes.
const DRAWN: usize = 1000;

impl ShootingReport {
    /// `static` or `rolling`.
    pub fn ball(&self) -> &'static str {
        if self.options.rolling.is_some() { "rolling" } else { "static" }
    }

    /// Success and accuracy over the grid, each with its name; a place without a trial (or without a kick) has no number.
    pub fn maps(&self) -> [(&'static str, HeatMap); 2] {
        let map = |title: &str, value: fn(&CellScore) -> Option<f64>| HeatMap {
            title: format!("{title}, {} ball, knowledge: {}", self.ball(), self.engine.knowledge_name()),
            x: self.options.grid.places(self.options.grid.x),
            y: self.options.grid.places(self.options.grid.y),
            values: self.grid_values(value),
            low: 0.0,
            high: 1.0,
            print: (100.0, 0),
        };
        [
            ("success", map("success [%]", |c| (c.success.trials > 0).then_some(c.success.share))),
            ("accuracy", map("accuracy x 100", |c| c.accuracy)),
        ]
    }

    /// Where robot and ball went, in at most a thousand trials that are spread evenly over all.
    pub fn paths(&self) -> Figure {
        let every = self.trials.len().div_ceil(DRAWN).max(1);
        let drawn = self.trials.iter().step_by(every);
        let paths: Vec<Path> = drawn.map(|t| Path { points: &t.path, goal: t.goal }).collect();
        plot_paths(&paths, self.options.goal_half_width_m)
    }

    /// The paper's figures for this kind of ball as one line.
    pub(super) fn paper_line(&self) -> String {
        let methods = PAPER.map(|(name, figures)| {
            let [success, accuracy] = figures[self.row()];
            format!("{name} {success:.1}% {accuracy:.3}")
        });
        format!(
            "paper (MuJoCo, {}): {}; paper's knowledge: {}\n",
            self.ball(),
            methods.join(", "),
            knowledge::PAPER
        )
    }

    fn row(&self) -> usize {
        usize::from(self.options.rolling.is_some())
    }
}

/// Success and accuracy of every report in one plot, one row per report: for a static and a rolling one, the paper's four panels.
pub fn panels(reports: &[ShootingReport]) -> Figure {
    let charts: Vec<Figure> =
        reports.iter().flat_map(ShootingReport::maps).map(|(_, map)| map.figure()).collect();
    Figure::tiled(&charts, 2)
}

/// Success and accuracy of the reports next to the paper's, as text.
pub fn summary(reports: &[ShootingReport]) -> String {
    let mut table = Table::new(&[
        "ball",
        "method",
        "knowledge",
        "trials",
        "success",
        "of kicks",
        "95% low",
        "high",
        "accuracy",
    ]);
    let percent = |share: f64| format!("{:.1}%", 100.0 * share);
    for report in reports {
        for (name, score) in
            [("this policy", Some(&report.total)), ("this policy, effective", report.effective.as_ref())]
        {
            let Some(score) = score else { continue };
            let kicks = &score.success_of_kicks;
            table.row([
                report.ball().to_owned(),
                name.to_owned(),
                report.engine.knowledge_name().to_owned(),
                score.success.trials.to_string(),
                percent(score.success.share),
                percent(kicks.share),
                percent(kicks.low),
                percent(kicks.high),
                score.accuracy.map_or("-".to_owned(), |a| number(a, 3)),
            ]);
        }
        for (name, figures) in PAPER {
            let [success, accuracy] = figures[report.row()];
            table.row([
                report.ball().to_owned(),
                format!("{name} [paper, MuJoCo]"),
                knowledge::PAPER_SHORT.to_owned(),
                String::new(),
                String::new(),
                format!("{success:.1}%"),
                String::new(),
                String::new(),
                number(accuracy, 3),
            ]);
        }
    }
    let titles: String = reports.iter().map(|r| format!("{}\n", r.title())).collect();
    format!("{titles}\n{table}")
}
