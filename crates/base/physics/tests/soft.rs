//! Soft contacts: spring and damper instead of one step.

use crate::common::{biped, engine, lane_at, reset_all, stance};
use paid_lanes::{F32Array, Real};
use paid_physics::{
    BallParams, Combine, Compliance, Cone, ContactCompliance, ContactKind, Engine, EnvParams, LaneState,
    Material, SceneConfig, Simulator, SoleShape,
};

fn scene() -> SceneConfig {
    SceneConfig {
        ground: Material { static_friction: 1.0, dynamic_friction: 1.0, restitution: 1.0 },
        ground_friction_combine: Combine::Multiply,
        ground_restitution_combine: Combine::Multiply,
        substeps: 1,
        ..SceneConfig::default()
    }
}

fn ball(friction: f64, restitution: f64) -> BallParams {
    BallParams {
        material: Material { static_friction: friction, dynamic_friction: friction, restitution },
        linear_damping: 0.0,
        angular_damping: 0.0,
        ..BallParams::default()
    }
}

fn soft(contact: Compliance) -> ContactKind {
    let compliance = ContactCompliance { ball_robot: contact, ball_ground: contact, sole_ground: contact };
    ContactKind { compliance, ..ContactKind::default() }
}

fn with_ball<V: Real>(params: &EnvParams, start: &LaneState) -> Engine<V> {
    let (model, spec) = biped();
    let mut engine = Engine::new(&model, spec, &scene(), 1).unwrap();
    for lane in 0..V::LANES {
        engine.set_params(0, lane, params);
    }
    reset_all(&mut engine, start);
    engine
}

fn far(ball_pos: [f64; 3], ball_vel: [f64; 3], ball_ang_vel: [f64; 3]) -> LaneState {
    let (model, _) = biped();
    LaneState { ball_pos, ball_vel, ball_ang_vel, ..lane_at(model.joints.len(), 50.0) }
}

fn step<V: Real>(engine: &mut Engine<V>) {
    let targets = vec![V::zero(); engine.model().joints.len()];
    engine.step(0, &targets);
}

/// Speed after the bounce over the speed before it.
fn bounce<V: Real>(contact: Compliance, height: f64) -> f64 {
    let params = EnvParams { ball: ball(0.5, 0.0), kind: soft(contact), ..EnvParams::default() };
    let mut engine = with_ball::<V>(&params, &far([0.0, 0.0, 0.11 + height], [0.0; 3], [0.0; 3]));
    let (mut down, mut up) = (0.0_f64, 0.0_f64);
    for _ in 0..160 {
        step(&mut engine);
        let v = engine.state(0).ball.vel.0[2].lane(0);
        down = down.max(-v);
        up = up.max(v);
    }
    up / down
}

#[test]
fn a_dropped_ball_returns_what_the_spring_returns() {
    for e in [0.0, 0.45, 0.6, 0.75] {
        for time in [0.005, 0.02] {
            let contact = Compliance::returning(time, e);
            for height in [0.7, 0.83, 1.0] {
                for found in [bounce::<f64>(contact, height), bounce::<F32Array<8>>(contact, height)] {
                    let want = contact.restitution();
                    assert!(
                        (found - want).abs() < 0.02,
                        "e {e} t {time} h {height}: {found}, expected {want}"
                    );
                }
            }
        }
    }
}

#[test]
fn a_ball_at_rest_stays_where_it_lies_on_any_ground() {
    for contact in [Compliance::HARD, Compliance::returning(0.02, 0.6), Compliance::returning(0.025, 0.0)] {
        let kind = ContactKind {
            ball_spin_friction_m: [0.01, 0.0001],
            cone: Cone { pyramid: true, convex: true },
            ..soft(contact)
        };
        let params = EnvParams { ball: ball(0.8, 0.6), kind, ..EnvParams::default() };
        let mut engine = with_ball::<f64>(&params, &far([0.3, 0.2, 0.11], [0.0; 3], [0.0; 3]));
        for _ in 0..400 {
            step(&mut engine);
        }
        let b = &engine.state(0).ball;
        let off = b.pos.0[0].hypot(b.pos.0[1]) - 0.3_f64.hypot(0.2);
        assert!(off.abs() < 1e-9 && (b.pos.0[2] - 0.11).abs() < 1e-4, "{contact:?}: {:?}", b.pos);
    }
}

