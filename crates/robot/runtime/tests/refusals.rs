//! What a runtime refuses, and what the flag for states without checksum does not weaken.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::common::player;
use paid_play::PolicyFile;
use paid_runtime::wire::{Key, LowState, Remote};
use paid_runtime::{DeployError, Limits, Packet, Player, PlayerSpec, Runtime, State};

fn policy() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../policies/demo/policy.onnx")
}

/// A healthy state of a robot that stands upright, without its checksum.
fn healthy(tick: u32) -> LowState {
    let mut state = LowState { mode_machine: 5, tick, ..LowState::default() };
    state.imu.quaternion = [1.0, 0.0, 0.0, 0.0];
    state.wireless_remote = Remote::pressing(&[]);
    state
}

/// L2 and up on the keyboard.
fn up() -> Packet {
    Packet::Keys((1 << Key::L2 as u16) | (1 << Key::Up as u16))
}

/// What comes of being asked to stand `age_us` after the last of three states that `sent` has made.
fn asked(
    player: &Arc<Player>,
    limits: Limits,
    age_us: u64,
    sent: fn(LowState) -> LowState,
) -> (State, String) {
    let mut runtime = Runtime::new(Arc::clone(player), Limits { listen_s: 0.0, ..limits });
    for k in 1..=3_u32 {
        let state = sent(healthy(2 * k));
        runtime.step(2000 * u64::from(k), &[Packet::LowState(state.to_cdr())], false);
    }
    let output = runtime.step(6000 + age_us, &[up()], false);
    (output.state, output.events.iter().map(|event| event.reason.clone()).collect())
}

#[test]
fn a_state_older_than_20_ms_refuses_to_stand_up() {
    let player = player();
    let at = |age_us| asked(&player, Limits::default(), age_us, LowState::sealed);
    assert_eq!(at(20_000).0, State::StandUp);
    let (state, told) = at(20_001);
    assert_eq!((state, told.as_str()), (State::Passive, "refused to stand up: no new state for 20 ms"));
    // A robot that never sent a state, too.
    let mut runtime = Runtime::new(Arc::clone(&player), Limits { listen_s: 0.0, ..Limits::default() });
    let output = runtime.step(2000, &[up()], false);
    assert_eq!(output.state, State::Passive);
    assert!(output.events[0].reason.starts_with("refused to stand up: no new state"), "{:?}", output.events);
}

#[test]
fn states_without_checksum_pass_only_where_the_flag_says_so() {
    let player = player();
    let flag = |check_crc| Limits { check_crc, ..Limits::default() };
    assert_eq!(asked(&player, flag(false), 0, |state| state).0, State::StandUp);
    // With the check they are no states at all.
    let (state, told) = asked(&player, flag(true), 0, |state| state);
    assert_eq!(state, State::Passive);
    assert!(told.contains("no new state") && told.contains("3 wrong checksums in a row"), "{told}");
}

#[test]
fn without_checksums_a_state_of_another_length_still_counts_as_broken() {
    let player = player();
    let limits = Limits { check_crc: false, listen_s: 0.0, stand_up_s: 0.01, ..Limits::default() };
    let mut runtime = Runtime::new(Arc::clone(&player), limits);
    let mut told = Vec::new();
    for k in 1..=20_u32 {
        let mut bytes = healthy(2 * k).to_cdr();
        if k > 15 {
            bytes.truncate(2000);
        }
        let mut packets = vec![Packet::LowState(bytes)];
        packets.extend((k == 3).then(up));
        let output = runtime.step(2000 * u64::from(k), &packets, false);
        told.extend(output.events.into_iter().map(|event| event.reason));
    }
    assert_eq!(runtime.state(), State::Damping);
    assert_eq!(told.last().map(String::as_str), Some("3 wrong checksums in a row"));
}

/// What becomes of the repository's policy after a change of what it was trained for.
fn changed(change: impl FnOnce(&mut PolicyFile)) -> Result<Player, DeployError> {
    let mut file = PolicyFile::load(&policy(), &[]).expect("policy");
    let library = Arc::clone(&player().library);
    change(&mut file);
    Player::new(file, library)
}

/// What is said of it.
fn refused(change: impl FnOnce(&mut PolicyFile)) -> String {
    match changed(change) {
        Err(DeployError::Policy(message)) => message,
        other => panic!("{:?}", other.map(|_| "a player")),
    }
}

#[test]
fn a_policy_for_another_robot_is_refused_with_what_differs() {
    let told = refused(|file| file.spec.policy_joint_order.swap(0, 1));
    assert!(told.contains("the policy is not for this robot") && told.contains("joint"), "{told}");
    let told = refused(|file| file.spec.natural_frequency_hz = 12.0);
    assert!(told.contains("the policy is not for this robot") && told.contains("stiffness"), "{told}");
}

#[test]
fn a_robot_file_of_the_policys_own_widens_no_limit() {
    let wide = |file: &mut PolicyFile| {
        for joint in &mut file.model.joints {
            joint.range = [joint.range[0] - 5.0, joint.range[1] + 5.0];
            joint.effort_limit *= 2.0;
        }
        // The same radians of target per unit of action.
        file.spec.action_scale_factor *= 0.5;
        for limit in &mut file.spec.velocity_limit {
            limit.value *= 100.0;
        }
    };
    let (found, expected) = (changed(wide).expect("the same contract"), player());
    assert_eq!((&found.model, &found.control), (&expected.model, &expected.control));
}

#[test]
fn a_robot_file_of_another_order_is_refused() {
    let told = refused(|file| file.model.joints.swap(0, 1));
    let expected = "joint 0 of its robot file: expected left_hip_pitch_joint, found left_hip_roll_joint";
    assert!(told.contains("the policy is not for this robot") && told.contains(expected), "{told}");
}

#[test]
fn a_policy_that_was_trained_without_a_ball_is_refused() {
    let spec = PlayerSpec {
        policy: policy().with_file_name("../../crates/skill/train/tests/samples/stage1.safetensors"),
        motions: None,
        sets: Vec::new(),
    };
    let Err(DeployError::Policy(message)) = Player::load(&spec) else { panic!("a player without a ball") };
    assert!(message.contains("stage1.safetensors: expected a policy of a task with a ball"), "{message}");
    assert!(message.contains("found the task '") && message.ends_with("without one"), "{message}");
}
