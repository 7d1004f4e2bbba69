//! The style reward: a discriminator in the learner.

use std::sync::Arc;

use paid_lanes::rng::Rng;
use paid_learn::adam::AdamStep;
use paid_learn::parallel::for_each;
use paid_learn::ranks::gather_numbers;
use paid_learn::{LearnedReward, Ranks, Transitions};

use crate::clips::Clips;
use crate::config::{AmpConfig, Formulation};
use crate::horizon::Horizon;
use crate::network::{Perceptron, Tape};
use crate::objective::{Batch, Sums, Workspace, evaluate};
use crate::replay::Replay;
use crate::{AmpError, GROUP};

/// Streams of the random number generator.
const INIT_STREAM: u32 = 0x616D_7069;
const DRAW_STREAM: u32 = 0x616D_7064;
/// Parts of a step whose gradients are summed apart, so that threads do not change the sum.
const PARTS: usize = 8;

/// A reward for moving like the clips, by a discriminator that learns to distinguish them from the policy.
///
/// It reads the observation group [`GROUP`] before and after each control step. A step that ends an episode is paid nothing and
/// teaches nothing, because the next episode's first frame follows it.
#[derive(Clone, Debug)]
pub struct StyleReward {
    config: AmpConfig,
    clips: Arc<Clips>,
    net: Perceptron,
    params: Vec<f32>,
    moments: [Vec<f32>; 2],
    steps: u64,
    replay: Replay,
    rng: Rng,
    last: Sums,
    usual: Usual,
}

/// The policy's scores in the last step's pairs, its own and the replayed ones.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Usual {
    mean: f64,
    deviation: f64,
}

impl Usual {
    /// Before the first step.
    const UNKNOWN: Self = Self { mean: 0.0, deviation: 1.0 };
    /// Scores that hardly differ are not blown up.
    const LEAST_DEVIATION: f64 = 1e-3;

    fn new(sums: &Sums, count: f64) -> Self {
        let mean = sums.policy / count;
        let variance = sums.policy_squares / count - mean * mean;
        Self { mean, deviation: variance.max(0.0).sqrt().max(Self::LEAST_DEVIATION) }
    }

    /// How many deviations a score lies above the mean.
    fn above(&self, score: f32) -> f32 {
        ((f64::from(score) - self.mean) / self.deviation) as f32
    }
}

impl StyleReward {
    /// A fresh discriminator.
    ///
    /// # Errors
    /// The first value of the configuration that is out of range.
    pub fn new(clips: Arc<Clips>, config: &AmpConfig, seed: u64) -> Result<Self, AmpError> {
        config.check()?;
        let width = 2 * clips.features();
        let net = Perceptron::new(width, &config.hidden);
        let params = net.initialize(&mut Rng::new(seed, 0, INIT_STREAM));
        let zeros = vec![0.0; params.len()];
        Ok(Self {
            config: config.clone(),
            moments: [zeros.clone(), zeros],
            net,
            params,
            steps: 0,
            replay: Replay::new(width, config.replay),
            rng: Rng::new(seed, 0, DRAW_STREAM),
            last: Sums::default(),
            usual: Usual::UNKNOWN,
            clips,
        })
    }

    /// The reward of a score.
    fn reward_of(&self, score: f32) -> f32 {
        match self.config.formulation {
            Formulation::LeastSquares => (1.0 - 0.25 * (score - 1.0).powi(2)).max(0.0),
            Formulation::Wasserstein => 1.0 + (0.4 * self.usual.above(score)).tanh(),
        }
    }

