//! The loss of a candidate, and many searches for its minimum at once.

use paid_lanes::rng::Rng;
use paid_physics::BallParams;
use serde::Serialize;

use crate::cmaes::CmaEs;
use crate::csv::Quantity;
use crate::lab::{Lab, Launch, Start};
use crate::options::{Options, PARAMETERS, Parameters, Starts, with_parameters};
use crate::trial::Trial;

/// Change of a drop's height `[m]` and share of a roll's speed from which their effects are computed.
const SHIFT_M: f64 = 0.005;
const SHIFT_SHARE: f64 = 0.01;
/// What a start taken from first samples may be wrong by `[m, share of the speed]`, and a sample `[m]` (standard deviations).
const START_SD_M: f64 = 0.03;
const START_SD_SHARE: f64 = 0.1;
const SAMPLE_SD_M: f64 = 0.005;
/// Steps from the first guess of a start to its best value.
const REFINEMENTS: usize = 3;
/// Streams of the random numbers: places of the restarts, and steps of each search.
const PLACES: u32 = 0;
const STEPS: u32 = 1;

/// Experiments and the ball that is to repeat them.
#[derive(Clone, Debug)]
pub struct Problem<'a> {
    /// Mass, radius and inertia; the rest is replaced.
    pub ball: BallParams,
    /// What was measured.
    pub trials: Vec<&'a Trial>,
    /// Weights and ranges.
    pub options: &'a Options,
}

/// Why a search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Stop {
    /// The best loss no longer changed.
    Tolerance,
    /// The limit of generations.
    Generations,
}

/// One search.
#[derive(Clone, Debug, Serialize)]
pub struct Search {
    /// Where it began.
    pub start: Parameters,
    /// The best candidate it saw.
    pub best: Parameters,
    /// Its loss `[m^2]`.
    pub loss: f64,
    /// Why it ended.
    pub stop: Stop,
    /// Loss of the best candidate so far, a value a generation `[m^2]`.
    pub curve: Vec<f64>,
}

impl Problem<'_> {
    /// Measured less simulated positions `[candidate][trial][sample]` `[m]`. If the starts are to be refined, each trial's best
    /// correction of its start is taken out first.
    pub fn residuals(&self, lab: &mut dyn Lab, candidates: &[Parameters]) -> Vec<Vec<Vec<f64>>> {
        let refine = self.options.starts == Starts::Refined;
        let mut launches = Vec::with_capacity(candidates.len() * self.trials.len() * 2);
        for candidate in candidates {
            let ball = with_parameters(&self.ball, candidate);
            for trial in &self.trials {
                launches.push(Launch { ball, start: trial.start, times: &trial.times });
                if refine {
                    launches.push(Launch { ball, start: shifted(trial.start).0, times: &trial.times });
                }
            }
        }
        let mut all = lab.run(&launches).into_iter();
        let mut of_trial = |trial: &&Trial| {
            let base = all.next().unwrap_or_default();
            let residual = trial.values.iter().zip(&base).map(|(m, s)| m - s).collect();
            if !refine {
                return residual;
            }
            let moved = all.next().unwrap_or_default();
            correct(trial, residual, &base, &moved).0
        };
        candidates.iter().map(|_| self.trials.iter().map(&mut of_trial).collect()).collect()
    }

    /// The trials with the starts that fit a candidate best; unchanged if starts are not refined.
    pub fn refined(&self, lab: &mut dyn Lab, candidate: &Parameters) -> Vec<Trial> {
        let mut trials: Vec<Trial> = self.trials.iter().map(|t| (*t).clone()).collect();
        if self.options.starts == Starts::FirstSamples {
            return trials;
        }
        let ball = with_parameters(&self.ball, candidate);
        for trial in &mut trials {
            // The motion is not quite linear in its start.
            for _ in 0..REFINEMENTS {
                let launch = |start| Launch { ball, start, times: &trial.times };
                let found = lab.run(&[launch(trial.start), launch(shifted(trial.start).0)]);
                let residual = trial.values.iter().zip(&found[0]).map(|(m, s)| m - s).collect();
                let [along, offset] = correct(trial, residual, &found[0], &found[1]).1;
                match &mut trial.start {
                    Start::Drop { height_m } => *height_m += along,
                    Start::Roll { speed, offset_m, .. } => {
                        *speed += along;
                        *offset_m += offset;
                    }
                }
            }
        }
        trials
    }

    /// Sum of squared differences of each trial `[m^2]`, for every candidate.
    fn trial_errors(&self, lab: &mut dyn Lab, candidates: &[Parameters]) -> Vec<Vec<f64>> {
        let squares = |r: &Vec<f64>| r.iter().map(|x| x * x).sum::<f64>();
        self.residuals(lab, candidates).iter().map(|c| c.iter().map(squares).collect()).collect()
    }

    /// Weight of a trial's squared error: lambda over the number of repeats.
    fn weight(&self, trial: &Trial) -> f64 {
        let repeats = self.trials.iter().filter(|t| t.quantity == trial.quantity).count() as f64;
        match trial.quantity {
            Quantity::Height => self.options.weight_drop / repeats,
            Quantity::Distance => self.options.weight_roll / repeats,
        }
    }

    /// Losses (paper, equation of L_sysid) of candidates: weighted sums of squared differences, mean over the repeats `[m^2]`.
    pub fn losses(&self, lab: &mut dyn Lab, candidates: &[Parameters]) -> Vec<f64> {
        let weights: Vec<f64> = self.trials.iter().map(|t| self.weight(t)).collect();
        let weighted = |errors: &Vec<f64>| errors.iter().zip(&weights).map(|(e, w)| e * w).sum();
        self.trial_errors(lab, candidates).iter().map(weighted).collect()
    }

    /// Unweighted sums of squared differences of candidates `[m^2]`.
    pub fn square_sums(&self, lab: &mut dyn Lab, candidates: &[Parameters]) -> Vec<f64> {
        self.trial_errors(lab, candidates).iter().map(|errors| errors.iter().sum()).collect()
    }

    /// Compared samples.
    pub fn samples(&self) -> usize {
        self.trials.iter().map(|t| t.times.len()).sum()
    }
}

