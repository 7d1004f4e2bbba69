//! Uneven ground in MuJoCo lies where the simulator says, and where the built-in engine has it.

use paid_mujoco::{Ground, Library, MujocoSim, SceneOptions};
use paid_physics::{Engine, EngineSpec, LaneState, SceneConfig, Simulator};
use paid_robot::{RobotModel, RobotSpec};

const RADIUS: f64 = 0.11;
const GROUNDS: [Ground; 3] = [
    Ground::Rough { amplitude_m: 0.01, seed: 4 },
    Ground::Rough { amplitude_m: 0.03, seed: 5 },
    Ground::Slope { angle_rad: 0.07, downhill_rad: 2.0 },
];

fn sim(ground: Ground) -> MujocoSim {
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    let control = spec.resolve(&model).expect("the G1");
    MujocoSim::new(&model, &control, &SceneOptions { ground, ..SceneOptions::default() }, 1).expect("a scene")
}

/// The robot high above `xy`, where it touches nothing.
fn robot_above(sim: &mut MujocoSim, [x, y]: [f64; 2]) {
    let state = sim.save_lane(0, 0);
    let state = LaneState { base_pos: [x, y, 50.0], warm_start: Vec::new(), ..state };
    sim.reset_lane(0, 0, &state);
    sim.refresh(0);
}

/// Points of a disc of some meters, evenly.
fn points() -> impl Iterator<Item = [f64; 2]> {
    (0..60).map(|k| {
        let (angle, distance) = (2.4 * f64::from(k), 0.5 * f64::from(k).sqrt());
        [distance * angle.cos(), distance * angle.sin()]
    })
}

#[test]
fn a_ball_touches_the_ground_where_the_simulator_says() {
    let Some(_) = paid_testing::mujoco("a_ball_touches_the_ground_where_the_simulator_says", Library::get())
    else {
        return;
    };
    for ground in GROUNDS {
        let mut sim = sim(ground);
        // Far from the origin the field has moved along.
        for far in [[0.0, 0.0], [70.0, -31.0]] {
            robot_above(&mut sim, far);
            sim.step(0, &[0.0; 29]);
            for [x, y] in points() {
                let [x, y, z] = sim.ball_on_ground(0, 0, [far[0] + x, far[1] + y], RADIUS, false);
                for (deeper, touches) in [(0.002, true), (-0.002, false)] {
                    sim.set_ball(0, 0, [x, y, z - deeper], [0.0; 3], [0.0; 3]);
                    let world = sim.world_mut(0);
                    world.forward();
                    let ball = world.geom("ball").expect("a ball");
                    let depths = (0..world.contact_count())
                        .map(|i| world.contact(i))
                        .filter(|contact| contact.geoms.contains(&ball))
                        .map(|contact| -contact.dist);
                    let depth = depths.fold(0.0, f64::max);
                    // 2 mm along the vertical are less along a normal, of a slope of up to 0.85.
                    let expected = if touches { 0.001..0.0027 } else { 0.0..0.0005 };
                    assert!(expected.contains(&depth), "{ground:?} at ({x}, {y}): {depth} at {deeper}");
                }
            }
        }
    }
}

#[test]
fn a_ball_that_is_put_down_on_rough_ground_lies_still() {
    let Some(_) = paid_testing::mujoco("a_ball_that_is_put_down_on_rough_ground_lies_still", Library::get())
    else {
        return;
    };
    let mut sim = sim(GROUNDS[0]);
    robot_above(&mut sim, [0.0; 2]);
    for xy in points().take(10) {
        let [x, y, z] = sim.ball_on_ground(0, 0, xy, RADIUS, true);
        assert!((x - xy[0]).hypot(y - xy[1]) < 0.15, "{xy:?} to ({x}, {y})");
        robot_above(&mut sim, [0.0; 2]);
        sim.set_ball(0, 0, [x, y, z], [0.0; 3], [0.0; 3]);
        // A second; the robot falls less than its 50 m.
        for _ in 0..50 {
            sim.step(0, &[0.0; 29]);
        }
        let [a, b, c] = sim.state(0).ball.pos.0;
        assert!((a - x).hypot(b - y) < 0.01, "{xy:?}: moved from ({x}, {y}) to ({a}, {b})");
        assert!((c - z).abs() < 0.001, "{xy:?}: {c} instead of {z}");
    }
}

