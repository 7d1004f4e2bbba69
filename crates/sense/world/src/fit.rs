//! The constants of the paper's noise, `c_min + |v| / c_vel + d / c_dist`, from detections whose truth is known.
//!
//! A normal error of standard deviation `s` has the mean size `s sqrt(2 / pi)`. So the sizes of the errors, times `sqrt(pi / 2)`, are
//! regressed on `1`, speed and distance, weighted by the inverse of the variance that the last round gave (iterated least squares), with
//! no coefficient below zero. Finds beyond four standard deviations are of something else and left out.

use std::path::Path;

use paid_lanes::stats::quantile;
use serde::Serialize;

use crate::SightError;

/// A detection against the ground truth at its capture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Find {
    /// Distance of the ball along the ground `[m]`.
    pub distance_m: f64,
    /// Its speed relative to the torso `[m/s]`.
    pub speed_m_s: f64,
    /// Age of the image when it was used `[s]`.
    pub age_s: f64,
    /// Error away from the robot and to its left `[m]`.
    pub error_m: [f64; 2],
    /// Share of the ball in the image, 0 to 1.
    pub shown: f64,
}

/// Errors of some detections.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Group {
    /// Which detections.
    pub name: String,
    /// How many.
    pub finds: usize,
    /// Mean of distance, speed and age: `[m]`, `[m/s]`, `[s]`.
    pub mean: [f64; 3],
    /// Root of the mean squared error along the ray and across `[m]`.
    pub rms_m: [f64; 2],
    /// Mean error along the ray and across `[m]`.
    pub bias_m: [f64; 2],
    /// What the fit gives for their mean distance and speed `[m]`.
    pub fitted_m: f64,
}

/// The fitted constants.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fit {
    /// Finds that were used.
    pub finds: usize,
    /// Share of the detections that were of something else.
    pub false_share: f64,
    /// Constant part `[m]`.
    pub c_min_m: f64,
    /// Divisor of the speed `[1/s]`; infinite where speed adds nothing.
    pub c_vel: f64,
    /// Divisor of the distance; infinite where distance adds nothing.
    pub c_dist: f64,
    /// Middle and 95th percentile of the images' ages when they were used `[s]`.
    pub latency_s: [f64; 2],
    /// Errors by distance, speed, age and view.
    pub groups: Vec<Group>,
}

impl Fit {
    /// Standard deviation that the fit gives `[m]`.
    pub fn deviation(&self, speed: f64, distance: f64) -> f64 {
        self.c_min_m + speed / self.c_vel + distance / self.c_dist
    }

    /// The fit's deviation over that of other constants, at the detections' own speeds and distances, averaged: training's `noise_scale` if
    /// those are training's.
    pub fn scale(&self, finds: &[Find], other: impl Fn(f64, f64) -> f64) -> f64 {
        let ratio = |f: &Find| self.deviation(f.speed_m_s, f.distance_m) / other(f.speed_m_s, f.distance_m);
        finds.iter().map(ratio).sum::<f64>() / finds.len().max(1) as f64
    }
}

/// Fewest detections that constants are fitted to.
const FEWEST: usize = 30;
/// A detection farther from the ball is of something else `[m]`.
const OTHER_M: f64 = 0.3;
/// Standard deviations beyond which a detection is of something else.
const OUTLIER: f64 = 4.0;
/// Rounds of the regression.
const ROUNDS: usize = 30;
/// No deviation is taken to be less `[m]`.
const LEAST_M: f64 = 1e-4;

/// Columns of a file of detections, in their order.
pub const COLUMNS: &str = "trial,distance_m,speed_m_s,age_s,error_along_m,error_across_m,shown,own";

/// Detections of a file that an evaluation with onboard perception has written ([`COLUMNS`]).
///
/// # Errors
/// If it cannot be read, or a line is not what it should be.
pub fn read(path: &Path) -> Result<Vec<Find>, SightError> {
    let text = std::fs::read_to_string(path);
    let text = text.map_err(|source| SightError::File { path: path.to_owned(), source })?;
    let wrong = |line: usize, expected: &str, found: &str| SightError::Recording {
        path: path.to_owned(),
        place: format!("line {line}"),
        expected: expected.to_owned(),
        found: format!("'{found}'"),
    };
    let head = text.lines().next().unwrap_or_default();
    if head != COLUMNS {
        return Err(wrong(1, COLUMNS, head));
    }
    let mut finds = Vec::new();
    for (index, line) in text.lines().enumerate().skip(1) {
        let fields: Vec<f64> = line.split(',').take(7).filter_map(|field| field.parse().ok()).collect();
        let &[_, distance_m, speed_m_s, age_s, along, across, shown] = fields.as_slice() else {
            return Err(wrong(index + 1, "seven numbers, then true or false", line));
        };
        finds.push(Find { distance_m, speed_m_s, age_s, error_m: [along, across], shown });
    }
    Ok(finds)
}

