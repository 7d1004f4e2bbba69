//! Which parameters the experiments have seen, and how sharply.

use serde::Serialize;

use crate::lab::Lab;
use crate::options::{NAMES, PARAMETERS, Parameters};
use crate::search::Problem;
use crate::symmetric::eigen;

/// Rise of the squared error, in units of the noise's variance, that counts as visible: two standard deviations.
const VISIBLE: f64 = 4.0;
/// Step of the derivatives, in units of the range.
const STEP: f64 = 0.01;
/// A parameter whose derivative predicts no visible change over this share of its range is left out of the correlations.
const SEEN_WITHIN: f64 = 0.1;
/// Places at which a parameter's range is looked at.
const PLACES: usize = 101;

/// How well a parameter is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// To within 5% of its value.
    Sharp,
    /// Less sharply, but to within a quarter of its range.
    Rough,
    /// These experiments do not determine it.
    Unseen,
}

impl Verdict {
    /// One word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sharp => "sharp",
            Self::Rough => "rough",
            Self::Unseen => "unseen",
        }
    }
}

/// A parameter and what is known about it.
#[derive(Clone, Debug, Serialize)]
pub struct Estimate {
    /// Its name.
    pub name: &'static str,
    /// The best value.
    pub value: f64,
    /// Standard deviation over the searches that fit as well as the best.
    pub restart_spread: f64,
    /// Standard error of the mean of the repeats fitted one by one; `None` with a single repeat.
    pub repeat_error: Option<f64>,
    /// Standard error from the curvature of the loss and the noise, the other parameters free; `None` if the curvature does
    /// not see the parameter.
    pub standard_error: Option<f64>,
    /// Values, the other parameters held, that fit as well within the noise.
    pub flat: [f64; 2],
    /// True if the best value lies at an end of its search range: the truth may lie beyond.
    pub at_bound: bool,
    /// The judgment.
    pub verdict: Verdict,
    /// The value that the surface gets instead, if these measurements do not determine it.
    pub kept: Option<f64>,
}

impl Estimate {
    /// Half-width of what remains possible: the largest of all evidence (twice the standard errors).
    pub fn half_width(&self) -> f64 {
        let flat = (self.value - self.flat[0]).max(self.flat[1] - self.value);
        let errors = [self.repeat_error, self.standard_error].into_iter().flatten().map(|e| 2.0 * e);
        errors.fold(flat.max(2.0 * self.restart_spread), f64::max)
    }
}

/// All that is known about the parameters.
#[derive(Clone, Debug, Serialize)]
pub struct Confidence {
    /// One a parameter.
    pub estimates: Vec<Estimate>,
    /// Correlation of the errors of two parameters; `None` where one is not seen by the curvature.
    pub correlation: [[Option<f64>; PARAMETERS]; PARAMETERS],
    /// Standard deviation of measured from simulated positions at the best fit, at least the camera's resolution `[m]`.
    pub noise_m: f64,
    /// Searches that fit as well as the best.
    pub agreeing: usize,
}

impl Confidence {
    /// Rise of the squared error that stands out of the noise `[m^2]`.
    pub fn visible(&self) -> f64 {
        VISIBLE * self.noise_m * self.noise_m
    }
}

