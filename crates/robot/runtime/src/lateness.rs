//! How late a loop woke up, compared with a bare timer.

use std::fmt::Write as _;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use paid_lanes::stats::quantile_of_counts;
use serde::Serialize;

use crate::cpu::{WRITER_PRIORITY, ask_for_real_time};
use crate::wire::COMMAND_US;

/// How late a loop came, in steps of 10 microseconds up to a tenth of a second.
#[derive(Clone, Debug)]
pub struct Lateness {
    counts: Vec<u64>,
}

impl Default for Lateness {
    fn default() -> Self {
        Self { counts: vec![0; 10_000] }
    }
}

/// Upper edges of the bins of [`Lateness::shares`] `[ms]`; the last bin has none.
pub const LATENESS_EDGES_MS: [f64; 9] = [0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 20.0];

/// A loop's lateness in figures.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LatenessFigures {
    /// Periods.
    pub periods: u64,
    /// Lateness that 50, 99 and 99.9% of them stayed within `[ms]`, and the longest.
    pub within_ms: [f64; 4],
    /// Share of the periods in each bin of [`LATENESS_EDGES_MS`], and beyond the last edge.
    pub shares: Vec<f64>,
}

impl Lateness {
    /// Counts a period.
    pub fn add(&mut self, late: Duration) {
        let at = (late.as_micros() / 10) as usize;
        let last = self.counts.len() - 1;
        self.counts[at.min(last)] += 1;
    }

    fn periods(&self) -> u64 {
        self.counts.iter().sum()
    }

    /// The lateness that a share of the periods stayed within `[ms]`.
    pub fn quantile_ms(&self, share: f64) -> f64 {
        quantile_of_counts(&self.counts, share).map_or(f64::NAN, |bin| (bin + 1) as f64 * 0.01)
    }

    /// Share of the periods in each bin of [`LATENESS_EDGES_MS`], and beyond the last edge.
    pub fn shares(&self) -> Vec<f64> {
        let mut shares = vec![0.0; LATENESS_EDGES_MS.len() + 1];
        for (k, count) in self.counts.iter().enumerate() {
            let late_ms = (k + 1) as f64 * 0.01;
            let bin = LATENESS_EDGES_MS.iter().take_while(|edge| late_ms > **edge + 1e-9).count();
            shares[bin] += *count as f64;
        }
        let periods = self.periods().max(1) as f64;
        shares.iter().map(|count| count / periods).collect()
    }

    /// Everything to print or to write.
    pub fn figures(&self) -> LatenessFigures {
        let within_ms = [0.5, 0.99, 0.999, 1.0].map(|share| self.quantile_ms(share));
        LatenessFigures { periods: self.periods(), within_ms, shares: self.shares() }
    }
}

/// A bare loop of the command period alongside a run, in a thread of its own that asks for the same priority as the writer.
#[derive(Debug)]
pub struct BareTimer {
    over: Arc<AtomicBool>,
    thread: JoinHandle<Lateness>,
}

impl BareTimer {
    /// Begins.
    pub fn start() -> Self {
        let over = Arc::new(AtomicBool::new(false));
        let ended = Arc::clone(&over);
        let run = move || {
            ask_for_real_time(WRITER_PRIORITY);
            let (mut out, mut pace) = (Lateness::default(), Pace::new(COMMAND_US));
            while !ended.load(Ordering::Relaxed) {
                out.add(pace.wait());
            }
            out
        };
        Self { over, thread: std::thread::spawn(run) }
    }

    /// Ends; how late it was.
    pub fn end(self) -> Lateness {
        self.over.store(true, Ordering::Relaxed);
        self.thread.join().unwrap_or_default()
    }
}

/// Two loops side by side: a row a bin, then the quantiles.
pub fn lateness_table(commands: &LatenessFigures, timer: &LatenessFigures) -> String {
    let mut out = format!("{:<18} {:>10} {:>12}\n", "late by [ms]", "commands", "bare timer");
    let mut from = 0.0;
    for (k, (a, b)) in commands.shares.iter().zip(&timer.shares).enumerate() {
        let to = LATENESS_EDGES_MS.get(k);
        let bin = to.map_or_else(|| format!("> {from}"), |to| format!("{from} to {to}"));
        let _ = writeln!(out, "{bin:<18} {:>9.2}% {:>11.2}%", 100.0 * a, 100.0 * b);
        from = to.copied().unwrap_or(from);
    }
    for (k, name) in ["50%", "99%", "99.9%", "all"].iter().enumerate() {
        let (a, b) = (commands.within_ms[k], timer.within_ms[k]);
        let _ = writeln!(out, "{:<18} {a:>10.2} {b:>12.2}", format!("{name} within [ms]"));
    }
    let _ = writeln!(out, "{:<18} {:>10} {:>12}", "periods", commands.periods, timer.periods);
    out
}

/// How long something took, in steps of a microsecond up to 10 ms.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Durations {
    counts: Vec<u64>,
    longest: Duration,
}

impl Default for Durations {
    fn default() -> Self {
        Self { counts: vec![0; 10_000], longest: Duration::ZERO }
    }
}

