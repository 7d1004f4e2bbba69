//! Comparisons of the engines on disk.

use std::path::Path;

use paid_eval::EvalError;
use paid_eval::results::{to_json, write_shooting, write_tracking};
use paid_files::write_whole;

use crate::agreement::AgreementReport;
use crate::tracking_agreement::TrackingAgreement;

/// Writes both reports and their comparison.
///
/// # Errors
/// If a file cannot be written.
pub fn write_agreement(folder: &Path, report: &AgreementReport) -> Result<(), EvalError> {
    let kind = report.builtin.ball();
    write_shooting(folder, "builtin", &report.builtin, &to_json(&report.builtin)?)?;
    write_shooting(folder, "mujoco", &report.mujoco, &to_json(&report.mujoco)?)?;
    write_whole(&folder.join(format!("both_{kind}_trials.csv")), report.csv().as_bytes())?;
    Ok(write_whole(&folder.join(format!("both_{kind}.txt")), report.table().as_bytes())?)
}

/// Writes both reports and their comparison.
///
/// # Errors
/// If a file cannot be written.
pub fn write_tracking_agreement(folder: &Path, report: &TrackingAgreement) -> Result<(), EvalError> {
    write_tracking(folder, "builtin", &report.builtin, &to_json(&report.builtin)?)?;
    write_tracking(folder, "mujoco", &report.mujoco, &to_json(&report.mujoco)?)?;
    write_whole(&folder.join("both_tracking_runs.csv"), report.csv().as_bytes())?;
    Ok(write_whole(&folder.join("both_tracking.txt"), report.table().as_bytes())?)
}
