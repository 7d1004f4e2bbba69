//! `paid agent`: a task under a zero or random agent.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::ValueEnum;
use paid_task::{Agent, AgentReport, TermStatistics, observe_agent};
use paid_train::{RunPreset, Scene};
use serde::Serialize;

use crate::failure::Failure;
use crate::train::{motion_folder, motions_value, whole};

/// Arguments of `paid agent`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Actions of the agent.
    #[arg(value_enum)]
    agent: Kind,
    /// Run preset: built in, or a file.
    #[arg(long, value_name = "NAME|FILE", default_value = "stage1")]
    preset: String,
    /// Folder of motion files [default: the built-in kicks].
    ///
    /// Files end in .npz, .csv or .pkl, and are searched recursively.
    #[arg(long, value_name = "DIR")]
    motions: Option<PathBuf>,
    /// Control steps.
    #[arg(long, value_name = "N", default_value_t = 500)]
    steps: usize,
    /// Environments; a multiple of the instruction set's lanes (at most 16).
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = envs)]
    envs: usize,
    /// Seed of all random numbers.
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Change a preset value, such as task.rewards.action_rate.weight=-0.05 (repeatable).
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,
    /// Print one line of JSON.
    #[arg(long)]
    json: bool,
}

/// Environments at most, as in a run preset.
const MOST_ENVS: usize = 1_000_000;

fn envs(text: &str) -> Result<usize, String> {
    let found = text.parse().ok().filter(|envs| (1..=MOST_ENVS).contains(envs));
    found.ok_or_else(|| format!("expected 1 to {MOST_ENVS}, found '{text}'"))
}

/// Values that this command sets itself, and what to use instead of `--set`.
const OWN: [(&str, &str); 3] =
    [("run.envs", "--envs"), ("run.seed", "--seed"), ("run.shards", "the one shard of an agent")];

/// Refuses a change of a value that this command sets itself: it would be lost.
fn refuse_own(sets: &[String]) -> Result<(), Failure> {
    for set in sets {
        let key = set.split('=').next().unwrap_or_default().trim();
        if let Some((_, instead)) = OWN.iter().find(|(own, _)| *own == key) {
            return Err(Failure::input(format!("--set {key}: expected {instead}, found '{set}'")));
        }
    }
    Ok(())
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Kind {
    /// Holds the default pose.
    Zero,
    /// Standard normal actions.
    Random,
}

#[derive(Serialize)]
struct Report<'a> {
    preset: &'a str,
    steps: usize,
    envs: usize,
    metrics: serde_json::Map<String, serde_json::Value>,
    policy_observation: &'a [TermStatistics],
    critic_observation: &'a [TermStatistics],
}

/// Runs the agent and prints each term's mean.
pub fn run(args: Args) -> Result<ExitCode, Failure> {
    let mut sets = whole(&args.sets)?;
    refuse_own(&sets)?;
    sets.extend([
        format!("run.envs={}", args.envs),
        "run.shards=1".to_owned(),
        format!("run.seed={}", args.seed),
    ]);
    if let Some(motions) = &args.motions {
        motion_folder(motions)?;
        sets.push(motions_value(motions));
    }
    let preset = RunPreset::resolve(&args.preset, &sets).map_err(Failure::input)?;
    let scene = Scene::load(&preset).map_err(Failure::input)?;
    let mut shards = scene.shards(&preset).map_err(Failure::input)?;
    let agent = match args.agent {
        Kind::Zero => Agent::Zero,
        Kind::Random => Agent::Random,
    };
    let shard = shards.first_mut().ok_or_else(|| Failure::input("run.shards: expected 1, found 0"))?;
    let report = observe_agent(shard.as_mut(), agent, args.steps, args.seed).map_err(Failure::input)?;
    if args.json {
        let metrics = report.metrics.summary().into_iter().map(|(name, x)| (name, x.into())).collect();
        let line = serde_json::to_string(&Report {
            preset: &args.preset,
            steps: args.steps,
            envs: args.envs,
            metrics,
            policy_observation: &report.policy,
            critic_observation: &report.critic,
        });
        println!("{}", line.map_err(Failure::input)?);
    } else {
        print(&args, &report);
    }
    Ok(ExitCode::SUCCESS)
}

fn print(args: &Args, report: &AgentReport) {
    println!("{}: {} steps of {} environments", args.preset, args.steps, args.envs);
    println!("\n{:<36} {:>12}", "figure", "mean");
    for (name, value) in report.metrics.summary() {
        println!("{name:<36} {value:>12.5}");
    }
    for (group, terms) in [("policy", &report.policy), ("critic", &report.critic)] {
        println!(
            "\n{:<36} {:>12} {:>12} {:>12} {:>12}",
            format!("{group} observation"),
            "mean",
            "std",
            "min",
            "max"
        );
        for t in terms {
            println!("{:<36} {:>12.5} {:>12.5} {:>12.5} {:>12.5}", t.name, t.mean, t.std, t.min, t.max);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_that_the_command_would_overwrite_is_refused_with_its_option() {
        let error = refuse_own(&["run.envs=128".to_owned()]).expect_err("refused").to_string();
        assert_eq!(error, "--set run.envs: expected --envs, found 'run.envs=128'");
        let error = refuse_own(&["run.seed = 3".to_owned()]).expect_err("refused").to_string();
        assert_eq!(error, "--set run.seed: expected --seed, found 'run.seed = 3'");
        assert!(refuse_own(&["run.isa=portable".to_owned(), "task.scene.gravity=9.8".to_owned()]).is_ok());
    }
}
