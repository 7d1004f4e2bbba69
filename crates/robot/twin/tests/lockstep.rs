//! Runtime and virtual robot in step, with a policy and motions that are part of the repository.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use crate::common::player;
use paid_runtime::log::{LogHeader, LogReader, LogWriter, replay};
use paid_runtime::wire::{DAMPING_KEYS, Key, LowCmd, LowState, Remote};
use paid_runtime::{Limits, Packet, Player, PlayerSpec, Runtime, State, Writer};
use paid_twin::{Fault, Lockstep, LockstepOptions, MatchOptions, VirtualG1, draw_course, drill, play_match};

fn spec() -> PlayerSpec {
    let policy = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../policies/demo/policy.onnx");
    PlayerSpec { policy, motions: None, sets: Vec::new() }
}

fn ready(player: &Arc<Player>) -> Lockstep {
    let limits = Limits { stand_up_s: 0.3, listen_s: 0.0, ..Limits::default() };
    let mut step = Lockstep::new(player, &LockstepOptions { limits, seed: 1, ..LockstepOptions::default() })
        .expect("MuJoCo");
    step.make_ready(false).expect("ready");
    step
}

#[test]
fn a_robot_that_is_let_go_stands_for_ten_seconds() {
    if !crate::common::mujoco("a_robot_that_is_let_go_stands_for_ten_seconds") {
        return;
    }
    let player = player();
    let mut step = Lockstep::new(&player, &LockstepOptions::default()).expect("MuJoCo");
    step.make_ready(true).expect("ready");
    step.run_until(10.0, |_| false).expect("run");
    assert_eq!(step.runtime().state(), State::Ready, "{:?}", step.runtime().why());
    assert!(step.truth().base.pos.z() > 0.7);
}

#[test]
fn commands_reach_the_robot_as_late_as_was_asked() {
    if !crate::common::mujoco("commands_reach_the_robot_as_late_as_was_asked") {
        return;
    }
    let player = player();
    // Ticks of 2 ms from the stop keys to a command without stiffness.
    let ticks = |command_delay_us: u64| {
        let limits = Limits { stand_up_s: 0.3, listen_s: 0.0, ..Limits::default() };
        let options = LockstepOptions { limits, command_delay_us, ..LockstepOptions::default() };
        let mut step = Lockstep::new(&player, &options).expect("MuJoCo");
        step.make_ready(false).expect("ready");
        step.robot.set_remote(Remote::pressing(&DAMPING_KEYS));
        (1..50)
            .find(|_| {
                step.tick().expect("tick");
                step.robot.command().motors.iter().all(|motor| motor.kp == 0.0)
            })
            .expect("damped")
    };
    let at_once = ticks(0);
    assert_eq!(ticks(4_000), at_once + 2);
    assert_eq!(ticks(10_000), at_once + 5);
}

#[test]
fn a_rolling_ball_slows_as_the_runtime_predicts() {
    if !crate::common::mujoco("a_rolling_ball_slows_as_the_runtime_predicts") {
        return;
    }
    let player = player();
    let mut robot = VirtualG1::new(Arc::clone(&player)).expect("MuJoCo");
    robot.place_ball([-2.0, 0.0], [-0.3, 0.0]);
    (0..500).for_each(|_| robot.step());
    let ball = robot.truth().ball;
    let (speed, way) = (-ball.vel.x(), -2.0 - ball.pos.x());
    // 1 s of v' = -c v: what is left is exp(-c), and the way is (1 - exp(-c)) / c.
    let decay = player.play.ball_decay();
    assert!(decay > 0.1, "{decay}");
    let left = (-decay).exp();
    assert!((speed - 0.3 * left).abs() < 0.01, "{speed} m/s, expected {}", 0.3 * left);
    assert!((way - 0.3 * (1.0 - left) / decay).abs() < 0.01, "{way} m");
}

