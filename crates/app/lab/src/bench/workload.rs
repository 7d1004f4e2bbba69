//! What the robots do while they are timed.

use paid_lanes::rng::Rng;
use paid_physics::{GroupState, LaneState, SceneConfig, Terrain};
use paid_robot::{ControlSpec, RobotModel, RobotSpec};

use paid_eval::EvalError;

/// Control steps between resets: the robots stand, stagger and begin to fall.
pub const EPISODE: usize = 50;
/// Targets stray from the default pose by this `[rad]`.
const STRAY_RAD: f64 = 0.15;
const SEED: u64 = 1;

/// A robot on its feet that follows random targets, the ball before it.
pub struct Workload {
    pub model: RobotModel,
    pub control: ControlSpec,
    pub feet: [usize; 2],
    pub scene: SceneConfig,
    height: f64,
}

/// The rough ground of PAiD's public training code.
pub fn rough() -> Terrain {
    Terrain::Rough { amplitude_m: 0.02, step_m: 0.02, cell_m: 0.1, size: 64, seed: SEED }
}

impl Workload {
    /// With every feature of the scene on.
    pub fn new(terrain: Terrain) -> Result<Self, EvalError> {
        let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
        let control = spec.resolve(&model)?;
        let feet = spec.indices(&model)?.feet;
        let scene = SceneConfig { terrain, ..SceneConfig::default() };
        Ok(Self { model, control, feet, scene, height: spec.nominal_height_m })
    }

    /// The state at the start of an episode of environment `env`, `ground` being the height of the ground `[m]`.
    pub fn start(&self, env: u32, ground: f64) -> LaneState {
        let mut rng = Rng::new(SEED, env, 0);
        LaneState {
            base_pos: [0.0, 0.0, self.height + ground],
            base_quat: [1.0, 0.0, 0.0, 0.0],
            base_lin_vel: std::array::from_fn(|_| rng.uniform(-0.2, 0.2)),
            base_ang_vel: std::array::from_fn(|_| rng.uniform(-0.2, 0.2)),
            joint_pos: self.control.default_pos.clone(),
            joint_vel: vec![0.0; self.control.default_pos.len()],
            ball_pos: [rng.uniform(0.3, 0.6), rng.uniform(-0.3, 0.3), 0.11 + ground],
            ball_vel: [0.0; 3],
            ball_ang_vel: [0.0; 3],
            warm_start: Vec::new(),
        }
    }

    /// Joint targets `[rad]` of environment `env` for the steps of an episode.
    pub fn targets(&self, env: u32) -> Vec<Vec<f64>> {
        let mut rng = Rng::new(SEED, env, 1);
        let mut step =
            || self.control.default_pos.iter().map(|q| q + rng.uniform(-STRAY_RAD, STRAY_RAD)).collect();
        (0..EPISODE).map(|_| step()).collect()
    }
}

/// Means over an episode, to show that simulators do the same work.
#[derive(Default)]
pub struct Means {
    contacts: f64,
    height: f64,
    samples: f64,
}

impl Means {
    /// Takes in a group after a control step.
    pub fn take<V: paid_lanes::Real>(&mut self, state: &GroupState<V>, feet: [usize; 2]) {
        for lane in 0..V::LANES {
            for foot in feet {
                if state.contact_force[foot].norm().lane(lane) > 1.0 {
                    self.contacts += 0.5;
                }
            }
            self.height += state.bodies[0].pos.z().lane(lane);
            self.samples += 1.0;
        }
    }

    /// Share of foot contact and mean height.
    pub fn get(&self) -> (f64, f64) {
        (self.contacts / self.samples, self.height / self.samples)
    }
}
