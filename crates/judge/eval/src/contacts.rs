//! When a policy's foot meets the ball: later or earlier than the motion's strike, and nearly the same in every kick.
//!
//! A ball that rolls on must be awaited where it is then. A policy that met the ball 0.2 s before the strike hit 80% of MuJoCo's rolling balls
//! when they were predicted to the strike, and 97% when they were predicted to its own contact.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use paid_play::POLICY_FILE;
use paid_plot::{Table, number};
use paid_policy::PlayContract;
use paid_task::TaskPreset;
use paid_task::preset::KnowledgeMode;
use paid_train::RunPreset;
use paid_train::policy_weights::write_play;
use serde::Serialize;

use crate::EvalError;
use crate::clips::{ClipsOptions, shots};
use crate::episodes::EvalSetup;
use crate::monitor::Monitor;
use crate::policy::DriverMaker;
use crate::subject::{Subject, SubjectSpec};

/// Shots of each motion, with balls about its own place.
const OPTIONS: ClipsOptions = ClipsOptions { trials: 20, radius_m: 0.25, limit_s: 12.0 };

/// One motion's contacts.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ContactRow {
    /// Name of the motion.
    pub motion: String,
    /// Its strike, from the first frame `[s]`.
    pub strike_s: f64,
    /// Median of the times at which a foot met the ball `[s]`; `None` if it did so in less than half of the shots.
    pub contact_s: Option<f64>,
    /// Half of the way from the first to the third quartile of these times `[s]`.
    pub spread_s: f64,
    /// Shots in which a foot met the ball before the motion's end.
    pub kicks: usize,
}

/// Contacts of all motions.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ContactReport {
    /// In the library's order.
    pub rows: Vec<ContactRow>,
}

impl ContactReport {
    /// Median times by motion `[s]`, as a preset's `ball.contact_s` has them.
    pub fn times(&self) -> BTreeMap<String, f64> {
        self.rows.iter().filter_map(|row| Some((row.motion.clone(), row.contact_s?))).collect()
    }

    /// How much earlier than the strikes, in one sentence.
    pub fn summary(&self) -> String {
        let mut early: Vec<f64> =
            self.rows.iter().filter_map(|row| Some(row.strike_s - row.contact_s?)).collect();
        early.sort_by(f64::total_cmp);
        match early[..] {
            [] => "The foot never touches the ball, so rolling balls are predicted for the motions' strikes"
                .to_owned(),
            [first, .., last] => format!(
                "The foot touches the ball {} to {} s before the motions' strikes; rolling balls are predicted for that time",
                number(first, 2),
                number(last, 2)
            ),
            [only] => format!(
                "The foot touches the ball {} s before the motion's strike; rolling balls are predicted for that time",
                number(only, 2)
            ),
        }
    }

    /// The rows as text.
    pub fn table(&self) -> String {
        let mut table =
            Table::new(&["motion", "strike [s]", "contact [s]", "early [s]", "spread [s]", "kicks"]);
        for row in &self.rows {
            let or_dash = |time: Option<f64>| time.map_or("-".to_owned(), |time| number(time, 2));
            table.row([
                row.motion.clone(),
                number(row.strike_s, 2),
                or_dash(row.contact_s),
                or_dash(row.contact_s.map(|time| row.strike_s - time)),
                number(row.spread_s, 3),
                row.kicks.to_string(),
            ]);
        }
        format!("static balls around each motion's own ball\n\n{table}")
    }
}

/// Kicks balls at rest with every motion, and takes the time of the foot's contact.
///
/// # Errors
/// As [`crate::clips::evaluate`].
pub fn measure(setup: &EvalSetup, policy: &DriverMaker) -> Result<ContactReport, EvalError> {
    let outcomes = shots(setup, policy, &OPTIONS)?;
    let dt_s = setup.preset.control_dt_s();
    let rows = setup.library.facts().iter().enumerate().map(|(motion, facts)| {
        let of_motion = outcomes.iter().filter(|o| o.trial.motion == motion && o.foot_contact);
        // A robot that fell may roll over the ball later.
        let end_s = (facts.frames - 1) as f64 * dt_s;
        let mut times: Vec<f64> =
            of_motion.filter_map(|o| o.kick_time_s).filter(|time| *time < end_s).collect();
        times.sort_by(f64::total_cmp);
        let at = |share: f64| times.get((share * times.len() as f64) as usize).copied();
        ContactRow {
            motion: facts.name.clone(),
            strike_s: facts.strike_frame as f64 * dt_s,
            contact_s: at(0.5).filter(|_| 2 * times.len() >= OPTIONS.trials),
            spread_s: at(0.75).zip(at(0.25)).map_or(0.0, |(high, low)| (high - low) / 2.0),
            kicks: times.len(),
        }
    });
    Ok(ContactReport { rows: rows.collect() })
}

/// True if a policy of the task is given the ball's position at its contact, whose time must then be measured.
pub fn matter_to(task: &TaskPreset) -> bool {
    task.predicts_ball() && task.scene.ball
}

/// Measures the contacts of a run's policy, in the built-in engine and with `truth`, and writes them into its policy file. `None` where its task has no strike or does not predict the ball, and
/// where `stop` was set before the end: nothing is written then.
///
/// # Errors
/// As [`Subject::load`] and [`measure`], or if the file cannot be written.
pub fn keep_of_run(
    run: &Path,
    threads: usize,
    stop: &Arc<AtomicBool>,
) -> Result<Option<ContactReport>, EvalError> {
    let task = RunPreset::of_run(run, &[])?.task;
    if !matter_to(&task) {
        return Ok(None);
    }
    let spec =
        SubjectSpec { threads, knowledge: Some(KnowledgeMode::Truth), ..SubjectSpec::new(run.to_owned()) };
    let mut subject = Subject::load(&spec)?;
    subject.setup.monitor = Monitor::stopped_by(Arc::clone(stop));
    let report = measure(&subject.setup, &*subject.maker)?;
    if subject.setup.monitor.stopped() {
        return Ok(None);
    }
    let play = PlayContract { contact_s: report.times(), ..task.play() };
    write_play(&run.join(POLICY_FILE), play)?;
    Ok(Some(report))
}
