//! The scene as an MJCF file.

use std::fmt::Write;

use paid_robot::{ControlSpec, RobotModel, Shape};

use crate::ground::Surface;
use crate::scene::{
    BALL, BallOptions, Cone, FLOOR, FootShapes, GROUND, PdControl, SceneOptions, ball_inertia,
};

/// Centers of the spheres of [`FootShapes::Spheres`] in the frame of a foot of the G1 `[m]`.
const SPHERES: [[f64; 3]; 4] =
    [[-0.05, 0.025, -0.03], [-0.05, -0.025, -0.03], [0.12, 0.03, -0.03], [0.12, -0.03, -0.03]];
/// Their radius `[m]`.
const SPHERE_RADIUS: f64 = 0.005;

/// Bits of `contype` and `conaffinity`: two geoms may touch if one's type is in the other's affinity.
mod bits {
    pub const FLOOR: u32 = 1;
    pub const ROBOT: u32 = 2;
    pub const BALL: u32 = 4;
}

/// A number that reads back exactly.
fn num(x: f64) -> String {
    format!("{x}")
}

fn nums(values: &[f64]) -> String {
    values.iter().map(|x| num(*x)).collect::<Vec<_>>().join(" ")
}

fn escape(name: &str) -> String {
    name.replace('&', "&amp;").replace('"', "&quot;").replace('<', "&lt;")
}

/// Writes `model` and its surroundings as MJCF. Bodies, joints and motors keep the model's order; the ball comes after them, then rough ground;
/// the keyframe `home` is the default pose of `control` at the height where the base is in the model's zero pose.
///
/// Motors take torques `[N m]`, position actuators angles `[rad]`; both are limited to the effort limits. Contacts with the ball use the ball's surface, those of
/// the robot with the floor the floor's (geom priorities); the robot's own surface acts only between its bodies.
pub fn mjcf_scene(model: &RobotModel, control: &ControlSpec, options: &SceneOptions) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = write_scene(&mut out, model, control, options);
    out
}

