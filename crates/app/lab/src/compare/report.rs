//! The table of a comparison.

use std::fmt::Write;

use paid_eval::likeness::Likeness;
use paid_eval::shooting::PAPER;
use paid_plot::{Table, number};
use serde::Serialize;

use super::score::{ClipShots, Scores, Shots};
use super::{seeds, tracks};

/// One policy.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Name of its entry.
    pub name: String,
    /// The paper's name of the method.
    pub paper: Option<String>,
    /// Seed of its training.
    pub seed: Option<u64>,
    /// What it scored.
    pub scores: Scores,
}

/// The whole comparison.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Title of the plan.
    pub title: String,
    /// In the order of the plan.
    pub rows: Vec<Row>,
}

impl Comparison {
    /// Text: a table of goals with 95% intervals for each knowledge, the paper's figures below it, and the panel.
    pub fn table(&self) -> String {
        let mut out = format!("{}\n", self.title);
        let shoots = |row: &&Row| !row.scores.judgments.is_empty();
        if let Some(first) = self.rows.iter().find(shoots) {
            self.shots(&mut out, first);
        }
        if let Some(tables) = tracks::tables(&self.rows) {
            let _ = write!(out, "\n{tables}");
        }
        out
    }

    /// The tables of goals, panel, clips and likeness; `first` is a row that has them.
    fn shots(&self, out: &mut String, first: &Row) {
        let judge = &first.scores.judge;
        let _ = writeln!(
            out,
            "MuJoCo, effective workspace, {} shots at each of {} positions with still and with rolling balls, seed {}",
            judge.trials,
            judge.places(),
            judge.seed
        );
        for (k, judgment) in first.scores.judgments.iter().enumerate() {
            let knowledge = format!("{:?}", judgment.knowledge).to_lowercase();
            let mut table = Table::new(&[
                "method",
                "knowledge",
                "seed",
                "samples [M]",
                "static [95%]",
                "accuracy",
                "rolling [95%]",
                "accuracy",
                "contact",
                "falls",
                "ball [m/s]",
            ]);
            for row in &self.rows {
                let Some(judgment) = row.scores.judgments.get(k) else { continue };
                let samples: u64 = row.scores.samples.iter().sum();
                let optional =
                    |value: Option<f64>, digits| value.map_or("-".to_owned(), |x| number(x, digits));
                let share = |count: &crate::compare::Count| format!("{}%", number(100.0 * count.share(), 1));
                let Shots { goals, contacts, falls, accuracy, ball_speed } = &judgment.fixed;
                table.row([
                    row.name.clone(),
                    knowledge.clone(),
                    seed_text(row.seed),
                    samples_text(samples),
                    goals.text(),
                    optional(*accuracy, 3),
                    judgment.rolling.goals.text(),
                    optional(judgment.rolling.accuracy, 3),
                    share(contacts),
                    share(falls),
                    optional(*ball_speed, 2),
                ]);
            }
            let _ = write!(out, "\n{table}");
        }
        out.push_str(&self.paper());
        if let Some(table) = seeds::table(&self.rows) {
            let _ = write!(out, "\n{table}");
        }
        let mut panel = Table::new(&["panel of balls, static", "seed", "mean", "worst", "which"]);
        let mut any = false;
        for row in &self.rows {
            if let Some(score) = &row.scores.panel {
                any = true;
                panel.row([
                    row.name.clone(),
                    seed_text(row.seed),
                    format!("{}%", number(100.0 * score.mean, 1)),
                    format!("{}%", number(100.0 * score.worst, 1)),
                    score.worst_ball.clone(),
                ]);
            }
        }
        if any {
            let _ = write!(out, "\n{panel}");
        }
        if let Some(table) = self.clips() {
            let _ = write!(out, "\n{table}");
        }
        let likeness = self.likeness();
        if !likeness.is_empty() {
            let _ = write!(out, "\n{}", paid_eval::likeness::table(&likeness));
        }
    }

    /// Goals with each clip, the ball within 0.25 m of the clip's own place; `None` if no entry has them.
    fn clips(&self) -> Option<Table> {
        let mut table = Table::new(&[
            "near each clip's own ball, truth",
            "seed",
            "clip",
            "static [95%]",
            "accuracy",
            "falls",
            "ball [m/s]",
            "MPJPE [mm]",
            "G-MPJPE [mm]",
        ]);
        let mut any = false;
        for row in &self.rows {
            for ClipShots { clip, shots, mpjpe_mm, g_mpjpe_mm } in &row.scores.clips {
                any = true;
                table.row([
                    row.name.clone(),
                    seed_text(row.seed),
                    clip.clone(),
                    shots.goals.text(),
                    shots.accuracy.map_or("-".to_owned(), |x| number(x, 3)),
                    format!("{}%", number(100.0 * shots.falls.share(), 1)),
                    shots.ball_speed.map_or("-".to_owned(), |x| number(x, 2)),
                    mpjpe_mm.map_or("-".to_owned(), |x| number(x, 0)),
                    g_mpjpe_mm.map_or("-".to_owned(), |x| number(x, 0)),
                ]);
            }
        }
        any.then_some(table)
    }

