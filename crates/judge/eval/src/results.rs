//! Results on disk and as JSON: what an evaluation leaves in its folder.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use paid_files::{FileError, write_whole};
use serde::Serialize;

use crate::EvalError;
use crate::clips::ClipsReport;
#[cfg(feature = "eyes")]
use crate::eyes::{EyesReport, KickLog, kick_chart};
use crate::lag::LagReport;
use crate::likeness::LikenessReport;
use crate::matches::MatchReport;
use crate::monitor::Timing;
use crate::panel::PanelReport;
use crate::robustness::RobustnessReport;
use crate::shooting::{self, ShootingReport};
use crate::tracking::TrackingReport;
use crate::worst::STRIPS;

/// An evaluation as JSON: the report, what it is about, and what it cost.
#[derive(Clone, Debug, Serialize)]
pub struct Evaluation<'a, R: Serialize> {
    /// `tracking`, `shooting`, `agreement`, ...
    pub kind: &'static str,
    /// Where the policy came from.
    pub policy: &'a str,
    /// The report.
    #[serde(flatten)]
    pub report: &'a R,
    /// What it cost.
    pub timing: Timing,
    /// The command that this program was started with.
    pub command: String,
}

impl<'a, R: Serialize> Evaluation<'a, R> {
    /// An evaluation by the command that runs.
    pub fn new(kind: &'static str, policy: &'a str, report: &'a R, timing: Timing) -> Self {
        Self { kind, policy, report, timing, command: command() }
    }
}

/// The running command, as a shell takes it; the program without its folder.
fn command() -> String {
    let quoted = |word: String| {
        let plain = |c: char| c.is_alphanumeric() || "-_./=,:[]+@%".contains(c);
        if !word.is_empty() && word.chars().all(plain) {
            word
        } else {
            format!("'{}'", word.replace('\'', "'\\''"))
        }
    };
    let words =
        std::env::args_os().map(|word| word.to_string_lossy().into_owned()).enumerate().map(|(k, word)| {
            let program = Path::new(&word).file_stem().map(|stem| stem.to_string_lossy().into_owned());
            quoted(program.filter(|_| k == 0).unwrap_or(word))
        });
    words.collect::<Vec<_>>().join(" ")
}

/// A value on one line of JSON.
///
/// # Errors
/// If JSON cannot hold it.
pub fn to_json(value: &impl Serialize) -> Result<String, EvalError> {
    serde_json::to_string(value).map_err(|error| EvalError::Serialize(error.to_string()))
}

/// Writes a shooting report into `folder` as JSON (`json`), table, CSV, heat maps and paths, and removes the list of an earlier report's
/// film strips. Names start with `engine` (`builtin` or
/// `mujoco`) and the kind of ball.
///
/// # Errors
/// If a file cannot be written.
pub fn write_shooting(
    folder: &Path,
    engine: &str,
    report: &ShootingReport,
    json: &str,
) -> Result<(), EvalError> {
    let kind = report.ball();
    let file = |what: &str| folder.join(format!("{engine}_{kind}_{what}"));
    // Film strips of an earlier report show other shots.
    let strips = file(STRIPS);
    match fs::remove_file(&strips) {
        Err(source) if source.kind() != ErrorKind::NotFound => {
            return Err(FileError { path: strips, source }.into());
        }
        _ => {}
    }
    write_whole(&file("shooting.json"), json.as_bytes())?;
    write_whole(&file("trials.csv"), report.csv().as_bytes())?;
    write_whole(&folder.join(format!("{engine}_{kind}.txt")), report.table().as_bytes())?;
    for (name, map) in report.maps() {
        map.figure().save(&file(name))?;
    }
    Ok(report.paths().save(&file("paths"))?)
}

/// Writes the reports of one engine side by side, where there is more than one: static and rolling balls in one table and one
/// plot.
///
/// # Errors
/// If a file cannot be written.
pub fn write_summary(folder: &Path, engine: &str, reports: &[ShootingReport]) -> Result<(), EvalError> {
    if reports.len() < 2 {
        return Ok(());
    }
    let table = folder.join(format!("{engine}_summary.txt"));
    write_whole(&table, shooting::summary(reports).as_bytes())?;
    Ok(shooting::panels(reports).save(&folder.join(format!("{engine}_summary_panels")))?)
}

