//! The trainer and its run folder on the toy task.

use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use paid_learn::{Alone, Checkpoint};
use paid_policy::PlayContract;

use crate::folder::{METRICS_FILE, checkpoint_name, checkpoints};
use crate::policy_weights::{load_weights, write_play};
use crate::stage::run_stage;
use crate::toy::Toy;
use crate::{End, Judge, Limits, Named, Outcome, Phase, RunPreset, StageJob, Start, Trainer};

pub(crate) fn trainer(preset: &RunPreset) -> Trainer<Toy> {
    Trainer::new(preset, Toy::shards(preset), vec!["toy".to_owned()]).expect("trainer")
}

pub(crate) fn weights(trainer: &Trainer<Toy>) -> Vec<u32> {
    trainer
        .learner()
        .actor()
        .params
        .iter()
        .chain(&trainer.learner().critic().params)
        .map(|x| x.to_bits())
        .collect()
}

/// Without memory, with it, and with it beside the policy's input alone.
fn kinds() -> [RunPreset; 3] {
    [&[][..], &["learn.actor.kind=lstm", "learn.critic.kind=lstm"], &["learn.actor.kind=memory"]]
        .map(Toy::preset)
}

#[test]
fn the_thread_count_does_not_change_the_weights() {
    for preset in kinds() {
        let mut one = trainer(&preset);
        let mut three = trainer(&preset);
        for _ in 0..3 {
            let a = one.iterate(1).expect("iterates");
            let b = three.iterate(3).expect("iterates");
            assert_eq!((a.mean_reward, a.loss, a.rewards), (b.mean_reward, b.loss, b.rewards));
        }
        assert_eq!(weights(&one), weights(&three));
    }
}

#[test]
fn a_resumed_run_ends_in_the_weights_of_an_uninterrupted_one() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("model.safetensors");
    for preset in kinds() {
        let mut straight = trainer(&preset);
        let mut killed = trainer(&preset);
        for _ in 0..3 {
            straight.iterate(2).expect("iterates");
            killed.iterate(2).expect("iterates");
        }
        killed.save(&path).expect("saves");
        drop(killed);
        let mut resumed = trainer(&preset);
        resumed.resume(&Checkpoint::load(&path).expect("reads")).expect("resumes");
        for _ in 0..3 {
            let a = straight.iterate(2).expect("iterates");
            let b = resumed.iterate(2).expect("iterates");
            assert_eq!((a.iteration, a.samples), (b.iteration, b.samples));
            assert_eq!(a.loss, b.loss);
        }
        assert_eq!(weights(&straight), weights(&resumed));
    }
}

/// A trainer after an iteration, which has written its checkpoint.
pub(crate) fn saved(preset: &RunPreset, path: &Path) -> Trainer<Toy> {
    let mut first = trainer(preset);
    first.iterate(1).expect("iterates");
    first.save(path).expect("saves");
    first
}

#[test]
fn a_checkpoint_of_another_run_is_refused_with_the_reason() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("model.safetensors");
    let preset = Toy::preset(&[]);
    saved(&preset, &path);
    let checkpoint = Checkpoint::load(&path).expect("reads");
    let refuse = |trainer: &mut Trainer<Toy>| {
        let before = weights(trainer);
        let error = trainer.resume(&checkpoint).expect_err("refused").to_string();
        assert_eq!(weights(trainer), before, "a refused checkpoint changes nothing");
        error
    };
    let mut other = Trainer::new(&preset, Toy::shards(&preset), vec!["kick".to_owned()]).expect("trainer");
    let error = refuse(&mut other);
    assert!(error.contains("kick") && error.contains("toy"), "{error}");
    let error = refuse(&mut trainer(&Toy::preset(&["run.shards=8"])));
    assert!(error.contains("run.shards"), "{error}");
    let error = refuse(&mut trainer(&Toy::preset(&["learn.actor.hidden=[16]"])));
    assert!(error.contains("learn.actor.hidden: expected [16], found [8]"), "{error}");
    let error = refuse(&mut trainer(&Toy::preset(&["learn.ppo.learning_rate=0.5"])));
    assert!(
        error.contains("model.safetensors: learn.ppo.learning_rate: expected 0.5, found 0.001"),
        "{error}"
    );
    fs::write(folder.path().join(checkpoint_name(1)), b"not a checkpoint").expect("write");
    let error = load_weights(folder.path()).expect_err("refused").to_string();
    assert!(error.contains("model_1.safetensors"), "{error}");
}

