//! The training of a policy of a comparison, stage by stage.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use paid_eval::contacts;
use paid_eval::curves::Curves;
use paid_lab::compare::Contender;
use paid_lab::compare::{difference, has_run};
use paid_play::{POLICY_FILE, PRESET_FILE};
use paid_train::folder::{METRICS_FILE, checkpoints, forget_unsaved};
use paid_train::{Alone, End, Limits, RunPreset, StageJob, Start, train_stage};

use crate::failure::Failure;
use crate::stage_progress::StageProgress;

/// Where a stage of a contender is trained.
pub fn run_folder(out: &Path, contender: &Contender, preset: &RunPreset) -> PathBuf {
    out.join(&contender.folder).join(&preset.stage)
}

/// A run of other values in the folder would be continued with a policy that is not the plan's, and one without a preset may be any run.
pub fn refuse_another(folder: &Path, preset: &RunPreset) -> Result<(), Failure> {
    let file = folder.join(PRESET_FILE);
    if has_run(folder) {
        return match difference(folder, preset)? {
            None => Ok(()),
            Some((key, expected, found)) => Err(Failure::input(format!(
                "{}: expected {key} = {expected}, as in this plan, found {found}; use another --out",
                file.display()
            ))),
        };
    }
    match [METRICS_FILE, POLICY_FILE].into_iter().find(|name| folder.join(name).exists()) {
        None => Ok(()),
        Some(name) => Err(Failure::input(format!(
            "{}: expected the preset of the run next to its {name}, found none; copy it too, or use another --out",
            file.display()
        ))),
    }
}

/// Refuses runs of a contender that began with another policy, or with other clips.
pub fn refuse_another_origin(out: &Path, contender: &Contender) -> Result<(), Failure> {
    if !contender.stages.iter().any(|preset| has_run(&run_folder(out, contender, preset))) {
        return Ok(());
    }
    match contender.origin()? {
        Some(origin) => Ok(origin.refuse_another(&out.join(&contender.folder))?),
        None => Ok(()),
    }
}

/// The samples of a stage, if it was trained to its end.
fn samples(folder: &Path, preset: &RunPreset) -> Option<u64> {
    let curves = Curves::read(folder).ok()?;
    (curves.iteration() >= preset.run.iterations).then(|| curves.samples() as u64)
}

/// The samples of each stage, if all of them were trained to their end.
pub fn trained(out: &Path, contender: &Contender) -> Option<Vec<u64>> {
    contender.stages.iter().map(|preset| samples(&run_folder(out, contender, preset), preset)).collect()
}

/// Policy file and samples of a stage that was trained to its end elsewhere, and came without its checkpoints. Next to checkpoints a policy
/// file may be that of an earlier end.
fn carried(folder: &Path, preset: &RunPreset) -> Result<Option<(PathBuf, u64)>, Failure> {
    let file = folder.join(POLICY_FILE);
    match samples(folder, preset) {
        Some(samples) if file.is_file() && checkpoints(folder)?.is_empty() => Ok(Some((file, samples))),
        _ => Ok(None),
    }
}

/// Trains what is to be trained, and reports the progress under `name` unless `quiet`. The policy and the samples of its stages; `None` after
/// Ctrl-C.
pub fn train(
    out: &Path,
    contender: &Contender,
    name: &str,
    threads: usize,
    quiet: bool,
    stop: &Arc<AtomicBool>,
) -> Result<Option<(PathBuf, Vec<u64>)>, Failure> {
    if let Some(policy) = &contender.policy {
        return Ok(Some((policy.clone(), Vec::new())));
    }
    if let Some(origin) = contender.origin()? {
        origin.keep(&out.join(&contender.folder))?;
    }
    let (mut before, mut samples) = (contender.from.clone(), Vec::new());
    for preset in &contender.stages {
        let folder = run_folder(out, contender, preset);
        if let Some((policy, trained)) = carried(&folder, preset)? {
            samples.push(trained);
            before = Some(policy);
            continue;
        }
        forget_unsaved(&folder)?;
        let start =
            if has_run(&folder) { Start::Resume } else { before.take().map_or(Start::Fresh, Start::From) };
        let job = StageJob {
            preset: preset.clone(),
            out: folder.clone(),
            start,
            limits: Limits::default(),
            threads,
            ranks: Arc::new(Alone),
        };
        let mut progress = StageProgress::new(format!("{name}, {}", preset.stage), quiet);
        let outcome = train_stage(&job, stop, &mut |record| progress.tell(record)).map_err(Failure::input)?;
        if outcome.end == End::Stopped {
            return Ok(None);
        }
        samples.push(outcome.samples);
        if contacts::keep_of_run(&folder, threads, stop)?.is_none() && stop.load(Ordering::SeqCst) {
            return Ok(None);
        }
        before = Some(folder);
    }
    Ok(before.map(|policy| (policy, samples)))
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn preset(iterations: u64) -> RunPreset {
        let mut preset = RunPreset::resolve("stage1", &[]).expect("built in");
        preset.run.iterations = iterations;
        preset
    }

    /// A folder with the preset of two iterations and a log of as many.
    fn run() -> tempfile::TempDir {
        let folder = tempfile::tempdir().expect("folder");
        fs::write(folder.path().join(PRESET_FILE), preset(2).to_toml().expect("TOML")).expect("writes");
        let log = "{\"iteration\":1,\"samples\":1536}\n{\"iteration\":2,\"samples\":3072}\n";
        fs::write(folder.path().join(METRICS_FILE), log).expect("writes");
        folder
    }

    #[test]
    fn a_finished_stage_without_checkpoints_is_taken_by_its_policy_file() {
        let folder = run();
        let found = |iterations| carried(folder.path(), &preset(iterations)).expect("reads");
        assert_eq!(found(2), None, "no policy");
        let file = folder.path().join(POLICY_FILE);
        fs::write(&file, "weights").expect("writes");
        assert_eq!(found(2), Some((file, 3072)));
        assert_eq!(found(3), None, "not at its end");
        fs::write(folder.path().join("model_1.safetensors"), "weights").expect("writes");
        assert_eq!(found(2), None, "the policy may be of an earlier end");
    }

    #[test]
    fn a_longer_or_a_shorter_run_in_the_folder_is_refused() {
        let folder = run();
        let told = |iterations| refuse_another(folder.path(), &preset(iterations)).map_err(|e| e.to_string());
        assert_eq!(told(2), Ok(()));
        for iterations in [1, 3] {
            let error = told(iterations).expect_err("another length");
            assert!(error.starts_with(&folder.path().display().to_string()), "{error}");
            let expected = format!(
                "expected run.iterations = {iterations}, as in this plan, found 2; use another --out"
            );
            assert!(error.ends_with(&expected), "{error}");
        }
    }

    #[test]
    fn a_run_that_came_without_its_preset_is_refused() {
        let folder = run();
        fs::remove_file(folder.path().join(PRESET_FILE)).expect("removed");
        let told = || refuse_another(folder.path(), &preset(2)).map_err(|e| e.to_string());
        let error = told().expect_err("no preset");
        assert!(
            error.contains("preset.toml: expected the preset of the run next to its metrics.jsonl"),
            "{error}"
        );
        fs::remove_file(folder.path().join(METRICS_FILE)).expect("removed");
        assert_eq!(told(), Ok(()), "nothing is there");
    }
}
