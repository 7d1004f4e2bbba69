//! The task on the built-in engine, with the paper's motions.

use std::sync::Arc;

use paid_lanes::Isa;
use paid_motion::MotionLibrary;
use paid_play::ReferenceLibrary;
use paid_policy::StepBuffers;
use paid_robot::{RobotModel, RobotSpec};
use paid_task::{
    Agent, Disturbances, EndCause, EpisodeRules, InitialState, ShardSetup, TaskMetrics, TaskPreset,
    TaskSetup, TaskShard, build_shard, observe_agent, run_agent,
};

/// The paper's motions, or `None` (the test is skipped).
fn library(test: &str) -> Option<(RobotModel, RobotSpec, Arc<ReferenceLibrary>)> {
    let dir = paid_testing::shared_data(test, "data/motions/paid")?;
    let (robot, spec) = (RobotModel::g1(), RobotSpec::g1());
    let motions = MotionLibrary::load(&dir, &robot, &spec, 50.0).expect("the motions are good");
    let library = ReferenceLibrary::from_motions(&motions, &robot, &spec).expect("they fit the robot");
    Some((robot, spec, Arc::new(library)))
}

fn shard(name: &str, overrides: &[&str], envs: usize, test: &str) -> Option<Box<dyn TaskShard>> {
    let (robot, spec, library) = library(test)?;
    let overrides: Vec<String> = overrides.iter().map(|s| (*s).to_owned()).collect();
    let preset = TaskPreset::builtin_with(&format!("paper_{name}"), &overrides).expect("valid");
    let task =
        TaskSetup { robot: &robot, spec: &spec, library: &library, preset: &preset, first_env: 0, seed: 7 };
    Some(build_shard(&ShardSetup { task, isa: Isa::detect(), num_envs: envs }).expect("builds"))
}

fn get(metrics: &TaskMetrics, name: &str) -> f64 {
    metrics.summary().iter().find(|(n, _)| n == name).unwrap_or_else(|| panic!("no figure {name}")).1
}

#[test]
fn facts_of_the_motions_are_the_releases() {
    let Some((_, _, library)) = library("facts_of_the_motions_are_the_releases") else { return };
    assert_eq!(library.len(), 13);
    // The release's displacements in the first frame's torso frame, standard 001 and 005.
    for (name, expected) in [("001", [0.82, 0.01]), ("005", [0.65, -0.57])] {
        let facts = library.facts().iter().find(|f| f.name.contains(name)).expect("present");
        let (s, c) = facts.heading.sin_cos();
        let [x, y] = facts.displacement;
        let local = [c * x + s * y, c * y - s * x];
        assert!(
            (local[0] - expected[0]).abs() < 0.006 && (local[1] - expected[1]).abs() < 0.006,
            "{} {local:?}",
            facts.name
        );
        assert!(facts.strike_speed > 4.5 && facts.strike_frame > facts.frames / 3, "{facts:?}");
    }
}

#[test]
fn episodes_are_drawn_from_the_robots_that_the_preset_names() {
    let run = |machines: &str| {
        let set = format!("randomization.mode_machines={machines}");
        let mut shard =
            shard("stage2", &[&set], 32, "episodes_are_drawn_from_the_robots_that_the_preset_names")?;
        Some(observe_agent(&mut *shard, Agent::Zero, 40, 1).expect("finite").policy)
    };
    let (Some(one), Some(other), Some(both)) = (run("[5]"), run("[11]"), run("[5, 11]")) else { return };
    assert!(one != other && both != one && both != other);
}

#[test]
fn zero_and_random_agents_run_every_preset() {
    for name in ["stage1", "stage2"] {
        let Some(mut shard) = shard(name, &[], 32, "zero_and_random_agents_run_every_preset") else { return };
        for agent in [Agent::Zero, Agent::Random] {
            let metrics = run_agent(shard.as_mut(), agent, 150, 1).expect("finite");
            assert_eq!(metrics.steps, 150 * 32);
            assert!(metrics.episodes > 10, "{name} {agent:?}: {}", metrics.episodes);
            assert_eq!(
                metrics.ends[EndCause::NotFinite.index()],
                0,
                "{name} {agent:?}: states that are not finite"
            );
            let body = get(&metrics, "reward/body_pos") / 0.02;
            assert!(body > 0.1 && body < 1.0, "{name} {agent:?}: {body}");
        }
    }
}

