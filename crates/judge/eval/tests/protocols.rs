//! The protocols on the built-in engine with the real motions, driven by a policy that needs no training.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use paid_eval::EvalError;
use paid_eval::engine::EngineChoice;
use paid_eval::episodes::EvalSetup;
use paid_eval::monitor::Monitor;
use paid_eval::policy::{Driver, ZeroDriver};
use paid_eval::shooting::{self, Grid, Placement, ShootingOptions, Variant, plan};
use paid_eval::tracking::{self, TrackingOptions};
use paid_lanes::Isa;
use paid_learn::ranks::ThreadRanks;
use paid_motion::MotionLibrary;
use paid_play::ReferenceLibrary;
use paid_robot::{RobotModel, RobotSpec};
use paid_task::TaskPreset;
use paid_task::preset::KnowledgeMode;
use paid_train::Ranks;

/// The folder of the standard kicks, or `None` (the test is skipped).
fn motions(test: &str) -> Option<PathBuf> {
    paid_testing::shared_data(test, "data/motions/paid/standard")
}

fn setup(folder: &Path, task: &str, threads: usize) -> EvalSetup {
    let (robot, spec) = (RobotModel::g1(), RobotSpec::g1());
    let motions = MotionLibrary::load(folder, &robot, &spec, 50.0).expect("good motions");
    let library = ReferenceLibrary::from_motions(&motions, &robot, &spec).expect("fits the robot");
    EvalSetup {
        engine: EngineChoice::Builtin,
        isa: Isa::detect(),
        robot,
        spec,
        library: Arc::new(library),
        preset: TaskPreset::builtin(task).expect("built in"),
        threads,
        seed: 5,
        monitor: Monitor::default(),
        ranks: Arc::new(paid_train::Alone),
    }
}

fn zero(setup: &EvalSetup) -> impl Fn() -> Result<Box<dyn Driver>, EvalError> + Sync {
    let obs_dim = setup.preset.observations.layout(&setup.spec).expect("terms").policy_dim();
    let action_dim = setup.spec.policy_joint_order.len();
    move || Ok(Box::new(ZeroDriver { obs_dim, action_dim }) as Box<dyn Driver>)
}

#[test]
fn shots_repeat_whatever_the_number_of_threads() {
    let Some(folder) = motions("shots_repeat_whatever_the_number_of_threads") else { return };
    let options = ShootingOptions {
        grid: Grid { x: [0.75, 1.0], y: [0.0, 0.0], step: 0.25 },
        trials: 40,
        rolling: Some(shooting::ROLLING_SPEED),
        limit_s: 0.6,
        ..ShootingOptions::default()
    };
    let run = |threads| {
        let setup = setup(&folder, "paper_stage2", threads);
        shooting::evaluate(&setup, &zero(&setup), &options).expect("runs")
    };
    let (one, three) = (run(1), run(3));
    assert_eq!(one, three);
    assert_eq!((one.cells.len(), one.trials.len()), (2, 80));
    let start = one.trials[7].path[0][1];
    let end = one.trials[7].path.last().expect("steps")[1];
    assert!((start[0] - end[0]).hypot(start[1] - end[1]) > 0.03, "the ball rolls: {start:?} {end:?}");
    // The goal is 5 m ahead of the grid's origin, wherever the robot was put.
    let trial = &one.trials[0].trial;
    let ball = one.trials[0].path[0][1];
    assert!(
        (ball[0] - (trial.place[0] - 5.0)).abs() < 1e-3 && (ball[1] - trial.place[1]).abs() < 1e-3,
        "{ball:?}"
    );
}

