//! What a training prints.

use std::time::{Duration, Instant};

use paid_train::{Comparer, End, Outcome, Record, StageJob};

/// Progress in the terminal: a block of text every few seconds, or JSON lines, or nothing.
pub struct Printer {
    pub json: bool,
    pub quiet: bool,
    pub last: Option<Instant>,
    pub comparer: Comparer,
    /// It was said that gates are saturated.
    pub warned: bool,
}

impl Printer {
    /// Iterations take fractions of a second; no one reads faster than this.
    const PAUSE: Duration = Duration::from_secs(5);

    /// Prints an iteration, and how the run stands next to the published one.
    pub fn iteration(&mut self, record: &Record) {
        let metric = |name: &str| record.metrics.get(name);
        if !self.warned
            && let Some(warning) = saturated(record)
        {
            eprintln!("{warning}");
            self.warned = true;
        }
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

/// From this share on there is a warning. The long spans that a `memory` begins with hold some 0.4 of them at one end.
const SATURATED: f64 = 2.0 / 3.0;

/// What to say of a recurrent network most of whose gates are shut or wide open.
fn saturated(record: &Record) -> Option<String> {
    let share = |network: &str| record.metrics.get(&format!("gates/{network}_saturated"));
    let (network, share) = ["actor", "critic"]
        .into_iter()
        .find_map(|name| Some((name, share(name).filter(|s| *s > SATURATED)?)))?;
    Some(format!(
        "warning: {:.0}% of the gates of the {network}'s LSTM are shut or wide open, where they hardly learn; try a lower \
         learn.ppo.max_learning_rate",
        100.0 * share
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gates_that_are_mostly_shut_get_a_warning() {
        let mut record = Record::default();
        assert_eq!(saturated(&record), None);
        record.metrics.push("gates/actor_saturated", 0.5);
        assert_eq!(saturated(&record), None);
        record.metrics.push("gates/critic_saturated", 0.75);
        let text = saturated(&record).expect("most of them");
        assert!(text.starts_with("warning: 75% of the gates of the critic's LSTM are shut"), "{text}");
    }
}
