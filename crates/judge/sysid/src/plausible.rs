//! Whether films are plausible, and whether a fit matches them: a free fall shows the clock and the unit.

use std::path::Path;

use crate::SysidError;
use crate::csv::{Quantity, Run};
use crate::identify::{Identification, Overlay};
use crate::options::Options;
use crate::trial::{rolling_start, trials};

/// A clock may be wrong by this share: 50 instead of 60 frames per second is reported, the air's drag on a ball is not.
const CLOCK: f64 = 0.15;
/// ... and by this many standard errors.
const SURE: f64 = 4.0;
/// The part of a fall that is looked at: neither frames in which the ball is still held nor those around the impact.
const PART: [f64; 2] = [0.15, 0.8];
/// Noise of a camera if too few rows show it, and the least that is assumed [m].
const NOISE_M: f64 = 0.005;
const LEAST_NOISE_M: f64 = 0.001;
/// Fewest compared rows of a run: as many as there are parameters.
const MIN_COMPARED: usize = 5;
/// Speeds of a rolling ball at its first row [m/s].
const SPEEDS: [f64; 2] = [0.05, 50.0];
/// A drop must match within this many times the noise, or within this share of the ball's motion; a roll within the share.
const NOISES: f64 = 10.0;
const SHARES: [f64; 2] = [0.025, 0.05];
/// Errors below this are no reason to refuse a fit [m].
const SMALL_M: f64 = 0.03;

/// How balls fall in a film.
struct Fall {
    /// Acceleration `[m/s^2]`, its standard error, and the noise of a row `[m]`.
    acceleration: f64,
    error: f64,
    noise_m: f64,
}

/// The common acceleration of falling balls, a parabola a run; `None` if no run has three rows of its fall.
fn fall(drops: &[Run]) -> Option<Fall> {
    let (mut weight, mut sum, mut rest, mut free) = (0.0, 0.0, 0.0, 0_usize);
    for run in drops {
        let [release, lowest] = [run.values[0], run.values.iter().copied().fold(f64::INFINITY, f64::min)];
        let at = |share: f64| release - share * (release - lowest);
        let end = run.values.iter().position(|h| *h <= at(PART[1])).unwrap_or(run.values.len());
        let rows = run.times.iter().zip(&run.values).take(end).skip_while(|(_, h)| **h > at(PART[0]));
        let (times, heights): (Vec<f64>, Vec<f64>) = rows.map(|(t, h)| (*t, *h)).unzip();
        if times.len() < 3 {
            continue;
        }
        // Least squares with orthogonal polynomials.
        let n = times.len() as f64;
        let mean = |x: &[f64]| x.iter().sum::<f64>() / n;
        let dot = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(a, b)| a * b).sum::<f64>();
        let middle = mean(&times);
        let line: Vec<f64> = times.iter().map(|t| t - middle).collect();
        let square: Vec<f64> = line.iter().map(|u| u * u).collect();
        let (width, skew) = (dot(&line, &line), dot(&square, &line));
        let level = mean(&square);
        let curve: Vec<f64> = square.iter().zip(&line).map(|(s, u)| s - level - skew / width * u).collect();
        let (w, height) = (dot(&curve, &curve), mean(&heights));
        let (bend, slope) = (dot(&curve, &heights) / w, dot(&line, &heights) / width);
        let left = heights.iter().zip(line.iter().zip(&curve));
        rest += left.map(|(h, (u, c))| (h - height - slope * u - bend * c).powi(2)).sum::<f64>();
        free += times.len() - 3;
        weight += w;
        sum += w * -2.0 * bend;
    }
    let noise_m = if free < 3 { NOISE_M } else { (rest / free as f64).sqrt().max(LEAST_NOISE_M) };
    (weight > 0.0).then(|| Fall { acceleration: sum / weight, error: 2.0 * noise_m / weight.sqrt(), noise_m })
}

