//! The run folder: preset, metrics, checkpoints. Files appear whole or not at all.

use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};

use paid_files::write_atomically;
use paid_play::{POLICY_FILE, PRESET_FILE};

use crate::events::EVENTS;
use crate::record::Record;
use crate::{EventWriter, RunPreset, TrainError};

/// Name of the metrics file in a run folder: one JSON object per line.
pub const METRICS_FILE: &str = "metrics.jsonl";

/// A folder that belongs to one stage of one run.
#[derive(Debug)]
pub struct RunFolder {
    path: PathBuf,
    metrics: File,
    events: EventWriter,
}

impl RunFolder {
    /// Starts a new run: makes the folder, refuses one that holds a run already, saves the resolved preset.
    ///
    /// # Errors
    /// If the folder is taken or cannot be written.
    pub fn create(path: &Path, preset: &str) -> Result<Self, TrainError> {
        fs::create_dir_all(path).map_err(TrainError::write(path))?;
        if path.join(PRESET_FILE).exists() || !checkpoints(path)?.is_empty() {
            return Err(TrainError::Folder {
                path: path.to_owned(),
                message:
                    "expected no earlier run, found one; continue it with --resume or choose another --out"
                        .to_owned(),
            });
        }
        write(&path.join(PRESET_FILE), preset.as_bytes())?;
        Self::open(path, 0)
    }

    /// Continues a run after `iteration`: later lines of the metrics file are dropped, a new event file voids later events.
    ///
    /// # Errors
    /// If the folder cannot be read or written.
    pub fn resume(path: &Path, iteration: u64) -> Result<Self, TrainError> {
        let metrics = path.join(METRICS_FILE);
        let text = match fs::read_to_string(&metrics) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => String::new(),
            Err(source) => return Err(TrainError::Read { path: metrics, source }),
        };
        let kept: String = text
            .split_inclusive('\n')
            .filter(|line| line.ends_with('\n') && line_iteration(line).is_some_and(|i| i <= iteration))
            .collect();
        if kept != text {
            write(&metrics, kept.as_bytes())?;
        }
        Self::open(path, iteration + 1)
    }

    fn open(path: &Path, first_step: u64) -> Result<Self, TrainError> {
        let metrics_path = path.join(METRICS_FILE);
        let metrics = File::options()
            .append(true)
            .create(true)
            .open(&metrics_path)
            .map_err(TrainError::write(&metrics_path))?;
        let events = EventWriter::create(path, first_step)?;
        Ok(Self { path: path.to_owned(), metrics, events })
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Appends an iteration to the metrics and the event file.
    ///
    /// # Errors
    /// If either cannot be written.
    pub fn log(&mut self, record: &Record) -> Result<(), TrainError> {
        let path = self.path.join(METRICS_FILE);
        let mut line = serde_json::to_string(record).map_err(|error| {
            TrainError::Setup(format!("metrics of iteration {}: {error}", record.iteration))
        })?;
        line.push('\n');
        self.metrics.write_all(line.as_bytes()).map_err(TrainError::write(&path))?;
        self.events.scalars(record.iteration, &record.scalars())
    }

    /// Removes all but the last `keep` checkpoints.
    ///
    /// # Errors
    /// If the folder cannot be read or a file not be removed.
    pub fn prune(&self, keep: usize) -> Result<(), TrainError> {
        let all = checkpoints(&self.path)?;
        for (_, path) in &all[..all.len().saturating_sub(keep.max(1))] {
            fs::remove_file(path).map_err(TrainError::write(path))?;
        }
        Ok(())
    }
}