#[test]
fn a_ball_rolls_down_a_slope() {
    let Some(_) = paid_testing::mujoco("a_ball_rolls_down_a_slope", Library::get()) else { return };
    let mut sim = sim(GROUNDS[2]);
    robot_above(&mut sim, [0.0; 2]);
    let at = sim.ball_on_ground(0, 0, [1.0, 1.0], RADIUS, true);
    sim.set_ball(0, 0, at, [0.0; 3], [0.0; 3]);
    for _ in 0..50 {
        sim.step(0, &[0.0; 29]);
    }
    // A thin shell rolls with g sin(a) / (1 + 2/3), in a second half of that, downhill.
    let expected = 0.5 * 9.81 * 0.07_f64.sin() / (1.0 + 2.0 / 3.0);
    let [x, y, z] = sim.state(0).ball.pos.0;
    let (moved, way) = ([x - 1.0, y - 1.0], 2.0_f64.sin_cos());
    let along = moved[0] * way.1 + moved[1] * way.0;
    assert!((along - expected).abs() < 0.01, "{along} m, expected {expected}");
    assert!((moved[1] * way.1 - moved[0] * way.0).abs() < 0.002, "{moved:?}");
    assert!((z - (sim.ground_height(0, 0, [x, y]) + RADIUS)).abs() < 0.002, "{z}");
}

#[test]
fn the_built_in_engine_has_the_same_heights() {
    let Some(_) = paid_testing::mujoco("the_built_in_engine_has_the_same_heights", Library::get()) else {
        return;
    };
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    let ground = GROUNDS[1];
    let scene = SceneConfig { terrain: ground.terrain().expect("rough"), ..SceneConfig::default() };
    let spec = EngineSpec::for_robot(&model, &spec).expect("the G1");
    let engine = Engine::<f64>::new(&model, spec, &scene, 1).expect("a scene");
    let sim = sim(ground);
    for (i, j) in [(0, 0), (1, 0), (0, 1), (-3, 7), (50, -60), (200, 300)] {
        // At grid points, and in the middle of two.
        for [x, y] in [[0.0, 0.0], [0.5, 0.0], [0.0, 0.5]] {
            let xy = [0.1 * (f64::from(i) + x + 1e-9), 0.1 * (f64::from(j) + y + 1e-9)];
            let (own, builtin) = (sim.ground_height(0, 0, xy), engine.ground_height(0, 0, xy));
            assert!((own - builtin).abs() < 1e-7, "{xy:?}: {own} and {builtin}");
        }
    }
}

#[test]
fn a_soft_floor_yields_to_the_feet() {
    let Some(_) = paid_testing::mujoco("a_soft_floor_yields_to_the_feet", Library::get()) else { return };
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    let control = spec.resolve(&model).expect("the G1");
    let targets = control.default_pos.clone();
    let depths = |time_s: f64| {
        let mut scene = SceneOptions::default();
        scene.floor.solref[0] = time_s;
        let mut sim = MujocoSim::new(&model, &control, &scene, 1).expect("a scene");
        let home = LaneState {
            base_pos: [0.0, 0.0, spec.nominal_height_m],
            warm_start: Vec::new(),
            ..sim.save_lane(0, 0)
        };
        sim.reset_lane(0, 0, &home);
        // It comes down by some millimeters, and stands.
        let (mut deepest, mut last) = (0.0_f64, 0.0);
        for _ in 0..20 {
            sim.step(0, &targets);
            let world = sim.world(0);
            let depths = (0..world.contact_count()).map(|i| -world.contact(i).dist);
            last = depths.fold(0.0, f64::max);
            deepest = deepest.max(last);
        }
        [deepest, last].map(|depth| 1e3 * depth)
    };
    // Landing and standing [mm].
    let [hard, usual, turf] = [0.004, 0.01, 0.04].map(depths);
    assert!(hard[0] < 0.5 && hard[1] < 0.2, "{hard:?}");
    assert!((0.8..2.0).contains(&usual[0]) && usual[1] < 0.2, "{usual:?}");
    assert!((3.5..5.5).contains(&turf[0]) && (0.4..0.9).contains(&turf[1]), "{turf:?}");
}
