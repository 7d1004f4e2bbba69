//! What surrounds the robot: ground, ball, and the numbers that all environments share.

use serde::{Deserialize, Serialize};

use crate::{Combine, ContactKind, Material};

/// The ball: a sphere with measured contact behavior.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BallParams {
    /// Mass `[kg]`.
    pub mass_kg: f64,
    /// Radius `[m]`.
    pub radius_m: f64,
    /// Moment of inertia over m r^2: 2/5 solid, 2/3 thin shell.
    pub inertia_factor: f64,
    /// Surface.
    pub material: Material,
    /// Velocity is multiplied by (1 - c dt) each physics step `[1/s]`.
    pub linear_damping: f64,
    /// Angular velocity is multiplied by (1 - c dt) each physics step `[1/s]`.
    pub angular_damping: f64,
}

/// Shape of the ground.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Terrain {
    /// z = 0.
    Plane,
    /// A square grid of uniformly random heights, bilinear between grid points, periodic in x and y.
    Rough {
        /// Heights are uniform within plus and minus this `[m]`.
        amplitude_m: f64,
        /// Heights are rounded to multiples of this `[m]`; zero leaves them.
        step_m: f64,
        /// Grid spacing `[m]`.
        cell_m: f64,
        /// Grid points per side.
        size: usize,
        /// Seed of the heights.
        seed: u64,
    },
}

/// Everything that all environments of a simulation share.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneConfig {
    /// Physics step `[s]`.
    pub physics_dt_s: f64,
    /// Physics steps per control step.
    pub substeps: usize,
    /// Gravity along z `[m/s^2]`, negative.
    pub gravity: f64,
    /// Ground shape.
    pub terrain: Terrain,
    /// Ground surface.
    pub ground: Material,
    /// The ground's rule for friction; the robot's and ball's rule is `average`.
    pub ground_friction_combine: Combine,
    /// The ground's rule for restitution.
    pub ground_restitution_combine: Combine,
    /// Approach speed below which nothing bounces `[m/s]`.
    pub bounce_threshold: f64,
    /// True if the ball exists physically; else it is a marker that the task may still observe.
    pub ball: bool,
    /// True if legs, and hands against thighs, push each other apart.
    pub self_collision: bool,
    /// Sweeps of the contact solver per physics step.
    pub solver_sweeps: usize,
    /// Joint speeds are limited to this `[rad/s]` to keep diverging states finite.
    pub max_joint_speed: f64,
}

/// What differs between environments, one lane of one group.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EnvParams {
    /// Surface of the robot.
    pub robot: Material,
    /// Added to the base's center of mass `[m]`.
    pub base_com_offset: [f64; 3],
    /// Mass and inertia of every body are multiplied by this, model order; empty means 1.
    pub mass_scale: Vec<f64>,
    /// Actuator stiffness and damping are multiplied by these.
    pub gain_scale: [f64; 2],
    /// Each joint's motor relative to the model's, model order; empty means the model's. The built-in engine alone has it, as it has `kind`.
    #[serde(default)]
    pub motor_scale: Vec<MotorScale>,
    /// The ball.
    pub ball: BallParams,
    /// Offset into the terrain grid `[m]`.
    pub terrain_offset: [f64; 2],
    /// Kind of contacts and controllers.
    #[serde(default)]
    pub kind: ContactKind,
}

/// A joint's motor and controller relative to the model's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MotorScale {
    /// Factor of the armature.
    pub armature: f64,
    /// Factor of the controller's stiffness.
    pub stiffness: f64,
    /// Factor of the controller's damping.
    pub damping: f64,
    /// Factor of the largest torque.
    pub effort: f64,
    /// Factor of the dry friction.
    pub friction: f64,
}

impl MotorScale {
    /// The model's motor.
    pub const ONE: Self = Self { armature: 1.0, stiffness: 1.0, damping: 1.0, effort: 1.0, friction: 1.0 };
}

impl Default for SceneConfig {
    /// The release's scene: 5 ms steps, 50 Hz control, plane, unit ground friction.
    fn default() -> Self {
        Self {
            physics_dt_s: 0.005,
            substeps: 4,
            gravity: -9.81,
            terrain: Terrain::Plane,
            ground: Material { static_friction: 1.0, dynamic_friction: 1.0, restitution: 0.0 },
            ground_friction_combine: Combine::Average,
            ground_restitution_combine: Combine::Average,
            bounce_threshold: 0.2,
            ball: true,
            self_collision: true,
            solver_sweeps: 4,
            max_joint_speed: 60.0,
        }
    }
}

impl SceneConfig {
    /// The contact of a surface with the ground: friction and restitution combined by the ground's rules.
    ///
    /// The robot's and the ball's own rule is `average`, the lowest, so the ground's always holds.
    pub fn contact_with_ground(&self, surface: Material) -> Material {
        surface.against(self.ground, self.ground_friction_combine, self.ground_restitution_combine)
    }

    /// The contact of the robot with itself: the average of a surface and itself. It does not bounce.
    pub fn contact_of_robot_and_itself(robot: Material) -> Material {
        Material { restitution: 0.0, ..robot }
    }

    /// The contact of the ball with the robot, both of whose rules are `average`.
    pub fn contact_of_ball_and_robot(ball: Material, robot: Material) -> Material {
        ball.against(robot, Combine::Average, Combine::Average)
    }
}

impl Default for BallParams {
    /// A size-5 ball (FIFA: 0.42 to 0.445 kg, diameter 0.22 m) with the paper's hard-ground parameters.
    fn default() -> Self {
        Self {
            mass_kg: 0.43,
            radius_m: 0.11,
            inertia_factor: 2.0 / 3.0,
            material: Material { static_friction: 0.77, dynamic_friction: 0.07, restitution: 0.75 },
            linear_damping: 0.01,
            angular_damping: 4.28,
        }
    }
}

impl Default for EnvParams {
    fn default() -> Self {
        Self {
            robot: Material { static_friction: 1.0, dynamic_friction: 1.0, restitution: 0.0 },
            base_com_offset: [0.0; 3],
            mass_scale: Vec::new(),
            gain_scale: [1.0; 2],
            motor_scale: Vec::new(),
            ball: BallParams::default(),
            terrain_offset: [0.0; 2],
            kind: ContactKind::default(),
        }
    }
}