/// Removes the files of a run that was killed before its first checkpoint, so that it can start again: preset, log and event files.
/// True if there was such a run. A folder with a checkpoint or a policy stays as it is, and so does one whose log continues past the first
/// checkpoint: its files were lost.
///
/// # Errors
/// If the folder cannot be read, or a file cannot be removed.
pub fn forget_unsaved(folder: &Path) -> Result<bool, TrainError> {
    if !folder.join(PRESET_FILE).exists()
        || folder.join(POLICY_FILE).exists()
        || !checkpoints(folder)?.is_empty()
    {
        return Ok(false);
    }
    let interval = RunPreset::of_run(folder, &[])?.run.checkpoint_interval;
    let log = folder.join(METRICS_FILE);
    let text =
        if log.exists() { fs::read_to_string(&log).map_err(TrainError::read(&log))? } else { String::new() };
    if text.lines().filter_map(line_iteration).any(|iteration| iteration > interval) {
        return Ok(false);
    }
    let mut files = vec![log];
    for entry in fs::read_dir(folder).map_err(TrainError::read(folder))? {
        let entry = entry.map_err(TrainError::read(folder))?;
        if entry.file_name().to_string_lossy().starts_with(EVENTS) {
            files.push(entry.path());
        }
    }
    // Last: without it there is no run.
    files.push(folder.join(PRESET_FILE));
    for file in files {
        match fs::remove_file(&file) {
            // Another process of the run may be faster.
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {}
            removed => removed.map_err(TrainError::write(&file))?,
        }
    }
    Ok(true)
}

/// Writes a small file of a run folder, whole or not at all.
///
/// # Errors
/// If it cannot be written.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), TrainError> {
    write_atomically(path, bytes).map_err(TrainError::write(path))
}

fn line_iteration(line: &str) -> Option<u64> {
    serde_json::from_str::<serde_json::Value>(line).ok()?.get("iteration")?.as_u64()
}

/// File name of the checkpoint after `iteration` iterations.
pub fn checkpoint_name(iteration: u64) -> String {
    format!("model_{iteration}.safetensors")
}

/// The checkpoints of a run folder, oldest first, with their iterations.
///
/// # Errors
/// If the folder cannot be read.
pub fn checkpoints(folder: &Path) -> Result<Vec<Numbered>, TrainError> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).map_err(TrainError::read(folder))? {
        let path = entry.map_err(TrainError::read(folder))?.path();
        let iteration = path
            .file_name()
            .and_then(|name| name.to_str())
            .and_then(|name| name.strip_prefix("model_")?.strip_suffix(".safetensors")?.parse().ok());
        if let Some(iteration) = iteration {
            found.push((iteration, path));
        }
    }
    found.sort();
    Ok(found)
}

/// The newest checkpoint of a run folder, or the file itself if `path` is one.
///
/// # Errors
/// If there is none.
pub fn latest_checkpoint(path: &Path) -> Result<PathBuf, TrainError> {
    if path.is_file() {
        return Ok(path.to_owned());
    }
    Ok(newest_and_earlier(path)?.0.1)
}

/// A checkpoint file with its iteration.
pub type Numbered = (u64, PathBuf);

