//! The curves of a training run: its metrics, thinned, and a plot of them, to keep next to the policy.

use std::path::Path;

use paid_files::{FileError, write_whole};
use paid_plot::{Chart, Figure, Series};
use paid_train::PublishedRun;
use serde_json::Value;

use crate::EvalError;

/// The log of a run, in its folder.
const METRICS: &str = "metrics.jsonl";
/// Iterations from the beginning that are all kept: who repeats a run compares these.
const FIRST: u64 = 100;
/// Diagrams in a row.
const COLUMNS: usize = 2;

const BLUE: [u8; 3] = [31, 119, 180];
const ORANGE: [u8; 3] = [255, 127, 14];
/// The published run's line.
const PALE: [u8; 3] = [190, 200, 210];

/// A diagram: title, unit of y, and its lines, each a path of keys in a record of the log.
type Diagram = (&'static str, &'static str, &'static [(&'static [&'static str], [u8; 3])]);

const DIAGRAMS: [Diagram; 8] = [
    ("mean reward per episode", "", &[(&["mean_reward"], BLUE)]),
    ("error of the bodies", "[m]", &[(&["metrics", "error_body_pos"], BLUE)]),
    (
        "peak speed of the kicking foot (orange: the reference's)",
        "[m/s]",
        &[(&["metrics", "kick_foot_peak_reference"], ORANGE), (&["metrics", "kick_foot_peak"], BLUE)],
    ),
    ("shots on target", "[share of episodes]", &[(&["metrics", "kick/on_target"], BLUE)]),
    ("speed of the kicked ball", "[m/s]", &[(&["metrics", "kick/ball_speed"], BLUE)]),
    (
        "goals of test shots: MuJoCo (blue), built-in engine (orange)",
        "[share of shots]",
        &[(&["judge", "builtin_goal"], ORANGE), (&["judge", "mujoco_goal"], BLUE)],
    ),
    ("standard deviation of the actions", "", &[(&["mean_noise_std"], BLUE)]),
    ("samples per second", "", &[(&["samples_per_s"], BLUE)]),
];

/// The records of a run, one an iteration.
#[derive(Clone, Debug, PartialEq)]
pub struct Curves {
    lines: Vec<(u64, String, Value)>,
}

impl Curves {
    /// Reads the log in a run folder.
    ///
    /// # Errors
    /// If it cannot be read, is empty, or a line is not a record with an `iteration`.
    pub fn read(run: &Path) -> Result<Self, EvalError> {
        let path = run.join(METRICS);
        let text = std::fs::read_to_string(&path).map_err(FileError::at(&path))?;
        let bad = |found| EvalError::Format { path: path.clone(), expected: "a run's log", found };
        let mut lines = Vec::new();
        for (k, line) in text.lines().enumerate() {
            let record: Value =
                serde_json::from_str(line).map_err(|e| bad(format!("line {}: {e}", k + 1)))?;
            let iteration = record["iteration"].as_u64();
            let iteration =
                iteration.ok_or_else(|| bad(format!("line {}: no whole number \"iteration\"", k + 1)))?;
            lines.push((iteration, line.to_owned(), record));
        }
        if lines.is_empty() {
            return Err(bad("an empty file".to_owned()));
        }
        Ok(Self { lines })
    }

    /// The first hundred iterations, those with scored shots, the last one, and every n-th in between, so that about `count` remain.
    pub fn thinned(&self, count: usize) -> String {
        let later = self.lines.iter().filter(|(iteration, ..)| *iteration > FIRST).count();
        let every = later.div_ceil(count.saturating_sub(FIRST as usize).max(1)).max(1) as u64;
        let last = self.lines.len() - 1;
        let kept = self.lines.iter().enumerate().filter(|(k, (iteration, _, record))| {
            *iteration <= FIRST || iteration.is_multiple_of(every) || *k == last || !record["judge"].is_null()
        });
        kept.map(|(_, (_, line, _))| format!("{line}\n")).collect()
    }

    /// Diagrams over millions of samples; what the run does not have is left out. The pale lines are the published run's, if there is one of
    /// this stage.
    pub fn figure(&self) -> Figure {
        let mut charts = Vec::new();
        let stage = self.lines.last().and_then(|(.., record)| record["stage"].as_str());
        let published = stage.and_then(PublishedRun::of);
        for (title, y_label, lines) in DIAGRAMS {
            let mut series: Vec<Series> =
                lines.iter().map(|(path, color)| self.series(path, *color)).collect();
            if series.iter().any(|s| s.points.iter().any(|[_, y]| *y != 0.0)) {
                let pale = |path: &[&str]| {
                    let points = published.map_or_else(Vec::new, |run| run.points(path));
                    (!points.is_empty()).then_some(Series { points, color: PALE, dots: false })
                };
                series.splice(0..0, lines.iter().filter_map(|(path, _)| pale(path)).collect::<Vec<_>>());
                let chart =
                    Chart { title, x_label: "samples [million]", y_label, logarithmic: false, series };
                charts.push(chart.draw());
            }
        }
        Figure::tiled(&charts, COLUMNS)
    }

    /// A value of the log, over millions of samples.
    pub fn series(&self, path: &[&str], color: [u8; 3]) -> Series {
        let number =
            |record: &Value| path.iter().try_fold(record, |v, key| v.get(key)).and_then(Value::as_f64);
        let points: Vec<[f64; 2]> = self
            .lines
            .iter()
            .filter_map(|(.., record)| Some([1e-6 * record["samples"].as_f64()?, number(record)?]))
            .collect();
        // A line of some thousand iterations is a band: each point of the plot is the mean of its neighbors.
        let bin = points.len().div_ceil(300).max(1);
        let mean = |part: &[[f64; 2]], k: usize| part.iter().map(|p| p[k]).sum::<f64>() / part.len() as f64;
        let points = points.chunks(bin).map(|part| [mean(part, 0), mean(part, 1)]).collect();
        Series { points, color, dots: false }
    }

    /// The last iteration.
    pub fn iteration(&self) -> u64 {
        self.lines.last().map_or(0, |(iteration, ..)| *iteration)
    }

    /// Samples at the end of the run.
    pub fn samples(&self) -> f64 {
        self.lines.last().and_then(|(.., record)| record["samples"].as_f64()).unwrap_or(0.0)
    }

    /// One line: how much was trained, how long it took, and with which instruction set.
    pub fn summary(&self) -> String {
        let record = self.lines.last().map_or(&Value::Null, |(.., record)| record);
        let number = |key: &str| record[key].as_f64().unwrap_or(f64::NAN);
        format!(
            "{}: {:.1} million samples in {:.1} min ({})",
            record["stage"].as_str().unwrap_or("run"),
            1e-6 * number("samples"),
            number("elapsed_s") / 60.0,
            record["products"].as_str().unwrap_or("instruction set not stated")
        )
    }

    /// Writes `metrics.jsonl`, thinned to about `count` lines, and the plot as `curves.svg` and `curves.png`.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn write(&self, folder: &Path, count: usize) -> Result<(), EvalError> {
        write_whole(&folder.join(METRICS), self.thinned(count).as_bytes())?;
        Ok(self.figure().save(&folder.join("curves"))?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(lines: &str) -> (tempfile::TempDir, Result<Curves, EvalError>) {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join(METRICS), lines).expect("written");
        let curves = Curves::read(folder.path());
        (folder, curves)
    }

    fn records(n: u64) -> String {
        let record = |i: u64| {
            let judge = if i == 333 { r#","judge":{"mujoco_goal":0.5}"# } else { "" };
            format!("{{\"iteration\":{i},\"samples\":{},\"mean_reward\":{i}.5{judge}}}\n", 1000 * i)
        };
        (1..=n).map(record).collect()
    }

    #[test]
    fn the_first_hundred_the_judged_and_the_last_iteration_stay() {
        let (_folder, curves) = run(&records(1105));
        let text = curves.expect("reads").thinned(201);
        // 1005 later ones, 101 wanted: every tenth.
        let kept: Vec<u64> = text
            .lines()
            .map(|line| {
                serde_json::from_str::<Value>(line).expect("JSON")["iteration"].as_u64().expect("there")
            })
            .collect();
        assert_eq!(kept[..100], (1..=100).collect::<Vec<_>>());
        assert_eq!(kept[100..103], [110, 120, 130]);
        assert!(
            kept.contains(&333) && kept.last() == Some(&1105) && kept.len() == 100 + 101 + 1,
            "{}",
            kept.len()
        );
    }

    #[test]
    fn a_picture_has_a_diagram_for_what_the_run_has() {
        let (folder, curves) = run(&records(1000));
        let curves = curves.expect("reads");
        let svg = curves.figure().svg();
        assert!(
            svg.contains("mean reward") && svg.contains("test shots") && !svg.contains("error of the bodies")
        );
        // 1000 iterations in bins of 4: the mean of 1 to 4 and its samples.
        assert_eq!(curves.series(&["mean_reward"], BLUE).points[0], [0.0025, 3.0]);
        let out = folder.path().join("out");
        curves.write(&out, 150).expect("writes");
        assert!(
            out.join("curves.svg").is_file()
                && out.join("curves.png").is_file()
                && out.join(METRICS).is_file()
        );
    }

    #[test]
    fn the_published_run_is_drawn_behind_a_run_of_its_stage() {
        let lines = |stage: &str| {
            let (_folder, curves) = run(&format!(
                "{{\"stage\":\"{stage}\",\"iteration\":1,\"samples\":46080,\"mean_reward\":6.0}}\n"
            ));
            curves.expect("reads").figure().svg().matches("#bec8d2").count()
        };
        assert_eq!((lines("stage1"), lines("stage3")), (1, 0));
    }

    #[test]
    fn a_run_is_summed_up_in_a_line() {
        let line = r#"{"iteration":3,"stage":"stage1","samples":2500000,"elapsed_s":90.0,"products":"avx2"}"#;
        let (_folder, curves) = run(line);
        assert_eq!(curves.expect("reads").summary(), "stage1: 2.5 million samples in 1.5 min (avx2)");
    }

    #[test]
    fn a_line_that_is_no_record_is_named() {
        for (text, expected) in [
            ("", "metrics.jsonl: expected a run's log: an empty file"),
            ("{\"iteration\":1}\nx\n", "line 2: expected value"),
            ("{\"samples\":1}\n", "line 1: no whole number \"iteration\""),
        ] {
            let error = run(text).1.expect_err("bad").to_string();
            assert!(error.contains(expected), "{error}");
        }
    }
}
