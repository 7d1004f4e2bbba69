//! The next kick of a robot that is not reset.

use paid_policy::VecEnv;
use paid_task::{EpisodeRules, EvalControl, InitialState, NextKick, TaskShard, TimeLimit};

use super::simulator::{FRAMES, Playback, steps, task};

const NEXT: NextKick =
    NextKick { motion: 0, ball_xy: [1.0, 0.25], ball_velocity: [0.1, 0.2], goal_xy: [5.0, -1.0], look: 1 };

fn near(found: [f64; 3], expected: [f64; 3]) {
    assert!((0..3).all(|k| (found[k] - expected[k]).abs() < 1e-9), "{found:?}, expected {expected:?}");
}

fn standing() -> paid_task::Task<f64, Playback> {
    let mut task = task("stage2", &["ball.after_strike.show=where_it_lay"], 1, 40);
    task.eval()
        .set_rules(EpisodeRules { time_limit: TimeLimit::Steps(u32::MAX), ..EpisodeRules::evaluation() });
    task.eval().force_start(0, &InitialState::nominal(0)).expect("exists");
    steps(&mut task, 80);
    task
}

#[test]
fn the_reference_begins_where_the_robot_stands_and_the_ball_lies_before_it() {
    let mut task = standing();
    let before = task.sample(0).expect("exists");
    assert!(before.kick.is_some() && before.motion_ended);
    assert_eq!(before.reference_anchor.0, [0.0, -0.59], "where the clip ends");
    task.eval().next_kick(0, &NEXT).expect("exists");
    let sample = task.sample(0).expect("exists");
    // The robot slid to (0, -0.59) and looks along -y: ahead is -y, left is +x.
    assert_eq!((&sample.bodies, &sample.joint_pos), (&before.bodies, &before.joint_pos), "untouched");
    near(sample.ball_pos, [0.25, -1.59, 0.11]);
    near(sample.ball_vel, [0.2, -0.1, 0.0]);
    near(sample.goal_pos, [-1.0, -5.59, 0.11]);
    assert!((sample.reference_anchor.0[1] + 0.59).abs() < 1e-9, "{:?}", sample.reference_anchor);
    assert_eq!((sample.frame, sample.step, sample.kick), (0, 80, None));
    // A frame on, the reference has slid by a centimeter.
    steps(&mut task, 1);
    let later = task.sample(0).expect("exists");
    assert!((later.reference_anchor.0[1] + 0.6).abs() < 1e-9 && !later.motion_ended);
    steps(&mut task, FRAMES - 2);
    assert!(task.sample(0).expect("exists").motion_ended);
}

#[test]
fn the_new_ball_is_shown_until_its_own_strike() {
    let mut task = standing();
    let place = task.layout().policy.place("ball_pos").expect("a term").start;
    let (mut policy, mut critic) = (vec![0.0; task.policy_obs_dim()], vec![0.0; task.critic_obs_dim()]);
    task.observe(&mut [&mut policy, &mut critic]);
    assert!(policy[place].abs() < 1e-5, "where the first one lay, now below the robot: {}", policy[place]);
    task.eval().next_kick(0, &NextKick { ball_velocity: [0.0; 2], ..NEXT }).expect("exists");
    task.observe(&mut [&mut policy, &mut critic]);
    assert!((policy[place] - 1.0).abs() < 1e-5 && (policy[place + 1] - 0.25).abs() < 1e-5);
}

#[test]
fn a_motion_or_a_number_that_is_none_is_refused() {
    let mut task = standing();
    let mut error = |next: &NextKick| task.eval().next_kick(0, next).expect_err("bad").to_string();
    assert!(error(&NextKick { motion: 1, ..NEXT }).contains("motion 1 of 1"));
    assert!(error(&NextKick { ball_xy: [f64::NAN, 0.0], ..NEXT }).contains("not finite"));
}
