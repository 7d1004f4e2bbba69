//! `paid-robot`: what a robot's computer needs of `paid robot`, without training, evaluation and simulation.

use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use paid_robot_program::{CheckArgs, ReplayArgs, RunArgs, check, replay, run};
use paid_terminal::{EXIT_CODES, end_with_the_reader, prepared};

/// Run a policy on a Unitree G1.
#[derive(Debug, Parser)]
#[command(name = "paid-robot", version, after_help = EXIT_CODES)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Run a policy on the robot: damping, stand up, wait for a ball, kick, settle.
    Run(Box<RunArgs>),
    /// Check the robot's states, rates and joints. Sends no commands.
    Check(CheckArgs),
    /// Run a log through the runtime again, and compare the results bit for bit.
    Replay(ReplayArgs),
}

fn main() -> ExitCode {
    end_with_the_reader();
    let mut command = prepared(Cli::command());
    let matches = command.clone().get_matches();
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|error| error.format(&mut command).exit());
    let result = match cli.command {
        Command::Run(args) => run(&args, |_, _| Ok(None)),
        Command::Check(args) => check(&args),
        Command::Replay(args) => replay(&args, |_| Ok(())),
    };
    result.unwrap_or_else(|failure| {
        paid_terminal::eprintln!("error: {failure}");
        failure.exit_code()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_well_formed() {
        prepared(Cli::command()).debug_assert();
    }
}
