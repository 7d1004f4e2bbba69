//! `paid bench physics`: steps a second of the built-in engine, and next to it of MuJoCo in the same scene.

mod clock;
mod engine;
mod mujoco;
mod workload;

use std::process::ExitCode;

use clap::Parser;
use paid_lanes::Isa;
use paid_physics::Terrain;
use serde::Serialize;

use crate::failure::Failure;
use clock::Rate;
use workload::Workload;

/// Arguments of `paid bench physics`.
#[derive(Debug, Parser)]
pub struct Args {
    /// Instruction set: auto, avx512, avx2 or portable.
    #[arg(long, default_value = "auto")]
    isa: String,
    /// Environments a core in the built-in engine; rounded up to whole lane groups.
    #[arg(long, default_value_t = 512, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    envs: u32,
    /// Seconds of each measurement.
    #[arg(long, default_value_t = 0.5)]
    seconds: f64,
    /// Rounds; engines take turns, and the median round counts.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1000))]
    rounds: u32,
    /// Threads of the measurement on all cores; 0 means one a core.
    #[arg(long, default_value_t = 0)]
    threads: usize,
    /// Leave MuJoCo out.
    #[arg(long)]
    no_mujoco: bool,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Steps a second.
#[derive(Clone, Copy, Debug, Default, Serialize)]
struct Speed {
    /// By the clock on the wall, all threads together.
    physics_steps_per_s: f64,
    control_steps_per_s: f64,
    /// By processor time, a core: holds on a busy machine too.
    physics_steps_per_core_s: f64,
    control_steps_per_core_s: f64,
}

/// One simulator in one scene.
#[derive(Clone, Debug, Serialize)]
struct Row {
    simulator: String,
    scene: String,
    one_core: Speed,
    all_cores: Speed,
    /// Share of control steps at whose end a foot presses on something, over feet and environments.
    foot_contact_share: f64,
    /// Mean height of the base over the episodes [m].
    mean_base_height_m: f64,
    /// Mean number of contacts a physics step, where the simulator counts them.
    mean_contacts: Option<f64>,
    /// How many times the built-in engine on the plane is faster on one core and on all, by processor time.
    engine_is_faster_by: Option<[f64; 2]>,
}

#[derive(Debug, Serialize)]
struct Report {
    isa: String,
    lanes: usize,
    cores: usize,
    envs_per_core: usize,
    physics_dt_s: f64,
    substeps: usize,
    rows: Vec<Row>,
    /// Why MuJoCo is not in the rows.
    mujoco_missing: Option<String>,
}

/// What can be measured: some way to step the workload.
trait Subject: Sync {
    /// Steps for about `seconds` on `threads` threads; physics steps a second.
    fn speed(&self, threads: usize, seconds: f64) -> Result<Rate, Failure>;
    /// What the robots do in the untimed first episode.
    fn row(&self) -> Result<Row, Failure>;
}

/// The median rate of the rounds as speed.
fn speed(rates: &[Rate], substeps: usize) -> Speed {
    let median = |value: fn(&Rate) -> f64| {
        let mut values: Vec<f64> = rates.iter().map(value).collect();
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    let (wall, per_core) = (median(|r| r.wall), median(|r| r.per_core));
    Speed {
        physics_steps_per_s: wall,
        control_steps_per_s: wall / substeps as f64,
        physics_steps_per_core_s: per_core,
        control_steps_per_core_s: per_core / substeps as f64,
    }
}

/// Measures and prints.
pub fn run(args: Args) -> Result<ExitCode, Failure> {
    let isa: Isa = args.isa.parse().map_err(Failure::input)?;
    if !(args.seconds > 0.0 && args.seconds <= 3600.0) {
        return Err(Failure::input(format!(
            "--seconds: expected above 0, at most 3600, found {}",
            args.seconds
        )));
    }
    let cores = match args.threads {
        0 => std::thread::available_parallelism().map_or(1, usize::from),
        n => n,
    };
    let plane = Workload::new(Terrain::Plane)?;
    let rough = Workload::new(workload::rough())?;
    let groups = (args.envs as usize).div_ceil(isa.lanes());
    let mut subjects: Vec<Box<dyn Subject>> = vec![
        Box::new(engine::BuiltIn { isa, groups, scene: "plane", workload: &plane }),
        Box::new(engine::BuiltIn { isa, groups, scene: "rough ground", workload: &rough }),
    ];
    let missing = if args.no_mujoco {
        Some("left out by --no-mujoco".to_owned())
    } else {
        mujoco::subjects(&plane, &mut subjects).err()
    };
    let mut rows = Vec::new();
    for subject in &subjects {
        rows.push(subject.row()?);
    }
    let mut rates = vec![[Vec::new(), Vec::new()]; subjects.len()];
    for _ in 0..args.rounds {
        for (subject, rates) in subjects.iter().zip(&mut rates) {
            for (threads, rates) in [1, cores].into_iter().zip(rates) {
                rates.push(subject.speed(threads, args.seconds)?);
            }
        }
    }
    let substeps = plane.scene.substeps;
    for (row, [one, all]) in rows.iter_mut().zip(&rates) {
        (row.one_core, row.all_cores) = (speed(one, substeps), speed(all, substeps));
    }
    let best = [rows[0].one_core, rows[0].all_cores].map(|s| s.physics_steps_per_core_s);
    for row in rows.iter_mut().filter(|r| r.mean_contacts.is_some()) {
        let own = [row.one_core, row.all_cores].map(|s| s.physics_steps_per_core_s);
        row.engine_is_faster_by = Some([best[0] / own[0], best[1] / own[1]]);
    }
    let report = Report {
        isa: isa.to_string(),
        lanes: isa.lanes(),
        cores,
        envs_per_core: groups * isa.lanes(),
        physics_dt_s: plane.scene.physics_dt_s,
        substeps,
        rows,
        mujoco_missing: missing,
    };
    if args.json {
        let text = serde_json::to_string_pretty(&report).map_err(Failure::input)?;
        println!("{text}");
    } else {
        print(&report);
    }
    Ok(ExitCode::SUCCESS)
}

fn print(report: &Report) {
    println!(
        "{} ({} lanes), {} environments a core, {} cores; physics step {} s, {} a control step",
        report.isa, report.lanes, report.envs_per_core, report.cores, report.physics_dt_s, report.substeps
    );
    println!(
        "thousand steps/s; 'one core' by processor time, 'wall' and 'all cores' by the clock on the wall"
    );
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
