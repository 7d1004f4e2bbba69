//! Arguments for the engine, the ball and MuJoCo's scene.

use std::path::PathBuf;

use clap::ValueEnum;
use paid_eval::scene::{Engines, ScenePreset, SceneSpec, check_feet};
use paid_files::write_whole;
use paid_mujoco::mjcf_scene;
use paid_play::load_robot;
use paid_task::TaskPreset;

use super::out::writable;
use crate::failure::{Failure, first_given};

/// Engine that simulates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum EngineName {
    /// The engine that trains.
    Builtin,
    /// MuJoCo, the referee.
    Mujoco,
    /// Both on the same trials, compared one by one.
    Both,
}

impl From<EngineName> for Engines {
    fn from(name: EngineName) -> Self {
        match name {
            EngineName::Builtin => Self::Builtin,
            EngineName::Mujoco => Self::Mujoco,
            EngineName::Both => Self::Both,
        }
    }
}

/// A named set of constants for MuJoCo's scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Protocol {
    /// A size-5 ball of 0.43 kg.
    Paper,
    /// The public evaluation: a solid ball of 0.1 kg.
    Public,
    /// The scene that the TWIST2 tracker is published with: floor friction 1, a softer floor, four spheres per foot, no dry friction
    /// in the joints, 1 ms steps.
    Twist2,
}

impl From<Protocol> for ScenePreset {
    fn from(protocol: Protocol) -> Self {
        match protocol {
            Protocol::Paper => Self::Paper,
            Protocol::Public => Self::Public,
            Protocol::Twist2 => Self::Twist2,
        }
    }
}

/// Options of MuJoCo's scene.
#[derive(Clone, Debug, Default, clap::Args)]
#[command(next_help_heading = "MuJoCo's scene")]
pub struct SceneOptionsArgs {
    /// Named constants; the options below change single ones [default: paper; twist2 for the TWIST2 tracker].
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
    /// Apply the ball's linear and angular damping in MuJoCo too.
    #[arg(long)]
    ball_damping: bool,
    /// Give the ball the friction, bounce and damping of training, as far as MuJoCo's contact can follow.
    #[arg(long)]
    training_ball: bool,
    /// Use the training's four spheres per foot instead of the vendor's seven capsules.
    #[arg(long)]
    training_soles: bool,
    /// Damp joint control with the next velocity, as in training, instead of computing torques explicitly.
    #[arg(long)]
    implicit_pd: bool,
    /// Use the circular friction cone instead of the pyramid.
    #[arg(long)]
    elliptic_cone: bool,
    /// Let the robot's bodies pass through each other.
    #[arg(long)]
    no_self_collision: bool,
    /// Sliding friction between the robot's own bodies [default: 1].
    #[arg(long, value_name = "MU", value_parser = not_negative)]
    self_friction: Option<f64>,
    /// Time constant of contacts between the robot's own bodies [s]; larger is softer [default: 0.02].
    #[arg(long, value_name = "S", value_parser = positive)]
    self_contact_time: Option<f64>,
    /// Remove the joints' dry friction.
    #[arg(long)]
    no_friction_loss: bool,
}

/// The ball, and MuJoCo's scene.
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

/// A count of trials, kicks, pictures and such: more than the most that anyone waits for is a slip.
pub fn count(text: &str) -> Result<usize, String> {
    const MOST: usize = 1_000_000;
    let found = text.parse().ok().filter(|count| (0..=MOST).contains(count));
    found.ok_or_else(|| format!("expected a whole number from 0 to {MOST}, found '{text}'"))
}

/// A number that is not negative, and finite.
fn not_negative(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x >= 0.0 && x.is_finite() => Ok(x),
        _ => Err(format!("expected a number that is not negative, found '{text}'")),
    }
}

impl EngineArgs {
    /// An option that was given and changes nothing but MuJoCo's scene.
    pub fn only_in_mujoco(&self) -> Option<&'static str> {
        let args = &self.scene;
        // The public protocol has another ball, in both engines.
        let protocol = args.protocol.is_some_and(|protocol| protocol != Protocol::Public);
        first_given(&[
            ("--protocol", protocol),
            ("--physics-dt", args.physics_dt.is_some()),
            ("--floor-friction", args.floor_friction.is_some()),
            ("--ball-friction", args.ball_friction.is_some()),
            ("--ball-contact-time", args.ball_contact_time.is_some()),
            ("--floor-contact-time", args.floor_contact_time.is_some()),
            ("--ball-contact-damping", args.ball_contact_damping.is_some()),
            ("--ball-damping", args.ball_damping),
            ("--training-ball", args.training_ball),
            ("--training-soles", args.training_soles),
            ("--implicit-pd", args.implicit_pd),
            ("--elliptic-cone", args.elliptic_cone),
            ("--no-self-collision", args.no_self_collision),
            ("--self-friction", args.self_friction.is_some()),
            ("--self-contact-time", args.self_contact_time.is_some()),
            ("--no-friction-loss", args.no_friction_loss),
        ])
    }

    /// An option that was given and is said anew by every ball of the panel ([`paid_eval::panel::PanelBall::apply`]).
    pub fn said_by_panel(&self) -> Option<&'static str> {
        let args = &self.scene;
        first_given(&[
            ("--ball-mass", self.ball_mass.is_some()),
            ("--ball-friction", args.ball_friction.is_some()),
            ("--ball-contact-time", args.ball_contact_time.is_some()),
            ("--ball-contact-damping", args.ball_contact_damping.is_some()),
            ("--ball-damping", args.ball_damping),
            ("--training-ball", args.training_ball),
            ("--floor-friction", args.floor_friction.is_some()),
            ("--floor-contact-time", args.floor_contact_time.is_some()),
        ])
    }

    /// The scene that was asked for.
    pub fn spec(&self) -> SceneSpec {
        let args = &self.scene;
        SceneSpec {
            preset: args.protocol.map(ScenePreset::from),
            ball_mass_kg: self.ball_mass,
            physics_dt_s: args.physics_dt,
            floor_friction: args.floor_friction,
            ball_friction: args.ball_friction,
            ball_contact_time_s: args.ball_contact_time,
            floor_contact_time_s: args.floor_contact_time,
            ball_contact_damping: args.ball_contact_damping,
            ball_damping: args.ball_damping,
            training_ball: args.training_ball,
            training_soles: args.training_soles,
            implicit_pd: args.implicit_pd,
            elliptic_cone: args.elliptic_cone,
            no_self_collision: args.no_self_collision,
            self_friction: args.self_friction,
            self_contact_time_s: args.self_contact_time,
            no_friction_loss: args.no_friction_loss,
        }
    }
}

/// Arguments of `paid eval scene`.
#[derive(Debug, clap::Args)]
pub struct SceneArgs {
    /// Robot: built in, or a robot file.
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
    let scene = args.engine.spec().resolve(&mut task, ScenePreset::Paper)?;
    check_feet(&scene, &robot)?;
    let xml = mjcf_scene(&robot, &control, &scene);
    if let Some(folder) = args.out.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        writable("--out", folder)?;
    }
    write_whole(&args.out, xml.as_bytes())?;
    println!("{}: {} bodies, {} joints", args.out.display(), robot.bodies.len(), robot.joints.len());
    Ok(())
}
