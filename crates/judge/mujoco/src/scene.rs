//! What the scene is made of: robot, floor, ball, goal. [`crate::mjcf`] writes it.

use paid_physics::BallParams;
use paid_robot::Joint;

use crate::ground::Ground;

/// Name of the ball's body, joint and geom.
pub const BALL: &str = "ball";
/// Name of the floor's geom.
pub const FLOOR: &str = "floor";
/// Name of the body and the heights of rough ground.
pub(crate) const GROUND: &str = "ground";

/// Which shapes the feet meet the world with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FootShapes {
    /// The vendor's capsules (geom class `referee`) meet floor, ball and robot; where a body has them they replace its
    /// other shapes.
    Referee,
    /// As in the built-in engine: `sole` meets the floor alone, `collision` everything.
    Sole,
    /// Four spheres of 5 mm per foot, as in the Unitree G1's older public description. For that robot only: they replace the shapes of bodies
    /// that have the vendor's capsules.
    Spheres,
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
    /// Sliding, torsional `[m]` and rolling `[m]` friction.
    pub friction: [f64; 3],
    /// Time constant `[s]` and damping ratio of a contact.
    pub solref: [f64; 2],
}

/// The ball. Its surface decides every contact that it takes part in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BallOptions {
    /// Mass, radius, inertia, and, if `damped`, damping. `material` is not used: [`BallOptions::like_builtin`] converts it.
    pub params: BallParams,
    /// Sliding, torsional `[m]` and rolling `[m]` friction.
    pub friction: [f64; 3],
    /// Time constant `[s]` and damping ratio of a contact.
    pub solref: [f64; 2],
    /// Impedance at no and at full depth, and the depth `[m]`.
    pub solimp: [f64; 3],
    /// True if the ball's linear and angular damping act in MuJoCo too, as viscous forces.
    pub damped: bool,
}

/// A marker that touches nothing: the goal seen from the front.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GoalMarker {
    /// Middle of the goal line `[m]`.
    pub center: [f64; 2],
    /// Direction of the goal's normal about z, against x `[rad]`.
    pub yaw: f64,
    /// Width `[m]`.
    pub width: f64,
    /// Height `[m]`.
    pub height: f64,
}

/// What surrounds the robot, and how contacts and joints are solved.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneOptions {
    /// Physics step `[s]`.
    pub physics_dt_s: f64,
    /// Physics steps per control step.
    pub substeps: usize,
    /// Gravity along z `[m/s^2]`.
    pub gravity: f64,
    /// Joint control.
    pub pd: PdControl,
    /// Shapes of the feet.
    pub feet: FootShapes,
    /// Whether the robot's bodies push each other apart.
    pub self_collision: bool,
    /// Sliding friction between the robot's own bodies.
    pub self_friction: f64,
    /// Time constant of contacts between the robot's own bodies `[s]`.
    pub self_contact_time_s: f64,
    /// Whether the joints' dry friction acts.
    pub friction_loss: bool,
    /// Friction cone.
    pub cone: Cone,
    /// Floor.
    pub floor: FloorOptions,
    /// The floor's shape.
    pub ground: Ground,
    /// Ball; `None` leaves it out.
    pub ball: Option<BallOptions>,
    /// Goal marker.
    pub goal: Option<GoalMarker>,
    /// A joint whose motor is weak.
    pub weak_joint: Option<WeakJoint>,
}

/// A joint whose motor has less than its torque.
#[derive(Clone, Debug, PartialEq)]
pub struct WeakJoint {
    /// Name of the joint.
    pub name: String,
    /// Share of the effort limit that is left.
    pub share: f64,
}

impl Default for FloorOptions {
    /// The floor of PAiD's public evaluation; torsional and rolling friction are MuJoCo's defaults.
    fn default() -> Self {
        Self { friction: [0.8, 0.005, 0.0001], solref: [0.01, 1.0] }
    }
}

impl Default for BallOptions {
    /// The surface of PAiD's public evaluation, a size-5 ball's mass.
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

impl BallOptions {
    /// A match ball as filmed: 20 impacts on a wall at 9 to 19 m/s had restitutions of 0.80 to 0.89 in 5.8 to 7.0 ms, with indentations of
    /// 18 to 42 mm. The default ball does not bounce (0.13) and stays for 79 ms.
    pub fn real() -> Self {
        Self { solref: Self::REAL_CONTACT, ..Self::default() }
    }

    /// Time constant `[s]` and damping ratio of [`BallOptions::real`].
    pub const REAL_CONTACT: [f64; 2] = [0.0386, 0.0536];
}

impl Default for GoalMarker {
    /// Five meters ahead, two meters wide, in the direction of x.
    fn default() -> Self {
        Self { center: [5.0, 0.0], yaw: 0.0, width: 2.0, height: 1.0 }
    }
}

impl Default for SceneOptions {
    /// As PAiD's public evaluation: 2 ms steps, 50 Hz control, the vendor's feet, a ball of 0.43 kg.
    fn default() -> Self {
        Self {
            physics_dt_s: 0.002,
            substeps: 10,
            gravity: -9.81,
            pd: PdControl::Explicit,
            feet: FootShapes::Referee,
            self_collision: true,
            self_friction: 1.0,
            self_contact_time_s: 0.02,
            friction_loss: true,
            cone: Cone::Pyramidal,
            floor: FloorOptions::default(),
            ground: Ground::Flat,
            ball: Some(BallOptions::default()),
            goal: Some(GoalMarker::default()),
            weak_joint: None,
        }
    }
}

impl SceneOptions {
    /// Largest torque of a joint `[N m]`.
    pub(crate) fn effort(&self, joint: &Joint) -> f64 {
        let weak = self.weak_joint.as_ref().filter(|weak| weak.name == joint.name);
        joint.effort_limit * weak.map_or(1.0, |weak| weak.share)
    }

    /// PAiD's public evaluation with its ball of 0.1 kg, a solid sphere.
    pub fn public_protocol() -> Self {
        let params = BallParams { mass_kg: 0.1, inertia_factor: 0.4, ..BallParams::default() };
        Self { ball: Some(BallOptions { params, ..BallOptions::default() }), ..Self::default() }
    }

    /// The usual scene with [`BallOptions::real`], which leaves a foot within 6 ms: 0.5 ms steps.
    pub fn real_ball() -> Self {
        Self { physics_dt_s: 0.0005, substeps: 40, ball: Some(BallOptions::real()), ..Self::default() }
    }

    /// The scene that the TWIST2 tracker is published with: MuJoCo's default surfaces (friction 1, time constant 20 ms), four
    /// small spheres per foot, joints without dry friction, 1 ms steps.
    pub fn twist2() -> Self {
        Self {
            physics_dt_s: 0.001,
            substeps: 20,
            feet: FootShapes::Spheres,
            friction_loss: false,
            floor: FloorOptions { friction: [1.0, 0.005, 0.0001], solref: [0.02, 1.0] },
            ..Self::default()
        }
    }
}

/// Moment of inertia of the ball `[kg m^2]`.
pub(crate) fn ball_inertia(p: &BallParams) -> f64 {
    p.inertia_factor * p.mass_kg * p.radius_m * p.radius_m
}
