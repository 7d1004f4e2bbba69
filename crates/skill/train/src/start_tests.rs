//! What a run begins with: the policy of another run, or a policy alone.

use std::path::Path;

use paid_learn::Checkpoint;
use paid_play::POLICY_FILE;
use paid_policy::{NetworkKind, PlayContract};

use crate::folder::checkpoint_name;
use crate::policy_file::tests::trained;
use crate::policy_file::{TrainedPolicy, run_name};
use crate::policy_weights::{load_mean, load_weights, write_play, write_weights};
use crate::run_tests::{run, run_from, saved, trainer, weights};
use crate::toy::Toy;
use crate::{RunPreset, Start, Trainer};

#[test]
fn a_memory_beside_the_input_begins_as_the_policy_without_one() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("model.safetensors");
    // Each of these terms is one number of the toy; the memory reads the second.
    let terms = |list: &str| format!("task.observations.policy={list}");
    let first = saved(&Toy::preset(&[&terms(r#"["joint_pos_rel", "joint_vel"]"#)]), &path);
    let turned = terms(r#"["joint_vel", "joint_pos_rel"]"#);
    let lstm = "learn.actor.lstm={ layers = 1, size = 4, inputs = 1 }";
    let mut second = trainer(&Toy::preset(&[&turned, "learn.actor.kind=memory", lstm]));
    second.start_from(&Checkpoint::load(&path).expect("reads")).expect("starts");
    let [before, after] = [&first, &second].map(|trainer| trainer.learner().policy());
    let (mut none, mut memory) = (before.start(1), after.start(1));
    let [mut expected, mut found] = [[0.0], [0.0]];
    for [a, b] in [[0.1, 0.9], [-0.4, 0.3], [0.5, 0.2]] {
        before.act(&[a, b], &mut none, &mut expected);
        after.act(&[b, a], &mut memory, &mut found);
        assert!(expected[0] != 0.0 && (expected[0] - found[0]).abs() < 1e-6, "{expected:?} {found:?}");
    }
    assert_eq!(before.std, after.std);
    second.iterate(2).expect("iterates");
    second.save(&path).expect("saves");
    let mut third = trainer(&Toy::preset(&[&turned, "learn.actor.kind=memory", lstm]));
    third.start_from(&Checkpoint::load(&path).expect("reads")).expect("starts");
    assert_eq!(weights(&third), weights(&second));
}

#[test]
fn a_stage_with_a_new_ball_begins_with_its_own_noise_or_keeps_the_earlier_one() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("model.safetensors");
    let first = saved(&Toy::preset(&["learn.ppo.initial_std=0.3"]), &path).learner().policy().std;
    let mut preset = Toy::preset(&["learn.ppo.initial_std=0.2"]);
    preset.task.scene.ball = true;
    for (keep, expected) in [(false, vec![0.2]), (true, first)] {
        preset.learn.ppo.keep_std = keep;
        let mut second = trainer(&preset);
        second.start_from(&Checkpoint::load(&path).expect("reads")).expect("starts");
        let found = second.learner().policy().std;
        assert!((found[0] - expected[0]).abs() < 1e-6, "{keep}: {found:?} {expected:?}");
    }
}

#[test]
fn a_policy_begins_with_its_terms_in_another_order() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("model.safetensors");
    // The toy's one action is a joint, so that each of these terms is one number.
    let of = |a: &str, b: &str| {
        let terms = format!("task.observations.policy=[\"{a}\", \"{b}\"]");
        trainer(&Toy::preset(&[terms.as_str()]))
    };
    let rows = |trainer: &Trainer<Toy>| -> Vec<[f32; 2]> {
        trainer.learner().actor().params[..16].chunks_exact(2).map(|row| [row[0], row[1]]).collect()
    };
    let mean = |trainer: &Trainer<Toy>| trainer.learner().policy().normalizer.mean().to_vec();
    let mut first = of("joint_pos_rel", "joint_vel");
    first.iterate(1).expect("iterates");
    first.save(&path).expect("saves");
    let checkpoint = Checkpoint::load(&path).expect("reads");

    let mut turned = of("joint_vel", "joint_pos_rel");
    turned.start_from(&checkpoint).expect("the same terms");
    let expected: Vec<[f32; 2]> = rows(&first).into_iter().map(|[a, b]| [b, a]).collect();
    assert_eq!(rows(&turned), expected);
    assert_eq!(mean(&turned), [mean(&first)[1], mean(&first)[0]]);

    let mut replaced = of("joint_pos_rel", "last_action");
    replaced.start_from(&checkpoint).expect("one gives way to another");
    assert_eq!((rows(&replaced), mean(&replaced)), (rows(&first), mean(&first)));

    let error = of("joint_vel", "last_action").start_from(&checkpoint).expect_err("both").to_string();
    let expected = "model.safetensors: task.observations.policy: expected joint_vel, last_action, found \
                    joint_pos_rel, joint_vel; ";
    assert!(error.contains(expected), "{error}");
}

#[test]
fn a_run_starts_from_the_mean_of_the_last_checkpoints_of_another() {
    let folder = tempfile::tempdir().expect("folder");
    let first = folder.path().join("first");
    run(&first, &Toy::preset(&["run.average_last=0.5"]), false, u64::MAX);
    let params = |path: &Path| Checkpoint::load(path).expect("reads").policy().expect("policy").params;
    let [a, b] = [4, 6].map(|iteration| params(&first.join(checkpoint_name(iteration))));
    assert_ne!(a, b);
    let still = Toy::preset(&["learn.ppo.learning_rate=1e-12", "learn.ppo.adaptive_learning_rate=false"]);
    let next = run_from(&folder.path().join("next"), &still, Start::From(first), 1);
    for ((a, b), found) in a.iter().zip(&b).zip(params(&next.checkpoint)) {
        assert!((f32::midpoint(*a, *b) - found).abs() < 1e-6, "{a}, {b}: {found}");
    }
}

#[test]
fn a_policy_without_a_critic_is_no_start_without_a_teacher() {
    let preset = Toy::preset(&[]);
    let policy = trainer(&preset).learner().policy();
    let networks = [&preset.learn.actor, &preset.learn.critic];
    let mut alone = Checkpoint::of_policy(&policy, networks, "policy.onnx".as_ref()).expect("a policy");
    alone.set_blob("preset.toml", preset.to_toml().expect("writes").as_bytes());
    let error = trainer(&preset).start_from(&alone).expect_err("no critic").to_string();
    assert!(error.contains("policy.onnx: expected a critic, or a [teacher] in the preset"), "{error}");
}

#[test]
fn how_a_policy_is_played_belongs_to_the_policy_that_it_was_measured_of() {
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path().join("run");
    run(&out, &Toy::preset(&[]), false, 4);
    let weights = load_weights(&out).expect("a policy");
    // The toy is no robot, so that the file of a robot's policy stands in for the run's own.
    let mut trained = trained(NetworkKind::Mlp);
    trained.run = run_name(&RunPreset::of_checkpoint(&weights).expect("a preset"), weights.path());
    let file = out.join(POLICY_FILE);
    trained.write_onnx(&file, "none", None).expect("writes");
    let contacts = [("kick".to_owned(), 1.25)];
    let play = PlayContract { contact_s: contacts.into(), mirror_left_kicks: true, where_it_lay: None };
    write_play(&file, play.clone()).expect("writes");
    let read = TrainedPolicy::load(&file).expect("reads");
    assert_eq!((read.preset.task.play(), &read.policy.params), (play.clone(), &trained.policy.params));
    let plays = |weights: &Checkpoint| RunPreset::of_checkpoint(weights).expect("a preset").task.play();
    let of = |path: &Path| plays(&load_weights(path).expect("a policy"));
    assert_eq!(of(&out), play);
    assert_eq!(plays(&load_mean(&out, 2).expect("two checkpoints")), play, "export --average");
    let small = folder.path().join("small.safetensors");
    write_weights(&weights, &small).expect("writes");
    assert_eq!(
        Checkpoint::load(&small).expect("reads").policy().expect("policy").params,
        weights.policy().expect("policy").params
    );
    let error = load_weights(&file).expect_err("no critic").to_string();
    assert!(error.contains("policy.onnx: a policy file holds no critic"), "{error}");
    // Trained further, it meets the ball at other times.
    run(&out, &Toy::preset(&[]), true, u64::MAX);
    assert_eq!(of(&out), PlayContract::default());
}