fn write_scene(
    out: &mut String,
    model: &RobotModel,
    control: &ControlSpec,
    options: &SceneOptions,
) -> std::fmt::Result {
    let cone = if options.cone == Cone::Elliptic { "elliptic" } else { "pyramidal" };
    writeln!(out, r#"<mujoco model="{} with ball">"#, escape(&model.name))?;
    writeln!(out, r#"  <compiler angle="radian" autolimits="true" inertiafromgeom="false"/>"#)?;
    let (dt, gravity) = (num(options.physics_dt_s), num(options.gravity));
    let integrator = if options.pd == PdControl::Implicit { "implicitfast" } else { "Euler" };
    writeln!(
        out,
        r#"  <option timestep="{dt}" gravity="0 0 {gravity}" cone="{cone}" integrator="{integrator}">"#
    )?;
    // A diverging state must be seen by the caller, not be replaced in silence.
    writeln!(out, "    <flag autoreset=\"disable\"/>\n  </option>")?;
    writeln!(out, r#"  <visual><headlight ambient="0.4 0.4 0.4"/></visual>"#)?;
    let surface = Surface::new(options.ground);
    let field = surface.mjcf_field(GROUND);
    if let Some((asset, _)) = &field {
        out.push_str(asset);
    }
    writeln!(out, "  <worldbody>")?;
    writeln!(out, r#"    <light pos="0 0 5" dir="0 0 -1" directional="true"/>"#)?;
    let floor = format!(
        r#"rgba="0.4 0.55 0.4 1" contype="{}" conaffinity="0" priority="1" friction="{}" solref="{}""#,
        bits::FLOOR,
        nums(&options.floor.friction),
        nums(&options.floor.solref)
    );
    if field.is_none() {
        let tilt = surface.mjcf_plane();
        writeln!(out, r#"    <geom name="{FLOOR}" type="plane" size="0 0 0.1"{tilt} {floor}/>"#)?;
    }
    if let Some(goal) = &options.goal {
        let (x, y, z) = (num(goal.center[0]), num(goal.center[1]), num(0.5 * goal.height));
        writeln!(
            out,
            r#"    <geom name="goal" type="box" pos="{x} {y} {z}" euler="0 0 {}" size="0.005 {} {z}" rgba="0.9 0.9 0.2 0.3" contype="0" conaffinity="0"/>"#,
            num(goal.yaw),
            num(0.5 * goal.width)
        )?;
    }
    if !model.bodies.is_empty() {
        write_body(out, model, 0, 2, options)?;
    }
    if let Some(ball) = &options.ball {
        write_ball(out, ball)?;
    }
    if let Some((_, low)) = field {
        // A body of its own can be moved. It is behind all others, which are counted.
        writeln!(
            out,
            r#"    <body name="{GROUND}" pos="0 0 {low}"><geom name="{FLOOR}" type="hfield" hfield="{GROUND}" {floor}/></body>"#
        )?;
    }
    writeln!(out, "  </worldbody>")?;
    if !model.contact_exclusions.is_empty() {
        writeln!(out, "  <contact>")?;
        for &(a, b) in &model.contact_exclusions {
            let (a, b) = (escape(&model.bodies[a].name), escape(&model.bodies[b].name));
            writeln!(out, r#"    <exclude body1="{a}" body2="{b}"/>"#)?;
        }
        writeln!(out, "  </contact>")?;
    }
    writeln!(out, "  <actuator>")?;
    for (j, joint) in model.joints.iter().enumerate() {
        let (name, limit) = (escape(&joint.name), num(options.effort(joint)));
        match options.pd {
            PdControl::Explicit => {
                writeln!(out, r#"    <motor name="{name}" joint="{name}" ctrlrange="-{limit} {limit}"/>"#)?;
            }
            PdControl::Implicit => {
                let (kp, kv) = (num(control.stiffness[j]), num(control.damping[j]));
                writeln!(
                    out,
                    r#"    <position name="{name}" joint="{name}" kp="{kp}" kv="{kv}" forcerange="-{limit} {limit}"/>"#
                )?;
            }
        }
    }
    writeln!(out, "  </actuator>")?;
    let base = model.bodies.first().map_or([0.0; 3], |b| b.pos);
    let mut home = [base.as_slice(), &[1.0, 0.0, 0.0, 0.0], &control.default_pos].concat();
    if let Some(ball) = &options.ball {
        home.extend([1.0, 0.0, ball.params.radius_m, 1.0, 0.0, 0.0, 0.0]);
    }
    writeln!(out, r#"  <keyframe><key name="home" qpos="{}"/></keyframe>"#, nums(&home))?;
    writeln!(out, "</mujoco>")
}

/// What a shape of the robot may touch, and its surface.
fn touch(class: &str, options: &SceneOptions) -> String {
    let (contype, conaffinity) = match (class, options.self_collision) {
        ("sole", _) => (0, bits::FLOOR),
        (_, true) => (bits::ROBOT, bits::FLOOR | bits::ROBOT | bits::BALL),
        (_, false) => (bits::ROBOT, bits::FLOOR | bits::BALL),
    };
    let (friction, time) = (num(options.self_friction), num(options.self_contact_time_s));
    format!(
        r#"contype="{contype}" conaffinity="{conaffinity}" friction="{friction} 0.005 0.0001" solref="{time} 1""#
    )
}

fn write_body(
    out: &mut String,
    model: &RobotModel,
    index: usize,
    depth: usize,
    options: &SceneOptions,
) -> std::fmt::Result {
    let (body, pad) = (&model.bodies[index], "  ".repeat(depth));
    let name = escape(&body.name);
    writeln!(out, r#"{pad}<body name="{name}" pos="{}" quat="{}">"#, nums(&body.pos), nums(&body.quat))?;
    if body.parent.is_none() {
        writeln!(out, r#"{pad}  <freejoint name="{name}_free"/>"#)?;
    }
    let (mass, com, inertia) = (num(body.mass), nums(&body.com), nums(&body.inertia));
    writeln!(out, r#"{pad}  <inertial mass="{mass}" pos="{com}" fullinertia="{inertia}"/>"#)?;
    for joint in model.joints.iter().filter(|j| j.body == index) {
        writeln!(
            out,
            r#"{pad}  <joint name="{}" type="hinge" axis="{}" range="{}" armature="{}" frictionloss="{}" damping="{}"/>"#,
            escape(&joint.name),
            nums(&joint.axis),
            nums(&joint.range),
            num(joint.armature),
            num(if options.friction_loss { joint.friction_loss } else { 0.0 }),
            num(joint.damping)
        )?;
    }
    let has_referee = body.geoms.iter().any(|g| g.class == "referee");
    for geom in &body.geoms {
        let used = match options.feet {
            FootShapes::Referee => has_referee == (geom.class == "referee"),
            FootShapes::Sole => geom.class != "referee",
            FootShapes::Spheres => !has_referee,
        };
        if !used {
            continue;
        }
        let touch = touch(&geom.class, options);
        let shape = match geom.shape {
            Shape::Sphere { center, radius } => {
                format!(r#"type="sphere" pos="{}" size="{}""#, nums(&center), num(radius))
            }
            Shape::Capsule { ends, radius } => {
                format!(r#"type="capsule" fromto="{}" size="{}""#, nums(ends.as_flattened()), num(radius))
            }
            Shape::Box { center, half_size, quat } => {
                let (pos, quat, size) = (nums(&center), nums(&quat), nums(&half_size));
                format!(r#"type="box" pos="{pos}" quat="{quat}" size="{size}""#)
            }
        };
        let geom_name = escape(&geom.name);
        writeln!(out, r#"{pad}  <geom name="{geom_name}" {shape} {touch} rgba="0.7 0.7 0.75 1"/>"#)?;
    }
    if has_referee && options.feet == FootShapes::Spheres {
        let touch = touch("referee", options);
        for (i, center) in SPHERES.iter().enumerate() {
            let (pos, size) = (nums(center), num(SPHERE_RADIUS));
            writeln!(
                out,
                r#"{pad}  <geom name="{name}_sphere_{i}" type="sphere" pos="{pos}" size="{size}" {touch} rgba="0.7 0.7 0.75 1"/>"#
            )?;
        }
    }
    for (child, _) in model.bodies.iter().enumerate().filter(|(_, b)| b.parent == Some(index)) {
        write_body(out, model, child, depth + 1, options)?;
    }
    writeln!(out, "{pad}</body>")
}

fn write_ball(out: &mut String, ball: &BallOptions) -> std::fmt::Result {
    let p = &ball.params;
    let inertia = num(ball_inertia(p));
    let radius = num(p.radius_m);
    writeln!(out, r#"    <body name="{BALL}" pos="1 0 {radius}">"#)?;
    writeln!(out, r#"      <freejoint name="{BALL}"/>"#)?;
    writeln!(
        out,
        r#"      <inertial pos="0 0 0" mass="{}" diaginertia="{inertia} {inertia} {inertia}"/>"#,
        num(p.mass_kg)
    )?;
    writeln!(
        out,
        r#"      <geom name="{BALL}" type="sphere" size="{radius}" rgba="0.95 0.95 0.95 1" contype="{}" conaffinity="{}" priority="2" condim="6" friction="{}" solref="{}" solimp="{}"/>"#,
        bits::BALL,
        bits::FLOOR,
        nums(&ball.friction),
        nums(&ball.solref),
        nums(&ball.solimp)
    )?;
    writeln!(out, "    </body>")
}
