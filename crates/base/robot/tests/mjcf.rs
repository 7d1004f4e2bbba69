//! The MJCF reader: what it reads, and its errors.

use paid_robot::{RobotModel, Shape};
use proptest::prelude::*;

/// A trunk and a leg that use every form that the reader knows.
const TWIG: &str = r#"<mujoco model="twig">
  <compiler angle="degree"/>
  <default>
    <joint damping="0.5"/>
    <default class="leg">
      <joint armature="0.01" axis="0 2 0" range="-90 90"/>
      <geom type="capsule" size="0.05"/>
      <motor ctrlrange="-20 20"/>
      <default class="strong"><joint armature="0.02"/></default>
    </default>
  </default>
  <worldbody>
    <geom type="plane" size="1 1 1"/>
    <body name="trunk" pos="0 0 1">
      <freejoint/>
      <inertial mass="2" pos="0 0 0.1" fullinertia="0.03 0.02 0.01 0.001 0.002 0.003"/>
      <geom name="chest" type="box" size="0.1 0.2 0.3" pos="0 0 0.2" euler="0 0 90"/>
      <body name="thigh" childclass="leg" pos="0 0.1 0" axisangle="0 0 3 90">
        <inertial mass="1" pos="0 0 -0.2" diaginertia="0.01 0.02 0.015" euler="0 0 90"/>
        <joint name="hip" class="strong"/>
        <geom name="thigh" fromto="0 0 0 0 0 -0.3"/>
        <body name="shin" pos="0 0 -0.4" quat="2 0 0 0">
          <inertial mass="0.5" pos="0 0 0" diaginertia="0.01 0.01 0.01"/>
          <joint name="knee" damping="0" frictionloss="0.2"/>
          <geom class="leg" size="0.04 0.1" quat="0 1 0 0" pos="0 0 -0.1"/>
          <site name="toe"/>
        </body>
      </body>
    </body>
  </worldbody>
  <contact>
    <exclude body1="shin" body2="trunk"/>
  </contact>
  <actuator>
    <position name="knee" joint="knee" kp="50" forcerange="-30 30" ctrlrange="-1 2"/>
    <motor name="hip" class="leg" joint="hip" gear="2"/>
  </actuator>
</mujoco>
"#;

/// The message about the file after a change, which must be possible only once.
fn fault(from: &str, to: &str) -> String {
    assert_eq!(TWIG.matches(from).count(), 1, "'{from}' occurs once");
    RobotModel::from_mjcf(&TWIG.replace(from, to), "twig.xml").expect_err("the change is a fault").to_string()
}

#[test]
fn the_embedded_robot_is_whole() {
    let model = RobotModel::g1();
    assert_eq!((model.bodies.len(), model.joints.len()), (30, 29));
    assert_eq!(model.name, "g1");
    for (j, joint) in model.joints.iter().enumerate() {
        assert_eq!(joint.body, j + 1);
    }
}

#[test]
fn classes_units_and_forms_are_resolved() {
    let model = RobotModel::from_mjcf(TWIG, "twig.xml").unwrap();
    assert_eq!(model.body_names(), ["trunk", "thigh", "shin"]);
    assert_eq!(model.joint_names(), ["hip", "knee"]);
    let (hip, knee) = (&model.joints[0], &model.joints[1]);
    assert_eq!((hip.armature, knee.armature), (0.02, 0.01));
    assert_eq!((hip.damping, knee.damping), (0.5, 0.0));
    assert_eq!((hip.friction_loss, knee.friction_loss), (0.0, 0.2));
    assert_eq!(hip.axis, [0.0, 1.0, 0.0]);
    assert_eq!(hip.range, [-std::f64::consts::FRAC_PI_2, std::f64::consts::FRAC_PI_2]);
    assert_eq!((hip.effort_limit, knee.effort_limit), (40.0, 30.0));

    let (trunk, thigh, shin) = (&model.bodies[0], &model.bodies[1], &model.bodies[2]);
    let near = |a: &[f64], b: &[f64]| {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12), "{a:?} is not {b:?}");
    };
    let half = std::f64::consts::FRAC_1_SQRT_2;
    assert_eq!(trunk.inertia, [0.03, 0.02, 0.01, 0.001, 0.002, 0.003]);
    near(&thigh.quat, &[half, 0.0, 0.0, half]);
    near(&shin.quat, &[1.0, 0.0, 0.0, 0.0]);
    // A quarter turn about z exchanges xx and yy.
    near(&thigh.inertia, &[0.02, 0.01, 0.015, 0.0, 0.0, 0.0]);

    let Shape::Box { half_size, quat, .. } = trunk.geoms[0].shape else { panic!("a box") };
    assert_eq!((half_size, trunk.geoms[0].class.as_str()), ([0.1, 0.2, 0.3], "main"));
    near(&quat, &[half, 0.0, 0.0, half]);
    assert_eq!(thigh.geoms[0].class, "leg");
    assert_eq!(thigh.geoms[0].shape, Shape::Capsule { ends: [[0.0; 3], [0.0, 0.0, -0.3]], radius: 0.05 });
    let Shape::Capsule { ends, radius } = shin.geoms[0].shape else { panic!("a capsule") };
    assert_eq!(radius, 0.04);
    near(&ends[0], &[0.0, 0.0, 0.0]);
    near(&ends[1], &[0.0, 0.0, -0.2]);
    assert_eq!(shin.geoms[0].name, "shin_geom0");
    assert_eq!(model.contact_exclusions, [(0, 1), (0, 2), (1, 2)]);
}

