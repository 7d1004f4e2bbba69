//! How much the policy tries out, by the phase of the motion.

use paid_lanes::Real;
use paid_physics::Simulator;
use serde::{Deserialize, Serialize};

use crate::preset::numbers::{FACTOR, TIME, check};
use crate::preset::{ReferenceSource, value_error};
use crate::{Task, TaskError};

/// Noise of the actions while a policy is trained. Evaluations have none.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ExplorationPreset {
    /// Factor on the noise's standard deviation near the strike; 1: none.
    pub near_strike: f64,
    /// Time to the reference's strike, before and after it, within which the factor holds `[s]`.
    pub around_s: f64,
}

impl Default for ExplorationPreset {
    fn default() -> Self {
        Self { near_strike: 1.0, around_s: 0.2 }
    }
}

impl ExplorationPreset {
    pub(crate) fn check(&self, reference: ReferenceSource) -> Result<(), TaskError> {
        check(
            "exploration",
            &[("near_strike", self.near_strike.into(), FACTOR), ("around_s", self.around_s.into(), TIME)],
        )?;
        if self.depends_on_phase() && reference == ReferenceSource::None {
            let expected = "1 in a task without a reference, which says when to strike";
            return Err(value_error("exploration.near_strike", expected, self.near_strike.to_string()));
        }
        Ok(())
    }

    fn depends_on_phase(&self) -> bool {
        self.near_strike != 1.0
    }
}

impl<V: Real, S: Simulator<V>> Task<V, S> {
    /// See [`paid_policy::VecEnv::exploration`].
    pub(crate) fn exploration_factors(&self, factors: &mut [f32]) -> bool {
        let preset = &self.config.preset.exploration;
        if !preset.depends_on_phase() {
            return false;
        }
        assert_eq!(factors.len(), self.envs.len(), "one factor per environment");
        for (env, factor) in factors.iter_mut().enumerate() {
            let to_strike_s = self.groups[env / V::LANES].to_strike_s.lane(env % V::LANES);
            let near = to_strike_s.abs() <= preset.around_s + 1e-6;
            *factor = if near { preset.near_strike as f32 } else { 1.0 };
        }
        true
    }
}