fn deviation(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    if values.len() < 2 {
        return 0.0;
    }
    let mean = values.iter().sum::<f64>() / n;
    (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt()
}

/// Assesses `best`, the result of several searches (their `optima`, `best` among them) and of fits to single `repeats`.
pub fn judge(
    problem: &Problem<'_>,
    lab: &mut dyn Lab,
    best: &Parameters,
    optima: &[Parameters],
    repeats: &[Parameters],
) -> Confidence {
    let options = problem.options;
    let lowest = problem.square_sums(lab, &[*best])[0];
    let free = problem.samples().saturating_sub(PARAMETERS).max(1) as f64;
    let noise_m = (lowest / free).sqrt().max(options.resolution_m);
    let visible = VISIBLE * noise_m * noise_m;
    let agreeing: Vec<&Parameters> = problem
        .square_sums(lab, optima)
        .iter()
        .zip(optima)
        .filter(|(sum, _)| **sum - lowest <= visible)
        .map(|(_, optimum)| optimum)
        .collect();
    let flat = flat_ranges(problem, lab, best, lowest + visible);
    let (errors, correlation) = curvature(problem, lab, best, noise_m);
    let estimates = (0..PARAMETERS)
        .map(|i| {
            let [lo, hi] = options.range[i];
            let of = |all: &[&Parameters]| deviation(&all.iter().map(|p| p[i]).collect::<Vec<_>>());
            let single: Vec<&Parameters> = repeats.iter().collect();
            let mut estimate = Estimate {
                name: NAMES[i],
                value: best[i],
                restart_spread: of(&agreeing),
                repeat_error: (repeats.len() > 1).then(|| of(&single) / (repeats.len() as f64).sqrt()),
                standard_error: errors[i],
                flat: flat[i],
                at_bound: (best[i] - lo).min(hi - best[i]) < 1e-3 * (hi - lo),
                verdict: Verdict::Unseen,
                kept: None,
            };
            let half = estimate.half_width();
            if estimate.standard_error.is_some() {
                if half <= 0.05 * estimate.value.abs() {
                    estimate.verdict = Verdict::Sharp;
                } else if half <= 0.25 * (hi - lo) {
                    estimate.verdict = Verdict::Rough;
                }
            }
            estimate
        })
        .collect();
    Confidence { estimates, correlation, noise_m, agreeing: agreeing.len() }
}

/// Around the best value of each parameter, how far it may go, the others held, before the squared error exceeds `limit` `[m^2]`.
fn flat_ranges(
    problem: &Problem<'_>,
    lab: &mut dyn Lab,
    best: &Parameters,
    limit: f64,
) -> [[f64; 2]; PARAMETERS] {
    std::array::from_fn(|i| {
        let [lo, hi] = problem.options.range[i];
        let places: Vec<f64> = (0..PLACES).map(|k| lo + (hi - lo) * k as f64 / (PLACES - 1) as f64).collect();
        let candidates: Vec<Parameters> = places
            .iter()
            .map(|&x| {
                let mut p = *best;
                p[i] = x;
                // A dynamic friction above it would hide a small static one.
                p[1] = if i == 0 { p[1].min(x) } else { p[1] };
                p
            })
            .collect();
        let sums = problem.square_sums(lab, &candidates);
        let fits = |k: &usize| sums[*k] <= limit;
        let above = places.iter().position(|x| *x > best[i]).unwrap_or(PLACES);
        let high = (above..PLACES).take_while(fits).last().map_or(best[i], |k| places[k]);
        let low = (0..above).rev().take_while(fits).last().map_or(best[i], |k| places[k]);
        [low.min(best[i]), high]
    })
}

/// Errors and their correlations.
type Curvature = ([Option<f64>; PARAMETERS], [[Option<f64>; PARAMETERS]; PARAMETERS]);

/// Standard errors and correlations from the derivatives of all compared samples (Gauss-Newton).
fn curvature(problem: &Problem<'_>, lab: &mut dyn Lab, best: &Parameters, noise: f64) -> Curvature {
    let options = problem.options;
    let mut candidates = Vec::new();
    let mut widths = [0.0; PARAMETERS];
    for i in 0..PARAMETERS {
        let [lo, hi] = options.range[i];
        let (mut below, mut above) = (*best, *best);
        below[i] = (best[i] - STEP * (hi - lo)).max(lo);
        above[i] = (best[i] + STEP * (hi - lo)).min(hi);
        widths[i] = (above[i] - below[i]) / (hi - lo);
        candidates.extend([below, above]);
    }
    let flat = |c: Vec<Vec<f64>>| c.concat();
    let curves: Vec<Vec<f64>> = problem.residuals(lab, &candidates).into_iter().map(flat).collect();
    let slopes: [Vec<f64>; PARAMETERS] = std::array::from_fn(|i| {
        let (below, above) = (&curves[2 * i], &curves[2 * i + 1]);
        below.iter().zip(above).map(|(a, b)| (b - a) / widths[i]).collect()
    });
    let product = |i: usize, j: usize| slopes[i].iter().zip(&slopes[j]).map(|(a, b)| a * b).sum::<f64>();
    let seen: [bool; PARAMETERS] =
        std::array::from_fn(|i| product(i, i) * SEEN_WITHIN * SEEN_WITHIN > VISIBLE * noise * noise);
    // What is not seen is decoupled: a diagonal entry of its own.
    let matrix: [[f64; PARAMETERS]; PARAMETERS] = std::array::from_fn(|i| {
        std::array::from_fn(|j| match (seen[i] && seen[j], i == j) {
            (true, _) => product(i, j),
            (false, true) => 1.0,
            (false, false) => 0.0,
        })
    });
    let (values, vectors) = eigen(&matrix);
    let floor = 1e-12 * values.iter().copied().fold(0.0, f64::max);
    let covariance = |i: usize, j: usize| {
        (0..PARAMETERS).map(|k| vectors[i][k] * vectors[j][k] / values[k].max(floor)).sum::<f64>()
    };
    let width = |i: usize| options.range[i][1] - options.range[i][0];
    let errors = std::array::from_fn(|i| seen[i].then(|| noise * covariance(i, i).sqrt() * width(i)));
    let correlation = std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            (seen[i] && seen[j]).then(|| covariance(i, j) / (covariance(i, i) * covariance(j, j)).sqrt())
        })
    });
    (errors, correlation)
}
