//! Which engine simulates, and MuJoCo's scene.

use std::path::PathBuf;

use clap::ValueEnum;
use paid_eval::engine::Engine;
use paid_eval::file::write_whole;
use paid_mujoco::{Cone, FootShapes, PdControl, SceneOptions, mjcf_scene};
use paid_robot::RobotModel;
use paid_task::TaskPreset;
use paid_train::setup::load_robot;

use crate::failure::Failure;

/// Who simulates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum EngineName {
    /// The engine that trains.
    Builtin,
    /// MuJoCo, the referee.
    Mujoco,
    /// Both on the same trials, compared one by one.
    Both,
}

/// A named set of constants for MuJoCo's scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Protocol {
    /// A size-5 ball of 0.43 kg.
    Paper,
    /// The public evaluation: a solid ball of 0.1 kg.
    Public,
    /// The scene that the TWIST2 tracker is published with: floor friction 1, softer floor, four spheres a foot, no dry friction
    /// in joints, 1 ms steps.
    Twist2,
}

/// Options of MuJoCo's scene.
#[derive(Clone, Debug, Default, clap::Args)]
#[command(next_help_heading = "MuJoCo's scene")]
pub struct SceneOptionsArgs {
    /// Named constants; the other options change single ones [default: paper; twist2 for the TWIST2 tracker].
    #[arg(long, value_enum)]
    protocol: Option<Protocol>,
    /// Physics step [s], a whole part of the control period [default: 0.002; 0.001 with --protocol twist2].
    #[arg(long, value_name = "S", value_parser = positive)]
    physics_dt: Option<f64>,
    /// Sliding friction between feet and floor [default: 0.8].
    #[arg(long, value_name = "MU", value_parser = positive)]
    floor_friction: Option<f64>,
    /// Sliding friction of the ball [default: 0.8].
    #[arg(long, value_name = "MU", value_parser = positive)]
    ball_friction: Option<f64>,
    /// Time constant of contacts with the ball [s]; larger is softer [default: 0.02].
    #[arg(long, value_name = "S", value_parser = positive)]
    ball_contact_time: Option<f64>,
    /// Time constant of contacts with the floor [s]; larger is softer [default: 0.01].
    #[arg(long, value_name = "S", value_parser = positive)]
    floor_contact_time: Option<f64>,
    /// Damping ratio of contacts with the ball; 1 does not bounce, 0.16 asks for a restitution of 0.6 [default: 1].
    #[arg(long, value_name = "RATIO", value_parser = positive)]
    ball_contact_damping: Option<f64>,
    /// The ball's linear and angular damping act in MuJoCo too.
    #[arg(long)]
    ball_damping: bool,
    /// Friction, bounce and damping of the ball as in training, as far as MuJoCo's contact can follow.
    #[arg(long)]
    training_ball: bool,
    /// The training's four spheres a foot instead of the vendor's seven capsules.
    #[arg(long)]
    training_soles: bool,
    /// Joint control with the next velocity's damping, as in training, instead of explicit torques.
    #[arg(long)]
    implicit_pd: bool,
    /// The circular friction cone instead of the pyramid.
    #[arg(long)]
    elliptic_cone: bool,
    /// Bodies of the robot pass through each other.
    #[arg(long)]
    no_self_collision: bool,
    /// Joints have no dry friction.
    #[arg(long)]
    no_friction_loss: bool,
}

/// Which engine, and the ball.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct EngineArgs {
    /// Mass of the ball [kg] [default: the task's, 0.43; 0.1 with --protocol public].
    #[arg(long, value_name = "KG", value_parser = positive)]
    ball_mass: Option<f64>,
    #[command(flatten)]
    scene: SceneOptionsArgs,
}

/// A positive, finite number.
pub fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x > 0.0 && x.is_finite() => Ok(x),
        _ => Err(format!("expected a positive number, found '{text}'")),
    }
}

