//! Agents that need no training: a check of a preset before time is spent on it.

use paid_lanes::rng::Rng;

use crate::{TaskMetrics, TaskShard};

/// What the agent does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Agent {
    /// Holds the default pose.
    Zero,
    /// Standard normal actions.
    Random,
}

/// Runs an agent for `steps` control steps and returns what happened. Observations are computed too, so that all of the
/// task is exercised.
///
/// # Errors
/// A plain sentence if an observation or reward is not finite, with the step and the environment.
pub fn run_agent(
    shard: &mut dyn TaskShard,
    agent: Agent,
    steps: usize,
    seed: u64,
) -> Result<TaskMetrics, String> {
    let envs = shard.num_envs();
    let mut policy = vec![0.0; shard.policy_obs_dim() * envs];
    let mut critic = vec![0.0; shard.critic_obs_dim() * envs];
    let mut actions = vec![0.0; shard.action_dim() * envs];
    let mut reward = vec![0.0; envs];
    let (mut terminated, mut truncated) = (vec![0; envs], vec![0; envs]);
    let mut rng = Rng::new(seed, u32::MAX, 0);
    shard.take_metrics();
    for step in 0..steps {
        shard.observe(&mut policy, &mut critic);
        for (name, values) in [("policy", &policy), ("critic", &critic)] {
            if let Some(i) = values.iter().position(|x| !x.is_finite()) {
                let (row, env) = (i / envs, i % envs);
                return Err(format!(
                    "step {step}, environment {env}: {name} observation {row} is not finite"
                ));
            }
        }
        if agent == Agent::Random {
            for action in &mut actions {
                *action = rng.normal() as f32;
            }
        }
        shard.step(&actions, &mut reward, &mut terminated, &mut truncated);
        if let Some(env) = reward.iter().position(|x| !x.is_finite()) {
            return Err(format!("step {step}, environment {env}: the reward is not finite"));
        }
    }
    Ok(shard.take_metrics())
}
