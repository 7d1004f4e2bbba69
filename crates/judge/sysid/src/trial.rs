//! From measured runs to experiments that the engine can repeat: initial conditions and compared samples.

use crate::csv::{Quantity, Run};
use crate::lab::Start;
use crate::options::{Options, Repeats};

/// One repeat of an experiment.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// Label of the run.
    pub name: String,
    /// What it measures.
    pub quantity: Quantity,
    /// How it begins.
    pub start: Start,
    /// Compared instants `[s]`.
    pub times: Vec<f64>,
    /// Heights of the ball's lowest point, or distances `[m]`.
    pub values: Vec<f64>,
}

/// The samples nearest after multiples of `every`, up to `end` `[s]`.
fn thinned(run: &Run, every: f64, end: f64) -> (Vec<f64>, Vec<f64>) {
    // A hair, so that rounded times such as 0.3333 still count.
    let hair = 1e-3 * every;
    let mut next = 0.0;
    let (mut times, mut values) = (Vec::new(), Vec::new());
    for (&t, &v) in run.times.iter().zip(&run.values) {
        if t > end + hair {
            break;
        }
        if t + hair >= next {
            times.push(t);
            values.push(v);
            next = (((t + hair) / every).floor() + 1.0) * every;
        }
    }
    (times, values)
}

/// Initial speed `[m/s]` and distance `[m]` of a rolling ball from its samples up to `window` `[s]` (at least the first three): the
/// least-squares curve `d0 + v0 (1 - exp(-r t)) / r`, the motion of a ball whose resistance grows with its speed,
/// over all rates `r` from 0 (no resistance) to 10 /s. A straight line would take the mean speed for the first one.
pub fn rolling_start(times: &[f64], values: &[f64], window: f64) -> (f64, f64) {
    let n = times.iter().take_while(|t| **t <= window).count().max(3).min(times.len());
    let (times, values) = (&times[..n], &values[..n]);
    let fit = |rate: f64| {
        let x = |t: &f64| if rate < 1e-6 { *t } else { -(-rate * t).exp_m1() / rate };
        let mean_x = times.iter().map(x).sum::<f64>() / n as f64;
        let mean_y = values.iter().sum::<f64>() / n as f64;
        let (mut xx, mut xy) = (0.0, 0.0);
        for (t, y) in times.iter().zip(values) {
            let dx = x(t) - mean_x;
            xx += dx * dx;
            xy += dx * (y - mean_y);
        }
        let speed = xy / xx.max(1e-12);
        let start = mean_y - speed * mean_x;
        let error: f64 = times.iter().zip(values).map(|(t, y)| (start + speed * x(t) - y).powi(2)).sum();
        (error, speed, start)
    };
    let mut best = fit(0.0);
    for i in 1..=200 {
        let next = fit(0.05 * f64::from(i));
        if next.0 < best.0 {
            best = next;
        }
    }
    (best.1, best.2)
}

fn trial(run: &Run, quantity: Quantity, options: &Options) -> Trial {
    let start = match quantity {
        Quantity::Height => Start::Drop { height_m: run.values[0] },
        Quantity::Distance => {
            let (speed, offset_m) = rolling_start(&run.times, &run.values, options.speed_window_s);
            Start::Roll { speed, offset_m, spin: run.spin.unwrap_or(options.spin) }
        }
    };
    let (times, values) = thinned(run, options.every_s, options.duration_s);
    Trial { name: run.name.clone(), quantity, start, times, values }
}

/// Linear interpolation; `None` outside the run.
fn value_at(run: &Run, t: f64) -> Option<f64> {
    let i = run.times.iter().position(|x| *x >= t - 1e-9)?;
    if i == 0 {
        return Some(run.values[0]);
    }
    let (a, b) = (run.times[i - 1], run.times[i]);
    let s = ((t - a) / (b - a)).min(1.0);
    Some(run.values[i - 1] + s * (run.values[i] - run.values[i - 1]))
}

/// The mean of at least one run at multiples of `every` up to `end` `[s]` or as long as all of them last.
fn mean_run(runs: &[Run], every: f64, end: f64) -> Run {
    let mut mean = Run { name: "mean".to_owned(), times: Vec::new(), values: Vec::new(), spin: runs[0].spin };
    for i in 0..=(end / every + 1e-3) as u32 {
        let t = every * f64::from(i);
        let Some(values) = runs.iter().map(|r| value_at(r, t)).collect::<Option<Vec<f64>>>() else { break };
        mean.times.push(t);
        mean.values.push(values.iter().sum::<f64>() / values.len() as f64);
    }
    mean
}

