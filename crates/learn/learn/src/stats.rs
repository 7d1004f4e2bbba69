//! What an iteration saw, learned and took.

/// What a collection saw and took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CollectStats {
    /// Samples (control steps times environments).
    pub samples: usize,
    /// Mean of the task's reward per control step.
    pub mean_reward: f64,
    /// Mean of the learned reward per control step, before any weight.
    pub mean_learned_reward: f64,
    /// Episodes that failed.
    pub terminated: u64,
    /// Episodes that were cut.
    pub truncated: u64,
    /// Observations and rewards that were not finite (replaced by zero).
    pub non_finite: u64,
    /// Wall clock `[s]`.
    pub wall_s: f64,
    /// Time in environments `[s]`, summed over threads.
    pub env_s: f64,
    /// Time in normalization `[s]`, summed over threads.
    pub normalize_s: f64,
    /// Time in networks and sampling `[s]`, summed over threads.
    pub forward_s: f64,
}

/// One iteration: a horizon and an update.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct IterationStats {
    /// Number of the iteration, from 1.
    pub iteration: u64,
    /// Collection.
    pub collect: CollectStats,
    /// Update.
    pub update: UpdateStats,
    /// Wall clock of the update `[s]`.
    pub learn_s: f64,
    /// Learning rate after it.
    pub learning_rate: f64,
    /// Mean standard deviation of the actions after it.
    pub mean_std: f64,
    /// Entropy of the policy after it `[nat]`.
    pub entropy: f64,
}

/// Means over the gradient steps of an update.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct UpdateStats {
    /// Clipped surrogate loss.
    pub surrogate_loss: f64,
    /// Value loss of the task's critic, before its weight.
    pub value_loss: f64,
    /// Value loss of the learned reward's critic, before its weight; 0 if there is none.
    pub learned_value_loss: f64,
    /// Mirror symmetry loss, before its weight; 0 where it is off.
    pub mirror_loss: f64,
    /// Imitation loss ([`crate::Teacher`]), before its weight; 0 without a teacher.
    pub teacher_loss: f64,
    /// Divergence from the policy that collected.
    pub kl: f64,
    /// Share of samples outside the clip range.
    pub clip_fraction: f64,
    /// Norm of the gradient before clipping.
    pub grad_norm: f64,
    /// Gradient steps taken.
    pub steps: u64,
    /// Gradient steps left out because the gradient was not finite.
    pub skipped: u64,
}

impl UpdateStats {
    /// What every rank has a share of: losses, divergence, share of clipped samples.
    pub(crate) fn sums_mut(&mut self) -> [&mut f64; 7] {
        let Self {
            surrogate_loss,
            value_loss,
            learned_value_loss,
            mirror_loss,
            teacher_loss,
            kl,
            clip_fraction,
            ..
        } = self;
        [surrogate_loss, value_loss, learned_value_loss, mirror_loss, teacher_loss, kl, clip_fraction]
    }
}
