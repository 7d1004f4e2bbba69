//! A plan of a comparison: what is trained or taken as it is, with which budget, and how it is judged.

use std::fs;
use std::path::{Path, PathBuf};

use paid_task::preset::KnowledgeMode;
use paid_train::RunPreset;
use serde::{Deserialize, Serialize};

use crate::EvalError;
use crate::shooting::Grid;

/// A file of a plan.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// Stands above the table.
    pub title: String,
    /// Training samples of an entry, over all of its stages.
    pub samples: u64,
    /// Every entry is trained with each of these.
    #[serde(default = "one_seed")]
    pub seeds: Vec<u64>,
    /// Changed preset values of every stage, each `KEY=VALUE`.
    #[serde(default)]
    pub sets: Vec<String>,
    /// How policies are judged.
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
    /// The first stage begins with this policy instead of from scratch, and keeps its action noise except where Stage II follows
    /// Stage I: a run folder or checkpoint. A path is relative to the plan.
    pub from: Option<PathBuf>,
    /// Instead of stages: a run folder, checkpoint or ONNX file. A path is relative to the plan.
    pub policy: Option<PathBuf>,
    /// Instead of the plan's.
    pub seeds: Option<Vec<u64>>,
    /// Further changed preset values.
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
}

fn whole() -> f64 {
    1.0
}

/// How policies are judged, in MuJoCo.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct JudgePlan {
    /// Trials at each place of the effective workspace, with balls that lie still and with balls that roll.
    pub trials: usize,
    /// Distance between the places `[m]`; the paper's 0.25 m gives 63.
    pub grid_step_m: f64,
    /// Time limit of a trial `[s]`.
    pub limit_s: f64,
    /// What the policies are told of ball and goal, one judgment each.
    pub knowledge: Vec<KnowledgeMode>,
    /// Trials at each place with each of the ten balls and grounds of the panel, `truth`, still balls; 0 leaves it out.
    pub panel_trials: usize,
    /// Shots with each clip, `truth`, still balls within 0.25 m of the clip's own place; 0 leaves it out, as does a policy without clips.
    pub clip_trials: usize,
    /// Trials at each place, `truth`, still balls, whose kicks are compared with the clips; 0 leaves it out.
    pub likeness_trials: usize,
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

/// A policy of the comparison, once all of its presets are known to fit.
#[derive(Clone, Debug)]
pub struct Contender {
    /// Name of its entry.
    pub name: String,
    /// The paper's name of the method.
    pub paper: Option<String>,
    /// Seed of its training; `None` for a policy that there is.
    pub seed: Option<u64>,
    /// Folder of its runs and scores, below the comparison's.
    pub folder: PathBuf,
    /// What is trained.
    pub stages: Vec<RunPreset>,
    /// What the first stage begins with.
    pub from: Option<PathBuf>,
    /// What there is.
    pub policy: Option<PathBuf>,
}

impl Plan {
    /// Reads a plan.
    ///
    /// # Errors
    /// File, place, what was expected and found.
    pub fn read(path: &Path) -> Result<Self, EvalError> {
        let text = fs::read_to_string(path).map_err(EvalError::read(path))?;
        toml::from_str(&text).map_err(|error| EvalError::Format {
            path: path.to_owned(),
            expected: "a plan of a comparison",
            found: error.to_string().trim_end().to_owned(),
        })
    }

