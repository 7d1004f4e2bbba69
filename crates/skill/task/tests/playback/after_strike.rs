//! What is shown of the ball after the strike.

use paid_policy::VecEnv;
use paid_task::{EpisodeRules, InitialState, TaskShard};

use super::simulator::{steps, task};

/// Ahead of the base in what policy and critic are shown of the ball, after every step up to the 60th. The ball lies 0.59 m ahead of the
/// first frame, the robot slides on by 1 cm a frame, the ball flies at 4 m/s from frame 40 on, which is the strike.
fn ahead(more: &[&str], rules: EpisodeRules) -> Vec<[f64; 2]> {
    let mut task = task("stage2", more, 1, 40);
    task.eval().set_rules(rules);
    task.eval().force_start(0, &InitialState::nominal(0)).expect("exists");
    let [at_policy, at_critic] = [&task.layout().policy, &task.layout().critic]
        .map(|group| group.place("ball_pos").expect("a term").start);
    let (mut policy, mut critic) = (vec![0.0; task.policy_obs_dim()], vec![0.0; task.critic_obs_dim()]);
    let mut shown = Vec::new();
    for _ in 0..58 {
        steps(&mut task, 1);
        task.observe(&mut [&mut policy, &mut critic]);
        shown.push([policy[at_policy], critic[at_critic]].map(f64::from));
    }
    shown
}

#[test]
fn policy_and_critic_are_shown_where_the_ball_lay_in_training_and_in_evaluations() {
    let rule = ["ball.after_strike.show=where_it_lay", "ball.after_strike.from_s=0.3"];
    for rules in [EpisodeRules::TRAINING, EpisodeRules::evaluation()] {
        let (as_it_is, by_rule) = (ahead(&[], rules), ahead(&rule, rules));
        for step in 1..=58 {
            let (flies, shown) = (as_it_is[step - 1], by_rule[step - 1]);
            // Before the strike it lies; at step 40 it has flown for one frame.
            let way = if step < 40 { 0.0 } else { 0.08 * (step - 39) as f64 };
            let lies = 0.59 - 0.01 * step as f64;
            // 0.3 s are 15 frames.
            let expected = if step < 55 { lies + way } else { lies };
            for k in 0..2 {
                assert!((flies[k] - lies - way).abs() < 1e-5, "{step}: {flies:?}");
                assert!((shown[k] - expected).abs() < 1e-5, "{step}: {shown:?}, expected {expected}");
            }
        }
    }
}
