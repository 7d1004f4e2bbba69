//! What the trainer needs of a shard beyond the learner's view, and the adapter for the task.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use paid_learn::{StepBuffers, VecEnv};
use paid_task::{SamplerState, TaskMetrics, TaskShard};

/// A shard of environments that also reports and takes the adaptive sampler.
pub trait TrainShard: VecEnv {
    /// Sums and counts since the last call.
    fn take_metrics(&mut self) -> TaskMetrics;
    /// Failures by (motion, phase bin) since the last call.
    fn take_failures(&mut self) -> Vec<f32>;
    /// A uniform sampler of the right size.
    fn new_sampler(&self) -> SamplerState;
    /// From now on resets draw from this distribution.
    fn set_sampler(&mut self, sampler: &SamplerState);
}

/// A task's shard under the learner's interface.
pub struct TaskEnv(pub Box<dyn TaskShard>);

impl VecEnv for TaskEnv {
    fn num_envs(&self) -> usize {
        self.0.num_envs()
    }
    fn policy_obs_dim(&self) -> usize {
        self.0.policy_obs_dim()
    }
    fn critic_obs_dim(&self) -> usize {
        self.0.critic_obs_dim()
    }
    fn action_dim(&self) -> usize {
        self.0.action_dim()
    }
    fn observe(&mut self, policy: &mut [f32], critic: &mut [f32]) {
        self.0.observe(policy, critic);
    }
    fn step(&mut self, actions: &[f32], out: StepBuffers<'_>) {
        self.0.step(actions, out.reward, out.terminated, out.truncated);
    }
    fn save(&self) -> Vec<u8> {
        self.0.save()
    }
    fn restore(&mut self, bytes: &[u8]) -> Result<(), String> {
        self.0.restore(bytes)
    }
}

impl TrainShard for TaskEnv {
    fn take_metrics(&mut self) -> TaskMetrics {
        self.0.take_metrics()
    }
    fn take_failures(&mut self) -> Vec<f32> {
        self.0.take_failures()
    }
    fn new_sampler(&self) -> SamplerState {
        self.0.new_sampler()
    }
    fn set_sampler(&mut self, sampler: &SamplerState) {
        self.0.set_sampler(sampler);
    }
}

/// A shard that the learner steps and the trainer talks to between rollouts: both hold it, never at the same time.
pub struct Handle<E>(Arc<Mutex<E>>);

impl<E> Handle<E> {
    /// The first handle of a shard.
    pub fn new(shard: E) -> Self {
        Self(Arc::new(Mutex::new(shard)))
    }

    /// Another handle of the same shard.
    pub fn another(&self) -> Self {
        Self(Arc::clone(&self.0))
    }

    /// The shard. Uncontended: the learner's and the trainer's phases follow one another.
    pub fn get(&self) -> MutexGuard<'_, E> {
        // A poisoned shard means a panic in another thread, which ends the run there.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<E: VecEnv> VecEnv for Handle<E> {
    fn num_envs(&self) -> usize {
        self.get().num_envs()
    }
    fn policy_obs_dim(&self) -> usize {
        self.get().policy_obs_dim()
    }
    fn critic_obs_dim(&self) -> usize {
        self.get().critic_obs_dim()
    }
    fn action_dim(&self) -> usize {
        self.get().action_dim()
    }
    fn observe(&mut self, policy: &mut [f32], critic: &mut [f32]) {
        self.get().observe(policy, critic);
    }
    fn step(&mut self, actions: &[f32], out: StepBuffers<'_>) {
        self.get().step(actions, out);
    }
    fn save(&self) -> Vec<u8> {
        self.get().save()
    }
    fn restore(&mut self, bytes: &[u8]) -> Result<(), String> {
        self.get().restore(bytes)
    }
}
