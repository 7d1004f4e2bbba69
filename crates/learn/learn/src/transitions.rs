//! The further observation groups of a horizon, in the order of time, with rewards and ends.

use paid_policy::ObservationGroup;
use paid_policy::matrix::Mat;

/// What one shard collected in one horizon, for rewards that the learner computes: raw observations of the further groups before
/// and after each step, the task's reward, and where episodes ended.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Transitions {
    envs: usize,
    steps: usize,
    groups: Vec<ObservationGroup>,
    /// `[steps + 1, size, envs]` of each group.
    observations: Vec<Vec<f32>>,
    /// `[steps, envs]`.
    reward: Vec<f32>,
    /// `[steps, envs]`.
    done: Vec<u8>,
}

impl Transitions {
    /// Space for a horizon.
    pub fn new(envs: usize, steps: usize, groups: &[ObservationGroup]) -> Self {
        Self {
            envs,
            steps,
            groups: groups.to_vec(),
            observations: groups.iter().map(|group| vec![0.0; (steps + 1) * group.size * envs]).collect(),
            reward: vec![0.0; steps * envs],
            done: vec![0; steps * envs],
        }
    }

    /// Number of environments.
    pub fn envs(&self) -> usize {
        self.envs
    }

    /// Number of control steps.
    pub fn steps(&self) -> usize {
        self.steps
    }

    /// The further groups, in the environment's order.
    pub fn groups(&self) -> &[ObservationGroup] {
        &self.groups
    }

    /// Number of the group of a name.
    pub fn group(&self, name: &str) -> Option<usize> {
        self.groups.iter().position(|group| group.name == name)
    }

    /// Observation of group `group` before step `t`, `[size, envs]`, as the environment wrote it; numbers that are not finite are
    /// zero.
    pub fn before(&self, group: usize, t: usize) -> Mat<'_, f32> {
        let rows = self.groups[group].size;
        Mat::new(&self.observations[group][t * rows * self.envs..], rows, self.envs, self.envs)
    }

    /// Observation of group `group` after step `t`. Where the step ended an episode it is the first one of the next episode.
    pub fn after(&self, group: usize, t: usize) -> Mat<'_, f32> {
        self.before(group, t + 1)
    }

    /// The task's reward of step `t`, `[envs]`.
    pub fn task_reward(&self, t: usize) -> &[f32] {
        &self.reward[t * self.envs..(t + 1) * self.envs]
    }

    /// How step `t` ended, `[envs]`: bit 0 set if the episode failed, bit 1 if it was cut, 0 if it continues.
    pub fn done(&self, t: usize) -> &[u8] {
        &self.done[t * self.envs..(t + 1) * self.envs]
    }

    /// Where the environment writes the observations before step `t`, one slice per group.
    pub(crate) fn observations_mut(&mut self, t: usize) -> impl Iterator<Item = &mut [f32]> {
        let envs = self.envs;
        self.observations.iter_mut().zip(&self.groups).map(move |(values, group)| {
            let size = group.size * envs;
            &mut values[t * size..(t + 1) * size]
        })
    }

    /// Notes how a step of an environment went.
    pub(crate) fn record(&mut self, t: usize, e: usize, reward: f32, done: u8) {
        self.reward[t * self.envs + e] = reward;
        self.done[t * self.envs + e] = done;
    }
}
