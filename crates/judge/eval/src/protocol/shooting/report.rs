//! The report of a shooting evaluation: per trial, per ball place and in all.

use std::fmt::Write;

use serde::Serialize;

use super::score::{CellScore, Outcome, totals};
use super::{Grid, ShootingOptions, Variant};
use crate::engine::EngineFacts;

/// Everything.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ShootingReport {
    /// Who simulated.
    pub engine: EngineFacts,
    /// What was run.
    pub options: ShootingOptions,
    /// All trials together.
    pub total: CellScore,
    /// The trials of the paper's effective workspace together, if the grid goes beyond it.
    pub effective: Option<CellScore>,
    /// Per grid place, x slowest; a place without a trial (of a stopped run) has zeros.
    pub cells: Vec<CellScore>,
    /// Every trial.
    pub trials: Vec<Outcome>,
}

impl ShootingReport {
    pub(crate) fn new(engine: EngineFacts, options: &ShootingOptions, trials: Vec<Outcome>) -> Self {
        let grid = &options.grid;
        let score = |place, member: &dyn Fn([f64; 2]) -> bool| {
            CellScore::of(place, &trials.iter().filter(|o| member(o.trial.place)).collect::<Vec<_>>())
        };
        let mut cells = Vec::new();
        for x in grid.places(grid.x) {
            for y in grid.places(grid.y) {
                cells.push(score(Some([x, y]), &|place| place == [x, y]));
            }
        }
        let inside = |place: [f64; 2]| {
            let within = |v: f64, range: [f64; 2]| v >= range[0] - 1e-9 && v <= range[1] + 1e-9;
            within(place[0], Grid::EFFECTIVE.x) && within(place[1], Grid::EFFECTIVE.y)
        };
        let beyond = cells.iter().filter_map(|c| c.place).any(|place| !inside(place));
        Self {
            engine,
            options: options.clone(),
            total: score(None, &|_| true),
            effective: beyond.then(|| score(None, &inside)),
            cells,
            trials,
        }
    }

    /// Trials that were planned.
    pub fn planned(&self) -> usize {
        self.cells.len() * self.options.trials
    }

    /// One line that says what was run.
    pub fn title(&self) -> String {
        let o = &self.options;
        let Grid { x, y, step } = o.grid;
        let ball = match o.rolling {
            None => "static ball".to_owned(),
            Some([lo, hi]) => format!("ball rolling at {lo} to {hi} m/s"),
        };
        let variant = match o.variant {
            Variant::Robot => "ball position in the robot's first pose (its displacement changes nothing)",
            Variant::World => "ball position and goal fixed in the world, robot displaced",
        };
        let engine = &self.engine;
        let mass = engine.ball_mass_kg.map_or(String::new(), |m| format!(", ball {m} kg"));
        let scatter =
            if o.scatter_m > 0.0 { format!(", balls within {} m of it", o.scatter_m) } else { String::new() };
        format!(
            "{} ({} ms steps{mass}, {}); {ball}, grid [{}, {}] x [{}, {}] m every {step} m{scatter}, {} trials per position, robot start within {} m; {variant}{}",
            engine.name,
            1e3 * engine.physics_dt_s,
            engine.surfaces,
            x[0],
            x[1],
            y[0],
            y[1],
            o.trials,
            o.start_radius_m,
            engine.knowledge_text()
        )
    }

    /// The report as text (writing to a string cannot fail): totals, then success and accuracy over the grid (rows: x ahead, columns: y left).
    pub fn table(&self) -> String {
        let mut out = format!("{}\n", self.title());
        if self.trials.len() < self.planned() {
            let _ = writeln!(out, "stopped: {} of {} trials", self.trials.len(), self.planned());
        }
        let _ = writeln!(out, "\n{}", totals(&self.total, self.options.after_s));
        if let Some(effective) = &self.effective {
            let _ = writeln!(
                out,
                "effective workspace [0.5, 2.0] x [-1, 1] m\n\n{}",
                totals(effective, self.options.after_s)
            );
        }
        for (name, value) in [
            (
                "success [%]",
                (|c| (c.success.trials > 0).then_some(100.0 * c.success.share))
                    as fn(&CellScore) -> Option<f64>,
            ),
            ("accuracy x 100", |c| c.accuracy.map(|a| 100.0 * a)),
        ] {
            let _ =
                writeln!(out, "{name}; rows: x ahead [m], columns: y left [m]\n{}", self.grid_text(value));
        }
        out.push_str(&self.paper_line());
        out
    }

