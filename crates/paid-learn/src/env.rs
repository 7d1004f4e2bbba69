//! What the learner needs of an environment.

/// Where a step writes its results, one entry an environment.
#[derive(Debug)]
pub struct StepBuffers<'a> {
    /// Reward of the step.
    pub reward: &'a mut [f32],
    /// 1 if the episode ended by failure: no value follows.
    pub terminated: &'a mut [u8],
    /// 1 if the episode was cut (time limit, motion end): the value of the last state is bootstrapped.
    pub truncated: &'a mut [u8],
}

/// A shard of environments that one worker owns for a whole horizon. Matrices are feature-major `[features, num_envs]`.
pub trait VecEnv: Send {
    /// Number of environments.
    fn num_envs(&self) -> usize;
    /// Features of the policy's observation.
    fn policy_obs_dim(&self) -> usize;
    /// Features of the critic's observation.
    fn critic_obs_dim(&self) -> usize;
    /// Number of actions.
    fn action_dim(&self) -> usize;
    /// Writes the current observations: `policy` is `[policy_obs_dim, num_envs]` (with noise), `critic` `[critic_obs_dim, num_envs]`.
    fn observe(&mut self, policy: &mut [f32], critic: &mut [f32]);
    /// Advances all environments by one control step under `actions` `[action_dim, num_envs]`; environments whose
    /// episode ended are reset before this returns, so the next `observe` shows the new episode.
    fn step(&mut self, actions: &[f32], out: StepBuffers<'_>);
    /// Serializes everything that the next steps depend on, for an exact resume.
    fn save(&self) -> Vec<u8>;
    /// Restores what `save` wrote.
    ///
    /// # Errors
    /// A plain sentence if the bytes do not fit this environment.
    fn restore(&mut self, bytes: &[u8]) -> Result<(), String>;
}
