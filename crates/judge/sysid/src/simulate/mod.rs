//! Measurements where the truth is known: the same files that a camera would give.
//!
//! Three sources: the built-in engine with known parameters; MuJoCo's ball, another contact model; and closed-form motion
//! with FIFA's test figures, free of any engine.

mod fifa;
mod mujoco;

use paid_lanes::Isa;
use paid_lanes::rng::Rng;
use paid_physics::{BallParams, SceneConfig};

pub use fifa::{FifaFigures, ramp_speed};
pub use mujoco::MujocoBall;

use crate::SysidError;
use crate::csv::Run;
use crate::lab::{Launch, Start, engine_lab};

/// Who moves the ball.
#[derive(Clone, Debug)]
pub enum Source {
    /// The built-in engine.
    Engine {
        /// The ball with the true parameters.
        ball: BallParams,
        /// Ground and solver.
        scene: SceneConfig,
        /// Instruction set.
        isa: Isa,
    },
    /// MuJoCo.
    Mujoco(MujocoBall),
    /// Closed form, from the figures of FIFA's tests.
    Fifa(FifaFigures),
}

/// What is filmed, and how well.
#[derive(Clone, Debug, PartialEq)]
pub struct Experiment {
    /// Repeats of each experiment (paper: 5).
    pub repeats: usize,
    /// Height of release `[m]`; repeats differ by 1 cm (standard deviation), as hands do.
    pub height_m: f64,
    /// Initial speed `[m/s]`; repeats differ by 3%.
    pub speed: f64,
    /// Spin of the rolling ball at the start: 1 rolls, 0 slides.
    pub spin: f64,
    /// Length of a run `[s]` (paper: 2 s).
    pub duration_s: f64,
    /// Camera frames per second (paper: a sample every 0.1 s).
    pub rate_hz: f64,
    /// Standard deviation of the camera's error on a position `[m]`.
    pub noise_m: f64,
    /// Seed of noise and repeats.
    pub seed: u64,
}

impl Default for Experiment {
    /// The paper's experiments, a phone camera's noise.
    fn default() -> Self {
        Self {
            repeats: 5,
            height_m: 2.0,
            speed: 2.0,
            spin: 1.0,
            duration_s: 2.0,
            rate_hz: 10.0,
            noise_m: 0.005,
            seed: 0,
        }
    }
}

/// Measured runs.
#[derive(Clone, Debug, PartialEq)]
pub struct Measurements {
    /// Drops.
    pub drops: Vec<Run>,
    /// Rolls.
    pub rolls: Vec<Run>,
}

/// Spread of the repeats: heights `[m]` and relative speeds.
const HAND: [f64; 2] = [0.01, 0.03];
/// Streams of random numbers.
const STARTS: u32 = 0;
const NOISE: u32 = 1;

impl Experiment {
    /// Checks every number.
    ///
    /// # Errors
    /// Option, expected, found.
    pub fn validate(&self) -> Result<(), SysidError> {
        for (name, x, lo, hi) in [
            ("height_m", self.height_m, 0.3, 20.0),
            ("speed", self.speed, 0.2, 20.0),
            ("spin", self.spin, 0.0, 3.0),
            ("duration_s", self.duration_s, 0.5, 20.0),
            ("rate_hz", self.rate_hz, 5.0, 1000.0),
            ("noise_m", self.noise_m, 0.0, 0.1),
        ] {
            if !(lo..=hi).contains(&x) {
                return Err(SysidError::option(name, &format!("{lo} to {hi}"), x));
            }
        }
        if !(1..=100).contains(&self.repeats) {
            return Err(SysidError::option("repeats", "1 to 100", self.repeats));
        }
        Ok(())
    }

    fn times(&self) -> Vec<f64> {
        let frames = (self.duration_s * self.rate_hz + 1e-9) as usize;
        (0..=frames).map(|i| i as f64 / self.rate_hz).collect()
    }

