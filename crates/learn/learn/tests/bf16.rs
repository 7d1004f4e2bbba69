//! Training with products in bfloat16: gradients, the first minibatch, repeatability, checkpoints, learning.

#![expect(clippy::vec_box, reason = "the learner takes boxed environments")]

use crate::common::{PointMass, Recall};
use paid_lanes::rng::Rng;
use paid_learn::net::{Sequence, Steps, TrainNetwork, TrainWorkspace};
use paid_learn::{
    Checkpoint, LearnConfig, Learner, LstmConfig, NetworkConfig, NetworkKind, PpoConfig, Precision, VecEnv,
};
use paid_policy::bf16::Kernel;
use paid_policy::element::Element;
use paid_policy::matrix::Mat;
use paid_policy::net::{Network, PackedWeights, Weights};

const KINDS: [NetworkKind; 3] = [NetworkKind::Mlp, NetworkKind::Lstm, NetworkKind::Memory];

fn network(kind: NetworkKind, hidden: &[usize], size: usize) -> NetworkConfig {
    let inputs = if kind == NetworkKind::Memory { 1 } else { 0 };
    NetworkConfig {
        kind,
        hidden: hidden.to_vec(),
        lstm: LstmConfig { layers: 2, size, inputs },
        ..NetworkConfig::default()
    }
}

/// Sum of `(y - target)^2 / 2` over a sequence, and its gradient.
fn loss<S: Element>(net: &Network, weights: Weights<'_, S>, width: usize, grads: &mut [S]) -> f64 {
    const STEPS: usize = 3;
    let cols = STEPS * width;
    let mut rng = Rng::new(5, 0, 0);
    let mut normals =
        |n: usize| -> Vec<S> { (0..n).map(|_| S::from_f64(f64::from(rng.normal() as f32))).collect() };
    let (input, target) = (normals(net.input * cols), normals(net.output * cols));
    let mask: Vec<S> =
        (0..cols).map(|k| S::from_f64(if k >= width && k % 7 == 3 { 0.0 } else { 1.0 })).collect();
    let sequence = Sequence {
        input: Mat::new(&input, net.input, cols, cols),
        steps: Steps { steps: STEPS, width, mask: &mask },
        state: &net.initial_state(width),
    };
    let mut total = 0.0;
    net.train(weights, grads, sequence, &mut TrainWorkspace::default(), &mut |columns, y, mut dy| {
        for r in 0..y.rows() {
            for (i, c) in columns.clone().enumerate() {
                let error = y.row(r)[i].to_f64() - target[r * cols + c].to_f64();
                total += 0.5 * error * error;
                dy.row(r)[i] = S::from_f64(error);
            }
        }
    });
    total
}

/// bfloat16 rounds each factor by up to 0.4%; the errors of a sum are independent, so that a gradient's relative error stays
/// near that.
#[test]
fn gradients_match_differences_in_f64_within_bfloat16s_rounding() {
    for (kind, width) in KINDS.into_iter().zip([40, 20, 20]) {
        let net = Network::new(9, 3, &network(kind, &[12, 7], 6));
        let mut params: Vec<f32> = net.initialize(&mut Rng::new(6, 0, 0));
        // A memory that weighs nothing has no gradient, and one of long spans has little of it in three steps.
        let mut rng = Rng::new(8, 0, 0);
        for tensor in net.layout().tensors() {
            let spans = net.is_beside() && tensor.name.ends_with("bias");
            let fresh = params[tensor.range.clone()].iter_mut().filter(|x| spans || **x == 0.0);
            fresh.for_each(|x| *x = rng.uniform(-0.3, 0.3) as f32);
        }
        let exact: Vec<f64> = params.iter().map(|x| f64::from(*x)).collect();
        let value = |params: &[f64]| loss(&net, Weights::from(params), width, &mut vec![0.0; params.len()]);
        let difference = |k: usize| {
            let (mut up, mut down) = (exact.clone(), exact.clone());
            up[k] += 1e-5;
            down[k] -= 1e-5;
            (value(&up) - value(&down)) / 2e-5
        };
        for kernel in Kernel::available() {
            let packed = PackedWeights::new(kernel, &net, &params);
            let mut grads = vec![0.0_f32; params.len()];
            loss(&net, Weights::new(&params, Some(&packed)), width, &mut grads);
            for tensor in net.layout().tensors() {
                let (mut error, mut size) = (0.0, 0.0);
                for k in tensor.range.clone() {
                    let want = difference(k);
                    error += (f64::from(grads[k]) - want).powi(2);
                    size += want * want;
                }
                let relative = (error / size).sqrt();
                assert!(relative < 0.02, "{}, {kind:?}, {}: {relative}", kernel.name(), tensor.name);
                assert!(size > 1e-6, "{} has no gradient", tensor.name);
            }
        }
    }
}

fn config(kind: NetworkKind, precision: Precision) -> LearnConfig {
    let mut network = network(kind, &[32, 32], 16);
    network.lstm.layers = 1;
    LearnConfig {
        precision,
        actor: network.clone(),
        critic: network,
        ppo: PpoConfig {
            entropy: 0.0,
            initial_std: 0.4,
            learning_rate: 3e-3,
            block: 32,
            sequence_block: 16,
            ..PpoConfig::default()
        },
    }
}

fn point_masses(shards: usize, envs: usize) -> Vec<Box<PointMass>> {
    (0..shards).map(|k| Box::new(PointMass::new(envs, k as u64))).collect()
}

fn learner(kind: NetworkKind, precision: Precision) -> Learner {
    Learner::new(2, 3, 1, &config(kind, precision), 3).expect("valid")
}

fn weights(learner: &Learner) -> Vec<u32> {
    learner.actor().params.iter().chain(&learner.critic().params).map(|x| x.to_bits()).collect()
}

