//! Running mean and standard deviation of observations.

use paid_lanes::{Mask, Real};

use crate::element::{Element, Lanewise, load, store, sum_valid};
use crate::matrix::{Mat, MatMut};

/// Added to the standard deviation, as rsl_rl does: a constant feature stays near zero instead of blowing up noise.
pub const EPSILON: f64 = 1e-2;

/// Count, mean and sum of squared deviations of each feature.
#[derive(Clone, Debug, PartialEq)]
pub struct Moments {
    /// Number of samples.
    pub count: f64,
    /// Mean per feature.
    pub mean: Vec<f64>,
    /// Sum of squared deviations from the mean, per feature.
    pub m2: Vec<f64>,
}

impl Moments {
    /// No samples of `features` features.
    pub fn new(features: usize) -> Self {
        Self { count: 0.0, mean: vec![0.0; features], m2: vec![0.0; features] }
    }

    /// Checks that samples can have these moments.
    ///
    /// # Errors
    /// The number that none have, with its place, what was expected and what was found.
    pub fn check(&self) -> Result<(), String> {
        let not_negative =
            |name: &str, values: &[f64]| match values.iter().position(|x| x.is_nan() || *x < 0.0) {
                Some(k) => Err(format!("{name}: element {k}: expected 0 or more, found {}", values[k])),
                None => Ok(()),
            };
        not_negative("count", &[self.count])?;
        not_negative("m2", &self.m2)?;
        if self.count == 0.0 {
            for (name, values) in [("mean", &self.mean), ("m2", &self.m2)] {
                if let Some(k) = values.iter().position(|x| *x != 0.0) {
                    return Err(format!(
                        "{name}: element {k}: expected 0 without samples, found {}",
                        values[k]
                    ));
                }
            }
        }
        Ok(())
    }

    /// Adds the samples of `other` (Chan, Golub and LeVeque 1979).
    pub fn merge(&mut self, other: &Self) {
        let count = self.count + other.count;
        if other.count == 0.0 {
            return;
        }
        for k in 0..self.mean.len() {
            let delta = other.mean[k] - self.mean[k];
            self.mean[k] += delta * other.count / count;
            self.m2[k] += other.m2[k] + delta * delta * self.count * other.count / count;
        }
        self.count = count;
    }
}

/// `(x - mean) / (std + 0.01)` per feature. The statistics are frozen while samples are collected; what an iteration saw is
/// merged at its end. Before the first samples the mean is 0 and the standard deviation 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Normalizer {
    moments: Moments,
    mean: Vec<f32>,
    inv_std: Vec<f32>,
}

/// What one shard saw in one iteration: sums of the normalized values.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NormalizerBatch {
    count: f64,
    sum: Vec<f64>,
    squares: Vec<f64>,
    /// Values that were not finite; they were replaced by zero.
    pub non_finite: u64,
}

impl NormalizerBatch {
    /// Nothing seen of `features` features.
    pub fn new(features: usize) -> Self {
        Self { count: 0.0, sum: vec![0.0; features], squares: vec![0.0; features], non_finite: 0 }
    }

    /// What it saw as numbers, for another process: the count, then the sums of each feature. See [`NormalizerBatch::from_numbers`].
    pub fn numbers(&self) -> impl Iterator<Item = f64> {
        core::iter::once(self.count).chain(self.sum.iter().copied()).chain(self.squares.iter().copied())
    }

    /// A batch from the first `1 + 2 features` of [`NormalizerBatch::numbers`]; values that were not finite are not counted again.
    pub fn from_numbers(features: usize, numbers: &mut impl Iterator<Item = f64>) -> Self {
        let count = numbers.next().unwrap_or(0.0);
        let mut some = || numbers.by_ref().take(features).collect();
        Self { count, sum: some(), squares: some(), non_finite: 0 }
    }
}

impl Normalizer {
    /// A normalizer that has seen nothing.
    pub fn new(features: usize) -> Self {
        Self::from_moments(Moments::new(features))
    }

