//! Gaussian policy with a standard deviation per action that does not depend on the observation.

use paid_lanes::rng::philox;
use paid_lanes::{MAX_LANES, Mask, Real, Scalar};

use paid_policy::element::{Element, Lanewise, load, store, sum, sum_valid};
use paid_policy::matrix::{Mat, MatMut};

/// `ln(2 pi) / 2`.
pub const HALF_LN_TAU: f64 = 0.918_938_533_204_672_8;

/// Entropy of the policy `[nat]`: sum of `ln std + (1 + ln 2 pi) / 2` over the actions.
pub fn entropy<S: Scalar>(log_std: &[S]) -> f64 {
    log_std.iter().map(|x| x.to_f64() + 0.5 + HALF_LN_TAU).sum()
}

/// Logarithm of the probability density of one action vector.
pub fn log_prob(mean: &[f64], log_std: &[f64], action: &[f64]) -> f64 {
    let term = |k: usize| {
        let z = (action[k] - mean[k]) / log_std[k].exp();
        -0.5 * z * z - log_std[k] - HALF_LN_TAU
    };
    (0..mean.len()).map(term).sum()
}

/// Kullback-Leibler divergence of the Gaussian (`mean`, `log_std`) from the older one: KL(old || new), per rsl_rl's
/// adaptive schedule.
pub fn kl(old_mean: &[f64], old_log_std: &[f64], mean: &[f64], log_std: &[f64]) -> f64 {
    let term = |k: usize| {
        let (old_var, var) = ((2.0 * old_log_std[k]).exp(), (2.0 * log_std[k]).exp());
        let d = old_mean[k] - mean[k];
        log_std[k] - old_log_std[k] + (old_var + d * d) / (2.0 * var) - 0.5
    };
    (0..mean.len()).map(term).sum()
}

/// The place of a draw in the sequence of random numbers; equal keys give equal noise, whatever the thread or lane count.
#[derive(Clone, Copy, Debug)]
pub struct NoiseKey {
    /// Seed of the run.
    pub seed: u64,
    /// Number of the first environment among all shards.
    pub first_env: u32,
    /// Control steps since the start of training.
    pub step: u64,
}

/// Separates this use of the generator from others under the same seed.
const STREAM: u32 = 0x6163_7400;

/// Draws actions: `action = mean + exp(log_std) * noise`, `[actions, n]`, and their log probabilities `[n]`.
pub fn sample(
    key: NoiseKey,
    mean: Mat<'_, f32>,
    log_std: &[f32],
    action: MatMut<'_, f32>,
    log_prob: &mut [f32],
) {
    assert!(mean.rows() == log_std.len() && action.rows() == log_std.len(), "one log_std per action");
    assert!(mean.cols() == action.cols() && log_prob.len() == action.cols(), "equal batch sizes");
    f32::launch(Sample { key, mean, log_std, action, log_prob });
}

struct Sample<'a> {
    key: NoiseKey,
    mean: Mat<'a, f32>,
    log_std: &'a [f32],
    action: MatMut<'a, f32>,
    log_prob: &'a mut [f32],
}

impl Lanewise<f32> for Sample<'_> {
    type Output = ();
    #[inline(always)]
    fn run<V: Real<Scalar = f32>>(mut self) {
        let n = self.log_prob.len();
        let actions = self.log_std.len();
        let mut i = 0;
        while i < n {
            let mut log_prob = V::zero();
            for quad in 0..actions.div_ceil(4) {
                let noise = normals::<V>(self.key, i as u32, quad as u32);
                for k in 0..4.min(actions - 4 * quad) {
                    let a = 4 * quad + k;
                    let z = noise[k];
                    let log_std = V::splat(self.log_std[a]);
                    let mean = load::<V>(self.mean.row(a), i);
                    store(log_std.exp().mul_add(z, mean), self.action.row(a), i);
                    log_prob = log_prob - V::c(0.5) * z * z - log_std - V::c(HALF_LN_TAU);
                }
            }
            store(log_prob, self.log_prob, i);
            i += V::LANES;
        }
    }
}

