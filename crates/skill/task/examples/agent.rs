//! Runs the zero and the random agent on a preset and prints every figure, then what the task costs beside the physics.
//!
//! `cargo run --release -p paid-task --example agent -- MOTION_DIR [paper_stage1|paper_stage2] [environments] [steps] [KEY=VALUE ...]`

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use paid_lanes::Isa;
use paid_motion::MotionLibrary;
use paid_play::ReferenceLibrary;
use paid_policy::StepBuffers;
use paid_robot::{RobotModel, RobotSpec};
use paid_task::{Agent, ShardSetup, TaskPreset, TaskSetup, build_shard, run_agent};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let dir = args.first().ok_or("expected a folder with motions")?;
    let name = args.get(1).map_or("paper_stage1", String::as_str);
    let envs: usize = args.get(2).map_or(Ok(512), |x| x.parse())?;
    let steps: usize = args.get(3).map_or(Ok(200), |x| x.parse())?;
    let overrides = args.get(4..).unwrap_or_default();
    let preset = TaskPreset::builtin_with(name, overrides)?;
    let (robot, spec) = (RobotModel::g1(), RobotSpec::g1());
    let motions = MotionLibrary::load(Path::new(dir), &robot, &spec, 1.0 / preset.control_dt_s())?;
    let library = Arc::new(ReferenceLibrary::from_motions(&motions, &robot, &spec)?);
    let isa = Isa::detect();
    let task =
        TaskSetup { robot: &robot, spec: &spec, library: &library, preset: &preset, first_env: 0, seed: 1 };
    let setup = ShardSetup { task, isa, num_envs: envs };
    for agent in [Agent::Zero, Agent::Random] {
        let mut shard = build_shard(&setup)?;
        println!("{name}, {agent:?} agent, {envs} environments, {steps} steps");
        for (figure, value) in run_agent(shard.as_mut(), agent, steps, 1)?.summary() {
            println!("  {figure:36} {value:12.6}");
        }
    }
    let mut shard = build_shard(&setup)?;
    let mut policy = vec![0.0; shard.policy_obs_dim() * envs];
    let mut critic = vec![0.0; shard.critic_obs_dim() * envs];
    let actions = vec![0.0; shard.action_dim() * envs];
    let (mut reward, mut terminated, mut truncated) = (vec![0.0; envs], vec![0; envs], vec![0; envs]);
    let (mut observing, mut stepping, mut resets) = (0.0, 0.0, 0);
    for _ in 0..steps {
        let start = Instant::now();
        shard.observe(&mut [&mut policy, &mut critic]);
        let middle = Instant::now();
        shard.step(&actions, StepBuffers::new(&mut reward, &mut terminated, &mut truncated));
        observing += (middle - start).as_secs_f64();
        stepping += middle.elapsed().as_secs_f64();
        resets += terminated.iter().chain(&truncated).filter(|x| **x == 1).count();
    }
    let each = 1e6 / (envs * steps) as f64;
    println!(
        "{isa}: observations {:.3} us, step with physics {:.3} us an environment and step; {resets} resets",
        observing * each,
        stepping * each
    );
    Ok(())
}