#[test]
fn a_kicked_ball_slides_to_the_goal() {
    if !crate::common::mujoco("a_kicked_ball_slides_to_the_goal") {
        return;
    }
    let player = player();
    let mut robot = VirtualG1::new(Arc::clone(&player)).expect("MuJoCo");
    robot.place_ball([-2.0, 0.0], [-6.0, 0.0]);
    (0..500).for_each(|_| robot.step());
    let way = -2.0 - robot.truth().ball.pos.x();
    // A coefficient of 0.07 takes 0.34 m of 6 m in a second; a ball that rolled from the start would come 2.9 m far.
    assert!((way - (6.0 - 0.5 * 0.07 * 9.81)).abs() < 0.1, "{way} m");
}

#[test]
fn a_ball_within_reach_is_kicked_and_the_log_replays_bit_for_bit() {
    if !crate::common::mujoco("a_ball_within_reach_is_kicked_and_the_log_replays_bit_for_bit") {
        return;
    }
    let player = player();
    let dir = tempfile::tempdir().expect("dir");
    let file = dir.path().join("match.mcap");
    let mut options = MatchOptions::default();
    options.field.kicks = 1;
    let limits = options.lockstep.limits.clone();
    let log = LogWriter::create(&file, &LogHeader { player: spec(), limits }).expect("log");
    let result = play_match(&player, &options, Some(log), None, |_| {}).expect("match");
    let [kick] = &result.kicks[..] else { panic!("one kick: {result:?}") };
    assert!(!kick.motion.is_empty() && kick.ball_error_m < 0.1, "{kick:?}");

    let mut reader = LogReader::open(&file).expect("log");
    let again = replay(&mut reader, &player).expect("replay");
    assert_eq!(again.difference, None);
    assert!(again.policy_steps > 50 && again.frames > 2000, "{again:?}");
    let picture = draw_course(&again.course).svg();
    assert!(picture.contains("kicks: 1") && picture.contains("a kick begins"), "the course as a plot");
    assert!(!picture.contains("no odometry"));

    // A changed limit is another runtime: the replay finds the first command that differs.
    let mut reader = LogReader::open(&file).expect("log");
    reader.header.limits.passive_kd = 4.0;
    let other = replay(&mut reader, &player).expect("replay");
    // It listens for a second first.
    assert_eq!(other.difference, Some((500, "the command")));

    // A log that was cut off is read up to there.
    let bytes = std::fs::read(&file).expect("read");
    std::fs::write(&file, &bytes[..bytes.len() / 2]).expect("write");
    let cut = replay(&mut LogReader::open(&file).expect("log"), &player).expect("replay");
    assert_eq!(cut.difference, None);
    assert!((1000..again.frames - 1000).contains(&cut.frames), "{} of {} frames", cut.frames, again.frames);
}

#[test]
fn a_match_that_is_stopped_damps_the_robot_and_keeps_its_kicks_and_its_log() {
    if !crate::common::mujoco("a_match_that_is_stopped_damps_the_robot_and_keeps_its_kicks_and_its_log") {
        return;
    }
    let player = player();
    let dir = tempfile::tempdir().expect("dir");
    let file = dir.path().join("match.mcap");
    let options = MatchOptions::default();
    let limits = options.lockstep.limits.clone();
    let log = LogWriter::create(&file, &LogHeader { player: spec(), limits }).expect("log");
    let stop = Arc::clone(&options.lockstep.stop);
    let result = play_match(&player, &options, Some(log), None, |_| stop.store(true, Ordering::Relaxed));
    let result = result.expect("match");
    assert_eq!(result.kicks.len(), 1, "the second kick was not played: {:?}", result.kicks);
    assert_eq!(result.stopped.as_deref(), Some("stop signal"));
    let again = replay(&mut LogReader::open(&file).expect("log"), &player).expect("replay");
    assert_eq!(again.difference, None);
    let end = again.frames as f64 * 0.002;
    assert!((end - result.seconds).abs() < 0.01, "the log has {end} s of {} s", result.seconds);
}

