//! Generalized advantage estimation (Schulman et al. 2016).

/// Discount and decay.
#[derive(Clone, Copy, Debug)]
pub struct GaeConfig {
    /// Discount per step.
    pub gamma: f64,
    /// Decay of the estimate.
    pub lambda: f64,
}

/// One step of the backward recursion for one environment, in `f32`.
#[derive(Clone, Copy, Debug)]
pub struct GaeStep {
    /// Reward of the step.
    pub reward: f32,
    /// Value of the state before the step.
    pub value: f32,
    /// Value of the state after the step; ignored if the episode ended.
    pub next_value: f32,
    /// The episode ended by failure.
    pub terminated: bool,
    /// The episode was cut.
    pub truncated: bool,
}

/// The advantage of a step from that of the next.
///
/// Where an episode is cut, the environment is reset before its last state can be observed, so the value of the state
/// before the step stands in for it, as in rsl_rl: `reward += gamma V(s_t)`. A failure has no value after it, also if
/// both flags are set.
pub fn advantage(config: GaeConfig, step: GaeStep, next_advantage: f32) -> f32 {
    let (gamma, lambda) = (config.gamma as f32, config.lambda as f32);
    if step.terminated {
        step.reward - step.value
    } else if step.truncated {
        step.reward + gamma * step.value - step.value
    } else {
        let delta = step.reward + gamma * step.next_value - step.value;
        delta + gamma * lambda * next_advantage
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(ends: [(bool, bool); 3]) -> [f32; 3] {
        let config = GaeConfig { gamma: 0.5, lambda: 0.5 };
        let (rewards, values) = ([1.0, 2.0, 3.0], [10.0, 20.0, 30.0, 40.0]);
        let mut next = 0.0;
        let mut out = [0.0; 3];
        for t in (0..3).rev() {
            let step = GaeStep {
                reward: rewards[t],
                value: values[t],
                next_value: values[t + 1],
                terminated: ends[t].0,
                truncated: ends[t].1,
            };
            next = advantage(config, step, next);
            out[t] = next;
        }
        out
    }

    #[test]
    fn an_open_episode_matches_the_hand_computation() {
        // deltas: 1+10-10 = 1; 2+15-20 = -3; 3+20-30 = -7; advantages: -7; -3-7/4; 1+(-4.75)/4.
        assert_eq!(run([(false, false); 3]), [-0.1875, -4.75, -7.0]);
    }

    #[test]
    fn a_failure_ends_the_sum_without_a_value() {
        // Step 1: 2 - 20 = -18; step 0: 1 - 18/4.
        assert_eq!(run([(false, false), (true, false), (false, false)]), [-3.5, -18.0, -7.0]);
        assert_eq!(run([(false, false), (true, true), (false, false)]), [-3.5, -18.0, -7.0]);
    }

    #[test]
    fn a_cut_bootstraps_from_the_state_before_it() {
        // Step 1: 2 + 0.5*20 - 20 = -8; step 0: 1 - 8/4.
        assert_eq!(run([(false, false), (false, true), (false, false)]), [-1.0, -8.0, -7.0]);
    }
}
