//! MuJoCo under the clock: the same robot, ball, targets, step and joint control as the built-in engine on the plane.
//!
//! MuJoCo runs with its Newton solver at default settings and its implicit integrator, which treats the controllers'
//! damping as the built-in engine does. Only control values are written and steps taken while the clock runs, no reports.

use paid_eval::EvalError;
use paid_mujoco::{BallOptions, FloorOptions, FootShapes, Library, MujocoSim, PdControl, SceneOptions};
use paid_physics::Simulator;

use super::clock::{Rate, timed};
use super::workload::{EPISODE, Means, Workload};
use super::{Contender, Row, Speed};

/// Environments per thread; more would only strain the caches.
const ENVS: usize = 8;

struct Mujoco<'a> {
    feet: FootShapes,
    workload: &'a Workload,
}

/// Adds MuJoCo with both shapes of the feet, or says why it cannot.
pub fn contenders<'a>(workload: &'a Workload, out: &mut Vec<Box<dyn Contender + 'a>>) -> Result<(), String> {
    Library::get().map_err(|e| e.to_string())?;
    for feet in [FootShapes::Referee, FootShapes::Sole] {
        out.push(Box::new(Mujoco { feet, workload }));
    }
    Ok(())
}

struct Runner {
    sim: MujocoSim,
    targets: Vec<Vec<Vec<f64>>>,
    step: usize,
    contacts: u64,
}

impl Mujoco<'_> {
    fn runner(&self) -> Result<Runner, EvalError> {
        let (w, scene) = (self.workload, &self.workload.scene);
        let friction = scene.ground.dynamic_friction;
        let options = SceneOptions {
            physics_dt_s: scene.physics_dt_s,
            substeps: scene.substeps,
            gravity: scene.gravity,
            pd: PdControl::Implicit,
            feet: self.feet,
            self_collision: scene.self_collision,
            floor: FloorOptions { friction: [friction, 0.005, 0.0001], ..FloorOptions::default() },
            ball: Some(BallOptions { damped: true, ..BallOptions::default() }),
            goal: None,
            ..SceneOptions::default()
        };
        let sim = MujocoSim::new(&w.model, &w.control, &options, ENVS)?;
        let targets = (0..ENVS).map(|env| w.targets(env as u32)).collect();
        let mut runner = Runner { sim, targets, step: 0, contacts: 0 };
        for env in 0..ENVS {
            runner.reset(w, env);
        }
        Ok(runner)
    }
}

impl Runner {
    fn reset(&mut self, workload: &Workload, env: usize) {
        self.sim.reset_lane(env, 0, &workload.start(env as u32, 0.0));
    }

    /// One control step of every environment, without reports. Returns physics steps.
    fn round(&mut self, workload: &Workload) -> u64 {
        let substeps = workload.scene.substeps;
        for env in 0..ENVS {
            // Spread over the episode, so that every round does the same mixture.
            let step = (self.step + env * EPISODE / ENVS) % EPISODE;
            if step == 0 {
                self.reset(workload, env);
            }
            let world = self.sim.world_mut(env);
            world.ctrl_mut().copy_from_slice(&self.targets[env][step]);
            for _ in 0..substeps {
                world.step();
                self.contacts += world.contact_count() as u64;
            }
        }
        self.step += 1;
        (ENVS * substeps) as u64
    }
}

impl Contender for Mujoco<'_> {
    fn speed(&self, threads: usize, seconds: f64) -> Result<Rate, EvalError> {
        timed(threads, seconds, || self.runner(), |r| r.round(self.workload))
    }

    fn row(&self) -> Result<Row, EvalError> {
        let w = self.workload;
        let mut runner = self.runner()?;
        let mut means = Means::default();
        for step in 0..EPISODE {
            for env in 0..ENVS {
                runner.sim.step(env, &runner.targets[env][step]);
                means.take(runner.sim.state(env), w.feet);
            }
        }
        let (foot_contact_share, mean_base_height_m) = means.get();
        // The mixture that is timed, from its second episode on.
        for _ in 0..EPISODE {
            runner.round(w);
        }
        runner.contacts = 0;
        let steps: u64 = (0..EPISODE).map(|_| runner.round(w)).sum();
        let feet = match self.feet {
            FootShapes::Referee => "plane, vendor's feet",
            FootShapes::Sole => "plane, sole spheres",
            FootShapes::Spheres => "plane, small spheres",
        };
        Ok(Row {
            simulator: "MuJoCo".to_owned(),
            scene: feet.to_owned(),
            one_core: Speed::default(),
            all_cores: Speed::default(),
            foot_contact_share,
            mean_base_height_m,
            mean_contacts: Some(runner.contacts as f64 / steps as f64),
            engine_is_faster_by: None,
        })
    }
}
