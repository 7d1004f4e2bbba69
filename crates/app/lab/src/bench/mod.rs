//! Physics steps per second of the built-in engine and of MuJoCo in the same scene.

mod builtin;
mod clock;
mod mujoco;
mod workload;

use paid_lanes::Isa;
use paid_lanes::stats::quantile;
use paid_physics::Terrain;
use serde::Serialize;

use clock::Rate;
use paid_eval::{EvalError, Setting};
use workload::Workload;

/// What is measured, and for how long.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BenchOptions {
    /// Instruction set of the built-in engine.
    pub isa: Isa,
    /// Environments per core in the built-in engine; rounded up to whole lane groups.
    pub envs: usize,
    /// Duration of each measurement `[s]`.
    pub seconds: f64,
    /// Rounds; engines take turns, and the median round counts. At least 1.
    pub rounds: u32,
    /// Threads of the measurement on all cores. At least 1.
    pub threads: usize,
    /// The built-in engine is measured too with contacts and controllers of all kinds.
    pub kinds: bool,
    /// MuJoCo is measured too.
    pub mujoco: bool,
}

/// Steps per second.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Speed {
    /// By the clock on the wall, all threads together.
    pub physics_steps_per_s: f64,
    /// The same for control steps.
    pub control_steps_per_s: f64,
    /// By processor time, per core: holds on a busy machine too.
    pub physics_steps_per_core_s: f64,
    /// The same for control steps.
    pub control_steps_per_core_s: f64,
}

/// One simulator in one scene.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// `built-in` or `MuJoCo`.
    pub simulator: String,
    /// Ground and feet in words.
    pub scene: String,
    /// On one core.
    pub one_core: Speed,
    /// On all cores.
    pub all_cores: Speed,
    /// Share of control steps at whose end a foot presses on something, over feet and environments.
    pub foot_contact_share: f64,
    /// Mean height of the base over the episodes `[m]`.
    pub mean_base_height_m: f64,
    /// Mean number of contacts per physics step, where the simulator counts them.
    pub mean_contacts: Option<f64>,
    /// How many times the built-in engine on the plane is faster on one core and on all, by processor time.
    pub engine_is_faster_by: Option<[f64; 2]>,
}

/// All of it.
#[derive(Clone, Debug, Serialize)]
pub struct PhysicsBench {
    /// Instruction set of the built-in engine.
    pub isa: String,
    /// Environments that it steps in one instruction.
    pub lanes: usize,
    /// Threads of the measurement on all cores.
    pub cores: usize,
    /// Environments per core in the built-in engine.
    pub envs_per_core: usize,
    /// Physics step `[s]`.
    pub physics_dt_s: f64,
    /// Physics steps per control step.
    pub substeps: usize,
    /// One row per simulator and scene.
    pub rows: Vec<Row>,
    /// Why MuJoCo is not in the rows.
    pub mujoco_missing: Option<String>,
}

/// A simulator that can be timed.
trait Contender: Sync {
    /// Steps for about `seconds` on `threads` threads; physics steps per second.
    fn speed(&self, threads: usize, seconds: f64) -> Result<Rate, EvalError>;
    /// What the robots do in the untimed first episode.
    fn row(&self) -> Result<Row, EvalError>;
}

/// The median rate of the rounds as speed.
fn speed(rates: &[Rate], substeps: usize) -> Speed {
    let median = |value: fn(&Rate) -> f64| {
        let mut values: Vec<f64> = rates.iter().map(value).collect();
        quantile(&mut values, 0.5).unwrap_or(0.0)
    };
    let (wall, per_core) = (median(|r| r.wall), median(|r| r.per_core));
    Speed {
        physics_steps_per_s: wall,
        control_steps_per_s: wall / substeps as f64,
        physics_steps_per_core_s: per_core,
        control_steps_per_core_s: per_core / substeps as f64,
    }
}

/// Measures both engines.
///
/// # Errors
/// If the duration is out of range, or a simulator cannot be built.
pub fn bench_physics(options: &BenchOptions) -> Result<PhysicsBench, EvalError> {
    let BenchOptions { isa, seconds, threads: cores, .. } = *options;
    if !(seconds > 0.0 && seconds <= 3600.0) {
        return Err(EvalError::Option {
            option: Setting::Seconds,
            expected: "above 0, at most 3600".to_owned(),
            found: seconds.to_string(),
        });
    }
    let plane = Workload::new(Terrain::Plane)?;
    let rough = Workload::new(workload::rough())?;
    let groups = options.envs.div_ceil(isa.lanes());
    let mut contenders: Vec<Box<dyn Contender>> = vec![
        Box::new(builtin::BuiltIn { isa, groups, scene: "plane", workload: &plane, kinds: false }),
        Box::new(builtin::BuiltIn { isa, groups, scene: "rough ground", workload: &rough, kinds: false }),
    ];
    if options.kinds {
        let scene = "plane, all kinds of contacts";
        contenders.push(Box::new(builtin::BuiltIn { isa, groups, scene, workload: &plane, kinds: true }));
    }
    let mujoco_missing = if options.mujoco {
        mujoco::contenders(&plane, &mut contenders).err()
    } else {
        Some("left out".to_owned())
    };
    let mut rows = Vec::new();
    for contender in &contenders {
        rows.push(contender.row()?);
    }
    let mut rates = vec![[Vec::new(), Vec::new()]; contenders.len()];
    for _ in 0..options.rounds {
        for (contender, rates) in contenders.iter().zip(&mut rates) {
            for (threads, rates) in [1, cores].into_iter().zip(rates) {
                rates.push(contender.speed(threads, seconds)?);
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
    Ok(PhysicsBench {
        isa: isa.to_string(),
        lanes: isa.lanes(),
        cores,
        envs_per_core: groups * isa.lanes(),
        physics_dt_s: plane.scene.physics_dt_s,
        substeps,
        rows,
        mujoco_missing,
    })
}
