//! What is searched, how, and from where: the appendix's numbers as defaults.

use paid_physics::BallParams;
use serde::{Deserialize, Serialize};

use crate::SysidError;

/// Number of identified parameters.
pub const PARAMETERS: usize = 5;
/// Their names, in the order of every vector of parameters.
pub const NAMES: [&str; PARAMETERS] =
    ["static_friction", "dynamic_friction", "restitution", "linear_damping", "angular_damping"];

/// One value per parameter, in the order of [`NAMES`]: two Coulomb coefficients, restitution, two dampings `[1/s]`.
pub type Parameters = [f64; PARAMETERS];

/// The ball with the parameters put in; mass, radius and inertia stay.
///
/// A dynamic friction above the static one raises the static one, as in the engine.
pub fn with_parameters(ball: &BallParams, p: &Parameters) -> BallParams {
    let mut ball = *ball;
    ball.material.static_friction = p[0].max(p[1]);
    ball.material.dynamic_friction = p[1];
    ball.material.restitution = p[2];
    ball.linear_damping = p[3];
    ball.angular_damping = p[4];
    ball
}

/// The parameters of a ball.
pub fn parameters_of(ball: &BallParams) -> Parameters {
    let m = ball.material;
    [m.static_friction, m.dynamic_friction, m.restitution, ball.linear_damping, ball.angular_damping]
}

/// What is done with the repeats of an experiment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Repeats {
    /// One set of parameters for all of them, each from its own initial condition.
    Joint,
    /// Averaged over time first; one experiment is left.
    Mean,
}

/// Where the simulated experiments begin.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Starts {
    /// At the first height, and at the speed of the first samples (paper).
    FirstSamples,
    /// There, corrected by what makes the whole run fit best, for every candidate: a speed from few samples is the largest
    /// error of a roll.
    Refined,
}

/// How parameters are set that the measurements do not show.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Unseen {
    /// They keep the value of the ball put in, moved into the range that fits as well.
    Kept,
    /// They take the value at which the best search happened to end (paper).
    Fitted,
}

/// Numbers of an identification.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Options {
    /// Where the first search starts (paper, table of ball parameters).
    pub initial: Parameters,
    /// Search ranges (same table).
    pub range: [[f64; 2]; PARAMETERS],
    /// Initial step of the search, in units of each range (paper: 0.2; ranges of 5 and 1 otherwise would not be comparable).
    pub scale: f64,
    /// Candidates a generation (paper: 4).
    pub population: usize,
    /// A search ends when the best loss of a generation differs from that of the last one by less than this `[m^2]` (paper,
    /// algorithm; it gives no number).
    pub tolerance: f64,
    /// ... this many generations in a row (paper: 1).
    pub patience: usize,
    /// Generations after which a search ends anyway (the algorithm's T; no number given).
    pub generations: usize,
    /// Searches: the first starts at `initial`, the others at random. With a population of 4 a single search can
    /// be caught; the spread over searches shows it.
    pub restarts: usize,
    /// Random places of which the best becomes the start of a search other than the first.
    pub screening: usize,
    /// Weight of the squared height errors, lambda_1.
    pub weight_drop: f64,
    /// Weight of the squared distance errors, lambda_2.
    pub weight_roll: f64,
    /// Spacing of the compared samples `[s]` (paper: 0.1 s); frames between are used for initial conditions only.
    pub every_s: f64,
    /// What comes later is not compared `[s]` (paper: 2 s).
    pub duration_s: f64,
    /// The rolling ball's initial speed comes from the samples up to here `[s]` (paper: "the first few frames").
    pub speed_window_s: f64,
    /// Spin of the rolling ball at the first sample: 1 rolls, 0 slides.
    pub spin: f64,
    /// Repeats.
    pub repeats: Repeats,
    /// Initial heights and speeds.
    pub starts: Starts,
    /// Parameters that are not seen.
    pub unseen: Unseen,
    /// Positions are not trusted beyond this `[m]`, however well the curves agree.
    pub resolution_m: f64,
    /// Seed of the searches.
    pub seed: u64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            initial: [0.5, 0.5, 0.5, 1.0, 1.0],
            range: [[0.0, 1.0], [0.0, 1.0], [0.0, 1.0], [0.0, 5.0], [0.0, 5.0]],
            scale: 0.2,
            population: 4,
            tolerance: 1e-9,
            patience: 1,
            generations: 1000,
            restarts: 16,
            screening: 64,
            weight_drop: 1.0,
            weight_roll: 1.0,
            every_s: 0.1,
            duration_s: 2.0,
            speed_window_s: 0.5,
            spin: 1.0,
            repeats: Repeats::Joint,
            starts: Starts::FirstSamples,
            unseen: Unseen::Kept,
            resolution_m: 0.001,
            seed: 0,
        }
    }
}

