//! A typical shot and a typical failure of a policy of a comparison, as film strips.

use std::fs;
use std::io::ErrorKind;
use std::path::Path;

use paid_eval::EvalError;
use paid_eval::results::to_json;
use paid_eval::shooting::{Outcome, ShootingReport};
use paid_eval::subject::Subject;
use paid_eval::worst::{StripFile, again};
use paid_files::{FileError, write_whole};

/// List of the strips in a policy's folder.
const STRIPS: &str = "strips.json";
/// The same for all policies, next to the comparison's table.
const ALL_STRIPS: &str = "comparison_strips.json";

/// What went wrong in a shot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Cause {
    Fell,
    Unmet,
    Short,
    Past,
}

const CAUSES: [(Cause, &str); 4] = [
    (Cause::Fell, "falls before the clip's end"),
    (Cause::Unmet, "balls that were not touched"),
    (Cause::Short, "balls short of the goal"),
    (Cause::Past, "balls past a post"),
];

/// `None` of a goal on the feet.
fn cause(shot: &Outcome) -> Option<Cause> {
    match shot.lateral_m {
        _ if shot.fell_in_clip => Some(Cause::Fell),
        _ if !shot.contact => Some(Cause::Unmet),
        _ if shot.goal => None,
        Some(_) => Some(Cause::Past),
        None => Some(Cause::Short),
    }
}

/// Number of the shot in the middle by `value`, the lower one of two.
fn median(shots: &[Outcome], value: impl Fn(&Outcome) -> Option<f64>) -> Option<usize> {
    let mut order: Vec<(f64, usize)> =
        shots.iter().enumerate().filter_map(|(k, shot)| Some((value(shot)?, k))).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    Some(order.get(order.len().checked_sub(1)? / 2)?.1)
}

/// Names of strips, numbers of their shots and what they stand for: of all balls that came to the goal the one that passed its middle at the
/// median distance; and of the most frequent failure the shot in the middle, by that distance or else by how long the shot lasted.
fn chosen(shots: &[Outcome]) -> Vec<(&'static str, usize, String)> {
    let mut found = Vec::new();
    let distance = |shot: &Outcome| shot.lateral_m.filter(|_| shot.contact).map(f64::abs);
    if let Some(shot) = median(shots, distance) {
        let came = shots.iter().filter(|shot| distance(shot).is_some()).count();
        found.push((
            "typical",
            shot,
            format!("typical of {came} of {} balls that reached the goal", shots.len()),
        ));
    }
    let count = |wanted: Cause| shots.iter().filter(|shot| cause(shot) == Some(wanted)).count();
    // Of causes that are equally frequent the first.
    if let Some((most, words)) = CAUSES.into_iter().rev().max_by_key(|(cause, _)| count(*cause))
        && let Some(shot) = median(shots, |shot| {
            let of_cause = cause(shot) == Some(most);
            of_cause.then(|| {
                if most == Cause::Past { distance(shot).unwrap_or(0.0) } else { f64::from(shot.steps) }
            })
        })
    {
        found.push((
            "failure",
            shot,
            format!("the most frequent failure, {} {words} of {}", count(most), shots.len()),
        ));
    }
    found
}

/// Plays both shots of a report again and writes them into `folder`.
pub(super) fn write(subject: &Subject, report: &ShootingReport, folder: &Path) -> Result<(), EvalError> {
    let chosen = chosen(&report.trials);
    let wanted: Vec<usize> = chosen.iter().map(|(_, shot, _)| *shot).collect();
    let strips = again(&subject.setup, &*subject.maker, report, &wanted)?;
    let mut files = Vec::new();
    for ((name, _, what), strip) in chosen.iter().zip(&strips) {
        let picture = format!("{name}.png");
        strip.picture.save(&folder.join(&picture))?;
        files.push(StripFile { picture, words: format!("{what}: {}", strip.words) });
    }
    Ok(write_whole(&folder.join(STRIPS), to_json(&files)?.as_bytes())?)
}

