//! The report of matches: per kick, per match and in all.

use std::fmt::Write;

use paid_lanes::stats::mean;
use paid_lanes::stats::median;
use paid_plot::{Table, number};
use serde::{Deserialize, Serialize};

use super::MatchOptions;
use crate::engine::EngineFacts;
use crate::metrics::statistics::Share;

/// The outcome of a kick. Positions are in the axes of the robot when the ball appeared: origin below its anchor, x along its heading, y left.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct KickOutcome {
    /// Name of the motion.
    pub motion_name: String,
    /// Ball center `[m]`.
    pub ball: [f64; 2],
    /// Ball velocity `[m/s]`.
    pub ball_velocity: [f64; 2],
    /// Goal center `[m]`.
    pub goal_center: [f64; 2],
    /// True if the robot met the ball.
    pub contact: bool,
    /// True if the labeled foot was the nearer one at first contact.
    pub correct_foot: bool,
    /// True if a foot met the ball first, whichever.
    pub foot_contact: bool,
    /// True if the kicked ball's center crossed the goal plane within the mouth.
    pub goal: bool,
    /// Where it crossed the plane, left positive `[m]`.
    pub lateral_m: Option<f64>,
    /// Time until the next ball appeared, or the fall `[s]`.
    pub seconds: f64,
    /// True if the robot stood still when the next ball appeared.
    pub still: bool,
    /// Mean speed of the base `[m/s]` and of the joints `[rad/s]` (root mean square) between the clip's end and then.
    pub held_speeds: [f64; 2],
    /// True if it fell.
    pub fell: bool,
    /// Distance of its anchor from the reference's at the end `[m]`; `None` after a fall.
    pub drift_m: Option<f64>,
    /// Angle between the two headings `[rad]`; `None` after a fall.
    pub drift_rad: Option<f64>,
}

/// A match.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MatchOutcome {
    /// Its number.
    pub number: usize,
    /// Kicks that ended on both feet, before the first fall.
    pub kicks_until_fall: usize,
    /// True if the robot fell.
    pub fell: bool,
    /// Every kick; the last one may have ended in the fall.
    pub kicks: Vec<KickOutcome>,
}

impl MatchOutcome {
    pub(super) fn new(number: usize, kicks: Vec<KickOutcome>) -> Self {
        let kicks_until_fall = kicks.iter().take_while(|k| !k.fell).count();
        Self { number, kicks_until_fall, fell: kicks_until_fall < kicks.len(), kicks }
    }
}

/// All matches together.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MatchTotal {
    /// Median over the matches of the kicks until the first fall; the number of kicks asked for where there was none.
    pub kicks_until_fall_median: Option<f64>,
    /// The mean.
    pub kicks_until_fall_mean: Option<f64>,
    /// Matches with a fall.
    pub fell: Share,
    /// Goals of all kicks.
    pub goals: Share,
    /// Kicks that met the ball.
    pub contact: Share,
    /// Labeled foot first, of those.
    pub correct_foot: Share,
    /// A foot met the ball first, of those.
    pub foot_contact: Share,
    /// Robot not still in time, of the kicks without a fall.
    pub unsettled: Share,
    /// Mean time of a kick without a fall `[s]`.
    pub seconds_a_kick: Option<f64>,
    /// Mean speeds of base `[m/s]` and joints `[rad/s]` while the last frame was held, of the kicks without a fall.
    pub held_speeds: [Option<f64>; 2],
    /// Mean distance from the reference at the end of a kick `[m]`.
    pub drift_m: Option<f64>,
    /// Mean angle from its heading `[rad]`.
    pub drift_rad: Option<f64>,
}

impl MatchTotal {
    fn of(matches: &[MatchOutcome]) -> Self {
        let kicks = || matches.iter().flat_map(|m| &m.kicks);
        let met = || kicks().filter(|k| k.contact);
        let stood = || kicks().filter(|k| !k.fell);
        let until = || matches.iter().map(|m| m.kicks_until_fall as f64);
        Self {
            kicks_until_fall_median: median(&mut until().collect::<Vec<_>>()),
            kicks_until_fall_mean: mean(until()),
            fell: Share::of(matches.iter().map(|m| m.fell)),
            goals: Share::of(kicks().map(|k| k.goal)),
            contact: Share::of(kicks().map(|k| k.contact)),
            correct_foot: Share::of(met().map(|k| k.correct_foot)),
            foot_contact: Share::of(met().map(|k| k.foot_contact)),
            unsettled: Share::of(stood().map(|k| !k.still)),
            held_speeds: [0, 1].map(|i| mean(stood().map(|k| k.held_speeds[i]))),
            seconds_a_kick: mean(stood().map(|k| k.seconds)),
            drift_m: mean(kicks().filter_map(|k| k.drift_m)),
            drift_rad: mean(kicks().filter_map(|k| k.drift_rad)),
        }
    }
}

