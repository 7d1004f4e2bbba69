//! Eleven balls on their grounds in MuJoCo: does a kick hold on what it was not trained on?
//!
//! Every value lies away from the ends of the ranges that the presets train on; several lie outside. The held-out balls and their trials
//! are for final scores only: nothing may be chosen by them.

use std::fmt::Write;

use paid_lanes::stats::mean;
use paid_mujoco::{BallOptions, SceneOptions};
use paid_plot::{Table, number};
use paid_task::TaskPreset;
use serde::Serialize;

use crate::EvalError;
use crate::engine::EngineChoice;
use crate::episodes::EvalSetup;
use crate::policy::DriverMaker;
use crate::shooting::{self, CellScore, Grid, ROLLING_SPEED, ShootingOptions};

/// Turns the seed of the panel's trials into that of the held-out ones.
const HELD_OUT_SEED: u64 = 0x0be1_d007_5eed_5afe;

/// A ball on a ground.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PanelBall {
    /// Short name.
    pub name: &'static str,
    /// What it stands for.
    pub what: &'static str,
    /// Mass `[kg]`.
    pub mass_kg: f64,
    /// Moment of inertia over `m r^2`: 2/3 is a thin shell, 0.4 a solid ball.
    pub inertia_factor: f64,
    /// Sliding friction of the ball.
    pub friction: f64,
    /// Time constant of its contacts `[s]`.
    pub contact_time_s: f64,
    /// Damping ratio of its contacts; 1 does not bounce.
    pub contact_damping: f64,
    /// Linear and angular damping `[1/s]`, as grass slows a ball.
    pub damping: [f64; 2],
    /// Sliding friction between feet and floor.
    pub floor_friction: f64,
    /// Time constant of the floor's contacts `[s]`.
    pub floor_contact_time_s: f64,
}

/// The usual scene's ball and ground.
const USUAL: PanelBall = PanelBall {
    name: "hollow",
    what: "a thin shell of a match ball's weight",
    mass_kg: 0.43,
    inertia_factor: 2.0 / 3.0,
    friction: 0.8,
    contact_time_s: 0.02,
    contact_damping: 1.0,
    damping: [0.0; 2],
    floor_friction: 0.8,
    floor_contact_time_s: 0.01,
};

/// The usual ball on grass.
pub(crate) const TURF: PanelBall = PanelBall {
    name: "turf",
    what: "grass that slows the ball and yields",
    friction: 0.9,
    // A rolling ball loses 1 m/s in the first meters, as on a football field; with [0.3, 3.3] none below 7 m/s reached the goal.
    damping: [0.12, 0.55],
    floor_friction: 0.9,
    floor_contact_time_s: 0.016,
    ..USUAL
};

/// The panel.
pub const PANEL: [PanelBall; 11] = [
    USUAL,
    PanelBall { name: "solid", what: "the inertia of a solid ball", inertia_factor: 0.4, ..USUAL },
    PanelBall { name: "light", what: "a size smaller", mass_kg: 0.36, ..USUAL },
    PanelBall { name: "heavy", what: "wet leather", mass_kg: 0.52, ..USUAL },
    PanelBall {
        name: "dead",
        what: "half inflated: a long contact and no bounce",
        contact_time_s: 0.03,
        contact_damping: 1.4,
        ..USUAL
    },
    PanelBall { name: "bouncing", what: "restitution of some 0.7", contact_damping: 0.12, ..USUAL },
    PanelBall {
        name: "slippery",
        what: "wet ball on a wet floor",
        friction: 0.22,
        floor_friction: 0.6,
        ..USUAL
    },
    PanelBall { name: "gripping", what: "rubber on rubber", friction: 1.15, floor_friction: 1.1, ..USUAL },
    TURF,
    PanelBall {
        name: "hall",
        what: "a hard floor and a hard ball",
        friction: 0.6,
        contact_time_s: 0.012,
        contact_damping: 0.35,
        floor_friction: 0.95,
        floor_contact_time_s: 0.006,
        ..USUAL
    },
    PanelBall {
        name: "real",
        what: "bounces as a filmed match ball: 84% in 6.5 ms",
        contact_time_s: BallOptions::REAL_CONTACT[0],
        contact_damping: BallOptions::REAL_CONTACT[1],
        ..USUAL
    },
];

