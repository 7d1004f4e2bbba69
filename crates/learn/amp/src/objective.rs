//! The discriminator's loss on a batch of pairs, and its gradient.

use paid_policy::element::Element;

use crate::config::{AmpConfig, Formulation};
use crate::network::{Perceptron, Tape};

/// Pairs of both kinds, `[2 features, samples]` each, row-major.
#[derive(Clone, Copy, Debug)]
pub struct Batch<'a, S> {
    /// Pairs of the clips.
    pub clips: &'a [S],
    /// Pairs of the policy.
    pub policy: &'a [S],
    /// Shares of the clips' pair in the points where [`Formulation::Wasserstein`] holds the gradient, `[samples]`.
    pub mix: &'a [S],
    /// Samples of each kind here.
    pub samples: usize,
    /// Samples of each kind in the whole step, of which these are a part.
    pub of: usize,
}

/// Sums over the samples of a batch; over the step's samples they are means.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sums {
    /// The loss.
    pub loss: f64,
    /// Its part from the gradient penalty.
    pub penalty: f64,
    /// Scores of the clips' pairs.
    pub clips: f64,
    /// Scores of the policy's pairs.
    pub policy: f64,
    /// Their squares.
    pub policy_squares: f64,
    /// Pairs on their own side of the middle.
    pub right: f64,
}

impl Sums {
    /// Adds another part of the step.
    pub fn add(&mut self, other: &Self) {
        for (sum, x) in self.all_mut().into_iter().zip(other.all()) {
            *sum += x;
        }
    }

    /// Every sum, in the order of their declaration.
    pub fn all(&self) -> [f64; 6] {
        let Self { loss, penalty, clips, policy, policy_squares, right } = *self;
        [loss, penalty, clips, policy, policy_squares, right]
    }

    /// Every sum to write to, in the same order.
    pub fn all_mut(&mut self) -> [&mut f64; 6] {
        let Self { loss, penalty, clips, policy, policy_squares, right } = self;
        [loss, penalty, clips, policy, policy_squares, right]
    }
}

/// Room of one worker.
#[derive(Clone, Debug, Default)]
pub struct Workspace<S> {
    tape: Tape<S>,
    gradient: Vec<S>,
    points: Vec<S>,
}

/// Adds the gradient of the loss, divided by the step's samples, to `grads`, and returns the loss's sums over these samples.
pub fn evaluate<S: Element>(
    net: &Perceptron,
    params: &[S],
    config: &AmpConfig,
    batch: &Batch<'_, S>,
    work: &mut Workspace<S>,
    grads: &mut [S],
) -> Sums {
    let mut sums = Sums::default();
    let n = batch.samples;
    for (clips, x) in [(true, batch.clips), (false, batch.policy)] {
        net.forward(params, x, n, &mut work.tape);
        work.gradient.clear();
        let side = if clips { 1.0 } else { -1.0 };
        for score in work.tape.scores() {
            let d = score.to_f64();
            let (loss, slope) = match config.formulation {
                Formulation::LeastSquares => (0.5 * (d - side).powi(2), d - side),
                Formulation::Wasserstein => (-side * d, -side),
            };
            sums.loss += loss + config.score_penalty * d * d;
            if clips {
                sums.clips += d;
            } else {
                sums.policy += d;
                sums.policy_squares += d * d;
            }
            sums.right += f64::from(u8::from(side * d > 0.0));
            let gradient = (slope + 2.0 * config.score_penalty * d) / batch.of as f64;
            work.gradient.push(S::from_f64(gradient));
        }
        net.backward(params, x, &work.gradient, &mut work.tape, grads);
        if clips && config.formulation == Formulation::LeastSquares {
            // Half of the weight, as the method's paper has it.
            sums.penalty += penalty(net, params, 0.5 * config.gradient_penalty, None, batch, work, grads);
        }
    }
    if config.formulation == Formulation::Wasserstein {
        let mut points = core::mem::take(&mut work.points);
        points.clear();
        for (clips, policy) in batch.clips.chunks_exact(n).zip(batch.policy.chunks_exact(n)) {
            for k in 0..n {
                let share = batch.mix[k].to_f64();
                points.push(S::from_f64(share * clips[k].to_f64() + (1.0 - share) * policy[k].to_f64()));
            }
        }
        net.forward(params, &points, n, &mut work.tape);
        work.points = points;
        sums.penalty += penalty(net, params, config.gradient_penalty, Some(1.0), batch, work, grads);
    }
    sums.loss += sums.penalty;
    sums
}

