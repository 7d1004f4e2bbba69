//! Known problems are solved, and results do not depend on the number of threads.

#![expect(clippy::vec_box, reason = "the learner takes boxed environments")]

use crate::common::{PointMass, Recall, WithSign};
use paid_learn::{
    LearnConfig, Learner, LstmConfig, MirrorConfig, NetworkConfig, NetworkKind, PpoConfig, StepBuffers,
    VecEnv,
};
use paid_policy::{Mirror, Mirrors, Sides};

fn point_masses(shards: usize, envs: usize) -> Vec<Box<PointMass>> {
    (0..shards).map(|k| Box::new(PointMass::new(envs, k as u64))).collect()
}

fn recalls(shards: usize, envs: usize) -> Vec<Box<Recall>> {
    (0..shards).map(|k| Box::new(Recall::new(envs, k as u64))).collect()
}

fn config(kind: NetworkKind, hidden: &[usize]) -> LearnConfig {
    let network = NetworkConfig {
        kind,
        hidden: hidden.to_vec(),
        lstm: LstmConfig { layers: 1, size: 16, inputs: 0 },
        ..NetworkConfig::default()
    };
    LearnConfig {
        actor: network.clone(),
        critic: network,
        ppo: PpoConfig { minibatches: 4, epochs: 4, block: 32, sequence_block: 16, ..PpoConfig::default() },
        ..LearnConfig::default()
    }
}

/// Mean reward of the deterministic policy over 50 steps of `envs` environments.
fn evaluate(learner: &Learner, env: &mut dyn VecEnv) -> f64 {
    let policy = learner.policy();
    let n = env.num_envs();
    let mut state = policy.start(n);
    let mut obs = vec![0.0; env.policy_obs_dim() * n];
    let mut actions = vec![0.0; n];
    let (mut reward, mut terminated, mut truncated) = (vec![0.0; n], vec![0; n], vec![0; n]);
    let mut total = 0.0;
    for _ in 0..48 {
        env.observe(&mut [&mut obs]);
        policy.act(&obs, &mut state, &mut actions);
        env.step(&actions, StepBuffers::new(&mut reward, &mut terminated, &mut truncated));
        for e in 0..n {
            total += f64::from(reward[e]);
            if terminated[e] + truncated[e] > 0 {
                state.reset(e);
            }
        }
    }
    total / (48 * n) as f64
}

/// Mean reward over 48 steps under the linear feedback `a = -k x - d v`.
fn feedback(k: f32, d: f32) -> f64 {
    let mut env = PointMass::new(200, 99);
    let n = env.num_envs();
    let (mut obs, mut actions) = (vec![0.0; 2 * n], vec![0.0; n]);
    let (mut reward, mut terminated, mut truncated) = (vec![0.0; n], vec![0; n], vec![0; n]);
    let mut total = 0.0;
    for _ in 0..48 {
        env.observe(&mut [&mut obs]);
        for e in 0..n {
            actions[e] = -k * obs[e] - d * obs[n + e];
        }
        env.step(&actions, StepBuffers::new(&mut reward, &mut terminated, &mut truncated));
        total += reward.iter().map(|&r| f64::from(r)).sum::<f64>();
    }
    total / (48 * n) as f64
}

#[test]
fn a_point_mass_is_brought_to_rest_as_well_as_by_the_best_linear_feedback() {
    let mut best = f64::MIN;
    for k in 1..12 {
        for d in 1..8 {
            best = best.max(feedback(k as f32, d as f32));
        }
    }
    let mut learner = Learner::new(2, 3, 1, &config(NetworkKind::Mlp, &[32, 32]), 1).unwrap();
    let mut envs = point_masses(2, 64);
    let before = evaluate(&learner, &mut PointMass::new(200, 99));
    for _ in 0..160 {
        learner.iterate(&mut envs, 2).unwrap();
    }
    let after = evaluate(&learner, &mut PointMass::new(200, 99));
    let idle = feedback(0.0, 0.0);
    println!("untrained {before:.3}, idle {idle:.3}, trained {after:.3}, best linear {best:.3}");
    assert!(after > best - 0.05 * (best - idle), "trained {after}, best linear {best}, idle {idle}");
}

