//! The command line of PAiD: parse, call, print. One module per subcommand group.

// The help texts are doc comments. Units stand in brackets there and are no links.
#![allow(rustdoc::broken_intra_doc_links)]

mod ablate;
mod agent;
mod bench;
mod bench_physics;
mod bench_train;
mod compare;
mod curves;
mod eval;
mod export;
mod failure;
mod live;
mod motion;
mod perceive;
mod play;
mod ranks;
mod robot;
mod stop;
mod sysid;
mod task;
mod threads;
mod train;
mod viewer;

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
    Perceive(perceive::Args),
    /// Find out how a ball bounces and rolls from filmed experiments.
    Sysid(Box<sysid::Args>),
    /// Repeat the paper's ablation: train with and without identification and observation noise, and judge in MuJoCo.
    Ablate(Box<ablate::Args>),
    /// Train several methods from one plan, each with the same budget, judge them alike in MuJoCo, and print the table.
    Compare(compare::Args),
    /// List what a task is made of.
    Task(task::Args),
    /// Run a task under a zero or random agent and print the mean of each reward and observation term.
    Agent(agent::Args),
    /// Take a policy to a Unitree G1, virtual or real.
    Robot(Box<robot::Args>),
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
        Command::Curves(args) => curves::run(&args),
        Command::Bench(args) => bench::run(args),
        Command::Perceive(args) => perceive::run(&args),
        Command::Sysid(args) => sysid::run(*args),
        Command::Ablate(args) => ablate::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Task(args) => task::run(&args),
        Command::Agent(args) => agent::run(args),
        Command::Robot(args) => robot::run(*args),
    };
    match result {
        Ok(code) => code,
        Err(failure) => {
            eprintln!("error: {failure}");
            failure.exit_code()
        }
    }
}