/// Everything.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MatchReport {
    /// Who simulated.
    pub engine: EngineFacts,
    /// What was run.
    pub options: MatchOptions,
    /// All matches together.
    pub total: MatchTotal,
    /// Every match that ended.
    pub matches: Vec<MatchOutcome>,
}

impl MatchReport {
    pub(super) fn new(engine: EngineFacts, options: &MatchOptions, matches: Vec<MatchOutcome>) -> Self {
        Self { engine, options: options.clone(), total: MatchTotal::of(&matches), matches }
    }

    /// `static` or `rolling`.
    pub fn ball(&self) -> &'static str {
        if self.options.rolling.is_some() { "rolling" } else { "static" }
    }

    /// One line that says what was run.
    pub fn title(&self) -> String {
        let (o, engine) = (&self.options, &self.engine);
        let ball = match o.rolling {
            None => "static ball".to_owned(),
            Some([lo, hi]) => format!("ball rolling at {lo} to {hi} m/s"),
        };
        let mass = engine.ball_mass_kg.map_or(String::new(), |m| format!(", ball {m} kg"));
        let ([x0, x1], [y0, y1]) = (o.workspace.x, o.workspace.y);
        format!(
            "{} ({} ms steps{mass}, {}); {} matches of {} kicks, robot never reset; {ball} in [{x0}, {x1}] x [{y0}, {y1}] m in front of it, goal {} m away within {} degrees; next ball when base and joints (root mean square) have been slower than {} m/s and {} rad/s for {} s and the last ball has passed the goal plane, at the latest {} s after the clip's end{}",
            engine.name,
            1e3 * engine.physics_dt_s,
            engine.surfaces,
            o.matches,
            o.kicks,
            o.goal_distance_m,
            o.goal_bearing_deg,
            o.still_base_m_s,
            o.still_joint_rad_s,
            o.still_s,
            o.patience_s,
            engine.knowledge_text()
        )
    }

    /// The report as text: totals, then a row a match. Writing to a string cannot fail.
    pub fn table(&self) -> String {
        let mut out = format!("{}\n", self.title());
        if self.matches.len() < self.options.matches {
            let _ = writeln!(out, "stopped: {} of {} matches", self.matches.len(), self.options.matches);
        }
        let _ = writeln!(out, "\n{}\n{}", self.totals(), self.rows());
        out
    }

    fn totals(&self) -> Table {
        let t = &self.total;
        let mut table = Table::new(&["figure", "", "value", "95% low", "high", "n"]);
        let value = |v: Option<f64>, digits| v.map_or("-".to_owned(), |v| number(v, digits));
        for (name, v) in [
            ("kicks until the first fall, median", value(t.kicks_until_fall_median, 1)),
            ("mean", value(t.kicks_until_fall_mean, 1)),
            ("time of a kick [s]", value(t.seconds_a_kick, 2)),
            ("speed of the base while held [m/s]", value(t.held_speeds[0], 3)),
            ("speed of the joints while held [rad/s]", value(t.held_speeds[1], 3)),
            ("drift of a kick [m]", value(t.drift_m, 3)),
            ("drift of a kick [rad]", value(t.drift_rad, 3)),
        ] {
            table.row([name.into(), String::new(), v, String::new(), String::new(), String::new()]);
        }
        for (name, s) in [
            ("matches with a fall", t.fell),
            ("goals", t.goals),
            ("contact", t.contact),
            ("correct foot of contacts", t.correct_foot),
            ("a foot first, of contacts", t.foot_contact),
            ("not still in time", t.unsettled),
        ] {
            let p = |v: f64| format!("{:.1}%", 100.0 * v);
            table.row([name.into(), String::new(), p(s.share), p(s.low), p(s.high), s.trials.to_string()]);
        }
        table
    }

    fn rows(&self) -> Table {
        let mut table = Table::new(&["match", "", "kicks until the fall", "goals", "kicks"]);
        for m in &self.matches {
            let goals = m.kicks.iter().filter(|k| k.goal).count();
            let until = if m.fell { m.kicks_until_fall.to_string() } else { "none".to_owned() };
            table.row([
                (m.number + 1).to_string(),
                String::new(),
                until,
                goals.to_string(),
                m.kicks.len().to_string(),
            ]);
        }
        table
    }

    /// One line per kick.
    pub fn csv(&self) -> String {
        let mut out = String::from(
            "match,kick,motion,ball_x,ball_y,ball_vx,ball_vy,goal_x,goal_y,contact,correct_foot,foot_contact,goal,lateral_m,\
             seconds,still,held_base_speed,held_joint_speed,fell,drift_m,drift_rad,knowledge\n",
        );
        let o = |v: Option<f64>| v.map_or(String::new(), |v| format!("{v:.5}"));
        for m in &self.matches {
            for (number, k) in m.kicks.iter().enumerate() {
                let places = [k.ball, k.ball_velocity, k.goal_center].concat();
                let places: Vec<String> = places.iter().map(|x| format!("{x:.5}")).collect();
                let _ = writeln!(
                    out,
                    "{},{},{},{},{},{},{},{},{},{:.2},{},{:.4},{:.4},{},{},{},{}",
                    m.number + 1,
                    number + 1,
                    k.motion_name.replace([',', '"'], ";"),
                    places.join(","),
                    k.contact,
                    k.correct_foot,
                    k.foot_contact,
                    k.goal,
                    o(k.lateral_m),
                    k.seconds,
                    k.still,
                    k.held_speeds[0],
                    k.held_speeds[1],
                    k.fell,
                    o(k.drift_m),
                    o(k.drift_rad),
                    self.engine.knowledge_name()
                );
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::EngineChoice;
    use paid_task::TaskPreset;

    fn kick(goal: bool, fell: bool, seconds: f64) -> KickOutcome {
        KickOutcome {
            motion_name: "kick, hard".into(),
            ball: [1.0, 0.0],
            ball_velocity: [0.0; 2],
            goal_center: [5.0, 0.0],
            contact: true,
            correct_foot: goal,
            foot_contact: true,
            goal,
            lateral_m: None,
            seconds,
            still: !fell,
            held_speeds: [0.01 * seconds, 0.2],
            fell,
            drift_m: (!fell).then_some(0.1 * seconds),
            drift_rad: (!fell).then_some(0.05),
        }
    }

    fn report() -> MatchReport {
        let engine = EngineChoice::Builtin.facts(&TaskPreset::builtin("paper_stage2").expect("built in"));
        let options = MatchOptions { kicks: 3, matches: 3, ..MatchOptions::default() };
        let of = |kicks: &[(bool, bool, f64)]| kicks.iter().map(|&(g, f, s)| kick(g, f, s)).collect();
        let matches: [Vec<KickOutcome>; 3] = [
            of(&[(true, false, 4.0), (true, true, 1.0)]),
            of(&[(true, false, 4.0), (false, false, 6.0), (true, false, 6.0)]),
            of(&[(false, true, 2.0)]),
        ];
        let matches = matches.into_iter().enumerate().map(|(i, kicks)| MatchOutcome::new(i, kicks));
        MatchReport::new(engine, &options, matches.collect())
    }

    #[test]
    fn the_median_counts_whole_matches_and_the_shares_all_kicks() {
        let total = report().total;
        // 1, 3 and 0 kicks on both feet.
        assert_eq!(total.kicks_until_fall_median, Some(1.0));
        assert!((total.kicks_until_fall_mean.expect("matches") - 4.0 / 3.0).abs() < 1e-12);
        assert_eq!((total.fell.count, total.goals.count, total.goals.trials), (2, 4, 6));
        // Times and drifts are of the kicks that did not end in a fall: 4, 4, 6, 6 s.
        assert!((total.seconds_a_kick.expect("kicks") - 5.0).abs() < 1e-12);
        assert!((total.drift_m.expect("kicks") - 0.5).abs() < 1e-12);
        assert_eq!(total.unsettled.trials, 4);
        assert!((total.held_speeds[0].expect("kicks") - 0.05).abs() < 1e-12);
    }

    #[test]
    fn the_csv_has_a_row_a_kick_and_as_many_fields_as_titles() {
        let csv = report().csv();
        let lines: Vec<&str> = csv.lines().collect();
        assert_eq!(lines.len(), 7);
        let titles = lines[0].split(',').count();
        assert!(lines.iter().all(|line| line.split(',').count() == titles), "{csv}");
        assert!(lines[2].ends_with(",1.00,false,0.0100,0.2000,true,,,truth"), "{}", lines[2]);
    }

    #[test]
    fn the_title_says_what_was_run_and_what_the_policy_knew() {
        let table = report().table();
        assert!(
            table.contains("3 matches of 3 kicks, robot never reset") && table.contains("knowledge: truth")
        );
        assert!(table.contains("kicks until the first fall, median"), "{table}");
    }
}
