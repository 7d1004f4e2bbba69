//! The weights of a run's policy: those of one checkpoint, or the mean of the last ones.

use std::path::{Path, PathBuf};

use paid_learn::Checkpoint;

use crate::folder::{PRESET_FILE, checkpoints, latest_checkpoint};
use crate::{RunPreset, TrainError};

/// Name of a run's policy in its folder, as a small checkpoint.
pub const WEIGHTS_FILE: &str = "policy.safetensors";

/// A checkpoint file as it is, or the policy of a run folder: the mean over the checkpoints of its last part, as its preset asks
/// ([`crate::RunConfig::average_last`]).
///
/// # Errors
/// If there is none, or one is damaged or of other networks than the others.
pub fn load_weights(run: &Path) -> Result<Checkpoint, TrainError> {
    let newest = latest_checkpoint(run)?;
    if !run.join(PRESET_FILE).is_file() {
        return mean(&[newest]);
    }
    let share = RunPreset::of_run(run, &[])?.run.average_last;
    let all = checkpoints(run)?;
    let end = all.last().map_or(0, |(iteration, _)| *iteration) as f64;
    let late = all.iter().filter(|(iteration, _)| *iteration as f64 >= (1.0 - share) * end).count();
    load_mean(run, late)
}

/// The mean of the weights of the newest `count` checkpoints of a run folder (at least one).
///
/// # Errors
/// If there are fewer, or as [`load_weights`].
pub fn load_mean(run: &Path, count: usize) -> Result<Checkpoint, TrainError> {
    let mut all = checkpoints(run)?;
    if count == 0 || all.len() < count {
        let message = format!("expected at least {} checkpoints, found {}", count.max(1), all.len());
        return Err(TrainError::Folder { path: run.to_owned(), message });
    }
    let newest: Vec<PathBuf> = all.split_off(all.len() - count).into_iter().map(|(_, path)| path).collect();
    mean(&newest)
}

/// The last of some checkpoints with the mean of all their weights.
fn mean(paths: &[PathBuf]) -> Result<Checkpoint, TrainError> {
    let mut all = paths.iter().map(|path| Checkpoint::load(path)).collect::<Result<Vec<_>, _>>()?;
    let newest =
        all.pop().ok_or_else(|| TrainError::Setup("expected a checkpoint, found none".to_owned()))?;
    Ok(if all.is_empty() { newest } else { newest.mean_with(&all)? })
}

/// Writes a checkpoint of weights, normalisers and preset only: small, free of anything that comes from the motion files, such as
/// environment states. It can be evaluated, exported and started from, not resumed.
///
/// # Errors
/// If `weights` has no preset, or the file cannot be written; an earlier file stays whole.
pub fn write_weights(weights: &Checkpoint, path: &Path) -> Result<(), TrainError> {
    let preset = RunPreset::of_checkpoint(weights)?.to_toml()?;
    weights.save_weights(path, &[(PRESET_FILE, preset.as_bytes())])?;
    Ok(())
}
