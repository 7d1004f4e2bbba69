//! A whole run as one typed preset: robot, task, learner, and the numbers of the run itself.

use std::fs;
use std::path::{Path, PathBuf};

use paid_lanes::Isa;
use paid_learn::{Checkpoint, LearnConfig};
use paid_task::TaskPreset;
use serde::{Deserialize, Serialize};
use toml::{Table, Value};

use crate::TrainError;
use crate::folder::PRESET_FILE;
use crate::phases::{Phase, hold, hold_key};
use crate::tree::{merge, one_line, parse, typed};

/// Run presets that the binary carries: name and TOML text.
pub const BUILTIN: [(&str, &str); 7] = [
    ("stage1", include_str!("../../../configs/train/stage1.toml")),
    ("stage2", include_str!("../../../configs/train/stage2.toml")),
    ("stage1_lstm", include_str!("../../../configs/train/stage1_lstm.toml")),
    ("stage2_lstm", include_str!("../../../configs/train/stage2_lstm.toml")),
    ("stage3", include_str!("../../../configs/train/stage3.toml")),
    ("stage3_no_sysid", include_str!("../../../configs/train/stage3_no_sysid.toml")),
    ("stage3_no_noise", include_str!("../../../configs/train/stage3_no_noise.toml")),
];

/// One stage of a run, completely described (with the motions).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunPreset {
    /// Name of the stage: the run folder's and the log's.
    pub stage: String,
    /// Built-in robot name, or path of a robot's TOML.
    pub robot: String,
    /// Values that change during the run, in the order in which they do.
    #[serde(default)]
    pub phases: Vec<Phase>,
    /// Size and duration.
    pub run: RunConfig,
    /// Networks and PPO; values that a file leaves out are the type's defaults.
    pub learn: LearnConfig,
    /// The task.
    pub task: TaskPreset,
}

/// Size and duration of a stage.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunConfig {
    /// Folder of the motion files; empty for the built-in kicks.
    pub motions: String,
    /// Environments over all shards.
    pub envs: usize,
    /// Shards: units of work that one thread steps and learns on. The result depends on their number, not on the threads.
    pub shards: usize,
    /// Iterations of the whole stage.
    pub iterations: u64,
    /// Seed of everything random.
    pub seed: u64,
    /// Iterations between checkpoints.
    pub checkpoint_interval: u64,
    /// Checkpoints that stay in the run folder; older ones are removed.
    pub keep_checkpoints: usize,
    /// The policy of the run is the mean of the checkpoints of its last part, this share of the iterations (of those that are kept):
    /// a little better than any one of them. With 0 it is the last.
    #[serde(default)]
    pub average_last: f64,
    /// `auto`, `avx512`, `avx2` or `portable`. Two instruction sets round differently, so a run repeats bit for bit only on
    /// the same one.
    pub isa: String,
}

impl RunPreset {
    /// Reads a preset by built-in name or file path, lays it over its bases, and applies `KEY=VALUE` overrides.
    ///
    /// A preset may say `base = "<run preset>"` at the top and `base = "<task preset>"` in `[task]`; a base is a built-in
    /// name or a path relative to the file. What a preset or an override says holds in every phase of the presets below.
    ///
    /// # Errors
    /// [`TrainError`] naming file or override, key, expected and found.
    pub fn resolve(name: &str, overrides: &[String]) -> Result<Self, TrainError> {
        let mut tree = load(name, Path::new(""), &|n| lookup(&BUILTIN, n), 0)?;
        if let Some(Value::Table(task)) = tree.get_mut("task")
            && let Some(base) = task.remove("base")
        {
            let fail = |message: String| TrainError::Preset { place: name.to_owned(), message };
            let Value::String(base) = base else {
                return Err(fail(format!("task.base: expected a name or path, found {base}")));
            };
            let mut bottom = load(&base, &folder_of(name), &|n| lookup(&paid_task::preset::BUILTIN, n), 0)?;
            merge(&mut bottom, std::mem::take(task));
            *task = bottom;
        }
        Self::with_overrides(name, tree, overrides)
    }

    /// Reads the resolved preset that a run saved, and applies overrides.
    ///
    /// # Errors
    /// If the text is not one, or an override does not apply.
    pub fn from_resolved(place: &str, text: &str, overrides: &[String]) -> Result<Self, TrainError> {
        Self::with_overrides(place, parse(place, text)?, overrides)
    }