#[test]
fn a_sign_seen_once_is_remembered_by_an_lstm() {
    let mut learner = Learner::new(2, 2, 1, &config(NetworkKind::Lstm, &[16]), 1).unwrap();
    let mut envs = recalls(2, 64);
    for _ in 0..80 {
        learner.iterate(&mut envs, 2).unwrap();
    }
    // Five of six steps earn up to 1; without recurrence the best is 0.
    let after = evaluate(&learner, &mut Recall::new(100, 99));
    println!("trained {after:.3}");
    assert!(after > 0.9 * 5.0 / 6.0, "trained {after}");
}

/// A policy with memory beside a critic without: what the policy must remember, the critic sees.
#[test]
fn a_sign_seen_once_is_remembered_beside_the_input_with_a_critic_that_has_no_memory() {
    let mut config = config(NetworkKind::Memory, &[16]);
    config.critic.kind = NetworkKind::Mlp;
    let mut learner = Learner::new(2, 3, 1, &config, 1).unwrap();
    let mut envs: Vec<Box<WithSign>> = (0..2).map(|k| Box::new(WithSign(Recall::new(64, k)))).collect();
    for _ in 0..80 {
        learner.iterate(&mut envs, 2).unwrap();
    }
    let after = evaluate(&learner, &mut Recall::new(100, 99));
    println!("trained {after:.3}");
    assert!(after > 0.9 * 5.0 / 6.0, "trained {after}");
}

fn weights(learner: &Learner) -> Vec<u32> {
    learner.actor().params.iter().chain(&learner.critic().params).map(|x| x.to_bits()).collect()
}

#[test]
fn weights_do_not_depend_on_the_number_of_threads() {
    for kind in [NetworkKind::Mlp, NetworkKind::Lstm, NetworkKind::Memory] {
        let run = |threads: usize| {
            let mut learner = Learner::new(2, 3, 1, &config(kind, &[16, 8]), 3).unwrap();
            let mut envs = point_masses(3, 40);
            for _ in 0..3 {
                learner.iterate(&mut envs, threads).unwrap();
            }
            weights(&learner)
        };
        let one = run(1);
        assert_eq!(one, run(2), "{kind:?}");
        assert_eq!(one, run(5), "{kind:?}");
    }
}

#[test]
fn another_seed_gives_other_weights() {
    let run = |seed: u64| {
        let mut learner = Learner::new(2, 3, 1, &config(NetworkKind::Mlp, &[8]), seed).unwrap();
        learner.iterate(&mut point_masses(1, 16), 1).unwrap();
        weights(&learner)
    };
    assert_ne!(run(1), run(2));
}

#[test]
fn a_shard_of_other_sizes_is_refused() {
    let mut learner = Learner::new(2, 2, 1, &config(NetworkKind::Mlp, &[8]), 1).unwrap();
    let error = learner.iterate(&mut point_masses(1, 16), 1).unwrap_err();
    assert_eq!(
        error.to_string(),
        "shard 0: expected 2 policy features, 2 critic features, 1 actions, found 2 policy features, 3 critic \
         features, 1 actions"
    );
    let mut learner = Learner::new(2, 3, 1, &config(NetworkKind::Mlp, &[8]), 1).unwrap();
    learner.iterate(&mut point_masses(2, 16), 1).unwrap();
    let error = learner.iterate(&mut point_masses(1, 16), 1).unwrap_err();
    assert_eq!(error.to_string(), "shard 1: expected 16 environments, found no such shard");
}

#[test]
fn a_lower_limit_of_the_noise_holds_for_the_next_horizon_and_is_no_divergence() {
    let mut config = config(NetworkKind::Mlp, &[16]);
    config.ppo = PpoConfig { initial_std: 0.5, max_std: 0.5, final_std: Some(0.1), ..config.ppo };
    let mut learner = Learner::new(2, 3, 1, &config, 3).expect("valid");
    let mut envs = point_masses(1, 32);
    learner.anneal(1.0);
    assert!(learner.policy().std.iter().all(|std| *std < 0.1001), "{:?}", learner.policy().std);
    learner.collect(&mut envs, 1).expect("collects");
    let kl = learner.update(1).kl;
    // From 0.5 to 0.1 within the update the divergence is above 10.
    assert!(kl < 1.0, "{kl}");
}

