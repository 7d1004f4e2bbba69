//! The command line of PAiD: parse, call, print. One module per subcommand group.

// The help texts are doc comments. Units stand in brackets there and are no links.
#![allow(rustdoc::broken_intra_doc_links)]

// `print` and `println` that end the program with an error.
#[macro_use]
extern crate paid_terminal;

mod agent;
mod bench;
mod bench_physics;
mod bench_train;
mod compare;
mod curves;
mod eval;
mod export;
mod failure;
#[cfg(not(feature = "full"))]
mod left_out;
mod live;
mod motion;
#[cfg(feature = "full")]
mod perceive;
mod play;
mod ranks;
#[cfg(feature = "full")]
mod robot;
mod stage_progress;
mod sysid;
mod task;
mod threads;
mod train;
mod viewer;

use std::process::ExitCode;

use clap::parser::ValueSource;
use clap::{ArgMatches, CommandFactory, FromArgMatches, Parser, Subcommand};
use paid_terminal::{EXIT_CODES, end_with_the_reader, values_may_be_negative};

/// Train and score a humanoid kick on a CPU.
#[derive(Debug, Parser)]
#[command(name = "paid", version, about, after_help = EXIT_CODES)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Train a policy: both stages and the evaluation, or one stage.
    Train(train::Args),
    /// Score a policy, or draw what it does.
    Eval(Box<eval::Args>),
    /// Watch a policy shoot at the goal from random places: a score table, pictures and a recording.
    Demo(eval::demo::Args),
    /// Make, check, convert and retarget motion files.
    Motion(motion::Args),
    /// Show a motion, a human beside the robot that follows, or an episode of a policy, as pictures or in Rerun.
    Play(Box<play::Args>),
    /// Write a policy as an ONNX file.
    Export(export::Args),
    /// Draw the course of a training, and thin its log to keep it beside the policy.
    Curves(curves::Args),
    /// Measure the speed of physics and training.
    Bench(bench::Args),
    /// Train, judge and calibrate what stands between sensors and policy.
    #[cfg(feature = "full")]
    Perceive(perceive::Args),
    /// Train, judge and calibrate what stands between sensors and policy (needs --features full).
    #[cfg(not(feature = "full"))]
    Perceive(left_out::Args),
    /// Find out how a ball bounces and rolls from filmed experiments.
    Sysid(Box<sysid::Args>),
    /// Train several methods from one plan, each with the same budget, judge them alike in MuJoCo, and print the table.
    Compare(compare::Args),
    /// List what a task is made of.
    Task(task::Args),
    /// Run a task under a zero or random agent and print the mean of each reward and observation term.
    Agent(agent::Args),
    /// Take a policy to a Unitree G1, virtual or real.
    #[cfg(feature = "full")]
    Robot(Box<robot::Args>),
    /// Take a policy to a Unitree G1, virtual or real (needs --features full).
    #[cfg(not(feature = "full"))]
    Robot(left_out::Args),
}

fn main() -> ExitCode {
    end_with_the_reader();
    let matches = command().get_matches();
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|error| error.format(&mut command()).exit());
    let given = given(&matches);
    let result = match cli.command {
        Command::Train(args) => train::run(args),
        Command::Eval(args) => eval::run(*args),
        Command::Demo(args) => eval::demo::run(&args),
        Command::Motion(args) => motion::run(args),
        Command::Play(args) => play::run(&args, &given),
        Command::Export(args) => export::run(args),
        Command::Curves(args) => curves::run(&args),
        Command::Bench(args) => bench::run(args),
        #[cfg(feature = "full")]
        Command::Perceive(args) => perceive::run(&args),
        #[cfg(not(feature = "full"))]
        Command::Perceive(args) => args.run("perceive"),
        Command::Sysid(args) => sysid::run(*args, &given),
        Command::Compare(args) => compare::run(&args),
        Command::Task(args) => task::run(&args),
        Command::Agent(args) => agent::run(args),
        #[cfg(feature = "full")]
        Command::Robot(args) => robot::run(*args),
        #[cfg(not(feature = "full"))]
        Command::Robot(args) => args.run("robot"),
    };
    match result {
        Ok(code) => code,
        Err(failure) => {
            eprintln!("error: {failure}");
            failure.exit_code()
        }
    }
}

/// The command line. A negative number is a value and no option: whoever reads it tells its range.
fn command() -> clap::Command {
    values_may_be_negative(Cli::command())
}

/// The arguments of the innermost subcommand that the user gave, by the names of their fields: what stays at its default is not there.
fn given(matches: &ArgMatches) -> Vec<String> {
    let mut innermost = matches;
    while let Some((_, of)) = innermost.subcommand() {
        innermost = of;
    }
    let by_user = |id: &&clap::Id| innermost.value_source(id.as_str()) == Some(ValueSource::CommandLine);
    innermost.ids().filter(by_user).map(ToString::to_string).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_well_formed() {
        command().debug_assert();
    }

    #[test]
    fn a_negative_number_is_a_value_of_every_option() {
        let of = |line: &[&str]| command().try_get_matches_from(line).map(|matches| given(&matches));
        let found = of(&["paid", "eval", "shooting", "--policy", "a", "--limit", "-1"]).expect("parses");
        assert!(found.iter().any(|id| id == "limit") && !found.iter().any(|id| id == "trials"), "{found:?}");
        let error = of(&["paid", "train", "--iterations", "-1"]).expect_err("refused").to_string();
        assert!(error.contains("invalid value '-1' for '--iterations"), "{error}");
    }
}
