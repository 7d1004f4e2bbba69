//! Random impacts of ball and leg in both engines: does the ball leave with the same speed, direction and spin?
//!
//! The robot floats without gravity, one leg swings, and a spinning ball flies into its foot or shin. Half of the legs are driven by their
//! joint controllers, the others are free.

mod draw;
mod report;
mod run;

use paid_mujoco::contact::{builtin_kind, builtin_surface};
use paid_mujoco::{FootShapes, MujocoSim, SceneOptions};
use paid_physics::{BallParams, ContactKind, Engine, EngineSpec, EnvParams, Material, SceneConfig, Terrain};
use paid_robot::{RobotModel, RobotSpec};

use paid_eval::EvalError;

pub use draw::{Impact, Leg};
pub use report::{Errors, ImpactReport, ImpactRow};
pub use run::{Exit, run};

/// What is compared.
#[derive(Clone, Debug, PartialEq)]
pub struct ImpactOptions {
    /// Impacts.
    pub trials: usize,
    /// Seed of the draws.
    pub seed: u64,
    /// Physics step of the built-in engine `[s]`.
    pub physics_dt_s: f64,
    /// MuJoCo's scene. Its ball, controllers and step count; gravity and floor do not, and the feet have the built-in engine's
    /// shapes.
    pub scene: SceneOptions,
}

impl Default for ImpactOptions {
    /// A thousand impacts of the usual ball at the built-in engine's usual step.
    fn default() -> Self {
        Self { trials: 1000, seed: 0, physics_dt_s: 0.005, scene: SceneOptions::default() }
    }
}

/// A row that compares the built-in engine: its name and the kind of its contacts.
struct Kind {
    name: &'static str,
    surface: Material,
    kind: ContactKind,
}

/// Runs the impacts in MuJoCo, in MuJoCo with half its step (what agreement is possible at all), and in the built-in engine with
/// its hard contact and with the kind of contact that comes nearest to MuJoCo's.
///
/// # Errors
/// If MuJoCo is missing or a scene is refused.
pub fn evaluate(
    robot: &RobotModel,
    spec: &RobotSpec,
    options: &ImpactOptions,
) -> Result<ImpactReport, EvalError> {
    let control = spec.resolve(robot)?;
    let mut scene =
        SceneOptions { gravity: 0.0, substeps: 1, self_collision: false, ..options.scene.clone() };
    scene.feet = FootShapes::Sole;
    let usual = scene.ball.unwrap_or_default();
    let params = BallParams { linear_damping: 0.0, angular_damping: 0.0, ..usual.params };
    scene.ball = Some(paid_mujoco::BallOptions { params, ..usual });
    let feet = spec.indices(robot)?.feet;
    let leg = Leg { model: robot, control: &control, feet, radius_m: params.radius_m };
    let impacts: Vec<Impact> =
        (0..options.trials).filter_map(|i| leg.impact(options.seed, i as u32)).collect();
    let in_mujoco = |dt: f64| -> Result<Vec<Option<Exit>>, EvalError> {
        let scene = SceneOptions { physics_dt_s: dt, ..scene.clone() };
        let mut sim = MujocoSim::new(robot, &control, &scene, 1)?;
        let plain = EnvParams { ball: params, ..EnvParams::default() };
        Ok(impacts.iter().map(|impact| run(&mut sim, &plain, impact)).collect())
    };
    let reference = in_mujoco(scene.physics_dt_s)?;
    let mut report = ImpactReport::new(options, &impacts, &reference);
    let finer = in_mujoco(0.5 * scene.physics_dt_s)?;
    report.add("MuJoCo, half the step", scene.physics_dt_s * 0.5, &reference, &finer);
    let config = SceneConfig {
        physics_dt_s: options.physics_dt_s,
        substeps: 1,
        gravity: 0.0,
        terrain: Terrain::Plane,
        self_collision: false,
        ..SceneConfig::default()
    };
    let surface = builtin_surface(&scene);
    let kind = builtin_kind(&scene, options.physics_dt_s);
    let pd = ContactKind { pd_implicitness: kind.pd_implicitness, ..ContactKind::default() };
    let kinds = [
        Kind { name: "built-in, hard", surface, kind: ContactKind::default() },
        Kind { name: "built-in, hard, MuJoCo's PD", surface, kind: pd },
        Kind { name: "built-in, as MuJoCo", surface, kind },
    ];
    for Kind { name, surface, kind } in kinds {
        let spec = EngineSpec::for_robot(robot, spec)?;
        let mut engine = Engine::<f64>::new(robot, spec, &config, 1)?;
        let ball = BallParams { material: surface, ..params };
        let env = EnvParams { robot: surface, ball, kind, ..EnvParams::default() };
        let exits: Vec<_> = impacts.iter().map(|impact| run(&mut engine, &env, impact)).collect();
        report.add(name, options.physics_dt_s, &reference, &exits);
    }
    Ok(report)
}