#[test]
fn unknown_elements_and_attributes_are_named_with_their_line() {
    assert_eq!(
        fault(r#"<geom name="chest" "#, r#"<geo name="chest" "#),
        "twig.xml:17:7: <geo 'chest'>: unknown element here (did you mean 'geom'?)"
    );
    assert_eq!(
        fault(r#"armature="0.01""#, r#"armatur="0.01""#),
        "twig.xml:6:14: <joint>: unknown attribute 'armatur' (did you mean 'armature'?)"
    );
    assert_eq!(
        fault(r#"<position name="knee""#, r#"<muscle name="knee""#),
        "twig.xml:35:5: <muscle 'knee'>: unknown element here"
    );
}

#[test]
fn what_is_not_simulated_says_what_to_do() {
    for (tag, words) in [
        ("tendon", "tendons are not simulated: remove this section"),
        ("equality", "remove this section, and what it constrains"),
        ("include", "included files are not read: put their elements here"),
    ] {
        let error = fault("<contact>", &format!("<{tag}/><contact>"));
        assert!(error.starts_with(&format!("twig.xml:31:3: <{tag}>: ")) && error.ends_with(words), "{error}");
    }
    let error = fault(r#"type="box" size="0.1 0.2 0.3""#, r#"type="cylinder" size="0.1 0.2""#);
    assert!(error.ends_with("(a capsule of the same radius is nearest), found 'cylinder'"), "{error}");
}

#[test]
fn a_mesh_that_touches_nothing_is_skipped_and_another_says_what_to_do() {
    let mesh = |attributes: &str| {
        TWIG.replace(
            r#"type="box" size="0.1 0.2 0.3""#,
            &format!("type=\"mesh\" mesh=\"trunk\" {attributes}"),
        )
    };
    let model =
        RobotModel::from_mjcf(&mesh(r#"contype="0" conaffinity="0""#), "twig.xml").expect("for the eye only");
    assert_eq!(model.bodies[0].geoms, []);
    for attributes in ["", r#"contype="0""#] {
        let error = RobotModel::from_mjcf(&mesh(attributes), "twig.xml").expect_err("it touches").to_string();
        assert!(
            error.contains("<geom 'chest'>: a mesh that touches other shapes: replace it by spheres"),
            "{error}"
        );
    }
    let fitted = fault(r#"type="box" size="0.1 0.2 0.3""#, r#"type="box" mesh="trunk""#);
    assert!(fitted.contains("a shape fitted to a mesh"), "{fitted}");
}

#[test]
fn references_to_nothing_are_named_with_the_nearest_name() {
    assert_eq!(
        fault(r#"joint="knee""#, r#"joint="knie""#),
        "twig.xml:35:27: <position 'knee'>: attribute 'joint': there is no joint 'knie' (did you mean 'knee'?)"
    );
    assert_eq!(
        fault(r#"body1="shin""#, r#"body1="shine""#),
        "twig.xml:32:14: <exclude>: attribute 'body1': there is no body 'shine' (did you mean 'shin'?)"
    );
    assert_eq!(
        fault(r#"class="strong"/"#, r#"class="stron"/"#),
        "twig.xml:20:27: <joint 'hip'>: attribute 'class': there is no default class 'stron' (did you mean 'strong'?)"
    );
}

#[test]
fn names_that_occur_twice_are_errors() {
    let body = fault(r#"<body name="shin""#, r#"<body name="thigh""#);
    assert_eq!(body, "twig.xml:22:9: <body 'thigh'>: the body name 'thigh' occurs twice");
    let joint = fault(r#"<joint name="knee""#, r#"<joint name="hip""#);
    assert_eq!(joint, "twig.xml:24:11: <joint 'hip'>: the joint name 'hip' occurs twice");
    let geom = fault(r#"<geom name="thigh""#, r#"<geom name="chest""#);
    assert_eq!(geom, "twig.xml:21:9: <geom 'chest'>: the geom name 'chest' occurs twice");
    let class = fault(r#"<default class="strong">"#, r#"<default class="leg">"#);
    assert_eq!(class, "twig.xml:9:7: <default 'leg'>: the class name 'leg' occurs twice");
    let actuator = fault(r#"<motor name="hip""#, r#"<motor name="knee""#);
    assert_eq!(actuator, "twig.xml:36:5: <motor 'knee'>: the actuator name 'knee' occurs twice");
}

#[test]
fn numbers_that_cannot_be_used_are_named() {
    let cases = [
        (
            r#"mass="0.5""#,
            r#"mass="NaN""#,
            "twig.xml:23:21: <inertial>: attribute 'mass': expected 1 finite number, found 'NaN'",
        ),
        (
            r#"mass="0.5""#,
            r#"mass="-1""#,
            "twig.xml:23:21: <inertial>: attribute 'mass': expected a positive mass [kg], found '-1'",
        ),
        (r#"mass="0.5" "#, "", "twig.xml:23:11: <inertial>: attribute 'mass' is missing"),
        (
            r#"pos="0 0 1""#,
            r#"pos="0 0 1e999""#,
            "twig.xml:14:24: <body 'trunk'>: attribute 'pos': expected 3 finite numbers, found '0 0 1e999'",
        ),
        (
            r#"pos="0 0 1""#,
            r#"pos="0 1""#,
            "twig.xml:14:24: <body 'trunk'>: attribute 'pos': expected 3 finite numbers, found '0 1'",
        ),
        (
            r#"quat="2 0 0 0""#,
            r#"quat="0 0 0 0""#,
            "twig.xml:22:42: <body 'shin'>: attribute 'quat': expected a quaternion w x y z that is not zero, found '0 0 0 0'",
        ),
        (
            r#"axis="0 2 0""#,
            r#"axis="0 0 0""#,
            "twig.xml:6:30: <joint>: attribute 'axis': expected a direction that is not zero, found '0 0 0'",
        ),
        (
            r#"range="-90 90""#,
            r#"range="90 -90""#,
            "twig.xml:6:43: <joint>: attribute 'range': expected a lower and a larger upper limit, found '90 -90'",
        ),
        (
            r#"size="0.04 0.1""#,
            r#"size="0.04 0""#,
            "twig.xml:25:29: <geom>: attribute 'size': expected positive sizes, found '0.04 0'",
        ),
        (
            r#"diaginertia="0.01 0.01 0.01""#,
            r#"diaginertia="0.01 0.01 0.05""#,
            "twig.xml:23:44: <inertial>: attribute 'diaginertia': expected positive moments, none above the sum of the others [kg m^2], found '0.01 0.01 0.05'",
        ),
        (
            "0.03 0.02 0.01 0.001",
            "0.03 0.02 -0.01 0.001",
            "twig.xml:16:40: <inertial>: attribute 'fullinertia': expected a positive definite matrix xx yy zz xy xz yz [kg m^2], found '0.03 0.02 -0.01 0.001 0.002 0.003'",
        ),
        (
            r#"frictionloss="0.2""#,
            r#"frictionloss="-0.2""#,
            "twig.xml:24:42: <joint 'knee'>: attribute 'frictionloss': expected a number of at least zero, found '-0.2'",
        ),
        (
            r#"forcerange="-30 30""#,
            r#"forcerange="-30 20""#,
            "twig.xml:35:48: <position 'knee'>: attribute 'forcerange': expected limits -x x, found '-30 20'",
        ),
        (
            r#"angle="degree""#,
            r#"angle="grad""#,
            "twig.xml:2:13: <compiler>: attribute 'angle': expected 'radian' or 'degree', found 'grad'",
        ),
        (
            r#"type="box""#,
            r#"type="plane""#,
            "twig.xml:17:26: <geom 'chest'>: attribute 'type': expected 'sphere', 'capsule' or 'box', found 'plane'",
        ),
    ];
    for (from, to, message) in cases {
        assert_eq!(fault(from, to), message);
    }
}

#[test]
fn what_is_missing_is_named() {
    assert_eq!(
        fault(r#"<inertial mass="0.5" pos="0 0 0" diaginertia="0.01 0.01 0.01"/>"#, ""),
        "twig.xml:22:9: <body 'shin'>: an <inertial> with mass, pos and diaginertia (masses are not computed from geoms) is missing"
    );
    assert_eq!(
        fault(r#"<joint name="knee" damping="0" frictionloss="0.2"/>"#, ""),
        "twig.xml:22:9: <body 'shin'>: a <joint> is missing"
    );
    assert_eq!(
        fault("      <freejoint/>\n", ""),
        "twig.xml:14:5: <body 'trunk'>: a single <freejoint> in the root body is missing"
    );
    assert_eq!(
        fault(r#"<motor name="hip" class="leg" joint="hip" gear="2"/>"#, ""),
        "twig.xml:1:1: <mujoco>: joint 'hip' has no actuator"
    );
    assert_eq!(
        fault(r#" forcerange="-30 30""#, ""),
        "twig.xml:35:5: <position 'knee'>: attribute 'forcerange' is missing"
    );
    assert_eq!(
        fault(r#"range="-90 90""#, ""),
        "twig.xml:20:9: <joint 'hip'>: a hinge needs a 'range' that limits it"
    );
}

#[test]
fn a_truncated_file_and_a_foreign_one_are_errors() {
    for cut in [0, 10, TWIG.len() / 2, TWIG.len() - 5] {
        let e = RobotModel::from_mjcf(&TWIG[..cut], "twig.xml").unwrap_err().to_string();
        assert!(e.starts_with("twig.xml:") && e.contains("not valid XML"), "{e}");
    }
    let e = RobotModel::from_mjcf("<robot name='x'/>", "x.urdf").unwrap_err().to_string();
    assert_eq!(e, "x.urdf:1:1: <robot 'x'>: unknown element here (expected <mujoco>)");
    let e = RobotModel::from_mjcf("<mujoco/>", "x.xml").unwrap_err().to_string();
    assert_eq!(e, "x.xml:1:1: <mujoco>: a <worldbody> with a <body> is missing");
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    /// The file with a part cut out is read to finite numbers or refused with a place, but never ends the program.
    #[test]
    fn a_damaged_file_is_read_or_refused(start in 0..TWIG.len(), length in 1..80_usize) {
        let end = (start + length).min(TWIG.len());
        let text = format!("{}{}", &TWIG[..start], &TWIG[end..]);
        match RobotModel::from_mjcf(&text, "twig.xml") {
            Ok(model) => {
                prop_assert!(model.mass().is_finite() && model.mass() > 0.0);
                prop_assert!(model.joints.iter().all(|j| j.effort_limit.is_finite() && j.range[0] < j.range[1]));
            }
            Err(e) => prop_assert!(e.line >= 1 && e.column >= 1 && e.to_string().starts_with("twig.xml:")),
        }
    }
}

#[test]
fn a_vendors_description_says_what_must_go() {
    for (file, said) in [
        ("data/robots/t1/T1_serial.xml", "<body 'Trunk'>: an <inertial> with mass, pos and diaginertia"),
        ("data/robots/g1_23dof/g1_23dof.xml", "a mesh that touches other shapes"),
    ] {
        let Some(path) = paid_testing::shared_data("a_vendors_description_says_what_must_go", file) else {
            return;
        };
        let text = std::fs::read_to_string(&path).expect("a file");
        let error = RobotModel::from_mjcf(&text, file).expect_err("not a robot of ours").to_string();
        assert!(error.contains(said), "{error}");
    }
}
