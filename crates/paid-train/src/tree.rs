//! Presets as trees: one laid over another, then read as a type.

use serde::de::DeserializeOwned;
use toml::{Table, Value};

use crate::TrainError;

/// Puts `top`'s entries over `bottom`'s, table by table.
pub fn merge(bottom: &mut Table, top: Table) {
    for (key, value) in top {
        match (bottom.get_mut(&key), value) {
            // A table that names a kind replaces a table of another kind as a whole: their keys differ.
            (Some(Value::Table(old)), Value::Table(new)) if same_kind(old, &new) => merge(old, new),
            (_, value) => {
                bottom.insert(key, value);
            }
        }
    }
}

fn same_kind(old: &Table, new: &Table) -> bool {
    new.get("kind").is_none_or(|kind| old.get("kind") == Some(kind))
}

/// Parses a preset text.
///
/// # Errors
/// [`TrainError::Preset`] with the parser's line and column.
pub fn parse(place: &str, text: &str) -> Result<Table, TrainError> {
    text.parse::<Table>().map_err(|error| TrainError::Preset {
        place: place.to_owned(),
        message: error.to_string().trim_end().to_owned(),
    })
}

/// The tree as a typed preset.
///
/// # Errors
/// Key, expected and found, as one line.
pub fn typed<T: DeserializeOwned>(tree: &Table) -> Result<T, String> {
    T::deserialize(Value::Table(tree.clone())).map_err(|error| one_line(&error))
}

/// An error's text without line breaks.
pub(crate) fn one_line(error: &dyn core::fmt::Display) -> String {
    error.to_string().lines().map(str::trim).filter(|l| !l.is_empty()).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn merge_goes_table_by_table_and_replaces_other_kinds() {
        let text = "[run]\nenvs = 4\nseed = 1\n[terrain]\nkind = 'plane'\nx = 1";
        let mut bottom = parse("bottom", text).expect("valid");
        merge(&mut bottom, parse("top", "[run]\nenvs = 9\n[terrain]\nkind = 'rough'\ny = 2").expect("valid"));
        assert_eq!(bottom["run"]["envs"].as_integer(), Some(9));
        assert_eq!(bottom["run"]["seed"].as_integer(), Some(1));
        let keys: Vec<_> = bottom["terrain"].as_table().expect("table").keys().cloned().collect();
        assert_eq!(keys, ["kind", "y"]);
    }

    #[test]
    fn a_syntax_error_names_file_and_line() {
        let error = parse("x.toml", "a = 1\nb =").expect_err("no value").to_string();
        assert!(error.contains("x.toml") && error.contains("line 2"), "{error}");
    }
}