#[test]
fn a_checkpoint_of_an_earlier_version_with_the_same_preset_continues() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("model.safetensors");
    let preset = Toy::preset(&[]);
    let first = saved(&preset, &path);
    let text = preset.to_toml().expect("writes");
    let fewer = text.replace("align_yaw = true\n", "");
    assert_ne!(text, fewer);
    for text in [text.as_str(), fewer.as_str(), "[run]\nwalkers = 4\n"] {
        let mut checkpoint = Checkpoint::load(&path).expect("reads");
        checkpoint.set_blob("preset.toml", text.as_bytes());
        let longer = Toy::preset(&["run.iterations=9", "learn.ppo.epochs=3"]);
        let mut resumed = trainer(&longer);
        resumed.resume(&checkpoint).expect(text);
        assert_eq!(weights(&resumed), weights(&first));
    }
}

#[test]
fn a_checkpoint_whose_preset_turns_on_what_there_is_not_says_what_to_do() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("model.safetensors");
    let preset = Toy::preset(&[]);
    let text = preset.to_toml().expect("writes");
    let old = text.replace("[task.observations]", "[task.observations]\nlead_ball = true");
    assert_ne!(text, old);
    let trainer = trainer(&preset);
    let expected =
        ["model.safetensors: preset preset.toml: task.observations.lead_ball = true", "train again"];
    let damaged = ["model.safetensors: preset preset.toml", "walkers"];
    for (text, parts) in [(old.as_str(), expected), ("[run]\nwalkers = 4\n", damaged)] {
        trainer.learner().save(&path, &[("preset.toml", text.as_bytes())]).expect("saves");
        let checkpoint = Checkpoint::load(&path).expect("reads");
        let error = RunPreset::of_checkpoint(&checkpoint).expect_err("refused").to_string();
        for part in parts {
            assert!(error.contains(part), "{part}: {error}");
        }
    }
}

#[test]
fn a_reward_that_is_not_finite_is_counted_and_the_run_continues() {
    let preset = Toy::preset(&[]);
    let mut shards = Toy::shards(&preset);
    shards[2].broken = true;
    let mut trainer = Trainer::new(&preset, shards, Vec::new()).expect("trainer");
    let record = trainer.iterate(2).expect("iterates");
    assert_eq!(record.nan_samples, preset.learn.ppo.horizon as u64);
    assert!(trainer.learner().actor().params.iter().all(|x| x.is_finite()));
}

pub(crate) fn run(out: &Path, preset: &RunPreset, resume: bool, stop_after: u64) -> Outcome {
    run_from(out, preset, if resume { Start::Resume } else { Start::Fresh }, stop_after)
}

pub(crate) fn run_from(out: &Path, preset: &RunPreset, start: Start, stop_after: u64) -> Outcome {
    let job = StageJob {
        preset: preset.clone(),
        out: out.to_owned(),
        start,
        limits: Limits::default(),
        threads: 2,
        ranks: Arc::new(Alone),
    };
    let stop = AtomicBool::new(false);
    let mut report = |record: &crate::Record| {
        if record.iteration == stop_after {
            stop.store(true, Ordering::SeqCst);
        }
    };
    run_stage(&job, &|preset| Ok(trainer(preset)), &stop, &mut report, None).expect("runs")
}

/// Reads what it is given, as an evaluator does, and remembers how often.
struct Reader(Vec<Vec<f32>>);

impl Judge for Reader {
    fn score(&mut self, policy: &Path) -> Named {
        self.0.push(Checkpoint::load(policy).expect("reads").policy().expect("policy").params);
        Named(vec![("mujoco_goal".to_owned(), self.0.len() as f64)])
    }
}