/// Runs that are repeats of each other: those with the same spin.
pub fn repeats(runs: &[Run]) -> Vec<Vec<Run>> {
    let mut groups: Vec<Vec<Run>> = Vec::new();
    for run in runs {
        match groups.iter_mut().find(|g| g[0].spin == run.spin) {
            Some(group) => group.push(run.clone()),
            None => groups.push(vec![run.clone()]),
        }
    }
    groups
}

/// The experiments of all runs of one quantity.
pub fn trials(runs: &[Run], quantity: Quantity, options: &Options) -> Vec<Trial> {
    if options.repeats == Repeats::Joint {
        return runs.iter().map(|run| trial(run, quantity, options)).collect();
    }
    repeats(runs).iter().map(|group| mean_trial(group, quantity, options)).collect()
}

/// The experiment of the mean of several runs.
fn mean_trial(runs: &[Run], quantity: Quantity, options: &Options) -> Trial {
    let mean = mean_run(runs, options.every_s, options.duration_s);
    let mut one = trial(&mean, quantity, options);
    // The mean of the runs' own starts, which know the frames between the compared samples.
    let starts: Vec<Start> = runs.iter().map(|run| trial(run, quantity, options).start).collect();
    let n = starts.len() as f64;
    if let Start::Roll { speed, offset_m, .. } = &mut one.start {
        let of = |pick: fn(&Start) -> f64| starts.iter().map(pick).sum::<f64>() / n;
        *speed = of(|s| if let Start::Roll { speed, .. } = s { *speed } else { 0.0 });
        *offset_m = of(|s| if let Start::Roll { offset_m, .. } = s { *offset_m } else { 0.0 });
    }
    one
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(rate: f64, end: f64, f: impl Fn(f64) -> f64) -> Run {
        let times: Vec<f64> = (0..=(end * rate) as usize).map(|i| i as f64 / rate).collect();
        let values = times.iter().map(|t| f(*t)).collect();
        Run { name: "1".into(), times, values, spin: None }
    }

    #[test]
    fn the_first_speed_is_found_under_any_resistance() {
        for rate in [0.0, 0.5, 1.7, 4.0] {
            for camera in [10.0, 60.0, 240.0] {
                let roll = run(camera, 2.0, |t| {
                    0.2 + if rate == 0.0 { 2.5 * t } else { 2.5 * (1.0 - (-rate * t).exp()) / rate }
                });
                let (speed, offset) = rolling_start(&roll.times, &roll.values, 0.5);
                assert!(
                    (speed - 2.5).abs() < 0.01 && (offset - 0.2).abs() < 0.002,
                    "{rate} {camera}: {speed}"
                );
            }
        }
        // Constant deceleration, as of a sliding ball.
        let slide = run(60.0, 2.0, |t| 3.0 * t - 0.5 * 0.7 * t * t);
        let (speed, _) = rolling_start(&slide.times, &slide.values, 0.5);
        assert!((speed - 3.0).abs() < 0.02, "{speed}");
    }

    #[test]
    fn samples_every_tenth_of_a_second_are_compared_whatever_the_camera() {
        for camera in [10.0, 24.0, 30.0, 60.0, 240.0] {
            let drop = run(camera, 3.0, |t| 1.0 - 0.1 * t);
            let one = &trials(&[drop], Quantity::Height, &Options::default())[0];
            assert_eq!(one.times.len(), 21, "{camera}: {:?}", one.times);
            assert!(one.times.iter().enumerate().all(|(i, t)| (t - 0.1 * i as f64).abs() <= 1.0 / camera));
            assert_eq!(one.start, Start::Drop { height_m: 1.0 });
        }
    }

    #[test]
    fn repeats_can_be_averaged() {
        let options = Options { repeats: Repeats::Mean, ..Options::default() };
        let rolls = [run(60.0, 2.0, |t| 2.0 * t), run(30.0, 1.5, |t| 0.1 + 3.0 * t)];
        let all = trials(&rolls, Quantity::Distance, &options);
        assert_eq!(all.len(), 1);
        assert!((all[0].times.last().expect("samples") - 1.5).abs() < 1e-9);
        assert!((all[0].values[10] - (0.05 + 2.5)).abs() < 1e-9);
        let Start::Roll { speed, offset_m, .. } = all[0].start else { panic!("a roll") };
        assert!((speed - 2.5).abs() < 1e-6 && (offset_m - 0.05).abs() < 1e-6);
        // A sliding ball is no repeat of a rolling one.
        let slide = Run { spin: Some(0.0), ..rolls[0].clone() };
        let all = trials(&[rolls[0].clone(), slide], Quantity::Distance, &options);
        assert_eq!(all.len(), 2);
        assert!(matches!(all[1].start, Start::Roll { spin: 0.0, .. }));
    }
}
