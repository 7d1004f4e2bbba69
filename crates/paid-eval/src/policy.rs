//! What the evaluation asks of a policy.

use std::sync::Arc;

use paid_learn::model::PolicyState;

use crate::EvalError;

/// A deterministic policy that drives a batch of environments. Matrices are feature-major `[features, envs]`.
pub trait Policy: Send {
    /// Length of the observation.
    fn obs_dim(&self) -> usize;
    /// Length of the action.
    fn action_dim(&self) -> usize;
    /// All environments begin an episode now: `envs` of them from here on, recurrent state zero.
    fn begin(&mut self, envs: usize);
    /// Writes the mean actions `[action_dim, envs]` for the observations `[obs_dim, envs]` and advances the recurrent state.
    fn act(&mut self, observations: &[f32], actions: &mut [f32]);
}

/// Makes one policy for each worker thread.
pub type PolicyMaker<'a> = dyn Fn() -> Result<Box<dyn Policy>, EvalError> + Sync + 'a;

/// Holds the default pose: the baseline that anything trained must beat.
#[derive(Clone, Copy, Debug)]
pub struct ZeroPolicy {
    /// Length of the observation that it ignores.
    pub obs_dim: usize,
    /// Length of the action.
    pub action_dim: usize,
}

impl Policy for ZeroPolicy {
    fn obs_dim(&self) -> usize {
        self.obs_dim
    }
    fn action_dim(&self) -> usize {
        self.action_dim
    }
    fn begin(&mut self, _envs: usize) {}
    fn act(&mut self, _observations: &[f32], actions: &mut [f32]) {
        actions.fill(0.0);
    }
}

/// A trained network's mean action.
#[derive(Clone, Debug)]
pub struct LearnedPolicy {
    policy: Arc<paid_learn::Policy>,
    state: PolicyState,
}

impl LearnedPolicy {
    /// Shares the weights with other threads' policies.
    pub fn new(policy: Arc<paid_learn::Policy>) -> Self {
        Self { state: policy.start(0), policy }
    }

    /// Makes one for each thread.
    pub fn maker(policy: paid_learn::Policy) -> impl Fn() -> Result<Box<dyn Policy>, EvalError> + Sync {
        let policy = Arc::new(policy);
        move || Ok(Box::new(Self::new(Arc::clone(&policy))) as Box<dyn Policy>)
    }
}

impl Policy for LearnedPolicy {
    fn obs_dim(&self) -> usize {
        self.policy.obs_dim()
    }
    fn action_dim(&self) -> usize {
        self.policy.action_dim()
    }
    fn begin(&mut self, envs: usize) {
        self.state = self.policy.start(envs);
    }
    fn act(&mut self, observations: &[f32], actions: &mut [f32]) {
        self.policy.act(observations, &mut self.state, actions);
    }
}
