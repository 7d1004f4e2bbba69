//! `paid eval`: scores a policy and draws what it does.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

use paid_eval::episodes::{Arena, run_episodes};
use paid_eval::file::write_whole;
use paid_eval::picture::{Film, HeatMap, Path as BallPath, film_strip, frame, plot_paths};
use paid_eval::policy::LearnedPolicy;
use paid_eval::shooting::{self, CellScore, Grid, Placement, ShootingOptions, ShootingReport, Variant};
use paid_eval::tracking::{self, TrackingOptions, TrackingReport};
use paid_learn::{Checkpoint, Policy};
use paid_motion::MotionLibrary;
use paid_physics::Terrain;
use paid_task::{ForcedStart, ReferenceLibrary, TaskPreset};
use paid_train::RunPreset;
use paid_train::folder::{PRESET_FILE, latest_checkpoint};
use paid_train::setup::load_robot;

use crate::failure::Failure;
use crate::train::thread_count;

/// Arguments of `paid eval`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, clap::Subcommand)]
enum Command {
    /// How closely the policy follows every motion.
    Tracking(TrackingArgs),
    /// Shots at the goal from a grid of ball places.
    Shooting(ShootingArgs),
    /// Pictures of one episode.
    Film(FilmArgs),
}

#[derive(Debug, clap::Args)]
struct Common {
    /// Run folder (its newest checkpoint) or checkpoint file.
    #[arg(long, value_name = "RUN|CHECKPOINT")]
    policy: PathBuf,
    /// Folder of the motion files [default: the one the policy was trained on].
    #[arg(long, value_name = "DIR")]
    motions: Option<PathBuf>,
    /// Built-in task or task preset file to score in [default: the one the policy was trained in].
    #[arg(long, value_name = "NAME|FILE")]
    task: Option<String>,
    /// Change a value of the task, such as scene.ground.restitution=0 (repeatable).
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,
    /// Seed of everything random.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Worker threads; the result does not depend on it [default: all cores].
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// Instruction set: auto, avx512, avx2 or portable. Two sets round differently.
    #[arg(long, default_value = "auto")]
    isa: String,
}