/// Writes a tracking report as JSON (`json`), table and error bars.
///
/// # Errors
/// If a file cannot be written.
pub fn write_tracking(
    folder: &Path,
    engine: &str,
    report: &TrackingReport,
    json: &str,
) -> Result<(), EvalError> {
    let file = |what: &str| folder.join(format!("{engine}_tracking{what}"));
    write_whole(&file(".json"), json.as_bytes())?;
    write_whole(&file(".txt"), report.table().as_bytes())?;
    Ok(report.error_bars().figure().save(&file("_errors"))?)
}

/// Writes `name` as JSON and table, and as CSV where there is one.
///
/// # Errors
/// If a file cannot be written.
pub fn write_forms(
    folder: &Path,
    name: &str,
    json: &str,
    csv: Option<String>,
    table: &str,
) -> Result<(), EvalError> {
    let file = |extension: &str| -> PathBuf { folder.join(format!("{name}.{extension}")) };
    write_whole(&file("json"), json.as_bytes())?;
    if let Some(csv) = csv {
        write_whole(&file("csv"), csv.as_bytes())?;
    }
    Ok(write_whole(&file("txt"), table.as_bytes())?)
}

/// Writes matches in `engine` (`builtin` or `mujoco`) as JSON, CSV and table.
///
/// # Errors
/// If a file cannot be written.
pub fn write_match(folder: &Path, engine: &str, report: &MatchReport, json: &str) -> Result<(), EvalError> {
    let name = format!("{engine}_match_{}", report.ball());
    write_forms(folder, &name, json, Some(report.csv()), &report.table())
}

/// Writes the scores of the clips in an engine as JSON, CSV and table.
///
/// # Errors
/// If a file cannot be written.
pub fn write_clips(folder: &Path, engine: &str, report: &ClipsReport, json: &str) -> Result<(), EvalError> {
    write_forms(folder, &format!("{engine}_clips"), json, Some(report.csv()), &report.table())
}

/// Writes a comparison with the clips as JSON and table.
///
/// # Errors
/// If a file cannot be written.
pub fn write_likeness(
    folder: &Path,
    engine: &str,
    report: &LikenessReport,
    json: &str,
) -> Result<(), EvalError> {
    write_forms(folder, &format!("{engine}_likeness"), json, None, &report.table())
}

/// Writes the lags of joints as JSON and table.
///
/// # Errors
/// If a file cannot be written.
pub fn write_lag(folder: &Path, engine: &str, report: &LagReport, json: &str) -> Result<(), EvalError> {
    write_forms(folder, &format!("{engine}_lag"), json, None, &report.table())
}

/// Writes a panel as JSON, CSV and table.
///
/// # Errors
/// If a file cannot be written.
pub fn write_panel(folder: &Path, report: &PanelReport, json: &str) -> Result<(), EvalError> {
    let name = if report.options.held_out { "panel_held_out" } else { "panel" };
    write_forms(folder, name, json, Some(report.csv()), &report.table())
}

/// Writes a report of what goes wrong as JSON, CSV and table; the files are named after its series.
///
/// # Errors
/// If a file cannot be written.
pub fn write_robustness(folder: &Path, report: &RobustnessReport, json: &str) -> Result<(), EvalError> {
    write_forms(folder, report.options.series.name(), json, Some(report.csv()), &report.table())
}

/// Writes an evaluation with onboard perception: the files of [`write_shooting`] under the name `eyes`, the detections as CSV, and the
/// course of a kick if one was kept.
///
/// # Errors
/// If a file cannot be written.
#[cfg(feature = "eyes")]
pub fn write_eyes(
    folder: &Path,
    report: &EyesReport,
    kick: Option<&KickLog>,
    json: &str,
) -> Result<(), EvalError> {
    write_shooting(folder, "eyes", &report.shooting, json)?;
    let ball = report.shooting.ball();
    write_whole(&folder.join(format!("eyes_{ball}.txt")), report.table().as_bytes())?;
    write_whole(&folder.join(format!("eyes_{ball}_sightings.csv")), report.sightings_csv().as_bytes())?;
    kick.map_or(Ok(()), |kick| Ok(kick_chart(kick).save(&folder.join(format!("eyes_{ball}_kick")))?))
}
