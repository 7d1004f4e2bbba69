//! A whole run as one typed preset: robot, task, learner, and the numbers of the run itself.

use paid_lanes::Isa;
use paid_learn::{ConfigError, LearnConfig};
use paid_task::layers::KeyError;
use paid_task::{TaskError, TaskPreset};
use serde::{Deserialize, Serialize};

use crate::TrainError;
use crate::judge::JudgeConfig;
use crate::phases::Phase;
use crate::style::AmpPreset;
use crate::teacher::TeacherPreset;
use crate::written::signed;

/// Environments and shards at most: more fit into no machine's memory.
const MOST_ENVS: usize = 1_000_000;

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
    /// A style reward by adversarial motion priors; none in most runs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub amp: Option<AmpPreset>,
    /// A policy to imitate; none in most runs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub teacher: Option<TeacherPreset>,
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
    pub average_last: f64,
    /// `auto`, `avx512`, `avx2` or `portable`. Two instruction sets round differently, so a run repeats bit for bit only on
    /// the same one.
    pub isa: String,
    /// Scores by MuJoCo in the log, where the program has it.
    #[serde(default)]
    pub judge: JudgeConfig,
}

/// A value that the learner refuses, as one of a preset whose table begins with `table`.
pub(crate) fn of_config(table: &str, ConfigError { key, expected, found }: ConfigError) -> KeyError {
    KeyError { key: format!("{table}{key}"), message: format!("expected {expected}, found {found}") }
}

impl RunPreset {
    /// Checks that every value is in its range.
    ///
    /// # Errors
    /// Key, expected, found.
    pub fn validate(&self) -> Result<(), String> {
        self.check().map_err(|error| error.to_string())
    }

    /// [`RunPreset::validate`], with the key apart.
    pub(crate) fn check(&self) -> Result<(), KeyError> {
        let wrong = |key: &str, message: String| Err(KeyError { key: key.to_owned(), message });
        let run = &self.run;
        for (key, value) in [
            ("run.envs", run.envs),
            ("run.shards", run.shards),
            ("run.keep_checkpoints", run.keep_checkpoints),
            ("run.checkpoint_interval", run.checkpoint_interval as usize),
        ] {
            if value == 0 {
                return wrong(key, "expected at least 1, found 0".to_owned());
            }
        }
        for (key, value) in [("run.envs", run.envs), ("run.shards", run.shards)] {
            if value > MOST_ENVS {
                return wrong(key, format!("expected at most {MOST_ENVS}, found {value}"));
            }
        }
        if !(0.0..1.0).contains(&run.average_last) {
            let found = run.average_last;
            return wrong("run.average_last", format!("expected 0 or more and less than 1, found {found}"));
        }
        run.judge.check()?;
        let isa: Isa = match run.isa.parse() {
            Ok(isa) => isa,
            Err(error) => return wrong("run.isa", format!("{error}")),
        };
        let unit = run.shards * isa.lanes();
        if !run.envs.is_multiple_of(unit) {
            let (shards, lanes, found) = (run.shards, isa.lanes(), run.envs);
            let message = format!(
                "expected a multiple of {unit} ({shards} shards of groups of {lanes} lanes), found {found}"
            );
            return wrong("run.envs", message);
        }
        self.task.validate().map_err(|error| match error {
            TaskError::Value { key, expected, found } => KeyError {
                key: format!("task.{key}"),
                message: format!("expected {expected}, found {found}"),
            },
            error => KeyError { key: "task".to_owned(), message: error.to_string() },
        })?;
        self.learn.check().map_err(|error| of_config("learn.", error))?;
        self.check_style()?;
        self.check_teacher()?;
        self.check_phases()
    }

    /// The instruction set of the preset.
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
            .map(|text| signed(&text))
            .map_err(|error| TrainError::Preset { place: self.stage.clone(), message: error.to_string() })
    }
}