#[test]
fn every_fault_of_a_standing_robot_is_damped_in_time() {
    if !crate::common::mujoco("every_fault_of_a_standing_robot_is_damped_in_time") {
        return;
    }
    let faults = [
        Fault::Tilt,
        Fault::Spin,
        Fault::JointSpeed,
        Fault::Torque,
        Fault::Range,
        Fault::Winding,
        Fault::NotFinite,
        Fault::Silence,
        Fault::Frozen,
        Fault::Checksum,
        Fault::ModeMachine,
        Fault::StopKey,
        Fault::StopSignal,
        Fault::Late,
        Fault::Hang,
        Fault::Kill,
        Fault::OthersCommand,
    ];
    let report = drill(&player(), &Limits::default(), &faults, 1, |_| {}).expect("drill");
    assert!(report.passed(), "{}", report.table());
}

#[test]
fn a_spoiled_policy_and_lost_senses_are_noticed_in_the_kick() {
    if !crate::common::mujoco("a_spoiled_policy_and_lost_senses_are_noticed_in_the_kick") {
        return;
    }
    let faults = [
        Fault::ActionNotFinite,
        Fault::ActionHuge,
        Fault::NoOdometry,
        Fault::SpinInKick,
        Fault::JointSpeedInKick,
    ];
    let report = drill(&player(), &Limits::default(), &faults, 1, |_| {}).expect("drill");
    assert!(report.passed(), "{}", report.table());
}

/// A healthy state of a robot that stands upright.
fn healthy(tick: u32) -> LowState {
    let mut state = LowState { mode_machine: 5, tick, ..LowState::default() };
    state.imu.quaternion = [1.0, 0.0, 0.0, 0.0];
    state.wireless_remote = Remote::pressing(&[]);
    state
}

/// A passive runtime's answer to L2 and up after this state.
fn asked_to_stand(player: &Arc<Player>, change: impl Fn(&mut LowState), more: &[Packet]) -> (State, String) {
    let limits = Limits { listen_s: 0.0, ..Limits::default() };
    let mut runtime = Runtime::new(Arc::clone(player), limits);
    let mut told = String::new();
    for k in 1..4_u32 {
        let mut state = healthy(2 * k);
        if k == 3 {
            state.wireless_remote = Remote::pressing(&[Key::L2, Key::Up]);
        }
        change(&mut state);
        let mut packets = more.to_vec();
        packets.push(Packet::LowState(state.sealed().to_cdr()));
        let output = runtime.step(2000 * u64::from(k), &packets, false);
        told += &output.events.iter().map(|e| e.reason.clone()).collect::<String>();
    }
    (runtime.state(), told)
}

/// A change of the state, what else comes, and the answer.
type Case<'a> = (&'a dyn Fn(&mut LowState), &'a [Packet], &'a str);

#[test]
fn the_runtime_refuses_a_robot_that_is_not_fit() {
    let player = player();
    assert_eq!(asked_to_stand(&player, |_| {}, &[]).0, State::StandUp);
    let tilted = |state: &mut LowState| state.imu.quaternion = [0.9, 0.44, 0.0, 0.0];
    let locked = |state: &mut LowState| state.mode_machine = 6;
    let vendor = [Packet::Master("ai".to_owned())];
    let cases: [Case<'_>; 5] = [
        (&tilted, &[], "tilted by 0.91 rad"),
        (
            &locked,
            &[],
            "mode_machine: expected 5, 11, 13, 15 or 18 (a G1 with 29 joints and a free waist), found 6: a G1 whose waist is locked",
        ),
        (&|_| {}, &[Packet::OthersCommand], "another program commands the robot"),
        (&|_| {}, &[Packet::Battery(12.0)], "battery at 12%"),
        (&|_| {}, &vendor, "the vendor's controller 'ai' is in command"),
    ];
    for (change, more, expected) in cases {
        let (state, told) = asked_to_stand(&player, change, more);
        assert_eq!(state, State::Passive, "{expected}");
        assert!(told.contains(expected), "{told}");
    }
}