#[derive(Debug, clap::Args)]
struct TrackingArgs {
    #[command(flatten)]
    common: Common,
    /// Starts with reset noise a clip, besides the exact one.
    #[arg(long, default_value_t = 20)]
    starts: usize,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    /// Write tracking.json to this folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

#[derive(Debug, clap::Args)]
struct ShootingArgs {
    #[command(flatten)]
    common: Common,
    /// Trials a ball place.
    #[arg(long, default_value_t = 10)]
    trials: usize,
    /// The ball rolls at 0.1 to 0.3 m/s in any direction.
    #[arg(long)]
    rolling: bool,
    /// Ball places are given in the robot's first pose, as in the public evaluation (its displacement then has no effect),
    /// instead of in the world.
    #[arg(long)]
    robot_frame: bool,
    /// The paper's whole grid, [0.5, 3.0] x [-1.5, 1.5] m, instead of its effective workspace.
    #[arg(long)]
    whole_grid: bool,
    /// Radius of the disc of robot starts [m].
    #[arg(long, default_value_t = 0.5)]
    start_radius: f64,
    /// Time limit of a trial [s].
    #[arg(long, default_value_t = 12.0)]
    limit: f64,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    /// Write JSON, a CSV row a trial, heat maps and paths to this folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

#[derive(Debug, clap::Args)]
struct FilmArgs {
    #[command(flatten)]
    common: Common,
    /// Ball place x,y in the robot's first pose [m]; the nearest motion is chosen [default: the motion's own].
    #[arg(long, value_name = "X,Y", value_parser = pair, allow_hyphen_values = true)]
    ball: Option<[f64; 2]>,
    /// Ball velocity x,y [m/s].
    #[arg(long, value_name = "X,Y", value_parser = pair, allow_hyphen_values = true, default_value = "0,0")]
    velocity: [f64; 2],
    /// Index of the motion (see `paid motion info`) [default: the nearest to the ball, or the first].
    #[arg(long)]
    motion: Option<usize>,
    /// Folder for the pictures: strip.png, paths.png, and numbered frames.
    #[arg(long, value_name = "DIR")]
    frames: PathBuf,
    /// Pictures a second of the numbered frames; 0 writes none.
    #[arg(long, default_value_t = 10)]
    rate: u32,
    /// Time limit [s].
    #[arg(long, default_value_t = 10.0)]
    limit: f64,
}

fn pair(text: &str) -> Result<[f64; 2], String> {
    let numbers: Vec<f64> = text.split(',').filter_map(|t| t.trim().parse().ok()).collect();
    match numbers[..] {
        [x, y] if x.is_finite() && y.is_finite() && text.matches(',').count() == 1 => Ok([x, y]),
        _ => Err(format!("expected two numbers X,Y, found '{text}'")),
    }
}

/// Runs a subcommand.
pub fn run(args: Args) -> Result<ExitCode, Failure> {
    match args.command {
        Command::Tracking(args) => track(&args),
        Command::Shooting(args) => shoot(&args),
        Command::Film(args) => film(&args),
    }
    .map(|()| ExitCode::SUCCESS)
}

/// A policy and the task to score it in.
struct Subject {
    arena: Arena,
    policy: Policy,
    /// Set of each motion: the name of the folder that it lies in.
    sets: Vec<String>,
}

impl Subject {
    fn load(common: &Common) -> Result<Self, Failure> {
        let path = if common.policy.is_dir() {
            latest_checkpoint(&common.policy).map_err(Failure::input)?
        } else {
            common.policy.clone()
        };
        let checkpoint = Checkpoint::load(&path).map_err(Failure::input)?;
        let text =
            checkpoint.blob(PRESET_FILE).and_then(|b| std::str::from_utf8(b).ok()).ok_or_else(|| {
                Failure::input(format!(
                    "{}: expected an entry '{PRESET_FILE}' (text), found none",
                    path.display()
                ))
            })?;
        let run = RunPreset::from_resolved(&path.to_string_lossy(), text, &[]).map_err(Failure::input)?;
        let mut task = task_preset(common, run.task)?;
        // Scored on flat ground, as in the paper's evaluation, also where training was on rough ground.
        task.scene.terrain = Terrain::Plane;
        let (robot, spec) = load_robot(&run.robot).map_err(Failure::input)?;
        let folder = common.motions.clone().unwrap_or_else(|| PathBuf::from(&run.run.motions));
        let motions =
            MotionLibrary::open(&folder, &robot, &spec, 1.0 / task.control_dt_s()).map_err(Failure::input)?;
        let sets = motions.clips.iter().map(|clip| set_of(&clip.path)).collect();
        let library = ReferenceLibrary::from_motions(&motions, &robot, &spec).map_err(Failure::input)?;
        let policy = checkpoint.policy().map_err(Failure::input)?;
        let arena = Arena {
            isa: common.isa.parse().map_err(Failure::input)?,
            robot,
            spec,
            library: Arc::new(library),
            preset: task,
            threads: thread_count(common.threads)?,
            seed: common.seed,
        };
        Ok(Self { arena, policy, sets })
    }

