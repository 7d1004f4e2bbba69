//! How late joints follow their targets: in an engine, and in the log of a robot.
//!
//! The lag of a joint is the shift between the target's and the angle's rate of change at which the two agree best. It holds everything on the
//! way: computing, sending, the motor's inertia and friction, the load.

use paid_lanes::stats::{mean, median};
use paid_plot::{Table, number};
use paid_task::EnvSample;
use serde::Serialize;

use crate::EvalError;
use crate::engine::EngineFacts;
use crate::episodes::{Ending, EvalSetup, Observer, run_episodes};
use crate::policy::DriverMaker;
use crate::shooting::{ShootingOptions, plan, rules_of, start_of};

/// Longest lag that is looked for [control steps].
const LONGEST: usize = 15;
/// Rates that agree less (correlation) say nothing about a lag.
const LEAST_AGREEMENT: f64 = 0.3;
/// Targets that move less (root of the mean squared rate) are held, not followed `[rad/s]`.
const LEAST_RATE: f64 = 0.1;
/// Fewer control steps say nothing.
const LEAST_STEPS: usize = 50;

/// A real G1 under the gains of [`paid_robot::RobotSpec::g1`]: least and largest median of each kind of joint over nine runs of a dance
/// `[ms]`.
const REAL_G1: [(&str, [u32; 2]); 16] = [
    ("hip pitch", [40, 80]),
    ("hip roll", [80, 80]),
    ("hip yaw", [60, 60]),
    ("knee", [60, 60]),
    ("ankle pitch", [80, 80]),
    ("ankle roll", [40, 40]),
    ("waist yaw", [160, 160]),
    ("waist roll", [20, 20]),
    ("waist pitch", [20, 20]),
    ("shoulder pitch", [120, 140]),
    ("shoulder roll", [140, 160]),
    ("shoulder yaw", [80, 80]),
    ("elbow", [80, 80]),
    ("wrist roll", [60, 80]),
    ("wrist pitch", [60, 80]),
    ("wrist yaw", [60, 80]),
];

/// What a robot's joints were to do and did, control step by control step.
#[derive(Clone, Debug, Default)]
pub struct Moves {
    /// Targets of the step, one for each joint `[rad]`.
    pub targets: Vec<Vec<f64>>,
    /// Angles when the targets were given `[rad]`.
    pub angles: Vec<Vec<f64>>,
}

impl Moves {
    /// Takes in a control step.
    pub fn push(&mut self, targets: Vec<f64>, angles: Vec<f64>) {
        self.targets.push(targets);
        self.angles.push(angles);
    }

    /// The lag of joint `j` [control steps]; `None` if its targets move less than `least_rate` a step, or if it does not follow.
    fn lag(&self, j: usize, least_rate: f64) -> Option<usize> {
        let rates =
            |values: &[Vec<f64>]| -> Vec<f64> { values.windows(2).map(|w| w[1][j] - w[0][j]).collect() };
        let targets = rates(&self.targets);
        let squares = mean(targets.iter().map(|rate| rate * rate))?;
        (squares.sqrt() >= least_rate).then(|| lag(&targets, &rates(&self.angles)))?
    }
}

/// The shift of `response` against `cause` with the largest correlation.
fn lag(cause: &[f64], response: &[f64]) -> Option<usize> {
    let agreement = |shift: usize| {
        let pairs = || cause.iter().zip(&response[shift..]);
        let n = pairs().count() as f64;
        let (a, b) = pairs().fold((0.0, 0.0), |(a, b), (x, y)| (a + x / n, b + y / n));
        let (xy, xx, yy) = pairs().fold((0.0, 0.0, 0.0), |(xy, xx, yy), (x, y)| {
            let (x, y) = (x - a, y - b);
            (xy + x * y, xx + x * x, yy + y * y)
        });
        let product = (xx * yy).sqrt();
        if product > 0.0 { xy / product } else { 0.0 }
    };
    if cause.len() < LEAST_STEPS {
        return None;
    }
    (0..=LONGEST)
        .map(|shift| (shift, agreement(shift)))
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .filter(|(_, agreement)| *agreement >= LEAST_AGREEMENT)
        .map(|(shift, _)| shift)
}

/// The lag of the joints of a kind, left and right.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LagRow {
    /// Kind of joint: `hip pitch`.
    pub joint: String,
    /// Median over runs and sides `[ms]`; `None` if the joint was not moved.
    pub lag_ms: Option<f64>,
    /// Runs and sides with a lag.
    pub runs: usize,
    /// Least and largest median of a real G1 `[ms]`, where one was measured.
    pub real_g1_ms: Option<[u32; 2]>,
}

/// The lags of a robot's joints.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LagReport {
    /// Where the runs are from.
    pub source: String,
    /// Runs.
    pub runs: usize,
    /// Kinds of joints, in the order of the joints.
    pub rows: Vec<LagRow>,
}