    /// Everything that is to be trained and judged, checked before any of it begins. `folder` is the plan's, and `motions` changes
    /// where the clips lie.
    ///
    /// # Errors
    /// The first part of the plan that cannot be done.
    pub fn contenders(&self, folder: &Path, motions: Option<&str>) -> Result<Vec<Contender>, EvalError> {
        self.check()?;
        let mut contenders: Vec<Contender> = Vec::new();
        for entry in &self.entries {
            let slug = slug(&entry.name);
            if contenders.iter().any(|c| c.folder.starts_with(&slug)) {
                return Err(wrong("entry.name", "a name of its own for every entry", &entry.name));
            }
            let new = |seed: Option<u64>| Contender {
                name: entry.name.clone(),
                paper: entry.paper.clone(),
                seed,
                folder: PathBuf::from(&slug),
                stages: Vec::new(),
                from: None,
                policy: None,
            };
            let there = |option: &'static str, path: &Path| {
                let path = folder.join(path);
                let found = path.display().to_string();
                path.exists()
                    .then_some(path)
                    .ok_or_else(|| wrong(option, "a run folder or a policy file", &found))
            };
            match (&entry.policy, entry.stages.is_empty()) {
                (Some(_), true) if entry.from.is_some() => {
                    return Err(wrong("entry.from", "stages that begin with it", &entry.name));
                }
                (Some(policy), true) => {
                    let policy = there("entry.policy", policy)?;
                    contenders.push(Contender { policy: Some(policy), ..new(None) });
                }
                (None, false) => {
                    let from = entry.from.as_deref().map(|from| there("entry.from", from)).transpose()?;
                    for &seed in entry.seeds.as_ref().unwrap_or(&self.seeds) {
                        let stages = self.stages(entry, seed, folder, motions)?;
                        let folder = PathBuf::from(&slug).join(format!("seed-{seed}"));
                        contenders.push(Contender { stages, folder, from: from.clone(), ..new(Some(seed)) });
                    }
                }
                _ => return Err(wrong("entry", "either stages or a policy", &entry.name)),
            }
        }
        let mut robots = contenders.iter().flat_map(|c| &c.stages).map(|preset| &preset.robot);
        if let Some(first) = robots.next()
            && let Some(other) = robots.find(|robot| *robot != first)
        {
            return Err(wrong("entry.stages", &format!("one robot for all, '{first}'"), other));
        }
        Ok(contenders)
    }

    fn check(&self) -> Result<(), EvalError> {
        if self.entries.is_empty() {
            return Err(wrong("entry", "one or more", "none"));
        }
        if self.samples == 0 {
            return Err(wrong("samples", "at least 1", "0"));
        }
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
        for seeds in core::iter::once(&self.seeds).chain(self.entries.iter().filter_map(|e| e.seeds.as_ref()))
        {
            let twice = seeds.iter().enumerate().any(|(k, seed)| seeds[..k].contains(seed));
            if seeds.is_empty() || twice {
                return Err(wrong("seeds", "one or more, each once", &format!("{seeds:?}")));
            }
        }
        Ok(())
    }

    /// The resolved presets of an entry's stages.
    fn stages(
        &self,
        entry: &Entry,
        seed: u64,
        folder: &Path,
        motions: Option<&str>,
    ) -> Result<Vec<RunPreset>, EvalError> {
        let total: f64 = entry.stages.iter().map(|stage| stage.share).sum();
        if entry.stages.iter().any(|stage| !(stage.share > 0.0 && stage.share.is_finite())) {
            return Err(wrong("entry.stages.share", "above zero", &entry.name));
        }
        let mut stages = Vec::new();
        for stage in &entry.stages {
            let mut sets: Vec<String> = self.sets.iter().chain(&entry.sets).cloned().collect();
            sets.extend(motions.map(str::to_owned));
            sets.push(format!("run.seed={seed}"));
            let file = Path::new(&stage.preset).extension().is_some();
            let name =
                if file { folder.join(&stage.preset).display().to_string() } else { stage.preset.clone() };
            let mut preset = RunPreset::resolve(&name, &sets)?;
            let per_iteration = (preset.run.envs * preset.learn.ppo.horizon) as f64;
            let samples = self.samples as f64 * stage.share / total;
            preset.run.iterations = (samples / per_iteration).ceil() as u64;
            stages.push(preset);
        }
        match stages.last() {
            Some(last) if last.task.scene.ball => Ok(stages),
            _ => Err(wrong("entry.stages", "a last stage with a ball", &entry.name)),
        }
    }
}

fn wrong(option: &'static str, expected: &str, found: &str) -> EvalError {
    EvalError::Option { option, expected: expected.to_owned(), found: found.to_owned() }
}

