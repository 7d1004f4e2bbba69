//! `paid motion clean`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use paid_motion::check::ClipReport;
use paid_motion::clean::{CleanError, CleanOptions, CleanReport, Cleaned, Peak, clean};
use paid_motion::{Clip, MotionLibrary, motion_files, write_motion};
use paid_robot::{RobotModel, RobotSpec};

use super::check::line;
use super::robot_file::{RobotFile, expect_folder};
use crate::failure::Failure;

/// Arguments of `paid motion clean`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Motion file of the robot (.npz, .csv, .pkl), or a folder of such files.
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
    #[arg(long, help_heading = "Cleaning", value_name = "HZ", default_value_t = 50.0)]
    clean_rate: f64,
    /// Duration relative to the input [default: 1 to 1.1].
    ///
    /// The default is the least that keeps the joints within their speed limits, at most 1.1.
    #[arg(long, help_heading = "Cleaning", value_name = "FACTOR")]
    stretch: Option<f64>,
    /// Largest share of the joints' torque limits that the cleaned motion may need.
    #[arg(long, help_heading = "Cleaning", value_name = "SHARE", default_value_t = 1.0)]
    torque: f64,
    /// Time to keep before the kick, if the player stands by then [s].
    ///
    /// More seconds of waiting teach a policy nothing.
    #[arg(long, help_heading = "Cleaning", value_name = "S", default_value_t = 4.5)]
    lead: f64,
    /// Turn the first stand toward the shot, within this angle [degrees] [default: 29].
    #[arg(long, help_heading = "Cleaning", value_name = "DEG")]
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

/// Cleans a clip that was read from `file`, and warns of motors that cannot do what comes out.
pub fn clean_clip(
    file: &Path,
    clip: &Clip,
    how: CleanHow,
    robot: (&RobotModel, &RobotSpec),
) -> Result<Cleaned, CleanError> {
    let named = |error: CleanError| error.named(file.display().to_string());
    let mut cleaned = clean(clip, robot.0, robot.1, &how.options()).map_err(named)?;
    cleaned.report.warnings.extend(overload(&cleaned.report.torque[1], cleaned.clip.fps));
    Ok(cleaned)
}

/// What to say of a cleaned motion that needs more torque than a motor has.
fn overload(peak: &Peak, fps: f64) -> Option<String> {
    let percent = (100.0 * peak.value).round();
    (percent > 100.0).then(|| {
        format!(
            "{} needs {percent} % of its motor's torque at {:.2} s (frame {}); a larger --stretch or a smaller --torque needs less",
            peak.joint,
            peak.frame as f64 / fps,
            peak.frame
        )
    })
}

/// A file to clean, and where the result goes.
struct Job {
    file: PathBuf,
    out: PathBuf,
}

/// Cleans, writes and reports. A clip that still fails the check makes the exit code 2, as does one that cannot be cleaned: the
/// others are cleaned all the same.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    let jobs = jobs(args)?;
    expect_folder(&args.out)?;
    let (mut reports, mut errors) = (Vec::new(), Vec::new());
    for job in &jobs {
        match one(args, job, &model, &spec)? {
            Ok(cleaned) => {
                if !args.json {
                    print(&job.out, &cleaned.report, cleaned.clip.fps);
                }
                reports.push(cleaned.report);
            }
            Err(error) if jobs.len() == 1 => return Err(error),
            Err(error) => errors.push(error.to_string()),
        }
    }
    if args.json {
        println!("{}", serde_json::to_string_pretty(&reports).map_err(Failure::input)?);
    }
    if errors.is_empty() {
        return Ok(exit_code(&reports));
    }
    let (bad, all) = (errors.len(), jobs.len());
    Err(Failure::input(format!("{bad} of {all} files were not cleaned:\n  {}", errors.join("\n  "))))
}

/// 2 if a cleaned clip fails the check.
pub fn exit_code<'a>(reports: impl IntoIterator<Item = &'a CleanReport>) -> ExitCode {
    super::check::exit_code(reports.into_iter().map(|r| &r.after))
}

/// The files, none of which may take the place of another one's result.
fn jobs(args: &Args) -> Result<Vec<Job>, Failure> {
    let files = if args.input.is_dir() {
        motion_files(&args.input).map_err(Failure::input)?
    } else {
        vec![args.input.clone()]
    };
    let mut jobs: Vec<Job> = Vec::new();
    for file in files {
        let stem = file.file_stem().unwrap_or_default().to_string_lossy();
        let out = args.out.join(format!("{stem}.npz"));
        if let Some(other) = jobs.iter().find(|job| job.out == out) {
            return Err(Failure::input(format!(
                "{}: expected one file that is cleaned to it, found {} and {}; rename one of them, or clean them into two folders",
                out.display(),
                other.file.display(),
                file.display()
            )));
        }
        jobs.push(Job { file, out });
    }
    Ok(jobs)
}

/// Reads, cleans and writes one file. The outer error is of the options, which are those of all files.
fn one(
    args: &Args,
    job: &Job,
    model: &RobotModel,
    spec: &RobotSpec,
) -> Result<Result<Cleaned, Failure>, Failure> {
    let clip = match MotionLibrary::read(&job.file, model, spec, &args.file.options(args.fps)) {
        Ok(clip) => args.file.licensed(clip),
        Err(error) => return Ok(Err(Failure::input(error))),
    };
    let cleaned = match clean_clip(&job.file, &clip, args.how, (model, spec)) {
        Ok(cleaned) => cleaned,
        Err(error @ CleanError::Option { .. }) => return Err(error.into()),
        Err(error) => return Ok(Err(error.into())),
    };
    Ok(write_motion(&job.out, &cleaned.clip, model, spec).map(|()| cleaned).map_err(Failure::input))
}

/// Prints what was done to a clip and the main measures before and after; JSON has all of them.
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
    for finding in &r.after.findings {
        println!("  {}", line(finding));
    }
    for warning in &r.warnings {
        println!("  warning: {warning}");
    }
}

/// The main measures with their units, before and after.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn torque_that_no_motor_has_is_warned_of_with_joint_and_time() {
        let peak = |value| Peak { value, frame: 75, joint: "left_knee_joint".to_owned() };
        assert_eq!(overload(&peak(1.0), 50.0), None);
        let told = overload(&peak(1.43), 50.0).expect("more than the motor has");
        assert!(
            told.starts_with("left_knee_joint needs 143 % of its motor's torque at 1.50 s (frame 75)"),
            "{told}"
        );
    }
}
