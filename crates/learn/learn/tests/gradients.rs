//! Every layer and loss against central differences, in `f64` (the same source runs in `f32`).

use paid_lanes::rng::Rng;
use paid_learn::gaussian::{self, ActorBatch, ActorLoss, ActorLossConfig, actor_loss};
use paid_learn::net::{Sequence, Steps, TrainNetwork, TrainWorkspace, gate_stats};
use paid_learn::value_loss::{ValueBatch, value_loss};
use paid_policy::matrix::{Mat, MatMut};
use paid_policy::net::{Network, State, StepWorkspace};
use paid_policy::{LstmConfig, NetworkConfig, NetworkKind};

fn config(layers: usize, hidden: &[usize]) -> NetworkConfig {
    NetworkConfig {
        kind: if layers > 0 { NetworkKind::Lstm } else { NetworkKind::Mlp },
        hidden: hidden.to_vec(),
        lstm: LstmConfig { layers, size: 4, inputs: 0 },
        ..NetworkConfig::default()
    }
}

/// A memory of `layers` beside the input, of which it reads the last `inputs`.
fn memory(layers: usize, inputs: usize, hidden: &[usize]) -> NetworkConfig {
    let lstm = LstmConfig { layers, size: 4, inputs };
    NetworkConfig { kind: NetworkKind::Memory, lstm, ..config(layers, hidden) }
}

struct Case {
    net: Network,
    params: Vec<f64>,
    input: Vec<f64>,
    mask: Vec<f64>,
    state: State<f64>,
    target: Vec<f64>,
    steps: usize,
    width: usize,
}

impl Case {
    fn new(net: Network, steps: usize, width: usize) -> Self {
        let mut rng = Rng::new(5, 0, 0);
        let mut normals = |n: usize| -> Vec<f64> { (0..n).map(|_| rng.normal()).collect() };
        let cols = steps * width;
        let input = normals(net.input * cols);
        let target = normals(net.output * cols);
        let mut state = net.initial_state(width);
        for layer in state.h.iter_mut().chain(&mut state.c) {
            *layer = normals(layer.len());
        }
        // Episodes begin in the middle of some sequences.
        let mask = (0..cols).map(|k| if k >= width && k % 7 == 3 { 0.0 } else { 1.0 }).collect();
        let mut params: Vec<f64> = net.initialize(&mut Rng::new(6, 0, 0));
        // A memory that weighs nothing has no gradient.
        params.iter_mut().filter(|x| **x == 0.0).for_each(|x| *x = rng.uniform(-0.5, 0.5));
        Self { net, params, input, mask, state, target, steps, width }
    }

    /// Sum of `(y - target)^2 / 2`, and its gradient.
    fn run(&self, params: &[f64], grads: &mut [f64]) -> f64 {
        let cols = self.steps * self.width;
        let sequence = Sequence {
            input: Mat::new(&self.input, self.net.input, cols, cols),
            steps: Steps { steps: self.steps, width: self.width, mask: &self.mask },
            state: &self.state,
        };
        let mut total = 0.0;
        let mut work = TrainWorkspace::default();
        self.net.train(params, grads, sequence, &mut work, &mut |columns, y, mut dy| {
            for r in 0..y.rows() {
                for (i, c) in columns.clone().enumerate() {
                    let error = y.row(r)[i] - self.target[r * cols + c];
                    total += 0.5 * error * error;
                    dy.row(r)[i] = error;
                }
            }
        });
        total
    }

    fn check(&self) {
        let mut grads = vec![0.0; self.params.len()];
        self.run(&self.params, &mut grads);
        let mut ignored = grads.clone();
        for tensor in self.net.layout().tensors() {
            let mut largest = 0.0f64;
            for k in tensor.range.clone() {
                let mut params = self.params.clone();
                let h = 1e-5;
                params[k] = self.params[k] + h;
                let up = self.run(&params, &mut ignored);
                params[k] = self.params[k] - h;
                let down = self.run(&params, &mut ignored);
                let want = (up - down) / (2.0 * h);
                largest = largest.max(grads[k].abs());
                let error = (grads[k] - want).abs();
                assert!(
                    error < 1e-6 * want.abs().max(1.0),
                    "{}[{k}]: {} against {want}",
                    tensor.name,
                    grads[k]
                );
            }
            assert!(largest > 1e-3, "{} has no gradient", tensor.name);
        }
    }
}

