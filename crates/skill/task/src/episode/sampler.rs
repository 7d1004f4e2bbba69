//! Adaptive sampling of (motion, phase bin) pairs: more episodes begin where failures happen.

use serde::{Deserialize, Serialize};

use crate::preset::SamplingPreset;

/// The failure histogram and the distribution that follows from it. Shards count failures; the trainer adds them up in a
/// fixed order, calls [`SamplerState::update`] and hands the result to every shard.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SamplerState {
    /// Number of motions.
    pub motions: usize,
    /// Phase bins per motion: whole seconds of the longest clip plus 1 (release).
    pub bins: usize,
    /// Exponential average of the failures, `[motion][bin]` flattened.
    pub failures: Vec<f32>,
    /// Probability of each pair, same order; sums to 1.
    pub probabilities: Vec<f32>,
}

impl SamplerState {
    /// Uniform over all pairs.
    pub fn uniform(motions: usize, bins: usize) -> Self {
        let pairs = motions * bins;
        let probabilities = vec![1.0 / pairs as f32; pairs];
        Self { motions, bins, failures: vec![0.0; pairs], probabilities }
    }

    /// Adds the failure counts of an iteration to the average and recomputes the probabilities:
    /// `p = u / N + (1 - u) smooth(F) / sum smooth(F)`, where smoothing gives a bin the failures of the `kernel_size` bins
    /// from itself on, weighted by `kernel_ratio^k` (the last bin is continued beyond the end).
    ///
    /// # Panics
    /// If `counts` has another length than the histogram.
    pub fn update(&mut self, counts: &[f32], preset: &SamplingPreset) {
        assert_eq!(counts.len(), self.failures.len(), "failure counts of another library");
        let alpha = preset.alpha as f32;
        for (average, count) in self.failures.iter_mut().zip(counts) {
            *average += alpha * (count - *average);
        }
        let mut smooth = vec![0.0_f64; self.failures.len()];
        for motion in 0..self.motions {
            let row = &self.failures[motion * self.bins..][..self.bins];
            for bin in 0..self.bins {
                let mut weight = 1.0;
                let mut total = 0.0;
                for k in 0..preset.kernel_size {
                    smooth[motion * self.bins + bin] += weight * f64::from(row[(bin + k).min(self.bins - 1)]);
                    total += weight;
                    weight *= preset.kernel_ratio;
                }
                smooth[motion * self.bins + bin] /= total;
            }
        }
        if preset.phase_only {
            for row in smooth.chunks_mut(self.bins) {
                let sum: f64 = row.iter().sum();
                let even = 1.0 / row.len() as f64;
                row.iter_mut().for_each(|s| *s = if sum > 1e-12 { *s / sum } else { even });
            }
        }
        let sum: f64 = smooth.iter().sum();
        let uniform = 1.0 / smooth.len() as f64;
        for (p, s) in self.probabilities.iter_mut().zip(&smooth) {
            let adaptive = if sum > 1e-12 { s / sum } else { uniform };
            *p = (preset.uniform_mass * uniform + (1.0 - preset.uniform_mass) * adaptive) as f32;
        }
    }

    /// The pair at `unit` in [0, 1) of the cumulative distribution: (motion, bin).
    pub fn draw(&self, unit: f64) -> (usize, usize) {
        let mut rest = unit;
        for (pair, p) in self.probabilities.iter().enumerate() {
            rest -= f64::from(*p);
            if rest < 0.0 {
                return (pair / self.bins, pair % self.bins);
            }
        }
        (self.motions - 1, self.bins - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn preset() -> SamplingPreset {
        SamplingPreset {
            uniform_mass: 0.6,
            alpha: 0.5,
            kernel_size: 3,
            kernel_ratio: 0.1,
            first_frame_share: 0.0,
            latest_start_before_strike_s: -1.0,
            miss_sampling_weight: 0.0,
            stop_after_kick_s: 0.0,
            stop_share: 0.0,
            after_strike_share: 0.0,
            from_last_pose_share: 0.0,
            from_end_state_share: 0.0,
            phase_only: false,
        }
    }

    #[test]
    fn failures_raise_their_bin_and_the_ones_before_it() {
        let mut sampler = SamplerState::uniform(1, 4);
        sampler.update(&[0.0, 0.0, 8.0, 0.0], &preset());
        assert_eq!(sampler.failures, [0.0, 0.0, 4.0, 0.0]);
        // Smoothed, times 1.11: 0.04, 0.4, 4, 0; sum 4.44.
        let expected = [0.15 + 0.4 * 0.04 / 4.44, 0.15 + 0.4 * 0.4 / 4.44, 0.15 + 0.4 * 4.0 / 4.44, 0.15];
        for (p, e) in sampler.probabilities.iter().zip(expected) {
            assert!((f64::from(*p) - e).abs() < 1e-6, "{p} {e}");
        }
    }

    #[test]
    fn phases_only_draw_every_motion_alike() {
        let mut sampler = SamplerState::uniform(3, 2);
        let preset = SamplingPreset { uniform_mass: 0.0, kernel_size: 1, phase_only: true, ..preset() };
        sampler.update(&[0.0, 8.0, 3.0, 1.0, 0.0, 0.0], &preset);
        let expected = [0.0, 1.0, 0.75, 0.25, 0.5, 0.5].map(|share: f64| share / 3.0);
        for (p, e) in sampler.probabilities.iter().zip(expected) {
            assert!((f64::from(*p) - e).abs() < 1e-6, "{p} {e}");
        }
    }

    #[test]
    fn draws_follow_the_distribution() {
        let mut sampler = SamplerState::uniform(2, 2);
        sampler.probabilities = vec![0.25, 0.0, 0.5, 0.25];
        assert_eq!(sampler.draw(0.0), (0, 0));
        assert_eq!(sampler.draw(0.26), (1, 0));
        assert_eq!(sampler.draw(0.74), (1, 0));
        assert_eq!(sampler.draw(0.76), (1, 1));
        assert_eq!(sampler.draw(0.999_999_99), (1, 1));
    }

    #[test]
    fn without_failures_the_distribution_is_uniform() {
        let mut sampler = SamplerState::uniform(3, 2);
        sampler.update(&[0.0; 6], &preset());
        assert!(sampler.probabilities.iter().all(|p| (p - 1.0 / 6.0).abs() < 1e-7));
    }
}