#[test]
fn ranks_share_out_the_trials_and_report_what_one_process_reports() {
    let Some(folder) = motions("ranks_share_out_the_trials_and_report_what_one_process_reports") else {
        return;
    };
    let options = ShootingOptions {
        grid: Grid { x: [0.75, 1.0], y: [0.0, 0.0], step: 0.25 },
        trials: 40,
        limit_s: 0.6,
        ..ShootingOptions::default()
    };
    let run = |ranks: Arc<dyn Ranks>, trials: usize| {
        let monitor = Monitor::default();
        let of = |task| EvalSetup {
            ranks: Arc::clone(&ranks),
            monitor: monitor.clone(),
            ..setup(&folder, task, 1)
        };
        let (shots, clips) = (of("paper_stage2"), of("paper_stage1"));
        let shooting =
            shooting::evaluate(&shots, &zero(&shots), &ShootingOptions { trials, ..options.clone() })?;
        let sets = vec!["standard".to_owned(); clips.library.len()];
        let tracking = TrackingOptions { starts: 8, sets, limits: true };
        let tracking = tracking::evaluate(&clips, &zero(&clips), &tracking)?;
        Ok::<_, EvalError>((shooting, tracking, monitor.effort().trials, monitor.effort().control_steps))
    };
    let on_two = |trials: [usize; 2]| -> Vec<_> {
        std::thread::scope(|scope| {
            let start = |(ranks, trials)| scope.spawn(move || run(Arc::new(ranks) as Arc<dyn Ranks>, trials));
            let threads: Vec<_> = ThreadRanks::of(2).into_iter().zip(trials).map(start).collect();
            threads.into_iter().map(|thread| thread.join().expect("no panic")).collect()
        })
    };
    let alone = run(Arc::new(paid_train::Alone), 40).expect("runs");
    assert!(alone.2 > 80, "more than a batch: {}", alone.2);
    for rank in on_two([40, 40]) {
        assert_eq!(rank.expect("runs"), alone);
    }
    // Two batches of one, three of the other.
    for (rank, expected) in on_two([40, 80]).into_iter().zip([80, 160]) {
        let text = rank.expect_err("they differ").to_string();
        let start = format!("several processes: expected {expected} trials on every rank, found ");
        assert!(text.starts_with(&start), "{text}");
    }
}

#[test]
fn perceived_shots_repeat_and_their_motions_are_chosen_by_what_the_robot_sees() {
    let Some(folder) = motions("perceived_shots_repeat_and_their_motions_are_chosen_by_what_the_robot_sees")
    else {
        return;
    };
    let options = ShootingOptions {
        grid: Grid { x: [0.75, 1.5], y: [-0.5, 0.5], step: 0.25 },
        trials: 6,
        rolling: Some(shooting::ROLLING_SPEED),
        limit_s: 0.4,
        ..ShootingOptions::default()
    };
    let setup = |knowledge, threads| {
        let setup = setup(&folder, "paper_stage2", threads);
        EvalSetup { preset: setup.preset.with_knowledge(knowledge), ..setup }
    };
    let run = |threads| {
        let setup = setup(KnowledgeMode::Perceived, threads);
        shooting::evaluate(&setup, &zero(&setup), &options).expect("runs")
    };
    let (one, three) = (run(1), run(3));
    assert_eq!(one, three);
    assert!(one.title().contains("; knowledge: perceived (the tracker's ball position"), "{}", one.title());
    assert!(one.csv().lines().skip(1).all(|line| line.ends_with(",perceived")));
    // The same balls, and another motion for those near a border.
    let truth = plan(&setup(KnowledgeMode::Truth, 1), &options).expect("plans");
    let others = one.trials.iter().zip(&truth).filter(|(o, t)| {
        assert_eq!((o.trial.place, o.trial.repeat), (t.place, t.repeat));
        o.trial.motion != t.motion
    });
    let others = others.count();
    assert!((1..truth.len() / 4).contains(&others), "{others} of {}", truth.len());
}