    /// Values over the grid, `[x][y]`.
    pub fn grid_values(&self, value: fn(&CellScore) -> Option<f64>) -> Vec<Vec<Option<f64>>> {
        let columns = self.options.grid.places(self.options.grid.y).len();
        self.cells.chunks(columns).map(|row| row.iter().map(value).collect()).collect()
    }

    fn grid_text(&self, value: fn(&CellScore) -> Option<f64>) -> String {
        let grid = &self.options.grid;
        let mut text = String::from("      ");
        for y in grid.places(grid.y) {
            let _ = write!(text, "{y:>6.2}");
        }
        for (x, row) in grid.places(grid.x).iter().zip(self.grid_values(value)) {
            let _ = write!(text, "\n{x:>5.2} ");
            for v in row {
                text.push_str(&v.map_or("     -".to_owned(), |v| format!("{v:>6.0}")));
            }
        }
        text.push('\n');
        text
    }

    /// One line per trial.
    pub fn csv(&self) -> String {
        let mut out = String::from(
            "x,y,repeat,displacement_x,displacement_y,ball_x,ball_y,ball_vx,ball_vy,goal_x,goal_y,motion,contact,correct_foot,\
             body,foot_contact,kick_time_s,foot_speed,goal,lateral_m,goal_time_s,plane_speed,cosine,ball_speed,ball_rise,\
             peak_ball_speed,fell_after_kick,fell,fell_in_clip,fell_within,torque_saturation,steps,knowledge\n",
        );
        let o = |v: Option<f64>| v.map_or(String::new(), |v| format!("{v:.5}"));
        for r in &self.trials {
            let t = &r.trial;
            let _ = writeln!(
                out,
                "{},{},{},{:.5},{:.5},{:.5},{:.5},{:.5},{:.5},{:.5},{:.5},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{:.5},{},{},{},{},{:.5},{},{}",
                t.place[0],
                t.place[1],
                t.repeat,
                t.displacement[0],
                t.displacement[1],
                t.ball[0],
                t.ball[1],
                t.ball_velocity[0],
                t.ball_velocity[1],
                t.goal[0],
                t.goal[1],
                quoted(&r.motion_name),
                r.contact,
                r.correct_foot,
                quoted(r.body.as_deref().unwrap_or("")),
                r.foot_contact,
                o(r.kick_time_s),
                o(r.foot_speed),
                r.goal,
                o(r.lateral_m),
                o(r.goal_time_s),
                o(r.plane_speed),
                o(r.cosine),
                o(r.ball_speed),
                o(r.ball_rise),
                r.peak_ball_speed,
                r.fell_after_kick,
                r.fell,
                r.fell_in_clip,
                r.fell_within.map_or(String::new(), |fell| fell.to_string()),
                r.torque_saturation,
                r.steps,
                self.engine.knowledge_name()
            );
        }
        out
    }
}

