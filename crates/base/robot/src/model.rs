//! The rigid-body tree as plain numbers (SI units, `f64`).

/// A robot: a floating base and a tree of hinge joints, in model order.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotModel {
    /// Model name from the description file.
    pub name: String,
    /// Bodies, parent before child; body 0 is the floating base.
    pub bodies: Vec<Body>,
    /// Joints; joint `j` moves body `j + 1`.
    pub joints: Vec<Joint>,
    /// Pairs of bodies whose contact is ignored, lower index first, sorted.
    pub contact_exclusions: Vec<(usize, usize)>,
}

/// A rigid body.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Unique name.
    pub name: String,
    /// Index of the parent; `None` for the base.
    pub parent: Option<usize>,
    /// Origin in the parent's frame `[m]`; for the base its height in the description's zero pose.
    pub pos: [f64; 3],
    /// Orientation in the parent's frame at joint angle zero, w, x, y, z.
    pub quat: [f64; 4],
    /// Mass `[kg]`.
    pub mass: f64,
    /// Center of mass in the body frame `[m]`.
    pub com: [f64; 3],
    /// Inertia about the center of mass in body axes [kg m^2]: xx, yy, zz, xy, xz, yz.
    pub inertia: [f64; 6],
    /// Contact shapes in the body frame.
    pub geoms: Vec<Geom>,
}

/// A hinge joint.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// Unique name.
    pub name: String,
    /// The body it moves.
    pub body: usize,
    /// Unit axis in the body frame (through the body origin).
    pub axis: [f64; 3],
    /// Lower and upper limit `[rad]`.
    pub range: [f64; 2],
    /// Rotor inertia reflected to the joint `[kg m^2]`.
    pub armature: f64,
    /// Coulomb friction torque `[N m]`.
    pub friction_loss: f64,
    /// Passive viscous damping `[N m s/rad]`.
    pub damping: f64,
    /// Largest actuator torque `[N m]`.
    pub effort_limit: f64,
}

/// A contact shape of a body.
#[derive(Clone, Debug, PartialEq)]
pub struct Geom {
    /// Unique name.
    pub name: String,
    /// Role in contact: the MJCF `class` of the geom or the `childclass` around it, `main` without either. `sole` touches the
    /// ground, `collision` meets ball, ground (falls) and other bodies, `referee` is used by MuJoCo only (the vendor's
    /// foot capsules).
    pub class: String,
    /// The shape.
    pub shape: Shape,
}

/// A primitive in the body frame `[m]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A ball.
    Sphere {
        /// Center.
        center: [f64; 3],
        /// Radius.
        radius: f64,
    },
    /// All points within `radius` of the segment.
    Capsule {
        /// The segment's ends.
        ends: [[f64; 3]; 2],
        /// Radius.
        radius: f64,
    },
    /// A cuboid.
    Box {
        /// Center.
        center: [f64; 3],
        /// Half extents along its own axes.
        half_size: [f64; 3],
        /// Orientation w, x, y, z.
        quat: [f64; 4],
    },
}

impl RobotModel {
    /// Index of a body by name.
    pub fn body_index(&self, name: &str) -> Option<usize> {
        self.bodies.iter().position(|b| b.name == name)
    }
    /// Index of a joint by name.
    pub fn joint_index(&self, name: &str) -> Option<usize> {
        self.joints.iter().position(|j| j.name == name)
    }
    /// Joint names in model order.
    pub fn joint_names(&self) -> Vec<String> {
        self.joints.iter().map(|j| j.name.clone()).collect()
    }
    /// Body names in model order.
    pub fn body_names(&self) -> Vec<String> {
        self.bodies.iter().map(|b| b.name.clone()).collect()
    }
    /// Total mass `[kg]`.
    pub fn mass(&self) -> f64 {
        self.bodies.iter().map(|b| b.mass).sum()
    }
}
