//! What a policy of a comparison scored.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use paid_eval::EvalError;
use paid_eval::clips::{ClipRow, ClipsOptions};
use paid_eval::likeness::{self, Likeness, load_clips};
use paid_eval::monitor::Monitor;
use paid_eval::panel::{self, PanelOptions};
use paid_eval::scene::Engines;
use paid_eval::shooting::{self, CellScore, ROLLING_SPEED, ShootingOptions};
use paid_eval::subject::{PolicySource, Subject, SubjectSpec};
use paid_task::preset::KnowledgeMode;
use serde::{Deserialize, Serialize};

use super::films;
use super::plan::JudgePlan;
use super::tracks::{self, ClipTrack};
use crate::compare::Count;

/// The sensors of `perceived` scores, the same for every policy, however it was trained: 30 images per second, 60 ms late, a noise of the
/// paper's form, odometry that drifts by 1 cm and 0.23 degrees a second.
pub const EYES: [&str; 7] = [
    "eyes.rate_hz=[30,30]",
    "eyes.latency_s=[0.06,0.06]",
    "eyes.dropout=[0.05,0.05]",
    "eyes.noise_scale=[1,1]",
    "eyes.odometry.offset_m=[0.01,0.01]",
    "eyes.odometry.drift_m_s=[0.01,0.01]",
    "eyes.odometry.heading_drift_deg_s=[0.23,0.23]",
];

/// Shots of one kind of ball.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shots {
    /// Goals.
    pub goals: Count,
    /// Shots in which the ball was touched.
    pub contacts: Count,
    /// Falls at any time.
    pub falls: Count,
    /// Mean cosine over the contacts.
    pub accuracy: Option<f64>,
    /// Mean outgoing ball speed over the contacts `[m/s]`.
    pub ball_speed: Option<f64>,
}

impl Shots {
    fn of(score: &CellScore) -> Self {
        Self {
            goals: score.success.into(),
            contacts: score.contact.into(),
            falls: score.falls_ever.into(),
            accuracy: score.accuracy,
            ball_speed: score.ball_speed,
        }
    }
}

/// Shots with one kind of knowledge.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Judgment {
    /// What the policy was given.
    pub knowledge: KnowledgeMode,
    /// Balls that lie still.
    pub fixed: Shots,
    /// Balls that roll.
    pub rolling: Shots,
}

/// Shares of goals over the panel of balls and grounds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PanelScore {
    /// Mean.
    pub mean: f64,
    /// The least.
    pub worst: f64,
    /// Whose it is.
    pub worst_ball: String,
}

/// Shots with one clip, the ball near the clip's own place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClipShots {
    /// Name of the clip.
    pub clip: String,
    /// Their outcomes.
    pub shots: Shots,
    /// How far off the clip the bodies were relative to the root, mean over the shots `[mm]`; `None` in older scores, which lack it.
    #[serde(default)]
    pub mpjpe_mm: Option<f64>,
    /// The same with the roots starting at one point `[mm]`: the way to the ball is in it. `None` in older scores, which lack it.
    #[serde(default)]
    pub g_mpjpe_mm: Option<f64>,
}

/// Everything about one policy.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scores {
    /// How it was scored.
    pub judge: JudgePlan,
    /// Training samples of each stage; empty for a policy that was there.
    pub samples: Vec<u64>,
    /// Which policy and which clips they are of ([`Contender::print`](super::Contender::print)); empty in older scores, which do not say.
    #[serde(default)]
    pub of: String,
    /// One for each knowledge of the plan; none of a policy that follows clips without a ball.
    pub judgments: Vec<Judgment>,
    /// If the plan requests it.
    pub panel: Option<PanelScore>,
    /// Shots with each clip; empty unless the plan requests them.
    #[serde(default)]
    pub clips: Vec<ClipShots>,
    /// How the kicks compare with the clips: the clips themselves, then the policy; empty unless the plan requests it.
    #[serde(default)]
    pub likeness: Vec<Likeness>,
    /// How each clip is followed, of a policy that follows clips without a ball.
    #[serde(default)]
    pub tracks: Vec<ClipTrack>,
}

