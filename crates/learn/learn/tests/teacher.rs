//! A policy that imitates another one on its own rollouts.

#![expect(clippy::vec_box, reason = "the learner takes boxed environments")]

use std::sync::Arc;

use crate::common::{PointMass, WithGroup};
use paid_learn::{LearnConfig, Learner, LstmConfig, NetworkConfig, NetworkKind, PpoConfig, Teacher};
use paid_policy::Policy;
use paid_policy::net::Network;
use paid_policy::normalizer::Normalizer;

/// Pushes with `0.7 x - 0.2 v + 0.3`, which the reward does not like.
fn teacher(weight: f64, until: f64) -> Teacher {
    let config = NetworkConfig { hidden: Vec::new(), ..NetworkConfig::default() };
    let policy = Policy {
        net: Network::new(2, 1, &config),
        params: vec![0.7, -0.2, 0.3],
        normalizer: Normalizer::new(2),
        std: vec![0.1],
    };
    Teacher::new(Arc::new(policy), weight, until).expect("good")
}

fn student(kind: NetworkKind, teacher: Teacher) -> Learner {
    let network = NetworkConfig {
        kind,
        hidden: vec![16],
        lstm: LstmConfig { layers: 1, size: 6, inputs: 0 },
        ..NetworkConfig::default()
    };
    let ppo = PpoConfig { minibatches: 4, block: 32, sequence_block: 16, ..PpoConfig::default() };
    let config = LearnConfig { actor: network.clone(), critic: network, ppo, ..LearnConfig::default() };
    Learner::new(2, 3, 1, &config, 3).expect("valid").with_teacher(teacher).expect("as many actions")
}

fn envs(group: &'static str) -> Vec<Box<WithGroup>> {
    (0..2).map(|k| Box::new(WithGroup(PointMass::new(40, k), group))).collect()
}

fn losses(mut learner: Learner, iterations: usize, threads: usize) -> Vec<f64> {
    let mut envs = envs("teacher");
    (0..iterations).map(|_| learner.iterate(&mut envs, threads).expect("fits").update.teacher_loss).collect()
}

#[test]
fn a_student_comes_to_act_as_its_teacher_with_and_without_memory() {
    for kind in [NetworkKind::Mlp, NetworkKind::Lstm] {
        let losses = losses(student(kind, teacher(10.0, 1.0)), 60, 2);
        assert!(losses[0] > 0.1 && losses[59] < 0.02 * losses[0], "{kind:?}: {losses:?}");
    }
}

#[test]
fn any_number_of_threads_learns_the_same() {
    let of = |threads| losses(student(NetworkKind::Mlp, teacher(1.0, 1.0)), 3, threads);
    assert_eq!(of(1), of(3));
}

#[test]
fn a_teacher_says_nothing_once_its_share_is_over() {
    let mut learner = student(NetworkKind::Mlp, teacher(1.0, 0.5));
    let mut envs = envs("teacher");
    for (share, teaches) in [(0.0, true), (0.49, true), (0.5, false), (0.9, false)] {
        learner.anneal(share);
        let loss = learner.iterate(&mut envs, 1).expect("fits").update.teacher_loss;
        assert_eq!(loss > 0.0, teaches, "{share}: {loss}");
    }
}

#[test]
fn environments_that_show_a_teacher_nothing_are_refused() {
    let mut learner = student(NetworkKind::Mlp, teacher(1.0, 0.5));
    let error = learner.iterate(&mut envs("motion"), 1).expect_err("nothing to see").to_string();
    assert_eq!(error, "shard 0: expected a further group teacher [2], found further groups (motion [2])");
}