impl LagReport {
    /// Of `runs` whose joints are `joints`, with control steps of `dt_s` `[s]`.
    pub fn new(source: String, joints: &[impl AsRef<str>], runs: &[Moves], dt_s: f64) -> Self {
        let mut rows: Vec<(String, Vec<f64>)> = Vec::new();
        for (j, joint) in joints.iter().enumerate() {
            let kind = kind_of(joint.as_ref());
            let lags = runs.iter().filter_map(|run| run.lag(j, LEAST_RATE * dt_s));
            let lags = lags.map(|steps| steps as f64 * dt_s * 1e3);
            match rows.iter_mut().find(|(known, _)| *known == kind) {
                Some((_, all)) => all.extend(lags),
                None => rows.push((kind, lags.collect())),
            }
        }
        let rows = rows.into_iter().map(|(joint, mut lags)| LagRow {
            runs: lags.len(),
            lag_ms: median(&mut lags),
            real_g1_ms: REAL_G1.iter().find(|(name, _)| *name == joint).map(|(_, range)| *range),
            joint,
        });
        Self { source, runs: runs.len(), rows: rows.collect() }
    }

    /// The rows as text.
    pub fn table(&self) -> String {
        let mut table = Table::new(&["joint", "lag [ms]", "runs and sides", "a real G1 [ms]"]);
        for row in &self.rows {
            table.row([
                row.joint.clone(),
                row.lag_ms.map_or("-".to_owned(), |lag| number(lag, 0)),
                row.runs.to_string(),
                row.real_g1_ms.map_or("-".to_owned(), |[lo, hi]| {
                    if lo == hi { lo.to_string() } else { format!("{lo} to {hi}") }
                }),
            ]);
        }
        format!("From target to angle, median over {} runs: {}\n\n{table}", self.runs, self.source)
    }
}

/// `hip pitch` of `left_hip_pitch_joint`.
fn kind_of(joint: &str) -> String {
    let side = ["left_", "right_"].into_iter().find_map(|side| joint.strip_prefix(side)).unwrap_or(joint);
    side.strip_suffix("_joint").unwrap_or(side).replace('_', " ")
}

/// Plays the shots of `options` and measures the joints, each shot a run.
///
/// # Errors
/// As [`crate::shooting::evaluate`].
pub fn evaluate(
    setup: &EvalSetup,
    policy: &DriverMaker,
    options: &ShootingOptions,
) -> Result<LagReport, EvalError> {
    let starts: Vec<_> = plan(setup, options)?.iter().map(start_of).collect();
    let dt_s = setup.preset.control_dt_s();
    let (rules, steps) = rules_of(options, dt_s);
    let watches = run_episodes(setup, policy, &starts, rules, steps, |_| Watch::default())?;
    let runs: Vec<Moves> = watches.into_iter().map(|(_, watch)| watch.moves).collect();
    let EngineFacts { name, .. } = setup.engine.facts(&setup.preset);
    Ok(LagReport::new(format!("{name}, static balls"), &setup.robot.joint_names(), &runs, dt_s))
}

/// A shot until the motion's end.
#[derive(Default)]
struct Watch {
    moves: Moves,
    /// Angles after the last step.
    angles: Option<Vec<f64>>,
}

impl Observer for Watch {
    fn observe(&mut self, sample: &EnvSample, ended: Option<Ending>) -> bool {
        if let Some(before) = self.angles.replace(sample.joint_pos.clone()) {
            self.moves.push(sample.joint_target.clone(), before);
        }
        ended.is_some() || sample.motion_ended
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A joint that follows a sweep `steps` control steps late, and one that is held.
    fn late(steps: usize) -> Moves {
        let target = |k: f64| (0.002 * k * k).sin();
        let mut moves = Moves::default();
        for k in 0..200_u32 {
            let past = f64::from(k) - steps as f64;
            moves.push(vec![target(f64::from(k)), 0.3], vec![0.7 * target(past), 0.3]);
        }
        moves
    }

    #[test]
    fn a_late_response_has_its_lag_and_a_held_joint_none() {
        let joints = ["left_knee_joint", "waist_roll_joint"];
        let runs = [late(3), late(4), late(4)];
        let report = LagReport::new("test".into(), &joints, &runs, 0.02);
        let [knee, waist] = &report.rows[..] else { panic!("{report:?}") };
        assert_eq!((knee.joint.as_str(), knee.lag_ms, knee.runs), ("knee", Some(80.0), 3));
        assert_eq!(knee.real_g1_ms, Some([60, 60]));
        assert_eq!((waist.joint.as_str(), waist.lag_ms, waist.runs), ("waist roll", None, 0));
        assert!(report.table().contains("knee"), "{}", report.table());
    }

    #[test]
    fn left_and_right_are_one_kind() {
        let joints = ["left_elbow_joint", "right_elbow_joint"];
        let mut moves = late(2);
        for (targets, angles) in moves.targets.iter_mut().zip(&mut moves.angles) {
            (targets[1], angles[1]) = (targets[0], angles[0]);
        }
        let report = LagReport::new("test".into(), &joints, &[moves], 0.02);
        assert_eq!(report.rows.len(), 1);
        assert_eq!((report.rows[0].lag_ms, report.rows[0].runs), (Some(40.0), 2));
    }
}