/// The held-out panel: the same kinds with other values. For final scores only.
pub const HELD_OUT: [PanelBall; 11] = [
    PanelBall { mass_kg: 0.425, friction: 0.7, ..PANEL[0] },
    PanelBall { inertia_factor: 0.46, friction: 0.7, ..PANEL[1] },
    PanelBall { mass_kg: 0.34, ..PANEL[2] },
    PanelBall { mass_kg: 0.51, inertia_factor: 0.6, ..PANEL[3] },
    PanelBall { contact_time_s: 0.027, contact_damping: 1.7, ..PANEL[4] },
    PanelBall { contact_time_s: 0.018, contact_damping: 0.16, ..PANEL[5] },
    PanelBall { friction: 0.28, floor_friction: 0.65, ..PANEL[6] },
    PanelBall { friction: 1.1, floor_friction: 1.25, ..PANEL[7] },
    PanelBall { damping: [0.08, 0.75], friction: 0.85, floor_contact_time_s: 0.014, ..PANEL[8] },
    PanelBall { friction: 0.65, contact_time_s: 0.014, contact_damping: 0.28, ..PANEL[9] },
    PanelBall { contact_time_s: 0.034, contact_damping: 0.0655, ..PANEL[10] },
];

impl PanelBall {
    /// Puts this ball and ground into a scene and its ball into the task.
    pub fn apply(&self, scene: &mut SceneOptions, task: &mut TaskPreset) {
        let params = &mut task.ball_params;
        (params.mass_kg, params.inertia_factor) = (self.mass_kg, self.inertia_factor);
        [params.linear_damping, params.angular_damping] = self.damping;
        let mut ball = scene.ball.unwrap_or_default();
        ball.params = *params;
        ball.friction[0] = self.friction;
        ball.solref = [self.contact_time_s, self.contact_damping];
        ball.damped = self.damping != [0.0; 2];
        scene.ball = Some(ball);
        scene.floor.friction[0] = self.floor_friction;
        scene.floor.solref[0] = self.floor_contact_time_s;
        scene.resolve_contacts();
    }
}

/// What to run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PanelOptions {
    /// The balls' places.
    pub grid: Grid,
    /// Trials at each of them.
    pub trials: usize,
    /// Speed ranges of the balls `[m/s]`; `None` lies still.
    pub balls: Vec<Option<[f64; 2]>>,
    /// Time limit of a trial `[s]`.
    pub limit_s: f64,
    /// The held-out balls and trials.
    pub held_out: bool,
}

impl Default for PanelOptions {
    /// A trial at each of the 63 places of the effective workspace, static and rolling.
    fn default() -> Self {
        let balls = vec![None, Some(ROLLING_SPEED)];
        Self { grid: Grid::EFFECTIVE, trials: 1, balls, limit_s: 12.0, held_out: false }
    }
}

/// One ball's score.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PanelRow {
    /// Which ball.
    pub ball: PanelBall,
    /// Scores.
    pub score: CellScore,
}

/// The panel with balls that lie still, or roll.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PanelPart {
    /// Speed range `[m/s]`; `None`: static.
    pub rolling: Option<[f64; 2]>,
    /// Every ball.
    pub rows: Vec<PanelRow>,
    /// Mean share of goals over the balls.
    pub mean: Option<f64>,
    /// The least share of goals, and the ball's name.
    pub worst: Option<(f64, &'static str)>,
}

/// Everything.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PanelReport {
    /// What was run.
    pub options: PanelOptions,
    /// What the policy knew of the ball, in one word.
    pub knowledge: &'static str,
    /// The same in words, and MuJoCo's version.
    pub title: String,
    /// Static, rolling.
    pub parts: Vec<PanelPart>,
}

