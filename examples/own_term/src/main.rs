//! A reward, a termination and an observation of one's own, trained on a few generated kicks, without a fork:
//!
//! ```sh
//! cargo run --release -p example-own-term -- runs/own_term
//! ```

mod terms;

use std::error::Error;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use paid_motion::MotionLibrary;
use paid_play::ReferenceLibrary;
use paid_robot::{RobotModel, RobotSpec};
use paid_task::TermSet;
use paid_train::{Alone, Limits, Outcome, Record, RunPreset, Scene, StageJob, Start, train_in};

use terms::{Effort, FeetApart, Tilt};

const PRESET: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/own_term.toml");

/// The terms under their names in presets. Installed once, before a preset is read.
fn install() -> Result<(), paid_task::TermSetError> {
    TermSet::builtin()
        .with_reward::<Effort>("effort")
        .with_termination::<FeetApart>("feet_apart")
        .with_observation::<Tilt>("tilt")
        .install()
}

/// Trains the preset with `--set` overrides, on motions that are made here: no file is read.
fn train(
    out: PathBuf,
    overrides: &[String],
    report: &mut dyn FnMut(&Record),
) -> Result<Outcome, Box<dyn Error>> {
    let preset = RunPreset::resolve(PRESET, overrides)?;
    let (robot, spec) = (RobotModel::g1(), RobotSpec::g1());
    let mut motions = MotionLibrary::builtin(&robot, &spec, 1.0 / preset.task.control_dt_s())?;
    motions.clips.truncate(3);
    let library = ReferenceLibrary::for_play(&motions, &robot, &spec, &preset.task.play_preset())?;
    let scene = Scene::with_library(&preset, library)?;
    let (start, limits, ranks) = (Start::Fresh, Limits::default(), Arc::new(Alone));
    let job = StageJob { preset, out, start, limits, threads: 2, ranks };
    Ok(train_in(&scene, &job, &AtomicBool::new(false), report, None)?)
}

fn main() {
    if let Err(error) = run() {
        eprintln!("error: {error}");
        std::process::exit(2);
    }
}

fn run() -> Result<(), Box<dyn Error>> {
    install()?;
    let out = std::env::args_os().nth(1).ok_or("expected the folder of the run, found nothing")?;
    train(out.into(), &[], &mut |record| {
        let effort = record.rewards.get("effort").unwrap_or_default();
        println!("iteration {:3}: effort {effort:.3} per second", record.iteration);
    })?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use paid_task::{TaskPreset, terms_table};
    use paid_train::TrainedPolicy;

    use super::*;

    /// One test, because terms are installed once in a process.
    #[test]
    fn terms_of_another_crate_are_trained_logged_listed_and_in_the_contract() {
        install().expect("free names");
        let folder = tempfile::tempdir().expect("folder");
        let out = folder.path().join("run");
        let mut records = Vec::new();
        let overrides = ["run.iterations=2", "task.terminations.feet_apart.limit_m=0.1"].map(str::to_owned);
        train(out.clone(), &overrides, &mut |record| records.push(record.clone())).expect("trains");

        // Torques cost; feet that stand 10 cm apart are too far from each other in every episode.
        for record in &records {
            assert!(record.rewards.get("effort").is_some_and(|paid| paid < 0.0), "{record:?}");
            assert!(record.terminations.get("feet_apart").is_some_and(|share| share > 0.5), "{record:?}");
        }
        assert_eq!(records.len(), 2);

        let row = |name: &str| terms_table().into_iter().find(|row| row.name == name).expect(name);
        assert_eq!((row("effort").kind, row("effort").parameters[0].default.as_str()), ("reward", "20.0"));
        assert_eq!((row("feet_apart").kind, row("tilt").kind), ("termination", "observation"));

        let policy = TrainedPolicy::load(&out).expect("reads");
        let contract = policy.contract("MIT").expect("a contract");
        let tilt = contract.observation.last().expect("terms");
        assert_eq!((tilt.name.as_str(), tilt.size, tilt.frame.as_str()), ("tilt", 1, "base"));

        // Presets: bad values and names that nothing has, one sentence each.
        let error = |set: &str| {
            TaskPreset::builtin_with("paper_stage1", &[set.to_owned()]).expect_err(set).to_string()
        };
        let text = error("rewards.effort.scale_nm=0.0");
        assert_eq!(text, "preset: rewards.effort.scale_nm is 0.0, expected a positive number");
        assert!(
            error("rewards.efort.weight=1.0").contains("rewards.effort"),
            "{}",
            error("rewards.efort.weight=1.0")
        );
        let text = error("observations.policy=[\"tild\"]");
        assert!(text.contains("this program has no observation term 'tild'"), "{text}");
        assert!(install().expect_err("twice").to_string().contains("installed once"));
    }
}
