//! A preset's values for networks and PPO. Unknown keys are refused.

use paid_policy::bf16::Precision;
use paid_policy::config::SizeError;
use paid_policy::{NetworkConfig, NetworkKind};
use serde::{Deserialize, Serialize};

/// The mirror symmetry loss (Yu et al. 2018): the squared distance of the policy's mean in the mirror image of a state from the mirrored
/// mean of the state, in the standard deviations of the actions.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MirrorConfig {
    /// Factor on it, against the surrogate loss; 0 is off.
    pub weight: f64,
    /// Share of the samples whose image is used in each pass, rounded to one in a whole number: 0.25 is one in 4, 0.4 one in 3, and
    /// more than two thirds are all of them. More cost time: an image costs the policy's network another pass.
    pub share: f64,
}

impl Default for MirrorConfig {
    fn default() -> Self {
        Self { weight: 0.0, share: 0.25 }
    }
}

impl MirrorConfig {
    /// One in how many units is used.
    pub(crate) fn every(&self) -> usize {
        (1.0 / self.share).round() as usize
    }
}

/// PPO (Schulman et al. 2017) with the constants of the release, except where a comment says otherwise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PpoConfig {
    /// Control steps between updates.
    pub horizon: usize,
    /// Passes over the collected samples per update. The release has 5; 2 cost the pilot nothing per sample.
    pub epochs: usize,
    /// Gradient steps per pass. The release has 4; more, smaller steps drove early progress.
    pub minibatches: usize,
    /// Discount per control step.
    pub gamma: f64,
    /// Decay of the generalized advantage estimate.
    pub lambda: f64,
    /// Clip range of the probability ratio and of the value.
    pub clip: f64,
    /// Weight of the value loss.
    pub value_loss: f64,
    /// Clip the value loss as the ratio is clipped.
    pub clip_value_loss: bool,
    /// Weight of the entropy bonus.
    pub entropy: f64,
    /// Learning rate of the first step.
    pub learning_rate: f64,
    /// Adapt the learning rate to `target_kl`.
    pub adaptive_learning_rate: bool,
    /// Wanted divergence of the new policy from the one that collected the samples.
    pub target_kl: f64,
    /// Smallest adapted learning rate.
    pub min_learning_rate: f64,
    /// Largest adapted learning rate.
    pub max_learning_rate: f64,
    /// Largest norm of the gradient of actor and critic together.
    pub max_grad_norm: f64,
    /// Standard deviation of the actions at the start. The release has 1.0, which costs a reward of 5 per step in action rate.
    pub initial_std: f64,
    /// True: a stage that starts from an earlier one's policy keeps its deviation, up to `max_std`. False: it starts with `initial_std`
    /// if the ball or the critic is new.
    pub keep_std: bool,
    /// Smallest standard deviation.
    pub min_std: f64,
    /// Largest standard deviation.
    pub max_std: f64,
    /// What the largest standard deviation has fallen to at the end of a run: exploration first, precision at last. Without it
    /// `max_std` holds throughout.
    pub final_std: Option<f64>,
    /// Share of a run after which it begins to fall, by the same factor each iteration.
    pub anneal_from: f64,
    /// Environments that go through the networks together, and the unit that minibatches are drawn in.
    pub block: usize,
    /// Environments of a sequence block, the unit of minibatches of a recurrent policy.
    pub sequence_block: usize,
    /// Parts of a minibatch whose gradients are summed apart and then in order: the same whatever the thread count. Ranks share them out;
    /// a rank with more threads than its share of them, twice, leaves threads idle.
    pub slices: usize,
    /// True: a minibatch has equally many units of every shard. Needed where shards are on several machines, so that none of them waits
    /// for another; a shuffle over all shards gives one more by chance.
    #[serde(default)]
    pub balanced: bool,
    /// Symmetry of the policy.
    pub mirror: MirrorConfig,
}