#[test]
fn an_undisturbed_start_matches_its_reference() {
    let Some(mut shard) = shard("stage1", &["scene.terrain={kind=\"plane\"}"], 16, "an_undisturbed_start")
    else {
        return;
    };
    let Some((_, spec, library)) = library("an_undisturbed_start") else { return };
    shard.eval().set_rules(EpisodeRules::evaluation());
    for env in 0..16 {
        let motion = env % 13;
        let frame = 10 * env;
        shard
            .eval()
            .force_start(env, &InitialState { frame, ..InitialState::nominal(motion) })
            .expect("exists");
        let sample = shard.eval().sample(env).expect("exists");
        let clip = &library.clips()[motion];
        let bodies = sample.bodies.len();
        assert_eq!((sample.frame, sample.motion), (frame, motion));
        for (b, body) in sample.bodies.iter().enumerate() {
            let row = frame * bodies + b;
            for k in 0..3 {
                let (p, v) = (clip.body_pos[row][k], clip.body_com_vel[row][k]);
                assert!((body.pos[k] - p).abs() < 1e-4, "{b} {k}: {} {p}", body.pos[k]);
                // The files' angular velocities are finite differences.
                assert!((body.com_vel[k] - v).abs() < 0.05, "{b} {k}: {} {v}", body.com_vel[k]);
            }
        }
    }
    // The critic sees zero anchor error but for the one frame that the reference is ahead.
    let envs = shard.num_envs();
    let mut policy = vec![0.0; shard.policy_obs_dim() * envs];
    let mut critic = vec![0.0; shard.critic_obs_dim() * envs];
    shard.observe(&mut [&mut policy, &mut critic]);
    assert_eq!((shard.policy_obs_dim(), shard.critic_obs_dim()), (160, 292));
    let row = shard.layout().critic.place("anchor_pos_error").expect("a term").start;
    for env in 0..envs {
        let error: f32 = (0..3).map(|k| critic[(row + k) * envs + env].powi(2)).sum::<f32>().sqrt();
        assert!(error < 0.05, "{env}: {error}");
    }
    assert_eq!(spec.policy_joint_order.len(), shard.action_dim());
}

#[test]
fn a_restored_shard_continues_bit_for_bit() {
    for name in ["stage1", "stage2"] {
        let Some(mut a) = shard(name, &[], 16, "a_restored_shard_continues_bit_for_bit") else { return };
        let Some(mut b) = shard(name, &[], 16, "a_restored_shard_continues_bit_for_bit") else { return };
        run_agent(a.as_mut(), Agent::Random, 40, 3).expect("finite");
        let bytes = a.save();
        run_agent(b.as_mut(), Agent::Random, 7, 4).expect("finite");
        b.restore(&bytes).expect("fits");
        assert!(b.save() == bytes, "{name}: a restored shard saves as it was");
        let one = run_agent(a.as_mut(), Agent::Random, 60, 5).expect("finite");
        let two = run_agent(b.as_mut(), Agent::Random, 60, 5).expect("finite");
        assert_eq!(one, two, "{name}");
        assert!(a.save() == b.save(), "{name}");
        let error = b.restore(&bytes[..bytes.len() - 8]).expect_err("cut off");
        assert!(error.contains("ends after"), "{error}");
    }
}

/// Every option of `[randomization]`, a late camera, every kind of start, and the ball shown where it lay.
const SIM_TO_REAL: [&str; 17] = [
    "randomization.robot=true",
    "randomization.surfaces=[{name=\"a\",static_friction=0.8,dynamic_friction=0.1,restitution=0.7,linear_damping=0.01,\
     angular_damping=4.0}]",
    "randomization.gain_scale=[0.9, 1.1]",
    "randomization.link_mass_scale=[0.9, 1.1]",
    "randomization.base_mass_scale=[0.8, 1.2]",
    "randomization.action_delay_s=[0, 0.02]",
    "randomization.observation_delay_s=[0, 0.02]",
    "knowledge=perceived",
    "eyes.latency_s=[0.02, 0.1]",
    "eyes.dropout=[0.2, 0.2]",
    "ball.after_strike.show=where_it_lay",
    "sampling.latest_start_before_strike_s=-1",
    "hold_s=[0.05, 0.2]",
    "sampling.first_frame_share=0.5",
    "sampling.after_strike_share=0.4",
    "sampling.from_last_pose_share=0.3",
    "sampling.from_end_state_share=0.5",
];

#[test]
fn a_restored_shard_continues_bit_for_bit_with_every_delay_and_camera() {
    let name = "a_restored_shard_continues_bit_for_bit_with_every_delay_and_camera";
    let Some(mut a) = shard("stage2", &SIM_TO_REAL, 16, name) else { return };
    let Some(mut b) = shard("stage2", &SIM_TO_REAL, 16, name) else { return };
    run_agent(a.as_mut(), Agent::Random, 40, 3).expect("finite");
    let bytes = a.save();
    run_agent(b.as_mut(), Agent::Random, 7, 4).expect("finite");
    b.restore(&bytes).expect("fits");
    for _ in 0..60 {
        let (x, y) = (observed(a.as_mut(), 0.1), observed(b.as_mut(), 0.1));
        assert_eq!(x, y);
    }
    assert!(a.save() == b.save());
}