/// Checks that the runs of a file can be repeated by a ball under `gravity` `[m/s^2]`.
///
/// # Errors
/// File, run, expected, found, and by which factor time or unit is wrong.
pub fn check_runs(
    path: &Path,
    runs: &[Run],
    quantity: Quantity,
    gravity: f64,
    options: &Options,
) -> Result<(), SysidError> {
    let wrong = |place: String, expected: String, found: String, hint: String| {
        Err(SysidError::Implausible { path: path.to_owned(), place, expected, found, hint })
    };
    if let (Quantity::Height, Some(fall)) = (quantity, fall(runs)) {
        let share = fall.acceleration / gravity;
        let factor = share.max(1e-12).sqrt().recip();
        let off = (factor - 1.0).abs() > CLOCK && (fall.acceleration - gravity).abs() > SURE * fall.error;
        if off {
            let expected = format!("a ball that falls at {gravity:.2} m/s^2");
            let found = match fall.acceleration {
                g if g.abs() < 1e-3 => format!("{g:.2e} m/s^2"),
                g => format!("{g:.3} m/s^2"),
            };
            return wrong("the drops".to_owned(), expected, found, cause(fall.acceleration, share, factor));
        }
    }
    for run in runs {
        let compared = &trials(std::slice::from_ref(run), quantity, options)[0];
        let place = format!("run '{}'", run.name);
        if quantity == Quantity::Distance {
            let speed = rolling_start(&run.times, &run.values, options.speed_window_s).0;
            if !(SPEEDS[0]..=SPEEDS[1]).contains(&speed) {
                let expected = format!("a ball that begins at {} to {} m/s", SPEEDS[0], SPEEDS[1]);
                let hint = "time_s is in seconds and distance_m in meters".to_owned();
                return wrong(place, expected, format!("{speed:.3} m/s"), hint);
            }
        }
        if compared.times.len() < MIN_COMPARED {
            let expected = format!(
                "at least {MIN_COMPARED} rows {} s or more apart within {} s",
                options.every_s, options.duration_s
            );
            let hint = "time_s is in seconds; film longer, or change --every and --duration".to_owned();
            return wrong(place, expected, compared.times.len().to_string(), hint);
        }
    }
    Ok(())
}

/// What makes a ball fall at `share` of gravity, as if time ran `factor` times too slowly.
fn cause(acceleration: f64, share: f64, factor: f64) -> String {
    let near = |x: f64, known: f64| (x / known - 1.0).abs() < 0.05;
    if acceleration <= 0.0 {
        return "height_m is the height over the ground and grows upward, and a run begins at the release"
            .to_owned();
    }
    if near(factor, 1000.0) {
        return "time_s is in milliseconds: divide it by 1000".to_owned();
    }
    for (unit, per_meter) in [("feet", 3.2808), ("inches", 39.37), ("centimeters", 100.0)] {
        if near(share, per_meter) {
            return format!("height_m is in {unit}: divide it by {per_meter}");
        }
    }
    if factor > 1.0 {
        return format!(
            "time_s is {factor:.3} times too long, as in slow motion or in frame numbers: divide it by {factor:.3} (time the frames by the \
             rate at which they were filmed)"
        );
    }
    let short = factor.recip();
    format!(
        "time_s is {short:.3} times too short: multiply it by {short:.3} (time the frames by the rate at which they were filmed), or height_m \
         is in another unit"
    )
}

