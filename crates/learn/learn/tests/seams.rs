//! What methods with rewards of their own (AMP) need of the learner: a further observation group, a reward that the learner
//! computes, a second critic.

#![expect(clippy::vec_box, reason = "the learner takes boxed environments")]

use crate::common::{PointMass, WithGroup};
use paid_learn::{
    LearnConfig, LearnedReward, Learner, LstmConfig, NetworkConfig, NetworkKind, PpoConfig, Ranks,
    RewardRole, Transitions, VecEnv,
};

fn config(kind: NetworkKind) -> LearnConfig {
    let network = NetworkConfig {
        kind,
        hidden: vec![16],
        lstm: LstmConfig { layers: 1, size: 6, inputs: 0 },
        ..NetworkConfig::default()
    };
    LearnConfig {
        actor: network.clone(),
        critic: network,
        ppo: PpoConfig { minibatches: 4, epochs: 4, block: 32, sequence_block: 16, ..PpoConfig::default() },
        ..LearnConfig::default()
    }
}

fn learner(kind: NetworkKind) -> Learner {
    Learner::new(2, 3, 1, &config(kind), 3).expect("valid")
}

fn with(kind: NetworkKind, reward: impl LearnedReward + 'static, role: RewardRole) -> Learner {
    learner(kind).with_learned_reward(Box::new(reward), role).expect("valid")
}

fn own_critic(kind: NetworkKind, task: f32, learned: f32) -> RewardRole {
    RewardRole::OwnCritic { task, learned, critic: config(kind).critic }
}

fn plain(shards: usize) -> Vec<Box<PointMass>> {
    (0..shards).map(|k| Box::new(PointMass::new(40, k as u64))).collect()
}

fn moving(shards: usize) -> Vec<Box<WithGroup>> {
    (0..shards).map(|k| Box::new(WithGroup(PointMass::new(40, k as u64), "motion"))).collect()
}

fn weights(learner: &Learner) -> Vec<u32> {
    let critic = &learner.critics()[0];
    learner.actor().params.iter().chain(&critic.params).map(|x| x.to_bits()).collect()
}

fn trained<E: VecEnv>(mut learner: Learner, mut envs: Vec<Box<E>>, threads: usize) -> Learner {
    for _ in 0..3 {
        learner.iterate(&mut envs, threads).expect("iterates");
    }
    learner
}

/// Rewards as the task does.
#[derive(Clone, Debug)]
struct Echo;

impl LearnedReward for Echo {
    fn name(&self) -> &str {
        "echo"
    }
    fn reward(&self, transitions: &Transitions, reward: &mut [f32]) {
        for t in 0..transitions.steps() {
            let envs = transitions.envs();
            reward[t * envs..(t + 1) * envs].copy_from_slice(transitions.task_reward(t));
        }
    }
    fn train(&mut self, _: &[&Transitions], _: &dyn Ranks, _: usize) {}
    fn save(&self) -> Vec<u8> {
        Vec::new()
    }
    fn restore(&mut self, _: &[u8]) -> Result<(), String> {
        Ok(())
    }
    fn boxed(&self) -> Box<dyn LearnedReward> {
        Box::new(self.clone())
    }
}

/// A small learned score: rewards a position after the step that is nearer to the mean position of all shards so far.
#[derive(Clone, Debug, Default)]
struct Nearness {
    count: f64,
    mean: f64,
    trainings: u64,
}

impl LearnedReward for Nearness {
    fn name(&self) -> &str {
        "nearness"
    }
    fn reward(&self, transitions: &Transitions, reward: &mut [f32]) {
        let motion = transitions.group("motion").expect("the group");
        for t in 0..transitions.steps() {
            let after = transitions.after(motion, t);
            for (e, &done) in transitions.done(t).iter().enumerate() {
                let distance = if done == 0 { after.row(0)[e] - self.mean as f32 } else { 0.0 };
                reward[t * transitions.envs() + e] = -distance * distance;
            }
        }
    }
    fn train(&mut self, shards: &[&Transitions], _: &dyn Ranks, _: usize) {
        self.trainings += 1;
        for transitions in shards {
            let motion = transitions.group("motion").expect("the group");
            for t in 0..transitions.steps() {
                for &x in transitions.before(motion, t).row(0) {
                    self.count += 1.0;
                    self.mean += (f64::from(x) - self.mean) / self.count;
                }
            }
        }
    }
    fn figures(&self) -> Vec<(String, f64)> {
        vec![("mean".to_owned(), self.mean), ("trainings".to_owned(), self.trainings as f64)]
    }
    fn save(&self) -> Vec<u8> {
        [self.count, self.mean, self.trainings as f64].iter().flat_map(|x| x.to_le_bytes()).collect()
    }
    fn restore(&mut self, bytes: &[u8]) -> Result<(), String> {
        let words: Vec<f64> =
            bytes.chunks_exact(8).map(|word| f64::from_le_bytes(core::array::from_fn(|i| word[i]))).collect();
        let [count, mean, trainings] = words[..] else {
            return Err(format!("expected 24 bytes, found {}", bytes.len()));
        };
        *self = Self { count, mean, trainings: trainings as u64 };
        Ok(())
    }
    fn boxed(&self) -> Box<dyn LearnedReward> {
        Box::new(self.clone())
    }
}

