//! Properties of permutations and forward kinematics.

use paid_lanes::{F32Array, Quat, Real, Vec3};
use paid_robot::kinematics::{forward, forward_velocity};
use paid_robot::{BodyAngVel, OrderError, Permutation, RobotModel, RobotSpec, WorldAngVel};
use proptest::prelude::*;

fn near(a: Vec3<f64>, b: Vec3<f64>, tolerance: f64) -> bool {
    (a - b).norm() <= tolerance
}

fn unit_quat() -> impl Strategy<Value = Quat<f64>> {
    prop::array::uniform4(-1.0..1.0_f64)
        .prop_filter("long enough", |q| q.iter().map(|x| x * x).sum::<f64>() > 0.01)
        .prop_map(|q| Quat(q).normalize())
}

fn vector(size: f64) -> impl Strategy<Value = Vec3<f64>> {
    prop::array::uniform3(-size..size).prop_map(Vec3)
}

fn angles() -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(-1.5..1.5_f64, RobotModel::g1().joints.len())
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_permutation_and_its_inverse_change_nothing(order in Just((0..12).collect::<Vec<usize>>()).prop_shuffle()) {
        let from: Vec<String> = (0..12).map(|i| format!("joint {i}")).collect();
        let to: Vec<String> = order.iter().map(|i| from[*i].clone()).collect();
        let p = Permutation::between(&from, &to).unwrap();
        prop_assert_eq!(p.indices(), &order[..]);
        let values: Vec<f64> = (0..12).map(f64::from).collect();
        prop_assert_eq!(p.inverse().apply(&p.apply(&values)), values.clone());
        prop_assert_eq!(p.apply(&p.inverse().apply(&values)), values);
        prop_assert_eq!(p.inverse(), Permutation::between(&to, &from).unwrap());
    }

    #[test]
    fn moving_the_base_moves_every_body(pos in vector(3.0), quat in unit_quat(), shift in vector(2.0), turn in unit_quat(), q in angles()) {
        let model = RobotModel::g1();
        let before = forward(&model, pos, quat, &q);
        let after = forward(&model, shift + turn.rotate(pos), turn.mul(quat), &q);
        for (a, b) in before.iter().zip(&after) {
            prop_assert!(near(shift + turn.rotate(a.pos), b.pos, 1e-12));
            prop_assert!(turn.mul(a.quat).conj().mul(b.quat).to_mat().angle() < 1e-12);
        }
    }

    #[test]
    fn velocities_are_the_derivatives_of_poses(pos in vector(1.0), quat in unit_quat(), lin in vector(2.0), ang in vector(3.0), q in angles(), qd in angles()) {
        let model = RobotModel::g1();
        let at = |t: f64| {
            let turn = Quat::from_axis_angle(ang.scale(1.0 / ang.norm().max(1e-9)), ang.norm() * t);
            let q: Vec<f64> = q.iter().zip(&qd).map(|(q, v)| q + v * t).collect();
            forward(&model, pos + lin.scale(t), turn.mul(quat), &q)
        };
        let h = 1e-5;
        let (before, now, after) = (at(-h), at(0.0), at(h));
        for (b, v) in forward_velocity(&model, &now, lin, WorldAngVel(ang), &qd).iter().enumerate() {
            let com = Vec3::c(model.bodies[b].com);
            prop_assert!(near((after[b].pos - before[b].pos).scale(0.5 / h), v.origin, 1e-6));
            prop_assert!(near((after[b].point(com) - before[b].point(com)).scale(0.5 / h), v.com, 1e-6));
            let turn = after[b].quat.mul(before[b].quat.conj());
            let turn = if turn.0[0] < 0.0 { Quat(turn.0.map(|x| -x)) } else { turn };
            let rate = Vec3([turn.0[1], turn.0[2], turn.0[3]]).scale(1.0 / h);
            prop_assert!(near(rate, v.ang.0, 1e-6), "{:?} {:?}", rate, v.ang.0);
        }
    }

    #[test]
    fn changing_the_frame_and_back_keeps_an_angular_velocity(w in vector(5.0), quat in unit_quat()) {
        let rot = quat.to_mat();
        let BodyAngVel(body) = WorldAngVel(w).in_body(&rot);
        prop_assert!((body.norm() - w.norm()).abs() < 1e-12);
        prop_assert!(near(BodyAngVel(body).in_world(&rot).0, w, 1e-12));
        prop_assert!(near(quat.rotate(body), w, 1e-12));
    }
}

#[test]
fn lanes_of_f32_agree_with_f64() {
    type V = F32Array<8>;
    let model = RobotModel::g1();
    let control = RobotSpec::g1().resolve(&model).unwrap();
    let exact = forward(&model, Vec3([0.0, 0.0, 0.76]), Quat::identity(), &control.default_pos);
    let joint_pos: Vec<V> = control.default_pos.iter().map(|q| V::c(*q)).collect();
    let lanes = forward(&model, Vec3::c([0.0, 0.0, 0.76]), Quat::identity(), &joint_pos);
    for (a, b) in exact.iter().zip(&lanes) {
        for lane in 0..V::LANES {
            assert!(near(a.pos, Vec3(b.pos.lane(lane)), 1e-5));
        }
    }
}

#[test]
fn the_soles_of_the_default_pose_are_flat_and_near_the_ground() {
    let model = RobotModel::g1();
    let spec = RobotSpec::g1();
    let control = spec.resolve(&model).unwrap();
    let base = Vec3([0.0, 0.0, spec.nominal_height_m]);
    let poses = forward(&model, base, Quat::identity(), &control.default_pos);
    for foot in spec.indices(&model).unwrap().feet {
        let up = poses[foot].rot().col(2);
        assert!(up.z() > 0.999, "{up:?}");
        // The sole is 35 mm below the ankle.
        let height = poses[foot].point(Vec3([0.039, 0.0, -0.035])).z();
        assert!(height.abs() < 0.03, "{height} m");
    }
}

#[test]
fn orders_that_do_not_match_are_errors() {
    let missing = Permutation::between(&["a", "b"], &["a", "c"]).unwrap_err();
    assert_eq!(missing, OrderError::Missing { name: "c".into(), found: "a, b".into() });
    assert_eq!(
        Permutation::between(&["a", "a"], &["a", "b"]).unwrap_err(),
        OrderError::Duplicate("a".into())
    );
    assert_eq!(Permutation::between(&["a", "b"], &["a"]).unwrap_err(), OrderError::Unknown("b".into()));
    assert_eq!(Permutation::between(&["a"], &["a", "a"]).unwrap_err(), OrderError::Duplicate("a".into()));
}
