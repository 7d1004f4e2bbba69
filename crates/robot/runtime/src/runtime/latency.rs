//! How old an image is when it moves a joint.

use paid_lanes::stats::quantile_of_counts;
use serde::Serialize;

/// Bins of a millisecond.
const BINS: usize = 512;
/// Two captures closer than this are one image `[us]`: the age of a belief is a sum of steps.
const SAME_US: u64 = 2_000;

/// From the capture of an image to the joint targets, in steps of a millisecond. Counting allocates nothing.
#[derive(Clone, Debug)]
pub struct Latency {
    counts: Vec<u64>,
    captured_us: u64,
}

/// A distribution in figures.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LatencyFigures {
    /// Images.
    pub pictures: u64,
    /// Shortest, what 1, 5, 50, 95 and 99% stay within, longest `[ms]`; a longer one than 511 counts as that.
    pub within_ms: [f64; 7],
}

impl Default for Latency {
    fn default() -> Self {
        Self { counts: vec![0; BINS], captured_us: 0 }
    }
}

impl Latency {
    /// Joint targets go out at `now_us` `[us]`; the newest image of the ball is `age_s` old `[s]`. An image counts once.
    pub(super) fn acted(&mut self, now_us: u64, age_s: f64) {
        // An image that old affected an earlier step, if any.
        if !(0.0..1.0).contains(&age_s) {
            return;
        }
        let age_us = (age_s * 1e6) as u64;
        let captured_us = now_us.saturating_sub(age_us);
        if captured_us <= self.captured_us + SAME_US {
            return;
        }
        self.captured_us = captured_us;
        self.counts[((age_us / 1000) as usize).min(BINS - 1)] += 1;
    }

    /// Adds what another one has counted.
    pub fn merge(&mut self, other: &Self) {
        for (count, more) in self.counts.iter_mut().zip(&other.counts) {
            *count += more;
        }
    }

    /// The distribution, bin by bin: milliseconds, and images of that age. Empty bins are left out.
    pub fn histogram(&self) -> Vec<(usize, u64)> {
        self.counts.iter().copied().enumerate().filter(|(_, count)| *count > 0).collect()
    }

    /// The distribution in figures; `None` before the first image.
    pub fn figures(&self) -> Option<LatencyFigures> {
        let pictures: u64 = self.counts.iter().sum();
        let within = |share: f64| quantile_of_counts(&self.counts, share).unwrap_or(BINS - 1) as f64;
        (pictures > 0).then(|| LatencyFigures {
            pictures,
            within_ms: [0.0, 0.01, 0.05, 0.5, 0.95, 0.99, 1.0].map(within),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_counts_once_with_the_age_that_it_has_at_the_first_targets() {
        let mut latency = Latency::default();
        assert_eq!(latency.figures(), None);
        // Images at 1.000 and 1.040 s; the first is used at 1.080 and 1.100, the second at 1.120.
        for (now_us, age_s) in
            [(1_080_000, 0.0805), (1_100_000, 0.1003), (1_120_000, 0.0805), (1_200_000, f64::INFINITY)]
        {
            latency.acted(now_us, age_s);
        }
        let figures = latency.figures().expect("two images");
        assert_eq!(latency.histogram(), [(80, 2)]);
        assert_eq!((figures.pictures, figures.within_ms), (2, [80.0; 7]));
    }
}