/// Four standard normals per lane, by Box and Muller.
#[inline(always)]
fn normals<V: Real<Scalar = f32>>(key: NoiseKey, first: u32, quad: u32) -> [V; 4] {
    let seed = [key.seed as u32, (key.seed >> 32) as u32];
    let mut bits = [[0u32; MAX_LANES]; 4];
    for lane in 0..V::LANES {
        let env = key.first_env.wrapping_add(first).wrapping_add(lane as u32);
        let words = philox([env, key.step as u32, (key.step >> 32) as u32, STREAM + quad], seed);
        for k in 0..4 {
            bits[k][lane] = words[k];
        }
    }
    let (r0, a0) = polar::<V>(&bits[0], &bits[1]);
    let (r1, a1) = polar::<V>(&bits[2], &bits[3]);
    let ((s0, c0), (s1, c1)) = (a0.sin_cos(), a1.sin_cos());
    [r0 * c0, r0 * s0, r1 * c1, r1 * s1]
}

/// Radius `sqrt(-2 ln u)` and angle `2 pi v` from two words of random bits.
#[inline(always)]
fn polar<V: Real<Scalar = f32>>(u: &[u32; MAX_LANES], v: &[u32; MAX_LANES]) -> (V, V) {
    let mut exponent = [0.0f32; MAX_LANES];
    let mut mantissa = [0.0f32; MAX_LANES];
    let mut angle = [0.0f32; MAX_LANES];
    for lane in 0..V::LANES {
        // u in (0, 1): the half keeps it from zero. Split it as mantissa in [sqrt(1/2), sqrt(2)) times a power of two.
        let uniform = ((u[lane] >> 8) as i32 as f32 + 0.5) * (1.0 / 16_777_216.0);
        let shifted = uniform.to_bits().wrapping_sub(0x3F35_04F3);
        exponent[lane] = (shifted as i32 >> 23) as f32;
        mantissa[lane] = f32::from_bits((shifted & 0x007F_FFFF) + 0x3F35_04F3);
        angle[lane] = (v[lane] >> 8) as i32 as f32 * (core::f32::consts::TAU / 16_777_216.0);
    }
    let (e, m) = (V::load(&exponent), V::load(&mantissa));
    // ln m = 2 artanh((m - 1) / (m + 1)), series to the ninth power: |argument| < 0.172, remainder below 1e-9.
    let s = (m - V::one()) / (m + V::one());
    let z = s * s;
    let p = V::c(2.0 / 9.0).mul_add(z, V::c(2.0 / 7.0)).mul_add(z, V::c(2.0 / 5.0));
    let p = p.mul_add(z, V::c(2.0 / 3.0)).mul_add(z, V::c(2.0));
    let ln = e.mul_add(V::c(core::f64::consts::LN_2), p * s);
    ((ln * V::c(-2.0)).max(V::zero()).sqrt(), V::load(&angle))
}

/// What the actor's loss reads of a batch of `n` samples.
#[derive(Clone, Copy, Debug)]
pub struct ActorBatch<'a, S> {
    /// Actions taken, `[actions, n]`.
    pub action: Mat<'a, S>,
    /// Means when they were taken, `[actions, n]`.
    pub old_mean: Mat<'a, S>,
    /// Logarithm of the standard deviations when they were taken, `[actions]`.
    pub old_log_std: &'a [S],
    /// Their log probabilities then, `[n]`.
    pub old_log_prob: &'a [S],
    /// Advantages before normalization, `[n]`.
    pub advantage: &'a [S],
}

/// Constants of the actor's loss.
#[derive(Clone, Copy, Debug)]
pub struct ActorLossConfig {
    /// Clip range of the probability ratio.
    pub clip: f64,
    /// Mean of the advantages, subtracted.
    pub advantage_mean: f64,
    /// Factor on the centered advantages.
    pub advantage_scale: f64,
    /// Weight of each sample: 1 / (samples of the minibatch).
    pub weight: f64,
}

/// Sums over samples.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ActorLoss {
    /// Clipped surrogate loss (sum, not weighted).
    pub surrogate: f64,
    /// Divergence from the old policy.
    pub kl: f64,
    /// Samples whose ratio lies outside the clip range.
    pub clipped: f64,
}

