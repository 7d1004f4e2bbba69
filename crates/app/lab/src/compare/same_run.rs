//! Whether the run in a folder is the one of a plan.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsStr;
use std::path::Path;

use paid_play::PRESET_FILE;
use paid_train::RunPreset;
use toml::{Table, Value};

use paid_eval::EvalError;

/// The key of a run's length.
const ITERATIONS: &str = "run.iterations";

/// The first value of the run in `folder` that is not that of `wanted`: key, expected, found; a different length comes last. Of the motions'
/// folder only the name counts, so that a run may be moved to another machine.
///
/// # Errors
/// If the run's preset cannot be read.
pub fn difference(folder: &Path, wanted: &RunPreset) -> Result<Option<(String, String, String)>, EvalError> {
    let mut found = RunPreset::of_run(folder, &[])?;
    if last_part(&found.run.motions) == last_part(&wanted.run.motions) {
        found.run.motions.clone_from(&wanted.run.motions);
    }
    let (mut expected, mut found) = (values(wanted)?, values(&found)?);
    let length = (expected.remove(ITERATIONS), found.remove(ITERATIONS));
    let text = |value: Option<&Value>| value.map_or("none".to_owned(), Value::to_string);
    let keys: BTreeSet<&String> = expected.keys().chain(found.keys()).collect();
    for key in keys {
        let (expected, found) = (expected.get(key), found.get(key));
        if expected != found {
            return Ok(Some((key.clone(), text(expected), text(found))));
        }
    }
    let (expected, found) = (text(length.0.as_ref()), text(length.1.as_ref()));
    Ok((expected != found).then(|| (ITERATIONS.to_owned(), expected, found)))
}

/// The last part of a path, as a policy file keeps it of the motions' folder; empty for an empty path.
fn last_part(path: &str) -> Option<&OsStr> {
    Path::new(path).file_name()
}

/// The values of a preset under their dotted keys.
fn values(preset: &RunPreset) -> Result<BTreeMap<String, Value>, EvalError> {
    fn collect(value: Value, key: &str, out: &mut BTreeMap<String, Value>) {
        match value {
            Value::Table(table) => {
                for (name, inner) in table {
                    let key = if key.is_empty() { name } else { format!("{key}.{name}") };
                    collect(inner, &key, out);
                }
            }
            value => {
                out.insert(key.to_owned(), value);
            }
        }
    }
    let text = preset.to_toml()?;
    let table: Table = toml::from_str(&text).map_err(|error| EvalError::Format {
        path: preset.stage.clone().into(),
        expected: "a preset",
        found: error.to_string(),
    })?;
    let mut out = BTreeMap::new();
    collect(Value::Table(table), "", &mut out);
    Ok(out)
}

/// True if there is a run in `folder`.
pub fn has_run(folder: &Path) -> bool {
    folder.join(PRESET_FILE).exists()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_is_the_same_wherever_its_motions_lie_and_tells_the_first_value_that_differs() {
        let folder = tempfile::tempdir().expect("folder");
        let preset = |sets: &[&str]| {
            let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
            RunPreset::resolve("stage1", &sets).expect("built in")
        };
        let run = preset(&["run.motions=\"/there/paid/\"", "run.iterations=100"]);
        std::fs::write(folder.path().join(PRESET_FILE), run.to_toml().expect("TOML")).expect("writes");
        let told = |sets: &[&str]| difference(folder.path(), &preset(sets)).expect("reads");
        let moved = ["run.motions=\"../here/paid\"", "run.iterations=100"];
        assert_eq!(told(&moved), None);

        let longer = ["run.motions=\"../here/paid\"", "run.iterations=200"];
        let three = |key: &str, expected: &str, found: &str| {
            Some((key.to_owned(), expected.to_owned(), found.to_owned()))
        };
        assert_eq!(told(&longer), three("run.iterations", "200", "100"));
        let other = ["run.motions=\"../here/others\"", "run.iterations=200"];
        assert_eq!(told(&other), three("run.motions", "\"../here/others\"", "\"/there/paid/\""));
        let seed = ["run.motions=\"paid\"", "run.iterations=200", "run.seed=7"];
        assert_eq!(told(&seed).map(|(key, ..)| key).as_deref(), Some("run.seed"));
    }
}
