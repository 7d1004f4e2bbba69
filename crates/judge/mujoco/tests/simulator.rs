//! The simulator interface on MuJoCo, with a small robot of three bodies.

use paid_mujoco::{BallOptions, FootShapes, Library, MujocoSim, PdControl, SceneOptions, World, mjcf_scene};
use paid_physics::{BallParams, EnvParams, LaneState, Simulator};
use paid_robot::{Body, ControlSpec, Geom, Joint, RobotModel, Shape};

const PLATE: f64 = 0.1;

fn body(name: &str, parent: Option<usize>, pos: [f64; 3], mass: f64, geoms: Vec<Geom>) -> Body {
    let inertia = [0.02, 0.03, 0.025, 0.001, -0.002, 0.0005].map(|i: f64| i * mass);
    Body {
        name: name.to_owned(),
        parent,
        pos,
        quat: [1.0, 0.0, 0.0, 0.0],
        mass,
        com: [0.0, 0.0, 0.01],
        inertia,
        geoms,
    }
}

fn geom(name: &str, class: &str, shape: Shape) -> Geom {
    Geom { name: name.to_owned(), class: class.to_owned(), shape }
}

fn joint(name: &str, body: usize, axis: [f64; 3]) -> Joint {
    Joint {
        name: name.to_owned(),
        body,
        axis,
        range: [-1.0, 1.0],
        armature: 0.01,
        friction_loss: 0.1,
        damping: 0.0,
        effort_limit: 20.0,
    }
}

/// A base that stands on a wide foot, with an arm.
fn robot() -> (RobotModel, ControlSpec) {
    let sphere = |x: f64, y: f64| Shape::Sphere { center: [x, y, -PLATE], radius: 0.02 };
    let mut foot = vec![geom("shell", "collision", Shape::Sphere { center: [0.0; 3], radius: 0.09 })];
    for (i, (x, y)) in [(0.2, 0.2), (0.2, -0.2), (-0.2, 0.2), (-0.2, -0.2)].into_iter().enumerate() {
        foot.push(geom(&format!("sole{i}"), "sole", sphere(x, y)));
    }
    for (i, y) in [-0.2, 0.2].into_iter().enumerate() {
        let ends = [[-0.2, y, -PLATE], [0.2, y, -PLATE]];
        foot.push(geom(&format!("rail{i}"), "referee", Shape::Capsule { ends, radius: 0.02 }));
    }
    let trunk =
        geom("trunk", "collision", Shape::Capsule { ends: [[0.0; 3], [0.0, 0.0, 0.2]], radius: 0.05 });
    let arm = geom(
        "arm",
        "collision",
        Shape::Box { center: [0.1, 0.0, 0.0], half_size: [0.1, 0.02, 0.02], quat: [1.0, 0.0, 0.0, 0.0] },
    );
    let model = RobotModel {
        name: "<stand>".to_owned(),
        bodies: vec![
            body("base", None, [0.0, 0.0, 0.5], 3.0, vec![trunk]),
            body("foot", Some(0), [0.0, 0.0, -0.38], 2.0, foot),
            body("arm", Some(0), [0.06, 0.0, 0.1], 0.5, vec![arm]),
        ],
        joints: vec![joint("ankle", 1, [0.0, 1.0, 0.0]), joint("shoulder", 2, [0.0, 0.6, 0.8])],
        contact_exclusions: vec![(1, 2)],
    };
    let two = |x: f64| vec![x; 2];
    let control = ControlSpec {
        default_pos: two(0.0),
        stiffness: two(200.0),
        damping: two(5.0),
        action_scale: two(0.1),
        velocity_limit: two(20.0),
        soft_range: vec![[-0.9, 0.9]; 2],
    };
    (model, control)
}

fn sim(options: &SceneOptions) -> MujocoSim {
    let (model, control) = robot();
    MujocoSim::new(&model, &control, options, 2).unwrap()
}

fn moving_state() -> LaneState {
    LaneState {
        base_pos: [0.1, -0.2, 1.0],
        base_quat: [0.5, 0.5, -0.5, 0.5],
        base_lin_vel: [0.3, 0.2, -0.1],
        base_ang_vel: [1.0, -2.0, 0.5],
        joint_pos: vec![0.2, -0.3],
        joint_vel: vec![1.0, 2.0],
        ball_pos: [1.5, 0.0, 0.5],
        ball_vel: [0.0, 1.0, 0.0],
        ball_ang_vel: [3.0, 0.0, 1.0],
        warm_start: Vec::new(),
    }
}