    /// A normalizer with given statistics.
    pub fn from_moments(moments: Moments) -> Self {
        let mut normalizer = Self { mean: Vec::new(), inv_std: Vec::new(), moments };
        normalizer.refresh();
        normalizer
    }

    /// A normalizer that applies these numbers, without the statistics that they come from: those of one sample with this mean and deviation
    /// stand in for them.
    pub fn frozen(mean: Vec<f32>, inv_std: Vec<f32>) -> Self {
        let square = |&factor: &f32| (1.0 / f64::from(factor) - EPSILON).powi(2);
        let moments = Moments {
            count: 1.0,
            mean: mean.iter().map(|&x| f64::from(x)).collect(),
            m2: inv_std.iter().map(square).collect(),
        };
        Self { moments, mean, inv_std }
    }

    /// The statistics.
    pub fn moments(&self) -> &Moments {
        &self.moments
    }

    /// Mean per feature, as applied.
    pub fn mean(&self) -> &[f32] {
        &self.mean
    }

    /// Factor per feature, `1 / (std + 0.01)`, as applied.
    pub fn inv_std(&self) -> &[f32] {
        &self.inv_std
    }

    fn std(&self, k: usize) -> f64 {
        if self.moments.count > 0.0 { (self.moments.m2[k] / self.moments.count).sqrt() } else { 1.0 }
    }

    fn refresh(&mut self) {
        self.mean = self.moments.mean.iter().map(|&x| x as f32).collect();
        self.inv_std = if self.moments.count > 0.0 {
            (0..self.mean.len()).map(|k| (1.0 / (self.std(k) + EPSILON)) as f32).collect()
        } else {
            vec![1.0; self.mean.len()]
        };
    }

    /// Normalizes `x` `[features, n]` into `out`; values that are not finite become zero. Counts what it saw in `batch`.
    pub fn apply(&self, x: Mat<'_, f32>, out: MatMut<'_, f32>, batch: Option<&mut NormalizerBatch>) {
        assert!(
            x.rows() == self.mean.len() && out.rows() == x.rows() && out.cols() == x.cols(),
            "equal shapes"
        );
        f32::launch(Apply { normalizer: self, x, out, batch });
    }

    /// Merges what the shards saw, in their order.
    pub fn merge<'a>(&mut self, batches: impl IntoIterator<Item = &'a NormalizerBatch>) {
        let old = (self.mean.clone(), self.inv_std.clone());
        for part in batches {
            if part.count == 0.0 {
                continue;
            }
            let mut batch = Moments::new(self.mean.len());
            batch.count = part.count;
            for k in 0..self.mean.len() {
                let scale = 1.0 / f64::from(old.1[k]);
                let mean = part.sum[k] / part.count;
                batch.mean[k] = f64::from(old.0[k]) + mean * scale;
                batch.m2[k] = (part.squares[k] - part.count * mean * mean).max(0.0) * scale * scale;
            }
            self.moments.merge(&batch);
        }
        self.refresh();
    }
}

struct Apply<'a, 'b> {
    normalizer: &'a Normalizer,
    x: Mat<'a, f32>,
    out: MatMut<'a, f32>,
    batch: Option<&'b mut NormalizerBatch>,
}