/// A text as a CSV field.
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::engine::EngineChoice;
    use crate::shooting::Trial;
    use paid_task::TaskPreset;

    pub(crate) fn outcome(place: [f64; 2], repeat: usize, contact: bool, goal: bool, cosine: f64) -> Outcome {
        Outcome {
            trial: Trial {
                place,
                repeat,
                displacement: [0.0; 2],
                ball: place,
                ball_velocity: [0.0; 2],
                goal: [5.0, 0.0],
                motion: 0,
            },
            motion_name: "kick, hard".into(),
            contact,
            correct_foot: contact,
            body: None,
            foot_contact: contact,
            foot: contact.then_some(repeat % 2),
            kick_time_s: contact.then_some(2.0),
            foot_speed: contact.then_some(5.0),
            goal,
            lateral_m: contact.then_some(0.25 * (1 + repeat) as f64),
            goal_time_s: None,
            plane_speed: None,
            torque_saturation: 0.25,
            cosine: contact.then_some(cosine),
            ball_speed: contact.then_some(4.0),
            ball_rise: None,
            peak_ball_speed: 4.5,
            fell_after_kick: false,
            fell: !contact,
            fell_in_clip: goal,
            fell_within: contact.then_some(goal),
            steps: 300,
            path: vec![],
        }
    }

    pub(crate) fn report() -> ShootingReport {
        let grid = Grid { x: [0.5, 0.75], y: [0.0, 0.0], step: 0.25 };
        let options = ShootingOptions { grid, trials: 2, ..ShootingOptions::default() };
        let engine = EngineChoice::Builtin.facts(&TaskPreset::builtin("paper_stage2").expect("built in"));
        ShootingReport::new(
            engine,
            &options,
            vec![
                outcome([0.5, 0.0], 0, true, true, 1.0),
                outcome([0.5, 0.0], 1, true, false, 0.5),
                outcome([0.75, 0.0], 0, false, false, 0.0),
                outcome([0.75, 0.0], 1, true, true, 0.9),
            ],
        )
    }

    #[test]
    fn the_json_of_a_trial_names_no_key_twice() {
        let json = serde_json::to_string(&report().trials[0]).expect("JSON");
        assert_eq!(json.matches("\"goal\":").count(), 1, "{json}");
        assert!(json.contains("\"goal_xy\":[5.0,0.0]") && json.contains("\"goal\":true"), "{json}");
    }

    #[test]
    fn shares_are_of_trials_and_accuracy_is_over_contacts() {
        let r = report();
        assert_eq!((r.total.success.count, r.total.success.trials), (2, 4));
        assert_eq!((r.total.success_of_kicks.count, r.total.success_of_kicks.trials), (2, 3));
        assert!((r.total.accuracy.expect("contacts") - 0.8).abs() < 1e-12);
        assert_eq!(r.cells.len(), 2);
        assert_eq!(r.cells[1].place, Some([0.75, 0.0]));
        assert_eq!((r.cells[1].contact.count, r.cells[1].accuracy), (1, Some(0.9)));
        assert_eq!((r.total.falls_ever.count, r.total.falls_in_clip.count), (1, 2));
        assert_eq!(r.total.falls_within.map(|s| (s.count, s.trials)), Some((2, 4)));
        // 0.25 m left of the center by the left foot, twice 0.5 m left of it by the right one.
        assert_eq!((r.total.miss_m, r.total.outward_m), (Some(1.25 / 3.0), Some(-0.25)));
        assert_eq!(r.grid_values(|c| Some(c.success.share)), vec![vec![Some(0.5)], vec![Some(0.5)]]);
    }

    #[test]
    fn the_csv_has_a_row_a_trial_and_as_many_fields_as_titles() {
        let csv = report().csv();
        let lines: Vec<&str> = csv.lines().collect();
        assert_eq!(lines.len(), 5);
        let titles = lines[0].split(',').count();
        // The motion's name holds a comma inside its quotes.
        assert!(
            lines[1..].iter().all(|l| l.split(',').count() == titles + 1 && l.contains("\"kick, hard\""))
        );
    }

    #[test]
    fn the_variant_and_the_grid_are_named() {
        let table = report().table();
        assert!(table.contains("fixed in the world, robot displaced") && table.contains("grid [0.5, 0.75]"));
        assert!(table.contains("50.0%") && table.contains("PAiD 91.3%"), "{table}");
    }

    #[test]
    fn every_form_of_the_report_says_what_the_policy_knew_and_what_the_papers_did() {
        let mut report = report();
        for rolling in [None, Some([0.1, 0.3])] {
            report.options.rolling = rolling;
            let table = report.table();
            assert!(report.title().contains("; knowledge: truth (the simulator's ball position"), "{table}");
            assert!(table.contains("paper's knowledge: ball position, no velocity"), "{table}");
            let csv = report.csv();
            assert!(csv.starts_with("x,y,") && csv.lines().next().is_some_and(|l| l.ends_with(",knowledge")));
            assert!(csv.lines().skip(1).all(|line| line.ends_with(",truth")), "{csv}");
            let json = serde_json::to_value(&report).expect("numbers");
            assert_eq!(json["engine"]["knowledge"]["name"], "truth");
            let summary = super::super::summary(std::slice::from_ref(&report));
            assert!(summary.contains("truth") && summary.contains("position, memory"), "{summary}");
            assert!(report.maps()[0].1.title.ends_with("knowledge: truth"));
        }
    }
}