impl Default for PpoConfig {
    fn default() -> Self {
        Self {
            horizon: 24,
            epochs: 2,
            minibatches: 8,
            gamma: 0.99,
            lambda: 0.95,
            clip: 0.2,
            value_loss: 1.0,
            clip_value_loss: true,
            entropy: 0.005,
            learning_rate: 1e-3,
            adaptive_learning_rate: true,
            target_kl: 0.01,
            min_learning_rate: 1e-5,
            max_learning_rate: 1e-2,
            max_grad_norm: 1.0,
            initial_std: 0.4,
            keep_std: false,
            min_std: 0.01,
            max_std: 10.0,
            final_std: None,
            anneal_from: 0.5,
            block: 256,
            sequence_block: 64,
            slices: 8,
            balanced: false,
            mirror: MirrorConfig::default(),
        }
    }
}

impl PpoConfig {
    /// The largest standard deviation when `share` (0 to 1) of a run is over.
    pub fn std_limit(&self, share: f64) -> f64 {
        let Some(last) = self.final_std else { return self.max_std };
        let done = ((share - self.anneal_from) / (1.0 - self.anneal_from)).clamp(0.0, 1.0);
        self.max_std * (last / self.max_std).powf(done)
    }
}

/// Everything that a learner is made from, apart from the sizes of its environment.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LearnConfig {
    /// Numbers of the products of hidden layers, in rollout and update alike. Weights, sums, the last layer, losses and Adam are f32.
    pub precision: Precision,
    /// Policy network.
    pub actor: NetworkConfig,
    /// Value network.
    pub critic: NetworkConfig,
    /// Algorithm.
    pub ppo: PpoConfig,
}

/// A value that no run can use.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{key}: expected {expected}, found {found}")]
pub struct ConfigError {
    /// The key within the learner's section.
    pub key: String,
    /// What it may be.
    pub expected: &'static str,
    /// What it is.
    pub found: String,
}