/// `weight` times the squared norm of the input gradient at the last way forward's samples, or its squared difference to `norm`.
fn penalty<S: Element>(
    net: &Perceptron,
    params: &[S],
    weight: f64,
    norm: Option<f64>,
    batch: &Batch<'_, S>,
    work: &mut Workspace<S>,
    grads: &mut [S],
) -> f64 {
    if weight == 0.0 {
        return 0.0;
    }
    let n = batch.samples;
    let slopes = net.input_gradient(params, &mut work.tape);
    let mut squares = vec![0.0; n];
    for row in slopes.chunks_exact(n) {
        for (square, slope) in squares.iter_mut().zip(row) {
            *square += slope.to_f64().powi(2);
        }
    }
    let mut total = 0.0;
    // Factors on the input gradient in the loss's gradient.
    let factors: Vec<f64> = squares
        .iter()
        .map(|square| {
            let length = square.sqrt();
            // The penalty, and its derivative by the input gradient over that gradient; at a slope of zero there is no direction.
            let (off, factor) = match norm {
                None => (*square, 2.0),
                Some(norm) => ((length - norm).powi(2), 2.0 * (length - norm) / length.max(1e-12)),
            };
            total += weight * off;
            weight * factor / batch.of as f64
        })
        .collect();
    let gradient = &mut work.gradient;
    gradient.clear();
    for row in slopes.chunks_exact(n) {
        gradient.extend(row.iter().zip(&factors).map(|(slope, factor)| S::from_f64(slope.to_f64() * factor)));
    }
    net.backward_input_gradient(params, gradient, &mut work.tape, grads);
    total
}

#[cfg(test)]
mod tests {
    use super::*;
    use paid_lanes::rng::Rng;

    fn numbers(seed: u64, count: usize) -> Vec<f64> {
        let mut rng = Rng::new(seed, 0, 0);
        (0..count).map(|_| rng.normal()).collect()
    }

    fn run(config: &AmpConfig, net: &Perceptron, params: &[f64], of: usize) -> (Sums, Vec<f64>) {
        let (clips, policy, mix) = (numbers(5, 6 * 7), numbers(6, 6 * 7), vec![0.3; 7]);
        let batch = Batch { clips: &clips, policy: &policy, mix: &mix, samples: 7, of };
        let mut grads = vec![0.0; net.params()];
        let sums = evaluate(net, params, config, &batch, &mut Workspace::default(), &mut grads);
        (sums, grads)
    }

    #[test]
    fn gradients_match_finite_differences_with_the_penalty_in_both_games() {
        let net = Perceptron::new(6, &[9, 5]);
        let params = numbers(4, net.params());
        for formulation in [Formulation::LeastSquares, Formulation::Wasserstein] {
            let config =
                AmpConfig { formulation, gradient_penalty: 3.0, score_penalty: 0.05, ..AmpConfig::default() };
            let (sums, grads) = run(&config, &net, &params, 7);
            assert!(sums.penalty > 0.1 * sums.loss.abs(), "the penalty counts: {sums:?}");
            for k in 0..params.len() {
                let at = |step: f64| {
                    let mut moved = params.clone();
                    moved[k] += step;
                    run(&config, &net, &moved, 7).0.loss / 7.0
                };
                let want = (at(1e-6) - at(-1e-6)) / 2e-6;
                assert!(
                    (grads[k] - want).abs() < 1e-5 * (1.0 + want.abs()),
                    "{formulation:?} {k}: {} {want}",
                    grads[k]
                );
            }
        }
    }

    #[test]
    fn a_small_network_has_the_loss_that_a_hand_computes() {
        // Score = 2 relu(x0 + x1 - 1) + 0.5; at (2, 1) it is 4.5 with slope (2, 2), at (0, 0) it is 0.5.
        let net = Perceptron::new(2, &[1]);
        let params = [1.0, 1.0, -1.0, 2.0, 0.5];
        let batch = Batch { clips: &[2.0, 1.0], policy: &[0.0, 0.0], mix: &[0.5], samples: 1, of: 1 };
        let config = AmpConfig { gradient_penalty: 10.0, score_penalty: 0.0, ..AmpConfig::default() };
        let mut grads = [0.0; 5];
        let sums = evaluate(&net, &params, &config, &batch, &mut Workspace::default(), &mut grads);
        // 0.5 (4.5 - 1)^2 + 0.5 (0.5 + 1)^2 = 6.125 + 1.125; 5 times the squared slope 8.
        assert_eq!((sums.penalty, sums.loss), (40.0, 47.25));
        assert_eq!((sums.clips, sums.policy, sums.policy_squares, sums.right), (4.5, 0.5, 0.25, 1.0));
        // The slope's gradient is 10 (2, 2): the score's weight gets 10 (2 + 2), in addition to 3.5 times the hidden output 2.
        assert_eq!(grads[3], 40.0 + 7.0);
        assert_eq!(grads[4], 3.5 + 1.5);
    }

    #[test]
    fn parts_of_a_step_add_up() {
        let net = Perceptron::new(6, &[9, 5]);
        let params = numbers(4, net.params());
        let config = AmpConfig::default();
        let (_, whole) = run(&config, &net, &params, 7);
        let (_, half) = run(&config, &net, &params, 14);
        for (a, b) in whole.iter().zip(&half) {
            assert!((a - 2.0 * b).abs() < 1e-12);
        }
    }
}