fn close(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance, "{a} and {b} differ by more than {tolerance}");
}

#[test]
fn every_variant_of_the_scene_is_accepted_by_mujoco() {
    let Some(_) = paid_testing::mujoco("every_variant_of_the_scene_is_accepted_by_mujoco", Library::get())
    else {
        return;
    };
    let (model, control) = robot();
    let variants = [
        SceneOptions::default(),
        SceneOptions::public_protocol(),
        SceneOptions { feet: FootShapes::Sole, pd: PdControl::Implicit, ..SceneOptions::default() },
        SceneOptions { ball: None, goal: None, self_collision: false, ..SceneOptions::default() },
        SceneOptions::twist2(),
    ];
    // Floor and goal, ball, foot, trunk, arm.
    let geoms = [2 + 1 + 2 + 1 + 1, 7, 2 + 1 + 5 + 1 + 1, 1 + 4, 2 + 1 + 4 + 1 + 1];
    for (options, geoms) in variants.iter().zip(geoms) {
        let world = World::from_xml(&mjcf_scene(&model, &control, options)).unwrap();
        let ball = usize::from(options.ball.is_some());
        assert_eq!((world.nv(), world.nu(), world.ngeom()), (8 + 6 * ball, 2, geoms));
        assert_eq!(world.timestep(), options.physics_dt_s);
    }
}

#[test]
fn the_scene_of_the_twist2_tracker_has_spheres_for_feet_and_no_dry_friction() {
    let (model, control) = robot();
    let own = mjcf_scene(&model, &control, &SceneOptions::default());
    let peer = mjcf_scene(&model, &control, &SceneOptions::twist2());
    assert!(own.contains("frictionloss=\"0.1\"") && own.contains("name=\"rail0\""), "{own}");
    assert!(peer.contains("frictionloss=\"0\"") && !peer.contains("frictionloss=\"0.1\""), "{peer}");
    assert!(!peer.contains("rail") && !peer.contains("sole"), "{peer}");
    assert_eq!(peer.matches("size=\"0.005\"").count(), 4, "{peer}");
    assert!(peer.contains("friction=\"1 0.005 0.0001\" solref=\"0.02 1\""), "{peer}");
    assert!(peer.contains("timestep=\"0.001\""), "{peer}");
}

#[test]
fn a_resting_robot_presses_its_weight_on_its_feet() {
    let Some(_) = paid_testing::mujoco("a_resting_robot_presses_its_weight_on_its_feet", Library::get())
    else {
        return;
    };
    for feet in [FootShapes::Referee, FootShapes::Sole] {
        let mut sim = sim(&SceneOptions { feet, ..SceneOptions::default() });
        for _ in 0..100 {
            sim.step(0, &[0.0, 0.0]);
        }
        let state = sim.state(0);
        close(state.contact_force[1].z(), 5.5 * 9.81, 0.5);
        assert_eq!(state.contact_force[0].0, [0.0; 3]);
        close(state.ball.ground_force.z(), 0.43 * 9.81, 0.05);
        assert_eq!((state.ball.robot_force.norm(), state.ball.touched_by), (0.0, -1.0));
        close(state.ball.pos.z(), 0.11, 0.002);
    }
}

#[test]
fn the_ball_knows_which_body_it_hit_and_pushes_back() {
    let Some(_) = paid_testing::mujoco("the_ball_knows_which_body_it_hit_and_pushes_back", Library::get())
    else {
        return;
    };
    let mut sim = sim(&SceneOptions::default());
    // Shot at the trunk from behind, above the foot.
    let shot = LaneState { ball_pos: [-0.5, 0.0, 0.6], ball_vel: [8.0, 0.0, 0.5], ..sim.save_lane(0, 0) };
    sim.reset_lane(0, 0, &shot);
    let before = sim.state(0).bodies[0].lin_vel.x();
    let hit = (0..10).find(|_| {
        sim.step(0, &[0.0, 0.0]);
        sim.state(0).ball.robot_force.norm() > 0.0
    });
    assert!(hit.is_some());
    let state = sim.state(0);
    assert_eq!(state.ball.touched_by, 0.0);
    assert!(state.ball.vel.x() < 5.0 && state.bodies[0].lin_vel.x() > before + 0.05, "{state:?}");
    // In the other environment nothing happened.
    assert_eq!(sim.save_lane(1, 0).ball_pos[0], 1.0);
}

