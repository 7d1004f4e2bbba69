//! The generated scene of the G1 against the table of its numbers (`shared/data/g1/g1_bodies.json`).

use std::fmt::Write as _;

use paid_mujoco::reference::random_state;
use paid_mujoco::{Library, SceneOptions, World, mjcf_scene};
use paid_robot::{RobotModel, RobotSpec};
use serde_json::Value;

/// The table, or `None` (the test is skipped).
fn table(test: &str) -> Option<Vec<Value>> {
    let path = paid_testing::shared_data(test, "data/g1/g1_bodies.json")?;
    Some(serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap())
}

fn numbers(value: &Value) -> String {
    let list = value.as_array().unwrap();
    list.iter().map(ToString::to_string).collect::<Vec<_>>().join(" ")
}

/// Writes a body of the table and its children, without the project's own reader.
fn write_body(out: &mut String, table: &[Value], index: usize) {
    let body = &table[index];
    let name = body["name"].as_str().unwrap();
    let (pos, quat) = (numbers(&body["pos"]), numbers(&body["quat_wxyz"]));
    write!(out, r#"<body name="{name}" pos="{pos}" quat="{quat}">"#).unwrap();
    let (com, quat) = (numbers(&body["com"]), numbers(&body["inertia_quat_wxyz"]));
    let (mass, inertia) = (&body["mass"], numbers(&body["inertia_diag"]));
    write!(out, r#"<inertial pos="{com}" quat="{quat}" mass="{mass}" diaginertia="{inertia}"/>"#).unwrap();
    let joint = &body["joint"];
    if joint["type"] == "free" {
        write!(out, "<freejoint/>").unwrap();
    } else {
        let (name, axis, armature) =
            (joint["name"].as_str().unwrap(), numbers(&joint["axis"]), &joint["armature"]);
        write!(out, r#"<joint name="{name}" axis="{axis}" armature="{armature}"/>"#).unwrap();
    }
    for child in 0..table.len() {
        if table[child]["parent"] == name {
            write_body(out, table, child);
        }
    }
    write!(out, "</body>").unwrap();
}

fn close(what: &str, found: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(found.len(), expected.len(), "{what}");
    let scale = expected.iter().fold(1e-12_f64, |m, x| m.max(x.abs()));
    for (i, (a, b)) in found.iter().zip(expected).enumerate() {
        assert!((a - b).abs() <= tolerance * scale, "{what}, entry {i}: {a}, expected {b}");
    }
}

#[test]
fn masses_inertias_and_mass_matrix_of_the_scene_are_those_of_the_table() {
    let test = "masses_inertias_and_mass_matrix_of_the_scene_are_those_of_the_table";
    let (Some(_), Some(table)) = (paid_testing::mujoco(test, Library::get()), table(test)) else { return };
    let model = RobotModel::g1();
    let control = RobotSpec::g1().resolve(&model).unwrap();
    let options = SceneOptions { ball: None, goal: None, ..SceneOptions::default() };
    let mut scene = World::from_xml(&mjcf_scene(&model, &control, &options)).unwrap();
    let mut text = r#"<mujoco><compiler angle="radian"/><worldbody>"#.to_owned();
    write_body(&mut text, &table, 0);
    text += "</worldbody></mujoco>";
    let mut expected = World::from_xml(&text).unwrap();
    close("masses", scene.body_mass(), expected.body_mass(), 1e-15);
    close("total mass", &[scene.body_mass().iter().sum()], &[33.341], 1e-4);
    close("centers of mass", scene.body_ipos(), expected.body_ipos(), 1e-15);
    for (index, body) in table.iter().enumerate() {
        let b = scene.body(body["name"].as_str().unwrap()).unwrap();
        assert_eq!(b, index + 1);
        let principal = |w: &World| {
            let mut values = w.body_inertia()[3 * b..3 * b + 3].to_vec();
            values.sort_by(f64::total_cmp);
            values
        };
        close("inertias", &principal(&scene), &principal(&expected), 1e-7);
    }
    for index in 0..16 {
        let state = random_state(&model, 3, index).state;
        for world in [&mut scene, &mut expected] {
            world.qpos_mut()[..3].copy_from_slice(&state.base_pos);
            world.qpos_mut()[3..7].copy_from_slice(&state.base_quat);
            world.qpos_mut()[7..].copy_from_slice(&state.joint_pos);
            world.qvel_mut()[6..].copy_from_slice(&state.joint_vel);
            world.forward();
        }
        close("mass matrix", &scene.mass_matrix(), &expected.mass_matrix(), 1e-7);
        close("bias", scene.qfrc_bias(), expected.qfrc_bias(), 1e-6);
    }
}

#[test]
fn limits_and_efforts_of_the_model_are_those_of_the_table() {
    let test = "limits_and_efforts_of_the_model_are_those_of_the_table";
    let Some(table) = table(test) else { return };
    let model = RobotModel::g1();
    for (joint, body) in model.joints.iter().zip(&table[1..]) {
        let row = &body["joint"];
        assert_eq!(row["name"], joint.name.as_str());
        let number = |key: &str| row[key].as_f64().unwrap();
        close(
            &joint.name,
            &joint.range,
            &[row["range"][0].as_f64().unwrap(), row["range"][1].as_f64().unwrap()],
            1e-6,
        );
        let found = [joint.armature, joint.friction_loss, joint.damping, joint.effort_limit];
        let expected = ["armature", "frictionloss", "damping", "effort_limit"].map(number);
        close(&joint.name, &found, &expected, 1e-9);
    }
}