impl Options {
    /// Checks every number.
    ///
    /// # Errors
    /// Option, expected, found.
    pub fn validate(&self) -> Result<(), SysidError> {
        let positive = |name: &str, x: f64| {
            if x > 0.0 && x.is_finite() {
                return Ok(());
            }
            Err(SysidError::option(name, "a positive number", x))
        };
        for (name, x) in [
            ("scale", self.scale),
            ("every_s", self.every_s),
            ("duration_s", self.duration_s),
            ("speed_window_s", self.speed_window_s),
            ("resolution_m", self.resolution_m),
        ] {
            positive(name, x)?;
        }
        if self.every_s < 0.001 {
            return Err(SysidError::option("every_s", "at least 0.001 s", self.every_s));
        }
        if self.duration_s > 60.0 {
            return Err(SysidError::option("duration_s", "at most 60 s", self.duration_s));
        }
        for (name, x) in [
            ("tolerance", self.tolerance),
            ("weight_drop", self.weight_drop),
            ("weight_roll", self.weight_roll),
            ("spin", self.spin),
        ] {
            if !(x >= 0.0 && x.is_finite()) {
                return Err(SysidError::option(name, "a number of at least 0", x));
            }
        }
        if self.weight_drop + self.weight_roll <= 0.0 {
            return Err(SysidError::option("weight_drop, weight_roll", "at least one above 0", "0 and 0"));
        }
        for (name, n, least, most) in [
            ("population", self.population, 2, 1024),
            ("patience", self.patience, 1, 1_000_000),
            ("generations", self.generations, 1, 1_000_000),
            ("restarts", self.restarts, 1, 1024),
            ("screening", self.screening, 1, 100_000),
        ] {
            if !(least..=most).contains(&n) {
                return Err(SysidError::option(name, &format!("{least} to {most}"), n));
            }
        }
        for (i, name) in NAMES.iter().enumerate() {
            let [lo, hi] = self.range[i];
            if !(lo >= 0.0 && lo < hi && hi.is_finite()) {
                let found = format!("{lo} to {hi}");
                return Err(SysidError::option(&format!("range of {name}"), "0 <= low < high", found));
            }
            if !(lo..=hi).contains(&self.initial[i]) {
                let expected = format!("{lo} to {hi}");
                return Err(SysidError::option(&format!("initial {name}"), &expected, self.initial[i]));
            }
        }
        Ok(())
    }

    /// Position of a value in its range, 0 to 1.
    pub fn to_unit(&self, p: &Parameters) -> Parameters {
        std::array::from_fn(|i| (p[i] - self.range[i][0]) / (self.range[i][1] - self.range[i][0]))
    }

    /// The value at a position of the range; positions outside 0 to 1 are mirrored into it, so that the search meets no wall.
    pub fn from_unit(&self, u: &Parameters) -> Parameters {
        std::array::from_fn(|i| {
            let [lo, hi] = self.range[i];
            let folded = u[i].rem_euclid(2.0);
            let inside = if folded > 1.0 { 2.0 - folded } else { folded };
            lo + (hi - lo) * inside
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_defaults_are_those_of_the_appendix_and_valid() {
        let options = Options::default();
        options.validate().expect("valid");
        assert_eq!((options.scale, options.population), (0.2, 4));
        assert_eq!(options.initial, [0.5, 0.5, 0.5, 1.0, 1.0]);
        assert_eq!(options.range[2..], [[0.0, 1.0], [0.0, 5.0], [0.0, 5.0]]);
    }

    #[test]
    fn positions_outside_the_range_are_mirrored() {
        let options = Options::default();
        let p = options.from_unit(&[-0.2, 1.3, 0.5, 2.1, -1.1]);
        for (found, want) in p.iter().zip([0.2, 0.7, 0.5, 0.5, 4.5]) {
            assert!((found - want).abs() < 1e-12, "{p:?}");
        }
        let inside = [0.1, 0.9, 0.3, 2.0, 4.0];
        let back = options.from_unit(&options.to_unit(&inside));
        assert!(inside.iter().zip(back).all(|(a, b)| (a - b).abs() < 1e-12));
    }

    #[test]
    fn a_wrong_number_is_named() {
        let wrong = Options { population: 1, ..Options::default() };
        let error = wrong.validate().expect_err("one candidate is no population").to_string();
        assert!(error.contains("population") && error.contains("found 1"), "{error}");
        let mut wrong = Options::default();
        wrong.initial[4] = 9.0;
        let error = wrong.validate().expect_err("outside").to_string();
        assert!(error.contains("initial angular_damping") && error.contains("0 to 5"), "{error}");
    }
}
