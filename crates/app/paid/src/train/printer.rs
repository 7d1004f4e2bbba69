//! What a training prints.

use std::time::{Duration, Instant};

use paid_train::{Comparer, End, Outcome, Record, StageJob};

/// Progress in the terminal: a block of text every few seconds, or JSON lines, or nothing.
pub struct Printer {
    pub json: bool,
    pub quiet: bool,
    pub last: Option<Instant>,
    pub comparer: Comparer,
}

impl Printer {
    /// Iterations take fractions of a second; no one reads faster than this.
    const PAUSE: Duration = Duration::from_secs(5);

    /// Prints an iteration, and how the run stands next to the published one.
    pub fn iteration(&mut self, record: &Record) {
        let metric = |name: &str| record.metrics.get(name);
        let comparison = self.comparer.take(&record.stage, record.samples, metric);
        if self.json {
            match serde_json::to_string(record) {
                Ok(line) => println!("{line}"),
                Err(error) => eprintln!("iteration {}: {error}", record.iteration),
            }
        } else if !self.quiet
            && (!record.judge.is_empty() || self.last.is_none_or(|last| last.elapsed() >= Self::PAUSE))
        {
            print!("{}", record.text());
            if let Some(comparison) = comparison {
                println!("  {comparison}");
            }
            self.last = Some(Instant::now());
        }
    }

    /// Prints how the stage ended.
    pub fn end(&self, job: &StageJob, outcome: &Outcome) {
        if self.json || self.quiet {
            return;
        }
        let why = match outcome.end {
            End::Done => "done",
            End::TimeUp => "time is up",
            End::Stopped => "stopped",
        };
        println!(
            "{} {why} after {} iterations and {:.2} M samples: {}",
            job.preset.stage,
            outcome.iteration,
            outcome.samples as f64 / 1e6,
            outcome.checkpoint.display()
        );
    }
}
