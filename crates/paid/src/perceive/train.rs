//! `paid perceive train`: a ball detector from rendered pictures.

use std::path::PathBuf;

use crate::failure::Failure;

/// Arguments of `paid perceive train`. The defaults are those of the committed network.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// ONNX file to write, now and then and at the end.
    #[arg(long, value_name = "FILE", default_value = "ball.onnx")]
    out: PathBuf,
    /// Steps of the optimizer.
    #[arg(long, default_value_t = 2800)]
    steps: u32,
    /// Windows of 160 x 96 pixels a step.
    #[arg(long, default_value_t = 16)]
    batch: u32,
    /// Largest learning rate.
    #[arg(long, default_value_t = 3e-3)]
    rate: f64,
    /// Numbers the scenes and the first weights.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// Trains and prints the loss.
#[cfg(feature = "train-detector")]
pub fn run(args: &Args) -> Result<(), Failure> {
    use paid_vision::train::{TrainOptions, train};

    let options = TrainOptions {
        steps: args.steps,
        batch: args.batch,
        rate: args.rate,
        seed: args.seed,
        ..TrainOptions::default()
    };
    train(&options, &args.out, |progress| {
        println!("step {:>6}: heat {:.3}, place {:.3}", progress.step, progress.heat, progress.place);
    })
    .map_err(Failure::input)?;
    println!("{}", args.out.display());
    Ok(())
}

/// Says what is missing.
#[cfg(not(feature = "train-detector"))]
pub fn run(args: &Args) -> Result<(), Failure> {
    Err(Failure::input(format!(
        "this program was built without training of detectors; {} is written by one built with it: cargo run --release --features \
         train-detector -- perceive train --steps {} --batch {} --rate {} --seed {}",
        args.out.display(),
        args.steps,
        args.batch,
        args.rate,
        args.seed
    )))
}
