//! Values that make no sense.

use thiserror::Error;

/// A value of a preset is outside its range.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{key} is {found}, expected {expected}")]
pub struct ValueError {
    /// Dotted key below the preset.
    pub key: String,
    /// What is allowed.
    pub expected: String,
    /// What was given.
    pub found: String,
}

impl ValueError {
    pub(crate) fn new(key: &str, expected: &str, found: impl ToString) -> Self {
        Self { key: key.to_owned(), expected: expected.to_owned(), found: found.to_string() }
    }

    /// The same error below another key.
    #[must_use]
    pub(crate) fn below(self, key: &str) -> Self {
        Self { key: format!("{key}.{}", self.key), ..self }
    }
}

/// Refuses a number outside `limits`, both included.
pub(crate) fn within(key: &str, value: f64, limits: [f64; 2], expected: &str) -> Result<(), ValueError> {
    if (limits[0]..=limits[1]).contains(&value) { Ok(()) } else { Err(ValueError::new(key, expected, value)) }
}

/// Refuses a range that does not ascend or leaves `limits`.
pub(crate) fn range_within(
    key: &str,
    [lo, hi]: [f64; 2],
    limits: [f64; 2],
    expected: &str,
) -> Result<(), ValueError> {
    if lo <= hi && limits[0] <= lo && hi <= limits[1] {
        return Ok(());
    }
    Err(ValueError::new(key, &format!("[lo, hi] with lo <= hi, {expected}"), format!("{:?}", [lo, hi])))
}