/// A slightly different start, and by how much: height `[m]` or speed `[m/s]`.
fn shifted(start: Start) -> (Start, f64) {
    match start {
        Start::Drop { height_m } => (Start::Drop { height_m: height_m + SHIFT_M }, SHIFT_M),
        Start::Roll { speed, offset_m, spin } => {
            let shift = SHIFT_SHARE * speed.abs().max(0.1);
            (Start::Roll { speed: speed + shift, offset_m, spin }, shift)
        }
    }
}

/// Takes the best correction of a trial's start out of its residual, by least squares from the motion with the start shifted.
/// Also returns the correction: height `[m]` or speed `[m/s]`, and the distance at the start `[m]`.
fn correct(trial: &Trial, residual: Vec<f64>, base: &[f64], moved: &[f64]) -> (Vec<f64>, [f64; 2]) {
    let shift = shifted(trial.start).1;
    let slope: Vec<f64> = base.iter().zip(moved).map(|(a, b)| (b - a) / shift).collect();
    // Corrections beyond what a first sample may be wrong by are held back.
    let (start_sd, has_offset) = match trial.start {
        Start::Drop { .. } => (START_SD_M, 0.0),
        Start::Roll { speed, .. } => (START_SD_SHARE * speed.abs().max(0.1), 1.0),
    };
    let n = slope.len() as f64 * has_offset;
    let sum = |x: &[f64]| x.iter().sum::<f64>() * has_offset;
    let dot = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(a, b)| a * b).sum::<f64>();
    let (gg, g1) = (dot(&slope, &slope) + (SAMPLE_SD_M / start_sd).powi(2), sum(&slope));
    let (gr, r1) = (dot(&slope, &residual), sum(&residual));
    // Normal equations of slope and offset; without an offset, of the slope alone.
    let n = n.max(1e-9);
    let along = (gr - g1 * r1 / n) / (gg - g1 * g1 / n).max(1e-12);
    let offset = has_offset * (r1 - g1 * along) / n;
    let left = residual.iter().zip(&slope).map(|(r, g)| r - g * along - offset).collect();
    (left, [along, offset])
}

/// Where the searches of an identification begin: the first at the initial values, each other one at the best of
/// `options.screening` random places. Large parts of the ranges are flat (a ball that never slides does not feel how slippery it
/// is), and a small population that begins there stays there.
pub fn starts(problem: &Problem<'_>, lab: &mut dyn Lab) -> Vec<Parameters> {
    let options = problem.options;
    let mut starts = vec![options.initial];
    for i in 1..options.restarts {
        let mut rng = Rng::new(options.seed, i as u32, PLACES);
        let mut place = || options.from_unit(&std::array::from_fn(|_| rng.unit()));
        let places: Vec<Parameters> = (0..options.screening).map(|_| place()).collect();
        let losses = problem.losses(lab, &places);
        let best = losses.iter().zip(&places).min_by(|a, b| a.0.total_cmp(b.0));
        starts.push(best.map_or(options.initial, |(_, place)| *place));
    }
    starts
}

struct Running {
    search: CmaEs<PARAMETERS>,
    report: Search,
    last: f64,
    quiet: usize,
    running: bool,
}

/// Searches from every start side by side, each with the initial `scale` (in units of the ranges). The candidates of all of
/// them are one batch of the lab.
pub fn search(problem: &Problem<'_>, lab: &mut dyn Lab, starts: &[Parameters], scale: f64) -> Vec<Search> {
    let options = problem.options;
    let mut all: Vec<Running> = (0..)
        .zip(starts)
        .map(|(i, start)| Running {
            search: CmaEs::new(
                options.to_unit(start),
                scale,
                options.population,
                Rng::new(options.seed, i, STEPS),
            ),
            report: Search {
                start: *start,
                best: *start,
                loss: f64::INFINITY,
                stop: Stop::Generations,
                curve: Vec::new(),
            },
            last: f64::INFINITY,
            quiet: 0,
            running: true,
        })
        .collect();
    for _ in 0..options.generations {
        let mut candidates = Vec::new();
        for one in all.iter_mut().filter(|one| one.running) {
            candidates.extend(one.search.ask().iter().map(|u| options.from_unit(u)));
        }
        if candidates.is_empty() {
            break;
        }
        let losses = problem.losses(lab, &candidates);
        let batches = losses.chunks(options.population).zip(candidates.chunks(options.population));
        for (one, (losses, candidates)) in all.iter_mut().filter(|one| one.running).zip(batches) {
            one.tell(losses, candidates, options);
        }
    }
    all.into_iter().map(|one| one.report).collect()
}

impl Running {
    fn tell(&mut self, losses: &[f64], candidates: &[Parameters], options: &Options) {
        self.search.tell(losses);
        let mut best = f64::INFINITY;
        for (loss, candidate) in losses.iter().zip(candidates) {
            best = best.min(*loss);
            if *loss < self.report.loss {
                (self.report.loss, self.report.best) = (*loss, *candidate);
            }
        }
        self.report.curve.push(self.report.loss);
        self.quiet = if (self.last - best).abs() < options.tolerance { self.quiet + 1 } else { 0 };
        self.last = best;
        if self.quiet >= options.patience {
            self.report.stop = Stop::Tolerance;
            self.running = false;
        }
    }
}
