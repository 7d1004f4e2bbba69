//! The policies that a plan asks for.

use std::path::{Path, PathBuf};

use paid_motion::motion_files;
use paid_train::RunPreset;

use super::plan::{Entry, Plan, wrong};
use crate::EvalError;

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
    /// True: judged by how it follows the clips.
    pub tracks: bool,
    /// The clip's file, of a specialist.
    pub clip: Option<PathBuf>,
}

impl Contender {
    /// What tells it from others of its name: the seed and, of a specialist, the clip.
    pub fn suffix(&self) -> String {
        let clip = self
            .clip
            .as_deref()
            .and_then(Path::file_stem)
            .map(|clip| format!(", {}", clip.to_string_lossy()));
        let seed = self.seed.map(|seed| format!(", seed {seed}"));
        [seed, clip].into_iter().flatten().collect()
    }
}

impl Plan {
    /// Everything that is to be trained and judged, checked before any of it begins. `folder` is the plan's, and `motions` changes
    /// where the clips lie.
    ///
    /// # Errors
    /// The first part of the plan that cannot be done.
    pub fn contenders(&self, folder: &Path, motions: Option<&str>) -> Result<Vec<Contender>, EvalError> {
        self.check()?;
        let mut contenders: Vec<Contender> = Vec::new();
        let left_out = self.left_out(folder);
        for entry in self.entries.iter().filter(|e| !left_out.iter().any(|(name, _)| *name == e.name)) {
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
                tracks: entry.tracks,
                clip: None,
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
                        let tracks = stages.last().is_some_and(|last| !last.task.scene.ball);
                        let folder = PathBuf::from(&slug).join(format!("seed-{seed}"));
                        let whole =
                            Contender { stages, folder, tracks, from: from.clone(), ..new(Some(seed)) };
                        if entry.specialists {
                            contenders.extend(specialists(&whole, &entry.clips)?);
                        } else {
                            contenders.push(whole);
                        }
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
        self.check_trackers(&contenders)?;
        Ok(contenders)
    }

    /// How policies without a ball are judged must be said, and only they can be specialists.
    fn check_trackers(&self, contenders: &[Contender]) -> Result<(), EvalError> {
        if let Some(tracker) = contenders.iter().find(|c| c.tracks && self.judge.tracking_starts == 0) {
            let expected = "above 0 for a policy without a ball, or a last stage with a ball";
            return Err(wrong("judge.tracking_starts", expected, &tracker.name));
        }
        if let Some(shooter) = contenders.iter().find(|c| c.clip.is_some() && !c.tracks) {
            return Err(wrong("entry.specialists", "stages without a ball", &shooter.name));
        }
        if let Some(entry) = self.entries.iter().find(|e| !e.clips.is_empty() && !e.specialists) {
            return Err(wrong("entry.clips", "specialists = true", &entry.name));
        }
        if let Some(entry) = self.entries.iter().find(|e| e.specialists && e.policy.is_some()) {
            return Err(wrong("entry.specialists", "stages to train them with", &entry.name));
        }
        if let Some(entry) = self.entries.iter().find(|e| e.tracks && e.policy.is_none()) {
            return Err(wrong(
                "entry.tracks",
                "a policy; of stages the last one's task says it",
                &entry.name,
            ));
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
            let samples = entry.samples.unwrap_or(self.samples) as f64 * stage.share / total;
            preset.run.iterations = (samples / per_iteration).ceil() as u64;
            stages.push(preset);
        }
        Ok(stages)
    }
}

/// `whole` once for each clip of its motions, or for each of `names`.
fn specialists(whole: &Contender, names: &[String]) -> Result<Vec<Contender>, EvalError> {
    let folder = whole.stages.first().map_or("", |stage| stage.run.motions.as_str());
    if folder.is_empty() {
        return Err(wrong("entry.specialists", "a folder of motion files (--motions)", "the built-in kicks"));
    }
    let files = motion_files(Path::new(folder))?;
    let stem = |file: &Path| file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    if let Some(name) = names.iter().find(|name| !files.iter().any(|file| stem(file) == **name)) {
        let found = files.iter().map(|file| stem(file)).collect::<Vec<_>>().join(", ");
        return Err(wrong("entry.clips", &format!("clips of {folder}: {found}"), name));
    }
    let chosen = files.iter().filter(|file| names.is_empty() || names.contains(&stem(file)));
    let of_clip = |file: &PathBuf| {
        let mut contender = whole.clone();
        for stage in &mut contender.stages {
            stage.run.motions = file.display().to_string();
        }
        contender.folder.push(slug(&stem(file)));
        Contender { clip: Some(file.clone()), ..contender }
    };
    Ok(chosen.map(of_clip).collect())
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
        let own = PLAN.replace("seeds = [7]", "seeds = [7]\n        samples = 50000");
        let own: Plan = toml::from_str(&own).expect("reads");
        let own = own.contenders(Path::new(""), None).expect("fits");
        let iterations: Vec<_> =
            own.iter().map(|c| c.stages.iter().map(|s| s.run.iterations).sum::<u64>()).collect();
        assert_eq!(iterations, [3, 3, 2]);
        let begun: Plan = toml::from_str(&PLAN.replace("seeds = [7]", "from = \"src\"")).expect("reads");
        let from: Vec<_> =
            begun.contenders(Path::new(""), None).expect("fits").into_iter().map(|c| c.from).collect();
        assert_eq!(from[1..], [None, Some("src".into()), Some("src".into())]);
    }