#[test]
fn multilayer_perceptron_gradients_match_differences() {
    Case::new(Network::new(5, 3, &config(0, &[6, 4])), 1, 9).check();
    Case::new(Network::new(5, 2, &config(0, &[])), 1, 9).check();
    // More than one chunk.
    Case::new(Network::new(2, 1, &config(0, &[3])), 1, 300).check();
}

#[test]
fn lstm_gradients_match_differences_through_time_and_resets() {
    Case::new(Network::new(3, 2, &config(1, &[5])), 5, 4).check();
    Case::new(Network::new(3, 2, &config(2, &[5, 3])), 4, 3).check();
    // Chunks that do not end with a step.
    Case::new(Network::new(2, 1, &config(1, &[])), 3, 100).check();
}

#[test]
fn gradients_of_a_memory_beside_the_input_match_differences_through_time_and_resets() {
    Case::new(Network::new(5, 2, &memory(1, 2, &[5])), 5, 4).check();
    Case::new(Network::new(3, 2, &memory(2, 0, &[5, 3])), 4, 3).check();
    // Chunks that do not end with a step, and a first layer that is the last.
    Case::new(Network::new(3, 1, &memory(1, 1, &[])), 3, 100).check();
}

#[test]
fn a_memory_beside_the_input_begins_as_the_network_without_one() {
    let (net, plain) = (Network::new(5, 2, &memory(1, 2, &[6, 4])), Network::new(5, 2, &config(0, &[6, 4])));
    let [params, without] = [&net, &plain].map(|net| net.initialize::<f64>(&mut Rng::new(6, 0, 0)));
    let (mut state, mut none) = (net.initial_state(3), plain.initial_state(3));
    let mut rng = Rng::new(7, 0, 0);
    for _ in 0..4 {
        let input: Vec<f64> = (0..15).map(|_| rng.normal()).collect();
        let x = Mat::new(&input, 5, 3, 3);
        let (mut out, mut expected) = (vec![0.0; 6], vec![0.0; 6]);
        let mut work = StepWorkspace::default();
        net.step(&params, x, &mut state, MatMut::new(&mut out, 2, 3, 3), &mut work);
        plain.step(&without, x, &mut none, MatMut::new(&mut expected, 2, 3, 3), &mut work);
        assert!(out.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-12), "{out:?} {expected:?}");
    }
    assert!(state.h[0].iter().all(|h| h.abs() > 1e-6), "it remembers from the start: {:?}", state.h);
    let bias = net.layout().find("lstm.0.bias").expect("a tensor").range.clone();
    let (input, forget) = params[bias][..8].split_at(4);
    assert!(forget.iter().zip(input).all(|(f, i)| (0.0..50.0_f64.ln()).contains(f) && f == &-i));
}

#[test]
fn what_is_in_front_of_a_memorys_features_does_not_reach_it() {
    let net = Network::new(5, 2, &memory(1, 2, &[6]));
    assert_eq!((net.remembered_features(), net.train_flop()), (3..5, f64::from(2 * (3 * 162 - 32 - 30))));
    let params = net.initialize::<f64>(&mut Rng::new(6, 0, 0));
    let mut states = [1.0, 2.0].map(|x| {
        let mut state = net.initial_state(1);
        let out = &mut [0.0; 2];
        let input = [x, x, x, 0.5, -0.5];
        let (input, out) = (Mat::new(&input, 5, 1, 1), MatMut::new(out, 2, 1, 1));
        net.step(&params, input, &mut state, out, &mut StepWorkspace::default());
        state
    });
    assert_eq!(states[0], states[1]);
    states[0].reset(0);
    assert_eq!(states[0], net.initial_state(1));
}

#[test]
fn gates_count_as_saturated_where_nothing_moves_them() {
    let stats = |net: Network, bias: f64| {
        let mut case = Case::new(net, 5, 4);
        for tensor in case.net.layout().tensors().iter().filter(|t| t.name.starts_with("lstm.")) {
            let value = if tensor.name.ends_with("bias") { bias } else { 0.25 };
            case.params[tensor.range.clone()].fill(value);
        }
        let sequence = Sequence {
            input: Mat::new(&case.input, case.net.input, 20, 20),
            steps: Steps { steps: 5, width: 4, mask: &case.mask },
            state: &case.state,
        };
        gate_stats(&case.net, &case.params, sequence, &mut TrainWorkspace::default())
    };
    assert_eq!(stats(Network::new(5, 2, &config(0, &[5])), 0.0), None);
    let net = || Network::new(5, 2, &memory(1, 2, &[5]));
    let [open, shut] = [0.0, -50.0].map(|bias| stats(net(), bias).expect("gates"));
    assert!(open.saturated < 0.1 && shut.saturated == 1.0, "{open:?} {shut:?}");
    assert_eq!(open.weight_rms, 0.25);
}

