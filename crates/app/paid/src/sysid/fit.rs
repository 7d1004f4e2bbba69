//! The identification itself.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::ValueEnum;
use paid_files::FileSet;
use paid_sysid::csv::{Quantity, Run, read_runs};
use paid_sysid::options::{NAMES, Parameters, Starts, Unseen};
use paid_sysid::plausible::{check_fit, check_runs};
use paid_sysid::{Identification, Options, Repeats, Surface, identify};
use serde::Serialize;

use super::identification;
use super::{World, five};
use crate::failure::Failure;

/// Arguments of the identification.
#[derive(Debug, clap::Args)]
pub struct FitArgs {
    /// Drops: CSV with the columns run, time_s, height_m (repeatable).
    #[arg(long, value_name = "CSV")]
    drop: Vec<PathBuf>,
    /// Rolls: CSV with the columns run, time_s, distance_m (repeatable).
    #[arg(long, value_name = "CSV")]
    roll: Vec<PathBuf>,
    /// Balls pushed off without spin: CSV as for rolls (repeatable).
    ///
    /// They slide before they roll.
    #[arg(long, value_name = "CSV")]
    slide: Vec<PathBuf>,
    /// Write the surface to this TOML file.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Name of the surface [default: the name of --out].
    #[arg(long)]
    name: Option<String>,
    /// Write the images loss, drop and roll to this folder, as PNG and SVG.
    #[arg(long, value_name = "DIR")]
    plots: Option<PathBuf>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    /// True values of simulated measurements, printed next to the results.
    #[arg(long, value_name = "S,D,R,L,A", value_parser = five)]
    truth: Option<Parameters>,
    #[command(flatten)]
    world: World,
    #[command(flatten)]
    search: Search,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum RepeatsArg {
    /// One set of parameters for all repeats.
    Joint,
    /// Average the repeats first.
    Mean,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum StartsArg {
    /// First height, and speed of the first samples (paper).
    FirstSamples,
    /// Corrected by the whole run.
    Refined,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum UnseenArg {
    /// Those of the task's ball, where they fit equally well.
    Kept,
    /// Those at which the search ended (paper).
    Fitted,
}

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Search (defaults as in the paper's appendix, where it gives a number)")]
struct Search {
    /// Start of the first search.
    ///
    /// Static and dynamic friction, restitution, linear and angular damping [1/s].
    #[arg(long, value_name = "S,D,R,L,A", value_parser = five, default_value = "0.5,0.5,0.5,1,1")]
    initial: Parameters,
    /// Range of a parameter, such as angular_damping=0,8 (repeatable).
    ///
    /// Default: 0,1; for the dampings 0,5.
    #[arg(long, value_name = "NAME=LO,HI", value_parser = range)]
    range: Vec<(usize, [f64; 2])>,
    /// Initial step, in units of the ranges.
    #[arg(long, hide_short_help = true, default_value_t = Options::default().scale)]
    scale: f64,
    /// Candidates per generation.
    #[arg(long, hide_short_help = true, default_value_t = Options::default().population)]
    population: usize,
    /// A search ends when the best loss changes by less than this [m^2].
    #[arg(long, hide_short_help = true, default_value_t = Options::default().tolerance)]
    tolerance: f64,
    /// Number of generations in a row with such small changes.
    #[arg(long, hide_short_help = true, default_value_t = Options::default().patience)]
    patience: usize,
    /// Most generations of a search.
    #[arg(long, hide_short_help = true, default_value_t = Options::default().generations)]
    generations: usize,
    /// Searches; all but the first start at random.
    #[arg(long, default_value_t = Options::default().restarts)]
    restarts: usize,
    /// Random points, of which the best becomes the start of a search.
    #[arg(long, hide_short_help = true, default_value_t = Options::default().screening)]
    screening: usize,
    /// Weight of squared height errors.
    #[arg(long, hide_short_help = true, default_value_t = Options::default().weight_drop)]
    lambda1: f64,
    /// Weight of squared distance errors.
    #[arg(long, hide_short_help = true, default_value_t = Options::default().weight_roll)]
    lambda2: f64,
    /// Spacing of the compared samples [s].
    #[arg(long, hide_short_help = true, default_value_t = Options::default().every_s)]
    every: f64,
    /// Compared part of a run [s].
    #[arg(long, default_value_t = Options::default().duration_s)]
    duration: f64,
    /// Time over which the rolling ball's initial speed is measured [s].
    #[arg(long, hide_short_help = true, default_value_t = Options::default().speed_window_s)]
    speed_window: f64,
    /// Spin of the rolling ball at its first sample: 1 rolls, 0 slides.
    #[arg(long, default_value_t = Options::default().spin)]
    spin: f64,
    /// How repeats are used.
    #[arg(long, value_enum, default_value = "joint")]
    repeats: RepeatsArg,
    /// Initial heights and speeds of the simulated runs.
    #[arg(long, value_enum, default_value = "first-samples")]
    starts: StartsArg,
    /// Values of parameters that the measurements do not show.
    #[arg(long, value_enum, default_value = "kept")]
    unseen: UnseenArg,
    /// Accuracy of the measured positions [m].
    #[arg(long, hide_short_help = true, default_value_t = Options::default().resolution_m)]
    resolution: f64,
    /// Seed of the searches.
    #[arg(long, default_value_t = 0)]
    seed: u64,
}

fn range(text: &str) -> Result<(usize, [f64; 2]), String> {
    let wrong = || format!("expected NAME=LO,HI with a name of {}, found '{text}'", NAMES.join(", "));
    let (name, ends) = text.split_once('=').ok_or_else(wrong)?;
    let index = NAMES.iter().position(|n| *n == name).ok_or_else(wrong)?;
    let (lo, hi) = ends.split_once(',').ok_or_else(wrong)?;
    match (lo.trim().parse::<f64>(), hi.trim().parse::<f64>()) {
        (Ok(lo), Ok(hi)) => Ok((index, [lo, hi])),
        _ => Err(wrong()),
    }
}

impl Search {
    fn options(&self) -> Options {
        let mut options = Options {
            initial: self.initial,
            scale: self.scale,
            population: self.population,
            tolerance: self.tolerance,
            patience: self.patience,
            generations: self.generations,
            restarts: self.restarts,
            screening: self.screening,
            weight_drop: self.lambda1,
            weight_roll: self.lambda2,
            every_s: self.every,
            duration_s: self.duration,
            speed_window_s: self.speed_window,
            spin: self.spin,
            repeats: match self.repeats {
                RepeatsArg::Joint => Repeats::Joint,
                RepeatsArg::Mean => Repeats::Mean,
            },
            starts: match self.starts {
                StartsArg::FirstSamples => Starts::FirstSamples,
                StartsArg::Refined => Starts::Refined,
            },
            unseen: match self.unseen {
                UnseenArg::Kept => Unseen::Kept,
                UnseenArg::Fitted => Unseen::Fitted,
            },
            resolution_m: self.resolution,
            seed: self.seed,
            ..Options::default()
        };
        for (index, range) in &self.range {
            options.range[*index] = *range;
        }
        options
    }
}

#[derive(Serialize)]
struct Report<'a> {
    surface: &'a Surface,
    #[serde(flatten)]
    found: &'a Identification,
    #[serde(skip_serializing_if = "Option::is_none")]
    truth: Option<&'a Parameters>,
    remarks: Vec<String>,
    options: &'a Options,
    seconds: f64,
    files: Vec<String>,
}

fn read_all(
    files: &[PathBuf],
    quantity: Quantity,
    gravity: f64,
    options: &Options,
) -> Result<Vec<Run>, Failure> {
    let mut all = Vec::new();
    for file in files {
        let runs = read_runs(file, quantity).map_err(Failure::input)?;
        check_runs(file, &runs, quantity, gravity, options).map_err(Failure::input)?;
        all.extend(runs);
    }
    Ok(all)
}

fn surface_name(args: &FitArgs) -> String {
    let stem = args.out.as_deref().and_then(Path::file_stem).map(|s| s.to_string_lossy().into_owned());
    args.name.clone().or(stem).unwrap_or_else(|| "surface".to_owned())
}

/// Identifies, writes, prints.
pub fn run(args: &FitArgs) -> Result<(), Failure> {
    if args.drop.is_empty() && args.roll.is_empty() && args.slide.is_empty() {
        return Err(Failure::input(
            "measurements: expected --drop FILE and --roll FILE, found neither; `paid sysid simulate` makes such files",
        ));
    }
    let (scene, ball) = args.world.load()?;
    let isa = args.world.isa.parse().map_err(Failure::input)?;
    let options = args.search.options();
    options.validate().map_err(Failure::input)?;
    let read = |files: &[PathBuf], quantity| read_all(files, quantity, scene.gravity.abs(), &options);
    let drops = read(&args.drop, Quantity::Height)?;
    let mut rolls = read(&args.roll, Quantity::Distance)?;
    let slides = read(&args.slide, Quantity::Distance)?;
    rolls.extend(slides.into_iter().map(|run| Run {
        name: format!("slide {}", run.name),
        spin: Some(0.0),
        ..run
    }));
    let begin = Instant::now();
    let found = identify(&drops, &rolls, &ball, &scene, isa, &options).map_err(Failure::input)?;
    let seconds = begin.elapsed().as_secs_f64();
    check_fit(&found, &drops).map_err(Failure::input)?;
    let surface = Surface::of(&surface_name(args), &found);
    let written = write(args, &found, &surface)?;
    if args.json {
        let files = written.iter().map(|p| p.display().to_string()).collect();
        let remarks = found.remarks();
        let (surface, found, truth) = (&surface, &found, args.truth.as_ref());
        let report = Report { surface, found, truth, remarks, options: &options, seconds, files };
        println!("{}", serde_json::to_string_pretty(&report).map_err(Failure::input)?);
        return Ok(());
    }
    print!("{}", found.table(args.truth.as_ref()));
    println!("\n{:.1} s, {:.0} rollouts a second", seconds, found.rollouts as f64 / seconds.max(1e-9));
    for file in &written {
        println!("wrote {}", file.display());
    }
    Ok(())
}

fn write(args: &FitArgs, found: &Identification, surface: &Surface) -> Result<Vec<PathBuf>, Failure> {
    let mut files = FileSet::default();
    if let Some(folder) = &args.plots {
        let mut add = |name: &str, figure: paid_plot::Figure| {
            let file = |ending: &str| folder.join(format!("{name}.{ending}"));
            files.add(file("png"), figure.canvas().png().map_err(Failure::input)?);
            files.add(file("svg"), figure.svg().into_bytes());
            Ok::<(), Failure>(())
        };
        add("loss", identification::loss(found))?;
        if !found.drops.is_empty() {
            add(
                "drop",
                identification::overlay("drop: dots measured, lines simulated", "height [m]", &found.drops),
            )?;
        }
        if !found.rolls.is_empty() {
            add(
                "roll",
                identification::overlay("roll: dots measured, lines simulated", "distance [m]", &found.rolls),
            )?;
        }
    }
    if let Some(out) = &args.out {
        let list = |files: &[PathBuf]| {
            files.iter().map(|p| p.display().to_string()).collect::<Vec<_>>().join(", ").replace('\n', " ")
        };
        let sources = [args.drop.as_slice(), &args.roll, &args.slide].concat();
        let comments = [
            format!("Identified by `paid sysid` from {}.", list(&sources)),
            "[ball_params] replaces the table of that name in a task preset.".to_owned(),
        ];
        let text = surface.to_toml(&comments).map_err(Failure::input)?;
        files.add(out.clone(), text.into_bytes());
    }
    Ok(files.write()?)
}
