//! `paid motion retarget`.

use std::path::PathBuf;
use std::process::ExitCode;
use std::str::FromStr;

use paid_motion::check::{CheckLimits, check_clip};
use paid_motion::clean::CleanReport;
use paid_motion::{KickLeg, write_motion};
use paid_retarget::{
    EndDistance, HumanOptions, Report, RetargetOptions, Retargeted, TimeScale, read_human, retarget,
};
use paid_robot::{RobotModel, RobotSpec};

use crate::failure::Failure;

/// Arguments of `paid motion retarget`.
#[derive(Debug, clap::Args)]
#[command(mut_args(with_clean))]
pub struct Args {
    /// Human motion: .bvh, .amc with its .asf, or .npz with its .toml.
    ///
    /// The .npz file holds point positions, and the .toml file describes them.
    input: PathBuf,
    /// The robot.
    #[arg(long, value_enum, default_value_t = Robot::G1)]
    robot: Robot,
    /// Clip to write; its extension sets the format (.npz, .csv).
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    #[command(flatten)]
    how: How,
    /// Clean the clip as `paid motion clean` does.
    #[arg(long, help_heading = "Cleaning")]
    clean: bool,
    #[command(flatten)]
    clean_how: super::clean::CleanHow,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Makes the options of [`super::clean::CleanHow`] require `--clean`: they would do nothing without it.
fn with_clean(option: clap::Arg) -> clap::Arg {
    let cleans = ["clean_rate", "stretch", "torque", "lead", "facing"].contains(&option.get_id().as_str());
    if cleans { option.requires("clean") } else { option }
}

/// What `paid play` of a human motion shares.
#[derive(Debug, clap::Args)]
pub struct How {
    /// Skeleton of an AMC file (.asf) or of points (.toml) [default: next to it].
    ///
    /// That is the file of the same name, or the only one there.
    #[arg(long, hide_short_help = true, help_heading = "Human motion", value_name = "FILE")]
    skeleton: Option<PathBuf>,
    /// Length unit of the file [m].
    ///
    /// Default: 0.01 for BVH; what its ASF says for AMC; for points what the TOML says, or else it is detected.
    #[arg(long, hide_short_help = true, help_heading = "Human motion", value_name = "M")]
    unit: Option<f64>,
    /// Frame rate of a file that does not state it [Hz]: AMC [default: 120], CSV.
    ///
    /// For a BVH file it takes the place of the file's own.
    #[arg(long, hide_short_help = true, help_heading = "Human motion", value_name = "HZ")]
    fps: Option<f64>,
    /// Height of the human [m].
    #[arg(long, help_heading = "Human motion", value_name = "M", default_value_t = 1.75)]
    height: f64,
    /// Start at this time of the file [s].
    #[arg(long, help_heading = "Human motion", value_name = "S", default_value_t = 0.0)]
    from: f64,
    /// End at this time of the file [s] [default: its end].
    #[arg(long, help_heading = "Human motion", value_name = "S")]
    to: Option<f64>,
    /// Duration relative to the human's, or auto.
    ///
    /// auto is the least that keeps the joints within their speed limits.
    #[arg(long, help_heading = "Human motion", value_name = "FACTOR", default_value = "1")]
    slow: Slow,
    /// Share of the joints' speed limits that may be used, or off.
    #[arg(
        long,
        hide_short_help = true,
        help_heading = "Human motion",
        value_name = "SHARE",
        default_value = "1"
    )]
    speed_limit: SpeedLimit,
    /// Frame rate of the clip [Hz].
    #[arg(
        long,
        hide_short_help = true,
        help_heading = "Human motion",
        value_name = "HZ",
        default_value_t = 50.0
    )]
    rate: f64,
    /// Kicking leg: auto (the faster foot), left or right.
    #[arg(
        long,
        hide_short_help = true,
        help_heading = "Human motion",
        value_name = "LEG",
        default_value = "auto"
    )]
    label: Label,
    /// Terms of use to state in the clip: those of the human motion.
    #[arg(long, hide_short_help = true, help_heading = "Human motion")]
    license: Option<String>,
}

impl How {
    /// The frame rate that was given [Hz].
    pub fn fps(&self) -> Option<f64> {
        self.fps
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Robot {
    /// Unitree G1, 29 joints.
    G1,
}

#[derive(Clone, Copy, Debug)]
struct Slow(TimeScale);

impl FromStr for Slow {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "auto" => Ok(Self(TimeScale::Auto)),
            _ => number(text).map(|x| Self(TimeScale::Fixed(x))),
        }
    }
}

#[derive(Clone, Copy, Debug)]
struct SpeedLimit(Option<f64>);

impl FromStr for SpeedLimit {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        if text == "off" { Ok(Self(None)) } else { number(text).map(|x| Self(Some(x))) }
    }
}