    /// Parts of a step: inputs as matrices with samples as columns. All ranks draw the same, and each gives the pairs of its own
    /// environments.
    fn parts(&mut self, horizon: &Horizon<'_>, ranks: &dyn Ranks) -> Option<Vec<Part>> {
        let (batch, width) = (self.config.batch, self.net.input());
        let clips = Arc::clone(&self.clips);
        let (mut drawn, mut fresh) = (Vec::with_capacity(batch), Vec::new());
        for k in 0..batch {
            let clip = clips.draw(&mut self.rng);
            let place = if k % 2 == 1 && !self.replay.is_empty() {
                self.replay.draw(&mut self.rng)
            } else {
                let Some(step) = horizon.draw(&mut self.rng) else { break };
                fresh.push((self.replay.place(), step));
                fresh[fresh.len() - 1].0
            };
            drawn.push((clip, place, self.rng.unit() as f32));
        }
        let mut pairs = vec![0.0; width * fresh.len()];
        for (pair, (_, step)) in pairs.chunks_exact_mut(width).zip(&fresh) {
            horizon.pair(*step, &clips, pair);
        }
        ranks.sum(&mut pairs);
        for (pair, (place, _)) in pairs.chunks_exact(width).zip(&fresh) {
            self.replay.put(*place, pair);
        }
        if drawn.len() < batch {
            return None;
        }
        let parts = PARTS.min(batch);
        let part = |part| {
            let drawn = &drawn[batch * part / parts..batch * (part + 1) / parts];
            let mut out = Part::new(width, drawn.len(), self.params.len());
            for (k, (clip, place, mix)) in drawn.iter().enumerate() {
                out.put(k, clip, self.replay.pair(*place), *mix);
            }
            out
        };
        Some((0..parts).map(part).collect())
    }

    /// A step of Adam. A rank evaluates every `count`-th part, from its own number on, and returns their sums.
    fn step(&mut self, mut parts: Vec<Part>, ranks: &dyn Ranks, threads: usize) -> Sums {
        let of = self.config.batch;
        let (net, params, config) = (&self.net, &self.params, &self.config);
        let mut workers = vec![Workspace::default(); threads.clamp(1, parts.len())];
        let own: Vec<&mut Part> = parts.iter_mut().skip(ranks.rank()).step_by(ranks.count()).collect();
        for_each(&mut workers, own, |work, part: &mut Part| {
            let Part { clips, policy, mix, grads, sums } = part;
            let batch = Batch { clips, policy, mix, samples: mix.len(), of };
            *sums = evaluate(net, params, config, &batch, work, grads);
        });
        let mut gradient = vec![0.0; self.params.len()];
        let mut sums = Sums::default();
        for part in &parts {
            sums.add(&part.sums);
            for (sum, x) in gradient.iter_mut().zip(&part.grads) {
                *sum += x;
            }
        }
        ranks.sum(&mut gradient);
        for range in self.net.all_weights() {
            for (sum, weight) in gradient[range.clone()].iter_mut().zip(&self.params[range]) {
                *sum += config.weight_decay as f32 * weight;
            }
        }
        if !gradient.iter().all(|x| x.is_finite()) {
            return sums;
        }
        self.steps += 1;
        let [m, v] = &mut self.moments;
        AdamStep {
            params: &mut self.params,
            m,
            v,
            gradient: &gradient,
            gradient_scale: 1.0,
            learning_rate: self.config.learning_rate,
            step: self.steps,
        }
        .apply();
        sums
    }
}

/// What one worker evaluates.
#[derive(Clone, Debug)]
struct Part {
    clips: Vec<f32>,
    policy: Vec<f32>,
    mix: Vec<f32>,
    grads: Vec<f32>,
    sums: Sums,
}

impl Part {
    fn new(width: usize, samples: usize, params: usize) -> Self {
        let zeros = vec![0.0; width * samples];
        Self {
            clips: zeros.clone(),
            policy: zeros,
            mix: vec![0.0; samples],
            grads: vec![0.0; params],
            sums: Sums::default(),
        }
    }

    fn put(&mut self, k: usize, clips: &[f32], policy: &[f32], mix: f32) {
        let samples = self.mix.len();
        for (to, pair) in [(&mut self.clips, clips), (&mut self.policy, policy)] {
            for (i, x) in pair.iter().enumerate() {
                to[i * samples + k] = *x;
            }
        }
        self.mix[k] = mix;
    }
}

impl LearnedReward for StyleReward {
    fn name(&self) -> &str {
        "style"
    }