/// Clipped surrogate loss `max(-A r, -A clip(r, 1 - eps, 1 + eps))` (Schulman et al. 2017): writes its weighted gradient
/// with respect to the means to `dmean` and adds that of `log_std` to `dlog_std`. `scratch` holds at least `n`.
///
/// Inside the clip range both branches agree and the gradient passes, whatever way rounding tips their comparison.
pub fn actor_loss<S: Element>(
    config: ActorLossConfig,
    mean: Mat<'_, S>,
    log_std: &[S],
    batch: ActorBatch<'_, S>,
    dmean: MatMut<'_, S>,
    dlog_std: &mut [S],
    scratch: &mut [S],
) -> ActorLoss {
    let n = batch.advantage.len();
    assert!(mean.cols() == n && batch.action.cols() == n && batch.old_mean.cols() == n, "equal batch sizes");
    assert!(batch.old_log_prob.len() == n && dmean.cols() == n && scratch.len() >= n, "equal batch sizes");
    S::launch(ActorKernel { config, mean, log_std, batch, dmean, dlog_std, scratch: &mut scratch[..n] })
}

struct ActorKernel<'a, S> {
    config: ActorLossConfig,
    mean: Mat<'a, S>,
    log_std: &'a [S],
    batch: ActorBatch<'a, S>,
    dmean: MatMut<'a, S>,
    dlog_std: &'a mut [S],
    scratch: &'a mut [S],
}

impl<S: Element> Lanewise<S> for ActorKernel<'_, S> {
    type Output = ActorLoss;
    #[inline(always)]
    fn run<V: Real<Scalar = S>>(mut self) -> ActorLoss {
        let n = self.scratch.len();
        let actions = self.log_std.len();
        let batch = self.batch;
        let mut log_norm = 0.0;
        let mut kl_constant = 0.0;
        for a in 0..actions {
            let (new, old) = (self.log_std[a].to_f64(), batch.old_log_std[a].to_f64());
            log_norm += new + HALF_LN_TAU;
            kl_constant += new - old + 0.5 * ((2.0 * (old - new)).exp() - 1.0);
        }
        let (lo, hi) = (V::c(1.0 - self.config.clip), V::c(1.0 + self.config.clip));
        let mut totals = ActorLoss::default();
        let mut i = 0;
        while i < n {
            let mut squares = V::zero();
            let mut moved = V::zero();
            for a in 0..actions {
                let inv_std = (-V::splat(self.log_std[a])).exp();
                let mean = load::<V>(self.mean.row(a), i);
                let z = (load::<V>(batch.action.row(a), i) - mean) * inv_std;
                let d = (load::<V>(batch.old_mean.row(a), i) - mean) * inv_std;
                squares = z.mul_add(z, squares);
                moved = d.mul_add(d, moved);
            }
            let log_prob = squares.mul_add(V::c(-0.5), V::c(-log_norm));
            // The bounds keep a policy that has run away from overflowing; the ratio is far outside the clip range there.
            let change = log_prob - load::<V>(batch.old_log_prob, i);
            let ratio = change.clamp(V::c(-20.0), V::c(20.0)).exp();
            let advantage = (load::<V>(batch.advantage, i) - V::c(self.config.advantage_mean))
                * V::c(self.config.advantage_scale);
            let free = -(advantage * ratio);
            let clipped = -(advantage * ratio.clamp(lo, hi));
            let outside = ratio.lt(lo).or(hi.lt(ratio));
            let stopped = outside.and(free.lt(clipped));
            let gradient = V::select(stopped, V::zero(), free * V::c(self.config.weight));
            store(gradient, self.scratch, i);
            totals.surrogate += sum_valid(free.max(clipped), i, n);
            totals.kl += sum_valid(moved.mul_add(V::c(0.5), V::c(kl_constant)), i, n);
            let count = V::select(outside, V::one(), V::zero());
            totals.clipped += sum_valid(count, i, n);
            i += V::LANES;
        }
        for a in 0..actions {
            let inv_std = (-V::splat(self.log_std[a])).exp();
            let mut total = V::zero();
            let mut i = 0;
            while i < n {
                let z = (load::<V>(batch.action.row(a), i) - load::<V>(self.mean.row(a), i)) * inv_std;
                let g = load::<V>(self.scratch, i);
                store(g * z * inv_std, self.dmean.row(a), i);
                total += g * (z * z - V::one());
                i += V::LANES;
            }
            let place = &mut self.dlog_std[a];
            *place = S::from_f64(place.to_f64() + sum(total));
        }
        totals
    }
}
