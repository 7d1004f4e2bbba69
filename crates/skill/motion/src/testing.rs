//! A robot of three bodies for tests; nothing of any real robot.

use paid_robot::{Body, Geom, Joint, RobotModel, RobotSpec, Shape};

use crate::{Clip, KickLeg};

pub(crate) fn model() -> RobotModel {
    let body = |name: &str, parent, com, shape| Body {
        name: name.to_owned(),
        parent,
        pos: [0.0, 0.0, -0.2],
        quat: [1.0, 0.0, 0.0, 0.0],
        mass: 1.0,
        com,
        inertia: [0.01, 0.01, 0.01, 0.0, 0.0, 0.0],
        geoms: vec![Geom { name: format!("{name}_geom"), class: "collision".to_owned(), shape }],
    };
    let joint = |name: &str, body| Joint {
        name: name.to_owned(),
        body,
        axis: [0.0, 1.0, 0.0],
        range: [-2.0, 2.0],
        armature: 0.01,
        friction_loss: 0.0,
        damping: 0.0,
        effort_limit: 10.0,
    };
    let cuboid = Shape::Box { center: [0.0; 3], half_size: [0.1, 0.2, 0.3], quat: [1.0, 0.0, 0.0, 0.0] };
    RobotModel {
        name: "twig".to_owned(),
        bodies: vec![
            body("trunk", None, [0.0, 0.0, 0.05], cuboid),
            body("left_foot", Some(0), [0.1, 0.0, 0.0], Shape::Sphere { center: [0.0; 3], radius: 0.05 }),
            body(
                "right_foot",
                Some(0),
                [0.1, 0.0, 0.0],
                Shape::Capsule { ends: [[-0.1, 0.0, 0.0], [0.1, 0.0, 0.0]], radius: 0.04 },
            ),
        ],
        joints: vec![joint("left_hip", 1), joint("right_hip", 2)],
        contact_exclusions: vec![],
    }
}

pub(crate) fn spec() -> RobotSpec {
    let names = |list: &[&str]| list.iter().map(|s| (*s).to_owned()).collect::<Vec<_>>();
    RobotSpec {
        name: "twig".to_owned(),
        nominal_height_m: 0.5,
        soft_limit_factor: 0.9,
        // Files list the right side first, unlike the model.
        policy_joint_order: names(&["right_hip", "left_hip"]),
        motion_body_order: names(&["trunk", "right_foot", "left_foot"]),
        anchor_body: "trunk".to_owned(),
        tracked_bodies: names(&["trunk", "left_foot", "right_foot"]),
        feet: ["left_foot".to_owned(), "right_foot".to_owned()],
        shins: ["left_foot".to_owned(), "right_foot".to_owned()],
        end_effectors: names(&["left_foot", "right_foot"]),
        allowed_contacts: names(&["left_foot", "right_foot"]),
        waist_joints: vec![],
        default_pos: vec![],
        action_scale: vec![],
        mode_machines: vec![],
        differences: vec![],
        natural_frequency_hz: 10.0,
        damping_ratio: 2.0,
        stiffness: Vec::new(),
        damping: Vec::new(),
        action_scale_factor: 0.25,
        velocity_limit: vec![],
        file: "twig.toml".to_owned(),
    }
}

/// All bodies move at 1 m/s along x while turning at `turn` rad/s about z; joint `j` turns at `0.5 j` rad/s.
pub(crate) fn steady_clip(frames: usize, fps: f64, turn: f64) -> Clip {
    let mut clip = Clip {
        name: "steady".to_owned(),
        path: "steady.npz".into(),
        fps,
        kick_leg: KickLeg::Right,
        kick_frame: None,
        license: Some("CC0".to_owned()),
        frames,
        joints: 2,
        bodies: 3,
        joint_pos: vec![],
        joint_vel: vec![],
        body_pos: vec![],
        body_quat: vec![],
        body_lin_vel: vec![],
        body_ang_vel: vec![],
    };
    for t in 0..frames {
        let time = t as f64 / fps;
        clip.joint_pos.extend([0.0, 0.5 * time]);
        for i in 0..3 {
            clip.body_pos.push([time, 0.1 * i as f64, 0.5]);
            clip.body_quat.push([(0.5 * turn * time).cos(), 0.0, 0.0, (0.5 * turn * time).sin()]);
        }
    }
    crate::resample::differentiate(&mut clip, &model());
    clip
}
