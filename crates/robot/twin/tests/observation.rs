//! The runtime sees through sensor messages what the task shows from the simulator's state.

use std::sync::Arc;

use crate::common::player;
use paid_lanes::Vec3;
use paid_lanes::rng::Rng;
use paid_mujoco::{MujocoSim, SceneOptions};
use paid_physics::{GroupState, Simulator};
use paid_play::{RollingBall, motion_for};
use paid_policy::net::Network;
use paid_policy::{LstmConfig, NetworkConfig, NetworkKind, Pose, VecEnv};
use paid_runtime::wire::{Key, LowState, Remote};
use paid_runtime::{BallDetection, Limits, OdometryPose, Packet, Player, PolicyTrace, Runtime, State};
use paid_task::{EpisodeRules, EvalControl, InitialState, Task, TaskSetup};
use paid_twin::trained_task;

const BALL: [f64; 2] = [1.2, 0.1];
const GOAL: [f64; 2] = [5.0, 0.4];

/// The robot's messages in a state that does not change.
fn messages(
    player: &Player,
    state: &GroupState<f64>,
    quat: [f64; 4],
    goal: [f64; 2],
    now_us: u64,
    keys: &[Key],
) -> Vec<Packet> {
    let base = &state.bodies[0];
    let torso = &state.bodies[player.model.body_index("torso_link").expect("torso")];
    let mut low = LowState { mode_machine: 5, tick: (now_us / 1000) as u32, ..LowState::default() };
    low.wireless_remote = Remote::pressing(keys);
    low.imu.quaternion = quat.map(|x| x as f32);
    low.imu.gyroscope = base.rot.tr_mul_vec(base.ang_vel).0.map(|x| x as f32);
    for (j, &m) in player.motors.iter().enumerate() {
        low.motors[m].q = state.joint_pos[j] as f32;
        low.motors[m].dq = state.joint_vel[j] as f32;
    }
    let ball = Pose { pos: torso.pos, rot: torso.rot }.point_in_body(state.ball.pos);
    vec![
        Packet::LowState(low.sealed().to_cdr()),
        Packet::Odometry(OdometryPose { stamp_us: now_us, position: base.pos.0, quaternion: quat }),
        Packet::Detection(BallDetection { captured_us: now_us, ball: Some(ball.0), deviation_m: 0.01 }),
        Packet::Goal(goal),
    ]
}

#[test]
fn the_first_observation_of_a_kick_is_the_tasks() {
    if !crate::common::mujoco("the_first_observation_of_a_kick_is_the_tasks") {
        return;
    }
    let player = player();
    let task = trained_task(&player).expect("the demo's task");
    let preset = task.with_knowledge(paid_task::preset::KnowledgeMode::Truth);
    let library = Arc::clone(&player.library);
    let ball = RollingBall { place: BALL, velocity: [0.0; 2], decay: 1.0 };
    let motion = motion_for(library.facts(), &ball, 0.02);

    let scene = SceneOptions::default();
    let sim = MujocoSim::new(&player.model, &player.control, &scene, 1).expect("MuJoCo");
    let setup = TaskSetup {
        robot: &player.model,
        spec: &player.spec,
        library: &library,
        preset: &preset,
        first_env: 0,
        seed: 0,
    };
    let mut task = Task::new(sim, &setup).expect("task");
    task.set_rules(EpisodeRules::evaluation());
    let start = InitialState { ball_xy: Some(BALL), goal_xy: Some(GOAL), ..InitialState::nominal(motion) };
    task.force_start(0, &start).expect("start");
    let mut expected = vec![0.0_f32; player.policy.obs_dim()];
    task.observe(&mut [&mut expected]);

    let state = task.simulator().state(0).clone();
    let quat = task.simulator().save_lane(0, 0).base_quat;
    let goal = task.sample(0).expect("sample").goal_pos;
    // A statue: what moves in the first frame is allowed to.
    let mut limits = Limits { stand_up_s: 0.01, listen_s: 0.0, ..Limits::default() };
    limits.standing = limits.kicking;
    let mut runtime = Runtime::new(Arc::clone(&player), limits);
    let mut seen: Option<PolicyTrace> = None;
    for k in 1..1000_u64 {
        let now_us = 2000 * k;
        let keys: &[Key] = match k {
            3 => &[Key::L2, Key::Up],
            500 => &[Key::R1, Key::X],
            _ => &[],
        };
        let packets = messages(&player, &state, quat, [goal[0], goal[1]], now_us, keys);
        let output = runtime.step(now_us, &packets, false);
        if output.acted {
            seen = Some(runtime.trace().clone());
            break;
        }
    }
    assert_eq!(runtime.state(), State::Kick, "{} {:?}", runtime.waiting(), runtime.why());
    assert_eq!(runtime.motion(), Some(motion));
    assert_eq!(
        runtime.phase().looks_anew(),
        2,
        "ready, and when kicks were allowed: the floor may be another by then"
    );
    let seen = seen.expect("a policy step").observation;
    let layout = paid_policy::ObservationTerms::new(
        &preset.observations.policy,
        paid_policy::Dimensions::of(&player.spec),
    );
    for (place, term) in layout.places() {
        for (k, at) in place.enumerate() {
            let (found, expected) = (seen[at], expected[at]);
            assert!(
                (found - expected).abs() < 2e-3,
                "{}[{k}]: expected {expected}, found {found}",
                term.name
            );
        }
    }
    assert!(Vec3(state.bodies[0].pos.0).z() > 0.5);
}

