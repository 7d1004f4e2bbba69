//! Typed parameters of a reward or termination term: default, unit, range and reason stand in one place, [`parameters!`](crate::parameters).

use core::fmt;

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::TaskError;
use crate::preset::value_error;

/// What a term needs of its task. Without a ball in the scene a term that needs one is 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Requirement {
    /// A reference motion.
    Reference,
    /// A physical ball.
    Ball,
}

impl fmt::Display for Requirement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Reference => "a reference motion",
            Self::Ball => "a ball",
        })
    }
}

/// A parameter of a term, for a table.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ParameterInfo {
    /// Key in the preset.
    pub name: &'static str,
    /// What it does.
    pub summary: String,
    /// Default, as TOML.
    pub default: String,
    /// SI unit; empty for pure numbers and choices.
    pub unit: &'static str,
    /// Why the default is what it is.
    pub reason: &'static str,
}

/// Parameters that a preset may set, each with a default.
pub trait Parameters: Default + fmt::Debug + Serialize + DeserializeOwned + Send + Sync + 'static {
    /// What the term measures, in one sentence.
    const SUMMARY: &'static str;

    /// Every parameter but a weight.
    fn parameters() -> Vec<ParameterInfo>;

    /// Checks that every value is in its range; `key` is the term's own in the preset.
    ///
    /// # Errors
    /// The first value that is not.
    fn validate(&self, key: &str) -> Result<(), TaskError>;
}

/// Declares a term's parameters: `key: type = default, unit, range, reason;`. The range is a function of [`range`].
///
/// It makes the struct (every key may be left out, unknown ones are refused), its defaults, its validation and its rows in the
/// table of terms. The crate that uses it needs `serde` with the feature `derive`.
#[macro_export]
macro_rules! parameters {
    (
        $(#[doc = $summary:literal])+
        pub struct $Term:ident {
            $($(#[doc = $doc:literal])+ $key:ident: $kind:ty = $default:expr, $unit:literal, $range:ident, $reason:literal;)*
        }
    ) => {
        $(#[doc = $summary])+
        #[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(default, deny_unknown_fields)]
        pub struct $Term {
            $(
                $(#[doc = $doc])+
                ///
                #[doc = concat!("Default: ", $reason, ".")]
                pub $key: $kind,
            )*
        }

        impl Default for $Term {
            fn default() -> Self {
                Self { $($key: $default),* }
            }
        }

        impl $crate::terms::parameters::Parameters for $Term {
            const SUMMARY: &'static str = concat!($($summary),+);

            fn parameters() -> Vec<$crate::terms::parameters::ParameterInfo> {
                let rows = [$((stringify!($key), concat!($($doc),+), $unit, $reason)),*];
                $crate::terms::parameters::rows(&Self::default(), &rows)
            }

            fn validate(&self, key: &str) -> Result<(), $crate::TaskError> {
                $($crate::terms::parameters::check(key, stringify!($key), &self.$key, $crate::terms::parameters::range::$range)?;)*
                Ok(())
            }
        }
    };
}
/// Table rows of `(key, summary, unit, reason)`; defaults are read from the serialized `term`.
///
/// # Panics
/// If a parameter is no plain value.
pub fn rows<T: Serialize>(
    term: &T,
    rows: &[(&'static str, &str, &'static str, &'static str)],
) -> Vec<ParameterInfo> {
    let defaults = toml::Table::try_from(term).expect("parameters are plain values");
    rows.iter()
        .filter(|(name, ..)| *name != "weight")
        .map(|&(name, summary, unit, reason)| ParameterInfo {
            name,
            summary: summary.trim().to_owned(),
            default: defaults[name].to_string(),
            unit,
            reason,
        })
        .collect()
}

/// Refuses a value outside its range.
///
/// # Errors
/// Key, expected and found.
pub fn check<T: std::fmt::Debug>(
    term: &str,
    key: &str,
    value: &T,
    (holds, expected): (fn(&T) -> bool, &str),
) -> Result<(), TaskError> {
    if holds(value) {
        Ok(())
    } else {
        Err(value_error(&format!("{term}.{key}"), expected, format!("{value:?}")))
    }
}

/// Ranges of parameters: whether a value is inside, and how the range reads in an error.
#[allow(non_upper_case_globals)]
pub mod range {
    /// A range and its name.
    pub type Range = (fn(&f64) -> bool, &'static str);
    /// Above zero.
    pub const positive: Range = (|x| *x > 0.0 && x.is_finite(), "a positive number");
    /// Zero or above.
    pub const not_negative: Range = (|x| *x >= 0.0 && x.is_finite(), "zero or more");
    /// Any number.
    pub const finite: Range = (|x| x.is_finite(), "a finite number");
    /// A switch.
    pub const switch: (fn(&bool) -> bool, &str) = (|_| true, "true or false");
    /// A point of the robot.
    pub const point: (fn(&crate::ProximityPoint) -> bool, &str) = (|_| true, "a point of the robot");
}

#[cfg(test)]
mod tests {
    use super::*;

    parameters! {
        /// A term
        /// for tests.
        pub struct Example {
            /// Pay.
            weight: f64 = 0.0, "", finite, "off";
            /// Width.
            sigma: f64 = 0.3, "m", positive, "measured";
        }
    }

    #[test]
    fn a_key_that_is_left_out_has_its_default_and_an_unknown_one_is_refused() {
        let example: Example = toml::from_str("weight = 2.0").expect("valid");
        assert_eq!(example, Example { weight: 2.0, sigma: 0.3 });
        let error = toml::from_str::<Example>("width = 2.0").expect_err("unknown").to_string();
        assert!(error.contains("width"), "{error}");
    }

    #[test]
    fn a_value_outside_its_range_is_named() {
        let error =
            Example { weight: 1.0, sigma: 0.0 }.validate("rewards.example").expect_err("zero").to_string();
        assert_eq!(error, "preset: rewards.example.sigma is 0.0, expected a positive number");
        assert!(Example { weight: f64::NAN, sigma: 1.0 }.validate("rewards.example").is_err());
    }

    #[test]
    fn the_table_has_every_parameter_but_the_weight() {
        assert_eq!(Example::SUMMARY, " A term for tests.");
        let expected = ParameterInfo {
            name: "sigma",
            summary: "Width.".into(),
            default: "0.3".into(),
            unit: "m",
            reason: "measured",
        };
        assert_eq!(Example::parameters(), [expected]);
    }
}