/// The policy of `spec` as a judgment of its shots takes it.
pub(super) fn subject(
    judge: &JudgePlan,
    spec: &SubjectSpec,
    knowledge: KnowledgeMode,
) -> Result<Subject, EvalError> {
    let overrides = match knowledge {
        KnowledgeMode::Truth => Vec::new(),
        KnowledgeMode::Perceived => EYES.map(str::to_owned).into(),
    };
    let subject = Subject::load(&SubjectSpec {
        knowledge: Some(knowledge),
        overrides,
        engines: Engines::Mujoco,
        seed: judge.seed,
        ..spec.clone()
    })?;
    subject.require_ball()?;
    Ok(subject)
}

/// The clips that kicks are compared with: those that the shots of `spec` are made with.
pub(super) fn clips_folder(spec: &SubjectSpec) -> Result<PathBuf, EvalError> {
    match &spec.motions {
        Some(folder) => Ok(folder.clone()),
        None => PolicySource::read(&spec.policy)?.motions_here(),
    }
}

impl Scores {
    /// Earlier scores, if they were made the same way, after the same number of samples, and are `of` the same policy and clips as far as they state it.
    ///
    /// # Errors
    /// If the file cannot be read, or is none of these.
    pub fn read(
        path: &Path,
        judge: &JudgePlan,
        samples: &[u64],
        of: &str,
    ) -> Result<Option<Self>, EvalError> {
        let text = match fs::read_to_string(path) {
            Ok(text) => text,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(paid_files::FileError::at(path)(error).into()),
        };
        let scores: Self = serde_json::from_str(&text).map_err(|error| EvalError::Format {
            path: path.to_owned(),
            expected: "scores of a comparison",
            found: error.to_string(),
        })?;
        let same = |scores: &Self| {
            let is_of = scores.of.is_empty() || scores.of == of;
            is_of && scores.judge == *judge && scores.samples == samples
        };
        Ok(Some(scores).filter(same))
    }

    /// There are no scores yet.
    fn empty(judge: &JudgePlan, samples: &[u64]) -> Self {
        Self {
            judge: judge.clone(),
            samples: samples.to_vec(),
            of: String::new(),
            judgments: Vec::new(),
            panel: None,
            clips: Vec::new(),
            likeness: Vec::new(),
            tracks: Vec::new(),
        }
    }

    /// Scores in MuJoCo how a policy without a ball follows each clip; `None` if `monitor` was stopped.
    ///
    /// # Errors
    /// As [`Scores::judge`].
    pub fn track(
        judge: &JudgePlan,
        spec: &SubjectSpec,
        samples: &[u64],
        monitor: &Monitor,
    ) -> Result<Option<Self>, EvalError> {
        let tracks = tracks::judge(judge, spec, monitor)?;
        Ok((!monitor.stopped()).then(|| Self { tracks, ..Self::empty(judge, samples) }))
    }

