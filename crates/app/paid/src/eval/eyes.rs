//! Onboard perception: options of `paid eval shooting --eyes`.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::ValueEnum;
use paid_eval::eyes::{self, DetectorChoice, EyesOptions, OdometryChoice};
use paid_eval::html::write_report;
use paid_eval::results::{Evaluation, to_json, write_eyes};
use paid_eval::shooting::ShootingOptions;
use paid_eval::subject::Subject;
use paid_lidar::sim::SceneKind;
use paid_mujoco::Ground;

use super::progress::Progress;
use super::{Output, ended};
use crate::failure::Failure;
use crate::{perceive, ranks};

/// Where the torso's pose comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum OdometryName {
    /// LiDAR-inertial odometry on a simulated Mid-360.
    Lidar,
    /// The true pose with the drift and jitter of training.
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
#[command(next_help_heading = "Onboard perception")]
pub struct EyesArgs {
    /// Use rendered images and a simulated LiDAR. Needs --engine mujoco.
    ///
    /// The program detects and tracks the ball in the images. Neither the policy nor the choice of the motion is given the simulator's
    /// ball.
    #[arg(long, conflicts_with = "knowledge")]
    eyes: bool,
    /// Ball detector: own, exact-box or an ONNX file.
    ///
    /// own is the network in this program; exact-box is the bounding box of the pixels that show the ball.
    #[arg(long, value_name = "DETECTOR", default_value = "own", requires = "eyes")]
    detector: String,
    /// Number of the ball's class in the ONNX file [default: the class that the file names].
    #[arg(long, hide_short_help = true, value_name = "K", requires = "eyes")]
    class: Option<usize>,
    /// Lowest score of a detection that counts, 0 to 1 [default: the detector's].
    #[arg(long, hide_short_help = true, value_name = "SCORE", value_parser = share, requires = "eyes")]
    confidence: Option<f64>,
    /// Source of the torso's pose.
    #[arg(long, value_enum, default_value = "lidar", requires = "eyes")]
    odometry: OdometryName,
    /// What the LiDAR scans: hall, pitch, corridor, people or endless.
    #[arg(long, hide_short_help = true, value_name = "NAME", default_value = "hall", requires = "eyes")]
    surroundings: SceneKind,
    /// Points that the LiDAR measures per second.
    #[arg(long, hide_short_help = true, default_value_t = 200_000, value_parser = clap::value_parser!(u32).range(1_000..=1_000_000), requires = "eyes")]
    points: u32,
    /// Plot true, seen and estimated ball of this trial (from 0) into the folder of --out.
    #[arg(long, hide_short_help = true, value_name = "TRIAL", requires = "eyes", requires = "out")]
    plot: Option<usize>,
    /// Record the sensor data of the first trial, or of that of --plot, as MCAP.
    ///
    /// About 20 MB per second.
    #[arg(long, hide_short_help = true, value_name = "FILE", requires = "eyes")]
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
        if subject.scene.ground != Ground::Flat {
            return Err(Failure::input(
                "--ground: expected flat, turf or hard with --eyes, whose images show a plane, found another",
            ));
        }
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

/// Scores with onboard perception, one kind of ball after the other.
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