/// Runs the panel in MuJoCo, whatever the setup's engine. `scene` is what the balls change. A stopped evaluation has fewer rows.
///
/// # Errors
/// As [`crate::shooting::evaluate`].
pub fn evaluate(
    setup: &EvalSetup,
    scene: &SceneOptions,
    policy: &DriverMaker,
    options: &PanelOptions,
) -> Result<PanelReport, EvalError> {
    let balls = if options.held_out { &HELD_OUT } else { &PANEL };
    let seed = if options.held_out { setup.seed ^ HELD_OUT_SEED } else { setup.seed };
    let facts = EngineChoice::Mujoco(Box::new(scene.clone())).facts(&setup.preset);
    let mut report = PanelReport {
        options: options.clone(),
        knowledge: facts.knowledge_name(),
        title: format!(
            "{}{}; eleven balls and grounds, effective workspace, {} trials per place, ball place and goal fixed in the world, robot \
             displaced by up to 0.5 m{}",
            facts.name,
            if options.held_out { ", HELD OUT: for final scores only" } else { "" },
            options.trials,
            facts.knowledge_text()
        ),
        parts: Vec::new(),
    };
    for rolling in &options.balls {
        let shots = ShootingOptions {
            grid: options.grid,
            trials: options.trials,
            rolling: *rolling,
            limit_s: options.limit_s,
            ..ShootingOptions::default()
        };
        let mut rows = Vec::new();
        for ball in balls {
            if setup.monitor.stopped() {
                break;
            }
            let (mut scene, mut preset) = (scene.clone(), setup.preset.clone());
            ball.apply(&mut scene, &mut preset);
            let engine = EngineChoice::Mujoco(Box::new(scene));
            let setup = EvalSetup { engine, preset, seed, ..setup.clone() };
            let score = shooting::evaluate(&setup, policy, &shots)?.total;
            if score.success.trials > 0 {
                rows.push(PanelRow { ball: *ball, score });
            }
        }
        report.parts.push(PanelPart::new(*rolling, rows));
    }
    Ok(report)
}

impl PanelPart {
    fn new(rolling: Option<[f64; 2]>, rows: Vec<PanelRow>) -> Self {
        let goals = |row: &PanelRow| row.score.success.share;
        Self {
            rolling,
            mean: mean(rows.iter().map(goals)),
            worst: rows
                .iter()
                .min_by(|a, b| goals(a).total_cmp(&goals(b)))
                .map(|row| (goals(row), row.ball.name)),
            rows,
        }
    }

    /// `static` or `rolling`.
    fn kind(&self) -> &'static str {
        if self.rolling.is_some() { "rolling" } else { "static" }
    }
}

/// Titles of the table and of the CSV.
const COLUMNS: [&str; 9] =
    ["ball", "what", "trials", "success", "accuracy", "contact", "a foot first", "ball [m/s]", "falls"];

impl PanelRow {
    fn cells(&self) -> [String; 9] {
        let share = |share: f64| format!("{:.1}%", 100.0 * share);
        let value = |v: Option<f64>, digits| v.map_or("-".to_owned(), |v| number(v, digits));
        let s = &self.score;
        [
            self.ball.name.to_owned(),
            self.ball.what.to_owned(),
            s.success.trials.to_string(),
            share(s.success.share),
            value(s.accuracy, 3),
            share(s.contact.share),
            share(s.foot_contact.share),
            value(s.ball_speed, 2),
            share(s.falls_ever.share),
        ]
    }
}

impl PanelReport {
    /// The rows, mean and worst as text. Writing to a string cannot fail.
    pub fn table(&self) -> String {
        let mut out = format!("{}\n", self.title);
        for part in self.parts.iter().filter(|part| !part.rows.is_empty()) {
            let mut table = Table::new(&COLUMNS);
            part.rows.iter().for_each(|row| table.row(row.cells()));
            let _ = writeln!(out, "\n{} balls\n{table}", part.kind());
            if let (Some(mean), Some((worst, name))) = (part.mean, part.worst) {
                let _ = writeln!(out, "mean {:.1}%, worst {:.1}% ({name})", 100.0 * mean, 100.0 * worst);
            }
        }
        out
    }

