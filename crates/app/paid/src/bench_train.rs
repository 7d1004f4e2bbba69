//! `paid bench train`.

use std::path::PathBuf;
use std::process::ExitCode;

use paid_train::{RunPreset, TrainBench, bench_train};

use crate::failure::Failure;
use crate::threads::thread_count;
use crate::train::motions_value;

/// Arguments of `paid bench train`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder of motion files [default: the built-in kicks].
    ///
    /// Files end in .npz, .csv or .pkl, and are searched recursively.
    #[arg(long, value_name = "DIR")]
    motions: Option<PathBuf>,
    /// Run preset to measure [default: MLP at 2 and at 5 epochs, LSTM at 2].
    #[arg(long, value_name = "NAME|FILE")]
    preset: Option<String>,
    /// Environments.
    #[arg(long, value_name = "N", default_value_t = 4096)]
    envs: usize,
    /// Duration of each measurement [s].
    #[arg(long, value_name = "S", default_value_t = 10.0)]
    seconds: f64,
    /// Worker threads [default: all cores].
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// Change a preset value (repeatable).
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,
    /// Print one line of JSON per measurement.
    #[arg(long)]
    json: bool,
}

/// What is measured without `--preset`: title, preset, override.
const CASES: [(&str, &str, &str); 3] = [
    ("MLP, 2 epochs", "stage1", "learn.ppo.epochs=2"),
    ("MLP, 5 epochs", "stage1", "learn.ppo.epochs=5"),
    ("LSTM 1x128 and an MLP critic, 2 epochs", "recurrent", "learn.ppo.epochs=2"),
];

/// Longest measurement `[s]`.
const MOST_S: f64 = 3600.0;

/// Measures and prints.
pub fn run(args: Args) -> Result<ExitCode, Failure> {
    if !(args.seconds > 0.0 && args.seconds <= MOST_S) {
        let found = args.seconds;
        return Err(Failure::input(format!("--seconds: expected above 0, at most {MOST_S}, found {found}")));
    }
    let threads = thread_count(args.threads)?;
    let mut cases: Vec<(String, &str, Option<&str>)> =
        CASES.iter().map(|(title, preset, set)| ((*title).to_owned(), *preset, Some(*set))).collect();
    if let Some(preset) = &args.preset {
        cases = vec![(preset.clone(), preset, None)];
    }
    for (title, preset, set) in cases {
        let mut sets: Vec<String> = set.into_iter().map(str::to_owned).collect();
        sets.push(format!("run.envs={}", args.envs));
        if let Some(motions) = &args.motions {
            sets.push(motions_value(motions));
        }
        sets.extend(args.sets.iter().cloned());
        let preset = RunPreset::resolve(preset, &sets).map_err(Failure::input)?;
        let found = bench_train(&title, &preset, threads, args.seconds).map_err(Failure::input)?;
        if args.json {
            println!("{}", serde_json::to_string(&found).map_err(Failure::input)?);
        } else {
            print(&found);
        }
    }
    Ok(ExitCode::SUCCESS)
}

fn print(found: &TrainBench) {
    println!(
        "{}: {} environments in {} shards, {} threads, {}, products in {}, {} iterations",
        found.name, found.envs, found.shards, found.threads, found.isa, found.products, found.iterations
    );
    for (part, rate) in [
        ("training, end to end", found.samples_per_s),
        ("physics and task alone", found.env_samples_per_s),
        ("rollout forward alone", found.forward_samples_per_s),
        ("update alone", found.update_samples_per_s),
        ("the three parts added up", found.parts_samples_per_s),
    ] {
        println!("  {part:<26} {rate:>10.0} samples/s");
    }
    println!("  whole over parts           {:>10.2}", found.ratio);
    if let Some(plain) = &found.f32 {
        println!(
            "  in f32, end to end         {:>10.0} samples/s: {:.2} times slower",
            plain.samples_per_s, plain.gain
        );
        println!(
            "  in f32, update alone       {:>10.0} samples/s: {:.2} times slower",
            plain.update_samples_per_s, plain.update_gain
        );
    }
    println!("  peak memory                {:>10.0} MiB", found.peak_rss_mib);
}
