//! `paid perceive train`: a ball detector from rendered images.

use std::path::PathBuf;
use std::process::ExitCode;

use crate::failure::Failure;

/// Arguments of `paid perceive train`. The defaults are those of the committed network.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// ONNX file to write, from time to time and at the end.
    #[arg(long, value_name = "FILE", default_value = "ball.onnx")]
    out: PathBuf,
    /// Optimizer steps.
    #[arg(long, default_value_t = 26_000)]
    steps: u32,
    /// Crops of 160 x 96 pixels per step.
    #[arg(long, default_value_t = 16)]
    batch: u32,
    /// Largest learning rate.
    #[arg(long, default_value_t = 2e-3)]
    rate: f64,
    /// Seed of the scenes and of the initial weights.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Print only the file at the end.
    #[arg(long, conflicts_with = "json")]
    quiet: bool,
    /// Print JSON lines.
    #[arg(long)]
    json: bool,
}

/// Trains and prints the loss; ends with 130 after Ctrl-C.
#[cfg(feature = "train-detector")]
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    use paid_vision::train::{TrainOptions, train};

    crate::eval::out::writable_file("--out", &args.out)?;
    let options = TrainOptions {
        steps: args.steps,
        batch: args.batch,
        rate: args.rate,
        seed: args.seed,
        ..TrainOptions::default()
    };
    let stop = paid_terminal::flag()?;
    let start = std::time::Instant::now();
    let done = train(&options, &args.out, &stop, |progress| {
        let (step, elapsed) = (progress.step, start.elapsed().as_secs_f64());
        let left = elapsed / f64::from(step) * f64::from(options.steps - step);
        if args.json {
            let line = serde_json::json!({
                "step": step, "heat": progress.heat, "place": progress.place, "elapsed_s": elapsed, "eta_s": left
            });
            println!("{line}");
        } else if !args.quiet {
            let (heat, place) = (progress.heat, progress.place);
            println!(
                "step {step:>6} of {}  heat {heat:.3}  place {place:.3}  elapsed {:.0} s  ETA {left:.0} s",
                options.steps, elapsed
            );
        }
    })
    .map_err(Failure::input)?;
    if !args.json {
        let stopped =
            if done < options.steps { format!(", stopped after {done} steps") } else { String::new() };
        println!("{}{stopped}", args.out.display());
    }
    Ok(if done < options.steps { ExitCode::from(paid_terminal::STOPPED) } else { ExitCode::SUCCESS })
}

/// Says what is missing.
#[cfg(not(feature = "train-detector"))]
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    Err(Failure::input(format!(
        "this program cannot train detectors; to write {}, build one that can: cargo run --release --features \
         train-detector -- perceive train --steps {} --batch {} --rate {} --seed {}",
        args.out.display(),
        args.steps,
        args.batch,
        args.rate,
        args.seed
    )))
}
