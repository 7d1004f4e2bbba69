//! What a policy's targets are held to: the joints' soft ranges, a step's length, and a slow begin of every kick.

use std::sync::Arc;

use crate::common::player;
use paid_runtime::log::{LogHeader, LogReader, LogWriter};
use paid_runtime::wire::{LowCmd, LowState};
use paid_runtime::{Limits, Packet, Player, PlayerSpec, State};
use paid_twin::{Lockstep, LockstepOptions, MatchOptions, play_match};

fn limits() -> Limits {
    Limits { stand_up_s: 0.3, listen_s: 0.0, ..Limits::default() }
}

/// A robot on the gantry that is ready for a kick, with a ball within reach.
fn ready(player: &Arc<Player>, limits: Limits) -> Lockstep {
    let mut step = Lockstep::new(player, &LockstepOptions { limits, seed: 1, ..LockstepOptions::default() })
        .expect("MuJoCo");
    step.make_ready(false).expect("ready");
    step.robot.place_ball([1.2, 0.0], [0.0; 2]);
    step
}

/// Targets of all joints, model order `[rad]`.
fn targets(step: &Lockstep) -> Vec<f64> {
    let status = step.runtime().status(step.robot.now_us());
    status.joints.iter().map(|joint| f64::from(joint.target_rad)).collect()
}

/// The angle at which a motor gives all its torque `[rad]`.
fn whole(player: &Player, j: usize) -> f64 {
    player.model.joints[j].effort_limit / player.control.stiffness[j]
}

/// A policy that asks for the same from every joint.
fn stubborn(player: &Player, action: f32) -> Arc<Player> {
    let mut player = player.clone();
    let last = player.policy.net.mlp.last().expect("a layer").clone();
    Arc::make_mut(&mut player.policy).params[last.bias.clone()].fill(action);
    Arc::new(player)
}

#[test]
fn a_policy_that_asks_for_too_much_gets_the_edge_of_the_soft_range() {
    if !crate::common::mujoco("a_policy_that_asks_for_too_much_gets_the_edge_of_the_soft_range") {
        return;
    }
    let good = player();
    let player = stubborn(&good, 60.0);
    let limits = Limits { action: 100.0, target_step: 10.0, switch_s: 0.0, ..limits() };
    let beyond = limits.target_beyond;
    let mut step = ready(&player, limits);
    // For the right foot: a kick of the left one is played in the mirror.
    step.robot.place_ball([1.2, -0.3], [0.0; 2]);
    assert!(step.run_until(4.0, |s| s.runtime().state() == State::Kick).expect("run"));
    for (j, target) in targets(&step).iter().enumerate() {
        let edge = player.control.soft_range[j][1] + beyond * whole(&player, j);
        assert!((target - edge).abs() < 1e-4, "joint {j}: {target} rad, the edge is {edge}");
    }
}

#[test]
fn targets_move_no_farther_in_a_step_than_allowed() {
    if !crate::common::mujoco("targets_move_no_farther_in_a_step_than_allowed") {
        return;
    }
    let good = player();
    let free = Limits { switch_s: 0.0, ..limits() };
    let longest = |limits: Limits| {
        let mut step = ready(&good, limits);
        assert!(step.run_until(4.0, |s| s.runtime().state() == State::Kick).expect("run"));
        let (mut before, mut longest) = (targets(&step), 0.0_f64);
        step.run_until(1.5, |s| {
            let now = targets(s);
            for (j, (a, b)) in before.iter().zip(&now).enumerate() {
                longest = longest.max((a - b).abs() / whole(&good, j));
            }
            before = now;
            false
        })
        .expect("run");
        longest
    };
    let usual = longest(free.clone());
    assert!(usual > 0.1 && usual < 1.5, "{usual} of a motor's whole angle");
    let held = longest(Limits { target_step: 0.05, ..free });
    assert!((held - 0.05).abs() < 1e-4, "{held}");
}

#[test]
fn the_first_target_of_a_second_kick_does_not_jump() {
    if !crate::common::mujoco("the_first_target_of_a_second_kick_does_not_jump") {
        return;
    }
    let player = player();
    let mut step = ready(&player, limits());
    let kick = |n: usize| move |s: &Lockstep| s.runtime().kicks() == n && s.runtime().state() == State::Kick;
    assert!(step.run_until(4.0, kick(1)).expect("run"));
    assert!(step.run_until(20.0, |s| s.runtime().state() == State::Ready).expect("run"));
    step.robot.place_ball([1.1, -0.2], [0.0; 2]);
    // The target before each step; the policy acts in the step that begins the kick.
    let mut before = targets(&step);
    let begun = step
        .run_until(6.0, |s| {
            let begins = kick(2)(s);
            if !begins {
                before = targets(s);
            }
            begins
        })
        .expect("run");
    assert!(begun, "{:?}", step.runtime().waiting());
    let reach = limits().kick_rad_s * 0.002 + 1e-5;
    let (mut worst, mut ticks) = (0.0_f64, 0);
    step.run_until(0.098, |s| {
        let now = targets(s);
        worst = before.iter().zip(&now).fold(worst, |worst, (a, b)| worst.max((a - b).abs()));
        before = now;
        ticks += 1;
        false
    })
    .expect("run");
    assert!(worst > 0.01 && worst <= 2.0 * reach, "{worst} rad in {ticks} commands");
}

#[test]
fn no_command_of_a_kick_asks_a_motor_for_more_than_it_has() {
    if !crate::common::mujoco("no_command_of_a_kick_asks_a_motor_for_more_than_it_has") {
        return;
    }
    let player = player();
    let dir = tempfile::tempdir().expect("dir");
    let file = dir.path().join("kick.mcap");
    let mut options = MatchOptions::default();
    options.field.kicks = 1;
    let spec = PlayerSpec { policy: "demo".into(), motions: None, sets: Vec::new() };
    let header = LogHeader { player: spec, limits: options.lockstep.limits.clone() };
    let log = LogWriter::create(&file, &header).expect("log");
    play_match(&player, &options, Some(log), None, |_| {}).expect("match");

    let mut reader = LogReader::open(&file).expect("log");
    let (mut state, mut commands, mut whole) = (LowState::default(), 0, 0);
    while let Some(frame) = reader.next_frame().expect("frame") {
        for packet in &frame.packets {
            if let Packet::LowState(bytes) = packet {
                state = LowState::from_cdr(bytes).expect("a state");
            }
        }
        if !matches!(frame.state, State::Kick | State::Settle) {
            continue;
        }
        let command = LowCmd::from_cdr(&frame.command).expect("a command");
        for (j, &m) in player.motors.iter().enumerate() {
            let (motor, is) = (&command.motors[m], &state.motors[m]);
            let torque = motor.kp * (motor.q - is.q) + motor.kd * (motor.dq - is.dq) + motor.tau;
            let share = f64::from(torque.abs()) / player.model.joints[j].effort_limit;
            assert!(share < 1.001, "joint {j}: {torque} N m");
            whole += usize::from(share > 0.999);
        }
        commands += 1;
    }
    // The limit is met, not only kept.
    assert!(commands > 1000 && whole > 10, "{commands} commands, {whole} with all of a motor's torque");
}
