//! Scores during a training run: static shots in MuJoCo, for the log.

use std::path::Path;

use paid_train::{Judge, JudgeConfig, Named};

use crate::EvalError;
use crate::scene::Engines;
use crate::shooting::{Grid, ShootingOptions, ShootingReport, evaluate};
use crate::subject::{Subject, SubjectSpec};

/// Scores a policy in MuJoCo's usual scene and, on the same shots, in the built-in engine.
///
/// Figures: `mujoco_goal`, `mujoco_accuracy`, `mujoco_falls`, and the same with `builtin_`. All are shares but the accuracy, which is left
/// out where no ball was kicked.
pub struct MujocoJudge<'a> {
    config: JudgeConfig,
    threads: usize,
    failed: Box<dyn FnMut(&EvalError) + 'a>,
}

impl<'a> MujocoJudge<'a> {
    /// A judge on `threads` threads. A policy that cannot be scored has no figures; `failed` receives the reason.
    ///
    /// # Errors
    /// If MuJoCo is missing.
    pub fn new(
        config: JudgeConfig,
        threads: usize,
        failed: impl FnMut(&EvalError) + 'a,
    ) -> Result<Self, EvalError> {
        Engines::Mujoco.check()?;
        Ok(Self { config, threads, failed: Box::new(failed) })
    }

    fn figures(&self, policy: &Path) -> Result<Named, EvalError> {
        let spec = SubjectSpec { engines: Engines::Both, threads: self.threads, ..SubjectSpec::new(policy) };
        let subject = Subject::load(&spec)?;
        subject.require_ball()?;
        let options = ShootingOptions {
            grid: Grid::EFFECTIVE,
            trials: self.config.shots / JudgeConfig::PLACES,
            ..ShootingOptions::default()
        };
        let mut figures = Named::default();
        add(&mut figures, "mujoco", &evaluate(&subject.in_mujoco(), &*subject.maker, &options)?);
        add(&mut figures, "builtin", &evaluate(&subject.setup, &*subject.maker, &options)?);
        Ok(figures)
    }
}

fn add(figures: &mut Named, engine: &str, report: &ShootingReport) {
    let total = &report.total;
    figures.push(format!("{engine}_goal"), total.success.share);
    if let Some(accuracy) = total.accuracy {
        figures.push(format!("{engine}_accuracy"), accuracy);
    }
    figures.push(format!("{engine}_falls"), total.falls_ever.share);
}

impl Judge for MujocoJudge<'_> {
    fn score(&mut self, policy: &Path) -> Named {
        self.figures(policy).unwrap_or_else(|error| {
            (self.failed)(&error);
            Named::default()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_judges_places_are_the_effective_workspace() {
        let Grid { x, y, step } = Grid::EFFECTIVE;
        let along = |[lo, hi]: [f64; 2]| ((hi - lo) / step).round() as usize + 1;
        assert_eq!(along(x) * along(y), JudgeConfig::PLACES);
    }

    #[test]
    fn a_policy_that_cannot_be_read_has_no_figures_and_says_why() {
        if paid_testing::mujoco("a_policy_that_cannot_be_read", paid_mujoco::Library::get()).is_none() {
            return;
        }
        let mut heard = String::new();
        {
            let failed = |error: &EvalError| heard = error.to_string();
            let mut judge = MujocoJudge::new(JudgeConfig::default(), 1, failed).expect("MuJoCo is here");
            assert!(judge.score(Path::new("absent.safetensors")).is_empty());
        }
        assert!(heard.contains("absent.safetensors"), "{heard}");
    }
}