impl EngineArgs {
    /// MuJoCo's scene, of the `usual` protocol unless another was asked for; the ball of `task` becomes the one that was asked for, in
    /// both engines.
    ///
    /// # Errors
    /// If the physics step is no whole part of the control period.
    pub fn scene(&self, task: &mut TaskPreset, usual: Protocol) -> Result<SceneOptions, Failure> {
        let args = &self.scene;
        let mut scene = match args.protocol.unwrap_or(usual) {
            Protocol::Paper => SceneOptions::default(),
            Protocol::Public => {
                let scene = SceneOptions::public_protocol();
                if let Some(ball) = &scene.ball {
                    task.ball_params.mass_kg = ball.params.mass_kg;
                    task.ball_params.inertia_factor = ball.params.inertia_factor;
                }
                scene
            }
            Protocol::Twist2 => SceneOptions::twist2(),
        };
        if let Some(mass) = self.ball_mass {
            task.ball_params.mass_kg = mass;
        }
        if let Some(ball) = &mut scene.ball {
            ball.params = task.ball_params;
            if args.training_ball {
                *ball = ball.like_builtin(task.ball_params, &task.scene);
            }
            ball.friction[0] = args.ball_friction.unwrap_or(ball.friction[0]);
            ball.solref[0] = args.ball_contact_time.unwrap_or(ball.solref[0]);
            ball.solref[1] = args.ball_contact_damping.unwrap_or(ball.solref[1]);
            ball.damped |= args.ball_damping;
        }
        scene.floor.friction[0] = args.floor_friction.unwrap_or(scene.floor.friction[0]);
        scene.floor.solref[0] = args.floor_contact_time.unwrap_or(scene.floor.solref[0]);
        if args.training_soles {
            scene.feet = FootShapes::Sole;
        }
        if args.implicit_pd {
            scene.pd = PdControl::Implicit;
        }
        if args.elliptic_cone {
            scene.cone = Cone::Elliptic;
        }
        scene.self_collision = !args.no_self_collision;
        scene.friction_loss &= !args.no_friction_loss;
        let (dt, control_dt) = (args.physics_dt.unwrap_or(scene.physics_dt_s), task.control_dt_s());
        scene.substeps = (control_dt / dt).round() as usize;
        scene.physics_dt_s = dt;
        if args.training_ball && args.ball_contact_time.is_none() {
            scene.resolve_contacts();
        }
        if scene.substeps == 0 || (scene.substeps as f64 * dt - control_dt).abs() > 1e-9 {
            return Err(Failure::input(format!(
                "--physics-dt: expected a whole part of the control period of {control_dt} s, found {dt}"
            )));
        }
        Ok(scene)
    }
}

/// Refuses shapes of the feet that are another robot's.
///
/// # Errors
/// If the scene has the spheres of the G1's feet and `robot` is none.
pub fn check_feet(scene: &SceneOptions, robot: &RobotModel) -> Result<(), Failure> {
    let g1 = RobotModel::g1().name;
    if scene.feet == FootShapes::Spheres && robot.name != g1 {
        let found = &robot.name;
        return Err(Failure::input(format!("--protocol twist2: expected the robot '{g1}', found '{found}'")));
    }
    Ok(())
}

/// The engine of a name; `Both` begins with the built-in one.
pub fn engine_of(name: EngineName, scene: &SceneOptions) -> Engine {
    match name {
        EngineName::Builtin | EngineName::Both => Engine::Builtin,
        EngineName::Mujoco => Engine::Mujoco(Box::new(scene.clone())),
    }
}

/// Arguments of `paid eval scene`.
#[derive(Debug, clap::Args)]
pub struct SceneArgs {
    /// Built-in robot or robot file.
    #[arg(long, default_value = "g1")]
    robot: String,
    #[command(flatten)]
    engine: EngineArgs,
    /// The file to write.
    #[arg(long, value_name = "FILE", default_value = "scene.xml")]
    out: PathBuf,
}

/// Writes the scene.
pub fn write_scene(args: &SceneArgs) -> Result<(), Failure> {
    let (robot, spec) = load_robot(&args.robot).map_err(Failure::input)?;
    let control = spec.resolve(&robot).map_err(Failure::input)?;
    let mut task = TaskPreset::builtin("paper_stage2").map_err(Failure::input)?;
    let scene = args.engine.scene(&mut task, Protocol::Paper)?;
    check_feet(&scene, &robot)?;
    let xml = mjcf_scene(&robot, &control, &scene);
    write_whole(&args.out, xml.as_bytes()).map_err(Failure::input)?;
    println!("{}: {} bodies, {} joints", args.out.display(), robot.bodies.len(), robot.joints.len());
    Ok(())
}
