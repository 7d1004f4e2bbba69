//! A resumed run equals one that was not stopped; files that do not fit are refused with one clear error.

use std::fs;

use crate::common::{PointMass, Recall};
use paid_learn::{
    Checkpoint, LearnConfig, Learner, LstmConfig, NetworkConfig, NetworkKind, PpoConfig, VecEnv,
};
use paid_policy::Policy;
use paid_policy::normalizer::Normalizer;

fn config(kind: NetworkKind, hidden: &[usize]) -> LearnConfig {
    let network = NetworkConfig {
        kind,
        hidden: hidden.to_vec(),
        lstm: LstmConfig { layers: 2, size: 6, inputs: 0 },
        ..NetworkConfig::default()
    };
    LearnConfig {
        actor: network.clone(),
        critic: network,
        ppo: PpoConfig { horizon: 8, minibatches: 2, block: 32, sequence_block: 16, ..PpoConfig::default() },
        ..LearnConfig::default()
    }
}

fn recalls() -> Vec<Box<dyn VecEnv>> {
    [20, 33].iter().map(|&n| Box::new(Recall::new(n, n as u64)) as Box<dyn VecEnv>).collect()
}

fn weights(learner: &Learner) -> Vec<u32> {
    learner.actor().params.iter().chain(&learner.critic().params).map(|x| x.to_bits()).collect()
}

#[test]
fn a_resumed_run_ends_in_the_same_weights() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.safetensors");
    for kind in [NetworkKind::Mlp, NetworkKind::Lstm, NetworkKind::Memory] {
        let config = config(kind, &[8]);
        let mut whole = Learner::new(2, 2, 1, &config, 4).unwrap();
        let mut envs = recalls();
        for _ in 0..3 {
            whole.iterate(&mut envs, 2).unwrap();
        }
        let states: Vec<Vec<u8>> = envs.iter().map(|env| env.save()).collect();
        whole.save(&path, &[("env.0", &states[0]), ("env.1", &states[1])]).unwrap();
        for _ in 0..3 {
            whole.iterate(&mut envs, 2).unwrap();
        }

        let checkpoint = Checkpoint::load(&path).unwrap();
        assert_eq!(checkpoint.blob_names(), ["env.0", "env.1"]);
        // Another seed on purpose: the checkpoint brings its own.
        let mut resumed = Learner::new(2, 2, 1, &config, 77).unwrap();
        resumed.restore(&checkpoint).unwrap();
        assert_eq!(resumed.iteration(), 3);
        let mut envs = recalls();
        for (k, env) in envs.iter_mut().enumerate() {
            env.restore(checkpoint.blob(&format!("env.{k}")).unwrap()).unwrap();
        }
        for _ in 0..3 {
            resumed.iterate(&mut envs, 1).unwrap();
        }
        assert_eq!(weights(&whole), weights(&resumed), "{kind:?}");
        assert_eq!(whole.learning_rate(), resumed.learning_rate());
    }
}

#[test]
fn a_policy_from_a_checkpoint_acts_like_the_learners() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("policy.safetensors");
    let mut learner = Learner::new(2, 2, 1, &config(NetworkKind::Lstm, &[8]), 4).unwrap();
    learner.iterate(&mut recalls(), 1).unwrap();
    learner.save(&path, &[]).unwrap();
    let policies = [learner.policy(), Checkpoint::load(&path).unwrap().policy().unwrap()];
    let mut actions = [[0.0; 3], [0.0; 3]];
    for (policy, actions) in policies.iter().zip(&mut actions) {
        let mut state = policy.start(3);
        for step in 0..4 {
            let obs: Vec<f32> = (0..6).map(|k| (k * step) as f32 * 0.1).collect();
            policy.act(&obs, &mut state, actions);
        }
    }
    assert_eq!(actions[0], actions[1]);
    assert!(actions[0].iter().any(|&a| a != 0.0));
    assert_eq!(policies[0].std, policies[1].std);
}

