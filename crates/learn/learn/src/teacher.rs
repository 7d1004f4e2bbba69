//! A trained policy that another one imitates on its own rollouts (DAgger, Ross et al. 2011; with a reward beside it kickstarting, Schmitt
//! et al. 2018).

use std::sync::Arc;

use paid_policy::matrix::{Mat, MatMut};
use paid_policy::net::StepWorkspace;
use paid_policy::{ObservationGroup, Policy};

use crate::config::ConfigError;

/// A policy without memory whose actions are imitated, and how much that counts.
///
/// The environments show it the further observation group [`paid_policy::env::TEACHER_GROUP`], so it may be given other things than its
/// student. The loss of a sample is half the squared distance of the student's mean action from the teacher's, in standard deviations of
/// the student's actions, summed over the actions.
#[derive(Clone, Debug)]
pub struct Teacher {
    policy: Arc<Policy>,
    weight: f64,
    until: f64,
}

impl Teacher {
    /// A teacher whose loss counts `weight` times, against the surrogate loss, at the start of a run, and falls linearly to nothing
    /// when the share `until` (0 to 1) of the run is over.
    ///
    /// # Errors
    /// If a value is out of range, or the policy has a memory.
    pub fn new(policy: Arc<Policy>, weight: f64, until: f64) -> Result<Self, ConfigError> {
        Self::check(weight, until)?;
        if policy.net.is_recurrent() {
            let (key, found) = ("teacher.policy".to_owned(), "a recurrent one".to_owned());
            return Err(ConfigError { key, expected: "one without memory", found });
        }
        Ok(Self { policy, weight, until })
    }

    /// Checks the values of a teacher whose policy has not been read yet.
    ///
    /// # Errors
    /// If one is out of range.
    pub fn check(weight: f64, until: f64) -> Result<(), ConfigError> {
        let fail = |key: &str, expected, found| Err(ConfigError { key: key.to_owned(), expected, found });
        if !(weight.is_finite() && weight > 0.0) {
            return fail("teacher.weight", "a positive number", weight.to_string());
        }
        if !(until > 0.0 && until <= 1.0) {
            return fail("teacher.until", "more than 0 and at most 1", until.to_string());
        }
        Ok(())
    }

    /// Weight of the loss when `share` of a run is over.
    pub(crate) fn weight(&self, share: f64) -> f64 {
        self.weight * (1.0 - share / self.until).max(0.0)
    }

    /// Where the environments show what it sees.
    pub(crate) fn group(&self, further: &[ObservationGroup]) -> Option<usize> {
        let wanted = ObservationGroup::new(paid_policy::env::TEACHER_GROUP, self.policy.obs_dim());
        further.iter().position(|group| *group == wanted)
    }

    /// What [`Teacher::group`] looks for, in words.
    pub(crate) fn wanted(&self) -> String {
        let (name, size) = (paid_policy::env::TEACHER_GROUP, self.policy.obs_dim());
        format!("a further group {name} [{size}]")
    }

    /// Actions that it takes.
    pub(crate) fn actions(&self) -> usize {
        self.policy.action_dim()
    }

    /// Its mean actions `[actions, n]` for raw observations `[features, n]`.
    pub(crate) fn act(
        &self,
        raw: Mat<'_, f32>,
        actions: MatMut<'_, f32>,
        room: &mut Vec<f32>,
        work: &mut StepWorkspace<f32>,
    ) {
        let (rows, n) = (raw.rows(), raw.cols());
        room.resize(rows * n, 0.0);
        self.policy.normalizer.apply(raw, MatMut::new(room, rows, n, n), None);
        let mut state = self.policy.net.initial_state(n);
        self.policy.net.step(&self.policy.params, Mat::new(room, rows, n, n), &mut state, actions, work);
    }
}

/// Squared distance of `mean` `[actions, n]` from `wanted`, each action's times its `inv_variance`, summed over actions and samples. Adds
/// the gradient of half of it, times `scale`, to `dmean`.
pub(crate) fn squared_distance(
    scale: f32,
    inv_variance: impl IntoIterator<Item = f32>,
    mean: Mat<'_, f32>,
    wanted: Mat<'_, f32>,
    dmean: &mut MatMut<'_, f32>,
) -> f64 {
    let mut total = 0.0;
    for (a, inv_variance) in inv_variance.into_iter().enumerate() {
        let factor = scale * inv_variance;
        let mut squares = 0.0f32;
        for ((d, m), w) in dmean.row(a).iter_mut().zip(mean.row(a)).zip(wanted.row(a)) {
            let apart = m - w;
            squares += apart * apart;
            *d += factor * apart;
        }
        total += f64::from(squares * inv_variance);
    }
    total
}