#[derive(Clone, Copy, Debug)]
struct Label(Option<KickLeg>);

impl FromStr for Label {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "auto" => Ok(Self(None)),
            _ => text
                .parse()
                .map(|leg| Self(Some(leg)))
                .map_err(|found: String| format!("expected auto, left or right, found {found}")),
        }
    }
}

fn number(text: &str) -> Result<f64, String> {
    text.parse().map_err(|_| format!("expected a number or a word of the help, found '{text}'"))
}

/// Reads a human motion and retargets it.
pub fn retarget_file(
    input: &std::path::Path,
    how: &How,
    model: &RobotModel,
    spec: &RobotSpec,
) -> Result<Retargeted, Failure> {
    let human = HumanOptions { unit_m: how.unit, fps: how.fps, skeleton: how.skeleton.clone() };
    let motion = read_human(input, &human)?;
    for note in &motion.notes {
        eprintln!("note: {}: {note}", input.display());
    }
    let options = RetargetOptions {
        fps: how.rate,
        height_m: how.height,
        span_s: [how.from, how.to.unwrap_or(f64::INFINITY)],
        time_scale: how.slow.0,
        speed_share: how.speed_limit.0,
        kick_leg: how.label.0,
        license: how.license.clone(),
        ..RetargetOptions::default()
    };
    Ok(retarget(&motion, model, spec, &options)?)
}

/// What `--clean --json` prints.
#[derive(serde::Serialize)]
struct WithHuman<'a> {
    #[serde(flatten)]
    clean: &'a CleanReport,
    from_human: EndDistance,
}

/// Retargets, writes the clip and prints what it is like; a clip that fails the check makes the exit code 2.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let Robot::G1 = args.robot;
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    let Retargeted { mut clip, report, ends, .. } = retarget_file(&args.input, &args.how, &model, &spec)?;
    clip.name = args.out.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or(clip.name);
    if args.clean {
        let cleaned = super::clean::clean_clip(&args.input, &clip, args.clean_how, (&model, &spec))?;
        write_motion(&args.out, &cleaned.clip, &model, &spec).map_err(Failure::input)?;
        let human = ends.distance(clip.fps, &cleaned.clip, &cleaned.report);
        if args.json {
            let both = WithHuman { clean: &cleaned.report, from_human: human };
            println!("{}", serde_json::to_string_pretty(&both).map_err(Failure::input)?);
        } else {
            print(args, &report, clip.kick_leg, clip.fps);
            super::clean::print(&args.out, &cleaned.report, cleaned.clip.fps);
            println!(
                "  from the scaled human, mean and largest: feet {:.0} and {:.0} mm, hands {:.0} and {:.0} mm",
                1e3 * human.feet_m[0],
                1e3 * human.feet_m[1],
                1e3 * human.hands_m[0],
                1e3 * human.hands_m[1]
            );
        }
        return Ok(super::clean::exit_code([&cleaned.report]));
    }
    write_motion(&args.out, &clip, &model, &spec).map_err(Failure::input)?;
    let check = check_clip(&clip, &model, &spec, &CheckLimits::default()).map_err(Failure::input)?;
    if args.json {
        println!("{}", serde_json::to_string_pretty(&report).map_err(Failure::input)?);
    } else {
        print(args, &report, clip.kick_leg, clip.fps);
        println!("check: {}", check.verdict);
        for finding in &check.findings {
            println!("  {}", super::check::line(finding));
        }
    }
    Ok(super::check::exit_code([&check]))
}

fn print(args: &Args, r: &Report, leg: KickLeg, fps: f64) {
    println!(
        "{}: {} frames at {fps} Hz from {} bones, {} foot, kick at {:.2} s with {:.1} m/s",
        args.out.display(),
        r.frames,
        r.naming,
        leg,
        r.kick_frame as f64 / fps,
        r.kick_speed
    );
    println!(
        "  from the scaled human {:.1} mm, {:.3} rad on average; {:.2}% of joint samples at a range's end, {:.2}% at a speed limit",
        1e3 * r.position_error_m,
        r.rotation_error,
        100.0 * r.at_range,
        100.0 * r.at_speed
    );
    println!(
        "  fastest joint at {:.0}% of its limit, {:.2} times as slow as the file; moved up {:.1} mm onto the ground: lowest point \
         {:.1} mm, a foot slides {:.1} mm",
        100.0 * r.joint_speed,
        r.time_scale,
        1e3 * r.ground_shift_m,
        -1e3 * r.penetration_m,
        1e3 * r.sliding_m
    );
    println!(
        "  {:.1} + {:.1} solves a frame, {:.0} frames/s",
        r.steps[0],
        r.steps[1],
        r.frames as f64 / r.solve_s.max(1e-9)
    );
}
