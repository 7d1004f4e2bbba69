//! Progress of a training that is one of many, in single lines.

use paid_train::Record;

/// Prints the progress of a stage: after its first iteration, then at whole percents, but at most once a minute.
pub struct StageProgress {
    name: String,
    quiet: bool,
    percent: u64,
    said_s: Option<f64>,
}

impl StageProgress {
    /// Training time between two lines, at least `[s]`.
    const PAUSE_S: f64 = 60.0;

    /// Of a stage with this name. `quiet` prints nothing.
    pub fn new(name: String, quiet: bool) -> Self {
        Self { name, quiet, percent: 0, said_s: None }
    }

    /// Prints a line to standard error, if it is time for one.
    pub fn tell(&mut self, record: &Record) {
        if !self.quiet
            && let Some(line) = self.line(record)
        {
            eprintln!("{line}");
        }
    }

    fn line(&mut self, record: &Record) -> Option<String> {
        let percent = record.iteration * 100 / record.iterations.max(1);
        let due = self.said_s.is_none_or(|said_s| {
            percent > self.percent && (percent >= 100 || record.elapsed_s - said_s >= Self::PAUSE_S)
        });
        if !due {
            return None;
        }
        (self.percent, self.said_s) = (percent, Some(record.elapsed_s));
        Some(format!(
            "{}: {percent}% of {} iterations, {:.1} M samples, {:.0} samples/s, {}",
            self.name,
            record.iterations,
            record.samples as f64 / 1e6,
            record.samples_per_s,
            left(record.eta_s)
        ))
    }
}

/// A time that is left, in the unit that one would use.
pub fn left(seconds: f64) -> String {
    if seconds < 120.0 { format!("{seconds:.0} s left") } else { format!("{:.0} min left", seconds / 60.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(iteration: u64, elapsed_s: f64) -> Record {
        let eta_s = (1000 - iteration) as f64;
        let (iterations, samples) = (1000, iteration * 2000);
        Record { iteration, iterations, samples, elapsed_s, eta_s, samples_per_s: 512.3, ..Record::default() }
    }

    #[test]
    fn the_first_iteration_is_told_then_whole_percents_a_minute_apart_and_the_end() {
        let mut progress = StageProgress::new("1 of 3: AMP, amp".to_owned(), false);
        let mut told = |iteration, elapsed_s| progress.line(&record(iteration, elapsed_s));
        // A resumed run prints where it is.
        let first = told(333, 100.0).expect("the first");
        assert_eq!(
            first,
            "1 of 3: AMP, amp: 33% of 1000 iterations, 0.7 M samples, 512 samples/s, 11 min left"
        );
        assert_eq!(told(339, 500.0), None, "not a whole percent more");
        assert_eq!(told(340, 159.0), None, "not a minute later");
        assert!(told(350, 160.0).expect("a minute later").contains(": 35% of 1000"));
        assert_eq!(told(360, 219.0), None);
        assert!(
            told(1000, 219.5)
                .expect("the end")
                .ends_with("100% of 1000 iterations, 2.0 M samples, 512 samples/s, 0 s left")
        );
    }

    #[test]
    fn a_run_of_one_iteration_is_told_once() {
        let mut progress = StageProgress::new("short".to_owned(), false);
        let record = Record { iteration: 1, iterations: 1, eta_s: 119.6, ..Record::default() };
        assert!(progress.line(&record).expect("a line").ends_with("120 s left"));
        assert_eq!(progress.line(&record), None);
    }
}
