//! Agents that need no training: a check of a preset before time is spent on it.

use core::ops::Range;

use paid_lanes::rng::Rng;
use paid_policy::{ObservationTerm, ObservationTerms, StepBuffers};
use serde::Serialize;

use crate::{TaskMetrics, TaskShard};

/// What the agent does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Agent {
    /// Holds the default pose.
    Zero,
    /// Standard normal actions.
    Random,
}

/// What an agent saw of an observation term, over its values, environments and steps.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TermStatistics {
    /// Name of the term.
    pub name: String,
    /// Mean.
    pub mean: f64,
    /// Standard deviation.
    pub std: f64,
    /// Smallest.
    pub min: f64,
    /// Largest.
    pub max: f64,
}

/// What happened to an agent.
#[derive(Clone, Debug, PartialEq)]
pub struct AgentReport {
    /// Rewards, episodes and kicks.
    pub metrics: TaskMetrics,
    /// The policy's observation, term by term.
    pub policy: Vec<TermStatistics>,
    /// The critic's observation, term by term.
    pub critic: Vec<TermStatistics>,
}

/// Runs an agent for `steps` control steps and returns what happened. Observations are computed too, so that all of the
/// task is exercised.
///
/// # Errors
/// A plain sentence if an observation or reward is not finite, with the step, the environment and the term.
pub fn run_agent(
    shard: &mut dyn TaskShard,
    agent: Agent,
    steps: usize,
    seed: u64,
) -> Result<TaskMetrics, String> {
    observe_agent(shard, agent, steps, seed).map(|report| report.metrics)
}

/// [`run_agent`] with statistics of the observations.
///
/// # Errors
/// As [`run_agent`].
pub fn observe_agent(
    shard: &mut dyn TaskShard,
    agent: Agent,
    steps: usize,
    seed: u64,
) -> Result<AgentReport, String> {
    let envs = shard.num_envs();
    let layout = shard.layout().clone();
    let mut policy = (vec![0.0; shard.policy_obs_dim() * envs], sums(&layout.policy));
    let mut critic = (vec![0.0; shard.critic_obs_dim() * envs], sums(&layout.critic));
    let mut actions = vec![0.0; shard.action_dim() * envs];
    let mut reward = vec![0.0; envs];
    let (mut terminated, mut truncated) = (vec![0; envs], vec![0; envs]);
    let mut rng = Rng::new(seed, u32::MAX, 0);
    shard.take_metrics();
    for step in 0..steps {
        shard.observe(&mut [&mut policy.0, &mut critic.0]);
        for (group, (values, sums)) in [("policy", &mut policy), ("critic", &mut critic)] {
            for sum in sums {
                sum.add(values, envs).map_err(|(name, env)| {
                    format!("step {step}, environment {env}: {group} observation '{name}' is not finite")
                })?;
            }
        }
        if agent == Agent::Random {
            for action in &mut actions {
                *action = rng.normal() as f32;
            }
        }
        shard.step(&actions, StepBuffers::new(&mut reward, &mut terminated, &mut truncated));
        if let Some(env) = reward.iter().position(|x| !x.is_finite()) {
            return Err(format!("step {step}, environment {env}: the reward is not finite"));
        }
    }
    let statistics = |sums: &[Sum]| sums.iter().map(Sum::statistics).collect();
    Ok(AgentReport {
        metrics: shard.take_metrics(),
        policy: statistics(&policy.1),
        critic: statistics(&critic.1),
    })
}

fn sums(terms: &ObservationTerms) -> Vec<Sum> {
    let new = |(place, term): (Range<usize>, &ObservationTerm)| Sum {
        name: term.name.clone(),
        place,
        count: 0,
        sum: 0.0,
        squares: 0.0,
        min: f64::INFINITY,
        max: f64::NEG_INFINITY,
    };
    terms.places().map(new).collect()
}

/// Running sums of one term.
struct Sum {
    name: String,
    place: Range<usize>,
    count: u64,
    sum: f64,
    squares: f64,
    min: f64,
    max: f64,
}

impl Sum {
    /// Adds the term's rows of `[features, envs]`; the error is the term's name and the environment of a value that is
    /// not finite.
    fn add(&mut self, values: &[f32], envs: usize) -> Result<(), (String, usize)> {
        let rows = self.place.start * envs..self.place.end * envs;
        for (i, &value) in values[rows].iter().enumerate() {
            if !value.is_finite() {
                return Err((self.name.clone(), i % envs));
            }
            let value = f64::from(value);
            self.count += 1;
            self.sum += value;
            self.squares += value * value;
            self.min = self.min.min(value);
            self.max = self.max.max(value);
        }
        Ok(())
    }

    fn statistics(&self) -> TermStatistics {
        let name = self.name.clone();
        if self.count == 0 {
            return TermStatistics { name, mean: 0.0, std: 0.0, min: 0.0, max: 0.0 };
        }
        let mean = self.sum / self.count as f64;
        let std = (self.squares / self.count as f64 - mean * mean).max(0.0).sqrt();
        TermStatistics { name, mean, std, min: self.min, max: self.max }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A term of `size` numbers behind `before` others.
    fn sum(before: usize, size: usize) -> Sum {
        let place = before..before + size;
        let limits = (f64::INFINITY, f64::NEG_INFINITY);
        Sum { name: "x".into(), place, count: 0, sum: 0.0, squares: 0.0, min: limits.0, max: limits.1 }
    }

    #[test]
    fn statistics_cover_the_rows_of_the_term_only() {
        // Two environments; the term is the middle two of four features.
        let values = [90.0, 91.0, 1.0, 2.0, 3.0, 6.0, -90.0, -91.0];
        let mut sum = sum(1, 2);
        sum.add(&values, 2).expect("finite");
        let s = sum.statistics();
        assert_eq!((s.mean, s.min, s.max), (3.0, 1.0, 6.0));
        assert!((s.std - 3.5_f64.sqrt()).abs() < 1e-12, "{}", s.std);
    }

    #[test]
    fn a_value_that_is_not_finite_names_term_and_environment() {
        let mut sum = sum(0, 2);
        assert_eq!(sum.add(&[1.0, 2.0, 3.0, f32::NAN], 2), Err(("x".to_owned(), 1)));
    }

    #[test]
    fn no_steps_give_zeros() {
        let s = sum(0, 1).statistics();
        assert_eq!((s.mean, s.std, s.min, s.max), (0.0, 0.0, 0.0, 0.0));
    }
}