#[test]
fn evaluations_come_as_often_as_the_preset_says_and_do_not_change_the_weights() {
    let folder = tempfile::tempdir().expect("folder");
    let preset = Toy::preset(&["run.judge.every_iterations=2"]);
    let (alone, watched) = (folder.path().join("alone"), folder.path().join("watched"));
    let plain = run(&alone, &preset, false, u64::MAX);
    let job = StageJob {
        preset,
        out: watched.clone(),
        start: Start::Fresh,
        limits: Limits::default(),
        threads: 2,
        ranks: Arc::new(Alone),
    };
    let mut judge = Reader(Vec::new());
    let build = |preset: &RunPreset| Ok(trainer(preset));
    let stop = AtomicBool::new(false);
    let judged = run_stage(&job, &build, &stop, &mut |_| {}, Some(&mut judge)).expect("runs");
    let params = |outcome: &Outcome| {
        Checkpoint::load(&outcome.checkpoint).expect("reads").policy().expect("policy").params
    };
    assert_eq!(params(&plain), params(&judged));
    assert_eq!(judge.0.len(), 3);
    assert_eq!(judge.0[2], params(&judged), "the evaluator sees the policy of the iteration");
    let lines = fs::read_to_string(watched.join(METRICS_FILE)).expect("metrics");
    let scores: Vec<Option<f64>> = lines
        .lines()
        .map(|line| serde_json::from_str::<serde_json::Value>(line).expect("json"))
        .map(|line| line["judge"]["mujoco_goal"].as_f64())
        .collect();
    assert_eq!(scores, [None, Some(1.0), None, Some(2.0), None, Some(3.0)]);
    assert!(lines.contains("\"seconds\":"));
    assert!(!watched.join("judged.safetensors").exists());
}

#[test]
fn a_stopped_run_saves_and_its_continuation_equals_an_uninterrupted_run() {
    let folder = tempfile::tempdir().expect("folder");
    let noise = ["learn.ppo.max_std=0.4", "learn.ppo.final_std=0.1"];
    let preset = Toy::preset(&[&["run.keep_checkpoints=2"], &noise[..]].concat());
    let (straight, stopped) = (folder.path().join("straight"), folder.path().join("stopped"));
    let whole = run(&straight, &preset, false, u64::MAX);
    assert_eq!((whole.end, whole.iteration, whole.samples), (End::Done, 6, 6 * 64 * 24));
    let kept: Vec<u64> = checkpoints(&straight).expect("list").iter().map(|c| c.0).collect();
    assert_eq!(kept, [4, 6]);

    let first = run(&stopped, &preset, false, 3);
    assert_eq!((first.end, first.iteration), (End::Stopped, 3));
    assert!(stopped.join(checkpoint_name(3)).exists());
    let second = run(&stopped, &preset, true, u64::MAX);
    assert_eq!((second.end, second.iteration, second.samples), (End::Done, 6, whole.samples));

    let policy = |outcome: &Outcome| {
        let checkpoint = Checkpoint::load(&outcome.checkpoint).expect("reads");
        checkpoint.policy().expect("policy").params
    };
    assert_eq!(policy(&whole), policy(&second));
    let checkpoint = Checkpoint::load(&whole.checkpoint).expect("reads");
    let std = checkpoint.policy().expect("policy").std;
    // Five of six iterations were over when the last one began: two thirds of the way from 0.4 to 0.1.
    let limit = 0.4 * 0.25_f32.powf(2.0 / 3.0);
    assert!(std.iter().all(|std| *std < 1.001 * limit), "{std:?}, {limit}");
    let lines = fs::read_to_string(stopped.join(METRICS_FILE)).expect("metrics");
    let iterations: Vec<u64> = lines
        .lines()
        .map(|line| serde_json::from_str::<serde_json::Value>(line).expect("json")["iteration"].as_u64())
        .map(|i| i.expect("number"))
        .collect();
    assert_eq!(iterations, [1, 2, 3, 4, 5, 6]);
}

#[test]
fn a_full_checkpoint_continues_as_before_once_it_records_how_it_is_played() {
    let folder = tempfile::tempdir().expect("folder");
    let preset = Toy::preset(&[]);
    let whole = run(&folder.path().join("straight"), &preset, false, u64::MAX);
    let out = folder.path().join("stopped");
    let file = run(&out, &preset, false, 3).checkpoint;
    let load = |path: &Path| Checkpoint::load(path).expect("reads");
    let before = load(&file);
    let contact_s = [("kick".to_owned(), 1.25)].into();
    let play = PlayContract { contact_s, mirror_left_kicks: true, where_it_lay: None };
    write_play(&file, play.clone()).expect("writes");
    let after = load(&file);
    assert_eq!(RunPreset::of_checkpoint(&after).expect("a preset").task.play(), play);
    let rest = |checkpoint: &Checkpoint| {
        let mut tensors = checkpoint.tensors().tensors.clone();
        tensors.remove("blob.preset.toml").expect("a preset");
        tensors
    };
    assert!(rest(&before) == rest(&after), "nothing else changes");
    let resumed = run(&out, &preset, true, u64::MAX);
    let params = |outcome: &Outcome| load(&outcome.checkpoint).policy().expect("policy").params;
    assert_eq!(params(&whole), params(&resumed));
}