/// A name as a folder's: letters and digits in lower case, `-` for everything between.
fn slug(name: &str) -> String {
    let words = name.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty());
    words.map(str::to_lowercase).collect::<Vec<_>>().join("-")
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLAN: &str = r#"
        title = "two methods"
        samples = 100000
        seeds = [1, 2]

        [judge]
        trials = 2
        knowledge = ["truth", "perceived"]

        [[entry]]
        name = "Ours (two stages)"
        paper = "PAiD"
        stages = [{ preset = "stage1", share = 0.4 }, { preset = "stage2", share = 0.6 }]

        [[entry]]
        name = "AMP"
        seeds = [7]
        stages = [{ preset = "amp" }]
    "#;

    fn refused(text: &str) -> String {
        let plan = toml::from_str::<Plan>(text).map_err(|error| error.to_string());
        match plan {
            Ok(plan) => plan.contenders(Path::new(""), None).expect_err("refused").to_string(),
            Err(error) => error,
        }
    }

    #[test]
    fn a_plan_gives_each_entry_its_seeds_and_its_stages_their_share() {
        let plan: Plan = toml::from_str(PLAN).expect("reads");
        let contenders = plan.contenders(Path::new(""), None).expect("fits");
        let folders: Vec<_> = contenders.iter().map(|c| c.folder.display().to_string()).collect();
        assert_eq!(folders, ["ours-two-stages/seed-1", "ours-two-stages/seed-2", "amp/seed-7"]);
        // 1920 environments and 24 steps are 46,080 samples: 40,000 are one iteration, 60,000 two.
        let iterations: Vec<_> = contenders[1].stages.iter().map(|s| s.run.iterations).collect();
        assert_eq!(iterations, [1, 2]);
        assert_eq!(contenders[1].stages[0].run.seed, 2);
        assert_eq!(contenders[2].stages[0].run.iterations, 3);
        let begun: Plan = toml::from_str(&PLAN.replace("seeds = [7]", "from = \"src\"")).expect("reads");
        let from: Vec<_> =
            begun.contenders(Path::new(""), None).expect("fits").into_iter().map(|c| c.from).collect();
        assert_eq!(from[1..], [None, Some("src".into()), Some("src".into())]);
    }

    #[test]
    fn the_shipped_plans_fit() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../configs/compare");
        for (name, rows) in [("paper.toml", 6), ("short.toml", 7), ("ablations.toml", 20)] {
            let plan = Plan::read(&folder.join(name)).expect(name);
            assert_eq!(plan.contenders(&folder, None).expect(name).len(), rows, "{name}");
        }
    }

    #[test]
    fn a_plan_that_cannot_be_done_is_refused_before_anything_is_trained() {
        let with = |from: &str, to: &str| refused(&PLAN.replace(from, to));
        assert!(with("samples = 100000", "samples = 0").contains("samples: expected at least 1, found 0"));
        assert!(with("trials = 2", "trails = 2").contains("unknown field `trails`"));
        assert!(with("seeds = [1, 2]", "seeds = [1, 1]").contains("each once"));
        assert!(with(r#"name = "AMP""#, r#"name = "ours two stages""#).contains("a name of its own"));
        assert!(with(r#"preset = "amp""#, r#"preset = "amq""#).contains("amq"));
        assert!(
            with(r#"stages = [{ preset = "amp" }]"#, "").contains("either stages or a policy, found AMP")
        );
        let missing = with(r#"stages = [{ preset = "amp" }]"#, r#"policy = "no/such/run""#);
        assert!(missing.contains("expected a run folder or a policy file, found no/such/run"), "{missing}");
        assert!(with(r#"preset = "amp""#, r#"preset = "stage1""#).contains("a last stage with a ball"));
        let both = r#"name = "AMP"
        from = "src"
        policy = "src""#;
        let both = with(r#"name = "AMP""#, both).replace('\n', " ");
        assert!(both.contains("either stages or a policy"), "{both}");
        let missing = with("seeds = [7]", "from = \"no/such/run\"");
        assert!(
            missing.contains("entry.from: expected a run folder or a policy file, found no/such/run"),
            "{missing}"
        );
        assert!(with("share = 0.4", "share = 0.0").contains("above zero"));
    }
}