/// The policy's observation, and then a step under equal actions.
fn observed(shard: &mut dyn TaskShard, action: f32) -> Vec<f32> {
    let envs = shard.num_envs();
    let mut policy = vec![0.0; shard.policy_obs_dim() * envs];
    let mut critic = vec![0.0; shard.critic_obs_dim() * envs];
    shard.observe(&mut [&mut policy, &mut critic]);
    let (mut reward, mut ends) = (vec![0.0; envs], [vec![0; envs], vec![0; envs]]);
    let [terminated, truncated] = &mut ends;
    let actions = vec![action; shard.action_dim() * envs];
    shard.step(&actions, StepBuffers::new(&mut reward, terminated, truncated));
    policy
}

#[test]
fn delays_are_up_to_one_control_step() {
    let test = "delays_are_up_to_one_control_step";
    let quiet = [
        "observations.noise={projected_gravity=0, reference_anchor_ang_vel=0, base_ang_vel=0, joint_pos_rel=0, joint_vel=0}",
        "pushes.enabled=false",
    ];
    let with = |more: &[&str]| shard("stage2", &[&quiet[..], more].concat(), 16, test);
    let Some(mut now) = with(&[]) else { return };
    let Some(mut late) = with(&["randomization.observation_delay_s=[0.02, 0.02]"]) else { return };
    let Some(mut slack) = with(&["randomization.action_delay_s=[0.02, 0.02]"]) else { return };
    // The task's own delay acts in evaluations too, where nothing is drawn.
    let Some(mut judged) = with(&["action_delay_s=0.02"]) else { return };
    let judging = EpisodeRules::evaluation();
    let training = EpisodeRules { disturbances: Disturbances::AsPreset, ..judging };
    for (shard, rules) in
        [(&mut now, training), (&mut late, training), (&mut slack, training), (&mut judged, judging)]
    {
        shard.eval().set_rules(rules);
        for env in 0..16 {
            shard.eval().force_start(env, &InitialState::nominal(0)).expect("exists");
        }
    }
    let row = now.layout().policy.place("joint_vel").expect("a term").start;
    let of = |x: &[f32]| x[row * 16..(row + 29) * 16].to_vec();
    let (mut before, mut moved) = (None, 0.0_f32);
    for step in 0..10 {
        // The action changes at every step, so that a late one differs.
        let action = 0.2 * step as f32;
        let (a, b, c) = (
            of(&observed(now.as_mut(), action)),
            of(&observed(late.as_mut(), action)),
            of(&observed(slack.as_mut(), action)),
        );
        if let Some(before) = &before {
            let error = b.iter().zip(before).map(|(x, y): (&f32, &f32)| (x - y).abs()).fold(0.0, f32::max);
            assert!(error < 1e-3, "{step}: {error}");
        }
        assert_eq!(c, of(&observed(judged.as_mut(), action)), "{step}");
        moved = moved.max(a.iter().zip(&c).map(|(x, y)| (x - y).abs()).fold(0.0, f32::max));
        before = Some(a);
    }
    assert!(moved > 0.05, "{moved}");
}

#[test]
fn environments_are_split_evenly_between_the_surfaces() {
    let test = "environments_are_split_evenly_between_the_surfaces";
    let surface = |name: &str, bounce: f64| {
        format!(
            "{{name=\"{name}\",static_friction=0.8,dynamic_friction=0.1,restitution={bounce},linear_damping=0.0,\
             angular_damping=0.0}}"
        )
    };
    let surfaces = format!("randomization.surfaces=[{}, {}]", surface("dead", 0.0), surface("lively", 1.0));
    let options = [&surfaces[..], "randomization.surface_deviation=0", "scene.ground.restitution=1.0"];
    let Some(shard) = shard("stage2", &options, 32, test) else { return };
    // Restitution 0 and 1 are in the snapshot's parameters of even and odd environments.
    let bytes = shard.save();
    let pattern = |bounce: f64| [0.8_f64, 0.1, bounce].map(f64::to_le_bytes).concat();
    let places = |bounce: f64| {
        let wanted = pattern(bounce);
        bytes.windows(wanted.len()).filter(|w| *w == wanted).count()
    };
    assert_eq!((places(0.0), places(1.0)), (16, 16));
}

