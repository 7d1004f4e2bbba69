//! Measurement files: a row a camera frame, several runs a file.
//!
//! ```text
//! # Ball 3, artificial turf, 24 C
//! run,time_s,height_m
//! 1,0.000,2.003
//! 1,0.100,1.951
//! ```
//!
//! Columns may come in any order; without `run` the file holds one. `time_s` counts from any moment; a run's first row is the
//! instant of release. `height_m` is that of the ball's lowest point over the ground (0 when it lies there). `distance_m`
//! is counted along the roll from any mark.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use crate::SysidError;

/// Fewest samples of a run.
const MIN_SAMPLES: usize = 5;
/// More than this is no kick-about [m]: a wrong unit.
const LARGEST_M: f64 = 100.0;

/// What a file measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Heights of a dropped ball.
    Height,
    /// Distances of a rolling ball.
    Distance,
}

impl Quantity {
    /// Name of the column.
    pub fn column(self) -> &'static str {
        match self {
            Self::Height => "height_m",
            Self::Distance => "distance_m",
        }
    }
}

/// One repeat of an experiment as measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// Its label in the file.
    pub name: String,
    /// Instants from its first sample `[s]`, strictly increasing from 0.
    pub times: Vec<f64>,
    /// Heights or distances `[m]`.
    pub values: Vec<f64>,
    /// Spin of a rolling ball at the first sample where it is not that of the options: 1 rolls, 0 slides.
    pub spin: Option<f64>,
}

/// Reads the runs of a file.
///
/// # Errors
/// File, line, column, expected, found.
pub fn read_runs(path: &Path, quantity: Quantity) -> Result<Vec<Run>, SysidError> {
    let text =
        fs::read_to_string(path).map_err(|source| SysidError::Read { path: path.to_owned(), source })?;
    parse_runs(path, &text, quantity)
}

/// Where a complaint belongs.
struct Place<'a> {
    path: &'a Path,
    line: usize,
}

impl Place<'_> {
    fn bad<T>(&self, column: &str, expected: impl ToString, found: impl ToString) -> Result<T, SysidError> {
        Err(SysidError::Csv {
            path: PathBuf::from(self.path),
            line: self.line,
            column: column.to_owned(),
            expected: expected.to_string(),
            found: found.to_string(),
        })
    }

    fn number(&self, column: &str, text: &str) -> Result<f64, SysidError> {
        match text.parse::<f64>() {
            Ok(x) if x.is_finite() => Ok(x),
            _ => self.bad(column, "a finite number such as 0.125", format!("'{text}'")),
        }
    }
}

/// A run under construction, and the line that it begins on.
struct Open {
    run: Run,
    start: f64,
    line: usize,
}