#[test]
fn weights_alone_start_a_next_stage() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("stage1.safetensors");
    let config = config(NetworkKind::Mlp, &[8]);
    let mut first = Learner::new(2, 2, 1, &config, 4).unwrap();
    first.iterate(&mut recalls(), 1).unwrap();
    first.save(&path, &[]).unwrap();
    let mut second = Learner::new(2, 2, 1, &config, 5).unwrap();
    second.load_weights(&Checkpoint::load(&path).unwrap()).unwrap();
    assert_eq!(weights(&first), weights(&second));
    assert_eq!(second.iteration(), 0);
    assert_eq!(second.learning_rate(), 1e-3);
    second.set_std(0.25).unwrap();
    assert!(second.policy().std.iter().all(|std| (std - 0.25).abs() < 1e-6));
    assert!(second.set_std(-1.0).is_err());
}

#[test]
fn a_checkpoint_of_another_architecture_is_refused_and_changes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("other.safetensors");
    Learner::new(2, 2, 1, &config(NetworkKind::Mlp, &[8]), 4).unwrap().save(&path, &[]).unwrap();
    let checkpoint = Checkpoint::load(&path).unwrap();
    let mut learner = Learner::new(2, 2, 1, &config(NetworkKind::Mlp, &[9]), 4).unwrap();
    let before = weights(&learner);
    let error = learner.restore(&checkpoint).unwrap_err().to_string();
    assert!(error.contains("other.safetensors: checkpoint of another architecture"), "{error}");
    assert!(error.contains("actor.mlp.0.weight: expected F32 [9, 2], found F32 [8, 2]"), "{error}");
    let mut recurrent = Learner::new(2, 2, 1, &config(NetworkKind::Lstm, &[8]), 4).unwrap();
    let error = recurrent.load_weights(&checkpoint).unwrap_err().to_string();
    assert!(error.contains("lstm.0.weight_ih") && error.contains("found none"), "{error}");
    assert_eq!(before, weights(&learner));
}

#[test]
fn files_that_are_no_checkpoints_are_refused_and_a_failed_write_leaves_the_old_one() {
    let folder = tempfile::tempdir().unwrap();
    let missing = Checkpoint::load(&folder.path().join("none")).unwrap_err().to_string();
    assert!(missing.contains("cannot read"), "{missing}");
    let path = folder.path().join("broken");
    fs::write(&path, b"not a checkpoint").unwrap();
    let broken = Checkpoint::load(&path).unwrap_err().to_string();
    assert!(broken.contains("broken: not a checkpoint"), "{broken}");

    let learner = Learner::new(3, 2, 1, &config(NetworkKind::Mlp, &[8]), 4).unwrap();
    let path = folder.path().join("good");
    learner.save(&path, &[]).unwrap();
    let mut bytes = fs::read(&path).unwrap();
    let cut = bytes.len() - 5;
    bytes.truncate(cut);
    fs::write(folder.path().join("cut"), &bytes).unwrap();
    assert!(Checkpoint::load(&folder.path().join("cut")).is_err());
    // A folder in the file's place: the rename fails, and no temporary file stays.
    let taken = folder.path().join("taken");
    fs::create_dir(&taken).unwrap();
    fs::write(taken.join("inside"), b"x").unwrap();
    let error = learner.save(&taken, &[]).unwrap_err().to_string();
    assert!(error.contains("taken: cannot write"), "{error}");
    assert!(taken.join("inside").exists());
    let left: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert!(!left.iter().any(|name| name.to_string_lossy().contains(".part")), "{left:?}");
}