    /// One line per ball.
    pub fn csv(&self) -> String {
        let mut out = format!("kind,{},held_out,knowledge\n", COLUMNS.join(","));
        for part in &self.parts {
            for row in &part.rows {
                let cells = row.cells().map(|cell| cell.replace(',', ";")).join(",");
                let _ = writeln!(out, "{},{cells},{},{}", part.kind(), self.options.held_out, self.knowledge);
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_ball_differs_from_every_other_held_out_ones_too() {
        let scenes = |balls: &[PanelBall]| -> Vec<(SceneOptions, TaskPreset)> {
            let apply = |ball: &PanelBall| {
                let mut task = TaskPreset::builtin("paper_stage2").expect("built in");
                let mut scene = SceneOptions::default();
                ball.apply(&mut scene, &mut task);
                assert_eq!(scene.ball.map(|b| b.params), Some(task.ball_params), "{}", ball.name);
                (scene, task)
            };
            balls.iter().map(apply).collect()
        };
        let all = [scenes(&PANEL), scenes(&HELD_OUT)].concat();
        for (i, scene) in all.iter().enumerate() {
            assert!(!all[..i].contains(scene), "{i}");
        }
        for (ball, other) in PANEL.iter().zip(&HELD_OUT) {
            assert_eq!((ball.name, ball.what), (other.name, other.what));
            assert!(!ball.what.contains(','), "it stands in a CSV");
        }
    }

    /// The values are not the ends of what the presets draw from.
    #[test]
    fn no_value_is_a_corner_of_the_trainings_ranges() {
        let task = TaskPreset::builtin("paper_stage2").expect("built in").randomization;
        // What configs/presets/stage2.toml sets beyond it.
        let stage2 = [
            [0.38, 0.5],
            [0.2, 1.2],
            [0.05, 1.2],
            [0.5, 1.3],
            [0.5, 1.2],
            [0.0, 5.0],
            [0.0, 0.1],
            [0.0, 0.025],
        ];
        let corners: Vec<f64> = [task.ball_mass_kg, task.ball_linear_damping, task.ball_angular_damping]
            .into_iter()
            .chain(stage2)
            .flatten()
            .filter(|x| *x != 0.0)
            .collect();
        for ball in PANEL[1..].iter().chain(&HELD_OUT) {
            // What the usual scene has too is not the panel's choice.
            let changed = [
                (ball.mass_kg, USUAL.mass_kg),
                (ball.friction, USUAL.friction),
                (ball.damping[0], 0.0),
                (ball.damping[1], 0.0),
                (ball.floor_friction, USUAL.floor_friction),
            ];
            for (value, _) in changed.into_iter().filter(|(value, usual)| value != usual) {
                assert!(!corners.contains(&value), "{}: {value}", ball.name);
            }
        }
    }

    #[test]
    fn the_worst_ball_is_named_and_nothing_has_no_mean() {
        let part = PanelPart::new(None, Vec::new());
        assert_eq!((part.mean, part.worst, part.kind()), (None, None, "static"));
        let row = |ball, goals: &[bool]| {
            let mut score = CellScore::of(None, &[]);
            score.success = crate::metrics::statistics::Share::of(goals.iter().copied());
            PanelRow { ball, score }
        };
        let rows = vec![row(PANEL[0], &[true, true]), row(PANEL[4], &[true, false])];
        let part = PanelPart::new(Some(ROLLING_SPEED), rows);
        assert_eq!((part.mean, part.worst, part.kind()), (Some(0.75), Some((0.5, "dead")), "rolling"));
        let report = PanelReport {
            options: PanelOptions::default(),
            knowledge: "truth",
            title: "title".into(),
            parts: vec![part],
        };
        assert!(report.table().contains("mean 75.0%, worst 50.0% (dead)"), "{}", report.table());
        let csv = report.csv();
        let fields = |line: &str| line.split(',').count();
        let lines: Vec<&str> = csv.lines().collect();
        assert!(lines.len() == 3 && lines.iter().all(|line| fields(line) == fields(lines[0])), "{csv}");
    }
}
