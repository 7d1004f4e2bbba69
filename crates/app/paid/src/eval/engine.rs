//! Arguments for the engine, the ball and MuJoCo's scene.

use std::path::PathBuf;

use clap::ValueEnum;
use paid_eval::ground::Ground;
use paid_eval::scene::{Engines, ScenePreset, SceneSpec, check_feet};
use paid_files::write_whole;
use paid_mujoco::mjcf_scene;
use paid_play::load_robot;
use paid_task::TaskPreset;

use super::out::writable;
use crate::failure::Failure;

/// Engine that simulates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum EngineName {
    /// The engine used for training.
    Builtin,
    /// MuJoCo, the reference simulator.
    Mujoco,
    /// Both, on the same trials, compared one by one.
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

/// The ball, and MuJoCo's scene.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct EngineArgs {
    /// MuJoCo's scene: paper, real, public, twist2 or a file [default: paper].
    ///
    /// real has a ball that bounces as a filmed one did. public has a solid ball of 0.1 kg. twist2 is the scene that the TWIST2 tracker was
    /// published with, and its default. `paid eval scene --print` prints a file to edit.
    #[arg(long, help_heading = "Simulation", value_name = "NAME|FILE", value_parser = SceneSpec::load)]
    scene: Option<SceneSpec>,
    /// Ground in MuJoCo, such as rough-2cm, slope-4deg or turf [default: flat].
    ///
    /// flat, rough-1cm, rough-2cm, rough-3cm, slope-2deg, slope-4deg, turf or hard. On rough ground, heights of plus and minus 1, 2 or 3 cm lie 10 cm apart at random; a ball that is to lie still lies in a dip. Slopes
    /// fall in a random direction, and the ball rolls down. Heights and direction differ between trials. Turf yields and slows the ball.
    #[arg(long, help_heading = "Simulation", value_name = "GROUND")]
    ground: Option<Ground>,
}

/// A positive, finite number.
pub fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x > 0.0 && x.is_finite() => Ok(x),
        _ => Err(format!("expected a positive number, found '{text}'")),
    }
}

/// A number of trials, kicks, images and so on. More than a million is a typing error.
pub fn count(text: &str) -> Result<usize, String> {
    const MOST: usize = 1_000_000;
    let found = text.parse().ok().filter(|count| (0..=MOST).contains(count));
    found.ok_or_else(|| format!("expected a whole number from 0 to {MOST}, found '{text}'"))
}

impl EngineArgs {
    /// A value that was given and changes nothing but MuJoCo's scene. The public protocol has another ball, in both engines.
    pub fn only_in_mujoco(&self) -> Option<&'static str> {
        let public = |spec: &SceneSpec| spec.protocol == Some(ScenePreset::Public);
        let spec = self.scene.as_ref()?;
        // --ground is checked on its own.
        let elsewhere = |key| matches!(key, "ball_mass_kg" | "ground") || key == "protocol" && public(spec);
        spec.given().find(|key| !elsewhere(key))
    }

    /// A value that was given and that every ball of the panel sets itself ([`paid_eval::panel::PanelBall::apply`]).
    pub fn set_by_panel(&self) -> Option<&'static str> {
        let of_panel =
            |key: &&str| key.starts_with("ball_") || key.starts_with("floor_") || *key == "training_ball";
        let ground = self.other_ground().map(|_| "ground");
        ground.or_else(|| self.scene.as_ref()?.given().find(of_panel))
    }

    /// Another ground than the flat one, by --ground or, without that, the scene file.
    pub fn other_ground(&self) -> Option<Ground> {
        self.spec().ground.filter(|ground| *ground != Ground::Flat)
    }

    /// The scene that was asked for.
    pub fn spec(&self) -> SceneSpec {
        let spec = self.scene.clone().unwrap_or_default();
        SceneSpec { ground: self.ground.or(spec.ground), ..spec }
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
    /// MJCF file to write.
    #[arg(long, value_name = "FILE", default_value = "scene.xml")]
    out: PathBuf,
    /// Print the scene as a file for --scene, with all keys, instead of writing MJCF.
    #[arg(long, conflicts_with = "out")]
    print: bool,
}

/// Writes the scene, or prints its file.
pub fn write_scene(args: &SceneArgs) -> Result<(), Failure> {
    let (robot, spec) = load_robot(&args.robot).map_err(Failure::input)?;
    let control = spec.resolve(&robot).map_err(Failure::input)?;
    let mut task = TaskPreset::builtin("paper_stage2").map_err(Failure::input)?;
    let (asked, usual) = (args.engine.spec(), ScenePreset::Paper);
    let scene = asked.resolve(&mut task, usual)?;
    check_feet(&scene, &robot)?;
    if args.print {
        print!("{}", asked.filled(&scene, &task, usual).to_toml());
        return Ok(());
    }
    let xml = mjcf_scene(&robot, &control, &scene);
    if let Some(folder) = args.out.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        writable("--out", folder)?;
    }
    write_whole(&args.out, xml.as_bytes())?;
    println!("{}: {} bodies, {} joints", args.out.display(), robot.bodies.len(), robot.joints.len());
    Ok(())
}