    #[test]
    fn an_optional_entry_without_its_file_is_left_out_and_named() {
        let plan = |policy: &str| -> Plan {
            let entry = format!("policy = \"{policy}\"\n        optional = true");
            toml::from_str(&PLAN.replace(r#"stages = [{ preset = "amp" }]"#, &entry)).expect("reads")
        };
        let names = |plan: &Plan| -> Vec<String> {
            plan.contenders(Path::new(""), None).expect("fits").into_iter().map(|c| c.name).collect()
        };
        let absent = plan("no/such/tracker.onnx");
        assert_eq!(names(&absent), ["Ours (two stages)"; 2]);
        assert_eq!(absent.left_out(Path::new("x")), [("AMP", "x/no/such/tracker.onnx".into())]);
        let there = plan("src");
        assert_eq!(names(&there), ["Ours (two stages)", "Ours (two stages)", "AMP"]);
        assert_eq!(there.left_out(Path::new("")), []);
    }

    #[test]
    fn the_shipped_plans_fit() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../configs/compare");
        for (name, rows) in [
            ("paper.toml", 8),
            ("short.toml", 7),
            ("ablations.toml", 32),
            ("fewer_samples.toml", 11),
            ("environments.toml", 5),
            ("mirror.toml", 2),
            ("stage2_tries.toml", 5),
            ("iterations.toml", 4),
            ("iterations_stage2.toml", 3),
        ] {
            let plan = Plan::read(&folder.join(name)).expect(name);
            assert_eq!(plan.contenders(&folder, None).expect(name).len(), rows, "{name}");
        }
        // Its specialists need clips, which are not in the repository; all else fits.
        let plan = Plan::read(&folder.join("trackers.toml")).expect("reads");
        let error = plan.contenders(&folder, None).expect_err("no clips").to_string();
        assert!(error.contains("found the built-in kicks"), "{error}");
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
        let tracker = with(r#"preset = "amp""#, r#"preset = "stage1""#);
        assert!(
            tracker.contains("judge.tracking_starts") && tracker.contains("a last stage with a ball"),
            "{tracker}"
        );
        let shooter = with("seeds = [7]", "seeds = [7]\n        specialists = true");
        assert!(shooter.contains("expected a folder of motion files (--motions), found the built-in kicks"));
        let tracks = with("seeds = [7]", "seeds = [7]\n        tracks = true");
        assert!(tracks.contains("entry.tracks: expected a policy"), "{tracks}");
        let clips = with("seeds = [7]", "seeds = [7]\n        clips = [\"a\"]");
        assert!(clips.contains("entry.clips: expected specialists = true, found AMP"), "{clips}");
        let none = with("seeds = [7]", "seeds = [7]\n        samples = 0");
        assert!(none.contains("entry.samples: expected at least 1, found 0 in 'AMP'"), "{none}");
        let spent = with(r#"stages = [{ preset = "amp" }]"#, "policy = \"src\"\n        samples = 5");
        assert!(spent.contains("entry.samples: expected stages to spend them on, found AMP"), "{spent}");
        let trained = with("seeds = [7]", "seeds = [7]\n        optional = true");
        assert!(trained.contains("entry.optional: expected a policy whose file may be missing"), "{trained}");
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