/// The newest checkpoint of a run folder, and the earlier ones, oldest first.
///
/// # Errors
/// If there is none.
pub fn newest_and_earlier(folder: &Path) -> Result<(Numbered, Vec<Numbered>), TrainError> {
    let mut all = checkpoints(folder)?;
    let newest = all.pop().ok_or_else(|| TrainError::Folder {
        path: folder.to_owned(),
        message: "expected a checkpoint model_<iteration>.safetensors, found none; a run that ended before its first one starts again in an \
                  empty folder"
            .to_owned(),
    })?;
    Ok((newest, all))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(iteration: u64) -> Record {
        Record { iteration, ..Record::default() }
    }

    #[test]
    fn a_taken_folder_is_refused_and_left_alone() {
        let dir = tempfile::tempdir().expect("folder");
        let path = dir.path().join("run");
        let mut folder = RunFolder::create(&path, "a = 1\n").expect("create");
        folder.log(&record(1)).expect("log");
        let error = RunFolder::create(&path, "a = 2\n").expect_err("taken").to_string();
        assert!(error.contains("--resume"), "{error}");
        assert_eq!(fs::read_to_string(path.join(PRESET_FILE)).expect("preset"), "a = 1\n");
    }

    #[test]
    fn resume_drops_lines_after_the_checkpoint_and_a_cut_line() {
        let dir = tempfile::tempdir().expect("folder");
        let mut folder = RunFolder::create(dir.path(), "").expect("create");
        for i in 1..=4 {
            folder.log(&record(i)).expect("log");
        }
        let path = dir.path().join(METRICS_FILE);
        let mut text = fs::read_to_string(&path).expect("metrics");
        text.push_str("{\"iteration\": 2, \"cu");
        fs::write(&path, text).expect("cut line");
        let mut folder = RunFolder::resume(dir.path(), 2).expect("resume");
        folder.log(&record(3)).expect("log");
        let text = fs::read_to_string(&path).expect("metrics");
        let iterations: Vec<_> = text.lines().map(|l| line_iteration(l).expect("whole line")).collect();
        assert_eq!(iterations, [1, 2, 3]);
    }

    #[test]
    fn a_run_without_a_checkpoint_is_forgotten_and_nothing_else() {
        let dir = tempfile::tempdir().expect("folder");
        let mut preset = RunPreset::resolve("stage1", &[]).expect("built in");
        preset.run.checkpoint_interval = 3;
        let files = || {
            let mut names: Vec<String> = fs::read_dir(dir.path())
                .expect("a folder")
                .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
                .collect();
            names.sort();
            names
        };
        let begin = |iterations: u64| {
            let mut folder = RunFolder::create(dir.path(), &preset.to_toml().expect("TOML")).expect("create");
            for i in 1..=iterations {
                folder.log(&record(i)).expect("log");
            }
        };
        assert!(!forget_unsaved(dir.path()).expect("nothing to do"));
        fs::write(dir.path().join("notes.txt"), "mine").expect("writes");
        begin(3);
        assert_eq!(files().len(), 4);
        assert!(forget_unsaved(dir.path()).expect("forgets"));
        assert_eq!(files(), ["notes.txt"]);

        begin(4);
        assert!(!forget_unsaved(dir.path()).expect("leaves it"));
        assert_eq!(files().len(), 4, "its checkpoint was lost");
        fs::remove_file(dir.path().join(PRESET_FILE)).expect("removed");
        fs::remove_file(dir.path().join(METRICS_FILE)).expect("removed");
        begin(2);
        for kept in [checkpoint_name(2), POLICY_FILE.to_owned()] {
            let file = dir.path().join(kept);
            fs::write(&file, "weights").expect("writes");
            assert!(!forget_unsaved(dir.path()).expect("leaves it"));
            assert!(dir.path().join(PRESET_FILE).exists() && dir.path().join(METRICS_FILE).exists());
            fs::remove_file(file).expect("removed");
        }
    }

    #[test]
    fn prune_keeps_the_newest_by_number() {
        let dir = tempfile::tempdir().expect("folder");
        let folder = RunFolder::create(dir.path(), "").expect("create");
        for i in [5, 10, 9, 100] {
            write_atomically(&dir.path().join(checkpoint_name(i)), b"x").expect("write");
        }
        folder.prune(2).expect("prune");
        let left: Vec<u64> = checkpoints(dir.path()).expect("list").iter().map(|c| c.0).collect();
        assert_eq!(left, [10, 100]);
        assert_eq!(latest_checkpoint(dir.path()).expect("latest"), dir.path().join("model_100.safetensors"));
    }

    #[test]
    fn a_refused_write_names_the_path_and_leaves_what_is_there() {
        let dir = tempfile::tempdir().expect("folder");
        let file = dir.path().join("file");
        fs::write(&file, "old").expect("write");
        let error = RunFolder::create(&file.join("below"), "").expect_err("refused").to_string();
        assert!(error.contains("below"), "{error}");
        assert_eq!(fs::read(&file).expect("file"), b"old");
    }
}