/// Fits the constants.
///
/// # Errors
/// If there are too few detections, or a number is not finite.
pub fn fit(finds: &[Find]) -> Result<Fit, SightError> {
    if let Some(find) = finds.iter().find(|f| {
        ![f.distance_m, f.speed_m_s, f.age_s, f.error_m[0], f.error_m[1]].iter().all(|v| v.is_finite())
    }) {
        return Err(SightError::Fit { expected: "finite numbers", found: format!("{find:?}") });
    }
    let mut used: Vec<Find> =
        finds.iter().copied().filter(|f| f.error_m[0].hypot(f.error_m[1]) < OTHER_M).collect();
    let too_few = |found: usize| SightError::Fit {
        expected: "30 detections of the ball or more",
        found: found.to_string(),
    };
    if used.len() < FEWEST {
        return Err(too_few(used.len()));
    }
    let mut coefficients = [0.02, 0.0, 0.0];
    for round in 0..ROUNDS {
        coefficients = regress(&used, coefficients);
        if round == ROUNDS / 2 {
            used.retain(|f| {
                let sigma = deviation(coefficients, f);
                f.error_m.iter().all(|e| e.abs() <= OUTLIER * sigma)
            });
            if used.len() < FEWEST {
                return Err(too_few(used.len()));
            }
        }
    }
    let [c_min_m, per_speed, per_distance] = coefficients;
    let mut ages: Vec<f64> = used.iter().map(|f| f.age_s).collect();
    let mut percentile = |share: f64| quantile(&mut ages, share).unwrap_or(f64::NAN);
    let mut fit = Fit {
        finds: used.len(),
        false_share: 1.0 - used.len() as f64 / finds.len() as f64,
        c_min_m,
        c_vel: 1.0 / per_speed,
        c_dist: 1.0 / per_distance,
        latency_s: [percentile(0.5), percentile(0.95)],
        groups: Vec::new(),
    };
    fit.groups = groups(&used, &fit);
    Ok(fit)
}

fn deviation([a, b, c]: [f64; 3], find: &Find) -> f64 {
    (a + b * find.speed_m_s + c * find.distance_m).max(LEAST_M)
}

/// A round: weights from the last coefficients, then the best of all sets of coefficients that are not below zero.
fn regress(finds: &[Find], last: [f64; 3]) -> [f64; 3] {
    let (mut normal, mut right) = ([[0.0; 3]; 3], [0.0; 3]);
    for find in finds {
        let weight = deviation(last, find).powi(-2);
        let row = [1.0, find.speed_m_s, find.distance_m];
        for error in find.error_m {
            let size = error.abs() * (core::f64::consts::FRAC_PI_2).sqrt();
            for i in 0..3 {
                right[i] += weight * row[i] * size;
                for k in 0..3 {
                    normal[i][k] += weight * row[i] * row[k];
                }
            }
        }
    }
    let mut best = ([last[0].max(LEAST_M), 0.0, 0.0], f64::INFINITY);
    for set in 1..8_usize {
        let used: Vec<usize> = (0..3).filter(|k| set >> k & 1 == 1).collect();
        let Some(found) = solve(&normal, &right, &used) else { continue };
        if found.iter().any(|v| *v < 0.0) {
            continue;
        }
        // Of the sum of squares, what depends on the coefficients.
        let cost: f64 = (0..3)
            .map(|i| {
                let product: f64 = (0..3).map(|k| normal[i][k] * found[k]).sum();
                found[i] * (product - 2.0 * right[i])
            })
            .sum();
        if cost < best.1 {
            best = (found, cost);
        }
    }
    best.0
}

/// The normal equations of some of the unknowns; the others are zero.
fn solve(normal: &[[f64; 3]; 3], right: &[f64; 3], used: &[usize]) -> Option<[f64; 3]> {
    let n = used.len();
    let matrix = nalgebra::DMatrix::from_fn(n, n, |i, k| normal[used[i]][used[k]]);
    let vector = nalgebra::DVector::from_fn(n, |i, _| right[used[i]]);
    let solved = matrix.cholesky()?.solve(&vector);
    let mut out = [0.0; 3];
    used.iter().enumerate().for_each(|(i, k)| out[*k] = solved[i]);
    Some(out)
}