/// How a point mass reads in a mirrored world: everything has the other sign.
fn other_side() -> Mirrors {
    let of = |numbers: usize| {
        Mirror::of_joints(&Sides { joints: (0..numbers).map(|k| (k, -1.0)).collect(), bodies: Vec::new() })
    };
    Mirrors { observation: of(2), action: of(1) }
}

/// RMS of `a(x) + a(-x)` over a grid of states: 0 for a policy without a preferred side.
fn asymmetry(learner: &Learner) -> f64 {
    let policy = learner.policy();
    let grid: Vec<[f32; 2]> = (-4..=4)
        .flat_map(|x| (-4..=4).map(move |v| [0.25 * x as f32, 0.25 * v as f32]))
        .flat_map(|[x, v]| [[x, v], [-x, -v]])
        .collect();
    let n = grid.len();
    let observation: Vec<f32> = (0..2).flat_map(|k| grid.iter().map(move |state| state[k])).collect();
    let mut actions = vec![0.0; n];
    policy.act(&observation, &mut policy.start(n), &mut actions);
    let squares = actions.chunks(2).map(|pair| f64::from(pair[0] + pair[1]).powi(2));
    (squares.sum::<f64>() / (n / 2) as f64).sqrt()
}

#[test]
fn a_policy_with_the_mirror_symmetry_loss_has_no_preferred_side() {
    let trained = |weight: f64, threads: usize| {
        let mut config = config(NetworkKind::Mlp, &[32, 32]);
        config.ppo.mirror = MirrorConfig { weight, share: 0.5 };
        let mut learner = Learner::new(2, 3, 1, &config, 1).unwrap().with_mirrors(other_side()).unwrap();
        let mut envs = point_masses(2, 64);
        let mut last = 0.0;
        for _ in 0..60 {
            last = learner.iterate(&mut envs, threads).unwrap().update.mirror_loss;
        }
        (learner, last)
    };
    let (free, nothing) = trained(0.0, 2);
    let (symmetric, loss) = trained(1.0, 2);
    let (a, b) = (asymmetry(&free), asymmetry(&symmetric));
    let scores = [&free, &symmetric].map(|learner| evaluate(learner, &mut PointMass::new(200, 99)));
    println!("asymmetry {a:.4} without the loss, {b:.4} with it; {loss:.5}; rewards {scores:.3?}");
    assert_eq!(nothing, 0.0);
    assert!(b < 0.3 * a && loss > 0.0, "{a} {b} {loss}");
    assert!(scores[1] > scores[0] - 0.05, "{scores:?}");
    assert_eq!(weights(&symmetric), weights(&trained(1.0, 1).0), "one thread and two");
}

#[test]
fn a_mirror_symmetry_loss_that_cannot_be_computed_is_refused() {
    let mut config = config(NetworkKind::Lstm, &[16]);
    config.ppo.mirror.weight = 0.1;
    let error = Learner::new(2, 2, 1, &config, 1).expect_err("a recurrent state has no image").to_string();
    assert_eq!(error, "ppo.mirror.weight: expected 0 for a recurrent policy, found 0.1");
    config.ppo.mirror = MirrorConfig { weight: 0.0, share: 0.0 };
    let error = Learner::new(2, 2, 1, &config, 1).expect_err("a share").to_string();
    assert_eq!(error, "ppo.mirror.share: expected more than 0 and at most 1, found 0");
    let learner = Learner::new(3, 2, 1, &LearnConfig::default(), 1).unwrap();
    let error = learner.with_mirrors(other_side()).expect_err("two features").to_string();
    assert_eq!(error, "mirrors: expected one for this policy, found one of (2, 1) for (3, 1)");
}