    /// Heights `[m]` and speeds `[m/s]` of the repeats.
    fn starts(&self) -> (Vec<f64>, Vec<f64>) {
        let mut rng = Rng::new(self.seed, 0, STARTS);
        let mut pair = || {
            let height = self.height_m + HAND[0] * rng.normal();
            (height.max(0.2), self.speed * (1.0 + HAND[1] * rng.normal()))
        };
        (0..self.repeats).map(|_| pair()).unzip()
    }
}

/// Makes measurements.
///
/// # Errors
/// If an option is out of range, or the source refuses.
pub fn simulate(experiment: &Experiment, source: &Source) -> Result<Measurements, SysidError> {
    experiment.validate()?;
    let times = experiment.times();
    let (heights, speeds) = experiment.starts();
    let (drops, rolls) = match source {
        Source::Engine { ball, scene, isa } => {
            let mut lab = engine_lab(*isa, scene)?;
            let drop = |height_m: &f64| Start::Drop { height_m: *height_m };
            let roll = |v: &f64| Start::Roll { speed: *v, offset_m: 0.0, spin: experiment.spin };
            let mut run = |starts: Vec<Start>| {
                let launch = |start: &Start| Launch { ball: *ball, start: *start, times: &times };
                lab.run(&starts.iter().map(launch).collect::<Vec<_>>())
            };
            (run(heights.iter().map(drop).collect()), run(speeds.iter().map(roll).collect()))
        }
        Source::Mujoco(ball) => (
            heights.iter().map(|h| ball.drop(*h, &times)).collect::<Result<_, _>>()?,
            speeds.iter().map(|v| ball.roll(*v, experiment.spin, &times)).collect::<Result<_, _>>()?,
        ),
        Source::Fifa(figures) => figures.measure(&heights, &speeds, &times, experiment.seed)?,
    };
    let filmed = |curves: Vec<Vec<f64>>, experiment_index: u32| {
        (0..)
            .zip(curves)
            .map(|(i, curve): (u32, Vec<f64>)| {
                let mut rng = Rng::new(experiment.seed, 2 * i + experiment_index, NOISE);
                let values = curve.iter().map(|x| x + experiment.noise_m * rng.normal()).collect();
                Run { name: (i + 1).to_string(), times: times.clone(), values, spin: None }
            })
            .collect()
    };
    Ok(Measurements { drops: filmed(drops, 0), rolls: filmed(rolls, 1) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn repeats_differ_and_the_noise_is_as_large_as_asked() {
        let source =
            Source::Engine { ball: BallParams::default(), scene: SceneConfig::default(), isa: Isa::Portable };
        let exact = simulate(&Experiment { noise_m: 0.0, ..Experiment::default() }, &source).expect("runs");
        let noisy = simulate(&Experiment::default(), &source).expect("runs");
        assert_eq!((exact.drops.len(), exact.rolls.len(), exact.drops[0].times.len()), (5, 5, 21));
        assert_ne!(exact.drops[0].values, exact.drops[1].values);
        let errors: Vec<f64> = exact
            .drops
            .iter()
            .chain(&exact.rolls)
            .zip(noisy.drops.iter().chain(&noisy.rolls))
            .flat_map(|(a, b)| a.values.iter().zip(&b.values).map(|(x, y)| x - y))
            .collect();
        let rms = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
        assert!((rms - 0.005).abs() < 0.001, "{rms}");
        assert_eq!(simulate(&Experiment::default(), &source).expect("runs"), noisy);
    }

    #[test]
    fn an_impossible_experiment_is_refused() {
        let source = Source::Fifa(FifaFigures::TURF);
        let error =
            simulate(&Experiment { rate_hz: 1.0, ..Experiment::default() }, &source).expect_err("too slow");
        assert!(error.to_string().contains("rate_hz: expected 5 to 1000, found 1"), "{error}");
    }
}
