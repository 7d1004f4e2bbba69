//! What an ablation found.

use std::fs;
use std::io::ErrorKind;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::judge::JudgeSettings;
use crate::EvalError;
use crate::knowledge::Knowledge;
use crate::metrics::statistics::Share;
use crate::table::Table;

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

/// A variant on a surface. The policy's knowledge is `noisy`: positions with noise, latency and frame rate of the settings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Score {
    /// What was trained.
    pub variant: String,
    /// Where it was judged.
    pub surface: String,
    /// Training samples after Stage I.
    pub samples: u64,
    /// How it was judged.
    pub settings: JudgeSettings,
    /// Goals from the paper's three places, (-0.6, 0.8), (0, 0.8), (0.6, 0.8) m in its axes.
    pub places: [Count; 3],
    /// Goals over the effective workspace.
    pub workspace: Count,
    /// Contacts with the ball over the workspace.
    pub contacts: Count,
    /// Falls over the workspace.
    pub falls: Count,
}

impl Score {
    /// An earlier score, if there is one.
    ///
    /// # Errors
    /// If the file cannot be read, or is no score.
    pub fn read(path: &Path) -> Result<Option<Self>, EvalError> {
        let text = match fs::read_to_string(path) {
            Ok(text) => text,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(EvalError::read(path)(error)),
        };
        let score = serde_json::from_str(&text).map_err(|error| EvalError::Format {
            path: path.to_owned(),
            expected: "a score of an ablation",
            found: error.to_string(),
        })?;
        Ok(Some(score))
    }

    /// True if it was judged like this, after as many samples.
    pub fn is_of(&self, settings: &JudgeSettings, samples: u64) -> bool {
        self.settings == *settings && self.samples == samples
    }
}

/// The whole ablation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Scores {
    /// How it was judged.
    pub settings: JudgeSettings,
    /// What every variant knew of ball and goal when it was judged.
    pub knowledge: Knowledge,
    /// One score per variant and surface.
    pub scores: Vec<Score>,
}

impl Scores {
    /// One row per variant and surface.
    pub fn table(&self) -> String {
        let mut table = Table::new(&[
            "variant",
            "surface",
            "(-0.6,0.8)",
            "(0.0,0.8)",
            "(0.6,0.8)",
            "workspace [95%]",
            "contact",
            "falls",
            "samples",
        ]);
        for score in &self.scores {
            let place = |k: usize| format!("{}/{}", score.places[k].count, score.places[k].trials);
            table.row([
                score.variant.clone(),
                score.surface.clone(),
                place(0),
                place(1),
                place(2),
                score.workspace.text(),
                score.contacts.text(),
                score.falls.text(),
                format!("{:.1} M", score.samples as f64 / 1e6),
            ]);
        }
        format!("{table}MuJoCo; knowledge: {}. Places: left, middle, right, 0.8 m ahead.\n", self.knowledge)
    }
}
