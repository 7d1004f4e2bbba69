//! A trained policy in MuJoCo, on a surface, with perception errors.

use std::path::Path;
use std::sync::Arc;

use paid_motion::MotionLibrary;
use paid_mujoco::SceneOptions;
use paid_physics::Terrain;
use paid_play::ReferenceLibrary;
use paid_policy::{Checkpoint, Policy};
use paid_robot::{RobotModel, RobotSpec};
use paid_sysid::Surface;
use paid_task::TaskPreset;
use paid_task::preset::KnowledgeMode;
use paid_train::setup::load_robot;
use paid_train::{Alone, RunPreset};
use serde::{Deserialize, Serialize};

use super::score::{Count, Score};
use crate::EvalError;
use crate::engine::EngineChoice;
use crate::episodes::EvalSetup;
use crate::knowledge::Knowledge;
use crate::monitor::Monitor;
use crate::policy::NetworkDriver;
use crate::shooting::{self, Grid, ShootingOptions, ShootingReport, Variant};

/// How policies are judged.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JudgeSettings {
    /// Trials at each of the three ball places of the paper's table.
    pub trials: usize,
    /// Trials at each of the 63 places of the effective workspace.
    pub workspace_trials: usize,
    /// Time limit of a trial `[s]`.
    #[serde(alias = "limit")]
    pub limit_s: f64,
    /// Age of what is seen of ball and goal `[s]`.
    #[serde(alias = "latency")]
    pub latency_s: f64,
    /// Time between two pictures `[s]`.
    #[serde(alias = "frame")]
    pub frame_s: f64,
    /// Seed of trials and perception.
    pub seed: u64,
}

impl Default for JudgeSettings {
    /// 50 trials per place of the table, 5 per place of the workspace, a camera of 30 Hz with 60 ms latency.
    fn default() -> Self {
        Self { trials: 50, workspace_trials: 5, limit_s: 12.0, latency_s: 0.06, frame_s: 0.033, seed: 0 }
    }
}

impl JudgeSettings {
    /// Refuses what cannot be run, before anything is trained.
    ///
    /// # Errors
    /// The first value out of range.
    pub fn check(&self) -> Result<(), EvalError> {
        for (option, value) in [("trials", self.trials), ("workspace trials", self.workspace_trials)] {
            if value == 0 {
                return Err(EvalError::Option { option, expected: "at least 1".into(), found: "0".into() });
            }
        }
        if !(self.limit_s > 0.0 && self.limit_s <= 60.0) {
            let expected = "more than 0 and at most 60 s".to_owned();
            return Err(EvalError::Option { option: "limit", expected, found: self.limit_s.to_string() });
        }
        for (option, value) in [("latency", self.latency_s), ("frame", self.frame_s)] {
            if !(0.0..=1.0).contains(&value) {
                let expected = "0 to 1 s".to_owned();
                return Err(EvalError::Option { option, expected, found: value.to_string() });
            }
        }
        Ok(())
    }
}

/// The paper's ball places. Its axes put the ball 0.8 m ahead and up to 0.6 m aside ((x, y), y ahead); here x is ahead and y to the left.
const PLACES: Grid = Grid { x: [0.8, 0.8], y: [-0.6, 0.6], step: 0.6 };

/// A policy with all that its trials need.
pub struct Judge<'a> {
    robot: RobotModel,
    spec: RobotSpec,
    library: Arc<ReferenceLibrary>,
    policy: Policy,
    preset: RunPreset,
    settings: &'a JudgeSettings,
    threads: usize,
}

/// The task that every variant is judged in: flat ground, and perception errors that act in evaluations.
fn task(preset: &RunPreset, settings: &JudgeSettings) -> TaskPreset {
    let mut task = preset.task.clone();
    task.knowledge = KnowledgeMode::Truth;
    task.scene.terrain = Terrain::Plane;
    let perception = &mut task.observations.perception;
    perception.gaussian = true;
    perception.in_evaluation = true;
    perception.latency_s = [settings.latency_s; 2];
    perception.frame_s = settings.frame_s;
    task
}