#[test]
fn a_sliding_ball_ends_rolling_with_three_fifths_of_its_speed() {
    // A shell: v = v0 / (1 + 2/3), whatever the friction and however soft the ground.
    for contact in [Compliance::HARD, Compliance::returning(0.02, 0.0)] {
        for cone in [Cone::default(), Cone { pyramid: true, convex: false }] {
            let kind = ContactKind { cone, ..soft(contact) };
            let params = EnvParams { ball: ball(0.3, 0.0), kind, ..EnvParams::default() };
            let mut engine = with_ball::<f64>(&params, &far([0.0, 0.0, 0.11], [2.0, 0.0, 0.0], [0.0; 3]));
            for _ in 0..200 {
                step(&mut engine);
            }
            let b = &engine.state(0).ball;
            assert!((b.vel.0[0] - 1.2).abs() < 0.01, "{contact:?}: {:?}", b.vel);
            assert!((b.ang_vel.0[1] * 0.11 - 1.2).abs() < 0.01, "{contact:?}: {:?}", b.ang_vel);
        }
    }
}

#[test]
fn a_sliding_ball_is_slowed_by_all_of_its_friction() {
    for contact in [Compliance::HARD, Compliance::returning(0.005, 0.0), Compliance::returning(0.02, 0.0)] {
        let params = EnvParams { ball: ball(0.1, 0.0), kind: soft(contact), ..EnvParams::default() };
        let mut engine = with_ball::<F32Array<8>>(&params, &far([0.0, 0.0, 0.11], [3.0, 0.0, 0.0], [0.0; 3]));
        for _ in 0..100 {
            step(&mut engine);
        }
        let found = engine.state(0).ball.vel.0[0].lane(0);
        let want = 3.0 - 0.1 * 9.81 * 0.5;
        assert!((found - want).abs() < 0.02, "{contact:?}: {found}, expected {want}");
    }
}

#[test]
fn torsional_friction_brakes_a_spinning_ball_and_rolling_friction_a_rolling_one() {
    let spin = |spin_friction: [f64; 2], vel: [f64; 3], ang: [f64; 3]| {
        let kind = ContactKind { ball_spin_friction_m: spin_friction, ..ContactKind::default() };
        let params = EnvParams { ball: ball(0.8, 0.0), kind, ..EnvParams::default() };
        let mut engine = with_ball::<f64>(&params, &far([0.0, 0.0, 0.11], vel, ang));
        for _ in 0..100 {
            step(&mut engine);
        }
        (engine.state(0).ball.vel.0[0], engine.state(0).ball.ang_vel.0[2])
    };
    // Moment 0.001 m x m g over 2/3 m r^2 for 0.5 s.
    let want = 10.0 - 0.001 * 9.81 / (2.0 / 3.0 * 0.11 * 0.11) * 0.5;
    let found = spin([0.001, 0.0], [0.0; 3], [0.0, 0.0, 10.0]).1;
    assert!((found - want).abs() < 0.01 * want, "{found}, expected {want}");
    // Rolling: (1 + 2/3) m a = -m g rho / r.
    let want = 1.0 - 9.81 * 0.001 / 0.11 / (5.0 / 3.0) * 0.5;
    let found = spin([0.0, 0.001], [1.0, 0.0, 0.0], [0.0, 1.0 / 0.11, 0.0]).0;
    assert!((found - want).abs() < 0.002, "{found}, expected {want}");
    assert_eq!(spin([0.0; 2], [0.0; 3], [0.0, 0.0, 10.0]).1, 10.0);
}