    /// The resolved preset that a run saved in its folder, with overrides.
    ///
    /// # Errors
    /// If the folder holds none, or an override does not apply.
    pub fn of_run(run: &Path, overrides: &[String]) -> Result<Self, TrainError> {
        let path = run.join(PRESET_FILE);
        let text = fs::read_to_string(&path).map_err(TrainError::read(&path))?;
        Self::from_resolved(&path.to_string_lossy(), &text, overrides)
    }

    /// What held when a checkpoint was written.
    ///
    /// # Errors
    /// If it holds no preset, or one that is damaged.
    pub fn of_checkpoint(checkpoint: &Checkpoint) -> Result<Self, TrainError> {
        let path = checkpoint.path();
        let fail = |message: String| TrainError::Checkpoint { path: path.to_owned(), message };
        let text = checkpoint
            .blob(PRESET_FILE)
            .ok_or_else(|| fail(format!("expected an entry '{PRESET_FILE}' (text), found none")))?;
        let text = std::str::from_utf8(text).map_err(|error| fail(format!("{PRESET_FILE}: {error}")))?;
        Self::from_resolved(&path.to_string_lossy(), text, &[])
    }

    fn with_overrides(place: &str, tree: Table, overrides: &[String]) -> Result<Self, TrainError> {
        let fail = |message: String| TrainError::Preset { place: place.to_owned(), message };
        // Through the type and back, so that values left to their defaults can be overridden too.
        let preset: Self = typed(&tree).map_err(fail)?;
        let mut value = Value::try_from(&preset).map_err(|error| fail(error.to_string()))?;
        for text in overrides {
            paid_task::apply_override(&mut value, text).map_err(|error| TrainError::Preset {
                place: format!("--set {text}"),
                message: error.to_string(),
            })?;
            if let (Value::Table(tree), Some((key, _))) = (&mut value, text.split_once('=')) {
                hold_key(tree, key.trim());
            }
        }
        let preset: Self = value.try_into().map_err(|error: toml::de::Error| fail(one_line(&error)))?;
        preset.validate().map_err(fail)?;
        Ok(preset)
    }

    /// Checks that every value is in its range.
    ///
    /// # Errors
    /// Key, expected, found.
    pub fn validate(&self) -> Result<(), String> {
        let run = &self.run;
        for (key, value) in [
            ("run.envs", run.envs),
            ("run.shards", run.shards),
            ("run.keep_checkpoints", run.keep_checkpoints),
            ("run.checkpoint_interval", run.checkpoint_interval as usize),
        ] {
            if value == 0 {
                return Err(format!("{key}: expected at least 1, found 0"));
            }
        }
        if !(0.0..1.0).contains(&run.average_last) {
            return Err(format!(
                "run.average_last: expected 0 or more and less than 1, found {}",
                run.average_last
            ));
        }
        let isa = self.isa()?;
        if !run.envs.is_multiple_of(run.shards * isa.lanes()) {
            return Err(format!(
                "run.envs: expected a multiple of {} ({} shards of groups of {} lanes), found {}",
                run.shards * isa.lanes(),
                run.shards,
                isa.lanes(),
                run.envs
            ));
        }
        self.task.validate().map_err(|error| error.to_string())?;
        self.learn.check().map_err(|error| format!("learn.{error}"))?;
        self.check_phases()
    }

    /// The instruction set that the preset asks for.
    ///
    /// # Errors
    /// Key, expected, found.
    pub fn isa(&self) -> Result<Isa, String> {
        self.run.isa.parse().map_err(|error| format!("run.isa: {error}"))
    }

    /// The preset as TOML text.
    ///
    /// # Errors
    /// If a value has no TOML form (an integer above 2^63).
    pub fn to_toml(&self) -> Result<String, TrainError> {
        toml::to_string(self)
            .map_err(|error| TrainError::Preset { place: self.stage.clone(), message: error.to_string() })
    }
}

fn lookup(builtin: &[(&'static str, &'static str)], name: &str) -> Option<&'static str> {
    builtin.iter().find(|(n, _)| *n == name).map(|(_, text)| *text)
}

fn folder_of(name: &str) -> PathBuf {
    Path::new(name).parent().map_or_else(PathBuf::new, Path::to_owned)
}

