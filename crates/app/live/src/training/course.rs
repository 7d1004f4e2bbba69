//! The curves of a training, from the log in its run folder.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use paid_train::folder::METRICS_FILE;
use paid_train::{Comparer, Comparison, PublishedRun};
use serde::Serialize;
use serde_json::Value;

/// Points of a curve at most: each is the mean of its neighbors.
const POINTS: usize = 240;

/// Title, unit, and the keys in a record of the log.
type Title = (&'static str, &'static str, &'static [&'static str]);

/// What is looked at while the robot learns to follow.
const FOLLOWS: [Title; 6] = [
    ("error of the bodies", "m", &["metrics", "error_body_pos"]),
    ("reward of an episode", "", &["mean_reward"]),
    ("peak speed of the kicking foot", "m/s", &["metrics", "kick_foot_peak"]),
    ("length of an episode", "control steps", &["mean_episode_length"]),
    ("fell or lost the motion", "share of episodes", ENDED_EARLY),
    ("samples a second", "", &["samples_per_s"]),
];

/// What is looked at while it learns to kick.
const KICKS: [Title; 6] = [
    ("shots on target", "share of episodes", &["metrics", "kick/on_target"]),
    ("speed of the kicked ball", "m/s", &["metrics", "kick/ball_speed"]),
    ("fell or lost the motion", "share of episodes", ENDED_EARLY),
    ("length of an episode", "control steps", &["mean_episode_length"]),
    ("reward of an episode", "", &["mean_reward"]),
    ("samples a second", "", &["samples_per_s"]),
];

/// Stands for all ends but those in [`IN_TIME`].
const ENDED_EARLY: &[&str] = &["terminations"];
const IN_TIME: [&str; 2] = ["motion_end", "time_out"];

/// An iteration: samples [million], and the figures of its stage; NaN where the log has none.
type Row = (u64, f64, [f64; 6]);

/// The log of a run, as far as it was read.
#[derive(Debug)]
pub(super) struct Course {
    path: PathBuf,
    /// Bytes that were read.
    read: u64,
    /// The beginning of a line that was not whole yet.
    rest: String,
    rows: Vec<Row>,
    /// The last record.
    last: Value,
    comparer: Comparer,
    comparison: Option<Comparison>,
}

#[derive(Serialize)]
struct Curve {
    title: &'static str,
    unit: &'static str,
    /// Samples [million], value.
    points: Vec<[f64; 2]>,
    /// The same of the published run, if there is one of this stage.
    published: Vec<[f64; 2]>,
}

/// The message to the page.
#[derive(Serialize)]
struct Told<'a> {
    kind: &'static str,
    stage: &'a str,
    iteration: u64,
    /// 0: only time limits it.
    iterations: u64,
    samples: u64,
    elapsed_s: f64,
    eta_s: f64,
    /// Iterations that the policy on the page has learned; `None`: there is none yet.
    playing: Option<u64>,
    /// How the run stands next to the published one, in words.
    standing: Option<String>,
    curves: Vec<Curve>,
}

/// A task with a ball logs how far the balls have spread, whatever its stage is called.
fn titles(record: &Value) -> &'static [Title; 6] {
    if record["metrics"].get("kick/reach").is_none() { &FOLLOWS } else { &KICKS }
}

fn figure(record: &Value, path: &[&str]) -> Option<f64> {
    let value = path.iter().try_fold(record, |value, key| value.get(key))?;
    let Some(ends) = value.as_object() else { return value.as_f64() };
    let early = ends.iter().filter(|(cause, _)| !IN_TIME.contains(&cause.as_str()));
    // Without an ended episode there is no share.
    (record["episodes"].as_u64() != Some(0)).then(|| early.filter_map(|(_, share)| share.as_f64()).sum())
}

impl Course {
    /// Of a run folder, which need not be there yet.
    pub fn of(run: &Path) -> Self {
        Self {
            path: run.join(METRICS_FILE),
            read: 0,
            rest: String::new(),
            rows: Vec::new(),
            last: Value::Null,
            comparer: Comparer::default(),
            comparison: None,
        }
    }