#[test]
fn standing_still_tracks_no_kick() {
    let Some(folder) = motions("standing_still_tracks_no_kick") else { return };
    let setup = setup(&folder, "paper_stage1", 2);
    let options =
        TrackingOptions { starts: 2, sets: vec!["standard".to_owned(); setup.library.len()], limits: true };
    let report = tracking::evaluate(&setup, &zero(&setup), &options).expect("runs");
    assert_eq!(report.runs.len(), 3 * setup.library.len());
    let set = &report.sets[0];
    let exact = set.exact.expect("exact starts");
    assert!(exact.displacement_share.abs() < 0.5, "{set:?}");
    assert!(exact.foot_speed_share < 0.5 && exact.errors.mpjpe_mm > 5.0, "{set:?}");
    assert!(report.table().contains("PAiD (paper)"));
    let bodies: Vec<f64> = report.bodies.iter().filter_map(|b| b.error_mm[0]).collect();
    let mean = bodies.iter().sum::<f64>() / bodies.len() as f64;
    assert_eq!((bodies.len(), bodies[0]), (setup.spec.tracked_bodies.len(), 0.0));
    assert!((mean - exact.errors.mpjpe_mm).abs() < 1e-9, "{bodies:?}");
    assert!(report.table().contains("left_ankle_roll_link"), "{}", report.table());
    // The first frame is the motion's own: its error is the engine's rounding.
    assert!(report.runs.iter().filter(|r| r.exact).all(|r| r.frames > 1));
}

#[test]
fn a_plan_is_in_the_robots_axes_and_leaves_room_for_the_ball() {
    let Some(folder) = motions("a_plan_is_in_the_robots_axes_and_leaves_room_for_the_ball") else { return };
    let setup = setup(&folder, "paper_stage2", 1);
    let placement = Placement::new(&setup);
    let options = ShootingOptions { grid: Grid::EFFECTIVE, trials: 5, ..ShootingOptions::default() };
    let world = plan(&setup, &options).expect("plans");
    assert_eq!(world.len(), 7 * 9 * 5);
    for t in &world {
        for k in 0..2 {
            assert!((t.ball[k] + t.displacement[k] - t.place[k]).abs() < 1e-12);
        }
        assert!(t.displacement[0].hypot(t.displacement[1]) <= 0.5);
        assert!(!placement.overlaps(t.motion, t.ball));
        assert_eq!(t.motion, placement.motion(0, 0, t.ball, t.ball_velocity));
    }
    let robot = ShootingOptions { trials: 1, variant: Variant::Robot, ..ShootingOptions::default() };
    assert!(plan(&setup, &robot).expect("plans").iter().all(|t| t.ball == t.place && t.goal == [5.0, 0.0]));
    // The ball does not fit under the feet; and motion 001 goes 0.82 m straight ahead.
    assert!(placement.overlaps(0, [0.0, 0.1]) && placement.overlaps(0, [0.0, -0.1]));
    assert_eq!(placement.motion(0, 0, [0.82, 0.0], [0.0; 2]), 0);
}

#[test]
fn a_policy_of_another_size_is_refused() {
    let Some(folder) = motions("a_policy_of_another_size_is_refused") else { return };
    let setup = setup(&folder, "paper_stage2", 1);
    let options = ShootingOptions { trials: 1, ..ShootingOptions::default() };
    let small = || Ok(Box::new(ZeroDriver { obs_dim: 3, action_dim: 29 }) as Box<dyn Driver>);
    let error = shooting::evaluate(&setup, &small, &options).expect_err("does not fit").to_string();
    assert!(error.contains("length of the observation") && error.contains('3'), "{error}");
}

#[test]
fn a_film_shows_the_robot() {
    let Some(folder) = motions("a_film_shows_the_robot") else { return };
    let setup = setup(&folder, "paper_stage2", 1);
    let (rules, _) = shooting::rules_of(&ShootingOptions::default(), 0.02);
    let start = paid_task::InitialState::nominal(0);
    let films = paid_eval::episodes::run_episodes(&setup, &zero(&setup), &[start], rules, 10, |_| {
        paid_plot::Film::default()
    })
    .expect("runs");
    assert_eq!(films[0].1.poses.len(), 11);
    let image = paid_plot::frame(&setup.robot, &films[0].1.poses[10], Some(0.11), 1.0, [160, 120]);
    let mut empty = films[0].1.poses[10].clone();
    empty.pos.truncate(1);
    let without = paid_plot::frame(&setup.robot, &empty, Some(0.11), 1.0, [160, 120]);
    let differ = (0..120).flat_map(|y| (0..160).map(move |x| (x, y)));
    let differ = differ.filter(|&(x, y)| image.get(x, y) != without.get(x, y)).count();
    assert!(differ > 300, "the robot covers part of the image: {differ} pixels");
}