/// The runs in the text of a file; `path` is for complaints.
///
/// # Errors
/// As [`read_runs`].
pub fn parse_runs(path: &Path, text: &str, quantity: Quantity) -> Result<Vec<Run>, SysidError> {
    let value_column = quantity.column();
    let names = format!("a header with the columns [run,]time_s,{value_column}");
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut rows = (1..)
        .zip(text.lines())
        .map(|(line, row)| (line, row.trim()))
        .filter(|(_, row)| !row.is_empty() && !row.starts_with('#'));
    let Some((line, header)) = rows.next() else {
        return Place { path, line: 1 }.bad(value_column, names, "no rows");
    };
    let header: Vec<&str> = header.split(',').map(str::trim).collect();
    let place = Place { path, line };
    let find = |name: &str| header.iter().position(|h| *h == name);
    let (Some(time_at), Some(value_at)) = (find("time_s"), find(value_column)) else {
        let missing = if find("time_s").is_none() { "time_s" } else { value_column };
        return place.bad(missing, names, format!("'{}'", header.join(",")));
    };
    let run_at = find("run");
    if let Some(strange) = header.iter().find(|h| !["run", "time_s", value_column].contains(h)) {
        return place.bad(strange, names, format!("'{}'", header.join(",")));
    }
    if header.len() != 2 + usize::from(run_at.is_some()) {
        return place.bad("header", "each column once", format!("'{}'", header.join(",")));
    }
    let mut runs: Vec<Open> = Vec::new();
    for (line, row) in rows {
        let place = Place { path, line };
        let cells: Vec<&str> = row.split(',').map(str::trim).collect();
        if cells.len() != header.len() {
            let column = header[cells.len().min(header.len() - 1)];
            let found = format!("{} in '{row}'", cells.len());
            return place.bad(column, format!("{} values", header.len()), found);
        }
        let name = run_at.map_or("1", |i| cells[i]);
        let time = place.number("time_s", cells[time_at])?;
        let value = place.number(value_column, cells[value_at])?;
        if value.abs() > LARGEST_M {
            return place.bad(value_column, format!("meters, within {LARGEST_M} m"), value);
        }
        if let Some(open) = runs.last_mut().filter(|r| r.run.name == name) {
            let last = open.start + open.run.times.last().copied().unwrap_or(0.0);
            if time <= last {
                return place.bad("time_s", format!("more than the last row's {last} s"), time);
            }
            open.run.times.push(time - open.start);
            open.run.values.push(value);
            continue;
        }
        if let Some(earlier) = runs.iter().find(|r| r.run.name == name) {
            let expected = format!("all rows of run '{name}' together (it began on line {})", earlier.line);
            return place.bad("run", expected, "another run between them");
        }
        let run = Run { name: name.to_owned(), times: vec![0.0], values: vec![value], spin: None };
        runs.push(Open { run, start: time, line });
    }
    if runs.is_empty() {
        return place.bad(value_column, "rows below the header", "none");
    }
    for open in &runs {
        check_run(&Place { path, line: open.line }, &open.run, quantity)?;
    }
    Ok(runs.into_iter().map(|open| open.run).collect())
}

/// Whether a run can be what it claims to be.
fn check_run(place: &Place, run: &Run, quantity: Quantity) -> Result<(), SysidError> {
    let column = quantity.column();
    if run.times.len() < MIN_SAMPLES {
        let expected = format!("at least {MIN_SAMPLES} rows in run '{}'", run.name);
        return place.bad(column, expected, run.times.len());
    }
    let lowest = run.values.iter().copied().fold(f64::INFINITY, f64::min);
    let highest = run.values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    match quantity {
        Quantity::Height => {
            let release = run.values[0];
            if release < 0.2 {
                return place.bad(column, "a release at 0.2 m or higher in a run's first row", release);
            }
            if highest > release + 0.1 {
                let expected = format!("no height in run '{}' above its release at {release} m", run.name);
                return place.bad(column, expected, highest);
            }
            if lowest < -0.1 {
                let expected = format!("heights of the ball's lowest point, from 0, in run '{}'", run.name);
                return place.bad(column, expected, lowest);
            }
        }
        Quantity::Distance => {
            let moved = run.values.last().copied().unwrap_or(0.0) - run.values[0];
            if moved < 0.1 {
                let expected = format!("a ball that rolls 0.1 m or more in run '{}'", run.name);
                return place.bad(column, expected, format!("{moved:.3} m from first to last row"));
            }
        }
    }
    Ok(())
}