    /// Reads what the log has more than before; true if that is a record or more. A log that cannot be read has nothing new.
    pub fn read(&mut self) -> bool {
        let Some(added) = self.added() else { return false };
        self.rest.push_str(&added);
        let text = std::mem::take(&mut self.rest);
        let whole = text.rfind('\n').map_or(0, |end| end + 1);
        text[whole..].clone_into(&mut self.rest);
        let before = self.rows.len();
        for record in text[..whole].lines().filter_map(|line| serde_json::from_str(line).ok()) {
            self.take(record);
        }
        self.rows.len() != before
    }

    fn added(&mut self) -> Option<String> {
        let mut file = File::open(&self.path).ok()?;
        let length = file.metadata().ok()?.len();
        if length < self.read {
            // A resumed run has dropped the iterations after its checkpoint.
            (self.read, self.rest) = (0, String::new());
            self.rows.clear();
        }
        if length == self.read {
            return None;
        }
        file.seek(SeekFrom::Start(self.read)).ok()?;
        let mut bytes = Vec::new();
        self.read += file.take(length - self.read).read_to_end(&mut bytes).ok()? as u64;
        Some(String::from_utf8_lossy(&bytes).into_owned())
    }

    fn take(&mut self, record: Value) {
        let (Some(iteration), Some(samples)) = (record["iteration"].as_u64(), record["samples"].as_f64())
        else {
            return;
        };
        while self.rows.last().is_some_and(|(last, ..)| *last >= iteration) {
            self.rows.pop();
        }
        let figures = titles(&record).map(|(.., path)| figure(&record, path).unwrap_or(f64::NAN));
        self.rows.push((iteration, 1e-6 * samples, figures));
        let stage = record["stage"].as_str().unwrap_or("");
        let metric = |name: &str| record["metrics"].get(name).and_then(Value::as_f64);
        self.comparison = self.comparer.take(stage, samples as u64, metric);
        self.last = record;
    }

    /// The curves for the page (JSON); `playing`: iterations that its policy has learned.
    pub fn json(&self, playing: Option<u64>) -> Result<String, serde_json::Error> {
        let curves = titles(&self.last).iter().enumerate();
        let stage = self.last["stage"].as_str().unwrap_or("");
        let published = PublishedRun::of(stage);
        let number = |key: &str| self.last[key].as_f64().unwrap_or(0.0);
        let whole = |key: &str| self.last[key].as_u64().unwrap_or(0);
        serde_json::to_string(&Told {
            kind: "training",
            stage,
            iteration: whole("iteration"),
            iterations: whole("iterations"),
            samples: whole("samples"),
            elapsed_s: number("elapsed_s"),
            eta_s: number("eta_s"),
            playing,
            standing: self.comparison.as_ref().map(ToString::to_string),
            curves: curves
                .map(|(k, (title, unit, path))| Curve {
                    title,
                    unit,
                    points: self.points(k),
                    published: published.map_or_else(Vec::new, |run| run.points(path)),
                })
                .collect(),
        })
    }