    fn reward(&self, transitions: &Transitions, reward: &mut [f32]) {
        reward.fill(0.0);
        let Some(group) = transitions.group(GROUP) else { return };
        let (envs, features) = (transitions.envs(), self.clips.features());
        let mut x = vec![0.0; self.net.input() * envs];
        let mut tape = Tape::default();
        for t in 0..transitions.steps() {
            let frames = [transitions.before(group, t), transitions.after(group, t)];
            for (half, frame) in frames.iter().enumerate() {
                for i in 0..features {
                    let row = &mut x[(half * features + i) * envs..][..envs];
                    for (to, from) in row.iter_mut().zip(frame.row(i)) {
                        *to = self.clips.scaled(i, *from);
                    }
                }
            }
            self.net.forward(&self.params, &x, envs, &mut tape);
            let out = &mut reward[t * envs..(t + 1) * envs];
            for ((out, score), done) in out.iter_mut().zip(tape.scores()).zip(transitions.done(t)) {
                *out = if *done == 0 { self.reward_of(*score) } else { 0.0 };
            }
        }
    }

    fn train(&mut self, shards: &[&Transitions], ranks: &dyn Ranks, threads: usize) {
        let horizon = Horizon::new(shards, ranks);
        let mut last = None;
        for _ in 0..self.config.steps {
            let Some(parts) = self.parts(&horizon, ranks) else { break };
            last = Some(self.step(parts, ranks, threads));
        }
        // The figures are those of the last step, of all ranks.
        let Some(own) = last else { return };
        self.last = Sums::default();
        for sums in gather_numbers(ranks, &own.all()) {
            for (total, x) in self.last.all_mut().into_iter().zip(sums) {
                *total += x;
            }
        }
        self.usual = Usual::new(&self.last, self.config.batch as f64);
    }

    fn figures(&self) -> Vec<(String, f64)> {
        let (n, sums) = (self.config.batch as f64, &self.last);
        let figures = [
            ("loss", sums.loss / n),
            ("penalty", sums.penalty / n),
            ("score_clips", sums.clips / n),
            ("score_policy", sums.policy / n),
            ("told_apart", sums.right / (2.0 * n)),
        ];
        figures.map(|(name, value)| (name.to_owned(), value)).into()
    }

    fn save(&self) -> Vec<u8> {
        let (pairs, next) = self.replay.state();
        let counts = [self.steps, self.rng.position(), next as u64, pairs.len() as u64];
        let numbers = [&self.params, &self.moments[0], &self.moments[1]].map(Vec::as_slice);
        let words = numbers.into_iter().chain([pairs]).flatten();
        let usual = [self.usual.mean, self.usual.deviation].map(f64::to_bits);
        let counts = counts.iter().chain(&usual).flat_map(|count| count.to_le_bytes());
        counts.chain(words.flat_map(|x| x.to_le_bytes())).collect()
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), String> {
        let params = self.params.len();
        let (head, words) = bytes.split_at_checked(48).ok_or("expected 48 bytes of counts, found fewer")?;
        let counts: Vec<u64> =
            head.chunks_exact(8).map(|w| u64::from_le_bytes(core::array::from_fn(|i| w[i]))).collect();
        let numbers: Vec<f32> =
            words.chunks_exact(4).map(|w| f32::from_le_bytes(core::array::from_fn(|i| w[i]))).collect();
        let expected = usize::try_from(counts[3]).ok().and_then(|pairs| pairs.checked_add(3 * params));
        if expected.and_then(|numbers| numbers.checked_mul(4)) != Some(words.len()) {
            return Err(format!(
                "expected {} numbers and {} of earlier pairs, found {} bytes",
                3 * params,
                counts[3],
                words.len()
            ));
        }
        self.replay.restore(numbers[3 * params..].to_vec(), counts[2] as usize)?;
        self.params.copy_from_slice(&numbers[..params]);
        self.moments[0].copy_from_slice(&numbers[params..2 * params]);
        self.moments[1].copy_from_slice(&numbers[2 * params..3 * params]);
        self.steps = counts[0];
        self.rng.seek(counts[1]);
        let [mean, deviation] = [counts[4], counts[5]].map(f64::from_bits);
        self.usual = Usual { mean, deviation };
        Ok(())
    }

    fn boxed(&self) -> Box<dyn LearnedReward> {
        Box::new(self.clone())
    }
}
