//! The scene as MJCF: robot, floor, ball, goal.

use std::fmt::Write;

use paid_physics::BallParams;
use paid_robot::{ControlSpec, RobotModel, Shape};

/// Name of the ball's body, joint and geom.
pub const BALL: &str = "ball";
/// Name of the floor's geom.
pub const FLOOR: &str = "floor";

/// Which shapes the feet meet the world with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FootShapes {
    /// The vendor's capsules (geom class `referee`) meet floor, ball and robot; where a body has them they replace its
    /// other shapes.
    Referee,
    /// As in the built-in engine: `sole` meets the floor alone, `collision` everything.
    Sole,
}

/// How joints follow their targets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PdControl {
    /// Motors; torques are computed and clipped to the effort limits before every physics step (the public evaluation).
    Explicit,
    /// MuJoCo's position actuators with force limits and the integrator `implicitfast`: the damping of the next velocity
    /// acts, as in training.
    Implicit,
}

/// Friction cone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cone {
    /// A pyramid (MuJoCo's default): friction is larger along the diagonals.
    Pyramidal,
    /// The circular cone.
    Elliptic,
}

/// The floor's surface. It decides the contact of the robot with the floor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FloorOptions {
    /// Sliding, torsional [m] and rolling [m] friction.
    pub friction: [f64; 3],
    /// Time constant [s] and damping ratio of a contact.
    pub solref: [f64; 2],
}

/// The ball. Its surface decides every contact that it takes part in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BallOptions {
    /// Mass, radius, inertia, and, if `damped`, damping. MuJoCo has no restitution: `material` is not used.
    pub params: BallParams,
    /// Sliding, torsional [m] and rolling [m] friction.
    pub friction: [f64; 3],
    /// Time constant [s] and damping ratio of a contact.
    pub solref: [f64; 2],
    /// Impedance at no and at full depth, and the depth [m].
    pub solimp: [f64; 3],
    /// True if the ball's linear and angular damping act in MuJoCo too, as viscous forces.
    pub damped: bool,
}

/// A marker that touches nothing: the goal seen from the front.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GoalMarker {
    /// Middle of the goal line [m].
    pub center: [f64; 2],
    /// Direction of the goal's normal about z, against x [rad].
    pub yaw: f64,
    /// Width [m].
    pub width: f64,
    /// Height [m].
    pub height: f64,
}

/// What surrounds the robot and how it is solved.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneOptions {
    /// Physics step [s].
    pub physics_dt_s: f64,
    /// Physics steps a control step.
    pub substeps: usize,
    /// Gravity along z [m/s^2].
    pub gravity: f64,
    /// Joint control.
    pub pd: PdControl,
    /// Shapes of the feet.
    pub feet: FootShapes,
    /// Whether the robot's bodies push each other apart.
    pub self_collision: bool,
    /// Whether the joints' dry friction acts.
    pub friction_loss: bool,
    /// Friction cone.
    pub cone: Cone,
    /// Floor.
    pub floor: FloorOptions,
    /// Ball; `None` leaves it out.
    pub ball: Option<BallOptions>,
    /// Goal marker.
    pub goal: Option<GoalMarker>,
}

impl Default for FloorOptions {
    /// The public evaluation's floor (release facts); torsional and rolling friction are MuJoCo's defaults.
    fn default() -> Self {
        Self { friction: [0.8, 0.005, 0.0001], solref: [0.01, 1.0] }
    }
}

impl Default for BallOptions {
    /// The public evaluation's surface (release facts), a size-5 ball's mass.
    fn default() -> Self {
        Self {
            params: BallParams::default(),
            friction: [0.8, 0.01, 0.0001],
            solref: [0.02, 1.0],
            solimp: [0.9, 0.95, 0.01],
            damped: false,
        }
    }
}

impl Default for GoalMarker {
    /// Five metres ahead, two metres wide, in the direction of x.
    fn default() -> Self {
        Self { center: [5.0, 0.0], yaw: 0.0, width: 2.0, height: 1.0 }
    }
}

impl Default for SceneOptions {
    /// The evaluation of the release facts: 2 ms steps, 50 Hz control, the vendor's feet, a ball of 0.43 kg.
    fn default() -> Self {
        Self {
            physics_dt_s: 0.002,
            substeps: 10,
            gravity: -9.81,
            pd: PdControl::Explicit,
            feet: FootShapes::Referee,
            self_collision: true,
            friction_loss: true,
            cone: Cone::Pyramidal,
            floor: FloorOptions::default(),
            ball: Some(BallOptions::default()),
            goal: Some(GoalMarker::default()),
        }
    }
}

impl SceneOptions {
    /// The public evaluation with its ball of 0.1 kg, a solid sphere (release facts).
    pub fn public_protocol() -> Self {
        let params = BallParams { mass_kg: 0.1, inertia_factor: 0.4, ..BallParams::default() };
        Self { ball: Some(BallOptions { params, ..BallOptions::default() }), ..Self::default() }
    }

    /// The scene that the TWIST2 tracker is published with: MuJoCo's default surfaces (friction 1, time constant 20 ms), four
    /// small spheres a foot, joints without dry friction, 1 ms steps. The spheres are this project's soles.
    pub fn twist2() -> Self {
        Self {
            physics_dt_s: 0.001,
            substeps: 20,
            feet: FootShapes::Sole,
            friction_loss: false,
            floor: FloorOptions { friction: [1.0, 0.005, 0.0001], solref: [0.02, 1.0] },
            ..Self::default()
        }
    }
}

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

/// Writes `model` and its surroundings as MJCF. Bodies, joints and motors keep the model's order; the ball is the last body;
/// the keyframe `home` is the default pose of `control` at the height where the base is in the model's zero pose.
///
/// Motors take torques [N m], position actuators angles [rad]; both are limited to the effort limits. Contacts with the ball use the ball's surface, those of
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
    writeln!(out, "  <worldbody>")?;
    writeln!(out, r#"    <light pos="0 0 5" dir="0 0 -1" directional="true"/>"#)?;
    let floor = &options.floor;
    writeln!(
        out,
        r#"    <geom name="{FLOOR}" type="plane" size="0 0 0.1" rgba="0.4 0.55 0.4 1" contype="{}" conaffinity="0" priority="1" friction="{}" solref="{}"/>"#,
        bits::FLOOR,
        nums(&floor.friction),
        nums(&floor.solref)
    )?;
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
        let (name, limit) = (escape(&joint.name), num(joint.effort_limit));
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
        };
        if !used {
            continue;
        }
        let (contype, conaffinity) = match (geom.class.as_str(), options.self_collision) {
            ("sole", _) => (0, bits::FLOOR),
            (_, true) => (bits::ROBOT, bits::FLOOR | bits::ROBOT | bits::BALL),
            (_, false) => (bits::ROBOT, bits::FLOOR | bits::BALL),
        };
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
        let touch = format!(r#"contype="{contype}" conaffinity="{conaffinity}""#);
        writeln!(out, r#"{pad}  <geom name="{geom_name}" {shape} {touch} rgba="0.7 0.7 0.75 1"/>"#)?;
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

/// Moment of inertia of the ball [kg m^2].
pub(crate) fn ball_inertia(p: &BallParams) -> f64 {
    p.inertia_factor * p.mass_kg * p.radius_m * p.radius_m
}
