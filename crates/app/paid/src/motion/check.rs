//! `paid motion check`.

use std::path::PathBuf;
use std::process::ExitCode;

use paid_motion::check::{CheckLimits, ClipReport, Finding, Verdict, check_clip, ends_away, mixed_rates};
use paid_motion::{Clip, JointOrder, MotionLibrary, QuatOrder, ReadOptions};
use paid_robot::{RobotModel, RobotSpec};

use crate::failure::Failure;

/// Arguments of `paid motion check`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder of motion files, or one file [default: the built-in kicks].
    ///
    /// Files end in .npz, .csv or .pkl.
    path: Option<PathBuf>,
    /// Frame rate of a file that does not state it [Hz].
    #[arg(long, value_name = "HZ", requires = "path")]
    fps: Option<f64>,
    /// Joint order of a CSV file that does not state it: model or policy.
    ///
    /// model is depth-first, policy is breadth-first.
    #[arg(long, value_name = "ORDER", requires = "path")]
    joint_order: Option<JointOrder>,
    /// Order of the base's quaternion in a CSV or pickle file: xyzw or wxyz [default: xyzw].
    #[arg(long, value_name = "ORDER", requires = "path")]
    quat: Option<QuatOrder>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Prints one verdict per clip; a clip that fails makes the exit code 2.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    let limits = CheckLimits::default();
    let reports = clips(args, &model, &spec)?
        .iter()
        .map(|clip| check_clip(clip, &model, &spec, &limits))
        .collect::<Result<Vec<_>, _>>()
        .map_err(Failure::input)?;
    if args.json {
        println!("{}", serde_json::to_string_pretty(&reports).map_err(Failure::input)?);
    } else {
        print(&reports);
    }
    Ok(exit_code(&reports))
}

/// 2 if a clip fails.
pub fn exit_code<'a>(reports: impl IntoIterator<Item = &'a ClipReport>) -> ExitCode {
    let fails = reports.into_iter().any(|r| r.verdict == Verdict::Fail);
    ExitCode::from(if fails { 2 } else { 0 })
}

/// At the files' own rates: resampling would smooth over what is to be found.
fn clips(args: &Args, model: &RobotModel, spec: &RobotSpec) -> Result<Vec<Clip>, Failure> {
    let options =
        ReadOptions { fps: args.fps, kick_leg: None, joint_order: args.joint_order, quat: args.quat };
    match &args.path {
        Some(file) if !file.is_dir() => {
            MotionLibrary::read(file, model, spec, &options).map(|clip| vec![clip])
        }
        Some(folder) => MotionLibrary::load_with(folder, model, spec, &options).map(|l| l.clips),
        None => MotionLibrary::builtin(model, spec, paid_motion::generate::FPS).map(|l| l.clips),
    }
    .map_err(Failure::input)
}

/// A finding with its verdict and its frame.
pub fn line(finding: &Finding) -> String {
    let place = finding.frame.map_or_else(String::new, |frame| format!(" (frame {frame})"));
    format!("{}: {}{place}", finding.verdict, finding.reason)
}

fn print(reports: &[ClipReport]) {
    let width = reports.iter().map(|r| r.name.len()).max().unwrap_or(4).max(4);
    println!(
        "{:<width$}  verdict  leg    time s  foot m/s  joint speed %  range rad  lowest mm  floats mm  slides mm  \
         overlap mm  legs apart mm  pressure inside %  margin mm",
        "clip"
    );
    for report in reports {
        let m = &report.measures;
        println!(
            "{:<width$}  {:<7}  {:<5}  {:>6.2}  {:>8.2}  {:>13.0}  {:>9.3}  {:>9.1}  {:>9.1}  {:>9.1}  {:>10.1}  \
             {:>13.1}  {:>17.0}  {:>9.1}",
            report.name,
            report.verdict,
            report.kick_leg.to_string(),
            m.duration_s,
            m.foot_speed.value,
            100.0 * m.joint_speed.value,
            m.joint_range.value,
            -1e3 * m.penetration_m.value,
            1e3 * m.floating_m.value,
            1e3 * m.sliding_m.value,
            1e3 * m.overlap_m.value,
            -1e3 * m.legs_m.value,
            100.0 * m.pressure_inside,
            1e3 * m.pressure_margin_m,
        );
        for finding in &report.findings {
            println!("{:<width$}    {}", "", line(finding));
        }
    }
    for note in [mixed_rates(reports), ends_away(reports)].into_iter().flatten() {
        println!("note: {note}");
    }
    let count = |verdict| reports.iter().filter(|r| r.verdict == verdict).count();
    println!(
        "{} clips: {} pass, {} warn, {} fail",
        reports.len(),
        count(Verdict::Pass),
        count(Verdict::Warn),
        count(Verdict::Fail)
    );
}
