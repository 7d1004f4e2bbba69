//! The policies of a plan.

use std::path::{Path, PathBuf};

use paid_eval::EvalError;
use paid_motion::motion_files;
use paid_train::RunPreset;

use super::origin::Origin;
use super::plan::{Entry, Plan, wrong};

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
    /// What the first stage starts from.
    pub from: Option<PathBuf>,
    /// What there is.
    pub policy: Option<PathBuf>,
    /// True: scored by how closely it follows the clips.
    pub tracks: bool,
    /// The clip's file, of a specialist.
    pub clip: Option<PathBuf>,
}

impl Contender {
    /// What its training starts from; `None` for an existing policy.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn origin(&self) -> Result<Option<Origin>, EvalError> {
        let Some(last) = self.stages.last() else { return Ok(None) };
        Origin::of(self.from.as_deref(), Path::new(&last.run.motions)).map(Some)
    }

    /// What distinguishes it from others of its name: the seed and, for a specialist, the clip.
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
    /// Everything that is to be trained and scored, checked before any of it starts. `folder` is the plan's, and `motions` changes
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
            if slug.is_empty() {
                return Err(wrong(
                    "entry.name",
                    "letters or digits, as its folder has this name",
                    &entry.name,
                ));
            }
            if contenders.iter().any(|c| c.folder.starts_with(&slug)) {
                return Err(wrong("entry.name", "a different name for each entry", &entry.name));
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
                    return Err(wrong("entry.from", "stages that start from it", &entry.name));
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
        check_folders(&contenders)?;
        Ok(contenders)
    }

    /// Policies without a ball need `tracks`, and only they can be specialists.
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
                "a policy; for stages the last stage's task decides it",
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
            let mut sets: Vec<String> =
                self.sets.iter().chain(&entry.sets).chain(&stage.sets).cloned().collect();
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

/// Two stages in one folder would be taken for each other.
fn check_folders(contenders: &[Contender]) -> Result<(), EvalError> {
    let mut taken: Vec<PathBuf> = Vec::new();
    for contender in contenders {
        for stage in &contender.stages {
            let folder = contender.folder.join(&stage.stage);
            if taken.contains(&folder) {
                let expected = "a different folder for each stage; name one with sets = ['stage=\"NAME\"'], or the clip's file otherwise";
                let found = format!("{} twice in '{}'", folder.display(), contender.name);
                return Err(wrong("entry.stages", expected, &found));
            }
            taken.push(folder);
        }
    }
    Ok(())
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
