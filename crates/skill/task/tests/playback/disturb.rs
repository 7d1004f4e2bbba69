//! Disturbances of an environment from outside.

use paid_physics::Simulator;
use paid_policy::VecEnv;
use paid_task::{Disturbance, EpisodeRules, EvalControl, InitialState, TaskShard};

use super::simulator::{Playback, steps, task};

fn standing() -> paid_task::Task<f64, Playback> {
    let mut task = task("stage2", &[], 1, 40);
    task.eval().set_rules(EpisodeRules::evaluation());
    task.eval().force_start(0, &InitialState::nominal(0)).expect("exists");
    steps(&mut task, 5);
    task
}

#[test]
fn a_push_is_the_impulse_over_the_robots_mass() {
    let mut task = standing();
    let mass = task.simulator().model().mass();
    task.eval().disturb(0, &Disturbance::Push([0.0, 2.0 * mass, 0.0])).expect("exists");
    let (_, linear, angular) = *task.simulator().pushes.last().expect("pushed");
    assert!((linear[1] - 2.0).abs() < 1e-12 && linear[0] == 0.0 && linear[2] == 0.0, "{linear:?}");
    assert_eq!(angular, [0.0; 3]);
}

#[test]
fn a_released_ball_rolls_without_sliding_and_the_robot_continues() {
    let mut task = standing();
    let before = task.sample(0).expect("exists");
    let ball = Disturbance::Ball { pos: [1.0, 2.0, 0.11], vel: [0.0, 1.1, 0.0] };
    task.eval().disturb(0, &ball).expect("exists");
    let after = task.sample(0).expect("exists");
    assert_eq!((after.ball_pos, after.ball_vel), ([1.0, 2.0, 0.11], [0.0, 1.1, 0.0]));
    // 1.1 m/s on a radius of 0.11 m.
    let spin = task.eval().ball_spin(0).expect("exists");
    assert!((spin[0] + 10.0).abs() < 1e-9 && spin[1] == 0.0 && spin[2] == 0.0, "{spin:?}");
    assert_eq!((after.frame, after.step, after.bodies), (before.frame, before.step, before.bodies));
}

#[test]
fn a_goal_that_is_carried_away_is_observed_there() {
    let mut task = standing();
    let place = task.layout().policy.place("goal_pos").expect("a term").start;
    let (mut policy, mut critic) = (vec![0.0; task.policy_obs_dim()], vec![0.0; task.critic_obs_dim()]);
    task.observe(&mut [&mut policy, &mut critic]);
    let before = policy[place..place + 2].to_vec();
    let [x, y, _] = task.sample(0).expect("exists").goal_pos;
    task.eval().disturb(0, &Disturbance::Goal([x + 3.0, y + 4.0])).expect("exists");
    assert_eq!(task.sample(0).expect("exists").goal_pos[..2], [x + 3.0, y + 4.0]);
    task.observe(&mut [&mut policy, &mut critic]);
    let moved = f64::from(policy[place] - before[0]).hypot(f64::from(policy[place + 1] - before[1]));
    assert!((moved - 5.0).abs() < 0.3, "5 m over the ground, seen from a base that may tilt: {moved}");
}

#[test]
fn numbers_that_are_none_and_environments_that_do_not_exist_are_refused() {
    let mut task = standing();
    for bad in [
        Disturbance::Push([f64::NAN, 0.0, 0.0]),
        Disturbance::Ball { pos: [0.0; 3], vel: [f64::INFINITY, 0.0, 0.0] },
        Disturbance::Goal([f64::NAN; 2]),
    ] {
        assert!(task.eval().disturb(0, &bad).is_err(), "{bad:?}");
    }
    assert!(task.eval().disturb(1, &Disturbance::Goal([0.0; 2])).is_err());
    assert!(task.eval().ball_spin(1).is_err());
}