/// Upper edges of the rows of [`Durations::table`] `[us]`.
const EDGES_US: [u64; 9] = [2, 5, 10, 20, 30, 50, 100, 200, 1000];

impl Durations {
    /// Counts one.
    pub fn add(&mut self, took: Duration) {
        let last = self.counts.len() - 1;
        self.counts[(took.as_micros() as usize).min(last)] += 1;
        self.longest = self.longest.max(took);
    }

    /// How many.
    pub fn count(&self) -> u64 {
        self.counts.iter().sum()
    }

    /// What this share of them stayed within, to a microsecond.
    pub fn quantile(&self, share: f64) -> Duration {
        let bin = quantile_of_counts(&self.counts, share);
        bin.map_or(self.longest, |k| Duration::from_micros(k as u64 + 1).min(self.longest))
    }

    /// Columns side by side: shares a bin, then the quantiles `[us]`.
    pub fn table(columns: &[(&str, &Self)]) -> String {
        let mut out = format!("{:<18}", "took [us]");
        let row = |out: &mut String, name: String, cell: &dyn Fn(&Self) -> String| {
            let _ = write!(out, "{name:<18}");
            for (_, durations) in columns {
                let _ = write!(out, "{:>16}", cell(durations));
            }
            out.push('\n');
        };
        for (name, _) in columns {
            let _ = write!(out, "{name:>16}");
        }
        out.push('\n');
        for (from, to) in [0].iter().chain(&EDGES_US).zip(EDGES_US.iter().chain(&[10_000])) {
            row(&mut out, format!("{from} to {to}"), &|durations| {
                let count: u64 = durations.counts[*from as usize..*to as usize].iter().sum();
                format!("{:.2}%", 100.0 * count as f64 / durations.count().max(1) as f64)
            });
        }
        for (name, share) in [("50%", 0.5), ("99%", 0.99), ("99.9%", 0.999), ("all", 1.0)] {
            row(&mut out, format!("{name} within"), &|durations| {
                format!("{:.1}", durations.quantile(share).as_secs_f64() * 1e6)
            });
        }
        row(&mut out, "count".to_owned(), &|durations| durations.count().to_string());
        out
    }
}

/// Wakes up at whole periods.
pub(crate) struct Pace {
    next: Instant,
    period: Duration,
}

impl Pace {
    pub(crate) fn new(period_us: u64) -> Self {
        let period = Duration::from_micros(period_us);
        Self { next: Instant::now() + period, period }
    }

    /// Sleeps until the next period begins; how late it is. Periods that were slept through are left out.
    pub(crate) fn wait(&mut self) -> Duration {
        let now = Instant::now();
        if now < self.next {
            std::thread::sleep(self.next - now);
        }
        let now = Instant::now();
        let late = now.saturating_duration_since(self.next);
        self.next += self.period;
        if self.next < now {
            self.next = now + self.period;
        }
        late
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_and_quantiles_come_from_the_same_counts() {
        let mut lateness = Lateness::default();
        // 90 within 10 microseconds, 9 of 140, one of 30 ms.
        for (count, micros) in [(90, 5), (9, 140), (1, 30_000)] {
            for _ in 0..count {
                lateness.add(Duration::from_micros(micros));
            }
        }
        let figures = lateness.figures();
        assert_eq!(figures.periods, 100);
        assert_eq!(figures.shares, [0.9, 0.0, 0.0, 0.09, 0.0, 0.0, 0.0, 0.0, 0.0, 0.01]);
        let near = |a: f64, b: f64| (a - b).abs() < 1e-9;
        let [half, most, nearly_all, all] = figures.within_ms;
        assert!(near(half, 0.01) && near(most, 0.15) && near(nearly_all, 30.01) && near(all, 30.01));
        let table = lateness_table(&figures, &figures);
        assert!(table.contains("0.1 to 0.2              9.00%        9.00%"), "{table}");
        assert!(table.contains("> 20                    1.00%        1.00%"), "{table}");
        assert!(table.contains("99.9% within [ms]       30.01        30.01"), "{table}");
    }

    #[test]
    fn durations_are_counted_a_microsecond_each() {
        let mut durations = Durations::default();
        for (count, nanos) in [(98, 12_300), (1, 55_000), (1, 3_000_000)] {
            for _ in 0..count {
                durations.add(Duration::from_nanos(nanos));
            }
        }
        let micros = |share| durations.quantile(share).as_micros();
        assert_eq!((micros(0.5), micros(0.98), micros(0.99), micros(1.0)), (13, 13, 56, 3000));
        let table = Durations::table(&[("policy", &durations)]);
        assert!(table.contains("10 to 20                    98.00%\n"), "{table}");
        assert!(table.contains("50 to 100                    1.00%\n"), "{table}");
        assert!(table.contains("99% within                    56.0\n"), "{table}");
    }

    #[test]
    fn an_edge_belongs_to_the_bin_below_it() {
        let mut lateness = Lateness::default();
        // Counted in steps of 10 microseconds, upper end: 0.02 ms.
        lateness.add(Duration::from_micros(19));
        assert_eq!(lateness.shares()[..2], [1.0, 0.0]);
        lateness.add(Duration::from_micros(20));
        assert_eq!(lateness.shares()[..2], [0.5, 0.5]);
    }
}