impl Lanewise<f32> for Apply<'_, '_> {
    type Output = ();
    #[inline(always)]
    fn run<V: Real<Scalar = f32>>(mut self) {
        let n = self.x.cols();
        let mut non_finite = 0;
        for r in 0..self.x.rows() {
            let mean = V::splat(self.normalizer.mean[r]);
            let inv_std = V::splat(self.normalizer.inv_std[r]);
            let row = self.x.row(r);
            let out = self.out.row(r);
            let (mut sum, mut squares) = (V::zero(), V::zero());
            let whole = n - n % V::LANES;
            let mut i = 0;
            while i < n {
                let mut z = (load::<V>(row, i) - mean) * inv_std;
                let finite = z.is_finite();
                if finite.not().any() {
                    non_finite += u64::from(finite.not().bits().count_ones());
                    z = V::select(finite, z, V::zero());
                }
                store(z, out, i);
                if i < whole {
                    sum += z;
                    squares = z.mul_add(z, squares);
                }
                i += V::LANES;
            }
            if let Some(batch) = &mut self.batch {
                batch.sum[r] += sum_valid(sum, 0, V::LANES);
                batch.squares[r] += sum_valid(squares, 0, V::LANES);
                for &z in &out[whole..] {
                    batch.sum[r] += f64::from(z);
                    batch.squares[r] += f64::from(z) * f64::from(z);
                }
            }
        }
        if let Some(batch) = self.batch {
            batch.count += n as f64;
            batch.non_finite += non_finite;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use paid_lanes::rng::Rng;

    #[test]
    fn running_statistics_match_the_direct_formula() {
        let (features, n, batches) = (3, 21, 7);
        let mut rng = Rng::new(1, 0, 0);
        let mut all = vec![Vec::new(); features];
        let mut normalizer = Normalizer::new(features);
        for _ in 0..batches {
            let mut parts = Vec::new();
            for _ in 0..2 {
                let x: Vec<f32> = (0..features * n)
                    .map(|i| (rng.normal() * [0.1, 3.0, 20.0][i / n] + [5.0, -1.0, 100.0][i / n]) as f32)
                    .collect();
                for f in 0..features {
                    all[f].extend(x[f * n..(f + 1) * n].iter().map(|&x| f64::from(x)));
                }
                let mut out = vec![0.0; features * n];
                let mut seen = NormalizerBatch::new(features);
                normalizer.apply(
                    Mat::new(&x, features, n, n),
                    MatMut::new(&mut out, features, n, n),
                    Some(&mut seen),
                );
                parts.push(seen);
            }
            normalizer.merge(&parts);
        }
        for f in 0..features {
            let count = all[f].len() as f64;
            let mean = all[f].iter().sum::<f64>() / count;
            let var = all[f].iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / count;
            assert!((normalizer.moments().mean[f] - mean).abs() < 1e-5 * mean.abs().max(1.0));
            assert!((normalizer.moments().m2[f] / count / var - 1.0).abs() < 1e-4, "feature {f}");
            let factor = f64::from(normalizer.inv_std()[f]);
            assert!((factor * (var.sqrt() + 0.01) - 1.0).abs() < 1e-4);
        }
    }

    #[test]
    fn moments_that_no_samples_have_are_refused() {
        let of =
            |count, mean: &[f64], m2: &[f64]| Moments { count, mean: mean.into(), m2: m2.into() }.check();
        assert_eq!(of(4.0, &[-1.0, 2.0], &[0.0, 3.0]), Ok(()));
        assert_eq!(Moments::new(2).check(), Ok(()));
        for (count, mean, m2, text) in [
            (-1.0, [0.0, 0.0], [0.0, 0.0], "count: element 0: expected 0 or more, found -1"),
            (4.0, [0.0, 0.0], [0.0, -3.0], "m2: element 1: expected 0 or more, found -3"),
            (4.0, [0.0, 0.0], [f64::NAN, 0.0], "m2: element 0: expected 0 or more, found NaN"),
            (0.0, [0.0, 5.0], [0.0, 0.0], "mean: element 1: expected 0 without samples, found 5"),
            (0.0, [0.0, 0.0], [2.0, 0.0], "m2: element 0: expected 0 without samples, found 2"),
        ] {
            assert_eq!(of(count, &mean, &m2).expect_err(text), text);
        }
    }

    #[test]
    fn values_that_are_not_finite_become_zero_and_are_counted() {
        let normalizer = Normalizer::new(1);
        let mut out = [9.0; 3];
        let mut seen = NormalizerBatch::new(1);
        normalizer.apply(
            Mat::new(&[f32::NAN, 2.0, f32::INFINITY], 1, 3, 3),
            MatMut::new(&mut out, 1, 3, 3),
            Some(&mut seen),
        );
        assert_eq!(out, [0.0, 2.0, 0.0]);
        assert_eq!(seen.non_finite, 2);
    }
}