#[test]
fn weights_that_are_not_finite_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("nan");
    let mut learner = Learner::new(2, 3, 1, &config(NetworkKind::Mlp, &[8]), 4).unwrap();
    learner.save(&path, &[]).unwrap();
    let mut file = paid_policy::tensor_file::TensorFile::load(&path).unwrap();
    file.put_f32s("critic.mlp.1.bias", &[1], &[f32::NAN]);
    file.save().unwrap();
    let error = learner.load_weights(&Checkpoint::load(&path).unwrap()).unwrap_err().to_string();
    assert!(error.contains("critic.mlp.1.bias: element 0: expected a finite number"), "{error}");
    let mut env: Vec<Box<dyn VecEnv>> = vec![Box::new(PointMass::new(16, 0))];
    learner.iterate(&mut env, 1).unwrap();
}

#[test]
fn the_mean_of_two_checkpoints_has_the_mean_of_their_weights() {
    let folder = tempfile::tempdir().unwrap();
    let mut learner = Learner::new(2, 2, 1, &config(NetworkKind::Lstm, &[8]), 4).unwrap();
    let mut envs = recalls();
    let mut saved = Vec::new();
    for k in 0..2 {
        learner.iterate(&mut envs, 2).unwrap();
        let path = folder.path().join(format!("{k}.safetensors"));
        learner.save(&path, &[("preset", b"x")]).unwrap();
        saved.push(Checkpoint::load(&path).unwrap());
    }
    let mean = saved[1].mean_with(&saved[..1]).unwrap();
    assert_eq!(mean.blob("preset"), Some(&b"x"[..]));
    let [a, b, m] = [&saved[0], &saved[1], &mean].map(|checkpoint| checkpoint.policy().unwrap());
    for ((a, b), m) in a.params.iter().zip(&b.params).zip(&m.params) {
        assert!((0.5 * (a + b) - m).abs() <= 1e-7 * (1.0 + m.abs()), "{a}, {b}: {m}");
    }
    assert!(a.params != b.params && (0.5 * (a.std[0].ln() + b.std[0].ln()) - m.std[0].ln()).abs() < 1e-6);
    // A mean can be started from, not resumed; another architecture is refused.
    learner.load_weights(&mean).unwrap();
    assert!(learner.restore(&mean).is_err());
    let other = Learner::new(2, 2, 1, &config(NetworkKind::Lstm, &[9]), 4).unwrap();
    let path = folder.path().join("other.safetensors");
    other.save(&path, &[]).unwrap();
    let error = mean.mean_with(&[Checkpoint::load(&path).unwrap()]).unwrap_err().to_string();
    assert!(error.contains("other.safetensors: checkpoint of another architecture"), "{error}");
}

#[test]
fn a_deeper_networks_checkpoint_is_refused_though_all_that_both_have_fits() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deep.safetensors");
    let deep = config(NetworkKind::Lstm, &[8]);
    Learner::new(2, 2, 1, &deep, 4).unwrap().save(&path, &[]).unwrap();
    let mut shallow = deep.clone();
    for network in [&mut shallow.actor, &mut shallow.critic] {
        network.lstm.layers = 1;
    }
    let mut learner = Learner::new(2, 2, 1, &shallow, 4).unwrap();
    let before = weights(&learner);
    let error = learner.load_weights(&Checkpoint::load(&path).unwrap()).unwrap_err().to_string();
    assert!(error.contains("actor.lstm.1.") && error.contains("expected none, found F32"), "{error}");
    assert_eq!(before, weights(&learner));
}

#[test]
fn a_learner_that_forgot_its_shards_can_be_saved() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("between.safetensors");
    let mut learner = Learner::new(2, 2, 1, &config(NetworkKind::Lstm, &[8]), 4).unwrap();
    learner.iterate(&mut recalls(), 1).unwrap();
    learner.forget();
    learner.save(&path, &[]).unwrap();
    assert_eq!(Checkpoint::load(&path).unwrap().policy().unwrap().params, learner.policy().params);
}