impl LearnConfig {
    /// Checks every value.
    ///
    /// # Errors
    /// The first value out of range.
    pub fn check(&self) -> Result<(), ConfigError> {
        let p = &self.ppo;
        let positive = |x: f64| x.is_finite() && x > 0.0;
        let mut rules: Vec<(&str, bool, &'static str, String)> = Vec::new();
        for (key, value) in [
            ("ppo.horizon", p.horizon),
            ("ppo.epochs", p.epochs),
            ("ppo.minibatches", p.minibatches),
            ("ppo.block", p.block),
            ("ppo.sequence_block", p.sequence_block),
            ("ppo.slices", p.slices),
        ] {
            rules.push((key, value > 0, "at least 1", value.to_string()));
        }
        for (key, value) in [("ppo.gamma", p.gamma), ("ppo.lambda", p.lambda)] {
            rules.push((key, (0.0..=1.0).contains(&value), "0 to 1", value.to_string()));
        }
        for (key, value) in [
            ("ppo.clip", p.clip),
            ("ppo.learning_rate", p.learning_rate),
            ("ppo.target_kl", p.target_kl),
            ("ppo.min_learning_rate", p.min_learning_rate),
            ("ppo.max_grad_norm", p.max_grad_norm),
            ("ppo.min_std", p.min_std),
        ] {
            rules.push((key, positive(value), "a positive number", value.to_string()));
        }
        for (key, value) in [
            ("ppo.value_loss", p.value_loss),
            ("ppo.entropy", p.entropy),
            ("ppo.mirror.weight", p.mirror.weight),
        ] {
            rules.push((key, value.is_finite() && value >= 0.0, "0 or more", value.to_string()));
        }
        let share = p.mirror.share > 0.0 && p.mirror.share <= 1.0;
        rules.push(("ppo.mirror.share", share, "more than 0 and at most 1", p.mirror.share.to_string()));
        let memory = p.mirror.weight == 0.0 || self.actor.kind == NetworkKind::Mlp;
        rules.push(("ppo.mirror.weight", memory, "0 for a recurrent policy", p.mirror.weight.to_string()));
        let rates = p.max_learning_rate.is_finite() && p.max_learning_rate >= p.min_learning_rate;
        rules.push((
            "ppo.max_learning_rate",
            rates,
            "at least ppo.min_learning_rate",
            p.max_learning_rate.to_string(),
        ));
        let stds = p.max_std.is_finite() && p.max_std >= p.min_std;
        rules.push(("ppo.max_std", stds, "at least ppo.min_std", p.max_std.to_string()));
        let last = p.final_std.unwrap_or(p.max_std);
        let ends = (p.min_std..=p.max_std).contains(&last);
        rules.push(("ppo.final_std", ends, "between ppo.min_std and ppo.max_std", last.to_string()));
        let from = (0.0..1.0).contains(&p.anneal_from);
        rules.push(("ppo.anneal_from", from, "0 or more and less than 1", p.anneal_from.to_string()));
        let std = (p.min_std..=p.max_std).contains(&p.initial_std);
        rules.push((
            "ppo.initial_std",
            std,
            "between ppo.min_std and ppo.max_std",
            p.initial_std.to_string(),
        ));
        for (key, good, expected, found) in rules {
            if !good {
                return Err(ConfigError { key: key.to_owned(), expected, found });
            }
        }
        for (name, net) in [("actor", &self.actor), ("critic", &self.critic)] {
            net.check().map_err(|error| of_network(name, &error))?;
        }
        Ok(())
    }

    /// Checks the networks for observations of `policy` and `critic` features.
    ///
    /// # Errors
    /// The first value that does not fit.
    pub fn check_for(&self, policy: usize, critic: usize) -> Result<(), ConfigError> {
        self.actor.check_for(policy).map_err(|error| of_network("actor", &error))?;
        self.critic.check_for(critic).map_err(|error| of_network("critic", &error))
    }
}

fn of_network(name: &str, error: &SizeError) -> ConfigError {
    let SizeError { key, expected, found } = error.clone();
    ConfigError { key: format!("{name}.{key}"), expected, found }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_limit_of_the_noise_falls_by_one_factor_after_its_share() {
        let mut ppo = PpoConfig { max_std: 0.4, ..PpoConfig::default() };
        assert_eq!([0.0, 1.0].map(|share| ppo.std_limit(share)), [0.4, 0.4], "without an end");
        (ppo.final_std, ppo.anneal_from) = (Some(0.1), 0.5);
        for (share, limit) in [(0.0, 0.4), (0.5, 0.4), (0.75, 0.2), (1.0, 0.1), (1.5, 0.1)] {
            assert!((ppo.std_limit(share) - limit).abs() < 1e-12, "{share}: {}", ppo.std_limit(share));
        }
    }

    #[test]
    fn an_end_of_the_noise_outside_its_bounds_is_refused() {
        let refused = |change: fn(&mut PpoConfig)| {
            let mut config = LearnConfig::default();
            change(&mut config.ppo);
            config.check().expect_err("a fault").to_string()
        };
        let text = refused(|ppo| ppo.final_std = Some(20.0));
        assert_eq!(text, "ppo.final_std: expected between ppo.min_std and ppo.max_std, found 20");
        let text = refused(|ppo| ppo.anneal_from = 1.0);
        assert_eq!(text, "ppo.anneal_from: expected 0 or more and less than 1, found 1");
    }

    #[test]
    fn networks_of_sizes_that_no_checkpoint_may_have_are_refused() {
        let refused = |change: fn(&mut LearnConfig)| {
            let mut config = LearnConfig::default();
            change(&mut config);
            config.check().expect_err("a fault").to_string()
        };
        let text = refused(|config| config.actor.hidden = vec![8, 0]);
        assert_eq!(text, "actor.hidden: expected widths of 1 to 65536, found [8, 0]");
        let text = refused(|config| {
            config.critic.kind = NetworkKind::Lstm;
            config.critic.lstm.layers = 0;
        });
        assert_eq!(text, "critic.lstm: expected 1 to 64 layers of 1 to 65536 cells, found 0 x 128");
    }

    #[test]
    fn the_share_of_images_is_one_in_a_whole_number() {
        let every = |share| MirrorConfig { weight: 1.0, share }.every();
        assert_eq!([1.0, 0.7, 0.5, 0.4, 0.3, 0.25].map(every), [1, 1, 2, 3, 3, 4]);
    }
}