    /// The clips, then every policy whose kicks were compared with them.
    fn likeness(&self) -> Vec<Likeness> {
        let mut rows: Vec<Likeness> = Vec::new();
        for row in &self.rows {
            let seed = row.seed.map_or(String::new(), |seed| format!(", seed {seed}"));
            for (k, likeness) in row.scores.likeness.iter().enumerate() {
                match k {
                    0 if rows.is_empty() => rows.push(likeness.clone()),
                    0 => {}
                    _ => rows.push(Likeness { name: format!("{}{seed}", row.name), ..likeness.clone() }),
                }
            }
        }
        rows
    }

    /// The paper's figures of the methods that the plan names.
    fn paper(&self) -> String {
        let mut table = Table::new(&["method", "paper, MuJoCo", "static", "accuracy", "rolling", "accuracy"]);
        let mut named: Vec<&str> = Vec::new();
        for paper in self.rows.iter().filter_map(|row| row.paper.as_deref()) {
            let Some((name, figures)) = PAPER.iter().find(|(name, _)| *name == paper) else { continue };
            if named.contains(name) {
                continue;
            }
            named.push(name);
            let [[fixed, fixed_accuracy], [rolling, rolling_accuracy]] = figures;
            table.row([
                (*name).to_owned(),
                paid_eval::knowledge::PAPER_SHORT.to_owned(),
                format!("{fixed:.1}%"),
                number(*fixed_accuracy, 3),
                format!("{rolling:.1}%"),
                number(*rolling_accuracy, 3),
            ]);
        }
        if named.is_empty() { String::new() } else { format!("\n{table}") }
    }
}

/// A seed, `-` for a policy that was there.
pub(super) fn seed_text(seed: Option<u64>) -> String {
    seed.map_or("-".to_owned(), |seed| seed.to_string())
}

/// Training samples in millions, `-` for a policy that was there.
pub(super) fn samples_text(samples: u64) -> String {
    if samples == 0 { "-".to_owned() } else { number(samples as f64 / 1e6, 0) }
}

#[cfg(test)]
mod tests {
    use paid_task::preset::KnowledgeMode;

    use super::*;
    use crate::compare::Count;
    use crate::compare::{JudgePlan, Judgment, PanelScore};

    #[test]
    fn a_row_has_goals_with_their_interval_and_the_papers_stand_below() {
        let shots = |goals: usize| Shots {
            goals: Count::of((0..100).map(|k| k < goals)),
            contacts: Count::of([true]),
            falls: Count::of([false]),
            accuracy: Some(0.75),
            ball_speed: None,
        };
        let likeness = |name: &str| Likeness {
            name: name.to_owned(),
            takes: 63,
            kicks: Some(60),
            jerk: Some(0.0123),
            auj: Some(0.0045),
            joint_distance_deg: None,
            foot_path_m: Some(0.071),
            swing: None,
        };
        let scores = Scores {
            judge: JudgePlan::default(),
            samples: vec![40_000_000, 160_000_000],
            of: String::new(),
            judgments: vec![Judgment {
                knowledge: KnowledgeMode::Truth,
                fixed: shots(50),
                rolling: shots(10),
            }],
            clips: vec![ClipShots {
                clip: "stylized-001".into(),
                shots: shots(40),
                mpjpe_mm: Some(77.0),
                g_mpjpe_mm: Some(231.0),
            }],
            panel: Some(PanelScore { mean: 0.4, worst: 0.1, worst_ball: "dead".into() }),
            likeness: ["the clips", "the policy"].map(likeness).into(),
            tracks: Vec::new(),
        };
        let row = Row { name: "AMP".into(), paper: Some("AMP".into()), seed: Some(1), scores };
        let mut other = Row { seed: Some(2), ..row.clone() };
        other.scores.likeness.clear();
        other.scores.panel = None;
        other.scores.clips.clear();
        other.scores.judgments[0].fixed = shots(54);
        let table = Comparison { title: "a title".into(), rows: vec![row, other] }.table();
        let seeds = table.lines().find(|l| l.contains("52.0%")).expect("the mean of 50 and 54");
        // Angles 0.785398 and 0.825441: sin^2(0.805420 -+ 12.706 x 0.0200214). The others are equal: 20 of 200.
        assert!(seeds.contains("[27.4, 76.1]") && seeds.contains("10.0% [6.6, 14.9]"), "{seeds}");
        assert!(table.contains("Student's with 1 degree of freedom"), "{table}");
        let clip = table.lines().find(|l| l.contains("stylized-001")).expect("a clip");
        assert!(
            clip.contains("40.0% [30.9, 49.8]")
                && clip.contains("0.750")
                && clip.contains(" 77 ")
                && clip.ends_with("231"),
            "{clip}"
        );
        let line = |start: &str| table.lines().find(|l| l.starts_with(start)).unwrap_or_default().to_owned();
        assert!(table.starts_with("a title\n"));
        let ours = table.lines().find(|l| l.contains("truth")).expect("a row");
        for part in ["200", "50.0% [40.4, 59.6]", "10.0% [5.5, 17.4]", "0.750", "100.0%", "0.0%"] {
            assert!(ours.contains(part), "{part}: {ours}");
        }
        assert!(table.lines().any(|l| l.contains("46.8%") && l.contains("35.5%")), "{table}");
        let ours =
            table.lines().find(|l| l.contains("60 of 63") && l.contains("AMP, seed 1")).expect("a row");
        for part in ["12.3", "0.0045", "7.1"] {
            assert!(ours.contains(part), "{part}: {ours}");
        }
        assert!(table.contains("the clips") && !table.contains("the policy"));
        assert!(line("AMP").contains("truth") && table.contains("40.0%  10.0%   dead"), "{table}");
    }
}
