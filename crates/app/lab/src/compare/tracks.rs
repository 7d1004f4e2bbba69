//! How policies without a ball follow the clips.

use std::fmt::Write;

use paid_eval::EvalError;
use paid_eval::monitor::Monitor;
use paid_eval::scene::Engines;
use paid_eval::subject::{Subject, SubjectSpec};
use paid_eval::tracking::{self, ClipScore, PAPER_ROWS, TrackingOptions};
use paid_lanes::stats::mean;
use paid_plot::{Table, number};
use serde::{Deserialize, Serialize};

use super::plan::JudgePlan;
use super::report::{Row, samples_text, seed_text};
use crate::compare::Count;

/// How one clip was followed in MuJoCo. The errors are those of the exact start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClipTrack {
    /// Name of the clip.
    pub clip: String,
    /// Its set, such as `standard`: the folder that it lies in.
    pub set: String,
    /// True if the exact start was followed to the end. Errors of a shorter run are those until it ended.
    pub completed: bool,
    /// `[mm]`.
    pub mpjpe_mm: f64,
    /// `[mm]`.
    pub g_mpjpe_mm: f64,
    /// Of the root `[mm/frame]`.
    pub velocity_error_mm: f64,
    /// Time-averaged peak link jerk `[m/frame^3]`.
    pub jerk: f64,
    /// The same of the clip.
    pub reference_jerk: f64,
    /// Peak speed of the kicking foot as a share of the clip's.
    pub foot_speed_share: f64,
    /// Starts with reset noise that were followed to the end.
    pub noisy: Count,
}

impl ClipTrack {
    /// `None` if a stopped evaluation did not get to the exact start.
    fn of(clip: &ClipScore) -> Option<Self> {
        let exact = clip.exact?;
        Some(Self {
            clip: clip.name.clone(),
            set: clip.set.clone(),
            completed: clip.exact_completed?,
            mpjpe_mm: exact.errors.mpjpe_mm,
            g_mpjpe_mm: exact.errors.g_mpjpe_mm,
            velocity_error_mm: exact.errors.velocity_error_mm,
            jerk: exact.jerk,
            reference_jerk: exact.reference_jerk,
            foot_speed_share: exact.foot_speed_share,
            noisy: clip.perturbed_completed.into(),
        })
    }
}

/// The policy of `spec` as its judgment takes it.
pub(super) fn subject(judge: &JudgePlan, spec: &SubjectSpec) -> Result<Subject, EvalError> {
    Subject::load(&SubjectSpec {
        engines: Engines::Mujoco,
        seed: judge.seed,
        fallback_task: "paper_stage1".to_owned(),
        ..spec.clone()
    })
}

/// Follows every clip of `spec` once exactly and from noisy starts, to the end or a fall.
pub(super) fn judge(
    judge: &JudgePlan,
    spec: &SubjectSpec,
    monitor: &Monitor,
) -> Result<Vec<ClipTrack>, EvalError> {
    let mut subject = subject(judge, spec)?;
    subject.setup.monitor = monitor.clone();
    let sets = subject.sets.clone();
    // Policies that drift are measured to the end of the clip as well.
    let options = TrackingOptions { starts: judge.tracking_starts, sets, limits: false };
    let report = tracking::evaluate(&subject.setup, &*subject.maker, &options)?;
    Ok(report.clips.iter().filter_map(ClipTrack::of).collect())
}

/// One policy, or the specialists of one seed: what stands in a line of the table.
struct Method<'a> {
    name: &'a str,
    seed: Option<u64>,
    samples: u64,
    tracks: Vec<&'a ClipTrack>,
}

fn methods(rows: &[Row]) -> Vec<Method<'_>> {
    let mut methods: Vec<Method<'_>> = Vec::new();
    for row in rows.iter().filter(|row| !row.scores.tracks.is_empty()) {
        let samples: u64 = row.scores.samples.iter().sum();
        match methods.iter_mut().find(|m| m.name == row.name && m.seed == row.seed) {
            Some(method) => {
                method.samples += samples;
                method.tracks.extend(&row.scores.tracks);
            }
            None => methods.push(Method {
                name: &row.name,
                seed: row.seed,
                samples,
                tracks: row.scores.tracks.iter().collect(),
            }),
        }
    }
    methods
}

