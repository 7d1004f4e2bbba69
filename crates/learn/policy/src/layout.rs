//! What the numbers of an observation mean: part of the contract of a policy file.

use core::ops::Range;

use paid_robot::RobotSpec;

use crate::contract::ObservationTerm;
use crate::observation::{ObservationError, ObservationId};

/// The robot's sizes that the size of a term depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dimensions {
    /// Joints of the policy.
    pub joints: usize,
    /// Tracked bodies.
    pub bodies: usize,
}

impl Dimensions {
    /// A robot's sizes.
    pub fn of(spec: &RobotSpec) -> Self {
        Self { joints: spec.policy_joint_order.len(), bodies: spec.tracked_bodies.len() }
    }
}

/// The terms of one observation, in order.
#[derive(Clone, Debug, PartialEq)]
pub struct ObservationTerms(Vec<ObservationTerm>);

impl ObservationTerms {
    /// The terms of a list for a robot's sizes. Joint vectors are in the policy's joint order; `base` is body 0, `anchor` the
    /// robot's anchor body.
    pub fn new(list: &[ObservationId], dimensions: Dimensions) -> Self {
        let term = |id: &ObservationId| {
            let info = id.info();
            ObservationTerm {
                name: info.name.into(),
                size: info.shape.size(dimensions),
                order: info.shape.order().into(),
                frame: info.frame.into(),
                unit: info.unit.into(),
                scale: 1.0,
            }
        };
        Self(list.iter().map(term).collect())
    }

    /// The terms.
    pub fn terms(&self) -> &[ObservationTerm] {
        &self.0
    }

    /// Length of the observation.
    pub fn dim(&self) -> usize {
        self.0.iter().map(|t| t.size).sum()
    }

    /// Every term with its place in the observation.
    pub fn places(&self) -> impl Iterator<Item = (Range<usize>, &ObservationTerm)> {
        self.0.iter().scan(0, |next, term| {
            let first = *next;
            *next += term.size;
            Some((first..*next, term))
        })
    }

    /// Where a term's numbers are.
    pub fn place(&self, name: &str) -> Option<Range<usize>> {
        self.places().find(|(_, term)| term.name == name).map(|(place, _)| place)
    }
}

/// What the policy and the critic observe.
#[derive(Clone, Debug, PartialEq)]
pub struct ObservationLayout {
    /// The policy's terms.
    pub policy: ObservationTerms,
    /// The critic's terms.
    pub critic: ObservationTerms,
}

impl ObservationLayout {
    /// The layout of two lists of terms for a robot.
    ///
    /// # Errors
    /// If a list is empty or has a term twice.
    pub fn new(
        policy: &[ObservationId],
        critic: &[ObservationId],
        dimensions: Dimensions,
    ) -> Result<Self, ObservationError> {
        for list in [policy, critic] {
            crate::observation::check_list(list)?;
        }
        Ok(Self {
            policy: ObservationTerms::new(policy, dimensions),
            critic: ObservationTerms::new(critic, dimensions),
        })
    }

    /// Length of the policy's observation.
    pub fn policy_dim(&self) -> usize {
        self.policy.dim()
    }

    /// Length of the critic's observation.
    pub fn critic_dim(&self) -> usize {
        self.critic.dim()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terms_lie_one_after_another() {
        let list = [ObservationId::GoalPos, ObservationId::JointVel, ObservationId::BodyOri];
        let terms = ObservationTerms::new(&list, Dimensions { joints: 29, bodies: 14 });
        assert_eq!(terms.dim(), 3 + 29 + 84);
        assert_eq!(terms.place("joint_vel"), Some(3..32));
        assert_eq!(terms.place("body_ori"), Some(32..116));
        assert_eq!(terms.place("ball_pos"), None);
        assert_eq!(
            (
                terms.terms()[0].order.as_str(),
                terms.terms()[0].frame.as_str(),
                terms.terms()[0].unit.as_str()
            ),
            ("x,y,z", "base", "m")
        );
    }

    #[test]
    fn a_term_twice_or_none_at_all_is_refused() {
        let dimensions = Dimensions { joints: 2, bodies: 1 };
        let one = [ObservationId::GoalPos];
        let twice = [ObservationId::GoalPos, ObservationId::GoalPos];
        let error = ObservationLayout::new(&twice, &one, dimensions).expect_err("twice").to_string();
        assert!(error.contains("goal_pos"), "{error}");
        assert_eq!(ObservationLayout::new(&one, &[], dimensions), Err(ObservationError::Empty));
    }
}