#[test]
fn the_runtime_takes_limits_and_gains_of_the_robot_that_reports_itself() {
    let player = player();
    let hip = player.model.joint_index("left_hip_pitch_joint").expect("joint");
    let limits = Limits { listen_s: 0.0, ..Limits::default() };
    let mut runtime = Runtime::new(Arc::clone(&player), limits);
    let state = |tick: u32, mode_machine: u8, keys: &[Key]| {
        let remote = Remote::pressing(keys);
        let state = LowState { mode_machine, wireless_remote: remote, ..healthy(tick) };
        [Packet::LowState(state.sealed().to_cdr())]
    };
    runtime.step(2_000, &state(2, 15, &[]), false);
    let found = runtime.player();
    assert_eq!(found.mode_machine, 15);
    assert_eq!((found.model.joints[hip].effort_limit, found.control.velocity_limit[hip]), (139.0, 20.0));
    // (2 pi 10 Hz)^2 times 0.025101925 kg m^2; an action means what it meant in training.
    assert!((found.control.stiffness[hip] - 99.098_428).abs() < 1e-5);
    assert_eq!(found.control.action_scale, player.control.action_scale);
    runtime.step(4_000, &state(4, 15, &[Key::L2, Key::Up]), false);
    assert_eq!(runtime.state(), State::StandUp);
    runtime.step(6_000, &state(6, 5, &[]), false);
    assert_eq!(runtime.state(), State::Damping);
    let why = runtime.why().expect("damped").to_string();
    assert_eq!(why, "mode_machine: it was 15 and is 5 now (a G1 with 29 joints)");
}

#[test]
fn each_g1_kicks_and_faults_are_damped_on_two_of_them() {
    if !crate::common::mujoco("each_g1_kicks_and_faults_are_damped_on_two_of_them") {
        return;
    }
    for mode_machine in [11, 13, 15, 18] {
        let player = Arc::new(player().as_variant(mode_machine).expect("known"));
        let mut options = MatchOptions::default();
        options.field.kicks = 1;
        let result = play_match(&player, &options, None, None, |_| {}).expect("match");
        assert!(result.kicks.len() == 1 && result.stopped.is_none(), "{mode_machine}: {:?}", result.stopped);
        if [11, 15].contains(&mode_machine) {
            let faults = [Fault::JointSpeed, Fault::Torque, Fault::ModeMachine, Fault::Silence];
            let report = drill(&player, &Limits::default(), &faults, 1, |_| {}).expect("drill");
            assert!(report.passed(), "{mode_machine}: {}", report.table());
        }
    }
    let error = player().as_variant(6).expect_err("a locked waist").to_string();
    assert!(error.contains("expected a robot of mode_machine 5, 11, 13, 15, 18, found 6"), "{error}");
}

/// States and reasons of a runtime that gets healthy states 2 ms apart, and in step `k` the packets of `more`.
fn run_with(player: &Arc<Player>, steps: u32, more: impl Fn(u32) -> Vec<Packet>) -> (State, String) {
    let limits = Limits { stand_up_s: 0.01, listen_s: 0.0, ..Limits::default() };
    let mut runtime = Runtime::new(Arc::clone(player), limits);
    let mut told = String::new();
    for k in 1..=steps {
        let mut packets = more(k);
        packets.push(Packet::LowState(healthy(2 * k).sealed().to_cdr()));
        let output = runtime.step(2000 * u64::from(k), &packets, false);
        told += &output.events.iter().map(|e| format!("{}; ", e.reason)).collect::<String>();
    }
    (runtime.state(), told)
}

