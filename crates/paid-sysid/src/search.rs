//! The loss of a candidate, and many searches for its minimum at once.

use paid_lanes::rng::Rng;
use paid_physics::BallParams;
use serde::Serialize;

use crate::cmaes::CmaEs;
use crate::csv::Quantity;
use crate::lab::{Lab, Launch};
use crate::options::{Options, PARAMETERS, Parameters, with_parameters};
use crate::trial::Trial;

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
    /// Its loss [m^2].
    pub loss: f64,
    /// Why it ended.
    pub stop: Stop,
    /// Loss of the best candidate so far, a value a generation [m^2].
    pub curve: Vec<f64>,
}

impl Problem<'_> {
    /// Trajectories `[candidate][trial][sample]` [m].
    pub fn simulate(&self, lab: &mut dyn Lab, candidates: &[Parameters]) -> Vec<Vec<Vec<f64>>> {
        let mut launches = Vec::with_capacity(candidates.len() * self.trials.len());
        for candidate in candidates {
            let ball = with_parameters(&self.ball, candidate);
            for trial in &self.trials {
                launches.push(Launch { ball, start: trial.start, times: &trial.times });
            }
        }
        let mut all = lab.run(&launches).into_iter();
        candidates.iter().map(|_| all.by_ref().take(self.trials.len()).collect()).collect()
    }

    /// Sum of squared differences of each trial [m^2], for every candidate.
    fn trial_errors(&self, lab: &mut dyn Lab, candidates: &[Parameters]) -> Vec<Vec<f64>> {
        let of_trial = |(found, trial): (&Vec<f64>, &&Trial)| {
            found.iter().zip(&trial.values).map(|(a, b)| (a - b).powi(2)).sum::<f64>()
        };
        let simulated = self.simulate(lab, candidates);
        simulated.iter().map(|c| c.iter().zip(&self.trials).map(of_trial).collect()).collect()
    }

    /// Weight of a trial's squared error: lambda over the number of repeats.
    fn weight(&self, trial: &Trial) -> f64 {
        let repeats = self.trials.iter().filter(|t| t.quantity == trial.quantity).count() as f64;
        match trial.quantity {
            Quantity::Height => self.options.weight_drop / repeats,
            Quantity::Distance => self.options.weight_roll / repeats,
        }
    }

    /// Losses (paper, equation of L_sysid) of candidates: weighted sums of squared differences, mean over the repeats [m^2].
    pub fn losses(&self, lab: &mut dyn Lab, candidates: &[Parameters]) -> Vec<f64> {
        let weights: Vec<f64> = self.trials.iter().map(|t| self.weight(t)).collect();
        let weighted = |errors: &Vec<f64>| errors.iter().zip(&weights).map(|(e, w)| e * w).sum();
        self.trial_errors(lab, candidates).iter().map(weighted).collect()
    }

    /// Unweighted sums of squared differences of candidates [m^2].
    pub fn square_sums(&self, lab: &mut dyn Lab, candidates: &[Parameters]) -> Vec<f64> {
        self.trial_errors(lab, candidates).iter().map(|errors| errors.iter().sum()).collect()
    }

    /// Compared samples.
    pub fn samples(&self) -> usize {
        self.trials.iter().map(|t| t.times.len()).sum()
    }
}

/// Where the searches of an identification begin: the first at the initial values, the others anywhere in the ranges.
pub fn starts(options: &Options) -> Vec<Parameters> {
    let place = |i: usize| {
        let mut rng = Rng::new(options.seed, i as u32, PLACES);
        let unit: [f64; PARAMETERS] = std::array::from_fn(|_| rng.unit());
        options.from_unit(&unit)
    };
    (0..options.restarts).map(|i| if i == 0 { options.initial } else { place(i) }).collect()
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
