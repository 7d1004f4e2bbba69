//! Covariance matrix adaptation (CMA-ES) by ask and tell.
//!
//! After N. Hansen, "The CMA evolution strategy: a tutorial" (arXiv 1604.00772): rank-one and rank-mu update, cumulative step-size
//! control, positive weights. Ours, because no published crate has both bounds and ask/tell: `cmaes` 0.2 takes an objective
//! function and has no bounds, `haru_cmaes` 2 has ask/tell and no bounds, `basin` 3 has bounds and drives the objective itself;
//! and here the candidates of many searches are evaluated as lanes of one simulation. Bounds are the caller's: it maps
//! any real vector into its box ([`crate::Options::from_unit`]).

use paid_lanes::rng::Rng;

use crate::symmetric::eigen;

/// The step does not grow beyond this: the searched box is a unit cube.
const LARGEST_STEP: f64 = 1.0;

/// A search for the minimum of a function of `N` numbers.
#[derive(Clone, Debug)]
pub struct CmaEs<const N: usize> {
    mean: [f64; N],
    step: f64,
    covariance: [[f64; N]; N],
    /// Square roots of the eigenvalues, and the eigenvectors, of the covariance.
    axes: ([f64; N], [[f64; N]; N]),
    path_step: [f64; N],
    path_covariance: [f64; N],
    generation: usize,
    weights: Vec<f64>,
    rates: Rates,
    population: usize,
    /// Standard normal draws behind the candidates of the generation under way.
    draws: Vec<[f64; N]>,
    rng: Rng,
}

#[derive(Clone, Copy, Debug)]
struct Rates {
    /// Effective number of parents.
    parents: f64,
    path_covariance: f64,
    path_step: f64,
    rank_one: f64,
    rank_mu: f64,
    damping: f64,
    /// Expected length of a standard normal vector.
    length: f64,
}

impl<const N: usize> CmaEs<N> {
    /// A search around `mean` with the initial `step`, `population` (at least 2) candidates a generation.
    pub fn new(mean: [f64; N], step: f64, population: usize, rng: Rng) -> Self {
        let population = population.max(2);
        let half = population / 2;
        let raw: Vec<f64> =
            (1..=half).map(|i| (0.5 * (population as f64 + 1.0)).ln() - (i as f64).ln()).collect();
        let sum: f64 = raw.iter().sum();
        let weights: Vec<f64> = raw.iter().map(|w| w / sum).collect();
        let parents = 1.0 / weights.iter().map(|w| w * w).sum::<f64>();
        let n = N as f64;
        let path_step = (parents + 2.0) / (n + parents + 5.0);
        let rank_one = 2.0 / ((n + 1.3).powi(2) + parents);
        let rank_mu =
            (2.0 * (parents - 2.0 + 1.0 / parents) / ((n + 2.0).powi(2) + parents)).min(1.0 - rank_one);
        let rates = Rates {
            parents,
            path_covariance: (4.0 + parents / n) / (n + 4.0 + 2.0 * parents / n),
            path_step,
            rank_one,
            rank_mu,
            damping: 1.0 + 2.0 * (((parents - 1.0) / (n + 1.0)).sqrt() - 1.0).max(0.0) + path_step,
            length: n.sqrt() * (1.0 - 1.0 / (4.0 * n) + 1.0 / (21.0 * n * n)),
        };
        let mut covariance = [[0.0; N]; N];
        for (i, row) in covariance.iter_mut().enumerate() {
            row[i] = 1.0;
        }
        Self {
            mean,
            step,
            axes: ([1.0; N], covariance),
            covariance,
            path_step: [0.0; N],
            path_covariance: [0.0; N],
            generation: 0,
            weights,
            rates,
            population,
            draws: Vec::new(),
            rng,
        }
    }

    /// Generations so far.
    pub fn generation(&self) -> usize {
        self.generation
    }

    /// The center of the search.
    pub fn mean(&self) -> [f64; N] {
        self.mean
    }

    /// The overall step.
    pub fn step(&self) -> f64 {
        self.step
    }

    /// `B D z`: a draw in the shape of the covariance.
    fn shaped(&self, z: &[f64; N]) -> [f64; N] {
        let (roots, vectors) = &self.axes;
        std::array::from_fn(|k| (0..N).map(|i| vectors[k][i] * roots[i] * z[i]).sum())
    }

    /// The candidates of the next generation. Tell their losses before asking again.
    pub fn ask(&mut self) -> Vec<[f64; N]> {
        let rng = &mut self.rng;
        self.draws = (0..self.population).map(|_| std::array::from_fn(|_| rng.normal())).collect();
        self.draws
            .iter()
            .map(|z| {
                let y = self.shaped(z);
                std::array::from_fn(|k| self.step.mul_add(y[k], self.mean[k]))
            })
            .collect()
    }

