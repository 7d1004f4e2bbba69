//! What the evaluation asks of a policy, and the policies that it knows: trained networks, ONNX files, a peer.

mod gains;
mod onnx;
mod twist2;

use std::sync::Arc;

use paid_policy::PolicyState;
use paid_task::EvalControl;

use crate::EvalError;

pub use gains::Gains;
pub use onnx::OnnxDriver;
pub use twist2::Twist2;

/// What a policy may look at before a control step.
#[derive(Clone, Copy)]
pub struct DriverInput<'a> {
    /// The task's observations `[obs_dim, envs]`.
    pub observations: &'a [f32],
    /// Environments.
    pub envs: usize,
    /// The state of every environment, for policies with observations of their own.
    pub world: &'a dyn EvalControl,
}

/// A deterministic policy that drives a batch of environments. Matrices are feature-major `[features, envs]`.
pub trait Driver: Send {
    /// Length of the task's observation; `None` for a policy that looks at the world itself.
    fn obs_dim(&self) -> Option<usize>;
    /// Length of the action.
    fn action_dim(&self) -> usize;
    /// All `envs` environments start an episode now, with a recurrent state of zero.
    fn begin(&mut self, envs: usize);
    /// Environment `env` begins another kick without a reset of the robot: its recurrent state is zero again, as at the begin of
    /// every episode of training.
    fn forget(&mut self, _env: usize) {}
    /// Writes the mean actions `[action_dim, envs]` for what is seen and advances the recurrent state.
    ///
    /// # Errors
    /// If the policy's runtime fails.
    fn act(&mut self, seen: DriverInput<'_>, actions: &mut [f32]) -> Result<(), EvalError>;
}

/// Makes one policy for each worker thread.
pub type DriverMaker<'a> = dyn Fn() -> Result<Box<dyn Driver>, EvalError> + Sync + 'a;

/// Holds the default pose: the baseline that anything trained must beat.
#[derive(Clone, Copy, Debug)]
pub struct ZeroDriver {
    /// Length of the observation that it ignores.
    pub obs_dim: usize,
    /// Length of the action.
    pub action_dim: usize,
}

impl Driver for ZeroDriver {
    fn obs_dim(&self) -> Option<usize> {
        Some(self.obs_dim)
    }
    fn action_dim(&self) -> usize {
        self.action_dim
    }
    fn begin(&mut self, _envs: usize) {}
    fn act(&mut self, _seen: DriverInput<'_>, actions: &mut [f32]) -> Result<(), EvalError> {
        actions.fill(0.0);
        Ok(())
    }
}

/// A trained network's mean action.
#[derive(Clone, Debug)]
pub struct NetworkDriver {
    policy: Arc<paid_policy::Policy>,
    state: PolicyState,
}

impl NetworkDriver {
    /// Shares the weights with other threads' policies.
    pub fn new(policy: Arc<paid_policy::Policy>) -> Self {
        Self { state: policy.start(0), policy }
    }

    /// Makes one for each thread.
    pub fn maker(policy: paid_policy::Policy) -> impl Fn() -> Result<Box<dyn Driver>, EvalError> + Sync {
        let policy = Arc::new(policy);
        move || Ok(Box::new(Self::new(Arc::clone(&policy))) as Box<dyn Driver>)
    }
}

impl Driver for NetworkDriver {
    fn obs_dim(&self) -> Option<usize> {
        Some(self.policy.obs_dim())
    }
    fn action_dim(&self) -> usize {
        self.policy.action_dim()
    }
    fn begin(&mut self, envs: usize) {
        self.state = self.policy.start(envs);
    }
    fn forget(&mut self, env: usize) {
        self.state.reset(env);
    }
    fn act(&mut self, seen: DriverInput<'_>, actions: &mut [f32]) -> Result<(), EvalError> {
        self.policy.act(seen.observations, &mut self.state, actions);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use paid_lanes::rng::Rng;
    use paid_policy::net::Network;
    use paid_policy::normalizer::Normalizer;
    use paid_policy::{LstmConfig, NetworkConfig, NetworkKind, Policy};

    #[test]
    fn a_kick_begins_with_an_empty_memory_and_the_others_keep_theirs() {
        let config = NetworkConfig {
            kind: NetworkKind::Lstm,
            hidden: vec![3],
            lstm: LstmConfig { layers: 2, size: 4, inputs: 0 },
            ..NetworkConfig::default()
        };
        let net = Network::new(2, 1, &config);
        let params = net.initialize(&mut Rng::new(1, 0, 0));
        let policy = Policy { params, normalizer: Normalizer::new(2), std: vec![0.1], net };
        let mut driver = NetworkDriver::new(Arc::new(policy.clone()));
        driver.begin(2);
        let (seen, mut actions) = ([0.5, -1.0, 2.0, 0.3], [0.0; 2]);
        policy.act(&seen, &mut driver.state, &mut actions);
        let (first, mut second) = (actions, [0.0; 2]);
        driver.forget(0);
        policy.act(&seen, &mut driver.state, &mut second);
        assert_eq!(second[0], first[0], "as at the begin of an episode");
        assert_ne!(second[1], first[1], "a memory that changes nothing");
    }
}
