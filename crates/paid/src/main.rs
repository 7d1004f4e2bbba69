//! The command line of PAiD: parse, call, print. One module a subcommand group.

mod ablate;
mod agent;
mod bench;
mod bench_physics;
mod bench_train;
mod eval;
mod export;
mod failure;
mod look;
mod motion;
mod play;
mod stop;
mod sysid;
mod task;
mod train;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Train and score a humanoid kick on a CPU.
#[derive(Debug, Parser)]
#[command(name = "paid", version, about, after_help = failure::EXIT_CODES)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Train a policy: both stages and the evaluation, or one stage.
    Train(train::Args),
    /// Score a policy.
    Eval(Box<eval::Args>),
    /// Let a policy shoot at the goal from random places: score table, pictures and a recording.
    Demo(eval::demo::Args),
    /// Make, check, convert and retarget motion files.
    Motion(motion::Args),
    /// Look at a motion, at a human and the robot that follows, or at an episode of a policy: pictures, or Rerun.
    Play(Box<play::Args>),
    /// Write a policy as ONNX.
    Export(export::Args),
    /// Measure speed.
    Bench(bench::Args),
    /// Identify how a ball bounces and rolls from filmed experiments.
    Sysid(Box<sysid::Args>),
    /// Train and judge with and without identification and observation noise.
    Ablate(Box<ablate::Args>),
    /// What a task is made of.
    Task(task::Args),
    /// Run a task under a zero or random agent and print each term's mean.
    Agent(agent::Args),
}

fn main() -> ExitCode {
    stop::end_with_the_reader();
    let result = match Cli::parse().command {
        Command::Train(args) => train::run(args),
        Command::Eval(args) => eval::run(*args),
        Command::Demo(args) => eval::demo::run(&args),
        Command::Motion(args) => motion::run(args),
        Command::Play(args) => play::run(&args),
        Command::Export(args) => export::run(args),
        Command::Bench(args) => bench::run(args),
        Command::Sysid(args) => sysid::run(*args),
        Command::Ablate(args) => ablate::run(&args),
        Command::Task(args) => task::run(&args),
        Command::Agent(args) => agent::run(args),
    };
    match result {
        Ok(code) => code,
        Err(failure) => {
            eprintln!("error: {failure}");
            failure.exit_code()
        }
    }
}