#[test]
fn keys_of_the_keyboard_are_keys_of_the_remote_for_one_step() {
    let player = player();
    let bits = |keys: &[Key]| Packet::Keys(keys.iter().fold(0, |bits, key| bits | (1 << *key as u16)));
    let typed = |k| match k {
        3 => vec![bits(&[Key::L2, Key::Up])],
        20 => vec![bits(&[Key::R1]), bits(&[Key::X])],
        _ => Vec::new(),
    };
    let (state, told) = run_with(&player, 30, typed);
    assert_eq!(state, State::Ready);
    assert_eq!(told.matches("refused to kick").count(), 1, "{told}");
    // Stop keys in two steps are no stop keys.
    let apart = |k| match k {
        20 => vec![bits(&[Key::L2])],
        21 => vec![bits(&[Key::B])],
        _ => typed(k),
    };
    assert_eq!(run_with(&player, 30, apart).0, State::Ready);
    let stopped = |k| if k == 25 { vec![bits(&[Key::L2, Key::B])] } else { typed(k) };
    assert_eq!(run_with(&player, 30, stopped).0, State::Damping);
}

#[test]
fn a_vendors_controller_that_comes_back_is_answered_by_damping() {
    let player = player();
    let keys = (1 << Key::L2 as u16) | (1 << Key::Up as u16);
    let master = |name: &str| vec![Packet::Master(name.to_owned())];
    let released = |k| match k {
        1 | 20 => master(""),
        3 => vec![Packet::Keys(keys)],
        _ => Vec::new(),
    };
    assert_eq!(run_with(&player, 30, released).0, State::Ready);
    let (state, told) = run_with(&player, 30, |k| if k == 20 { master("normal") } else { released(k) });
    assert_eq!(state, State::Damping);
    assert!(told.contains("the vendor's controller 'normal' is in command"), "{told}");
}

#[test]
fn no_kick_is_allowed_without_odometry_detector_and_goal() {
    let player = player();
    let limits = Limits { stand_up_s: 0.01, listen_s: 0.0, ..Limits::default() };
    let mut runtime = Runtime::new(Arc::clone(&player), limits);
    let mut told = String::new();
    for k in 1..40_u32 {
        let mut state = healthy(2 * k);
        match k {
            3 => state.wireless_remote = Remote::pressing(&[Key::L2, Key::Up]),
            30 => state.wireless_remote = Remote::pressing(&[Key::R1, Key::X]),
            _ => {}
        }
        let packets = [Packet::LowState(state.sealed().to_cdr())];
        let output = runtime.step(2000 * u64::from(k), &packets, false);
        told += &output.events.iter().map(|e| e.reason.clone()).collect::<String>();
    }
    assert_eq!(runtime.state(), State::Ready);
    assert!(told.contains("refused to kick: no odometry; no ball detector; no goal"), "{told}");
}

#[test]
fn targets_never_jump_when_the_controller_changes() {
    if !crate::common::mujoco("targets_never_jump_when_the_controller_changes") {
        return;
    }
    let player = player();
    let mut step = ready(&player);
    step.robot.place_ball([1.2, 0.0], [0.0; 2]);
    let mut before: Option<(State, LowCmd)> = None;
    let mut worst = 0.0_f64;
    step.run_until(4.0, |s| {
        let (state, command) = (s.runtime().state(), s.robot.command().clone());
        if let Some((State::Ready, _)) = &before
            && state == State::Kick
        {
            // The first command of the kick has not arrived yet: measured pose and old command are here.
            before = Some((state, command));
            return false;
        }
        if let Some((State::Kick, _)) = &before {
            for (j, q) in s.robot.truth().joint_pos.iter().enumerate() {
                let motor = &command.motors[j];
                worst = worst.max((f64::from(motor.q) - q).abs());
            }
            return true;
        }
        before = Some((state, command));
        false
    })
    .expect("run");
    assert!(matches!(before, Some((State::Kick, _))), "no kick: {}", step.runtime().waiting());
    // Two periods at 12 rad/s, and the joints' own motion.
    assert!(worst < 0.06, "a target {worst} rad from the measured pose");
}