#[test]
fn a_saved_environment_continues_bit_for_bit() {
    let Some(_) = paid_testing::mujoco("a_saved_environment_continues_bit_for_bit", Library::get()) else {
        return;
    };
    let mut sim = sim(&SceneOptions::default());
    let start = LaneState { base_pos: [0.0, 0.0, 0.52], ..moving_state() };
    sim.reset_lane(0, 0, &start);
    for _ in 0..20 {
        sim.step(0, &[0.3, -0.2]);
    }
    let saved = sim.save_lane(0, 0);
    for _ in 0..20 {
        sim.step(0, &[-0.3, 0.2]);
    }
    let end = sim.save_lane(0, 0);
    // Into the other environment, which has another past.
    sim.step(1, &[1.0, 1.0]);
    sim.reset_lane(1, 0, &saved);
    for _ in 0..20 {
        sim.step(1, &[-0.3, 0.2]);
    }
    assert_eq!(sim.save_lane(1, 0), end);
    let forces =
        |group: usize| sim.state(group).contact_force.iter().map(|force| force.0).collect::<Vec<_>>();
    assert_eq!(forces(0), forces(1));
}

#[test]
fn a_saved_state_that_was_changed_is_taken_as_changed() {
    let Some(_) = paid_testing::mujoco("a_saved_state_that_was_changed_is_taken_as_changed", Library::get())
    else {
        return;
    };
    let mut sim = sim(&SceneOptions::default());
    sim.step(0, &[0.1, 0.1]);
    let changed = LaneState { ball_pos: [0.7, 0.6, 0.5], ..sim.save_lane(0, 0) };
    sim.reset_lane(0, 0, &changed);
    sim.refresh(0);
    assert_eq!(sim.state(0).ball.pos.0, [0.7, 0.6, 0.5]);
}

#[test]
fn velocities_are_reported_in_world_axes() {
    let Some(_) = paid_testing::mujoco("velocities_are_reported_in_world_axes", Library::get()) else {
        return;
    };
    let mut sim = sim(&SceneOptions::default());
    let start = moving_state();
    sim.reset_lane(0, 0, &start);
    sim.refresh(0);
    let state = sim.state(0);
    let base = state.bodies[0];
    for k in 0..3 {
        close(base.pos.0[k], start.base_pos[k], 1e-15);
        close(base.lin_vel.0[k], start.base_lin_vel[k], 1e-12);
        close(base.ang_vel.0[k], start.base_ang_vel[k], 1e-12);
        close(state.ball.ang_vel.0[k], start.ball_ang_vel[k], 1e-12);
    }
    // The center of mass moves with the turning frame.
    let com = base.rot.mul_vec(paid_lanes::Vec3([0.0, 0.0, 0.01]));
    let expected = base.ang_vel.cross(com) + base.lin_vel;
    for k in 0..3 {
        close(base.com_vel.0[k], expected.0[k], 1e-12);
    }
    // The arm turns with the base and about its own axis.
    let arm = state.bodies[2];
    let axis = arm.rot.mul_vec(paid_lanes::Vec3([0.0, 0.6, 0.8]));
    let expected = axis.scale_add(2.0, base.ang_vel);
    for k in 0..3 {
        close(arm.ang_vel.0[k], expected.0[k], 1e-12);
    }
}

#[test]
fn torques_stay_within_the_effort_limits_under_both_controllers() {
    let Some(_) =
        paid_testing::mujoco("torques_stay_within_the_effort_limits_under_both_controllers", Library::get())
    else {
        return;
    };
    for pd in [PdControl::Explicit, PdControl::Implicit] {
        let mut sim = sim(&SceneOptions { pd, ..SceneOptions::default() });
        let start = LaneState { base_pos: [0.0, 0.0, 5.0], ..sim.save_lane(0, 0) };
        sim.reset_lane(0, 0, &start);
        sim.step(0, &[50.0, 0.0]);
        let torque = sim.state(0).joint_torque.clone();
        assert_eq!(torque[0], 20.0);
        assert!(torque[1].abs() < 20.0 && torque[1] != 0.0, "{torque:?}");
        sim.set_params(0, 0, &EnvParams { gain_scale: [0.0; 2], ..EnvParams::default() });
        sim.step(0, &[50.0, 0.0]);
        assert_eq!(sim.state(0).joint_torque, [0.0, 0.0]);
    }
}