#[test]
fn a_further_group_is_collected_raw_before_and_after_each_step() {
    let mut learner = trained(learner(NetworkKind::Mlp), moving(2), 2);
    learner.collect(&mut moving(2), 2).expect("collects");
    let (mut open, mut ended) = (0, 0);
    for shard in learner.shards() {
        let transitions = &shard.transitions;
        assert_eq!(transitions.groups().len(), 1);
        let motion = transitions.group("motion").expect("the group");
        for t in 0..transitions.steps() {
            let (before, after) = (transitions.before(motion, t), transitions.after(motion, t));
            for (e, &done) in transitions.done(t).iter().enumerate() {
                // The mass moves by 0.1 s times its new velocity: only in its own units, so nothing was normalized.
                let error = (after.row(0)[e] - before.row(0)[e] - 0.1 * after.row(1)[e]).abs();
                if done == 0 {
                    assert!(error < 1e-5, "step {t}, environment {e}: {error}");
                    open += 1;
                } else {
                    ended += usize::from(error > 1e-3);
                }
            }
        }
    }
    assert!(open > 1000 && ended > 20, "{open} open steps, {ended} ends with another episode after them");
}

#[test]
fn seams_that_do_nothing_change_no_weight() {
    for kind in [NetworkKind::Mlp, NetworkKind::Lstm] {
        let expected = weights(&trained(learner(kind), plain(2), 2));
        assert_eq!(expected, weights(&trained(learner(kind), moving(2), 2)), "{kind:?}: a group alone");
        let inert = RewardRole::Mixed { task: 1.0, learned: 0.0 };
        let found = trained(with(kind, Nearness::default(), inert), moving(2), 2);
        assert_eq!(expected, weights(&found), "{kind:?}: an inert reward");
    }
}

#[test]
fn a_learned_reward_is_added_to_the_tasks_or_replaces_it() {
    let expected = weights(&trained(learner(NetworkKind::Mlp), plain(2), 1));
    let found = |task: f32, learned: f32| {
        let role = RewardRole::Mixed { task, learned };
        weights(&trained(with(NetworkKind::Mlp, Echo, role), plain(2), 1))
    };
    // The echo is the task's own reward, so these are the same sum.
    assert_eq!(expected, found(0.0, 1.0));
    assert_eq!(expected, found(0.5, 0.5));
    assert_ne!(expected, found(1.0, 1.0));
}

#[test]
fn a_second_critic_has_its_own_rewards_and_its_advantages_are_added_with_weights() {
    for kind in [NetworkKind::Mlp, NetworkKind::Lstm] {
        let mut learner = with(kind, Nearness::default(), own_critic(kind, 0.75, 0.5));
        let mut envs = moving(2);
        let first = learner.iterate(&mut envs, 2).expect("iterates");
        assert!(first.collect.mean_learned_reward < 0.0 && first.update.learned_value_loss > 0.0);
        assert_ne!(learner.critics()[0].params, learner.critics()[1].params);
        learner.collect(&mut envs, 2).expect("collects");
        for shard in learner.shards() {
            let r = &shard.rollout;
            let [task, learned] = [0, 1].map(|k| &r.streams[k]);
            assert_ne!(task.reward, learned.reward);
            for s in 0..r.layout.samples() {
                let [a, b] = [task, learned].map(|stream| stream.returns[s] - stream.value[s]);
                assert!((0.75 * a + 0.5 * b - r.advantage[s]).abs() < 1e-4, "sample {s}");
            }
        }
    }
}

