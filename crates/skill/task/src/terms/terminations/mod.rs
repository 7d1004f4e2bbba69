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

use std::sync::OnceLock;

use paid_lanes::{Mask, Real};
use serde::{Deserialize, Serialize};

use crate::TaskError;
use crate::terms::parameters::{Parameters, Requirement};
use crate::terms::table::TermInfo;
use crate::terms::{OwnTerminations, TermInput, own_termination_names, own_termination_table};

/// A termination term: its limits, which [`parameters!`](crate::parameters) declares, and which lanes are beyond them.
pub trait TerminationTerm: Parameters {
    /// SI unit of what the term measures; empty for pure numbers.
    const UNIT: &'static str;
    /// Frame in which it measures.
    const FRAME: &'static str;
    /// What it needs.
    const NEEDS: &'static [Requirement] = &[];

    /// True if the term can end an episode.
    fn is_on(&self) -> bool;

    /// The lanes beyond the limits. Called only while the term is on. Mark it `#[inline(always)]`: it is compiled for each lane type and
    /// instruction set.
    fn fails<V: Real>(&self, input: &TermInput<'_, V>) -> V::Mask;
}

/// Makes the preset, the causes of an end and everything that runs over the terms, in the order of the list.
macro_rules! termination_terms {
    ($($name:ident: $Term:ident),+ $(,)?) => {
        $(pub use $name::$Term;)+

        /// All termination terms. One that a preset leaves out is off.
        #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
        #[serde(default)]
        pub struct TerminationPreset {
            $(
                #[doc = concat!("The term `", stringify!($Term), "`.")]
                pub $name: $Term,
            )+
            /// The terms of other crates, under their names; unknown keys are refused here.
            #[serde(flatten)]
            pub own: OwnTerminations,
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
            /// Failure: the term of this number among those that other crates have installed.
            Own(u8),
        }

        /// Names of the built-in terms.
        pub(crate) const TERMINATION_NAMES: [&str; TERMINATION_TERMS] = [$(stringify!($name)),+];

        /// Number of built-in terms.
        pub(crate) const TERMINATION_TERMS: usize = [$(stringify!($name)),+].len();

        impl EndCause {
            /// The causes that every task has, in order.
            pub const BUILTIN: [Self; TERMINATION_TERMS + 3] =
                [$(Self::$Term,)+ Self::NotFinite, Self::MotionEnd, Self::TimeOut];
        }

        impl TerminationPreset {
            pub(crate) fn validate(&self) -> Result<(), TaskError> {
                $(self.$name.validate(concat!("terminations.", stringify!($name)))?;)+
                self.own.validate()
            }

            /// Each term that is on, with what it needs.
            pub(crate) fn active(&self) -> impl Iterator<Item = (&'static str, &'static [Requirement])> {
                let terms = [$((stringify!($name), self.$name.is_on(), $Term::NEEDS)),+];
                let active = terms.into_iter().filter(|(_, on, _)| *on);
                active.map(|(name, _, needs)| (name, needs)).chain(self.own.active())
            }

            /// Rows of the table of terms.
            pub(crate) fn table() -> Vec<TermInfo> {
                let builtin = [$(TermInfo::new::<$Term>("termination", stringify!($name), [$Term::UNIT, $Term::FRAME], $Term::NEEDS)),+];
                builtin.into_iter().chain(own_termination_table()).collect()
            }

            /// The lanes that each built-in term fails, one bit per lane.
            #[inline(always)]
            pub(crate) fn evaluate<V: Real>(&self, input: &TermInput<'_, V>) -> [u32; TERMINATION_TERMS] {
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

/// Names of the causes of an episode's end, in the order of [`EndCause::index`].
pub fn end_names() -> &'static [&'static str] {
    static NAMES: OnceLock<Vec<&str>> = OnceLock::new();
    let others = ["not_finite", "motion_end", "time_out"];
    let builtin = TERMINATION_NAMES.into_iter().chain(others);
    NAMES.get_or_init(|| builtin.chain(own_termination_names()).collect())
}

/// Every key under `terminations`.
pub(crate) fn keys() -> &'static [&'static str] {
    static KEYS: OnceLock<Vec<&str>> = OnceLock::new();
    KEYS.get_or_init(|| TERMINATION_NAMES.into_iter().chain(own_termination_names()).collect())
}

impl EndCause {
    /// Place among [`end_names`] and in [`crate::TaskMetrics::ends`].
    pub fn index(self) -> usize {
        match self {
            Self::Own(term) => Self::BUILTIN.len() + usize::from(term),
            cause => Self::BUILTIN.iter().position(|builtin| *builtin == cause).expect("a built-in cause"),
        }
    }

    /// Name for logs.
    pub fn name(self) -> &'static str {
        end_names()[self.index()]
    }

    /// True for a failure, false for a truncation.
    pub fn is_failure(self) -> bool {
        self <= Self::NotFinite || matches!(self, Self::Own(_))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_causes_and_presets_are_in_one_order() {
        assert_eq!(EndCause::BUILTIN.map(EndCause::index), core::array::from_fn(|k| k));
        assert_eq!(EndCause::AnchorDistance.name(), "anchor_distance");
        assert_eq!([EndCause::TimeOut.name(), EndCause::NotFinite.name()], ["time_out", "not_finite"]);
        let failures = EndCause::BUILTIN.into_iter().filter(|c| c.is_failure()).count();
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
