//! Shares with intervals.

use serde::Serialize;

/// The 97.5% quantile of the standard normal distribution.
const Z: f64 = 1.959_963_984_540_054;

/// A share of trials with its 95% Wilson score interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Share {
    /// Trials that count.
    pub count: usize,
    /// All trials.
    pub trials: usize,
    /// `count / trials`; zero without trials.
    pub share: f64,
    /// Lower end of the interval; zero without trials.
    pub low: f64,
    /// Upper end of the interval; one without trials.
    pub high: f64,
}

impl Share {
    /// From counts (E. B. Wilson, "Probable inference, the law of succession, and statistical inference", 1927).
    ///
    /// # Panics
    /// If `count` is above `trials`.
    pub fn new(count: usize, trials: usize) -> Self {
        assert!(count <= trials, "{count} of {trials}");
        if trials == 0 {
            return Self { count, trials, share: 0.0, low: 0.0, high: 1.0 };
        }
        let (n, p) = (trials as f64, count as f64 / trials as f64);
        let center = p + Z * Z / (2.0 * n);
        let half = Z * (p * (1.0 - p) / n + Z * Z / (4.0 * n * n)).sqrt();
        let scale = 1.0 + Z * Z / n;
        Self {
            count,
            trials,
            share: p,
            low: ((center - half) / scale).max(0.0),
            high: ((center + half) / scale).min(1.0),
        }
    }

    /// From a yes or no per trial.
    pub fn of(outcomes: impl IntoIterator<Item = bool>) -> Self {
        let (count, trials) =
            outcomes.into_iter().fold((0, 0), |(yes, all), o| (yes + usize::from(o), all + 1));
        Self::new(count, trials)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_of_eight_in_ten() {
        // (0.8 + 0.19207) -+ 1.95996 sqrt(0.016 + 0.0096036), over 1.38415.
        let share = Share::new(8, 10);
        assert!((share.low - 0.4902).abs() < 1e-4, "{share:?}");
        assert!((share.high - 0.9433).abs() < 1e-4, "{share:?}");
    }

    #[test]
    fn the_interval_stays_within_zero_and_one() {
        let (none, all) = (Share::new(0, 20), Share::new(20, 20));
        assert!(none.low == 0.0 && (none.high - 0.1611).abs() < 1e-4, "{none:?}");
        assert!((all.low - 0.8389).abs() < 1e-4 && (all.high - 1.0).abs() < 1e-12, "{all:?}");
        assert_eq!(Share::new(0, 0), Share { count: 0, trials: 0, share: 0.0, low: 0.0, high: 1.0 });
    }

    #[test]
    fn counting_outcomes_is_the_same_as_giving_counts() {
        assert_eq!(Share::of([true, false, true, true]), Share::new(3, 4));
    }
}