/// Errors by distance, speed, age and view.
fn groups(finds: &[Find], fit: &Fit) -> Vec<Group> {
    let mut out = Vec::new();
    let mut add = |name: String, of: &dyn Fn(&Find) -> bool| {
        let some: Vec<&Find> = finds.iter().filter(|f| of(f)).collect();
        if some.len() < 5 {
            return;
        }
        let mean =
            |value: &dyn Fn(&Find) -> f64| some.iter().map(|f| value(f)).sum::<f64>() / some.len() as f64;
        let (distance, speed) = (mean(&|f| f.distance_m), mean(&|f| f.speed_m_s));
        out.push(Group {
            name,
            finds: some.len(),
            mean: [distance, speed, mean(&|f| f.age_s)],
            rms_m: [0, 1].map(|k| mean(&|f| f.error_m[k] * f.error_m[k]).sqrt()),
            bias_m: [0, 1].map(|k| mean(&|f| f.error_m[k])),
            fitted_m: fit.deviation(speed, distance),
        });
    };
    add("all".to_owned(), &|_| true);
    for (low, high) in [(0.0, 0.5), (0.5, 1.0), (1.0, 1.5), (1.5, 2.0), (2.0, 3.0), (3.0, 9.0)] {
        add(format!("{low} to {high} m"), &|f| (low..high).contains(&f.distance_m));
    }
    for (low, high) in [(0.0, 0.1), (0.1, 0.3), (0.3, 0.6), (0.6, 1.2), (1.2, 9.0)] {
        add(format!("{low} to {high} m/s"), &|f| (low..high).contains(&f.speed_m_s));
    }
    for (low, high) in [(0.0, 0.05), (0.05, 0.07), (0.07, 0.1), (0.1, 0.5)] {
        add(format!("{:.0} to {:.0} ms old", 1e3 * low, 1e3 * high), &|f| (low..high).contains(&f.age_s));
    }
    for (low, high) in [(0.0, 0.5), (0.5, 0.9), (0.9, 1.1)] {
        let high_percent = f64::min(100.0 * high, 100.0);
        add(format!("{:.0} to {high_percent:.0}% in view", 100.0 * low), &|f| (low..high).contains(&f.shown));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use paid_lanes::rng::Rng;

    fn drawn(constants: [f64; 3], count: usize) -> Vec<Find> {
        let mut rng = Rng::new(3, 0, 0);
        let mut draw = || {
            let (distance_m, speed_m_s) = (rng.uniform(0.3, 3.0), rng.uniform(0.0, 1.5));
            let sigma = constants[0] + constants[1] * speed_m_s + constants[2] * distance_m;
            let error_m = [sigma * rng.normal(), sigma * rng.normal()];
            Find { distance_m, speed_m_s, age_s: 0.06, error_m, shown: 1.0 }
        };
        (0..count).map(|_| draw()).collect()
    }

    #[test]
    fn constants_that_made_the_errors_are_found() {
        let fit = fit(&drawn([0.01, 0.02, 0.008], 20_000)).expect("enough");
        assert!((fit.c_min_m - 0.01).abs() < 0.001, "{fit:?}");
        assert!(
            (1.0 / fit.c_vel - 0.02).abs() < 0.002 && (1.0 / fit.c_dist - 0.008).abs() < 0.001,
            "{fit:?}"
        );
        assert_eq!(fit.latency_s, [0.06; 2]);
        let all = &fit.groups[0];
        assert!(all.name == "all" && (all.rms_m[0] / all.fitted_m - 1.0).abs() < 0.15, "{all:?}");
    }

    #[test]
    fn what_adds_nothing_gets_an_infinite_divisor_and_other_things_are_left_out() {
        let mut finds = drawn([0.02, 0.0, 0.0], 2000);
        for k in 0..100 {
            finds[k].error_m = [1.0, -0.8];
        }
        let fit = fit(&finds).expect("enough");
        assert!((fit.c_min_m - 0.02).abs() < 0.002 && 1.0 / fit.c_dist < 0.001, "{fit:?}");
        assert!((fit.false_share - 0.05).abs() < 0.003, "{}", fit.false_share);
        assert!((fit.scale(&finds, |_, _| 0.04) - 0.5).abs() < 0.05);
    }

    #[test]
    fn a_file_of_finds_is_read_and_a_wrong_line_is_named() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("finds.csv");
        let write = |text: &str| std::fs::write(&path, text).expect("written");
        write(&format!("{COLUMNS}\n3,1.25,0.5,0.06,0.01,-0.02,1.0,true\n"));
        let finds = read(&path).expect("a file");
        let wanted =
            Find { distance_m: 1.25, speed_m_s: 0.5, age_s: 0.06, error_m: [0.01, -0.02], shown: 1.0 };
        assert_eq!(finds, [wanted]);
        write(&format!("{COLUMNS}\n3,1.25,x,0.06,0.01,-0.02,1.0,true\n"));
        let error = read(&path).expect_err("no number").to_string();
        assert!(error.contains("finds.csv: line 2: expected seven numbers"), "{error}");
    }

    #[test]
    fn too_few_finds_are_refused() {
        let error = fit(&drawn([0.01, 0.0, 0.0], 12)).expect_err("12 of 30").to_string();
        assert_eq!(error, "sightings: expected 30 detections of the ball or more, found 12");
    }
}
