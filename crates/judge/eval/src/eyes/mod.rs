//! Shooting with onboard perception: rendered images, a simulated LiDAR, and the pipeline of [`paid_world`] between them and the
//! policy. Nothing of the simulator's ball reaches policy or choice of the motion.

mod cause;
mod judge;
mod kick;
mod plot;
mod report;
mod senses;
mod stage;
mod trial;

use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;

use paid_lidar::sim::SceneKind;
use serde::Serialize;

use crate::EvalError;
use crate::episodes::EvalSetup;
use crate::knowledge::Knowledge;
use crate::policy::DriverMaker;
use crate::shooting::{ShootingOptions, ShootingReport, Trial, plan};

pub use cause::Cause;
pub use judge::{EyesOutcome, SightingError};
pub use kick::{KickLog, LoggedStep};
pub use plot::kick_chart;
pub use report::{EyesReport, EyesTotals};

/// What detects the ball in an image.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum DetectorChoice {
    /// The project's own network.
    #[default]
    Own,
    /// The box around the pixels that show the ball, from the renderer: no truth about depth or pose, and never a false one.
    ExactBox,
    /// A network of the user.
    File(PathBuf),
}

/// Where the torso's pose comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum OdometryChoice {
    /// LiDAR-inertial odometry on a simulated Mid-360 that follows the robot's motion.
    #[default]
    Lidar,
    /// The true pose with the drift and the jitter that the task's preset has for training.
    Modeled,
}

/// The eyes of an evaluation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EyesOptions {
    /// What detects the ball.
    pub detector: DetectorChoice,
    /// Number of the ball's class in the file of a network of the user; `None`: the class with the ball's name in the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub class: Option<usize>,
    /// Lowest score of a detection that counts; `None`: the detector's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub confidence: Option<f64>,
    /// Where the torso's pose comes from.
    pub odometry: OdometryChoice,
    /// What the LiDAR sees.
    pub surroundings: SceneKind,
    /// Points that the LiDAR measures per second.
    pub points_per_s: f64,
    /// Write the sensors' messages of a trial (its number) to this file.
    #[serde(skip)]
    pub record: Option<(usize, PathBuf)>,
    /// Keep the whole course of a trial (its number).
    #[serde(skip)]
    pub log: Option<usize>,
}

impl Default for EyesOptions {
    fn default() -> Self {
        Self {
            detector: DetectorChoice::Own,
            class: None,
            confidence: None,
            odometry: OdometryChoice::Lidar,
            surroundings: SceneKind::Hall,
            points_per_s: 200_000.0,
            record: None,
            log: None,
        }
    }
}

impl EyesOptions {
    /// The eyes in words.
    fn words(&self, setup: &EvalSetup) -> Vec<String> {
        let eyes = &setup.preset.eyes;
        let detector = match &self.detector {
            DetectorChoice::Own => "the built-in network".to_owned(),
            DetectorChoice::ExactBox => "the exact box of the ball's pixels".to_owned(),
            DetectorChoice::File(path) => path.display().to_string(),
        };
        let odometry = match self.odometry {
            OdometryChoice::Lidar => format!(
                "LiDAR-inertial odometry ({}, {:.0} points/s)",
                self.surroundings.name(),
                self.points_per_s
            ),
            OdometryChoice::Modeled => "modeled odometry (drift as in training)".to_owned(),
        };
        vec![
            format!(
                "rendered images of 424 x 240 at {:.0} Hz, {:.2} s old",
                stage::rate(eyes),
                stage::latency(eyes)
            ),
            format!("balls by {detector}"),
            odometry,
        ]
    }
}

/// Runs the protocol in MuJoCo. A run that was stopped reports the trials that ended.
///
/// # Errors
/// If an option makes no sense, the engine is not MuJoCo, the policy does not fit the task, or a detector fails.
pub fn evaluate(
    setup: &EvalSetup,
    policy: &DriverMaker,
    options: &ShootingOptions,
    eyes: &EyesOptions,
) -> Result<(EyesReport, Option<KickLog>), EvalError> {
    let trials = plan(setup, options)?;
    let next = AtomicUsize::new(0);
    let results = Mutex::new(Vec::new());
    setup.monitor.plan(trials.len());
    let worker = || {
        let mut stage = stage::Stage::new(setup, policy, options, eyes);
        while !setup.monitor.stopped() {
            let number = next.fetch_add(1, Ordering::Relaxed);
            let Some(trial) = trials.get(number) else { break };
            let result = match &mut stage {
                Ok(stage) => stage.play(number, trial),
                Err(_) => break,
            };
            // What was stopped on its way has no outcome.
            let Some(result) = result.transpose() else { break };
            let failed = result.is_err();
            setup.monitor.finish(1);
            results.lock().unwrap_or_else(PoisonError::into_inner).push((number, result));
            if failed {
                next.store(trials.len(), Ordering::Relaxed);
            }
        }
        stage.map(drop)
    };
    thread::scope(|scope| {
        let others: Vec<_> =
            (1..setup.threads.clamp(1, trials.len().max(1))).map(|_| scope.spawn(worker)).collect();
        let mine = worker();
        others
            .into_iter()
            .try_for_each(|other| other.join().unwrap_or(Err(EvalError::Thread("evaluation"))))?;
        mine
    })?;
    let mut results = results.into_inner().unwrap_or_else(PoisonError::into_inner);
    results.sort_by_key(|(number, _)| *number);
    let (mut outcomes, mut seen, mut log) = (Vec::new(), Vec::new(), None);
    for (number, result) in results {
        let played = result?;
        outcomes.push(played.outcome);
        seen.push(played.eyes);
        if eyes.log == Some(number) {
            log = Some(played.log);
        }
    }
    let mut facts = setup.engine.facts(&setup.preset);
    let ball_velocity = setup.preset.predicts_ball();
    facts.knowledge = Some(Knowledge::Eyes { ball_velocity, eyes: eyes.words(setup) });
    let shooting = ShootingReport::new(facts, options, outcomes);
    Ok((EyesReport::new(shooting, eyes.clone(), seen), log))
}

/// The trial with another motion.
fn with_motion(trial: &Trial, motion: usize) -> Trial {
    Trial { motion, ..trial.clone() }
}