/// Over four steps two policies take the same action, of which the second sees what `other` makes of the first one's observation.
fn act_alike(one: &Policy, two: &Policy, other: impl Fn([f32; 2]) -> Vec<f32>, name: &str) {
    let (mut memory, mut other_memory) = (one.start(1), two.start(1));
    for step in 0..4_i16 {
        let seen = [0.3 * f32::from(step), 1.0 - f32::from(step)];
        let (mut expected, mut found) = ([0.0], [0.0]);
        one.act(&seen, &mut memory, &mut expected);
        two.act(&other(seen), &mut other_memory, &mut found);
        let same = expected[0] != 0.0 && (expected[0] - found[0]).abs() < 1e-6;
        assert!(same, "{name} {step}: {expected:?} {found:?}");
    }
}

#[test]
fn a_policy_with_new_inputs_does_what_it_did() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("two.safetensors");
    for kind in [NetworkKind::Mlp, NetworkKind::Lstm, NetworkKind::Memory] {
        let config = config(kind, &[8]);
        let mut learner = Learner::new(2, 2, 1, &config, 4).unwrap();
        learner.iterate(&mut recalls(), 2).unwrap();
        learner.save(&path, &[("preset", b"x")]).unwrap();
        let before = Checkpoint::load(&path).unwrap();
        let after = before.with_policy_inputs(&[None, Some(1), None, Some(0)]).unwrap();
        assert_eq!((after.meta().policy_obs, after.blob("preset")), (4, Some(&b"x"[..])));
        let (one, two) = (before.policy().unwrap(), after.policy().unwrap());
        act_alike(&one, &two, |[a, b]| vec![5.0, b, -7.0, a], &format!("{kind:?}"));
        // The critic's inputs are the same; what was for resuming is gone.
        let mut next = Learner::new(4, 2, 1, &config, 9).unwrap();
        next.load_weights(&after).unwrap();
        assert_eq!(next.critic().params, learner.critic().params);
        assert!(next.restore(&after).is_err());
        // New inputs learn from their own beginning on: the normalizer takes them for normalized.
        let normalizer = after.normalizer("policy", 4).unwrap();
        assert_eq!(normalizer.mean()[0], 0.0);
        assert!((normalizer.inv_std()[0] - 1.0 / 1.01).abs() < 1e-6);
    }
}

#[test]
fn a_memory_beside_the_input_starts_from_a_network_without_one_and_does_what_it_did() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mlp.safetensors");
    let mut first = Learner::new(2, 2, 1, &config(NetworkKind::Mlp, &[8, 6]), 4).unwrap();
    first.iterate(&mut recalls(), 1).unwrap();
    first.save(&path, &[]).unwrap();
    let checkpoint = Checkpoint::load(&path).unwrap();
    let mut with = config(NetworkKind::Memory, &[8, 6]);
    with.actor.lstm.inputs = 1;
    with.critic.kind = NetworkKind::Mlp;
    let mut second = Learner::new(2, 2, 1, &with, 5).unwrap();
    let fresh = second.policy();
    second.load_weights(&checkpoint).unwrap();
    let (before, after) = (first.policy(), second.policy());
    let (mut none, mut memory) = (before.start(3), after.start(3));
    let mut actions = [[0.0; 3], [0.0; 3]];
    for step in 0..4 {
        let obs: Vec<f32> = (0..6).map(|k| (k * step) as f32 * 0.1 - 0.3).collect();
        before.act(&obs, &mut none, &mut actions[0]);
        after.act(&obs, &mut memory, &mut actions[1]);
        assert!(actions[0].iter().zip(&actions[1]).all(|(a, b)| (a - b).abs() < 1e-6), "{actions:?}");
    }
    assert_eq!((&before.std, &first.critic().params), (&after.std, &second.critic().params));
    assert_eq!(before.normalizer.mean(), after.normalizer.mean());
    // Its memory is a fresh one, which runs and will be listened to.
    let lstm = after.net.lstm[0].weight_ih.clone();
    assert_eq!(after.params[lstm.clone()], fresh.params[lstm.clone()]);
    assert!(memory.recurrent.h[0].iter().any(|h| *h != 0.0));
    for _ in 0..2 {
        second.iterate(&mut recalls(), 1).unwrap();
    }
    let listened = &second.actor().params[after.net.mlp[0].weight.clone()];
    assert!(listened.chunks(8).all(|row| row[2..].iter().all(|w| *w != 0.0)));
    assert_ne!(second.actor().params[lstm.clone()], fresh.params[lstm]);
    // A run is continued by its own kind alone, and other widths are no start.
    let error = second.restore(&checkpoint).unwrap_err().to_string();
    assert!(error.contains("lstm.0.weight_ih") && error.contains("found none"), "{error}");
    with.actor.hidden = vec![9, 6];
    let mut wider = Learner::new(2, 2, 1, &with, 5).unwrap();
    let error = wider.load_weights(&checkpoint).unwrap_err().to_string();
    assert!(error.contains("actor.mlp.0.weight: expected F32 [9, 2], found F32 [8, 2]"), "{error}");
}

