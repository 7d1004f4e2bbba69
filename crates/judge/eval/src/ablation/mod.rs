//! The paper's ablation of its third stage: each variant is trained from one policy, and MuJoCo judges it on the shipped surfaces.

mod judge;
mod score;

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsStr;
use std::path::Path;

use paid_train::RunPreset;
use paid_train::folder::PRESET_FILE;
use toml::{Table, Value};

use crate::EvalError;

pub use judge::{Judge, JudgeSettings, knowledge};
pub use score::{Count, Score, Scores};

/// What is compared: the name in the table and the run preset. The first one is complete.
pub const VARIANTS: [(&str, &str); 3] = [
    ("full", "stage3"),
    ("w/o identification", "stage3_no_sysid"),
    ("w/o observation noise", "stage3_no_noise"),
];
/// Where it is judged: surfaces of `configs/surfaces`.
pub const SURFACES: [&str; 2] = ["hard", "grass"];

/// How long every variant is trained.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Budget {
    /// As its preset says.
    #[default]
    Preset,
    /// So many iterations.
    Iterations(u64),
    /// So many samples, rounded up to whole iterations.
    Samples(u64),
}

/// A variant's run preset with changed values and a budget.
///
/// # Errors
/// If the preset does not exist or a value does not fit.
pub fn variant_preset(name: &str, overrides: &[String], budget: Budget) -> Result<RunPreset, EvalError> {
    let mut preset = RunPreset::resolve(name, overrides)?;
    let samples_per_iteration = (preset.run.envs * preset.learn.ppo.horizon) as u64;
    match budget {
        Budget::Preset => {}
        Budget::Iterations(iterations) => preset.run.iterations = iterations,
        Budget::Samples(samples) => preset.run.iterations = samples.div_ceil(samples_per_iteration),
    }
    Ok(preset)
}

/// True if the run in `folder` may be continued with `wanted`: it has the same values, but for its length and for where the motions' folder
/// lies.
///
/// # Errors
/// If the run's preset cannot be read.
pub fn is_same_run(folder: &Path, wanted: &RunPreset) -> Result<bool, EvalError> {
    Ok(difference(folder, wanted)?.is_none_or(|(key, ..)| key == ITERATIONS))
}

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
    use paid_sysid::Surface;
    use paid_task::preset::SurfacePreset;

    use super::*;

    #[test]
    fn the_training_surfaces_are_the_shipped_ones_and_variants_differ_in_one_thing() {
        let [full, no_sysid, no_noise] =
            VARIANTS.map(|(_, name)| RunPreset::resolve(name, &[]).expect(name).task);
        let shipped =
            SURFACES.map(|name| SurfacePreset::of(name, &Surface::load(name).expect(name).ball_params));
        assert_eq!(full.randomization.surfaces, shipped);
        let mut restored = no_sysid.clone();
        restored.randomization.surfaces.clone_from(&full.randomization.surfaces);
        restored.name.clone_from(&full.name);
        assert_eq!(restored, full);
        assert_eq!(no_sysid.randomization.surfaces.len(), 1);
        let mut restored = no_noise;
        assert!(!restored.observations.perception.gaussian);
        restored.observations.perception.gaussian = true;
        restored.name.clone_from(&full.name);
        assert_eq!(restored, full);
    }

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
        let same = |sets: &[&str]| is_same_run(folder.path(), &preset(sets)).expect("reads");
        let moved = ["run.motions=\"../here/paid\"", "run.iterations=100"];
        assert_eq!(told(&moved), None);
        assert!(same(&moved));

        let longer = ["run.motions=\"../here/paid\"", "run.iterations=200"];
        let three = |key: &str, expected: &str, found: &str| {
            Some((key.to_owned(), expected.to_owned(), found.to_owned()))
        };
        assert_eq!(told(&longer), three("run.iterations", "200", "100"));
        assert!(same(&longer), "but for its length");
        let other = ["run.motions=\"../here/others\"", "run.iterations=200"];
        assert_eq!(told(&other), three("run.motions", "\"../here/others\"", "\"/there/paid/\""));
        let seed = ["run.motions=\"paid\"", "run.iterations=200", "run.seed=7"];
        assert_eq!(told(&seed).map(|(key, ..)| key).as_deref(), Some("run.seed"));
        assert!(!same(&other) && !same(&seed));
    }

    #[test]
    fn samples_are_rounded_up_to_whole_iterations() {
        let overrides = ["run.envs=32", "run.shards=2"].map(str::to_owned);
        let of = |budget| variant_preset("stage3", &overrides, budget).expect("built in").run;
        let horizon =
            variant_preset("stage3", &overrides, Budget::Preset).expect("built in").learn.ppo.horizon;
        let one = (32 * horizon) as u64;
        assert_eq!(of(Budget::Samples(3 * one)).iterations, 3);
        assert_eq!(of(Budget::Samples(3 * one + 1)).iterations, 4);
        assert_eq!(of(Budget::Iterations(7)).iterations, 7);
    }
}