#[test]
fn a_learned_reward_alone_teaches_the_policy() {
    // The task's advantages count nothing; positions near the mean, the origin, are rewarded.
    let mut learner = with(NetworkKind::Mlp, Nearness::default(), own_critic(NetworkKind::Mlp, 0.0, 1.0));
    let mut envs = moving(2);
    let first = learner.iterate(&mut envs, 2).expect("iterates").collect.mean_learned_reward;
    let mut last = first;
    for _ in 0..60 {
        last = learner.iterate(&mut envs, 2).expect("iterates").collect.mean_learned_reward;
    }
    assert!(last > 0.4 * first, "mean reward {first} became {last}");
}

#[test]
fn threads_do_not_change_a_learner_with_all_seams() {
    let run = |threads: usize| {
        let role = own_critic(NetworkKind::Mlp, 1.0, 0.5);
        let learner = trained(with(NetworkKind::Mlp, Nearness::default(), role), moving(3), threads);
        let figures = learner.learned_reward().expect("a reward").figures();
        (weights(&learner), learner.critics()[1].params.clone(), figures)
    };
    let one = run(1);
    assert_eq!(one.2[1], ("trainings".to_owned(), 3.0));
    assert_eq!(one, run(4));
}

#[test]
fn a_resumed_learner_has_the_learned_reward_and_its_critic() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("model.safetensors");
    for kind in [NetworkKind::Mlp, NetworkKind::Lstm] {
        let fresh = || with(kind, Nearness::default(), own_critic(kind, 1.0, 0.5));
        let mut envs = moving(2);
        let mut straight = fresh();
        for _ in 0..2 {
            straight.iterate(&mut envs, 2).expect("iterates");
        }
        straight.save(&path, &[]).expect("saves");
        let states: Vec<Vec<u8>> = envs.iter().map(|env| env.save()).collect();
        for _ in 0..2 {
            straight.iterate(&mut envs, 2).expect("iterates");
        }
        let checkpoint = paid_learn::Checkpoint::load(&path).expect("reads");
        let (mut resumed, mut envs) = (fresh(), moving(2));
        resumed.restore(&checkpoint).expect("restores");
        for (env, state) in envs.iter_mut().zip(&states) {
            env.restore(state).expect("restores");
        }
        for _ in 0..2 {
            resumed.iterate(&mut envs, 2).expect("iterates");
        }
        assert_eq!(weights(&straight), weights(&resumed), "{kind:?}");
        assert_eq!(straight.critics()[1].params, resumed.critics()[1].params, "{kind:?}");
        let figures = |learner: &Learner| learner.learned_reward().expect("a reward").figures();
        assert_eq!(figures(&straight), figures(&resumed));
        // An evaluation needs none of it: AMP's has all the frames that it has seen.
        straight.save_policy(&path, &[]).expect("saves");
        let policy = paid_learn::Checkpoint::load(&path).expect("reads");
        let rewards = |file: &paid_learn::Checkpoint| {
            file.tensors().tensors.keys().any(|key| key.starts_with("reward."))
        };
        assert_eq!([rewards(&checkpoint), rewards(&policy)], [true, false]);

        let mut without = learner(kind);
        let error = without.restore(&checkpoint).expect_err("refused").to_string();
        assert!(error.ends_with("learned reward: expected none, found 'nearness'"), "{error}");
        without.load_weights(&checkpoint).expect("weights alone fit");
        // The other way round, a start takes what is there and keeps its own second critic.
        without.save(&path, &[]).expect("saves");
        let small = paid_learn::Checkpoint::load(&path).expect("reads");
        let mut start = fresh();
        let own = start.critics()[1].params.clone();
        start.load_weights(&small).expect("starts");
        assert_eq!((weights(&start), &start.critics()[1].params), (weights(&without), &own));
        let error = start.restore(&small).expect_err("refused").to_string();
        assert!(error.ends_with("learned reward: expected 'nearness', found none"), "{error}");
    }
}

#[test]
fn shards_with_other_further_groups_are_refused() {
    let mut envs: Vec<Box<dyn VecEnv>> =
        vec![Box::new(WithGroup(PointMass::new(40, 0), "motion")), Box::new(PointMass::new(40, 1))];
    let error = learner(NetworkKind::Mlp).iterate(&mut envs, 1).expect_err("refused").to_string();
    assert_eq!(error, "shard 1: expected further groups (motion [2]), found further groups ()");
}