    /// A figure over millions of samples.
    fn points(&self, k: usize) -> Vec<[f64; 2]> {
        let all: Vec<[f64; 2]> =
            self.rows.iter().map(|(_, x, y)| [*x, y[k]]).filter(|[_, y]| y.is_finite()).collect();
        let mean = |part: &[[f64; 2]], i: usize| part.iter().map(|p| p[i]).sum::<f64>() / part.len() as f64;
        let parts = all.chunks(all.len().div_ceil(POINTS).max(1));
        parts.map(|part| [mean(part, 0), mean(part, 1)]).collect()
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    fn line(stage: &str, i: u64) -> String {
        let reach = if stage.ends_with("stage2") { ",\"kick/reach\":1.0" } else { "" };
        format!(
            "{{\"stage\":\"{stage}\",\"iteration\":{i},\"iterations\":9,\"samples\":{},\"episodes\":{},\"mean_reward\":{i}.5,\
             \"terminations\":{{\"anchor_pos\":0.25,\"fell\":0.5,\"time_out\":0.25}},\"metrics\":{{\"kick/on_target\":0.5{reach}}}}}\n",
            i * 1_000_000,
            i - 1
        )
    }

    fn told(course: &Course) -> Value {
        serde_json::from_str(&course.json(Some(2)).expect("JSON")).expect("JSON")
    }

    #[test]
    fn a_log_is_read_as_it_grows_and_a_half_line_waits() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut course = Course::of(folder.path());
        assert!(!course.read(), "there is no log yet");
        assert_eq!(told(&course)["curves"][0]["points"], serde_json::json!([]));
        let path = folder.path().join(METRICS_FILE);
        let mut file = File::options().create(true).append(true).open(&path).expect("a file");
        let second = line("stage2", 2);
        write!(file, "{}{}", line("stage2", 1), &second[..20]).expect("written");
        assert!(course.read() && !course.read());
        write!(file, "{}", &second[20..]).expect("written");
        assert!(course.read());
        let told = told(&course);
        assert_eq!((&told["iteration"], &told["playing"]), (&Value::from(2), &Value::from(2)));
        assert_eq!(told["curves"][0]["points"], serde_json::json!([[1.0, 0.5], [2.0, 0.5]]));
        // The first iteration ended no episode; then three of four ended early.
        assert_eq!(told["curves"][2]["points"], serde_json::json!([[2.0, 0.75]]));
        assert_eq!(told["curves"][4]["title"], "reward of an episode");
    }

    #[test]
    fn a_stage_of_any_name_has_the_curves_of_what_it_learns() {
        for (stage, first) in [
            ("stage1", "error of the bodies"),
            ("paper_stage1", "error of the bodies"),
            ("stage2", "shots on target"),
            ("paper_stage2", "shots on target"),
        ] {
            let mut course = Course::of(Path::new("nowhere"));
            course.take(serde_json::from_str(&line(stage, 1)).expect("JSON"));
            assert_eq!(told(&course)["curves"][0]["title"], first, "{stage}");
        }
    }

    #[test]
    fn the_published_run_of_the_same_stage_comes_along() {
        let mut course = Course::of(Path::new("nowhere"));
        for i in 1..=9 {
            course.take(serde_json::from_str(&line("stage2", i)).expect("JSON"));
        }
        let told = told(&course);
        assert!(told["curves"][0]["published"].as_array().is_some_and(|points| points.len() > 100));
        assert_eq!(told["curves"][5]["published"], serde_json::json!([]), "no one's speed is published");
        // Half of the shots are on target, which paid13 had after 30 million samples.
        assert!(
            told["standing"].as_str().is_some_and(|words| words.starts_with("ahead: shots on target")),
            "{told}"
        );
        let mut other = Course::of(Path::new("nowhere"));
        other.take(serde_json::from_str(&line("paper_stage2", 9)).expect("JSON"));
        let json: Value = serde_json::from_str(&other.json(None).expect("JSON")).expect("JSON");
        assert_eq!(
            (&json["standing"], &json["curves"][0]["published"]),
            (&Value::Null, &serde_json::json!([]))
        );
    }

    #[test]
    fn a_resumed_run_goes_on_from_its_checkpoint() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join(METRICS_FILE);
        let write = |to: &[u64]| {
            let text: String = to.iter().map(|i| line("stage1", *i)).collect();
            std::fs::write(&path, text).expect("written");
        };
        let mut course = Course::of(folder.path());
        write(&[1, 2, 3, 4]);
        assert!(course.read());
        assert_eq!(told(&course)["curves"][0]["title"], "error of the bodies");
        write(&[1, 2, 3]);
        assert!(course.read());
        assert_eq!(
            told(&course)["curves"][1]["points"],
            serde_json::json!([[1.0, 1.5], [2.0, 2.5], [3.0, 3.5]])
        );
    }

    #[test]
    fn a_long_curve_is_thinned_to_means() {
        let mut course = Course::of(Path::new("nowhere"));
        for i in 1..=1000 {
            course.take(serde_json::from_str(&line("stage1", i)).expect("JSON"));
        }
        let points = course.points(1);
        assert_eq!((points.len(), points[0]), (200, [3.0, 3.5]));
    }
}