#[test]
fn a_sequence_and_single_steps_give_the_same_outputs() {
    same_outputs(Network::new(3, 2, &config(2, &[4])));
    same_outputs(Network::new(3, 2, &memory(2, 2, &[4])));
}

fn same_outputs(net: Network) {
    let (steps, width) = (6, 5);
    let mut case = Case::new(net, steps, width);
    let cols = steps * width;
    case.target.fill(0.0);
    let mut outputs = vec![0.0; 2 * cols];
    let sequence = Sequence {
        input: Mat::new(&case.input, 3, cols, cols),
        steps: Steps { steps, width, mask: &case.mask },
        state: &case.state,
    };
    let mut grads = vec![0.0; case.params.len()];
    case.net.train(
        &case.params,
        &mut grads,
        sequence,
        &mut TrainWorkspace::default(),
        &mut |columns, y, mut dy| {
            for r in 0..2 {
                dy.row(r).fill(0.0);
                outputs[r * cols + columns.start..r * cols + columns.end].copy_from_slice(y.row(r));
            }
        },
    );
    let mut state = case.state.clone();
    let mut work = StepWorkspace::default();
    for t in 0..steps {
        for i in 0..width {
            if case.mask[t * width + i] == 0.0 {
                state.reset(i);
            }
        }
        let mut out = vec![0.0; 2 * width];
        let x = Mat::new(&case.input, 3, cols, cols).columns(t * width, width);
        case.net.step(&case.params, x, &mut state, MatMut::new(&mut out, 2, width, width), &mut work);
        for r in 0..2 {
            for i in 0..width {
                assert!((out[r * width + i] - outputs[r * cols + t * width + i]).abs() < 1e-12);
            }
        }
    }
}

/// Actions, old means, old log std, old log probabilities, advantages of `n` samples of 3 actions.
struct ActorCase {
    action: Vec<f64>,
    old_mean: Vec<f64>,
    old_log_std: Vec<f64>,
    old_log_prob: Vec<f64>,
    advantage: Vec<f64>,
    n: usize,
}

const LOSS: ActorLossConfig =
    ActorLossConfig { clip: 0.2, advantage_mean: 0.3, advantage_scale: 0.7, weight: 0.1 };

impl ActorCase {
    fn new(n: usize) -> Self {
        let mut rng = Rng::new(9, 0, 0);
        let mut normals = |n: usize, s: f64| -> Vec<f64> { (0..n).map(|_| s * rng.normal()).collect() };
        let old_log_std: Vec<f64> = vec![-0.5, -1.0, 0.2];
        let old_mean = normals(3 * n, 1.0);
        let noise = normals(3 * n, 1.0);
        let action: Vec<f64> =
            (0..3 * n).map(|k| old_mean[k] + old_log_std[k / n].exp() * noise[k]).collect();
        let column = |x: &[f64], i: usize| [x[i], x[n + i], x[2 * n + i]];
        let old_log_prob = (0..n)
            .map(|i| gaussian::log_prob(&column(&old_mean, i), &old_log_std, &column(&action, i)))
            .collect();
        Self { old_log_prob, advantage: normals(n, 2.0), action, old_mean, old_log_std, n }
    }

    fn run(&self, mean: &[f64], log_std: &[f64], dmean: &mut [f64], dlog_std: &mut [f64]) -> ActorLoss {
        let n = self.n;
        let batch = ActorBatch {
            action: Mat::new(&self.action, 3, n, n),
            old_mean: Mat::new(&self.old_mean, 3, n, n),
            old_log_std: &self.old_log_std,
            old_log_prob: &self.old_log_prob,
            advantage: &self.advantage,
        };
        let mean = Mat::new(mean, 3, n, n);
        actor_loss(LOSS, mean, log_std, batch, MatMut::new(dmean, 3, n, n), dlog_std, &mut vec![0.0; n])
    }
}