    fn needs_ball(&self) -> Result<(), Failure> {
        if self.arena.preset.scene.ball {
            return Ok(());
        }
        Err(Failure::input(format!(
            "task '{}': expected one with a physical ball, found scene.ball = false; score in another with --task stage2",
            self.arena.preset.name
        )))
    }
}

fn task_preset(common: &Common, trained: TaskPreset) -> Result<TaskPreset, Failure> {
    let (name, text) = match &common.task {
        None => (trained.name.clone(), toml::to_string(&trained).map_err(Failure::input)?),
        Some(file) if file.ends_with(".toml") => {
            let text = std::fs::read_to_string(file).map_err(|e| Failure::input(format!("{file}: {e}")))?;
            (file.clone(), text)
        }
        Some(name) => {
            let preset = TaskPreset::builtin(name).map_err(Failure::input)?;
            (name.clone(), toml::to_string(&preset).map_err(Failure::input)?)
        }
    };
    TaskPreset::parse(&name, &text, &common.sets).map_err(Failure::input)
}

/// The name of the folder that a motion lies in.
fn set_of(path: &Path) -> String {
    path.parent()
        .and_then(Path::file_name)
        .map_or_else(|| "motions".to_owned(), |name| name.to_string_lossy().into_owned())
}

fn to_json(value: &impl serde::Serialize) -> Result<String, Failure> {
    serde_json::to_string_pretty(value).map_err(Failure::input)
}

fn track(args: &TrackingArgs) -> Result<(), Failure> {
    let subject = Subject::load(&args.common)?;
    let options = TrackingOptions { starts: args.starts, sets: subject.sets };
    let maker = LearnedPolicy::maker(subject.policy);
    let report: TrackingReport =
        tracking::evaluate(&subject.arena, &maker, &options).map_err(Failure::input)?;
    let json = to_json(&report)?;
    if let Some(out) = &args.out {
        write_whole(&out.join("tracking.json"), json.as_bytes()).map_err(Failure::input)?;
    }
    if args.json {
        println!("{json}");
    } else {
        print!("{}", report.table());
    }
    Ok(())
}

fn shoot(args: &ShootingArgs) -> Result<(), Failure> {
    let subject = Subject::load(&args.common)?;
    subject.needs_ball()?;
    let options = ShootingOptions {
        grid: if args.whole_grid { Grid::WHOLE } else { Grid::EFFECTIVE },
        trials: args.trials,
        variant: if args.robot_frame { Variant::Robot } else { Variant::World },
        start_radius_m: args.start_radius,
        rolling: args.rolling.then_some(shooting::ROLLING_SPEED),
        limit_s: args.limit,
        ..ShootingOptions::default()
    };
    let maker = LearnedPolicy::maker(subject.policy);
    let report = shooting::evaluate(&subject.arena, &maker, &options).map_err(Failure::input)?;
    if let Some(out) = &args.out {
        write_shooting(out, &report)?;
    }
    if args.json {
        println!("{}", to_json(&report)?);
    } else {
        print!("{}", report.table());
    }
    Ok(())
}

fn write_shooting(out: &Path, report: &ShootingReport) -> Result<(), Failure> {
    let kind = if report.options.rolling.is_some() { "rolling" } else { "static" };
    let file = |what: &str| out.join(format!("{kind}_{what}"));
    write_whole(&file("shooting.json"), to_json(report)?.as_bytes()).map_err(Failure::input)?;
    write_whole(&file("trials.csv"), report.csv().as_bytes()).map_err(Failure::input)?;
    let grid = report.options.grid;
    let map = |title: &str, low: f64, factor: f64, value: fn(&CellScore) -> Option<f64>| HeatMap {
        title: format!("{title}, {kind} ball"),
        x: grid.places(grid.x),
        y: grid.places(grid.y),
        values: report.grid_values(value),
        low,
        high: 1.0,
        print: (factor, 0),
    };
    let success = map("success [%]", 0.0, 100.0, |c| Some(c.success.share));
    success.draw().save(&file("success.png")).map_err(Failure::input)?;
    let accuracy = map("accuracy [%]", 0.0, 100.0, |c| c.accuracy);
    accuracy.draw().save(&file("accuracy.png")).map_err(Failure::input)?;
    let paths: Vec<BallPath> =
        report.trials.iter().map(|t| BallPath { points: &t.path, goal: t.goal }).collect();
    plot_paths(&paths, report.options.goal_half_width_m).save(&file("paths.png")).map_err(Failure::input)
}

fn film(args: &FilmArgs) -> Result<(), Failure> {
    let subject = Subject::load(&args.common)?;
    let arena = &subject.arena;
    let motion = match (args.motion, args.ball) {
        (Some(motion), _) => motion,
        (None, Some(ball)) => Placement::new(arena).nearest(ball),
        (None, None) => 0,
    };
    let start =
        ForcedStart { ball_xy: args.ball, ball_velocity: args.velocity, ..ForcedStart::nominal(motion) };
    let limits = ShootingOptions { limit_s: args.limit, ..ShootingOptions::default() };
    let dt = arena.preset.control_dt_s();
    let (control, steps) = shooting::control_of(&limits, dt);
    let maker = LearnedPolicy::maker(subject.policy);
    let films =
        run_episodes(arena, &maker, &[start], control, steps, |_| Film::default()).map_err(Failure::input)?;
    let Some(film) = films.first() else { return Ok(()) };
    let ball = arena.preset.scene.ball.then_some(arena.preset.ball_params.radius_m);
    let half_width = limits.goal_half_width_m;
    let save = |image: paid_eval::picture::Canvas, name: &str| {
        image.save(&args.frames.join(name)).map_err(Failure::input)
    };
    save(film_strip(&arena.robot, film, dt, ball, half_width, 12), "strip.png")?;
    let points = film.path();
    save(plot_paths(&[BallPath { points: &points, goal: false }], half_width), "paths.png")?;
    if args.rate > 0 {
        let every = (1.0 / (f64::from(args.rate) * dt)).round().max(1.0) as usize;
        for (i, pose) in film.poses.iter().step_by(every).enumerate() {
            let image = frame(&arena.robot, pose, ball, half_width, [640, 480]);
            save(image, &format!("frame_{i:04}.png"))?;
        }
    }
    let poses = film.poses.len();
    println!("{poses} control steps of motion {motion}: pictures in {}", args.frames.display());
    Ok(())
}
