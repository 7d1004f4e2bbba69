//! A trained policy in MuJoCo, on a surface, with perception errors.

use std::path::Path;
use std::sync::Arc;

use paid_eval::engine::Engine;
use paid_eval::episodes::EvalSetup;
use paid_eval::monitor::Monitor;
use paid_eval::policy::LearnedPolicy;
use paid_eval::shooting::{self, Grid, ShootingOptions, ShootingReport, Variant};
use paid_learn::{Checkpoint, Policy};
use paid_motion::MotionLibrary;
use paid_mujoco::SceneOptions;
use paid_physics::Terrain;
use paid_robot::{RobotModel, RobotSpec};
use paid_sysid::Surface;
use paid_task::ReferenceLibrary;
use paid_train::RunPreset;
use paid_train::setup::load_robot;
use serde::{Deserialize, Serialize};

use super::result::{Count, Score};
use crate::failure::Failure;
use crate::stop;

/// How policies are judged.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, clap::Args)]
#[command(next_help_heading = "Judging")]
pub struct Settings {
    /// Trials at each of the three ball places of the paper's table.
    #[arg(long, default_value_t = 50)]
    pub trials: usize,
    /// Trials at each of the 63 places of the effective workspace.
    #[arg(long, default_value_t = 5)]
    pub workspace_trials: usize,
    /// Time limit of a trial [s].
    #[arg(long, default_value_t = 12.0)]
    pub limit: f64,
    /// Age of what is seen of ball and goal [s].
    #[arg(long, default_value_t = 0.06)]
    pub latency: f64,
    /// Time between two pictures [s].
    #[arg(long, default_value_t = 0.033)]
    pub frame: f64,
    /// Seed of trials and perception.
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
}

impl Settings {
    /// Refuses what cannot be run, before anything is trained.
    pub fn check(&self) -> Result<(), Failure> {
        for (name, value) in [("--trials", self.trials), ("--workspace-trials", self.workspace_trials)] {
            if value == 0 {
                return Err(Failure::input(format!("{name}: expected at least 1, found 0")));
            }
        }
        for (name, value, most) in
            [("--limit", self.limit, 60.0), ("--latency", self.latency, 1.0), ("--frame", self.frame, 1.0)]
        {
            if !(0.0..=most).contains(&value) {
                return Err(Failure::input(format!("{name}: expected 0 to {most} s, found {value}")));
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
    settings: &'a Settings,
    threads: usize,
}

impl<'a> Judge<'a> {
    /// Reads a checkpoint; `preset` is the task that it is judged in.
    pub fn new(
        checkpoint: &Path,
        preset: &RunPreset,
        settings: &'a Settings,
        threads: usize,
    ) -> Result<Self, Failure> {
        let policy =
            Checkpoint::load(checkpoint).map_err(Failure::input)?.policy().map_err(Failure::input)?;
        let (robot, spec) = load_robot(&preset.robot).map_err(Failure::input)?;
        let rate = 1.0 / preset.task.control_dt_s();
        let motions = MotionLibrary::open(Path::new(&preset.run.motions), &robot, &spec, rate)
            .map_err(Failure::input)?;
        let library =
            Arc::new(ReferenceLibrary::from_motions(&motions, &robot, &spec).map_err(Failure::input)?);
        Ok(Self { robot, spec, library, policy, preset: preset.clone(), settings, threads })
    }

    /// The setup of a surface. The ball has the behavior that was measured on it, as far as MuJoCo's contact can
    /// follow ([`paid_mujoco::contact`]).
    fn setup(&self, surface: &str) -> Result<EvalSetup, Failure> {
        let mut task = self.preset.task.clone();
        task.scene.terrain = Terrain::Plane;
        let perception = &mut task.observations.perception;
        perception.gaussian = true;
        perception.in_evaluation = true;
        perception.latency_s = [self.settings.latency; 2];
        perception.frame_s = self.settings.frame;
        let ball = Surface::load(surface).map_err(Failure::input)?.ball_params;
        task.ball_params = ball;
        let scene = SceneOptions::default().with_builtin_ball(ball, &task.scene);
        task.validate().map_err(Failure::input)?;
        Ok(EvalSetup {
            engine: Engine::Mujoco(Box::new(scene)),
            isa: self.preset.isa().map_err(Failure::input)?,
            robot: self.robot.clone(),
            spec: self.spec.clone(),
            library: Arc::clone(&self.library),
            preset: task,
            threads: self.threads,
            seed: self.settings.seed,
            monitor: Monitor::stopped_by(stop::flag()?),
        })
    }

    /// The score on a surface; `None` if the program was told to stop.
    pub fn score(&self, variant: &str, surface: &str, samples: u64) -> Result<Option<Score>, Failure> {
        let setup = self.setup(surface)?;
        let maker = LearnedPolicy::maker(self.policy.clone());
        let run = |grid: Grid, trials: usize, scatter_m: f64| -> Result<ShootingReport, Failure> {
            let options = ShootingOptions {
                grid,
                trials,
                scatter_m,
                start_radius_m: 0.0,
                variant: Variant::Robot,
                limit_s: self.settings.limit,
                ..ShootingOptions::default()
            };
            shooting::evaluate(&setup, &maker, &options).map_err(Failure::input)
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
