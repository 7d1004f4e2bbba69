//! The weights of a run's policy: those of one checkpoint, or the mean of the last ones.

use std::path::Path;

use paid_learn::Checkpoint;
use paid_play::{POLICY_FILE, PRESET_FILE, is_onnx};
use paid_policy::PlayContract;

use paid_onnx::OnnxFile;

use crate::folder::{Numbered, newest_and_earlier};
use crate::policy_file::{TrainedPolicy, run_name, unread};
use crate::{RunPreset, TrainError};

/// A checkpoint file as it is, or the policy of a run folder: the mean over the checkpoints of its last part, as its preset says
/// ([`crate::RunConfig::average_last`]), played as its policy file says ([`write_play`]).
///
/// # Errors
/// If there is none, one is damaged or of other networks than the others, or `run` is a policy file, which holds no critic.
pub fn load_weights(run: &Path) -> Result<Checkpoint, TrainError> {
    if is_onnx(run) {
        let message = "a policy file holds no critic, which training needs to continue; expected a run folder or a checkpoint \
                       (.safetensors), or a preset with a [teacher], which holds the policy until a new critic has learned";
        return Err(TrainError::Checkpoint { path: run.to_owned(), message: message.to_owned() });
    }
    if run.is_file() {
        return Ok(Checkpoint::load(run)?);
    }
    as_its_policy_plays(run, mean_of_run(run)?)
}

/// What a run of `preset` begins with: as [`load_weights`], or the policy of a policy file, whose critic is a new one. The teacher of the run
/// has to hold the policy until that has learned.
///
/// # Errors
/// As [`load_weights`]; of a policy file, if the run has no teacher.
pub fn load_start(from: &Path, preset: &RunPreset) -> Result<Checkpoint, TrainError> {
    if !is_onnx(from) || preset.teacher.is_none() {
        return load_weights(from);
    }
    let trained = TrainedPolicy::load(from)?;
    let learn = &trained.preset.learn;
    let mut weights = Checkpoint::of_policy(&trained.policy, [&learn.actor, &learn.critic], from)?;
    weights.set_blob(PRESET_FILE, trained.preset.to_toml()?.as_bytes());
    Ok(weights)
}

/// `weights` of the run's end, played as its policy file says, if it has one of the same end: another met the ball at other times.
fn as_its_policy_plays(run: &Path, mut weights: Checkpoint) -> Result<Checkpoint, TrainError> {
    let file = run.join(POLICY_FILE);
    if file.is_file() {
        let file = OnnxFile::read(&file).map_err(unread)?;
        let end = run_name(&RunPreset::of_checkpoint(&weights)?, weights.path());
        if file.metadata(paid_onnx::RUN_KEY) == Some(end.as_str()) {
            set_play(&mut weights, file.contract().map_err(unread)?.play.unwrap_or_default())?;
        }
    }
    Ok(weights)
}

/// The mean over the checkpoints of the last part of a run.
///
/// # Errors
/// As [`load_weights`].
pub(crate) fn mean_of_run(run: &Path) -> Result<Checkpoint, TrainError> {
    let ((end, newest), earlier) = newest_and_earlier(run)?;
    if !run.join(PRESET_FILE).is_file() {
        return mean(&newest, &[]);
    }
    let first = (1.0 - RunPreset::of_run(run, &[])?.run.average_last) * end as f64;
    let late = earlier.iter().position(|(iteration, _)| *iteration as f64 >= first);
    mean(&newest, late.map_or(&[], |late| &earlier[late..]))
}

/// The mean of the weights of the newest `count` checkpoints of a run folder (at least one), played as its policy file says
/// ([`write_play`]).
///
/// # Errors
/// If there are fewer, or as [`load_weights`].
pub fn load_mean(run: &Path, count: usize) -> Result<Checkpoint, TrainError> {
    let ((_, newest), earlier) = newest_and_earlier(run)?;
    let found = earlier.len() + 1;
    if count == 0 || found < count {
        let message = format!("expected at least {} checkpoints, found {found}", count.max(1));
        return Err(TrainError::Folder { path: run.to_owned(), message });
    }
    as_its_policy_plays(run, mean(&newest, &earlier[found - count..])?)
}

/// The checkpoint `newest` with the mean of its weights and those of `others`.
fn mean(newest: &Path, others: &[Numbered]) -> Result<Checkpoint, TrainError> {
    let newest = Checkpoint::load(newest)?;
    if others.is_empty() {
        return Ok(newest);
    }
    let others = others.iter().map(|(_, path)| Checkpoint::load(path)).collect::<Result<Vec<_>, _>>()?;
    Ok(newest.mean_with(&others)?)
}

/// Writes a checkpoint of weights, normalizers and preset only: small, free of anything that comes from the motion files, such as
/// environment states. It can be evaluated, exported and started from, not resumed. Of the motions' folder only the name is
/// kept: a path is of no use on another machine.
///
/// # Errors
/// If `weights` has no preset, or the file cannot be written; an earlier file stays whole.
pub fn write_weights(weights: &Checkpoint, path: &Path) -> Result<(), TrainError> {
    let preset = RunPreset::of_checkpoint(weights)?.without_paths();
    weights.save_weights(path, &[(PRESET_FILE, preset.to_toml()?.as_bytes())])?;
    Ok(())
}

/// Writes into a policy file or a checkpoint how it is played. All else stays: the weights and, in a full checkpoint, what it takes to
/// resume it.
///
/// # Errors
/// If it holds no preset, embeds a reference, has a memory and is to play in the mirror, or cannot be written; the file stays whole then.
pub fn write_play(path: &Path, play: PlayContract) -> Result<(), TrainError> {
    if is_onnx(path) {
        let contract = OnnxFile::read(path).and_then(|file| file.contract()).map_err(unread)?;
        if let Some(clip) = contract.reference {
            let message =
                format!("expected a file without a reference, found '{clip}' in it; export the policy again");
            return Err(TrainError::Checkpoint { path: path.to_owned(), message });
        }
        let mut trained = TrainedPolicy::load(path)?;
        trained.preset.play_as(play)?;
        return trained.write_onnx(path, &contract.license, None);
    }
    let mut checkpoint = Checkpoint::load(path)?;
    set_play(&mut checkpoint, play)?;
    Ok(checkpoint.save()?)
}

fn set_play(weights: &mut Checkpoint, play: PlayContract) -> Result<(), TrainError> {
    let mut preset = RunPreset::of_checkpoint(weights)?;
    preset.play_as(play)?;
    weights.set_blob(PRESET_FILE, preset.to_toml()?.as_bytes());
    Ok(())
}

impl RunPreset {
    /// Changes how its policy is played.
    fn play_as(&mut self, play: PlayContract) -> Result<(), TrainError> {
        self.task.set_play(play);
        self.validate().map_err(|message| TrainError::Preset { place: self.stage.clone(), message })
    }

    /// With names in place of the paths of motions and teacher, for another machine.
    pub(crate) fn without_paths(&self) -> Self {
        let mut preset = self.clone();
        preset.run.motions = folder_name(&preset.run.motions);
        if let Some(teacher) = &mut preset.teacher {
            teacher.policy = folder_name(&teacher.policy);
        }
        preset
    }
}

/// The last part of a path; empty for an empty path.
fn folder_name(path: &str) -> String {
    Path::new(path).file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_policy_file_keeps_the_name_of_the_motions_folder_and_no_path() {
        for (path, name) in
            [("/somewhere/data/kicks/", "kicks"), ("../kicks", "kicks"), ("kicks", "kicks"), ("", "")]
        {
            assert_eq!(folder_name(path), name);
        }
    }
}