    /// Learns from the losses of the candidates last asked for, in their order. A loss that is not a number counts as the worst.
    ///
    /// # Panics
    /// If there is not one loss a candidate.
    pub fn tell(&mut self, losses: &[f64]) {
        assert_eq!(losses.len(), self.draws.len(), "one loss a candidate");
        let key = |i: &usize| if losses[*i].is_nan() { f64::INFINITY } else { losses[*i] };
        let mut order: Vec<usize> = (0..losses.len()).collect();
        order.sort_by(|a, b| key(a).total_cmp(&key(b)));
        let best: Vec<[f64; N]> = order.iter().take(self.weights.len()).map(|&i| self.draws[i]).collect();
        let steps: Vec<[f64; N]> = best.iter().map(|z| self.shaped(z)).collect();
        let average = |rows: &[[f64; N]]| -> [f64; N] {
            std::array::from_fn(|k| rows.iter().zip(&self.weights).map(|(row, w)| w * row[k]).sum())
        };
        let (z, y) = (average(&best), average(&steps));
        self.generation += 1;
        let r = self.rates;
        // C^(-1/2) y = B z.
        let vectors = &self.axes.1;
        let white: [f64; N] = std::array::from_fn(|k| (0..N).map(|i| vectors[k][i] * z[i]).sum());
        let gain = (r.path_step * (2.0 - r.path_step) * r.parents).sqrt();
        for k in 0..N {
            self.mean[k] += self.step * y[k];
            self.path_step[k] = (1.0 - r.path_step) * self.path_step[k] + gain * white[k];
        }
        let length = self.path_step.iter().map(|x| x * x).sum::<f64>().sqrt();
        let settled = (1.0 - (1.0 - r.path_step).powi(2 * self.generation as i32)).sqrt();
        let steady = length / settled < (1.4 + 2.0 / (N as f64 + 1.0)) * r.length;
        let h = f64::from(u8::from(steady));
        let gain = h * (r.path_covariance * (2.0 - r.path_covariance) * r.parents).sqrt();
        for k in 0..N {
            self.path_covariance[k] = (1.0 - r.path_covariance) * self.path_covariance[k] + gain * y[k];
        }
        let lost = (1.0 - h) * r.path_covariance * (2.0 - r.path_covariance);
        let keep = 1.0 - r.rank_one - r.rank_mu + r.rank_one * lost;
        for i in 0..N {
            for j in 0..N {
                let mu: f64 = steps.iter().zip(&self.weights).map(|(s, w)| w * s[i] * s[j]).sum();
                let one = self.path_covariance[i] * self.path_covariance[j];
                self.covariance[i][j] = keep * self.covariance[i][j] + r.rank_one * one + r.rank_mu * mu;
            }
        }
        let growth = (r.path_step / r.damping) * (length / r.length - 1.0);
        self.step = (self.step * growth.min(1.0).exp()).min(LARGEST_STEP);
        let (values, vectors) = eigen(&self.covariance);
        // Rounding must not make the shape collapse or turn negative.
        let floor = 1e-14 * values.iter().fold(0.0_f64, |a, v| a.max(*v));
        self.axes = (values.map(|v| v.max(floor).sqrt()), vectors);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn minimize<const N: usize>(
        population: usize,
        generations: usize,
        f: impl Fn(&[f64; N]) -> f64,
    ) -> [f64; N] {
        let mut search = CmaEs::new([0.5; N], 0.2, population, Rng::new(3, 0, 0));
        for _ in 0..generations {
            let losses: Vec<f64> = search.ask().iter().map(&f).collect();
            search.tell(&losses);
        }
        search.mean()
    }

    #[test]
    fn finds_the_bottom_of_a_narrow_turned_valley_with_the_papers_population() {
        let target = [0.77, 0.07, 0.75, 0.3, 0.856];
        // Axes of curvature from 1 to 10^4, none along a coordinate.
        let loss = |x: &[f64; 5]| {
            let d: [f64; 5] = std::array::from_fn(|i| x[i] - target[i]);
            let sums = [d[0] + d[1], d[0] - d[1], d[2] + d[3] + d[4], d[3] - d[4], d[2] - d[4]];
            sums.iter().enumerate().map(|(i, s)| 10_f64.powi(i as i32) * s * s).sum::<f64>()
        };
        let found = minimize(4, 1500, loss);
        for i in 0..5 {
            assert!((found[i] - target[i]).abs() < 1e-5, "{found:?}");
        }
    }

    #[test]
    fn a_candidate_without_a_loss_is_the_worst() {
        let found =
            minimize(
                6,
                400,
                |x: &[f64; 2]| {
                    if x[0] > 0.6 { f64::NAN } else { (x[0] - 0.4).powi(2) + (x[1] - 0.1).powi(2) }
                },
            );
        assert!((found[0] - 0.4).abs() < 1e-4 && (found[1] - 0.1).abs() < 1e-4, "{found:?}");
    }

    #[test]
    fn equal_seeds_give_equal_searches() {
        let run = || minimize(4, 50, |x: &[f64; 3]| x.iter().map(|v| (v - 0.2).powi(2)).sum());
        assert_eq!(run(), run());
    }
}