#[test]
fn parameters_change_masses_ball_and_damping_of_one_environment() {
    let Some(_) =
        paid_testing::mujoco("parameters_change_masses_ball_and_damping_of_one_environment", Library::get())
    else {
        return;
    };
    let ball = BallOptions { damped: true, ..BallOptions::default() };
    let mut sim = sim(&SceneOptions { ball: Some(ball), ..SceneOptions::default() });
    let params = EnvParams {
        mass_scale: vec![2.0, 1.0, 3.0],
        base_com_offset: [0.01, 0.02, 0.03],
        ball: BallParams { mass_kg: 0.2, radius_m: 0.15, linear_damping: 2.0, ..BallParams::default() },
        ..EnvParams::default()
    };
    // Twice, since parameters must not pile up.
    sim.set_params(0, 0, &params);
    sim.set_params(0, 0, &params);
    let world = sim.world(0);
    assert_eq!(world.body_mass()[1..], [6.0, 2.0, 1.5, 0.2]);
    assert_eq!(sim.world(1).body_mass()[1..], [3.0, 2.0, 0.5, 0.43]);
    for k in 0..3 {
        close(world.body_inertia()[3 + k], 2.0 * sim.world(1).body_inertia()[3 + k], 1e-15);
        close(world.body_ipos()[3 + k], [0.01, 0.02, 0.04][k], 1e-15);
    }
    let start = LaneState {
        base_pos: [0.0, 0.0, 9.0],
        ball_pos: [3.0, 0.0, 5.0],
        ball_vel: [4.0, 0.0, 0.0],
        ..sim.save_lane(0, 0)
    };
    sim.reset_lane(0, 0, &start);
    for _ in 0..25 {
        sim.step(0, &[0.0, 0.0]);
    }
    close(sim.state(0).ball.vel.x(), 4.0 * (-2.0_f64 * 0.5).exp(), 0.01);
    // The mass matrix follows: nine kilograms and a half in every direction.
    close(sim.world(0).mass_matrix()[0], 9.5, 1e-12);
}

#[test]
fn a_push_adds_to_the_velocity_of_the_base() {
    let Some(_) = paid_testing::mujoco("a_push_adds_to_the_velocity_of_the_base", Library::get()) else {
        return;
    };
    let mut sim = sim(&SceneOptions::default());
    sim.reset_lane(0, 0, &moving_state());
    sim.push_lane(0, 0, [1.0, 0.0, -1.0], [0.0, 0.5, 0.0]);
    let state = sim.save_lane(0, 0);
    for k in 0..3 {
        close(state.base_lin_vel[k], [1.3, 0.2, -1.1][k], 1e-12);
        close(state.base_ang_vel[k], [1.0, -1.5, 0.5][k], 1e-12);
    }
}

#[test]
fn without_a_ball_the_marker_keeps_its_place() {
    let Some(_) = paid_testing::mujoco("without_a_ball_the_marker_keeps_its_place", Library::get()) else {
        return;
    };
    let mut sim = sim(&SceneOptions { ball: None, ..SceneOptions::default() });
    let start = LaneState { ball_pos: [3.0, 2.0, 0.11], ..sim.save_lane(0, 0) };
    sim.reset_lane(0, 0, &start);
    sim.step(0, &[0.0, 0.0]);
    assert_eq!(sim.state(0).ball.pos.0, [3.0, 2.0, 0.11]);
    assert_eq!(sim.save_lane(0, 0).ball_pos, [3.0, 2.0, 0.11]);
}

#[test]
fn control_numbers_of_another_robot_are_refused() {
    let Some(_) = paid_testing::mujoco("control_numbers_of_another_robot_are_refused", Library::get()) else {
        return;
    };
    let (model, mut control) = robot();
    control.damping.pop();
    let error = MujocoSim::new(&model, &control, &SceneOptions::default(), 1).unwrap_err();
    assert_eq!(error.to_string(), "damping: expected 2 entries, found 1");
}

#[test]
fn a_model_out_of_depth_first_order_is_refused() {
    let Some(_) = paid_testing::mujoco("a_model_out_of_depth_first_order_is_refused", Library::get()) else {
        return;
    };
    let (mut model, control) = robot();
    // The foot on the arm, but before it in the list.
    model.bodies[1].parent = Some(2);
    model.contact_exclusions.clear();
    let error = MujocoSim::new(&model, &control, &SceneOptions::default(), 1).unwrap_err();
    assert!(error.to_string().contains("'foot'"), "{error}");
}
