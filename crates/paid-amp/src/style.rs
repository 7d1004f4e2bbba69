//! The style reward: a discriminator in the learner.

use std::sync::Arc;

use paid_lanes::rng::Rng;
use paid_learn::adam::AdamStep;
use paid_learn::parallel::for_each;
use paid_learn::{LearnedReward, Transitions};

use crate::clips::Clips;
use crate::config::{AmpConfig, Formulation};
use crate::network::{Perceptron, Tape};
use crate::objective::{Batch, Sums, Workspace, evaluate};
use crate::replay::Replay;
use crate::{AmpError, GROUP};

/// Streams of the random number generator.
const INIT_STREAM: u32 = 0x616D_7069;
const DRAW_STREAM: u32 = 0x616D_7064;
/// Parts of a step whose gradients are summed apart, so that threads do not change the sum.
const PARTS: usize = 8;
/// Draws for a pair that ends no episode, before a step goes without.
const TRIES: usize = 1000;

/// A reward for moving like the clips, by a discriminator that learns to tell them from the policy.
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
            clips,
        })
    }

    /// The reward of a score.
    fn pays(&self, score: f32) -> f32 {
        match self.config.formulation {
            Formulation::LeastSquares => (1.0 - 0.25 * (score - 1.0).powi(2)).max(0.0),
            Formulation::Wasserstein => 1.0 + (0.4 * score).tanh(),
        }
    }

    /// The policy's pair of step `t` of environment `e`, scaled.
    fn pair(&self, transitions: &Transitions, group: usize, t: usize, e: usize, out: &mut [f32]) {
        let features = self.clips.features();
        for (half, frame) in [transitions.before(group, t), transitions.after(group, t)].iter().enumerate() {
            for i in 0..features {
                out[half * features + i] = self.clips.scaled(i, frame.row(i)[e]);
            }
        }
    }

    /// Draws a pair of the last horizon; `None` if hardly any step goes on.
    fn draw(&mut self, shards: &[&Transitions], out: &mut [f32]) -> Option<()> {
        for _ in 0..TRIES {
            let transitions = shards[self.rng.below(shards.len())];
            let (t, e) = (self.rng.below(transitions.steps()), self.rng.below(transitions.envs()));
            if transitions.done(t)[e] == 0 {
                let group = transitions.group(GROUP)?;
                self.pair(transitions, group, t, e, out);
                return Some(());
            }
        }
        None
    }

    /// Parts of a step: inputs as matrices with samples as columns.
    fn parts(&mut self, shards: &[&Transitions]) -> Option<Vec<Part>> {
        let (batch, width) = (self.config.batch, self.net.input());
        let parts = PARTS.min(batch);
        let clips = Arc::clone(&self.clips);
        let mut pair = vec![0.0; width];
        let mut all = Vec::with_capacity(parts);
        for part in 0..parts {
            let samples = batch * (part + 1) / parts - batch * part / parts;
            let mut out = Part::new(width, samples, self.params.len());
            for k in 0..samples {
                let put = |to: &mut [f32], pair: &[f32]| {
                    for (i, x) in pair.iter().enumerate() {
                        to[i * samples + k] = *x;
                    }
                };
                put(&mut out.clips, clips.draw(&mut self.rng));
                if k % 2 == 1 && !self.replay.is_empty() {
                    put(&mut out.policy, self.replay.draw(&mut self.rng));
                } else {
                    self.draw(shards, &mut pair)?;
                    put(&mut out.policy, &pair);
                    self.replay.push(&pair);
                }
                out.mix[k] = self.rng.unit() as f32;
            }
            all.push(out);
        }
        Some(all)
    }

    fn step(&mut self, mut parts: Vec<Part>, threads: usize) {
        let of = self.config.batch;
        let (net, params, config) = (&self.net, &self.params, &self.config);
        let mut workers = vec![Workspace::default(); threads.clamp(1, parts.len())];
        for_each(&mut workers, parts.iter_mut().collect(), |work, part: &mut Part| {
            let Part { clips, policy, mix, grads, sums } = part;
            let batch = Batch { clips, policy, mix, samples: mix.len(), of };
            *sums = evaluate(net, params, config, &batch, work, grads);
        });
        let mut gradient = vec![0.0; self.params.len()];
        self.last = Sums::default();
        for part in &parts {
            self.last.add(&part.sums);
            for (sum, x) in gradient.iter_mut().zip(&part.grads) {
                *sum += x;
            }
        }
        for range in self.net.all_weights() {
            for (sum, weight) in gradient[range.clone()].iter_mut().zip(&self.params[range]) {
                *sum += config.weight_decay as f32 * weight;
            }
        }
        if !gradient.iter().all(|x| x.is_finite()) {
            return;
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
                *out = if *done == 0 { self.pays(*score) } else { 0.0 };
            }
        }
    }

    fn train(&mut self, shards: &[&Transitions], threads: usize) {
        if shards.is_empty() {
            return;
        }
        for _ in 0..self.config.steps {
            let Some(parts) = self.parts(shards) else { return };
            self.step(parts, threads);
        }
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
        let counts = counts.iter().flat_map(|count| count.to_le_bytes());
        counts.chain(words.flat_map(|x| x.to_le_bytes())).collect()
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), String> {
        let params = self.params.len();
        let (counts, words) = bytes.split_at_checked(32).ok_or("expected 32 bytes of counts, found fewer")?;
        let counts: Vec<u64> =
            counts.chunks_exact(8).map(|w| u64::from_le_bytes(core::array::from_fn(|i| w[i]))).collect();
        let numbers: Vec<f32> =
            words.chunks_exact(4).map(|w| f32::from_le_bytes(core::array::from_fn(|i| w[i]))).collect();
        let expected = 3 * params + counts[3] as usize;
        if words.len() != 4 * expected {
            return Err(format!("expected {expected} numbers, found {} bytes", words.len()));
        }
        self.replay.restore(numbers[3 * params..].to_vec(), counts[2] as usize)?;
        self.params.copy_from_slice(&numbers[..params]);
        self.moments[0].copy_from_slice(&numbers[params..2 * params]);
        self.moments[1].copy_from_slice(&numbers[2 * params..3 * params]);
        self.steps = counts[0];
        self.rng.seek(counts[1]);
        Ok(())
    }

    fn boxed(&self) -> Box<dyn LearnedReward> {
        Box::new(self.clone())
    }
}
