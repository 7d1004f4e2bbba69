//! A share in a report that is read again.

use serde::{Deserialize, Serialize};

use paid_eval::metrics::statistics::Share;

/// How many of how many, with the 95% Wilson score interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Count {
    /// Trials that count.
    pub count: usize,
    /// All trials.
    pub trials: usize,
    /// Lower end of the interval of the share.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Count {
    /// From a yes or no per trial.
    pub fn of(outcomes: impl IntoIterator<Item = bool>) -> Self {
        Share::of(outcomes).into()
    }

    /// `count / trials`; zero without trials.
    pub fn share(&self) -> f64 {
        self.count as f64 / self.trials.max(1) as f64
    }

    /// Share with interval.
    pub fn text(&self) -> String {
        let percent = |x: f64| 100.0 * x;
        format!("{:.1}% [{:.1}, {:.1}]", percent(self.share()), percent(self.low), percent(self.high))
    }
}

impl From<Share> for Count {
    fn from(share: Share) -> Self {
        Self { count: share.count, trials: share.trials, low: share.low, high: share.high }
    }
}
