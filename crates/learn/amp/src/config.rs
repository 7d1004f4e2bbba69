//! What a discriminator is and how it learns.

use serde::{Deserialize, Serialize};

use crate::AmpError;

/// Which game policy and discriminator play.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Formulation {
    /// Scores of 1 for the clips and -1 for the policy, by least squares; reward `max(0, 1 - (d - 1)^2 / 4)`, within 0 to 1. The
    /// penalty pulls the score's gradient at the clips to zero. (Peng et al. 2021, arXiv 2104.02180.)
    #[default]
    LeastSquares,
    /// The difference of the mean scores, with the gradient between clips and policy held at a norm of 1; reward `1 + tanh(0.4 z)`,
    /// within 0 to 2. (Reward as in arXiv 2511.03996, penalty of Gulrajani et al. 2017, arXiv 1704.00028.) There `z` is the score. Here
    /// it is how many deviations of the policy's scores the score lies above their mean: scores are as large as clips and policy are far apart, 70
    /// for a robot in 218 numbers, where tanh is flat.
    Wasserstein,
}

/// Discriminator and its training.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct AmpConfig {
    /// The game.
    pub formulation: Formulation,
    /// Widths of the hidden layers, with ReLU.
    pub hidden: Vec<usize>,
    /// Step size of Adam.
    pub learning_rate: f64,
    /// Factor on the weights (not the biases) that is added to their gradient.
    pub weight_decay: f64,
    /// Weight of the gradient penalty.
    pub gradient_penalty: f64,
    /// Weight of the mean squared score, which keeps scores small.
    pub score_penalty: f64,
    /// Pairs of frames of each kind in a step.
    pub batch: usize,
    /// Steps in an iteration.
    pub steps: usize,
    /// Pairs of earlier policies that are kept, at least a batch; half of a step's pairs come from there.
    pub replay: usize,
}

impl Default for AmpConfig {
    /// Settings in public use, with a network that a CPU can afford (they have `[1024, 512]`).
    fn default() -> Self {
        Self {
            formulation: Formulation::LeastSquares,
            hidden: vec![256, 128],
            learning_rate: 1e-4,
            weight_decay: 1e-4,
            gradient_penalty: 10.0,
            score_penalty: 0.01,
            batch: 1024,
            steps: 4,
            replay: 200_000,
        }
    }
}

impl AmpConfig {
    /// Checks every value.
    ///
    /// # Errors
    /// The first one out of range.
    pub fn check(&self) -> Result<(), AmpError> {
        let fail = |key: &'static str, expected: &'static str, found: String| {
            Err(AmpError::Config { key, expected, found })
        };
        if self.hidden.is_empty() || self.hidden.contains(&0) {
            return fail("hidden", "one or more widths above zero", format!("{:?}", self.hidden));
        }
        for (key, value) in [("batch", self.batch), ("steps", self.steps), ("replay", self.replay)] {
            if value == 0 {
                return fail(key, "one or more", "0".into());
            }
        }
        // All pairs of a step pass through the ring: in a smaller one they would take each other's place.
        if self.replay < self.batch {
            let found = format!("{} with a batch of {}", self.replay, self.batch);
            return fail("replay", "at least batch", found);
        }
        if !(self.learning_rate > 0.0 && self.learning_rate.is_finite()) {
            return fail("learning_rate", "above zero", self.learning_rate.to_string());
        }
        let weights = [
            ("weight_decay", self.weight_decay),
            ("gradient_penalty", self.gradient_penalty),
            ("score_penalty", self.score_penalty),
        ];
        for (key, value) in weights {
            if !(value >= 0.0 && value.is_finite()) {
                return fail(key, "zero or more", value.to_string());
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ring_that_does_not_hold_a_batch_is_refused() {
        let of = |replay| AmpConfig { batch: 64, replay, ..AmpConfig::default() }.check();
        of(64).expect("as many as a batch");
        let error = of(63).expect_err("one less").to_string();
        assert!(error.contains("replay") && error.contains("at least batch"), "{error}");
        assert!(error.contains("63 with a batch of 64"), "{error}");
    }
}
