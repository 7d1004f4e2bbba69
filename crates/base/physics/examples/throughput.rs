//! Physics steps per second on one core, for the G1 in the situations of training.
//!
//! `cargo run --release -p paid-physics --example throughput [seconds] [isa]`

use std::time::Instant;

use paid_lanes::rng::Rng;
use paid_lanes::{Isa, IsaVisitor, Real};
use paid_physics::{Engine, EngineSpec, LaneState, SceneConfig, Simulator, Terrain};
use paid_robot::{RobotModel, RobotSpec};

/// Seconds that this thread has run: the scheduler's account where there is one, so that other load does not count.
fn busy_s(start: Instant) -> f64 {
    let account = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let ran = account.split_whitespace().next().and_then(|ns| ns.parse::<f64>().ok());
    ran.map_or_else(|| start.elapsed().as_secs_f64(), |ns| ns * 1e-9)
}

struct Bench {
    seconds: f64,
}

/// What the robots do while they are timed.
struct Situation {
    name: &'static str,
    scene: SceneConfig,
    /// Ball center ahead of the robot `[m]`; near enough to be kicked.
    ball_x: f64,
    /// Radians of random target around the default pose.
    noise: f64,
    /// Control steps between resets.
    episode: usize,
}

fn situations() -> Vec<Situation> {
    let scene = SceneConfig::default();
    let still = Situation { name: "standing, ball 3 m away", scene, ball_x: 3.0, noise: 0.05, episode: 30 };
    let with = |name, change: &dyn Fn(&mut Situation)| {
        let mut s = Situation { name, scene: still.scene.clone(), ..still };
        change(&mut s);
        s
    };
    vec![
        with("standing, neither ball nor self-collision", &|s| {
            s.scene.ball = false;
            s.scene.self_collision = false;
        }),
        with("standing, no ball", &|s| s.scene.ball = false),
        with("standing, rough ground", &|s| {
            s.scene.terrain =
                Terrain::Rough { amplitude_m: 0.02, step_m: 0.02, cell_m: 0.1, size: 64, seed: 1 };
        }),
        with("ball at the feet", &|s| s.ball_x = 0.25),
        with("random actions, falling and lying", &|s| {
            s.noise = 0.5;
            s.episode = 150;
            s.ball_x = 0.5;
        }),
        still,
    ]
}

impl IsaVisitor for Bench {
    type Output = Result<(), String>;

    fn visit<V: Real<Scalar = f32>>(self) -> Result<(), String> {
        let start_time = Instant::now();
        let model = RobotModel::g1();
        let spec = RobotSpec::g1();
        let control = spec.resolve(&model).map_err(|e| e.to_string())?;
        let engine_spec = EngineSpec::for_robot(&model, &spec).map_err(|e| e.to_string())?;
        println!("{}", V::NAME);
        for s in situations() {
            let groups = 512 / V::LANES;
            let mut engine =
                Engine::<V>::new(&model, engine_spec.clone(), &s.scene, groups).map_err(|e| e.to_string())?;
            let start = LaneState {
                base_pos: [0.0, 0.0, spec.nominal_height_m],
                base_quat: [1.0, 0.0, 0.0, 0.0],
                base_lin_vel: [0.0; 3],
                base_ang_vel: [0.0; 3],
                joint_pos: control.default_pos.clone(),
                joint_vel: vec![0.0; model.joints.len()],
                ball_pos: [s.ball_x, 0.1, 0.11],
                ball_vel: [0.0; 3],
                ball_ang_vel: [0.0; 3],
                warm_start: Vec::new(),
            };
            let mut rng = Rng::new(1, 0, 0);
            let mut targets = vec![V::zero(); model.joints.len()];
            let (mut steps, mut busy) = (0_u64, 0.0);
            while busy < self.seconds {
                for group in 0..groups {
                    for lane in 0..V::LANES {
                        engine.reset_lane(group, lane, &start);
                    }
                    engine.refresh(group);
                }
                for _ in 0..s.episode {
                    for (target, &default) in targets.iter_mut().zip(&control.default_pos) {
                        *target = V::c(default + rng.uniform(-s.noise, s.noise));
                    }
                    let before = busy_s(start_time);
                    for group in 0..groups {
                        engine.step(group, &targets);
                    }
                    busy += busy_s(start_time) - before;
                    steps += (groups * V::LANES * s.scene.substeps) as u64;
                }
            }
            println!("  {:44} {:6.3} M physics steps/s", s.name, steps as f64 / busy / 1e6);
        }
        Ok(())
    }
}

fn main() -> Result<(), String> {
    let mut args = std::env::args().skip(1);
    let seconds = match args.next() {
        Some(text) => text.parse().map_err(|_| format!("seconds: expected a number, found '{text}'"))?,
        None => 1.0,
    };
    let isa: Isa = args.next().as_deref().unwrap_or("auto").parse().map_err(|e| format!("{e}"))?;
    isa.dispatch(Bench { seconds })
}