/// A player with a policy that remembers, of random weights.
fn with_memory(player: &Player) -> Arc<Player> {
    let mut player = player.clone();
    let config = NetworkConfig {
        kind: NetworkKind::Lstm,
        hidden: vec![24],
        lstm: LstmConfig { layers: 2, size: 16, inputs: 0 },
        ..NetworkConfig::default()
    };
    let policy = Arc::make_mut(&mut player.policy);
    policy.net = Network::new(policy.net.input, policy.net.output, &config);
    policy.params = policy.net.initialize(&mut Rng::new(6, 0, 0));
    Arc::new(player)
}

#[test]
fn a_policy_that_remembers_begins_every_kick_with_an_empty_memory() {
    if !crate::common::mujoco("a_policy_that_remembers_begins_every_kick_with_an_empty_memory") {
        return;
    }
    let player = with_memory(&player());
    let scene = SceneOptions::default();
    let sim = MujocoSim::new(&player.model, &player.control, &scene, 1).expect("MuJoCo");
    let mut state = sim.state(0).clone();
    state.joint_pos.copy_from_slice(&player.control.default_pos);
    state.ball.pos = state.bodies[0].pos + Vec3([1.2, 0.1, -0.65]);
    let mut limits = Limits { stand_up_s: 0.01, listen_s: 0.0, ..Limits::default() };
    limits.standing = limits.kicking;
    let mut runtime = Runtime::new(Arc::clone(&player), limits);
    let (mut memory, mut kicks, mut steps) = (player.policy.start(1), 0, 0);
    let (mut carried, mut expected) = (vec![0.0; player.joints()], vec![0.0; player.joints()]);
    for k in 1..10_000_u64 {
        let keys: &[Key] = match k {
            3 => &[Key::L2, Key::Up],
            500 => &[Key::R1, Key::X],
            _ => &[],
        };
        let packets = messages(&player, &state, [1.0, 0.0, 0.0, 0.0], GOAL, 2000 * k, keys);
        if !runtime.step(2000 * k, &packets, false).acted {
            continue;
        }
        let PolicyTrace { observation, action } = runtime.trace();
        if runtime.kicks() > kicks {
            // What the last kick would have left behind.
            let mut old = memory.clone();
            player.policy.act(observation, &mut old, &mut carried);
            memory = player.policy.start(1);
            kicks = runtime.kicks();
        }
        player.policy.act(observation, &mut memory, &mut expected);
        assert_eq!(action, &expected, "kick {kicks}, step {steps}");
        steps += 1;
        if kicks == 2 {
            assert_ne!(carried, expected, "a memory that changes nothing");
            assert!(steps > 100, "{steps}");
            return;
        }
    }
    panic!("{kicks} kicks in 20 s, {}: {} {:?}", runtime.state(), runtime.waiting(), runtime.why());
}

#[test]
fn the_torso_follows_from_pelvis_and_waist() {
    let player = player();
    let mut joints = player.control.default_pos.clone();
    for (name, angle) in [("waist_yaw_joint", 0.5), ("waist_roll_joint", -0.2), ("waist_pitch_joint", 0.3)] {
        joints[player.model.joint_index(name).expect("joint")] = angle;
    }
    let poses = paid_robot::kinematics::forward(
        &player.model,
        Vec3([0.0; 3]),
        paid_lanes::Quat([1.0, 0.0, 0.0, 0.0]),
        &joints,
    );
    let expected = &poses[player.model.body_index("torso_link").expect("torso")];
    let found = player.anchor_in_base(&joints);
    for k in 0..3 {
        assert!((found.pos.0[k] - expected.pos.0[k]).abs() < 1e-12);
        for l in 0..3 {
            assert!((found.rot.0[k][l] - expected.rot().0[k][l]).abs() < 1e-12);
        }
    }
}

#[test]
fn virtual_senses_have_a_clock_of_their_own() {
    let player = player();
    // Whose clock is three seconds ahead, and who begins before.
    for ahead_us in [0, 3_000_000] {
        let mut runtime = Runtime::new(Arc::clone(&player), Limits::default());
        let mut now_us = 0;
        while now_us < 400_000 {
            let mut low = LowState { mode_machine: 5, tick: (now_us / 1000) as u32, ..LowState::default() };
            low.imu.quaternion = [1.0, 0.0, 0.0, 0.0];
            for (j, &m) in player.motors.iter().enumerate() {
                low.motors[m].q = player.control.default_pos[j] as f32;
            }
            let mut packets = vec![Packet::LowState(low.sealed().to_cdr())];
            let clock_us = now_us + ahead_us;
            if now_us % 10_000 == 0 {
                let (position, quaternion) = ([0.0, 0.0, 0.75], [1.0, 0.0, 0.0, 0.0]);
                packets.push(Packet::Odometry(OdometryPose { stamp_us: clock_us, position, quaternion }));
            }
            // Images come 60 ms after their capture.
            if now_us % 40_000 == 0 && now_us >= 100_000 {
                let (captured_us, ball) = (clock_us - 60_000, Some([1.2, 0.1, -0.7]));
                packets.push(Packet::Detection(BallDetection { captured_us, ball, deviation_m: 0.01 }));
            }
            runtime.step(now_us, &packets, false);
            now_us += 2_000;
        }
        let [_, odometry_s, ball_s] = runtime.status(now_us).ages_s;
        assert!((0.0..=0.0101).contains(&odometry_s), "{ahead_us}: odometry {odometry_s} s");
        // The last image came at 360 ms.
        assert!((0.08..=0.105).contains(&ball_s), "{ahead_us}: ball {ball_s} s");
    }
}