    /// Scores a policy's shots in MuJoCo; `None` if `monitor` was stopped. `spec` names policy, motions, threads and so on. Film
    /// strips of a typical shot and of a typical failure go to `folder`.
    ///
    /// # Errors
    /// If the policy cannot be read or does not fit, MuJoCo is missing, or a strip cannot be written.
    pub fn judge(
        judge: &JudgePlan,
        spec: &SubjectSpec,
        samples: &[u64],
        folder: &Path,
        monitor: &Monitor,
    ) -> Result<Option<Self>, EvalError> {
        let load = |knowledge| -> Result<Subject, EvalError> {
            let mut subject = subject(judge, spec, knowledge)?;
            subject.setup.monitor = monitor.clone();
            Ok(subject)
        };
        let shots = |trials, rolling| ShootingOptions {
            grid: judge.grid(),
            trials,
            limit_s: judge.limit_s,
            rolling,
            ..ShootingOptions::default()
        };
        let mut judgments = Vec::new();
        for &knowledge in &judge.knowledge {
            let subject = load(knowledge)?;
            let run =
                |rolling| shooting::evaluate(&subject.setup, &*subject.maker, &shots(judge.trials, rolling));
            let fixed = run(None)?;
            if judgments.is_empty() && !monitor.stopped() {
                films::write(&subject, &fixed, folder)?;
            }
            let rolling = Shots::of(&run(Some(ROLLING_SPEED))?.total);
            judgments.push(Judgment { knowledge, fixed: Shots::of(&fixed.total), rolling });
        }
        let mut panel = None;
        if judge.panel_trials > 0 {
            let subject = load(KnowledgeMode::Truth)?;
            let options = PanelOptions {
                grid: judge.grid(),
                trials: judge.panel_trials,
                balls: vec![None],
                limit_s: judge.limit_s,
                ..PanelOptions::default()
            };
            let report = panel::evaluate(&subject.setup, &subject.scene, &*subject.maker, &options)?;
            let part = report.parts.first();
            panel = part
                .and_then(|part| Some((part.mean?, part.worst?)))
                .map(|(mean, (worst, ball))| PanelScore { mean, worst, worst_ball: ball.to_owned() });
        }
        let mut clips = Vec::new();
        if judge.clip_trials > 0 {
            let subject = load(KnowledgeMode::Truth)?;
            // A policy without a reference has no clip to shoot with.
            if !subject.setup.library.is_standing() {
                let options = ClipsOptions {
                    trials: judge.clip_trials,
                    limit_s: judge.limit_s,
                    ..ClipsOptions::default()
                };
                let report = paid_eval::clips::evaluate(&subject.setup, &*subject.maker, &options)?;
                let row = |row: &ClipRow| ClipShots {
                    clip: row.motion.clone(),
                    shots: Shots::of(&row.score),
                    mpjpe_mm: Some(row.errors.mpjpe_mm),
                    g_mpjpe_mm: Some(row.errors.g_mpjpe_mm),
                };
                clips = report.rows.iter().map(row).collect();
            }
        }
        let mut likeness = Vec::new();
        if judge.likeness_trials > 0 {
            let subject = load(KnowledgeMode::Truth)?;
            let clips = load_clips(&clips_folder(spec)?, &subject.setup)?;
            let options = shots(judge.likeness_trials, None);
            let report = likeness::evaluate(&subject.setup, &*subject.maker, &clips, "the policy", &options)?;
            likeness = report.rows;
        }
        if monitor.stopped() {
            return Ok(None);
        }
        Ok(Some(Self { judgments, panel, clips, likeness, ..Self::empty(judge, samples) }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scores_of_another_policy_or_of_other_clips_are_not_taken() {
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("scores.json");
        let judge = JudgePlan::default();
        let scores = Scores { of: "policy 1, clips 2".into(), ..Scores::empty(&judge, &[5]) };
        let write = |scores: &Scores| {
            fs::write(&path, serde_json::to_string(scores).expect("JSON")).expect("writes");
        };
        let read = |samples: &[u64], of: &str| Scores::read(&path, &judge, samples, of).expect("reads");
        assert_eq!(read(&[5], ""), None, "there are none");
        write(&scores);
        assert_eq!(read(&[5], "policy 1, clips 2").as_ref(), Some(&scores));
        assert_eq!(read(&[6], "policy 1, clips 2"), None);
        assert_eq!(read(&[5], "policy 3, clips 2"), None);
        assert_eq!(read(&[5], "policy 1, clips 4"), None);
        // Older ones do not say.
        let older = Scores { of: String::new(), ..scores };
        write(&older);
        assert_eq!(read(&[5], "policy 3, clips 2"), Some(older));
    }

    #[test]
    fn kicks_are_compared_with_the_clips_of_the_shots() {
        let policies = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../policies");
        let spec = SubjectSpec::new(policies.join("demo/policy.onnx"));
        let asked = SubjectSpec { motions: Some("asked".into()), ..spec.clone() };
        assert_eq!(clips_folder(&asked).expect("asked"), PathBuf::from("asked"));
        assert_eq!(clips_folder(&spec).expect("its own: the built-in kicks"), PathBuf::new());
        // Clips that its shots need and that are not here are not replaced by others.
        let other = SubjectSpec::new(policies.join("paid13/policy.onnx"));
        let error = clips_folder(&other).expect_err("not here").to_string();
        assert!(error.contains("expected their folder, found none"), "{error}");
    }
}
