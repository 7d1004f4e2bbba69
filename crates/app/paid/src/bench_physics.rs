//! `paid bench physics`: steps per second of the built-in engine and of MuJoCo in the same scene.

use std::process::ExitCode;

use clap::Parser;
use paid_lab::bench::{BenchOptions, PhysicsBench, bench_physics};

use crate::failure::Failure;
use crate::threads::thread_count;

/// Arguments of `paid bench physics`.
#[derive(Debug, Parser)]
pub struct Args {
    /// Instruction set: auto, avx512, avx2 or portable.
    #[arg(long, default_value = "auto")]
    isa: String,
    /// Environments per core in the built-in engine.
    ///
    /// Rounded up to whole groups of lanes.
    #[arg(long, default_value_t = 512, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    envs: u32,
    /// Duration of each measurement [s].
    #[arg(long, default_value_t = 0.5)]
    seconds: f64,
    /// Rounds; the engines take turns, and the median round counts.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1000))]
    rounds: u32,
    /// Threads of the measurement on all cores; 0 for one per core.
    #[arg(long, default_value_t = 0)]
    threads: usize,
    /// Also measure the built-in engine's other kinds of contacts and controllers.
    ///
    /// Soft and hard contacts, each friction cone, and so on.
    #[arg(long)]
    kinds: bool,
    /// Do not measure MuJoCo.
    #[arg(long)]
    no_mujoco: bool,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Measures and prints.
pub fn run(args: Args) -> Result<ExitCode, Failure> {
    let mut report = bench_physics(&BenchOptions {
        isa: args.isa.parse().map_err(Failure::input)?,
        envs: args.envs as usize,
        seconds: args.seconds,
        rounds: args.rounds,
        threads: thread_count((args.threads > 0).then_some(args.threads))?,
        kinds: args.kinds,
        mujoco: !args.no_mujoco,
    })?;
    if args.no_mujoco {
        report.mujoco_missing = Some("left out by --no-mujoco".to_owned());
    }
    if args.json {
        println!("{}", serde_json::to_string_pretty(&report).map_err(Failure::input)?);
    } else {
        print(&report);
    }
    Ok(ExitCode::SUCCESS)
}

fn print(report: &PhysicsBench) {
    println!(
        "{} ({} lanes), {} environments per core, {} cores; physics step {} s, {} per control step",
        report.isa, report.lanes, report.envs_per_core, report.cores, report.physics_dt_s, report.substeps
    );
    println!("thousand steps/s; 'one core' by processor time, 'wall' and 'all cores' by wall-clock time");
    println!(
        "{:33}{:>10}{:>10}{:>10}{:>10}{:>10}{:>9}{:>7}",
        "", "one core", "control", "wall", "all cores", "contacts", "on feet", "ratio"
    );
    for row in &report.rows {
        let optional = |x: Option<f64>| x.map_or_else(|| "-".to_owned(), |x| format!("{x:.1}"));
        println!(
            "{:33}{:>10.1}{:>10.1}{:>10.1}{:>10.1}{:>10}{:>8.0}%{:>7}",
            format!("{}, {}", row.simulator, row.scene),
            row.one_core.physics_steps_per_core_s / 1e3,
            row.one_core.control_steps_per_core_s / 1e3,
            row.one_core.physics_steps_per_s / 1e3,
            row.all_cores.physics_steps_per_s / 1e3,
            optional(row.mean_contacts),
            100.0 * row.foot_contact_share,
            optional(row.engine_is_faster_by.map(|r| r[0])),
        );
    }
    if let Some(reason) = &report.mujoco_missing {
        println!("MuJoCo: {reason}");
    }
}
