//! A plan of a comparison: what is trained or taken as it is, with which budget, and how it is scored.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use paid_task::preset::KnowledgeMode;
use serde::{Deserialize, Serialize};

use paid_eval::shooting::{Grid, PAPER};
use paid_eval::tracking::PAPER_ROWS;
use paid_eval::{EvalError, Setting};

/// A file of a plan.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// Stands above the table.
    pub title: String,
    /// Training samples of an entry, over all of its stages; an entry may have its own number.
    pub samples: u64,
    /// Every entry is trained with each of these.
    #[serde(default = "one_seed")]
    pub seeds: Vec<u64>,
    /// Changed preset values of every stage, each `KEY=VALUE`. What one says holds in all of a run's phases; `phases.0.KEY=VALUE` changes the
    /// value of its first one, if that has the key.
    #[serde(default)]
    pub sets: Vec<String>,
    /// How policies are scored.
    #[serde(default)]
    pub judge: JudgePlan,
    /// What is compared, in the order of the table.
    #[serde(rename = "entry")]
    pub entries: Vec<Entry>,
}

fn one_seed() -> Vec<u64> {
    vec![1]
}

/// A row of the table: a policy that is trained, or one that there is.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Entry {
    /// Name in the table.
    pub name: String,
    /// The paper's name of the method, if it has figures of one.
    pub paper: Option<String>,
    /// Stages, each from the one before.
    #[serde(default)]
    pub stages: Vec<StagePlan>,
    /// The first stage starts from this policy instead of from scratch, and keeps its action noise except where Stage II follows
    /// Stage I: a run folder or checkpoint. A path is relative to the plan.
    pub from: Option<PathBuf>,
    /// Instead of stages: a run folder, checkpoint or ONNX file. A path is relative to the plan.
    pub policy: Option<PathBuf>,
    /// True: without its `policy`'s file, such as one that may not be passed on, the entry is left out ([`Plan::left_out`]).
    #[serde(default)]
    pub optional: bool,
    /// The policy is scored by how closely it follows the clips, not by its shots. For stages, the last stage's task decides.
    #[serde(default)]
    pub tracks: bool,
    /// One policy for each clip, each with the plan's samples, scored on its own clip.
    #[serde(default)]
    pub specialists: bool,
    /// Names of the specialists' clips; empty: all.
    #[serde(default)]
    pub clips: Vec<String>,
    /// Instead of the plan's.
    pub seeds: Option<Vec<u64>>,
    /// Instead of the plan's: a network that learns from fewer samples a second may be given the same time.
    pub samples: Option<u64>,
    /// Further changed preset values of all of its stages.
    #[serde(default)]
    pub sets: Vec<String>,
}

/// A stage of an entry.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StagePlan {
    /// Run preset: built in, or a file relative to the plan.
    pub preset: String,
    /// Share of the entry's samples.
    #[serde(default = "whole")]
    pub share: f64,
    /// Changed preset values of this stage alone, after those of plan and entry.
    #[serde(default)]
    pub sets: Vec<String>,
}

fn whole() -> f64 {
    1.0
}

/// How policies are scored, in MuJoCo.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct JudgePlan {
    /// Trials at each place of the effective workspace, with balls that lie still and with balls that roll.
    pub trials: usize,
    /// Distance between the places `[m]`; the paper's 0.25 m gives 63.
    pub grid_step_m: f64,
    /// Time limit of a trial `[s]`.
    pub limit_s: f64,
    /// What the policies are given of ball and goal, one evaluation each.
    pub knowledge: Vec<KnowledgeMode>,
    /// Trials at each place with each of the eleven balls and grounds of the panel, `truth`, still balls; 0 leaves it out.
    pub panel_trials: usize,
    /// Shots with each clip, `truth`, still balls within 0.25 m of the clip's own place; 0 leaves it out, as does a policy without clips.
    pub clip_trials: usize,
    /// Trials at each place, `truth`, still balls, whose kicks are compared with the clips; 0 leaves it out.
    pub likeness_trials: usize,
    /// Starts with reset noise of each clip, besides the exact one, of policies that follow clips without a ball; 0 refuses these.
    pub tracking_starts: usize,
    /// Seed of the trials.
    pub seed: u64,
}

impl Default for JudgePlan {
    fn default() -> Self {
        let knowledge = vec![KnowledgeMode::Truth];
        Self {
            trials: 10,
            grid_step_m: Grid::EFFECTIVE.step,
            limit_s: 12.0,
            knowledge,
            panel_trials: 0,
            clip_trials: 0,
            likeness_trials: 0,
            tracking_starts: 0,
            seed: 0,
        }
    }
}

impl JudgePlan {
    /// Where the balls lie.
    pub fn grid(&self) -> Grid {
        Grid { step: self.grid_step_m, ..Grid::EFFECTIVE }
    }

    /// Number of places.
    pub fn places(&self) -> usize {
        let grid = self.grid();
        grid.places(grid.x).len() * grid.places(grid.y).len()
    }
}

