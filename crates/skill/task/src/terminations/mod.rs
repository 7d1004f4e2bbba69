//! What ends an episode as a failure: one term a file.
//!
//! A term is a struct of typed parameters and an inlined check over lanes. The list below makes from the terms the preset
//! (`terminations.<name> = { limit_m = 0.25 }`), the causes of an episode's end, their names and the table of terms. A term that
//! a preset leaves out is off.

mod anchor_distance;
mod anchor_height;
mod end_effector;
mod fallen;
mod gravity;

use paid_lanes::{Mask, Real};
use paid_physics::{BodyState, GroupState};
use serde::{Deserialize, Serialize};

use crate::TaskError;
use crate::config::TaskConfig;
use crate::parameters::{Parameters, Requirement};
use crate::reference::Reference;
use crate::terms_table::TermInfo;

/// What a termination term reads after a control step.
pub(crate) struct TerminationInput<'a, V> {
    /// Indices of the robot.
    pub config: &'a TaskConfig,
    /// The robot.
    pub state: &'a GroupState<V>,
    /// The frame that the state is scored against.
    pub reference: &'a Reference<V>,
}

impl<'a, V> TerminationInput<'a, V> {
    /// The robot's anchor body.
    #[inline(always)]
    pub(crate) fn anchor(&self) -> &'a BodyState<V> {
        &self.state.bodies[self.config.followed[self.config.anchor]]
    }
}

/// A termination term: its limits, and which lanes are beyond them.
pub(crate) trait TerminationTerm: Parameters {
    /// SI unit of what the term measures; empty for pure numbers.
    const UNIT: &'static str;
    /// Frame in which it measures.
    const FRAME: &'static str;
    /// What it needs.
    const NEEDS: &'static [Requirement];

    /// True if the term can end an episode.
    fn is_on(&self) -> bool;

    /// The lanes beyond the limits. Called only while the term is on.
    fn fails<V: Real>(&self, input: &TerminationInput<'_, V>) -> V::Mask;
}

/// Makes the preset, the causes of an end and everything that runs over the terms, in the order of the list.
macro_rules! termination_terms {
    ($($name:ident: $Term:ident),+ $(,)?) => {
        $(pub use $name::$Term;)+

        /// All termination terms. One that a preset leaves out is off.
        #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
        #[serde(default, deny_unknown_fields)]
        pub struct TerminationPreset {
            $(
                #[doc = concat!("The term `", stringify!($Term), "`.")]
                pub $name: $Term,
            )+
        }

        /// Why an episode ended.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
        #[repr(u8)]
        pub enum EndCause {
            $(
                #[doc = concat!("Failure: see `", stringify!($Term), "`.")]
                $Term,
            )+
            /// A number of the state was not finite; counted as a failure.
            NotFinite,
            /// The motion ended; a truncation.
            MotionEnd,
            /// The time limit; a truncation.
            TimeOut,
        }

        /// Names of the termination terms: the keys under `terminations`.
        pub const TERMINATION_NAMES: [&str; TERMINATION_TERMS] = [$(stringify!($name)),+];

        /// Number of termination terms.
        pub const TERMINATION_TERMS: usize = [$(stringify!($name)),+].len();

        /// Number of causes.
        pub const END_CAUSES: usize = END_NAMES.len();

        /// Names of the causes, in the order of [`EndCause`].
        pub const END_NAMES: [&str; TERMINATION_TERMS + 3] =
            [$(stringify!($name),)+ "not_finite", "motion_end", "time_out"];

        impl EndCause {
            /// Every cause, in order.
            pub const ALL: [Self; END_CAUSES] =
                [$(Self::$Term,)+ Self::NotFinite, Self::MotionEnd, Self::TimeOut];
        }

        impl TerminationPreset {
            pub(crate) fn validate(&self) -> Result<(), TaskError> {
                $(self.$name.validate(concat!("terminations.", stringify!($name)))?;)+
                Ok(())
            }

            /// Each term that is on, with what it needs.
            pub(crate) fn active(&self) -> impl Iterator<Item = (&'static str, &'static [Requirement])> {
                let terms = [$((stringify!($name), self.$name.is_on(), $Term::NEEDS)),+];
                terms.into_iter().filter(|(_, on, _)| *on).map(|(name, _, needs)| (name, needs))
            }

            /// Rows of the table of terms.
            pub(crate) fn table() -> Vec<TermInfo> {
                vec![$(TermInfo::new::<$Term>("termination", stringify!($name), [$Term::UNIT, $Term::FRAME], $Term::NEEDS)),+]
            }

            /// The lanes that each term fails, one bit per lane.
            #[inline(always)]
            pub(crate) fn evaluate<V: Real>(&self, input: &TerminationInput<'_, V>) -> [u32; TERMINATION_TERMS] {
                [$(if self.$name.is_on() { self.$name.fails(input).bits() } else { 0 }),+]
            }
        }
    };
}

termination_terms! {
    anchor_height: AnchorHeight,
    gravity: Gravity,
    end_effector: EndEffector,
    anchor_distance: AnchorDistance,
    fallen: Fallen,
}

impl EndCause {
    /// Name for logs.
    pub fn name(self) -> &'static str {
        END_NAMES[self as usize]
    }

    /// True for a failure, false for a truncation.
    pub fn is_failure(self) -> bool {
        self <= Self::NotFinite
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_causes_and_presets_are_in_one_order() {
        assert_eq!(EndCause::ALL.map(|c| c as usize), core::array::from_fn(|k| k));
        assert_eq!(EndCause::AnchorDistance.name(), "anchor_distance");
        assert_eq!([EndCause::TimeOut.name(), EndCause::NotFinite.name()], ["time_out", "not_finite"]);
        let failures = EndCause::ALL.into_iter().filter(|c| c.is_failure()).count();
        assert_eq!(failures, TERMINATION_TERMS + 1);
    }

    #[test]
    fn a_term_that_is_left_out_is_off_and_a_bad_limit_is_named() {
        let preset: TerminationPreset = toml::from_str("gravity = { limit = 0.8 }").expect("valid");
        assert_eq!(preset.active().map(|(name, _)| name).collect::<Vec<_>>(), ["gravity"]);
        assert!(toml::from_str::<TerminationPreset>("anchor_height_m = 0.25").is_err());
        let preset: TerminationPreset = toml::from_str("fallen = { tilt_deg = -1.0 }").expect("parses");
        let error = preset.validate().expect_err("negative").to_string();
        assert_eq!(error, "preset: terminations.fallen.tilt_deg is -1.0, expected zero or more");
    }
}
