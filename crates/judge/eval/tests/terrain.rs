//! Evaluations on uneven ground in MuJoCo.

use paid_eval::engine::EngineChoice;
use paid_eval::episodes::EvalSetup;
use paid_eval::ground::Ground;
use paid_eval::policy::Driver;
use paid_eval::scene::{ScenePreset, SceneSpec};
use paid_eval::shooting::{self, Grid, ShootingOptions};
use paid_lanes::{Mat3, Vec3};
use paid_mujoco::{Library, MujocoSim, SceneOptions};
use paid_physics::Simulator;
use paid_robot::Shape;
use paid_task::{EnvSample, EpisodeRules, InitialState, TaskPreset};

use crate::common::{Puppet, demo, setup};

fn scene(ground: Option<Ground>) -> SceneOptions {
    let mut task = TaskPreset::builtin("paper_stage2").expect("built in");
    let spec = SceneSpec { ground, ..SceneSpec::default() };
    spec.resolve(&mut task, ScenePreset::Paper).expect("a scene")
}

fn on(ground: Ground, setup: EvalSetup) -> EvalSetup {
    EvalSetup { engine: EngineChoice::Mujoco(Box::new(scene(Some(ground)))), ..setup }
}

/// The least distance from a foot's shapes down to the ground `[m]`.
fn gap(setup: &EvalSetup, sample: &EnvSample, ground: impl Fn([f64; 2]) -> f64) -> f64 {
    let mut least = f64::INFINITY;
    for (body, at) in setup.robot.bodies.iter().zip(&sample.bodies) {
        for geom in body.geoms.iter().filter(|geom| geom.class == "referee") {
            let Shape::Capsule { ends, radius } = geom.shape else {
                panic!("the vendor's feet are capsules")
            };
            for share in [0.0, 0.25, 0.5, 0.75, 1.0] {
                let local = Vec3(ends[0]).scale(1.0 - share) + Vec3(ends[1]).scale(share);
                let Vec3([x, y, z]) = Mat3(at.rot).mul_vec(local) + Vec3(at.pos);
                least = least.min(z - radius - ground([x, y]));
            }
        }
    }
    least
}

#[test]
fn the_robot_starts_with_its_soles_on_the_ground_and_the_ball_lies_on_it() {
    let test = "the_robot_starts_with_its_soles_on_the_ground_and_the_ball_lies_on_it";
    let Some(_) = paid_testing::mujoco(test, Library::get()) else { return };
    for ground in Ground::ALL {
        let setup = on(ground, setup("paper_stage2"));
        let control = setup.spec.resolve(&setup.robot).expect("the G1");
        for trial in 0..6 {
            let own = SceneOptions {
                ground: scene(Some(ground)).ground.of_trial(setup.seed, trial),
                ..scene(Some(ground))
            };
            let sim = MujocoSim::new(&setup.robot, &control, &own, 1).expect("a scene");
            let mut shard = setup.build(1, trial as usize).expect("builds");
            let control = shard.eval();
            control.set_rules(EpisodeRules::evaluation());
            let start = InitialState { ball_xy: Some([1.0, 0.3]), ..InitialState::nominal(0) };
            control.force_start(0, &start).expect("starts");
            let sample = control.sample(0).expect("a sample");
            let gap = gap(&setup, &sample, |xy| sim.ground_height(0, 0, xy));
            println!("{} {trial}: {gap}", ground.name());
            assert!((-0.01..0.01).contains(&gap), "{} {trial}: {gap} m", ground.name());
            let [x, y, z] = sample.ball_pos;
            let center = sim.ball_on_ground(0, 0, [x, y], setup.preset.ball_params.radius_m, false)[2];
            assert!((z - center).abs() < 1e-9, "{} {trial}: {z}, expected {center}", ground.name());
            assert_eq!(sample.ground_m, {
                let [x, y, _] = sample.bodies[0].pos;
                sim.ground_height(0, 0, [x, y])
            });
        }
    }
}

#[test]
fn flat_ground_is_the_usual_scene_to_the_last_bit() {
    assert_eq!(scene(Some(Ground::Flat)), scene(None));
    assert_eq!(scene(None), SceneOptions::default());
    let (mut task, turf) = (TaskPreset::builtin("paper_stage2").expect("built in"), Some(Ground::Turf));
    // What the file says comes after its ground.
    let spec = SceneSpec { ground: turf, floor_friction: Some(0.5), ..SceneSpec::default() };
    let scene = spec.resolve(&mut task, ScenePreset::Paper).expect("a scene");
    assert_eq!((scene.floor.friction[0], scene.floor.solref), (0.5, [0.04, 1.0]));
    let ball = scene.ball.expect("a ball");
    assert!(ball.damped && ball.params == task.ball_params);
    assert_eq!([ball.params.linear_damping, ball.params.angular_damping], [0.12, 0.55]);
}

#[test]
fn shots_on_rough_ground_repeat_whatever_the_number_of_threads() {
    let test = "shots_on_rough_ground_repeat_whatever_the_number_of_threads";
    let Some(_) = paid_testing::mujoco(test, Library::get()) else { return };
    let options = ShootingOptions {
        grid: Grid { x: [0.5, 0.5], y: [0.0, 0.25], step: 0.25 },
        trials: 1,
        limit_s: 0.3,
        ..ShootingOptions::default()
    };
    let run = |ground, threads| {
        let setup = EvalSetup { threads, ..on(ground, setup("paper_stage2")) };
        let puppet = Puppet::new(&setup);
        let maker = || Ok(Box::new(puppet.clone()) as Box<dyn Driver>);
        let report = shooting::evaluate(&setup, &maker, &options).expect("runs");
        report.trials.iter().map(|trial| trial.path.clone()).collect::<Vec<_>>()
    };
    let rough = run(Ground::Rough2Cm, 1);
    assert_eq!(rough, run(Ground::Rough2Cm, 2));
    assert_ne!(rough, run(Ground::Flat, 1));
}

#[test]
fn the_demo_stands_on_every_ground_at_the_begin() {
    let test = "the_demo_stands_on_every_ground_at_the_begin";
    let Some(_) = paid_testing::mujoco(test, Library::get()) else { return };
    let (setup, plain) = demo();
    let options = ShootingOptions {
        grid: Grid { x: [1.0, 1.0], y: [0.0, 0.0], step: 0.25 },
        trials: 1,
        start_radius_m: 0.0,
        limit_s: 0.6,
        ..ShootingOptions::default()
    };
    for ground in Ground::ALL {
        let setup = on(ground, setup.clone());
        let maker = || Ok(Box::new(plain.clone()) as Box<dyn Driver>);
        let report = shooting::evaluate(&setup, &maker, &options).expect("runs");
        assert_eq!(report.total.falls_ever.count, 0, "{}", ground.name());
        let words = setup.engine.facts(&setup.preset).surfaces;
        assert_eq!(words.contains("rough by"), ground.name().starts_with("rough"), "{words}");
        assert_eq!(words.contains("slope of"), ground.name().starts_with("slope"), "{words}");
    }
}
