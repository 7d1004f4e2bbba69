//! The robot's own eyes: options of `paid eval shooting --eyes`.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::ValueEnum;
use paid_eval::eyes::{self, DetectorChoice, EyesOptions, OdometryChoice};
use paid_eval::html::write_report;
use paid_eval::results::{Evaluation, to_json, write_eyes};
use paid_eval::shooting::ShootingOptions;
use paid_eval::subject::Subject;
use paid_lidar::sim::SceneKind;

use super::progress::Progress;
use super::{Output, ended};
use crate::failure::Failure;
use crate::{perceive, ranks};

/// Where the torso's pose comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum OdometryName {
    /// LiDAR-inertial odometry on a simulated Mid-360.
    Lidar,
    /// The true pose with the drift and the jitter of training.
    Modeled,
}

impl From<OdometryName> for OdometryChoice {
    fn from(name: OdometryName) -> Self {
        match name {
            OdometryName::Lidar => Self::Lidar,
            OdometryName::Modeled => Self::Modeled,
        }
    }
}

/// Options of the eyes.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "The robot's own eyes")]
pub struct EyesArgs {
    /// Render what the camera sees, scan, detect, localize and track: nothing of the simulator's ball reaches policy or choice of the
    /// motion. With --engine mujoco.
    #[arg(long, conflicts_with = "knowledge")]
    eyes: bool,
    /// Who finds the ball: own (the project's network), exact-box (the box of the pixels that show it), or an ONNX file.
    #[arg(long, value_name = "own|exact-box|ONNX", default_value = "own", requires = "eyes")]
    detector: String,
    /// Number of the ball's class in the ONNX file [default: the class that the file names so].
    #[arg(long, value_name = "K", requires = "eyes")]
    class: Option<usize>,
    /// Least score of a find, 0 to 1 [default: the detector's own].
    #[arg(long, value_name = "SCORE", value_parser = share, requires = "eyes")]
    confidence: Option<f64>,
    /// Where the torso's pose comes from.
    #[arg(long, value_enum, default_value = "lidar", requires = "eyes")]
    odometry: OdometryName,
    /// What the LiDAR sees: hall, pitch, corridor, people or endless.
    #[arg(long, value_name = "NAME", default_value = "hall", requires = "eyes")]
    surroundings: SceneKind,
    /// Points that the LiDAR measures per second.
    #[arg(long, default_value_t = 200_000, value_parser = clap::value_parser!(u32).range(1_000..=1_000_000), requires = "eyes")]
    points: u32,
    /// Draw the course of this trial, counted from 0, into the folder of --out: truth, seen, believed.
    #[arg(long, value_name = "TRIAL", requires = "eyes", requires = "out")]
    plot: Option<usize>,
    /// Record what reaches the eyes in the first trial, or in that of --plot, as MCAP (about 20 MB a second).
    #[arg(long, value_name = "FILE", requires = "eyes")]
    record: Option<PathBuf>,
}

fn share(text: &str) -> Result<f64, String> {
    let found = text.parse().ok().filter(|x| (0.0..=1.0).contains(x));
    found.ok_or_else(|| format!("expected a number from 0 to 1, found '{text}'"))
}

impl EyesArgs {
    /// Scores so if it was asked for.
    ///
    /// # Errors
    /// If the detector's file does not exist, or the evaluation fails.
    pub fn run(
        &self,
        subject: &mut Subject,
        kinds: &[ShootingOptions],
        output: &Output,
    ) -> Result<Option<ExitCode>, Failure> {
        let Some(options) = self.options()? else { return Ok(None) };
        ranks::alone("eval shooting --eyes")?;
        look(subject, kinds, &options, output).map(Some)
    }

    fn options(&self) -> Result<Option<EyesOptions>, Failure> {
        if !self.eyes {
            return Ok(None);
        }
        let detector = match self.detector.as_str() {
            "own" => DetectorChoice::Own,
            "exact-box" => DetectorChoice::ExactBox,
            file => {
                let path = PathBuf::from(file);
                if !path.is_file() {
                    let found =
                        format!("--detector: expected own, exact-box or an ONNX file, found '{file}'");
                    return Err(Failure::input(found));
                }
                // What it is taken for is said before the work.
                perceive::load(&path, self.class)?;
                DetectorChoice::File(path)
            }
        };
        if self.class.is_some() && !matches!(detector, DetectorChoice::File(_)) {
            let found = format!("--class: expected --detector with an ONNX file, found {}", self.detector);
            return Err(Failure::input(found));
        }
        Ok(Some(EyesOptions {
            detector,
            class: self.class,
            confidence: self.confidence,
            odometry: self.odometry.into(),
            surroundings: self.surroundings,
            points_per_s: f64::from(self.points),
            record: self.record.clone().map(|path| (self.plot.unwrap_or(0), path)),
            log: self.plot,
        }))
    }
}

/// Scores with the robot's own eyes, one kind of ball after the other.
fn look(
    subject: &mut Subject,
    kinds: &[ShootingOptions],
    eyes: &EyesOptions,
    output: &Output,
) -> Result<ExitCode, Failure> {
    output.prepare()?;
    let mut reported = false;
    for options in kinds {
        let (monitor, progress) = Progress::start(output.json)?;
        subject.setup.monitor = monitor;
        let (report, kick) = eyes::evaluate(&subject.setup, &*subject.maker, options, eyes)?;
        let timing = progress.finish();
        if output.nothing(&subject.setup.monitor, &timing) {
            break;
        }
        let whole = Evaluation::new("eyes", &subject.name, &report, timing);
        let json = to_json(&whole)?;
        output.print(&format!("{}\n{}", report.table(), timing.text()), &json);
        output.write(|out| write_eyes(out, &report, kick.as_ref(), &json))?;
        reported = true;
        if subject.setup.monitor.stopped() {
            break;
        }
    }
    if reported {
        output.write(write_report)?;
    }
    Ok(ended(&subject.setup.monitor))
}