#[test]
fn a_robot_stands_on_every_kind_of_sole() {
    let (model, _) = biped();
    let height = 0.1 + 0.3 * 0.3_f64.cos() + 0.33 * 0.3_f64.cos() + 0.07;
    let sole = SoleShape { length_scale: 0.9, width_scale: 0.8, rounding_m: 0.01 };
    for contact in [Compliance::HARD, Compliance::returning(0.01, 0.0), Compliance::returning(0.025, 0.0)] {
        for pd_implicitness in [0.4, 1.0] {
            let mut e = engine::<f64>(&SceneConfig::default());
            let kind = ContactKind { sole, pd_implicitness, ..soft(contact) };
            e.set_params(0, 0, &EnvParams { kind, ..EnvParams::default() });
            let mut start = lane_at(model.joints.len(), height);
            start.joint_pos = stance(&model);
            reset_all(&mut e, &start);
            for _ in 0..100 {
                e.step(0, &start.joint_pos);
            }
            let base = &e.state(0).bodies[0];
            assert!(base.pos.0[2] > height - 0.02, "{contact:?} {pd_implicitness}: {:?}", base.pos);
            assert!(base.lin_vel.norm() < 0.05, "{contact:?} {pd_implicitness}: {:?}", base.lin_vel);
        }
    }
}

#[test]
fn a_ball_at_the_height_of_the_sole_is_pushed_down_by_a_capsule_and_straight_on_by_a_plate() {
    // In free flight: ankle at 49.27 m, capsule 4 cm and sole 6 cm below it. The capsule's normal points down by 2 of 14 cm.
    let start = far([0.4, 0.1, 49.21], [-2.0, 0.0, 0.0], [0.0; 3]);
    let leaves = |foot_flatness: f64| {
        let kind = ContactKind { foot_flatness, ..ContactKind::default() };
        let params = EnvParams { ball: ball(0.0, 0.0), kind, ..EnvParams::default() };
        let mut e = with_ball::<F32Array<8>>(&params, &start);
        let steps = 30;
        (0..steps).for_each(|_| step(&mut e));
        let v = e.state(0).ball.vel.0.map(|x| x.lane(0));
        [v[0], v[2] + 9.81 * 0.005 * f64::from(steps)]
    };
    let ([x, z], [capsule_x, capsule_z]) = (leaves(1.0), leaves(0.0));
    assert!(x > -1.5 && capsule_x > -1.5, "both meet the foot: {x} {capsule_x}");
    assert!(z.abs() < 0.01, "{z}");
    assert!(capsule_z < -0.1, "{capsule_z}");
}

#[test]
fn a_hard_lane_among_soft_ones_moves_as_if_it_were_alone() {
    let impact = far([0.0, 0.0, 0.3], [3.0, 0.5, -4.0], [2.0, -3.0, 1.0]);
    let hard = EnvParams { ball: ball(0.4, 0.6), ..EnvParams::default() };
    let other = ContactKind {
        ball_spin_friction_m: [0.01, 0.001],
        cone: Cone { pyramid: true, convex: true },
        sole: SoleShape { length_scale: 0.9, ..SoleShape::default() },
        pd_implicitness: 0.5,
        foot_flatness: 0.7,
        ..soft(Compliance::returning(0.02, 0.3))
    };
    let mut alone = with_ball::<F32Array<8>>(&hard, &impact);
    let mut mixed = with_ball::<F32Array<8>>(&hard, &impact);
    for lane in 1..8 {
        mixed.set_params(0, lane, &EnvParams { kind: other, ..hard.clone() });
    }
    for _ in 0..200 {
        step(&mut alone);
        step(&mut mixed);
    }
    let [a, b] = [&alone, &mixed].map(|e| e.save_lane(0, 0));
    assert_eq!(a, b, "bit for bit");
    let soft = mixed.save_lane(0, 1);
    assert!((soft.ball_vel[0] - b.ball_vel[0]).abs() > 1e-3, "the kinds differ");
}