/// The text of a measurement file, `comments` first.
pub fn write_runs(runs: &[Run], quantity: Quantity, comments: &[String]) -> String {
    let mut out = String::new();
    for comment in comments {
        let _ = writeln!(out, "# {comment}");
    }
    let _ = writeln!(out, "run,time_s,{}", quantity.column());
    for run in runs {
        for (t, v) in run.times.iter().zip(&run.values) {
            // Tenths of a millimeter: finer than any camera.
            let _ = writeln!(out, "{},{t:.4},{v:.4}", run.name);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Vec<Run>, String> {
        parse_runs(Path::new("drop.csv"), text, Quantity::Height).map_err(|e| e.to_string())
    }

    const GOOD: &str = "run,time_s,height_m\n1,0.5,1.0\n1,0.6,0.95\n1,0.7,0.8\n1,0.8,0.6\n1,0.9,0.2\n";

    #[test]
    fn times_count_from_a_runs_first_row_and_comments_are_skipped() {
        let runs = parse(&format!("\u{feff}# a comment\n\n{GOOD}")).expect("good");
        assert_eq!(runs.len(), 1);
        assert!((runs[0].times[4] - 0.4).abs() < 1e-12 && runs[0].times[0] == 0.0);
        assert_eq!(runs[0].values[1], 0.95);
    }

    #[test]
    fn what_is_written_reads_back() {
        let times: Vec<f64> = (0..6).map(|i| 0.1 * f64::from(i)).collect();
        let run =
            |name: &str| Run { name: name.into(), times: times.clone(), values: vec![0.5; 6], spin: None };
        let runs = vec![run("a"), run("b")];
        let text = write_runs(&runs, Quantity::Height, &["note".into()]);
        let back = parse(&text).expect("good");
        assert_eq!(back.len(), 2);
        assert!(back[1].times.iter().zip(&times).all(|(a, b)| (a - b).abs() < 1e-9));
    }

    #[test]
    fn columns_may_be_swapped_and_the_run_left_out() {
        let text = "height_m,time_s\n1.0,0\n0.9,0.1\n0.8,0.2\n0.6,0.3\n0.3,0.4";
        assert_eq!(parse(text).expect("good")[0].values[0], 1.0);
    }

    #[test]
    fn complaints_name_file_line_column_expected_and_found() {
        for (text, parts) in [
            (GOOD.replace("0.95", "0,95"), ["line 3", "expected 3 values", "found 4"]),
            (GOOD.replace("0.95", "x"), ["line 3, column 'height_m'", "a finite number", "found 'x'"]),
            (GOOD.replace("0.95", "NaN"), ["line 3", "a finite number", "'NaN'"]),
            (GOOD.replace("0.7,", "0.55,"), ["line 4, column 'time_s'", "more than the last", "0.55"]),
            (GOOD.replace("time_s", "t"), ["line 1, column 'time_s'", "a header", "'run,t,height_m'"]),
            (GOOD.replace("1.0", "0.1"), ["line 2", "0.2 m or higher", "found 0.1"]),
            (GOOD.replace("0.2\n", "\n"), ["line 6, column 'height_m'", "a finite number", "''"]),
            (GOOD.replace("1.0", "1000"), ["line 2", "meters", "1000"]),
            ("run,time_s,height_m\n1,0,1\n1,0.1,0.9".into(), ["line 2", "at least 5 rows", "found 2"]),
            ("run,time_s,height_m\n".into(), ["line 1", "rows below the header", "none"]),
            (String::new(), ["line 1", "a header", "no rows"]),
        ] {
            let error = parse(&text).expect_err("bad");
            assert!(error.starts_with("drop.csv"), "{error}");
            for part in parts {
                assert!(error.contains(part), "{part}: {error}");
            }
        }
    }

    #[test]
    fn a_run_in_two_pieces_is_refused() {
        let text = format!("{GOOD}2,0,1.0\n1,1.0,0.5\n");
        let error = parse(&text).expect_err("bad");
        assert!(error.contains("line 8") && error.contains("began on line 2"), "{error}");
    }

    #[test]
    fn a_ball_that_does_not_roll_is_refused() {
        let text = "time_s,distance_m\n0,0\n0.1,0.01\n0.2,0.02\n0.3,0.02\n0.4,0.02";
        let error = parse_runs(Path::new("roll.csv"), text, Quantity::Distance).expect_err("bad").to_string();
        assert!(error.contains("roll.csv, line 2") && error.contains("0.020 m"), "{error}");
    }
}
