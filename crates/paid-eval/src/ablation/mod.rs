//! The paper's ablation of its third stage: each variant is trained from one policy, and MuJoCo judges it on the shipped surfaces.

mod judge;
mod score;

use std::path::Path;

use paid_train::RunPreset;
use paid_train::folder::PRESET_FILE;

use crate::EvalError;

pub use judge::{Judge, JudgeSettings, knowledge};
pub use score::{Count, Score, Scores};

/// What is compared: the name in the table and the run preset. The first one is complete.
pub const VARIANTS: [(&str, &str); 3] = [
    ("full", "stage3"),
    ("w/o identification", "stage3_no_sysid"),
    ("w/o observation noise", "stage3_no_noise"),
];
/// Where it is judged: surfaces of `configs/surfaces`.
pub const SURFACES: [&str; 2] = ["hard", "grass"];

/// How long every variant is trained.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Budget {
    /// As its preset says.
    #[default]
    Preset,
    /// So many iterations.
    Iterations(u64),
    /// So many samples, rounded up to whole iterations.
    Samples(u64),
}

/// A variant's run preset with changed values and a budget.
///
/// # Errors
/// If the preset does not exist or a value does not fit.
pub fn variant_preset(name: &str, overrides: &[String], budget: Budget) -> Result<RunPreset, EvalError> {
    let mut preset = RunPreset::resolve(name, overrides)?;
    let samples_per_iteration = (preset.run.envs * preset.learn.ppo.horizon) as u64;
    match budget {
        Budget::Preset => {}
        Budget::Iterations(iterations) => preset.run.iterations = iterations,
        Budget::Samples(samples) => preset.run.iterations = samples.div_ceil(samples_per_iteration),
    }
    Ok(preset)
}

/// True if the run in `folder` may be continued with `wanted`: it has the same values, but for its length.
///
/// # Errors
/// If the run's preset cannot be read.
pub fn is_same_run(folder: &Path, wanted: &RunPreset) -> Result<bool, EvalError> {
    let mut found = RunPreset::of_run(folder, &[])?;
    found.run.iterations = wanted.run.iterations;
    Ok(found == *wanted)
}

/// True if there is a run in `folder`.
pub fn has_run(folder: &Path) -> bool {
    folder.join(PRESET_FILE).exists()
}

#[cfg(test)]
mod tests {
    use paid_sysid::Surface;
    use paid_task::preset::SurfacePreset;

    use super::*;

    #[test]
    fn the_training_surfaces_are_the_shipped_ones_and_variants_differ_in_one_thing() {
        let [full, no_sysid, no_noise] =
            VARIANTS.map(|(_, name)| RunPreset::resolve(name, &[]).expect(name).task);
        let shipped =
            SURFACES.map(|name| SurfacePreset::of(name, &Surface::load(name).expect(name).ball_params));
        assert_eq!(full.randomization.surfaces, shipped);
        let mut restored = no_sysid.clone();
        restored.randomization.surfaces.clone_from(&full.randomization.surfaces);
        restored.name.clone_from(&full.name);
        assert_eq!(restored, full);
        assert_eq!(no_sysid.randomization.surfaces.len(), 1);
        let mut restored = no_noise;
        assert!(!restored.observations.perception.gaussian);
        restored.observations.perception.gaussian = true;
        restored.name.clone_from(&full.name);
        assert_eq!(restored, full);
    }

    #[test]
    fn samples_are_rounded_up_to_whole_iterations() {
        let overrides = ["run.envs=32", "run.shards=2"].map(str::to_owned);
        let of = |budget| variant_preset("stage3", &overrides, budget).expect("built in").run;
        let horizon =
            variant_preset("stage3", &overrides, Budget::Preset).expect("built in").learn.ppo.horizon;
        let one = (32 * horizon) as u64;
        assert_eq!(of(Budget::Samples(3 * one)).iterations, 3);
        assert_eq!(of(Budget::Samples(3 * one + 1)).iterations, 4);
        assert_eq!(of(Budget::Iterations(7)).iterations, 7);
    }
}
