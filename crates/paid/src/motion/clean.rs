//! `paid motion clean`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use paid_motion::check::{ClipReport, Verdict};
use paid_motion::clean::{CleanOptions, CleanReport, clean};
use paid_motion::{Clip, MotionLibrary, read_motion, write_motion};
use paid_robot::{RobotModel, RobotSpec};

use super::robot_file::RobotFile;
use crate::failure::Failure;

/// Arguments of `paid motion clean`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Motion file of the robot (.npz, .csv, .pkl), or a folder with such files.
    input: PathBuf,
    /// Folder for the cleaned clips, as NAME.npz.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Frame rate of a file that does not state it [Hz].
    #[arg(long, value_name = "HZ")]
    fps: Option<f64>,
    #[command(flatten)]
    file: RobotFile,
    #[command(flatten)]
    how: CleanHow,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// How a motion is cleaned.
#[derive(Clone, Copy, Debug, clap::Args)]
pub struct CleanHow {
    /// Frame rate of the cleaned clip [Hz].
    #[arg(long, value_name = "HZ", default_value_t = 50.0)]
    clean_rate: f64,
    /// Everything takes FACTOR times as long when cleaned [default: as little longer as the joints' speed limits ask for, at most 1.1].
    #[arg(long, value_name = "FACTOR")]
    stretch: Option<f64>,
    /// Share of the joints' torque limits that the cleaned motion should need.
    #[arg(long, value_name = "SHARE", default_value_t = 1.0)]
    torque: f64,
    /// Keep so much before the kick, where the player stands by then: seconds of waiting teach a policy nothing [s].
    #[arg(long, value_name = "S", default_value_t = 4.5)]
    lead: f64,
    /// Turn the first stand until it faces where the foot kicks, within this angle [degrees] [default: 29].
    #[arg(long, value_name = "DEG")]
    facing: Option<f64>,
}

impl CleanHow {
    /// For the library.
    pub fn options(self) -> CleanOptions {
        let usual = CleanOptions::default();
        CleanOptions {
            fps: self.clean_rate,
            slow: self.stretch,
            torque_share: self.torque,
            lead_s: self.lead,
            facing: self.facing.map_or(usual.facing, f64::to_radians),
        }
    }
}

/// Cleans, writes and reports. A clip that still fails the check makes the exit code 2.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    let clips = clips(args, &model, &spec)?;
    std::fs::create_dir_all(&args.out).map_err(|e| Failure::input(format!("{}: {e}", args.out.display())))?;
    let mut reports = Vec::new();
    for clip in clips {
        let clip = args.file.licensed(clip);
        let cleaned = clean(&clip, &model, &spec, &args.how.options())?;
        let path = args.out.join(format!("{}.npz", clip.name));
        write_motion(&path, &cleaned.clip, &model, &spec).map_err(Failure::input)?;
        if !args.json {
            print(&path, &cleaned.report, cleaned.clip.fps);
        }
        reports.push(cleaned.report);
    }
    if args.json {
        println!("{}", serde_json::to_string_pretty(&reports).map_err(Failure::input)?);
    }
    let fails = reports.iter().any(|r| r.after.verdict == Verdict::Fail);
    Ok(ExitCode::from(if fails { 2 } else { 0 }))
}

fn clips(args: &Args, model: &RobotModel, spec: &RobotSpec) -> Result<Vec<Clip>, Failure> {
    if args.input.is_dir() {
        return MotionLibrary::load_unchanged(&args.input, model, spec)
            .map(|l| l.clips)
            .map_err(Failure::input);
    }
    read_motion(&args.input, model, spec, &args.file.options(args.fps))
        .map(|clip| vec![clip])
        .map_err(Failure::input)
}

/// Prints what was done to a clip and every measure before and after.
pub fn print(path: &Path, r: &CleanReport, fps: f64) {
    println!(
        "{}: {} before, {} after ({:.1} s of work)",
        path.display(),
        r.before.verdict,
        r.after.verdict,
        r.seconds
    );
    println!(
        "  cut {:.2} s at the start and {:.2} s at the end, added {:.2} s and {:.2} s (stand, steps); {:.2} times as slow; moved down {:.0} mm",
        r.cut[0] as f64 / fps,
        r.cut[1] as f64 / fps,
        r.added[0] as f64 / fps,
        r.added[1] as f64 / fps,
        r.slow,
        1e3 * r.floor_m
    );
    println!(
        "  from the original, mean and largest: feet {:.0} and {:.0} mm, hands {:.0} and {:.0} mm, base {:.0} and {:.0} mm; in the air in {} frames",
        1e3 * r.feet_m[0],
        1e3 * r.feet_m[1],
        1e3 * r.hands_m[0],
        1e3 * r.hands_m[1],
        1e3 * r.base_m[0],
        1e3 * r.base_m[1],
        r.flight
    );
    println!(
        "  torque: at most {:.0} % of {}'s limit before, {:.0} % of {}'s after",
        100.0 * r.torque[0].value,
        r.torque[0].joint,
        100.0 * r.torque[1].value,
        r.torque[1].joint
    );
    println!("  {:<28}  before   after", "measure");
    for (name, before, after) in rows(&r.before, &r.after) {
        println!("  {name:<28}  {before:>6.2}  {after:>6.2}");
    }
    for reason in &r.reasons {
        println!("  {}: {reason}", r.after.verdict);
    }
    for warning in &r.warnings {
        println!("  warning: {warning}");
    }
}

/// Every measure with its unit, before and after.
fn rows(before: &ClipReport, after: &ClipReport) -> Vec<(&'static str, f64, f64)> {
    let values = |r: &ClipReport| {
        let m = &r.measures;
        vec![
            ("length s", m.duration_s),
            ("kicking foot m/s", m.foot_speed.value),
            ("kick off the heading deg", m.shot_angle.to_degrees()),
            ("end off the heading deg", m.turn.to_degrees()),
            ("joint beyond range rad", m.joint_range.value.max(0.0)),
            ("joint speed % of limit", 100.0 * m.joint_speed.value),
            ("joint jump % of limit", 100.0 * m.joint_jump.value),
            ("below the floor mm", 1e3 * m.penetration_m.value.max(0.0)),
            ("above the floor mm", 1e3 * m.floating_m.value.max(0.0)),
            ("foot slides mm", 1e3 * m.sliding_m.value),
            ("parts in each other mm", 1e3 * m.overlap_m.value),
            ("pressure outside % of frames", 100.0 * m.unbalanced),
            ("slippery % of frames", 100.0 * m.slippery),
            ("base speed at the end m/s", m.end_base_speed),
            ("joint speed at the end rad/s", m.end_joint_speed.value),
            ("tilt at the end deg", m.end_tilt.to_degrees()),
            ("feet on the floor at the end", m.end_feet as f64),
        ]
    };
    values(before).into_iter().zip(values(after)).map(|((name, b), (_, a))| (name, b, a)).collect()
}