/// Reads a preset tree and lays it over its bases.
fn load(
    name: &str,
    folder: &Path,
    builtin: &dyn Fn(&str) -> Option<&'static str>,
    depth: usize,
) -> Result<Table, TrainError> {
    // A path has an ending; a built-in name has none.
    let path = folder.join(name);
    let (text, inner_folder) = match builtin(name) {
        Some(text) => (text.to_owned(), PathBuf::new()),
        None if path.extension().is_some_and(|e| e == "toml") => {
            (fs::read_to_string(&path).map_err(TrainError::read(&path))?, folder_of(&path.to_string_lossy()))
        }
        None => {
            return Err(TrainError::Preset {
                place: name.to_owned(),
                message: format!(
                    "expected a built-in preset ({}) or the path of a .toml file",
                    BUILTIN.map(|(name, _)| name).join(", ")
                ),
            });
        }
    };
    let mut tree = parse(name, &text)?;
    match tree.remove("base") {
        None => Ok(tree),
        Some(Value::String(base)) if depth < 8 => {
            let mut bottom = load(&base, &inner_folder, builtin, depth + 1)?;
            hold(&mut bottom, &tree);
            merge(&mut bottom, tree);
            Ok(bottom)
        }
        Some(base) => Err(TrainError::Preset {
            place: name.to_owned(),
            message: format!("base: expected a name or path at most 8 bases deep, found {base}"),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn builtin_presets_resolve_and_survive_a_round_trip() {
        for (name, _) in BUILTIN {
            let preset = RunPreset::resolve(name, &[]).expect(name);
            assert_eq!(preset.task.name, preset.stage);
            let text = preset.to_toml().expect("writes");
            assert_eq!(RunPreset::from_resolved(name, &text, &[]).expect("reads"), preset);
        }
        // Stage II plays in its own scene, whatever its base does for Stage I; only the soles may bounce in both.
        let scene = TaskPreset::builtin("stage2").expect("built in").scene;
        let scene = paid_physics::SceneConfig { bounce_threshold: 0.05, ..scene };
        assert_eq!(RunPreset::resolve("stage2", &[]).expect("stage2").task.scene, scene);
        let lstm = RunPreset::resolve("stage2_lstm", &[]).expect("stage2_lstm");
        assert_eq!(lstm.learn.actor.kind, paid_learn::NetworkKind::Lstm);
        // With memory the ball is seen where it is.
        let mut without = RunPreset::resolve("stage2", &[]).expect("stage2").task;
        assert!(without.predicts_ball());
        without.observations = TaskPreset::builtin("stage2").expect("built in").observations;
        assert_eq!(lstm.task, without);
    }

    #[test]
    fn overrides_reach_every_part_and_a_misspelt_key_is_refused() {
        let sets =
            ["run.envs=64", "run.shards=4", "learn.ppo.gamma=0.9", "task.rewards.action_rate.weight=-1"];
        let preset = RunPreset::resolve("stage1", &sets.map(str::to_owned)).expect("resolves");
        assert_eq!((preset.run.envs, preset.learn.ppo.gamma), (64, 0.9));
        assert_eq!(preset.task.rewards.action_rate.weight, -1.0);
        for (set, hint) in [
            ("run.evns=64", "run.envs"),
            ("learn.ppo.gama=1", "learn.ppo.gamma"),
            ("run.envs=1000", "multiple of 64"),
            ("run.envs=many", "integer"),
            ("learn.ppo.clip=-1", "learn.ppo.clip"),
            ("run.isa=mmx", "avx2"),
            ("run.average_last=1.0", "run.average_last"),
        ] {
            let sets = ["run.isa=portable".to_owned(), set.to_owned()];
            let error = RunPreset::resolve("stage1", &sets).expect_err(set).to_string();
            assert!(error.contains(hint), "{error}");
        }
    }

    #[test]
    fn a_file_inherits_from_a_builtin_and_unknown_keys_name_the_file() {
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("mine.toml");
        fs::write(&path, "base = \"stage2\"\n[run]\nseed = 7\n[task.goal]\nwidth_m = 3.0\n").expect("write");
        let preset = RunPreset::resolve(&path.to_string_lossy(), &[]).expect("resolves");
        assert_eq!((preset.run.seed, preset.task.goal.width_m), (7, 3.0));
        assert_eq!(preset.task.name, "stage2");
        fs::write(&path, "base = \"stage2\"\n[run]\nsede = 7\n").expect("write");
        let error = RunPreset::resolve(&path.to_string_lossy(), &[]).expect_err("unknown key").to_string();
        assert!(error.contains("mine.toml") && error.contains("sede"), "{error}");
        assert!(RunPreset::resolve("stage9", &[]).is_err());
        assert!(RunPreset::resolve("absent.toml", &[]).is_err());
    }
}
