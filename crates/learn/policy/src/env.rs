//! The one interface between a learner and its environments.

use crate::mirror::Mirrors;

/// Number of the group that the policy sees.
pub const POLICY: usize = 0;
/// Number of the group that the critic sees.
pub const CRITIC: usize = 1;

/// Name of the group that a discriminator of the style sees, where there is one.
pub const STYLE_GROUP: &str = "style";
/// Name of the group that a teacher sees, where there is one.
pub const TEACHER_GROUP: &str = "teacher";

/// Observations that belong together: what the policy sees, the critic, a discriminator or a teacher.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ObservationGroup {
    /// Name, for example `policy`.
    pub name: String,
    /// Number of features.
    pub size: usize,
}

impl ObservationGroup {
    /// A group of `size` features.
    pub fn new(name: impl Into<String>, size: usize) -> Self {
        Self { name: name.into(), size }
    }

    /// The two groups that every environment has, in order.
    pub fn policy_and_critic(policy: usize, critic: usize) -> Vec<Self> {
        vec![Self::new("policy", policy), Self::new("critic", critic)]
    }
}

/// Where a step writes its results, one entry per environment.
#[derive(Debug)]
pub struct StepBuffers<'a> {
    /// Reward of the step.
    pub reward: &'a mut [f32],
    /// 1 if the episode ended by failure: no value follows.
    pub terminated: &'a mut [u8],
    /// 1 if the episode was cut (time limit, motion end): the value of the last state is bootstrapped.
    pub truncated: &'a mut [u8],
}

impl<'a> StepBuffers<'a> {
    /// Buffers of one entry per environment.
    pub fn new(reward: &'a mut [f32], terminated: &'a mut [u8], truncated: &'a mut [u8]) -> Self {
        Self { reward, terminated, truncated }
    }
}

/// A shard of environments that one worker owns for a whole horizon. Matrices are feature-major `[features, num_envs]`.
///
/// ```
/// use paid_policy::{ObservationGroup, StepBuffers, VecEnv};
///
/// /// Points on a line that the action moves; the reward is higher near the origin.
/// struct Points(Vec<f32>);
///
/// impl VecEnv for Points {
///     fn num_envs(&self) -> usize {
///         self.0.len()
///     }
///     fn observation_groups(&self) -> Vec<ObservationGroup> {
///         ObservationGroup::policy_and_critic(1, 1)
///     }
///     fn action_dim(&self) -> usize {
///         1
///     }
///     fn observe(&mut self, groups: &mut [&mut [f32]]) {
///         for group in groups {
///             group.copy_from_slice(&self.0);
///         }
///     }
///     fn step(&mut self, actions: &[f32], out: StepBuffers<'_>) {
///         for (e, x) in self.0.iter_mut().enumerate() {
///             *x += actions[e];
///             out.reward[e] = -x.abs();
///         }
///         out.terminated.fill(0);
///         out.truncated.fill(0);
///     }
///     fn save(&self) -> Vec<u8> {
///         self.0.iter().flat_map(|x| x.to_le_bytes()).collect()
///     }
///     fn restore(&mut self, bytes: &[u8]) -> Result<(), String> {
///         if bytes.len() != 4 * self.0.len() {
///             return Err(format!("expected {} bytes, found {}", 4 * self.0.len(), bytes.len()));
///         }
///         for (x, word) in self.0.iter_mut().zip(bytes.chunks_exact(4)) {
///             *x = f32::from_le_bytes([word[0], word[1], word[2], word[3]]);
///         }
///         Ok(())
///     }
/// }
///
/// let mut env = Points(vec![1.0, -2.0]);
/// let (mut reward, mut terminated, mut truncated) = ([0.0; 2], [0; 2], [0; 2]);
/// env.step(&[-1.0, 1.0], StepBuffers::new(&mut reward, &mut terminated, &mut truncated));
/// assert_eq!(reward, [0.0, -1.0]);
/// let mut policy = [0.0; 2];
/// env.observe(&mut [&mut policy]);
/// assert_eq!(policy, [0.0, -1.0]);
/// ```
pub trait VecEnv: Send {
    /// Number of environments.
    fn num_envs(&self) -> usize;
    /// The observation groups: number [`POLICY`] is the policy's (with noise), number [`CRITIC`] the critic's; further ones are
    /// collected as they are, for a reward that the learner computes or for a teacher.
    fn observation_groups(&self) -> Vec<ObservationGroup>;
    /// Number of actions.
    fn action_dim(&self) -> usize;
    /// How the policy's observation and actions read in a mirrored world.
    ///
    /// # Errors
    /// Why environments have no mirror image.
    fn mirrors(&self) -> Result<Mirrors, String> {
        Err("these environments have no mirror image".to_owned())
    }
    /// Writes the current observations, one matrix `[size, num_envs]` per group, in the order of the groups. The last groups may be
    /// left out by a caller that does not need them.
    ///
    /// # Panics
    /// If a slice has another length.
    fn observe(&mut self, groups: &mut [&mut [f32]]);
    /// Advances all environments by one control step under `actions` `[action_dim, num_envs]`; environments whose
    /// episode ended are reset before this returns, so the next `observe` shows the new episode.
    ///
    /// # Panics
    /// If a slice has another length.
    fn step(&mut self, actions: &[f32], out: StepBuffers<'_>);
    /// Serializes everything that the next steps depend on, for an exact resume.
    fn save(&self) -> Vec<u8>;
    /// Restores what `save` wrote.
    ///
    /// # Errors
    /// A plain sentence if the bytes do not fit this environment.
    fn restore(&mut self, bytes: &[u8]) -> Result<(), String>;

    /// Features of the policy's observation.
    fn policy_obs_dim(&self) -> usize {
        self.observation_groups()[POLICY].size
    }
    /// Features of the critic's observation.
    fn critic_obs_dim(&self) -> usize {
        self.observation_groups()[CRITIC].size
    }
}
