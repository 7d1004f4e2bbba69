//! Measurement files of a ball that is known.

use std::path::PathBuf;

use clap::ValueEnum;
use paid_files::FileSet;
use paid_sysid::Surface;
use paid_sysid::csv::{Quantity, write_runs};
use paid_sysid::options::{NAMES, Parameters, parameters_of, with_parameters};
use paid_sysid::simulate::{Experiment, FifaFigures, MujocoBall, Source, ramp_speed, simulate};
use serde::Serialize;

use super::{World, five};
use crate::failure::Failure;

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum SourceArg {
    /// The built-in engine with known parameters.
    Parameters,
    /// MuJoCo's ball (needs `cargo mujoco`).
    Mujoco,
    /// Closed form with FIFA's limits for turf: rebound 0.60 to 0.85 m from 2 m, roll of 4 to 8 m from the ramp.
    Turf,
    /// Closed form with FIFA's limits for steel: rebound 1.35 to 1.55 m; no rolls unless --roll-length is given.
    Steel,
}

/// Arguments of `paid sysid simulate`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder for drop.csv and roll.csv.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// What moves the ball.
    #[arg(long, value_enum, default_value = "parameters")]
    from: SourceArg,
    /// Surface whose ball is simulated: hard, grass or a file.
    ///
    /// Without it, the ball is the task's.
    #[arg(long, value_name = "NAME|FILE", conflicts_with = "parameters")]
    surface: Option<String>,
    /// Static and dynamic friction, restitution, damping (linear, angular).
    #[arg(long, value_name = "S,D,R,L,A", value_parser = five)]
    parameters: Option<Parameters>,
    /// Repeats of each experiment.
    #[arg(long, default_value_t = Experiment::default().repeats)]
    repeats: usize,
    /// Drop height [m].
    #[arg(long, default_value_t = Experiment::default().height_m)]
    height: f64,
    /// Initial speed of the roll [m/s] [default: 2; turf and steel 3.43].
    ///
    /// 3.43 m/s is the speed from FIFA's ramp.
    #[arg(long)]
    speed: Option<f64>,
    /// Initial spin of the rolling ball: 1 rolls, 0 slides.
    #[arg(long, default_value_t = Experiment::default().spin)]
    spin: f64,
    /// Also write slide.csv: balls pushed off at this speed without spin [m/s].
    #[arg(long, value_name = "SPEED")]
    slide: Option<f64>,
    /// Length of a run [s].
    #[arg(long, default_value_t = Experiment::default().duration_s)]
    duration: f64,
    /// Camera frames per second.
    #[arg(long, default_value_t = Experiment::default().rate_hz)]
    rate: f64,
    /// Standard deviation of the camera's error [m].
    #[arg(long, default_value_t = Experiment::default().noise_m)]
    noise: f64,
    /// Rebound after a drop from 2 m [m] [default: middle of the range].
    ///
    /// The range is what FIFA allows.
    #[arg(long, help_heading = "Turf and steel")]
    rebound: Option<f64>,
    /// Roll from FIFA's ramp [m] [default: for turf, middle of the range].
    ///
    /// The range is what FIFA allows.
    #[arg(long, help_heading = "Turf and steel")]
    roll_length: Option<f64>,
    /// Damping ratio of the contact; 0.15 returns about 0.6 of the speed.
    #[arg(long, value_name = "RATIO", help_heading = "MuJoCo", default_value_t = MujocoBall::default().options.solref[1])]
    damping_ratio: f64,
    /// Rolling friction [m].
    #[arg(long, value_name = "M", help_heading = "MuJoCo", default_value_t = MujocoBall::default().options.friction[2])]
    rolling_friction: f64,
    /// Seed of noise and repeats.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    world: World,
}

#[derive(Serialize)]
struct Made {
    files: Vec<String>,
    source: String,
    truth: Option<Parameters>,
}

/// Simulates, writes, prints.
pub fn run(args: &Args, given: &[String]) -> Result<(), Failure> {
    refuse_ignored(args.from, given)?;
    let (source, truth) = source(args)?;
    let fifa = matches!(source, Source::Fifa(_));
    let default_speed = if fifa { ramp_speed() } else { Experiment::default().speed };
    let experiment = Experiment {
        repeats: args.repeats,
        height_m: args.height,
        speed: args.speed.unwrap_or(default_speed),
        spin: args.spin,
        duration_s: args.duration,
        rate_hz: args.rate,
        noise_m: args.noise,
        seed: args.seed,
    };
    let made = simulate(&experiment, &source).map_err(Failure::input)?;
    let described = describe(args, truth.as_ref());
    let comments = [format!("Simulated: {described}."), format!("Camera noise {} m.", args.noise)];
    let mut files = FileSet::default();
    for (name, runs, quantity) in
        [("drop.csv", &made.drops, Quantity::Height), ("roll.csv", &made.rolls, Quantity::Distance)]
    {
        if !runs.is_empty() {
            files.add(args.out.join(name), write_runs(runs, quantity, &comments).into_bytes());
        }
    }
    if let Some(speed) = args.slide {
        if fifa {
            return Err(Failure::input(
                "--slide: expected with --from parameters or mujoco; FIFA has no such test",
            ));
        }
        // Another seed: other hands, other noise.
        let pushed = Experiment { speed, spin: 0.0, seed: args.seed.wrapping_add(1 << 32), ..experiment };
        let runs = simulate(&pushed, &source).map_err(Failure::input)?.rolls;
        files.add(args.out.join("slide.csv"), write_runs(&runs, Quantity::Distance, &comments).into_bytes());
    }
    let files: Vec<String> = files.write()?.iter().map(|p| p.display().to_string()).collect();
    if args.json {
        let line = serde_json::to_string(&Made { files, source: described, truth });
        println!("{}", line.map_err(Failure::input)?);
    } else {
        println!("{described}: {}", files.join(", "));
    }
    Ok(())
}

