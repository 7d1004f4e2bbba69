//! What policy and critic observe, with which noise.

use paid_policy::observation::{self, Need, ObservationId, ObservationNoise};
use paid_policy::{Dimensions, ObservationLayout};
use paid_robot::RobotSpec;
use serde::{Deserialize, Serialize};

use crate::TaskError;
use crate::preset::numbers::check;
use crate::preset::{ReferenceSource, value_error};

/// What is observed, and the noise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObservationPreset {
    /// Terms of the policy's observation, in order. With `ball_at_strike` among them the policy sees a rolling ball where it will be
    /// when the reference strikes, and motions are chosen by that place too; the paper's policy sees `ball_pos` and is recurrent.
    pub policy: Vec<ObservationId>,
    /// Terms of the critic's observation, in order.
    pub critic: Vec<ObservationId>,
    /// Terms of a frame that a discriminator compares with the clips' frames, in order; empty without one. What clips have: the robot's
    /// own state, without noise.
    #[serde(default)]
    pub style: Vec<ObservationId>,
    /// Terms that a teacher sees, in order, without noise; empty without one. They are the teacher's own: no preset names them.
    #[serde(skip)]
    pub teacher: Vec<ObservationId>,
    /// Half-widths of uniform noise on the policy's terms, by name; terms that are left out have none.
    pub noise: ObservationNoise,
}

impl ObservationPreset {
    /// True if policy, critic or teacher is shown the ball where it will be.
    pub(crate) fn predicts(&self) -> bool {
        self.policy
            .iter()
            .chain(&self.critic)
            .chain(&self.teacher)
            .any(|id| *id == ObservationId::BallAtStrike)
    }

    /// What the numbers of both observations mean for a robot.
    ///
    /// # Errors
    /// If a list is empty or has a term twice.
    pub fn layout(&self, spec: &RobotSpec) -> Result<ObservationLayout, TaskError> {
        self.check(ReferenceSource::Motions)?;
        let dimensions = Dimensions::of(spec);
        ObservationLayout::new(&self.policy, &self.critic, dimensions)
            .map_err(|error| TaskError::Observations { list: "policy, critic", error })
    }

    /// The policy must not need what only a simulator knows, and neither network a reference if there is none.
    pub(crate) fn check(&self, reference: ReferenceSource) -> Result<(), TaskError> {
        let critic: &[Need] = match reference {
            ReferenceSource::Motions => &[Need::Scene, Need::Privileged, Need::Reference],
            ReferenceSource::None => &[Need::Scene, Need::Privileged],
        };
        let policy: Vec<Need> = critic.iter().copied().filter(|need| *need != Need::Privileged).collect();
        for (list, ids, available) in
            [("policy", &self.policy, &policy[..]), ("critic", &self.critic, critic)]
        {
            observation::check(ids, available).map_err(|error| TaskError::Observations { list, error })?;
        }
        if !self.style.is_empty() {
            observation::check(&self.style, &[Need::Privileged])
                .map_err(|error| TaskError::Observations { list: "style", error })?;
            if self.style.contains(&ObservationId::LastAction) {
                let (expected, found) =
                    ("terms that clips have, which have no actions", "last_action".into());
                return Err(value_error("observations.style", expected, found));
            }
        }
        if !self.teacher.is_empty() {
            observation::check(&self.teacher, critic)
                .map_err(|error| TaskError::Observations { list: "teacher", error })?;
        }
        for id in ObservationId::all() {
            let limits = ([0.0, 1000.0], "0 to 1000");
            check("observations.noise", &[(id.name(), self.noise.half_width(id).into(), limits)])?;
        }
        Ok(())
    }
}

/// A term of the policy's observation.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PolicyTerm {
    pub id: ObservationId,
    /// True if it is delayed where the preset has a delay of observations.
    pub sensed: bool,
    /// Half-width of its noise; 0 draws no random numbers.
    pub half_width: f64,
}

/// The preset's lists of terms, and what follows from them.
#[derive(Clone, Debug)]
pub(crate) struct ObservationConfig {
    pub policy: Vec<PolicyTerm>,
    pub critic: Vec<ObservationId>,
    pub style: Vec<ObservationId>,
    /// Numbers of a frame that a discriminator sees; 0 without one.
    pub style_dim: usize,
    pub teacher: Vec<ObservationId>,
    /// Numbers that a teacher sees; 0 without one.
    pub teacher_dim: usize,
    /// Random numbers of one observation.
    pub noisy: usize,
    /// Numbers of the policy's sensed terms.
    pub sensed: usize,
    /// True if a list has the ball where it will be.
    pub predicts: bool,
}

impl ObservationConfig {
    pub(crate) fn new(preset: &ObservationPreset, dimensions: Dimensions) -> Self {
        let term = |&id: &ObservationId| PolicyTerm {
            id,
            sensed: id.info().sensed,
            half_width: preset.noise.half_width(id),
        };
        let policy: Vec<PolicyTerm> = preset.policy.iter().map(term).collect();
        let count = |counts: fn(&PolicyTerm) -> bool| {
            policy.iter().filter(|term| counts(term)).map(|term| term.id.info().shape.size(dimensions)).sum()
        };
        let size = |list: &[ObservationId]| list.iter().map(|id| id.info().shape.size(dimensions)).sum();
        Self {
            critic: preset.critic.clone(),
            style_dim: size(&preset.style),
            style: preset.style.clone(),
            teacher_dim: size(&preset.teacher),
            teacher: preset.teacher.clone(),
            noisy: count(|term| term.half_width > 0.0),
            sensed: count(|term| term.sensed),
            predicts: preset.predicts(),
            policy,
        }
    }
}