/// Lists the strips of all policies for the page of the comparison in `out`: of each its name and its folder below `out`. A policy that was
/// scored by an earlier version has none.
///
/// # Errors
/// If a list cannot be read or written.
pub fn gather<'a>(out: &Path, policies: impl Iterator<Item = (String, &'a Path)>) -> Result<(), EvalError> {
    let mut all: Vec<StripFile> = Vec::new();
    for (name, folder) in policies {
        let path = out.join(folder).join(STRIPS);
        let text = match fs::read_to_string(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == ErrorKind::NotFound => continue,
            Err(error) => return Err(FileError::at(&path)(error).into()),
        };
        let files: Vec<StripFile> = serde_json::from_str(&text).map_err(|error| EvalError::Format {
            path,
            expected: "a list of film strips",
            found: error.to_string(),
        })?;
        all.extend(files.into_iter().map(|file| StripFile {
            picture: folder.join(file.picture).display().to_string(),
            words: format!("{name}, {}", file.words),
        }));
    }
    Ok(write_whole(&out.join(ALL_STRIPS), to_json(&all)?.as_bytes())?)
}

#[cfg(test)]
mod tests {
    use paid_eval::shooting::Trial;

    use super::*;

    /// A shot that ends on its feet; `None` of a ball that came short.
    fn shot(lateral_m: Option<f64>) -> Outcome {
        let goal = lateral_m.is_some_and(|x| x.abs() < 1.0);
        Outcome {
            trial: Trial {
                place: [1.0, 0.0],
                repeat: 0,
                displacement: [0.0; 2],
                ball: [1.0, 0.0],
                ball_velocity: [0.0; 2],
                goal: [5.0, 0.0],
                motion: 0,
            },
            motion_name: "kick".to_owned(),
            contact: true,
            correct_foot: true,
            body: None,
            foot_contact: true,
            foot: Some(0),
            kick_time_s: Some(2.0),
            foot_speed: Some(5.0),
            goal,
            lateral_m,
            goal_time_s: None,
            plane_speed: None,
            torque_saturation: 0.25,
            cosine: Some(1.0),
            ball_speed: Some(4.0),
            ball_rise: None,
            peak_ball_speed: 4.5,
            fell_after_kick: false,
            fell: false,
            fell_in_clip: false,
            fell_within: Some(goal),
            steps: 300,
            path: Vec::new(),
        }
    }

    #[test]
    fn the_typical_shot_is_the_median_and_the_failure_is_of_the_most_frequent_kind() {
        let fallen = |steps| Outcome { fell_in_clip: true, steps, ..shot(None) };
        let shots = [
            shot(Some(-0.9)), // 0.1, 0.2, 0.3, 0.9, 1.5: the middle is 0.3.
            shot(Some(0.1)),
            shot(Some(-0.3)),
            shot(Some(0.2)),
            shot(Some(1.5)),
            fallen(50),
            fallen(30),
            fallen(40),
            shot(None),
        ];
        let told = |shots: &[Outcome]| -> Vec<(&str, usize)> {
            chosen(shots).into_iter().map(|(name, shot, _)| (name, shot)).collect()
        };
        assert_eq!(told(&shots), [("typical", 2), ("failure", 7)]);
        let words = &chosen(&shots)[1].2;
        assert_eq!(words, "the most frequent failure, 3 falls before the clip's end of 9");
        // One of each: the first kind.
        assert_eq!(told(&shots[4..6]), [("typical", 0), ("failure", 1)]);
        // Goals only; no ball at all.
        assert_eq!(told(&shots[..4]), [("typical", 3)]);
        assert_eq!(told(&shots[5..8]), [("failure", 2)]);
        assert_eq!(told(&[]), []);
    }

    #[test]
    fn a_policy_without_strips_is_left_out_of_the_list() {
        let out = tempfile::tempdir().expect("folder");
        fs::create_dir_all(out.path().join("amp/seed-1")).expect("made");
        let list = r#"[{"picture": "typical.png", "words": "a goal"}]"#;
        fs::write(out.path().join("amp/seed-1").join(STRIPS), list).expect("writes");
        let policies =
            [("AMP, seed 1".to_owned(), Path::new("amp/seed-1")), ("Ours".to_owned(), Path::new("ours"))];
        gather(out.path(), policies.into_iter()).expect("gathers");
        let found: Vec<StripFile> =
            serde_json::from_str(&fs::read_to_string(out.path().join(ALL_STRIPS)).expect("a list"))
                .expect("JSON");
        let expected =
            StripFile { picture: "amp/seed-1/typical.png".into(), words: "AMP, seed 1, a goal".into() };
        assert_eq!(found, [expected]);
    }
}