impl Plan {
    /// Reads a plan.
    ///
    /// # Errors
    /// File, place, what was expected and found.
    pub fn read(path: &Path) -> Result<Self, EvalError> {
        let text = fs::read_to_string(path).map_err(paid_files::FileError::at(path))?;
        toml::from_str(&text).map_err(|error| EvalError::Format {
            path: path.to_owned(),
            expected: "a plan of a comparison",
            found: error.to_string().trim_end().to_owned(),
        })
    }

    /// Optional entries whose policy is not there, with the file that is missing. `folder` is the plan's.
    pub fn left_out(&self, folder: &Path) -> Vec<(&str, PathBuf)> {
        let missing = |entry: &Entry| {
            let file = folder.join(entry.policy.as_ref().filter(|_| entry.optional)?);
            (!file.exists()).then_some(file)
        };
        self.entries.iter().filter_map(|entry| Some((entry.name.as_str(), missing(entry)?))).collect()
    }

    pub(super) fn check(&self) -> Result<(), EvalError> {
        if self.entries.is_empty() {
            return Err(wrong("entry", "one or more", "none"));
        }
        if self.samples == 0 {
            return Err(wrong("samples", "at least 1", "0"));
        }
        if let Some(entry) = self.entries.iter().find(|e| e.samples == Some(0)) {
            return Err(wrong("entry.samples", "at least 1", &format!("0 in '{}'", entry.name)));
        }
        if let Some(entry) = self.entries.iter().find(|e| e.optional && e.policy.is_none()) {
            return Err(wrong("entry.optional", "a policy whose file may be missing", &entry.name));
        }
        if let Some(entry) = self.entries.iter().find(|e| e.samples.is_some() && e.policy.is_some()) {
            return Err(wrong("entry.samples", "stages to spend them on", &entry.name));
        }
        for entry in &self.entries {
            entry.check()?;
        }
        check_sets(&self.sets)?;
        if self.judge.trials == 0 {
            return Err(wrong("judge.trials", "at least 1", "0"));
        }
        if !(self.judge.grid_step_m > 0.0 && self.judge.grid_step_m <= 2.0) {
            return Err(wrong(
                "judge.grid_step_m",
                "above 0 and at most 2 m",
                &self.judge.grid_step_m.to_string(),
            ));
        }
        if !(self.judge.limit_s > 0.0 && self.judge.limit_s <= 60.0) {
            return Err(wrong("judge.limit_s", "above 0 and at most 60 s", &self.judge.limit_s.to_string()));
        }
        if self.judge.knowledge.is_empty() {
            return Err(wrong("judge.knowledge", "truth, perceived or both", "none"));
        }
        let told = &self.judge.knowledge;
        if told.iter().enumerate().any(|(k, knowledge)| told[..k].contains(knowledge)) {
            return Err(wrong("judge.knowledge", "each once", &format!("{told:?}").to_lowercase()));
        }
        for seeds in core::iter::once(&self.seeds).chain(self.entries.iter().filter_map(|e| e.seeds.as_ref()))
        {
            let twice = seeds.iter().enumerate().any(|(k, seed)| seeds[..k].contains(seed));
            if seeds.is_empty() || twice {
                return Err(wrong("seeds", "one or more, each once", &format!("{seeds:?}")));
            }
        }
        Ok(())
    }
}

impl Entry {
    /// Refuses what would be ignored, and a method that the paper does not have.
    fn check(&self) -> Result<(), EvalError> {
        if self.policy.is_some() {
            let ignored = [("entry.sets", !self.sets.is_empty()), ("entry.seeds", self.seeds.is_some())];
            if let Some((option, _)) = ignored.into_iter().find(|(_, given)| *given) {
                return Err(wrong(option, "stages to train with them", &self.name));
            }
        }
        let known: BTreeSet<&str> =
            PAPER.iter().map(|(name, _)| *name).chain(PAPER_ROWS.iter().map(|row| row.method)).collect();
        if let Some(paper) = self.paper.as_deref().filter(|paper| !known.contains(paper)) {
            let known = known.into_iter().collect::<Vec<_>>().join(", ");
            return Err(wrong(
                "entry.paper",
                &format!("one of {known}"),
                &format!("{paper} in '{}'", self.name),
            ));
        }
        self.stages.iter().map(|stage| &stage.sets).chain([&self.sets]).try_for_each(|sets| check_sets(sets))
    }
}

/// Refuses values that the plan says in another way.
fn check_sets(sets: &[String]) -> Result<(), EvalError> {
    for set in sets {
        let key = set.split('=').next().unwrap_or_default().trim();
        for (taken, instead) in [("run.iterations", "samples"), ("run.seed", "seeds")] {
            if key == taken {
                return Err(wrong("sets", &format!("{instead} instead of {taken}"), set));
            }
        }
    }
    Ok(())
}

pub(super) fn wrong(option: &'static str, expected: &str, found: &str) -> EvalError {
    EvalError::Option {
        option: Setting::Named(option),
        expected: expected.to_owned(),
        found: found.to_owned(),
    }
}