#[test]
fn a_policy_without_its_critic_is_a_start_and_the_critic_a_new_one() {
    for kind in [NetworkKind::Mlp, NetworkKind::Lstm, NetworkKind::Memory] {
        let config = config(kind, &[8]);
        let mut learner = Learner::new(2, 2, 1, &config, 4).unwrap();
        learner.iterate(&mut recalls(), 2).unwrap();
        let mut policy = learner.policy();
        let (mean, inv_std) = (policy.normalizer.mean().to_vec(), policy.normalizer.inv_std().to_vec());
        policy.normalizer = Normalizer::frozen(mean, inv_std); // as a policy file has it
        let start =
            Checkpoint::of_policy(&policy, [&config.actor, &config.critic], "p.onnx".as_ref()).unwrap();
        assert!(!start.has_critic());
        let mut next = Learner::new(2, 2, 1, &config, 9).unwrap();
        let critic = next.critic().params.clone();
        next.load_weights(&start).unwrap();
        assert_eq!((next.critic().params.clone(), next.policy().std), (critic, policy.std.clone()));
        act_alike(&policy, &next.policy(), |seen| seen.to_vec(), &format!("{kind:?}"));
        // Some samples more hardly move the normalizer, and a run does not continue without a critic.
        next.iterate(&mut recalls(), 1).unwrap();
        let moved = next.policy().normalizer.mean()[0] - policy.normalizer.mean()[0];
        assert!(moved.abs() < 1e-4, "{moved}");
        assert!(next.restore(&start).is_err());
        let other = NetworkConfig { hidden: vec![7], ..config.actor.clone() };
        let error = Checkpoint::of_policy(&policy, [&other, &other], "p.onnx".as_ref()).unwrap_err();
        assert!(error.to_string().contains("p.onnx: checkpoint of another architecture"), "{error}");
    }
}

#[test]
fn a_memory_keeps_its_features_in_another_order_or_says_that_it_cannot() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("memory.safetensors");
    let mut config = config(NetworkKind::Memory, &[8]);
    config.actor.lstm.inputs = 1;
    let mut learner = Learner::new(2, 2, 1, &config, 4).unwrap();
    learner.iterate(&mut recalls(), 2).unwrap();
    learner.save(&path, &[]).unwrap();
    let before = Checkpoint::load(&path).unwrap();
    let after = before.with_policy_inputs(&[Some(0), None, Some(1)]).unwrap();
    let (one, two) = (before.policy().unwrap(), after.policy().unwrap());
    act_alike(&one, &two, |[a, b]| vec![a, 5.0, b], "memory");
    let error = before.with_policy_inputs(&[Some(1), Some(0)]).unwrap_err().to_string();
    assert!(error.contains("the 1 features that its memory reads at the end"), "{error}");
}

#[test]
fn a_memory_that_reads_more_than_is_observed_is_refused() {
    let mut config = config(NetworkKind::Memory, &[8]);
    config.actor.lstm.inputs = 3;
    let error = Learner::new(2, 3, 1, &config, 4).unwrap_err().to_string();
    assert_eq!(error, "actor.lstm.inputs: expected no more than are observed, found 3 of 2");
}