/// What every variant knows of ball and goal when it is judged in the task of `preset`.
pub fn knowledge(preset: &RunPreset, settings: &JudgeSettings) -> Knowledge {
    Knowledge::of(&task(preset, settings))
}

impl<'a> Judge<'a> {
    /// Reads a checkpoint; `preset` is the task that it is judged in.
    ///
    /// # Errors
    /// A checkpoint, robot or motion that cannot be read, or that do not fit together.
    pub fn new(
        checkpoint: &Path,
        preset: &RunPreset,
        settings: &'a JudgeSettings,
        threads: usize,
    ) -> Result<Self, EvalError> {
        let policy = Checkpoint::load(checkpoint)?.policy()?;
        let (robot, spec) = load_robot(&preset.robot)?;
        let rate = 1.0 / preset.task.control_dt_s();
        let motions = MotionLibrary::open(Path::new(&preset.run.motions), &robot, &spec, rate)?;
        let library =
            Arc::new(ReferenceLibrary::for_play(&motions, &robot, &spec, &preset.task.play_preset())?);
        Ok(Self { robot, spec, library, policy, preset: preset.clone(), settings, threads })
    }

    /// The setup of a surface. The ball has the behavior that was measured on it, as far as MuJoCo's contact can follow
    /// ([`paid_mujoco::contact`]).
    fn setup(&self, surface: &str, monitor: &Monitor) -> Result<EvalSetup, EvalError> {
        let mut task = task(&self.preset, self.settings);
        let ball = Surface::load(surface)?.ball_params;
        task.ball_params = ball;
        let scene = SceneOptions::default().with_builtin_ball(ball, &task.scene);
        task.validate()?;
        Ok(EvalSetup {
            engine: EngineChoice::Mujoco(Box::new(scene)),
            isa: self.preset.isa().map_err(EvalError::Policy)?,
            robot: self.robot.clone(),
            spec: self.spec.clone(),
            library: Arc::clone(&self.library),
            preset: task,
            threads: self.threads,
            seed: self.settings.seed,
            monitor: monitor.clone(),
            ranks: Arc::new(Alone),
        })
    }

    /// The score on a surface; `None` if the monitor was told to stop.
    ///
    /// # Errors
    /// If the surface does not exist or the evaluation fails.
    pub fn score(
        &self,
        variant: &str,
        surface: &str,
        samples: u64,
        monitor: &Monitor,
    ) -> Result<Option<Score>, EvalError> {
        let setup = self.setup(surface, monitor)?;
        let maker = NetworkDriver::maker(self.policy.clone());
        let run = |grid: Grid, trials: usize, scatter_m: f64| -> Result<ShootingReport, EvalError> {
            let options = ShootingOptions {
                grid,
                trials,
                scatter_m,
                start_radius_m: 0.0,
                variant: Variant::Robot,
                limit_s: self.settings.limit_s,
                ..ShootingOptions::default()
            };
            shooting::evaluate(&setup, &maker, &options)
        };
        let spots = run(PLACES, self.settings.trials, 0.05)?;
        // Half of the grid's step: places all over the workspace.
        let workspace = run(Grid::EFFECTIVE, self.settings.workspace_trials, 0.125)?;
        if setup.monitor.stopped() {
            return Ok(None);
        }
        let at = |y: f64| {
            let there = spots.trials.iter().filter(|t| (t.trial.place[1] - y).abs() < 1e-6);
            Count::of(there.map(|t| t.goal))
        };
        Ok(Some(Score {
            variant: variant.to_owned(),
            surface: surface.to_owned(),
            samples,
            settings: self.settings.clone(),
            // The paper's order: its x from -0.6 to 0.6 to the right.
            places: [at(0.6), at(0.0), at(-0.6)],
            workspace: Count::of(workspace.trials.iter().map(|t| t.goal)),
            contacts: Count::of(workspace.trials.iter().map(|t| t.contact)),
            falls: Count::of(workspace.trials.iter().map(|t| t.fell)),
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_places_are_the_papers_three() {
        assert_eq!((PLACES.places(PLACES.x).len(), PLACES.places(PLACES.y).len()), (1, 3));
    }
}