#[test]
fn every_option_at_once_stays_finite() {
    let options = [
        "knowledge=perceived",
        "randomization.robot=true",
        "randomization.ball=true",
        "rewards.body_kernel=mean_of_exp",
        "rewards.kick_foot_vel.weight=1",
        "rewards.feet_vel.weight=1",
        "rewards.kick_foot_pos.weight=1",
        "rewards.hand_pos.weight=1",
        "rewards.ball_prox.from=base",
        "scene.terrain={kind=\"rough\", amplitude_m=0.02, step_m=0.02, cell_m=0.1, size=64, seed=3}",
    ];
    let Some(mut shard) = shard("stage2", &options, 32, "every_option_at_once_stays_finite") else { return };
    let Some(mut real) = self::shard("stage2", &SIM_TO_REAL, 32, "every_option_at_once_stays_finite") else {
        return;
    };
    let metrics = run_agent(real.as_mut(), Agent::Random, 200, 2).expect("finite");
    assert_eq!(metrics.ends[EndCause::NotFinite.index()], 0);
    let metrics = run_agent(shard.as_mut(), Agent::Random, 200, 2).expect("finite");
    assert_eq!(metrics.ends[EndCause::NotFinite.index()], 0);
    for name in ["kick_foot_vel", "feet_vel", "kick_foot_pos", "hand_pos"] {
        assert!(get(&metrics, &format!("reward/{name}")) > 0.0, "{name}");
    }
}

#[test]
fn lane_types_agree() {
    let Some((robot, spec, library)) = library("lane_types_agree") else { return };
    let preset = TaskPreset::builtin("paper_stage2").expect("valid");
    let mut results = Vec::new();
    for isa in [Isa::Portable, Isa::detect()] {
        let task = TaskSetup {
            robot: &robot,
            spec: &spec,
            library: &library,
            preset: &preset,
            first_env: 0,
            seed: 7,
        };
        let mut shard = build_shard(&ShardSetup { task, isa, num_envs: 16 }).expect("builds");
        let mut policy = vec![0.0; shard.policy_obs_dim() * 16];
        let mut critic = vec![0.0; shard.critic_obs_dim() * 16];
        let (mut reward, mut terminated, mut truncated) = (vec![0.0; 16], vec![0; 16], vec![0; 16]);
        shard.observe(&mut [&mut policy, &mut critic]);
        let actions = vec![0.1; shard.action_dim() * 16];
        shard.step(&actions, StepBuffers::new(&mut reward, &mut terminated, &mut truncated));
        results.push((policy, critic, reward, terminated));
    }
    let (a, b) = (&results[0], &results[1]);
    for (x, y) in a.0.iter().zip(&b.0).chain(a.1.iter().zip(&b.1)) {
        assert!((x - y).abs() < 1e-4, "{x} {y}");
    }
    for (x, y) in a.2.iter().zip(&b.2) {
        assert!((x - y).abs() < 1e-3, "{x} {y}");
    }
    assert_eq!(a.3, b.3);
}

/// By the workspace rule the ball belongs to the episode's motion, and a robot that begins late has gone its share of the way.
#[test]
fn workspace_balls_belong_to_their_motion_and_late_starts_are_on_the_way() {
    let name = "workspace_balls_belong_to_their_motion_and_late_starts_are_on_the_way";
    let options =
        ["ball.rule=workspace", "ball.rolling_share=0", "resets.xy_m=0", "sampling.first_frame_share=0.5"];
    let Some(mut shard) = shard("stage2", &options, 512, name) else { return };
    let Some((robot, spec, library)) = library(name) else { return };
    let facts = library.facts();
    let anchor = robot.body_index(&spec.anchor_body).expect("an anchor");
    let bodies = robot.bodies.len();
    let (mut first, mut late, mut motions) = (0, 0, std::collections::BTreeSet::new());
    for env in 0..512 {
        let sample = shard.eval().sample(env).expect("exists");
        let motion = &facts[sample.motion];
        let (s, c) = motion.heading.sin_cos();
        let from = [0, 1].map(|k| sample.ball_pos[k] - motion.start_xy[k]);
        let ball = [c * from[0] + s * from[1], c * from[1] - s * from[0]];
        assert!((0.249..2.251).contains(&ball[0]) && ball[1].abs() < 1.251, "{env}: {ball:?}");
        assert_eq!(paid_play::nearest_motion(facts, ball), sample.motion, "{env}: {ball:?}");
        let way = (sample.frame as f64 / motion.strike_frame as f64).min(1.0);
        let reference = library.clips()[sample.motion].body_pos[sample.frame * bodies + anchor];
        for k in 0..2 {
            let expected = way * (from[k] - motion.displacement[k]);
            let shift = sample.bodies[anchor].pos[k] - reference[k];
            // The pelvis is displaced; the torso sways a little around it by the noise on pose and joints.
            assert!((shift - expected).abs() < 0.1, "{env} frame {}: {shift} {expected}", sample.frame);
        }
        if sample.frame == 0 {
            first += 1;
        } else {
            late += 1;
        }
        motions.insert(sample.motion);
    }
    assert!(first > 150 && late > 150 && motions.len() > 9, "{first} {late} {motions:?}");
}