#[test]
fn a_run_goes_through_its_phases_and_one_stopped_between_them_ends_in_the_same_weights() {
    for memory in [&[][..], &["learn.actor.kind=lstm", "learn.critic.kind=lstm"]] {
        phases_end_to_end(&Toy::preset(&[&["run.checkpoint_interval=100"], memory].concat()));
    }
}

fn phases_end_to_end(preset: &RunPreset) {
    let folder = tempfile::tempdir().expect("folder");
    let mut preset = preset.clone();
    let plain = run(&folder.path().join("plain"), &preset, false, u64::MAX);
    let values = "[learn.ppo]\nfinal_std = 0.02".parse().expect("toml");
    preset.phases.push(Phase { from: 0.5, values });
    let values = "[learn.ppo]\ngamma = 0.5".parse().expect("toml");
    preset.phases.push(Phase { from: 0.8, values });
    let (straight, stopped) = (folder.path().join("straight"), folder.path().join("stopped"));
    let whole = run(&straight, &preset, false, u64::MAX);
    // After the first iteration; the second phase begins where three of six are over, the third where five are.
    let kept: Vec<u64> = checkpoints(&straight).expect("list").iter().map(|c| c.0).collect();
    assert_eq!(kept, [1, 3, 5, 6]);
    let lines = fs::read_to_string(straight.join(METRICS_FILE)).expect("metrics");
    let phases: Vec<f64> = lines
        .lines()
        .map(|line| serde_json::from_str::<serde_json::Value>(line).expect("json"))
        .map(|line| line["metrics"]["phase"].as_f64().expect("phase"))
        .collect();
    assert_eq!(phases, [0.0, 0.0, 0.0, 1.0, 1.0, 2.0]);

    assert_eq!(run(&stopped, &preset, false, 4).iteration, 4);
    let resumed = run(&stopped, &preset, true, u64::MAX);
    let load = |outcome: &Outcome| Checkpoint::load(&outcome.checkpoint).expect("reads");
    let weights = |outcome: &Outcome| load(outcome).policy().expect("policy").params;
    assert_eq!(weights(&whole), weights(&resumed));
    assert_ne!(weights(&whole), weights(&plain));
    assert!(load(&whole).policy().expect("policy").std.iter().all(|std| *std < 0.05));
    // The checkpoint says what held when it was written; the folder keeps the whole plan.
    let last = RunPreset::of_checkpoint(&load(&whole)).expect("reads");
    assert_eq!((last.learn.ppo.gamma, last.phases.len()), (0.5, 0));
    assert_eq!(RunPreset::of_run(&straight, &[]).expect("reads"), preset);
}

#[test]
fn a_line_of_the_log_has_the_gates_of_a_recurrent_network() {
    let gates = |preset: &RunPreset| {
        let metrics = trainer(preset).iterate(1).expect("iterates").metrics;
        let gates = metrics.0.into_iter().filter(|(name, _)| name.starts_with("gates/"));
        gates.collect::<Vec<_>>()
    };
    let [plain, recurrent, beside] = kinds().map(|preset| gates(&preset));
    assert_eq!((plain.len(), recurrent.len(), beside.len()), (0, 4, 2));
    let [(saturated, share), (rms, size)] = &beside[..] else { panic!("{beside:?}") };
    assert_eq!((saturated.as_str(), rms.as_str()), ("gates/actor_saturated", "gates/actor_weight_rms"));
    assert!((0.0..1.0).contains(share) && (0.01..0.1).contains(size), "{beside:?}");
}

#[test]
fn training_improves_the_toy() {
    let preset = Toy::preset(&["run.envs=256", "run.iterations=40", "learn.ppo.entropy=0"]);
    let mut trainer = trainer(&preset);
    let first = trainer.iterate(2).expect("iterates").mean_reward;
    let mut last = first;
    for _ in 1..40 {
        last = trainer.iterate(2).expect("iterates").mean_reward;
    }
    assert!(last > 0.5 * first, "mean return {first} became {last}");
}

#[test]
fn environments_without_sides_cannot_train_a_symmetric_policy() {
    let mut preset = Toy::preset(&[]);
    preset.learn.ppo.mirror.weight = 0.1;
    let error = Trainer::new(&preset, Toy::shards(&preset), Vec::new()).err().expect("no image").to_string();
    assert!(error.contains("learn.ppo.mirror: these environments have no mirror image"), "{error}");
}
