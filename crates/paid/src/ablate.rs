//! `paid ablate`: the paper's ablation of its third stage. Each variant is trained from one policy and judged by MuJoCo.

mod judge;
mod result;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use paid_eval::file::write_whole;
use paid_mujoco::Library;
use paid_train::folder::PRESET_FILE;
use paid_train::{End, Limits, RunPreset, StageJob, Start, train_stage};

use crate::failure::Failure;
use crate::stop::{self, STOPPED};
use crate::train::{motions_value, thread_count};
use judge::{Judge, Settings};
use result::{Score, Scores};

/// What is compared: the table's name and the run preset.
const VARIANTS: [(&str, &str); 3] = [
    ("full", "stage3"),
    ("w/o identification", "stage3_no_sysid"),
    ("w/o observation noise", "stage3_no_noise"),
];
/// Where it is judged: surfaces of `configs/surfaces`.
const SURFACES: [&str; 2] = ["hard", "grass"];

/// Arguments of `paid ablate`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Run folder (the mean of its last checkpoints) or checkpoint of the policy (Stage I or II) that every variant starts from.
    #[arg(long, value_name = "RUN|CHECKPOINT")]
    from: PathBuf,
    /// Folder of the motion files [default: the built-in kicks].
    #[arg(long, value_name = "DIR")]
    motions: Option<PathBuf>,
    /// Output folder; a variant that was trained or judged there is not trained or judged again.
    #[arg(long, value_name = "DIR", default_value = "runs/ablate")]
    out: PathBuf,
    /// Training iterations of every variant [default: the presets'].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    iterations: Option<u64>,
    /// Training samples of every variant, rounded up to whole iterations.
    #[arg(long, value_name = "N", conflicts_with = "iterations", value_parser = clap::value_parser!(u64).range(1..))]
    samples: Option<u64>,
    /// Change a preset value of every variant (repeatable).
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,
    #[command(flatten)]
    settings: Settings,
    /// Worker threads; the result does not depend on it [default: all cores].
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// Print the table as one line of JSON.
    #[arg(long)]
    json: bool,
}

/// Trains and judges every variant, or takes up what an earlier call left.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    args.settings.check()?;
    let threads = thread_count(args.threads)?;
    Library::get().map_err(Failure::input)?;
    let stop = stop::flag()?;
    let mut presets = Vec::new();
    for (_, name) in VARIANTS {
        presets.push(preset(args, name)?);
    }
    let mut scores = Scores { settings: args.settings.clone(), scores: Vec::new() };
    for ((variant, name), preset) in VARIANTS.into_iter().zip(presets) {
        let folder = args.out.join(name);
        let taken = folder.join(PRESET_FILE).exists();
        if taken {
            same_preset(&folder, &preset)?;
        }
        let start = if taken { Start::Resume } else { Start::From(args.from.clone()) };
        let iterations = preset.run.iterations;
        let job = StageJob { preset, out: folder.clone(), start, limits: Limits::default(), threads };
        let mut said = 0;
        let outcome = train_stage(&job, &stop, &mut |record| {
            let tenth = record.iteration * 10 / iterations.max(1);
            if tenth > said {
                said = tenth;
                eprintln!("{variant}: {}% of {iterations} iterations", 10 * tenth);
            }
        })
        .map_err(Failure::input)?;
        if outcome.end == End::Stopped {
            return Ok(ExitCode::from(STOPPED));
        }
        // All variants are judged alike: seen as the complete one is trained to see, and late.
        let judge =
            Judge::new(&outcome.checkpoint, &self::preset(args, VARIANTS[0].1)?, &args.settings, threads)?;
        for surface in SURFACES {
            let file = folder.join(format!("{surface}.json"));
            let known = Score::read(&file)?.filter(|score| score.is_of(&args.settings, outcome.samples));
            let score = match known {
                Some(score) => score,
                None => {
                    let Some(score) = judge.score(variant, surface, outcome.samples)? else {
                        return Ok(ExitCode::from(STOPPED));
                    };
                    let text = serde_json::to_string_pretty(&score).map_err(Failure::input)?;
                    write_whole(&file, text.as_bytes()).map_err(Failure::input)?;
                    score
                }
            };
            eprintln!("{variant}, {surface}: {}", score.workspace.text());
            scores.scores.push(score);
        }
    }
    finish(args, &scores)?;
    Ok(ExitCode::SUCCESS)
}

fn finish(args: &Args, scores: &Scores) -> Result<(), Failure> {
    let table = scores.table();
    let json = serde_json::to_string(scores).map_err(Failure::input)?;
    write_whole(&args.out.join("ablation.txt"), table.as_bytes()).map_err(Failure::input)?;
    write_whole(&args.out.join("ablation.json"), json.as_bytes()).map_err(Failure::input)?;
    if args.json {
        println!("{json}");
    } else {
        print!("{table}");
    }
    Ok(())
}

/// A variant's run preset with the budget and the changes that were asked for.
fn preset(args: &Args, name: &str) -> Result<RunPreset, Failure> {
    let mut sets = args.sets.clone();
    if let Some(motions) = &args.motions {
        sets.push(motions_value(motions));
    }
    let mut preset = RunPreset::resolve(name, &sets).map_err(Failure::input)?;
    let an_iteration = (preset.run.envs * preset.learn.ppo.horizon) as u64;
    if let Some(iterations) = args.iterations.or(args.samples.map(|s| s.div_ceil(an_iteration))) {
        preset.run.iterations = iterations;
    }
    Ok(preset)
}

/// Refuses to go on with a run of other values; only its length may differ.
fn same_preset(folder: &Path, wanted: &RunPreset) -> Result<(), Failure> {
    let mut found = RunPreset::of_run(folder, &[]).map_err(Failure::input)?;
    found.run.iterations = wanted.run.iterations;
    if found == *wanted {
        return Ok(());
    }
    Err(Failure::input(format!(
        "{}: expected a run with the preset and the --set values of this call, found another; choose another --out",
        folder.join(PRESET_FILE).display()
    )))
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
}