/// Adds the gradient of the imitation loss of a chunk of samples to `dmean` `[actions, n]`; returns the loss, summed over the samples.
/// `scale` is the weight of a sample's loss, `log_std` that of the student's actions.
pub(crate) fn imitation_loss(
    scale: f64,
    log_std: &[f32],
    mean: Mat<'_, f32>,
    wanted: Mat<'_, f32>,
    dmean: &mut MatMut<'_, f32>,
) -> f64 {
    let inv_variance = log_std.iter().map(|log_std| (-2.0 * log_std).exp());
    0.5 * squared_distance(scale as f32, inv_variance, mean, wanted, dmean)
}

#[cfg(test)]
mod tests {
    use paid_lanes::rng::Rng;
    use paid_policy::net::Network;
    use paid_policy::normalizer::Normalizer;
    use paid_policy::{LstmConfig, NetworkConfig, NetworkKind};

    use super::*;

    fn policy(kind: NetworkKind) -> Arc<Policy> {
        let config = NetworkConfig {
            kind,
            hidden: vec![4],
            lstm: LstmConfig { layers: 1, size: 2, inputs: 0 },
            ..NetworkConfig::default()
        };
        let net = Network::new(3, 2, &config);
        let params = net.initialize(&mut Rng::new(1, 0, 0));
        Arc::new(Policy { net, params, normalizer: Normalizer::new(3), std: vec![0.1; 2] })
    }

    #[test]
    fn the_weight_falls_to_nothing_within_its_share() {
        let teacher = Teacher::new(policy(NetworkKind::Mlp), 2.0, 0.5).expect("good");
        let weights = [0.0, 0.125, 0.25, 0.5, 0.9].map(|share| teacher.weight(share));
        assert_eq!(weights, [2.0, 1.5, 1.0, 0.0, 0.0]);
    }

    #[test]
    fn values_out_of_range_and_teachers_with_memory_are_refused() {
        let refused =
            |kind, weight, until| Teacher::new(policy(kind), weight, until).expect_err("refused").to_string();
        let text = refused(NetworkKind::Mlp, -1.0, 0.5);
        assert_eq!(text, "teacher.weight: expected a positive number, found -1");
        let text = refused(NetworkKind::Mlp, 1.0, 1.5);
        assert_eq!(text, "teacher.until: expected more than 0 and at most 1, found 1.5");
        let text = refused(NetworkKind::Lstm, 1.0, 0.5);
        assert_eq!(text, "teacher.policy: expected one without memory, found a recurrent one");
    }

    #[test]
    fn the_loss_is_half_the_squared_distance_in_standard_deviations() {
        // Two actions with deviations of 0.5 and 1, two samples; the weight of a sample is 0.25.
        let log_std = [0.5f32.ln(), 0.0];
        let (mean, wanted) = ([1.0, 2.0, 3.0, 0.0], [0.5, 2.0, 1.0, 0.0]);
        let mut gradient = [10.0, 0.0, 0.0, 0.0];
        let loss = imitation_loss(
            0.25,
            &log_std,
            Mat::new(&mean, 2, 2, 2),
            Mat::new(&wanted, 2, 2, 2),
            &mut MatMut::new(&mut gradient, 2, 2, 2),
        );
        // (0.5 / 0.5)^2 / 2 + (2 / 1)^2 / 2; gradients 0.25 * 0.5 / 0.25 and 0.25 * 2.
        assert!((loss - 2.5).abs() < 1e-6, "{loss}");
        for (found, expected) in gradient.iter().zip([10.5, 0.0, 0.5, 0.0]) {
            assert!((found - expected).abs() < 1e-6, "{gradient:?}");
        }
    }

    #[test]
    fn it_acts_as_its_policy_does() {
        let policy = policy(NetworkKind::Mlp);
        let teacher = Teacher::new(Arc::clone(&policy), 1.0, 1.0).expect("good");
        let seen = [0.1, -0.2, 0.3, 0.4, 0.5, -0.6];
        let (mut expected, mut found) = ([0.0; 4], [0.0; 4]);
        policy.act(&seen, &mut policy.start(2), &mut expected);
        let out = MatMut::new(&mut found, 2, 2, 2);
        teacher.act(Mat::new(&seen, 3, 2, 2), out, &mut Vec::new(), &mut StepWorkspace::default());
        assert_eq!(found, expected);
        let group = |size| [ObservationGroup::new("style", 3), ObservationGroup::new("teacher", size)];
        assert_eq!((teacher.group(&group(3)), teacher.group(&group(4))), (Some(1), None));
    }
}