/// Refuses an option that the source does not look at.
fn refuse_ignored(from: SourceArg, given: &[String]) -> Result<(), Failure> {
    const BALL: [SourceArg; 2] = [SourceArg::Parameters, SourceArg::Mujoco];
    const FIFA: [SourceArg; 2] = [SourceArg::Turf, SourceArg::Steel];
    let options: [(&str, &[SourceArg], &str); 9] = [
        ("spin", &BALL, "parameters or mujoco"),
        ("task", &BALL, "parameters or mujoco"),
        ("isa", &[SourceArg::Parameters], "parameters"),
        ("surface", &BALL, "parameters or mujoco"),
        ("parameters", &BALL, "parameters or mujoco"),
        ("rebound", &FIFA, "turf or steel"),
        ("roll_length", &FIFA, "turf or steel"),
        ("damping_ratio", &[SourceArg::Mujoco], "mujoco"),
        ("rolling_friction", &[SourceArg::Mujoco], "mujoco"),
    ];
    let others = options.iter().filter(|(_, of, _)| !of.contains(&from));
    let found =
        from.to_possible_value().map_or_else(String::new, |name| format!("--from {}", name.get_name()));
    // Its option has another name than its field.
    if FIFA.contains(&from) && given.iter().any(|id| id == "sets") {
        return Err(Failure::input(format!("--set: expected --from parameters or mujoco, found {found}")));
    }
    Failure::if_ignored(others.map(|(id, _, expected)| (*id, format!("--from {expected}"))), given, &found)
}

/// The source, and the true parameters where it has them.
fn source(args: &Args) -> Result<(Source, Option<Parameters>), Failure> {
    let (scene, mut ball) = args.world.load()?;
    if let Some(surface) = &args.surface {
        ball = Surface::load(surface).map_err(Failure::input)?.ball_params;
    }
    if let Some(parameters) = &args.parameters {
        if let Some(i) = parameters.iter().position(|p| *p < 0.0) {
            let found = parameters[i];
            return Err(Failure::input(format!(
                "--parameters: {}: expected at least 0, found {found}",
                NAMES[i]
            )));
        }
        ball = with_parameters(&ball, parameters);
    }
    if let Some((option, x)) =
        [("--damping-ratio", args.damping_ratio), ("--rolling-friction", args.rolling_friction)]
            .into_iter()
            .find(|(_, x)| !(1e-6..=10.0).contains(x))
    {
        return Err(Failure::input(format!("{option}: expected 0.000001 to 10, found {x}")));
    }
    let figures = |of: FifaFigures| FifaFigures {
        rebound_m: args.rebound.unwrap_or(of.rebound_m),
        roll_m: args.roll_length.or(of.roll_m),
    };
    Ok(match args.from {
        SourceArg::Parameters => {
            let isa = args.world.isa.parse().map_err(Failure::input)?;
            (Source::Engine { ball, scene, isa }, Some(parameters_of(&ball)))
        }
        SourceArg::Mujoco => {
            let mut mujoco = MujocoBall::default();
            mujoco.options.params = ball;
            mujoco.options.solref[1] = args.damping_ratio;
            mujoco.options.friction[2] = args.rolling_friction;
            (Source::Mujoco(mujoco), None)
        }
        SourceArg::Turf => (Source::Fifa(figures(FifaFigures::TURF)), None),
        SourceArg::Steel => (Source::Fifa(figures(FifaFigures::STEEL)), None),
    })
}

fn describe(args: &Args, truth: Option<&Parameters>) -> String {
    match (args.from, truth) {
        (SourceArg::Parameters, Some(p)) => {
            let values: Vec<String> = p.iter().map(f64::to_string).collect();
            format!("built-in engine, truth {}", values.join(","))
        }
        (SourceArg::Parameters, None) => "built-in engine".to_owned(),
        (SourceArg::Mujoco, _) => {
            format!(
                "MuJoCo, damping ratio {}, rolling friction {} m",
                args.damping_ratio, args.rolling_friction
            )
        }
        (SourceArg::Turf, _) => "closed form with FIFA's limits for turf".to_owned(),
        (SourceArg::Steel, _) => "closed form with FIFA's limits for steel".to_owned(),
    }
}
