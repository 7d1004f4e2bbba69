//! Observation terms: one item per file, all of them in the list below.
//!
//! To add a built-in term, write its file, add it to the list, and name it in a preset. Another crate adds its own with
//! [`ObservationSet`].

mod list;
mod noise;
mod own;
mod sink;
mod term;

#[cfg(test)]
mod fixture;

mod anchor_ori_error;
mod anchor_pos_error;
mod ball_at_strike;
mod ball_pos;
mod base_ang_vel;
mod base_lin_vel;
mod body_ori;
mod body_pos;
mod goal_pos;
mod joint_pos_rel;
mod joint_vel;
mod last_action;
mod projected_gravity;
mod reference_anchor_ang_vel;
mod reference_joint_pos;
mod reference_joint_vel;

use std::sync::OnceLock;

use paid_lanes::Real;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use thiserror::Error;

pub use noise::ObservationNoise;
pub use own::{ObservationSet, OwnObservation, TermSetError, no_such_term};
pub use sink::Sink;
pub use term::{Need, Noise, Observation, ObservationInfo, Shape};

use crate::Views;

list::observations! {
    reference_joint_pos: ReferenceJointPos,
    reference_joint_vel: ReferenceJointVel,
    projected_gravity: ProjectedGravity,
    reference_anchor_ang_vel: ReferenceAnchorAngVel,
    base_ang_vel: BaseAngVel,
    joint_pos_rel: JointPosRel,
    joint_vel: JointVel,
    last_action: LastAction,
    ball_pos: BallPos,
    ball_at_strike: BallAtStrike,
    goal_pos: GoalPos,
    anchor_pos_error: AnchorPosError,
    anchor_ori_error: AnchorOriError,
    body_pos: BodyPos,
    body_ori: BodyOri,
    base_lin_vel: BaseLinVel,
}

impl ObservationId {
    /// Every term: the built-in ones, then those that other crates have installed.
    pub fn all() -> impl Iterator<Item = Self> {
        Self::BUILTIN.into_iter().chain(own::installed().map(Self::Own))
    }

    /// The names of [`ObservationId::all`].
    pub fn names() -> &'static [&'static str] {
        static NAMES: OnceLock<Vec<&str>> = OnceLock::new();
        NAMES.get_or_init(|| Self::all().map(|id| id.name()).collect())
    }

    /// The term of a name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::all().find(|id| id.name() == name)
    }
}

impl Serialize for ObservationId {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

impl<'de> Deserialize<'de> for ObservationId {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        Self::from_name(&name)
            .ok_or_else(|| D::Error::custom(no_such_term("observation", &name, Self::names())))
    }
}

/// Writes the terms of a list one after another.
///
/// # Panics
/// If the views lack what a term needs, see [`check`].
#[inline(always)]
pub fn observe<V: Real>(list: &[ObservationId], views: &Views<'_, V>, out: &mut impl Sink<V>) {
    for id in list {
        id.write(views, out);
    }
}

/// A list of terms that cannot be observed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum ObservationError {
    /// There is no term.
    #[error("an observation has no terms")]
    Empty,
    /// A term occurs twice.
    #[error("observation term '{0}' occurs twice")]
    Twice(&'static str),
    /// A term needs what is not there.
    #[error("observation term '{term}' needs {need}, which is missing")]
    Missing {
        /// The term.
        term: &'static str,
        /// What it needs.
        need: Need,
    },
}

/// Checks that a list can be observed: it has terms, none of them twice, and none that needs more than `available`.
///
/// # Errors
/// The first term that cannot.
pub fn check(list: &[ObservationId], available: &[Need]) -> Result<(), ObservationError> {
    check_list(list)?;
    for id in list {
        let info = id.info();
        if let Some(&need) = info.needs.iter().find(|need| !available.contains(need)) {
            return Err(ObservationError::Missing { term: info.name, need });
        }
    }
    Ok(())
}

pub(crate) fn check_list(list: &[ObservationId]) -> Result<(), ObservationError> {
    if list.is_empty() {
        return Err(ObservationError::Empty);
    }
    match list.iter().enumerate().find(|(i, id)| list[..*i].contains(id)) {
        Some((_, id)) => Err(ObservationError::Twice(id.name())),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Dimensions;

    #[test]
    fn every_term_writes_as_many_numbers_as_it_says() {
        let fixture = fixture::Fixture::new();
        for id in ObservationId::BUILTIN {
            let mut out = Vec::new();
            id.write(&fixture.views(), &mut out);
            let info = id.info();
            assert_eq!(out.len(), info.shape.size(Dimensions { joints: 2, bodies: 2 }), "{}", info.name);
            assert!(out.iter().all(|x: &f64| x.is_finite()), "{}", info.name);
        }
    }

    #[test]
    fn what_a_robot_senses_needs_nothing_else() {
        let fixture = fixture::Fixture::new();
        let robot = Views::of_robot(fixture.views().robot);
        let sensed: Vec<_> = ObservationId::BUILTIN.into_iter().filter(|id| id.info().sensed).collect();
        assert_eq!(
            sensed.iter().map(ObservationId::name).collect::<Vec<_>>(),
            ["projected_gravity", "base_ang_vel", "joint_pos_rel", "joint_vel"]
        );
        check(&sensed, &[]).expect("sensors are enough");
        observe(&sensed, &robot, &mut Vec::new());
    }

    #[test]
    fn a_list_names_the_term_that_cannot_be_observed() {
        let error = |list: &[ObservationId], available: &[Need]| {
            check(list, available).expect_err("cannot be observed").to_string()
        };
        let list = [ObservationId::JointVel, ObservationId::ReferenceJointPos];
        assert_eq!(
            error(&list, &[Need::Scene]),
            "observation term 'reference_joint_pos' needs a reference motion, which is missing"
        );
        assert_eq!(check(&list, &[Need::Reference]), Ok(()));
        assert_eq!(error(&[], &[]), "an observation has no terms");
        let twice = [ObservationId::JointVel; 2];
        assert_eq!(error(&twice, &[]), "observation term 'joint_vel' occurs twice");
    }

    #[test]
    fn presets_name_terms_as_their_files_are_called() {
        for id in ObservationId::BUILTIN {
            let text = serde_json::to_string(&id).expect("a name");
            assert_eq!(text, format!("\"{}\"", id.name()));
            assert_eq!(ObservationId::from_name(id.name()), Some(id));
        }
        let noise: ObservationNoise = serde_json::from_str(r#"{"joint_vel": 0.5}"#).expect("noise");
        assert_eq!(noise.half_width(ObservationId::JointVel), 0.5);
        assert_eq!(noise.half_width(ObservationId::JointPosRel), 0.0);
        assert!(serde_json::from_str::<ObservationNoise>(r#"{"speed": 0.5}"#).is_err());
    }

    #[test]
    fn the_standard_noise_is_on_what_is_sensed_and_on_the_references_turning() {
        let noise = ObservationNoise::standard();
        let noisy: Vec<_> = ObservationId::BUILTIN
            .into_iter()
            .filter(|id| noise.half_width(*id) > 0.0)
            .map(|id| (id.name(), noise.half_width(id)))
            .collect();
        let expected = [
            ("projected_gravity", 0.05),
            ("reference_anchor_ang_vel", 0.05),
            ("base_ang_vel", 0.2),
            ("joint_pos_rel", 0.01),
            ("joint_vel", 0.5),
        ];
        assert_eq!(noisy, expected);
        assert!(ObservationId::BUILTIN.iter().all(|id| {
            let noise = id.info().noise;
            noise.half_width == 0.0 || !noise.reason.is_empty()
        }));
    }
}