#[test]
fn nothing_is_sent_while_it_listens_and_nothing_at_all_next_to_another_commander() {
    let player = player();
    let commands = |others_at: u64| {
        let mut runtime = Runtime::new(Arc::clone(&player), Limits::default());
        let mut first = None;
        for k in 1..1000_u64 {
            let mut packets = vec![Packet::LowState(healthy(2 * k as u32).sealed().to_cdr())];
            if k == others_at {
                packets.push(Packet::OthersCommand);
            }
            if runtime.step(2000 * k, &packets, false).command.is_some() {
                first.get_or_insert(2 * k);
            }
        }
        first
    };
    assert_eq!(commands(0), Some(1002), "milliseconds");
    assert_eq!(commands(100), None);
}

#[test]
fn a_robot_that_it_has_not_moved_is_left_to_another_program_that_begins_to_command_it() {
    let mut runtime = Runtime::new(player(), Limits::default());
    let mut writer = Writer::new(&Limits::default(), 29);
    // Period of 2 ms; another program commands from the 700th on, the operator stops this program at the 800th.
    let mut sent = |k: u64| {
        let mut packets = vec![Packet::LowState(healthy(2 * k as u32).sealed().to_cdr())];
        packets.extend((k >= 700).then_some(Packet::OthersCommand));
        writer.give(runtime.step(2000 * k, &packets, k >= 800).command, 2000 * k);
        (writer.write(2000 * k).is_some(), runtime.state())
    };
    assert!((1..=500).all(|k| sent(k) == (false, State::Passive)), "it listens");
    assert!((501..700).all(|k| sent(k) == (true, State::Passive)), "its own damping");
    assert!((700..800).all(|k| sent(k) == (false, State::Passive)), "another program");
    assert!((800..1000).all(|k| sent(k) == (false, State::Damping)), "asked to stop");
}

#[test]
fn a_robot_that_another_program_commands_is_not_damped_by_a_request_to_stop() {
    if !crate::common::mujoco("a_robot_that_another_program_commands_is_not_damped_by_a_request_to_stop") {
        return;
    }
    let player = player();
    let options = LockstepOptions::default();
    let mut step = Lockstep::new(&player, &options).expect("MuJoCo");
    step.inject(Fault::OthersCommand);
    step.run_until(1.5, |_| false).expect("run");
    assert_eq!(step.runtime().state(), State::Passive);
    options.stop.store(true, Ordering::Relaxed);
    step.run_until(1.0, |_| false).expect("run");
    assert_eq!(step.runtime().state(), State::Damping);
    assert_eq!(*step.robot.command(), LowCmd::default(), "something was sent");
}

#[test]
fn a_runtime_asked_to_stop_before_it_has_listened_continues_to_listen() {
    let player = player();
    // Milliseconds to the first command of a runtime that is asked to stop from its first step on.
    let first = |heard: bool| {
        let mut runtime = Runtime::new(Arc::clone(&player), Limits::default());
        let commands = |k: u64| {
            let state = Packet::LowState(healthy(2 * k as u32).sealed().to_cdr());
            let packets = if heard { vec![state] } else { Vec::new() };
            runtime.step(2000 * k, &packets, true).command.map(|_| 2 * k)
        };
        (1..1000).find_map(commands)
    };
    assert_eq!(first(true), Some(1002));
    assert_eq!(first(false), None, "there is no sign of a robot");
}

#[test]
fn without_checksums_every_other_fault_is_damped_as_before() {
    if !crate::common::mujoco("without_checksums_every_other_fault_is_damped_as_before") {
        return;
    }
    let limits = Limits { check_crc: false, ..Limits::default() };
    let others: Vec<Fault> = Fault::ALL.into_iter().filter(|fault| *fault != Fault::Checksum).collect();
    let report = drill(&player(), &limits, &others, 1, |_| {}).expect("drill");
    assert!(report.passed() && report.rows.len() == Fault::ALL.len() - 1, "{}", report.table());
}