#[test]
fn actor_loss_gradients_match_differences() {
    let case = ActorCase::new(40);
    let mut rng = Rng::new(10, 0, 0);
    let mean: Vec<f64> = case.old_mean.iter().map(|m| m + 0.1 * rng.normal()).collect();
    let log_std: Vec<f64> = case.old_log_std.iter().map(|s| s + 0.03).collect();
    let (mut dmean, mut dlog_std) = (vec![0.0; 120], vec![0.0; 3]);
    let loss = case.run(&mean, &log_std, &mut dmean, &mut dlog_std);
    assert!(loss.clipped > 5.0 && loss.clipped < 35.0, "both branches are met: {}", loss.clipped);
    let value = |mean: &[f64], log_std: &[f64]| {
        LOSS.weight * case.run(mean, log_std, &mut [0.0; 120], &mut [0.0; 3]).surrogate
    };
    let h = 1e-6;
    for k in 0..120 {
        let (mut up, mut down) = (mean.clone(), mean.clone());
        up[k] += h;
        down[k] -= h;
        let want = (value(&up, &log_std) - value(&down, &log_std)) / (2.0 * h);
        assert!((dmean[k] - want).abs() < 1e-6, "mean {k}: {} against {want}", dmean[k]);
    }
    for k in 0..3 {
        let (mut up, mut down) = (log_std.clone(), log_std.clone());
        up[k] += h;
        down[k] -= h;
        let want = (value(&mean, &up) - value(&mean, &down)) / (2.0 * h);
        assert!((dlog_std[k] - want).abs() < 1e-6, "log_std {k}: {} against {want}", dlog_std[k]);
    }
}

#[test]
fn actor_loss_reports_the_divergence_of_the_formula() {
    let case = ActorCase::new(11);
    let mean: Vec<f64> = case.old_mean.iter().map(|m| m + 0.2).collect();
    let log_std = [-0.4, -1.1, 0.2];
    let loss = case.run(&mean, &log_std, &mut [0.0; 33], &mut [0.0; 3]);
    let column = |x: &[f64], i: usize| [x[i], x[11 + i], x[22 + i]];
    let want: f64 = (0..11)
        .map(|i| gaussian::kl(&column(&case.old_mean, i), &case.old_log_std, &column(&mean, i), &log_std))
        .sum();
    assert!((loss.kl - want).abs() < 1e-12 * want.abs());
    let same = case.run(&case.old_mean, &case.old_log_std, &mut [0.0; 33], &mut [0.0; 3]);
    assert_eq!((same.kl, same.clipped), (0.0, 0.0));
}

#[test]
fn value_loss_gradients_match_differences_inside_and_outside_the_clip_range() {
    // value, old value, returns: inside; outside toward the returns (clipped branch wins, no gradient); outside away.
    let cases = [(1.1, 1.0, 3.0), (1.5, 1.0, 3.0), (0.5, 1.0, 3.0), (1.5, 1.0, 1.0), (0.9, 1.0, 0.0)];
    let clip = 0.2;
    let run = |value: &[f64], clip, gradient: &mut [f64]| {
        let old: Vec<f64> = cases.iter().map(|c| c.1).collect();
        let returns: Vec<f64> = cases.iter().map(|c| c.2).collect();
        value_loss(clip, 0.5, value, ValueBatch { old_value: &old, returns: &returns }, gradient)
    };
    let value: Vec<f64> = cases.iter().map(|c| c.0).collect();
    for clip in [Some(clip), None] {
        let mut gradient = vec![0.0; cases.len()];
        run(&value, clip, &mut gradient);
        for k in 0..cases.len() {
            let (mut up, mut down) = (value.clone(), value.clone());
            up[k] += 1e-6;
            down[k] -= 1e-6;
            let ignored = &mut vec![0.0; cases.len()];
            let want = 0.5 * (run(&up, clip, ignored) - run(&down, clip, ignored)) / 2e-6;
            assert!((gradient[k] - want).abs() < 1e-6, "case {k}: {} against {want}", gradient[k]);
        }
        assert_eq!(gradient[1] == 0.0, clip.is_some());
    }
}

#[test]
fn value_gradients_survive_rounding_inside_the_clip_range() {
    // old + (value - old) differs from value in f32 here; a bare comparison of the squares would drop some gradients.
    let mut rng = Rng::new(3, 0, 0);
    for _ in 0..1000 {
        let old = rng.normal() as f32 * 30.0;
        let value = old + rng.uniform(-0.19, 0.19) as f32;
        let returns = rng.normal() as f32 * 30.0;
        let mut gradient = [0.0];
        value_loss(
            Some(0.2),
            1.0,
            &[value],
            ValueBatch { old_value: &[old], returns: &[returns] },
            &mut gradient,
        );
        assert_eq!(gradient[0], (value - returns) * 2.0);
    }
}