#[test]
fn a_learner_says_what_computes_its_products() {
    assert_eq!(learner(NetworkKind::Mlp, Precision::F32).products(), "f32");
    let name = learner(NetworkKind::Mlp, Precision::Bf16).products();
    assert!(Kernel::available().iter().any(|kernel| kernel.name() == name), "{name}");
}

/// Old log-probabilities come from the kernel of the update, so that training begins at a ratio of 1.
#[test]
fn the_ratio_of_the_first_minibatch_is_one() {
    for kind in KINDS {
        for precision in [Precision::F32, Precision::Bf16] {
            let mut config = config(kind, precision);
            (config.ppo.epochs, config.ppo.minibatches) = (1, 1);
            let mut learner = Learner::new(2, 3, 1, &config, 3).expect("valid");
            let mut envs = point_masses(2, 50);
            for _ in 0..3 {
                let update = learner.iterate(&mut envs, 2).expect("fits").update;
                // A mean off by 1e-4 standard deviations would already read 5e-9.
                assert!(update.kl.abs() < 1e-9, "{kind:?}, {precision:?}: {}", update.kl);
                assert_eq!(update.clip_fraction, 0.0);
            }
        }
    }
}

#[test]
fn weights_are_repeated_bit_for_bit_whatever_the_number_of_threads() {
    for kind in KINDS {
        let run = |threads: usize, precision| {
            let mut learner = learner(kind, precision);
            let mut envs = point_masses(3, 40);
            for _ in 0..3 {
                learner.iterate(&mut envs, threads).expect("fits");
            }
            weights(&learner)
        };
        let one = run(1, Precision::Bf16);
        assert_eq!(one, run(1, Precision::Bf16), "{kind:?}");
        assert_eq!(one, run(3, Precision::Bf16), "{kind:?}");
        assert_ne!(one, run(1, Precision::F32), "{kind:?}: the products are in bfloat16");
    }
}

#[test]
fn a_checkpoint_continues_in_either_precision() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run.safetensors");
    for [before, after] in [[Precision::F32, Precision::Bf16], [Precision::Bf16, Precision::F32]] {
        let mut first = learner(NetworkKind::Mlp, before);
        let mut envs = point_masses(1, 40);
        first.iterate(&mut envs, 1).expect("fits");
        first.save(&path, &[]).expect("saves");
        let mut next = learner(NetworkKind::Mlp, after);
        next.restore(&Checkpoint::load(&path).expect("reads")).expect("fits");
        assert_eq!(weights(&first), weights(&next), "the weights are f32 in both");
        let stats = next.iterate(&mut envs, 1).expect("fits");
        assert_eq!(stats.iteration, 2);
        assert!(stats.update.steps > 0 && stats.update.kl.is_finite());
        assert_ne!(weights(&first), weights(&next));
    }
}

/// Mean reward of the mean action over 50 steps of 100 environments.
fn score(learner: &Learner, mut env: impl VecEnv, features: usize) -> f64 {
    let n = env.num_envs();
    let policy = learner.policy();
    let mut state = policy.start(n);
    let (mut seen, mut critic) = (vec![0.0; features * n], vec![0.0; 3 * n]);
    let (mut actions, mut reward) = (vec![0.0; n], vec![0.0; n]);
    let (mut terminated, mut truncated) = (vec![0; n], vec![0; n]);
    let mut total = 0.0;
    for _ in 0..50 {
        let critic = &mut critic[..env.observation_groups()[1].size * n];
        env.observe(&mut [&mut seen, critic]);
        policy.act(&seen, &mut state, &mut actions);
        env.step(&actions, paid_learn::StepBuffers::new(&mut reward, &mut terminated, &mut truncated));
        total += reward.iter().map(|r| f64::from(*r)).sum::<f64>();
        for e in (0..n).filter(|&e| terminated[e] + truncated[e] > 0) {
            state.reset(e);
        }
    }
    total / (50 * n) as f64
}

#[test]
fn a_training_in_bfloat16_learns_as_much_as_one_in_f32() {
    let trained = |precision| {
        let mut learner = learner(NetworkKind::Mlp, precision);
        let mut envs = point_masses(2, 64);
        for _ in 0..120 {
            learner.iterate(&mut envs, 2).expect("fits");
        }
        score(&learner, PointMass::new(100, 99), 2)
    };
    let idle = score(&learner(NetworkKind::Mlp, Precision::F32), PointMass::new(100, 99), 2);
    let [plain, rounded] = [Precision::F32, Precision::Bf16].map(trained);
    println!("untrained {idle:.3}, f32 {plain:.3}, bf16 {rounded:.3}");
    assert!(plain > idle + 0.2 && (plain - rounded).abs() < 0.1 * (plain - idle), "{idle} {plain} {rounded}");
}

#[test]
fn a_policy_that_remembers_learns_in_bfloat16() {
    // A recurrent policy earns up to 1 in five of six steps; for another the best is 0.
    let config = config(NetworkKind::Lstm, Precision::Bf16);
    let mut learner = Learner::new(2, 2, 1, &config, 1).expect("valid");
    let mut envs: Vec<Box<Recall>> = (0..2).map(|k| Box::new(Recall::new(64, k))).collect();
    let wanted = 0.85 * 5.0 / 6.0;
    let mut remembered = 0.0;
    // Plain loops take a second an iteration: no more of them than it needs.
    for _ in 0..8 {
        for _ in 0..10 {
            learner.iterate(&mut envs, 2).expect("fits");
        }
        remembered = score(&learner, Recall::new(100, 99), 2);
        if remembered > wanted {
            break;
        }
    }
    assert!(remembered > wanted, "{remembered}");
}
