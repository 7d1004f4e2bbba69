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
use paid_terminal::{EXIT_CODES, end_with_the_reader, prepared};

/// Train a humanoid to kick a ball on a CPU, score it in MuJoCo, and run it on the robot.
#[derive(Debug, Parser)]
#[command(name = "paid", version, after_help = EXIT_CODES)]
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
    /// Score a policy on random shots: a result, images, a recording and a report.
    ///
    /// Without --policy it is the policy that this program contains.
    Demo(eval::demo::Args),
    /// Generate, check, convert and retarget motion files.
    Motion(motion::Args),
    /// Show a motion or an episode of a policy, as images, in a browser or in Rerun.
    Play(Box<play::Args>),
    /// Write a policy as an ONNX file.
    Export(export::Args),
    /// Plot a training run, and thin its log so that it can be committed.
    Curves(curves::Args),
    /// Measure the speed of physics and training.
    Bench(bench::Args),
    /// Train, evaluate and calibrate ball detection and odometry.
    #[cfg(feature = "full")]
    Perceive(perceive::Args),
    /// Train, evaluate and calibrate ball detection and odometry (needs --features full).
    #[cfg(not(feature = "full"))]
    Perceive(left_out::Args),
    /// Identify how a ball bounces and rolls from filmed experiments.
    Sysid(Box<sysid::Args>),
    /// Train several methods with equal budgets and compare their scores in MuJoCo.
    Compare(compare::Args),
    /// List the reward, termination and observation terms.
    Task(task::Args),
    /// Run a task with zero or random actions, and print the mean of each term.
    Agent(agent::Args),
    /// Run a policy on a Unitree G1, virtual or real.
    #[cfg(feature = "full")]
    Robot(Box<robot::Args>),
    /// Run a policy on a Unitree G1, virtual or real (needs --features full).
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

/// The commands as `paid --help` groups them.
const GROUPS: [(&str, &[&str]); 6] = [
    ("Start here", &["demo"]),
    ("Train and score", &["train", "eval", "compare", "export"]),
    ("Look", &["play", "curves"]),
    ("Motions and ball", &["motion", "sysid"]),
    ("Robot", &["robot", "perceive"]),
    ("Develop", &["task", "agent", "bench"]),
];

/// The command line.
fn command() -> clap::Command {
    let command = prepared(Cli::command());
    let mut list = String::new();
    for (title, names) in GROUPS {
        list += &format!("  {title}\n");
        for command in names.iter().filter_map(|name| command.find_subcommand(name)) {
            let about = command.get_about().map(ToString::to_string).unwrap_or_default();
            list += &format!("    {:<10}{about}\n", command.get_name());
        }
    }
    let usage = "{about-with-newline}\n{usage-heading} {usage}";
    let more = "Options:\n{options}\n\n'paid COMMAND -h' shows the common options of a command, '--help' all of them.";
    command.help_template(format!("{usage}\n\nCommands:\n{list}\n{more}{{after-help}}"))
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

    #[test]
    fn every_command_is_in_one_group_of_the_help() {
        let command = command();
        let names = command.get_subcommands().map(clap::Command::get_name).filter(|name| *name != "help");
        let mut grouped: Vec<&str> = GROUPS.iter().flat_map(|(_, names)| names.iter().copied()).collect();
        let mut names: Vec<&str> = names.collect();
        grouped.sort_unstable();
        names.sort_unstable();
        assert_eq!(grouped, names);
    }

    /// Of the command and all below it.
    fn fits_a_screen(command: &mut clap::Command, path: &str) {
        let help = command.render_help().to_string();
        let wide = help.lines().find(|line| line.chars().count() > 100);
        assert!(wide.is_none(), "{path} -h: {wide:?}");
        assert!(help.lines().count() <= LINES, "{path} -h has {} lines:\n{help}", help.lines().count());
        for below in command.get_subcommands_mut() {
            let path = format!("{path} {}", below.get_name());
            fits_a_screen(below, &path);
        }
    }

    /// Lines of a command's `-h`.
    const LINES: usize = 40;

    #[test]
    fn the_short_help_of_every_command_fits_a_screen() {
        let mut command = command().term_width(100);
        command.build();
        fits_a_screen(&mut command, "paid");
    }
}