/// A table by set, with the paper's rows below, and one by clip; `None` if no policy follows clips.
pub(super) fn tables(rows: &[Row]) -> Option<String> {
    let methods = methods(rows);
    let first = rows.iter().find(|row| !row.scores.tracks.is_empty())?;
    let sets = once(methods.iter().flat_map(|m| &m.tracks).map(|track| track.set.as_str()));
    let mut by_set = Table::new(&[
        "followed in MuJoCo",
        "set",
        "seed",
        "samples [M]",
        "clips",
        "MPJPE [mm]",
        "G-MPJPE [mm]",
        "velocity [mm/frame]",
        "AUJ",
        "kicking foot's speed",
        "noisy starts to the end",
    ]);
    for set in sets {
        for method in &methods {
            let of_set: Vec<&ClipTrack> =
                method.tracks.iter().copied().filter(|track| track.set == set).collect();
            let all = |f: fn(&ClipTrack) -> f64| mean(of_set.iter().map(|track| f(track)));
            let Some(mpjpe) = all(|t| t.mpjpe_mm) else { continue };
            let value = |f: fn(&ClipTrack) -> f64| all(f).unwrap_or(0.0);
            let noisy = of_set
                .iter()
                .fold([0, 0], |[done, all], track| [done + track.noisy.count, all + track.noisy.trials]);
            by_set.row([
                method.name.to_owned(),
                set.to_owned(),
                seed_text(method.seed),
                samples_text(method.samples),
                of_set.len().to_string(),
                number(mpjpe, 1),
                number(value(|t| t.g_mpjpe_mm), 1),
                number(value(|t| t.velocity_error_mm), 2),
                number((value(|t| t.jerk) - value(|t| t.reference_jerk)).abs(), 4),
                format!("{}%", number(100.0 * value(|t| t.foot_speed_share), 0)),
                format!("{} of {}", noisy[0], noisy[1]),
            ]);
        }
        for paper in PAPER_ROWS.iter().filter(|row| row.set == set) {
            let mut cells: [String; 11] = std::array::from_fn(|_| "-".to_owned());
            cells[0] = format!("{}, the paper's figures", paper.method);
            set.clone_into(&mut cells[1]);
            cells[5] = number(paper.mpjpe_mm, 1);
            cells[6] = number(paper.g_mpjpe_mm, 1);
            cells[7] = number(paper.velocity_error_mm, 2);
            cells[8] = number(paper.auj, 4);
            by_set.row(cells);
        }
    }
    let mut by_clip =
        Table::new(&["clip", "policy", "seed", "MPJPE [mm]", "G-MPJPE [mm]", "foot's speed", "to the end"]);
    let clips = once(methods.iter().flat_map(|m| &m.tracks).map(|track| track.clip.as_str()));
    for clip in clips {
        for method in &methods {
            for track in method.tracks.iter().filter(|track| track.clip == clip) {
                by_clip.row([
                    clip.to_owned(),
                    method.name.to_owned(),
                    seed_text(method.seed),
                    number(track.mpjpe_mm, 1),
                    number(track.g_mpjpe_mm, 1),
                    format!("{}%", number(100.0 * track.foot_speed_share, 0)),
                    format!(
                        "{}, noisy {} of {}",
                        if track.completed { "yes" } else { "no" },
                        track.noisy.count,
                        track.noisy.trials
                    ),
                ]);
            }
        }
    }
    let judge = &first.scores.judge;
    let mut out = format!(
        "MuJoCo, each clip once exactly (errors) and {} times with reset noise, until a fall or the clip's end, seed {}\n\n",
        judge.tracking_starts, judge.seed
    );
    let _ = write!(out, "{by_set}\n{by_clip}");
    Some(out)
}

/// Every name once, in the order in which they come first.
fn once<'a>(names: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut found = Vec::new();
    for name in names {
        if !found.contains(&name) {
            found.push(name);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::super::Scores;
    use super::*;

    fn row(name: &str, clip: &str, set: &str, mpjpe_mm: f64) -> Row {
        let track = ClipTrack {
            clip: clip.to_owned(),
            set: set.to_owned(),
            completed: true,
            mpjpe_mm,
            g_mpjpe_mm: 2.0 * mpjpe_mm,
            velocity_error_mm: 3.0,
            jerk: 0.05,
            reference_jerk: 0.02,
            foot_speed_share: 0.9,
            noisy: Count::of([true, false, true, true]),
        };
        let scores = Scores {
            judge: JudgePlan { tracking_starts: 4, ..JudgePlan::default() },
            samples: vec![20_000_000],
            of: String::new(),
            judgments: Vec::new(),
            panel: None,
            clips: Vec::new(),
            likeness: Vec::new(),
            tracks: vec![track],
        };
        Row { name: name.to_owned(), paper: None, seed: Some(1), scores }
    }

    #[test]
    fn specialists_of_a_seed_are_one_line_of_a_set_and_the_paper_stands_below() {
        let rows = [
            row("One each", "kick-a", "standard", 20.0),
            row("One each", "kick-b", "standard", 30.0),
            row("One each", "kick-c", "stylized", 50.0),
            row("One for all", "kick-a", "standard", 28.0),
        ];
        let text = tables(&rows).expect("trackers");
        let line = |words: &[&str]| {
            let found = text.lines().find(|line| words.iter().all(|word| line.contains(word)));
            found
                .unwrap_or_else(|| panic!("{words:?}: {text}"))
                .split_whitespace()
                .collect::<Vec<_>>()
                .join(" ")
        };
        assert_eq!(
            line(&["One each", "standard"]),
            "One each standard 1 60 2 25.0 50.0 3.00 0.0300 90% 6 of 8"
        );
        assert_eq!(
            line(&["One each", "stylized"]),
            "One each stylized 1 60 1 50.0 100.0 3.00 0.0300 90% 3 of 4"
        );
        assert!(line(&["TWIST2", "standard"]).contains("the paper's figures standard - - - 30.1 162.0 4.40"));
        assert_eq!(line(&["kick-a", "One for all"]), "kick-a One for all 1 28.0 56.0 90% yes, noisy 3 of 4");
        assert!(text.contains("4 times with reset noise"), "{text}");
        assert_eq!(tables(&[]), None);
    }
}
