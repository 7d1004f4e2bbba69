//! `paid curves`: the course of a training, to look at and to keep.

use std::path::PathBuf;
use std::process::ExitCode;

use paid_eval::curves::Curves;

use crate::failure::Failure;

/// Arguments of `paid curves`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Run folder.
    run: PathBuf,
    /// Folder for curves.svg, curves.png and the thinned metrics.jsonl.
    #[arg(long, value_name = "DIR", default_value = "curves")]
    out: PathBuf,
    /// Lines of the log to keep, about; the first hundred iterations all stay.
    #[arg(long, value_name = "N", default_value_t = 300)]
    lines: usize,
}

/// Reads the log, writes and says where.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let same = |a: &PathBuf, b: &PathBuf| {
        a.canonicalize().ok().zip(b.canonicalize().ok()).is_some_and(|(a, b)| a == b)
    };
    if same(&args.run, &args.out) {
        let place = args.out.display();
        return Err(Failure::input(format!(
            "--out {place}: expected a folder other than the run's, whose log it would thin"
        )));
    }
    let curves = Curves::read(&args.run)?;
    curves.write(&args.out, args.lines)?;
    println!("{0}/curves.svg, {0}/curves.png, {0}/metrics.jsonl", args.out.display());
    Ok(ExitCode::SUCCESS)
}
