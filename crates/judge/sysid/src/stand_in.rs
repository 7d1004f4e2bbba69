//! The smallest robot that the engine accepts: a ball's experiments need an engine, and the engine a biped.

use paid_physics::EngineSpec;
use paid_robot::{Body, Geom, Joint, RobotModel, Shape};

fn body(name: &str, parent: Option<usize>, geoms: Vec<Geom>) -> Body {
    Body {
        name: name.to_owned(),
        parent,
        pos: [0.0; 3],
        quat: [1.0, 0.0, 0.0, 0.0],
        mass: 1.0,
        com: [0.0; 3],
        inertia: [0.01, 0.01, 0.01, 0.0, 0.0, 0.0],
        geoms,
    }
}

/// A base with two feet of one sole point each. It never moves: only the balls are stepped.
pub(crate) fn stand_in() -> (RobotModel, EngineSpec) {
    let mut bodies = vec![body("base", None, Vec::new())];
    let mut joints = Vec::new();
    for foot in ["left", "right"] {
        let shape = Shape::Sphere { center: [0.0; 3], radius: 0.01 };
        let sole = Geom { name: format!("{foot}_sole"), class: "sole".to_owned(), shape };
        joints.push(Joint {
            name: format!("{foot}_hip"),
            body: bodies.len(),
            axis: [0.0, 1.0, 0.0],
            range: [-1.0, 1.0],
            armature: 0.01,
            friction_loss: 0.0,
            damping: 0.0,
            effort_limit: 1.0,
        });
        bodies.push(body(&format!("{foot}_foot"), Some(0), vec![sole]));
    }
    let model = RobotModel { name: "stand-in".to_owned(), bodies, joints, contact_exclusions: Vec::new() };
    (model, EngineSpec { feet: vec![1, 2], stiffness: vec![1.0; 2], damping: vec![1.0; 2] })
}
