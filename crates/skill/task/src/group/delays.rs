//! Delays of actions and observations, up to one control step.

use paid_lanes::Real;

use crate::config::TaskConfig;

/// Delays of a group and what they need to remember.
#[derive(Clone, Debug)]
pub(crate) struct Delays<V> {
    /// Delay of the action `[control steps]`.
    pub action: V,
    /// Delay of the sensed terms `[control steps]`.
    observation: V,
    /// The policy's sensed terms one control step ago, in the order of its list.
    pub before: Vec<V>,
}

impl<V: Real> Delays<V> {
    /// Where the preset has delays.
    pub(crate) fn new(config: &TaskConfig) -> Option<Self> {
        config.preset.delays().then(|| Self {
            action: V::zero(),
            observation: V::zero(),
            before: vec![V::zero(); config.observations.sensed],
        })
    }

    pub(crate) fn fields(&mut self) -> Vec<&mut V> {
        let mut fields = vec![&mut self.action, &mut self.observation];
        fields.extend(self.before.iter_mut());
        fields
    }

    pub(crate) fn reset_lane(&mut self, lane: usize, delays: [f64; 2]) {
        self.action.set_lane(lane, delays[0]);
        self.observation.set_lane(lane, delays[1]);
    }

    /// Number `k` of the sensed terms, `now` at this moment, as the policy gets it: between two control steps.
    #[inline(always)]
    pub(crate) fn delayed(&self, k: usize, now: V) -> V {
        (self.before[k] - now).mul_add(self.observation, now)
    }
}