/// Checks that a fit meets the `drops` and the rolls that it was made for.
///
/// # Errors
/// If its error is far above the noise: which, how far, and what to look for.
pub fn check_fit(found: &Identification, drops: &[Run]) -> Result<(), SysidError> {
    let noise = fall(drops).map_or(NOISE_M, |fall| fall.noise_m);
    let moved = |overlays: &[Overlay]| {
        let way = |overlay: &Overlay| {
            let values = || overlay.samples.iter().map(|[_, measured, _]| *measured);
            values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
        };
        overlays.iter().map(way).fold(0.0, f64::max)
    };
    // Half of the way is no noise, whatever the rows say.
    let limits = [
        (NOISES * noise).max(SHARES[0] * moved(&found.drops)).min(0.5 * moved(&found.drops)),
        SHARES[1] * moved(&found.rolls),
    ];
    for (what, error, limit) in
        [("drops", found.drop_rms_m, limits[0]), ("rolls", found.roll_rms_m, limits[1])]
    {
        let limit = limit.max(SMALL_M);
        if let Some(error) = error.filter(|error| error.is_nan() || *error > limit) {
            let bound = found.confidence.estimates.iter().find(|e| e.at_bound && e.flat[0] > 0.0);
            let hint = match bound {
                Some(e) if e.name == "restitution" => {
                    "restitution ended at an end of its range: the ground returns more than the task's can (--set scene.ground.restitution=1), \
                     or the films are not as the guide asks"
                        .to_owned()
                }
                Some(e) => {
                    format!("{} ended at an end of its range: --range, or films as the guide asks", e.name)
                }
                None => "wrong frame rate or scale, a first row that is not the release, heights of the ball's center; or too short a search \
                         (--restarts), or rough starts (--starts refined)"
                    .to_owned(),
            };
            return Err(SysidError::Misfit {
                what,
                error_mm: 1000.0 * error,
                limit_mm: 1000.0 * limit,
                hint,
            });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const G: f64 = 9.81;

    /// Five drops from 2 m, onto a ground that returns seven tenths of the speed, seen to 5 mm by a camera of this rate for 2 s.
    fn drops(rate: f64) -> Vec<Run> {
        let impact = (2.0 * 2.0 / G).sqrt();
        let height = |t: f64| {
            let up = t - impact;
            let (speed, second) = (0.7 * G * impact, 2.0 * 0.7 * impact);
            if up < 0.0 {
                2.0 - 0.5 * G * t * t
            } else if up < second {
                speed * up - 0.5 * G * up * up
            } else {
                0.0
            }
        };
        let run = |number: usize| {
            let times: Vec<f64> = (0..=(2.0 * rate) as usize).map(|i| i as f64 / rate).collect();
            // An error that repeats itself every three rows.
            let error = |i: usize| [0.006, -0.006, 0.0][(i + number) % 3];
            let values = times.iter().enumerate().map(|(i, t)| height(*t) + error(i)).collect();
            Run { name: number.to_string(), times, values, spin: None }
        };
        (1..=5).map(run).collect()
    }

    /// The complaint about drops whose times and heights are multiplied.
    fn complaint(rate: f64, time: f64, height: f64) -> Option<String> {
        let mut runs = drops(rate);
        for run in &mut runs {
            run.times.iter_mut().for_each(|t| *t *= time);
            run.values.iter_mut().for_each(|h| *h *= height);
        }
        let checked = check_runs(Path::new("drop.csv"), &runs, Quantity::Height, G, &Options::default());
        checked.err().map(|error| error.to_string())
    }

    #[test]
    fn a_fall_tells_by_which_factor_time_or_unit_is_wrong() {
        for rate in [10.0, 30.0, 60.0, 240.0] {
            assert_eq!(complaint(rate, 1.0, 1.0), None, "{rate}");
            // Drift of a clock, a scale that is 5% off.
            assert_eq!(complaint(rate, 1.03, 0.95), None, "{rate}");
            for (time, height, parts) in [
                // 9.81 / 64.
                (8.0, 1.0, ["drop.csv, the drops: expected a ball that falls at 9.81 m/s^2", "slow motion"]),
                (2.0, 1.0, ["divide it by", "the rate at which they were filmed"]),
                (0.5, 1.0, ["too short: multiply it by", "the rate at which they were filmed"]),
                (1000.0, 1.0, ["expected a ball", "time_s is in milliseconds: divide it by 1000"]),
                (1.0, 3.2808, ["expected a ball", "height_m is in feet: divide it by 3.2808"]),
                (1.0, 39.37, ["expected a ball", "height_m is in inches"]),
            ] {
                let error = complaint(rate, time, height).expect("refused");
                for part in parts {
                    assert!(error.contains(part), "{rate} {time} {height}: {part}: {error}");
                }
            }
        }
        let error = complaint(240.0, 8.0, 1.0).expect("refused");
        let factor: f64 =
            error.split("divide it by ").nth(1).expect("a factor")[..5].parse().expect("a number");
        assert!((factor - 8.0).abs() < 0.1, "{error}");
        // 60 frames per second taken for 50.
        let error = complaint(60.0, 1.2, 1.0).expect("refused");
        assert!(error.contains("times too long"), "{error}");
    }

    #[test]
    fn frames_before_the_release_do_not_change_the_fall() {
        let mut runs = drops(60.0);
        for run in &mut runs {
            run.times = (0..run.times.len() + 12).map(|i| i as f64 / 60.0).collect();
            run.values.splice(0..0, [2.0; 12]);
        }
        let found = fall(&runs).expect("falls");
        assert!((found.acceleration - G).abs() < 4.0 * found.error && found.error < 0.3, "{}", found.error);
        // Errors of 6 mm in two of three rows: 4.9 mm.
        assert!((found.noise_m - 0.0049).abs() < 0.001, "{}", found.noise_m);
    }

    #[test]
    fn a_ball_that_flies_up_is_no_drop() {
        let times: Vec<f64> = (0..40).map(|i| f64::from(i) / 40.0).collect();
        // It floats down ever more slowly.
        let values = times.iter().map(|t| 2.0 - 2.0 * t + t * t).collect();
        let run = Run { name: "a".into(), times, values, spin: None };
        let error = check_runs(Path::new("a.csv"), &[run], Quantity::Height, G, &Options::default());
        let error = error.expect_err("refused").to_string();
        assert!(error.contains("found -2.000 m/s^2: height_m is the height over the ground"), "{error}");
    }

    #[test]
    fn rolls_in_milliseconds_and_too_few_rows_are_refused() {
        let roll = |rate: f64, unit: f64| {
            let times: Vec<f64> = (0..=(2.0 * rate) as usize).map(|i| unit * i as f64 / rate).collect();
            let values = times.iter().map(|t| 2.0 * t / unit).collect();
            let run = Run { name: "b".into(), times, values, spin: None };
            let checked = check_runs(Path::new("r.csv"), &[run], Quantity::Distance, G, &Options::default());
            checked.map_err(|error| error.to_string())
        };
        assert_eq!(roll(60.0, 1.0), Ok(()));
        let error = roll(60.0, 1000.0).expect_err("milliseconds");
        assert_eq!(
            error,
            "r.csv, run 'b': expected a ball that begins at 0.05 to 50 m/s, found 0.002 m/s: time_s is in seconds and distance_m in meters"
        );
        let error = roll(1.5, 1.0).expect_err("four rows");
        assert!(
            error.contains("run 'b': expected at least 5 rows 0.1 s or more apart within 2 s, found 4"),
            "{error}"
        );
    }

    #[test]
    fn recorded_cases_of_wrong_clocks_are_told_their_factor() {
        for (file, expected) in
            [("slow_motion_240_as_30", "divide it by 8.0"), ("milliseconds", "time_s is in milliseconds")]
        {
            let test = "recorded_cases_of_wrong_clocks_are_told_their_factor";
            let Some(path) = paid_testing::shared_data(test, &format!("cases/{file}.csv")) else { return };
            let runs = crate::csv::read_runs(&path, Quantity::Height).expect("reads");
            let error = check_runs(&path, &runs, Quantity::Height, G, &Options::default());
            let error = error.expect_err("refused").to_string();
            assert!(error.contains(expected), "{error}");
        }
    }
}
