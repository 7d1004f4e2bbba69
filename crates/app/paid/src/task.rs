//! `paid task`: what a task is made of.

use std::process::ExitCode;

use paid_task::{TermInfo, terms_table};

use crate::failure::Failure;

/// Arguments of `paid task`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, clap::Subcommand)]
enum Command {
    /// List each term that a preset can use: unit, frame, parameters, defaults and their reasons.
    Terms {
        /// Print one line of JSON.
        #[arg(long)]
        json: bool,
    },
}

/// Runs a subcommand.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    match args.command {
        Command::Terms { json: true } => {
            println!("{}", serde_json::to_string(&terms_table()).map_err(Failure::input)?);
        }
        Command::Terms { json: false } => print(&terms_table()),
    }
    Ok(ExitCode::SUCCESS)
}

fn print(table: &[TermInfo]) {
    let mut kind = "";
    for term in table {
        if term.kind != kind {
            println!("{}{} terms", if kind.is_empty() { "" } else { "\n" }, term.kind);
            kind = term.kind;
        }
        let needs = if term.needs.is_empty() {
            String::new()
        } else {
            format!(", needs {}", term.needs.join(" and "))
        };
        println!("  {} {}, frame: {}{needs}", term.name, bracketed(term.unit), term.frame);
        println!("      {}", term.summary);
        for p in &term.parameters {
            let unit = bracketed(p.unit);
            println!("      {} = {} {unit}: {} Default: {}.", p.name, p.default, p.summary, p.reason);
        }
    }
}

/// A unit as it is written after a name; `[-]` for pure numbers.
fn bracketed(unit: &str) -> String {
    if unit.is_empty() { "[-]".to_owned() } else { format!("[{unit}]") }
}
