//! What an observation is computed from: robot, reference and scene, as the caller knows them.
//!
//! The simulated task fills these with the state of the engine, a robot with its sensors' readings. Joint vectors are in the
//! policy's joint order.

use paid_lanes::{Mat3, Real, Vec3};

/// Pose of a body in the world.
#[derive(Clone, Copy, Debug)]
pub struct Pose<V> {
    /// Origin of the body frame `[m]`.
    pub pos: Vec3<V>,
    /// Body frame in the world.
    pub rot: Mat3<V>,
}

impl<V: Real> Pose<V> {
    /// A pose at the origin of the world.
    pub fn identity() -> Self {
        Self { pos: Vec3::zero(), rot: Mat3::identity() }
    }

    /// A point of the world `[m]` in the body frame `[m]`.
    #[inline(always)]
    pub fn point_in_body(&self, point: Vec3<V>) -> Vec3<V> {
        self.rot.tr_mul_vec(point - self.pos)
    }

    /// A point of the body frame `[m]` in the world `[m]`.
    #[inline(always)]
    pub fn point_in_world(&self, point: Vec3<V>) -> Vec3<V> {
        self.rot.mul_vec(point) + self.pos
    }
}

/// What a robot knows of itself from its sensors.
#[derive(Clone, Copy, Debug)]
pub struct RobotView<'a, V> {
    /// Orientation of the base: base frame in the world. Only roll and pitch are used by terms that a robot can observe.
    pub base_rot: Mat3<V>,
    /// Angular velocity of the base in its own frame, as a gyroscope measures it `[rad/s]`.
    pub base_ang_vel: Vec3<V>,
    /// Joint angles relative to their rest angles, `[joints]` `[rad]`.
    pub joint_pos_rel: &'a [V],
    /// Joint velocities, `[joints]` `[rad/s]`.
    pub joint_vel: &'a [V],
    /// The last action, `[joints]`.
    pub last_action: &'a [V],
}

/// What only a simulator knows of the robot: for the critic.
#[derive(Clone, Copy, Debug)]
pub struct PrivilegedView<'a, V> {
    /// Velocity of the base's origin in the base frame `[m/s]`.
    pub base_lin_vel: Vec3<V>,
    /// Pose of the anchor body.
    pub anchor: Pose<V>,
    /// Poses of the tracked bodies, `[bodies]`.
    pub bodies: &'a [Pose<V>],
}

/// The frame of the reference motion that the policy follows.
#[derive(Clone, Copy, Debug)]
pub struct ReferenceView<'a, V> {
    /// Joint angles, `[joints]` `[rad]`.
    pub joint_pos: &'a [V],
    /// Joint velocities, `[joints]` `[rad/s]`.
    pub joint_vel: &'a [V],
    /// Pose of the anchor body.
    pub anchor: Pose<V>,
    /// Angular velocity of the anchor body, world axes `[rad/s]`.
    pub anchor_ang_vel: Vec3<V>,
}

/// Ball and goal as they are known: the truth, or what perception made of it.
#[derive(Clone, Copy, Debug)]
pub struct SceneView<V> {
    /// Center of the ball, base frame `[m]`.
    pub ball: Vec3<V>,
    /// Center of the ball when the reference strikes, base frame of now `[m]`; equal to `ball` without a prediction.
    pub ball_at_strike: Vec3<V>,
    /// Center of the goal, base frame `[m]`.
    pub goal: Vec3<V>,
}

impl<V: Real> SceneView<V> {
    /// A ball without a prediction, and the goal: centers in the base frame `[m]`.
    #[inline(always)]
    pub fn new(ball: Vec3<V>, goal: Vec3<V>) -> Self {
        Self { ball, ball_at_strike: ball, goal }
    }
}

/// Everything that an observation may be computed from.
#[derive(Clone, Copy, Debug)]
pub struct Views<'a, V> {
    /// The readings of the robot's sensors.
    pub robot: RobotView<'a, V>,
    /// What only a simulator knows.
    pub privileged: Option<PrivilegedView<'a, V>>,
    /// The reference motion.
    pub reference: Option<ReferenceView<'a, V>>,
    /// Ball and goal.
    pub scene: Option<SceneView<V>>,
}

impl<'a, V: Real> Views<'a, V> {
    /// Proprioception alone.
    #[inline(always)]
    pub fn of_robot(robot: RobotView<'a, V>) -> Self {
        Self { robot, privileged: None, reference: None, scene: None }
    }

    /// What only a simulator knows.
    ///
    /// # Panics
    /// If the caller has none; [`crate::observation::check`] refuses such a list of terms before.
    #[inline(always)]
    pub fn privileged(&self) -> &PrivilegedView<'a, V> {
        self.privileged.as_ref().expect("a term of the critic needs the simulator's state")
    }

    /// The reference motion.
    ///
    /// # Panics
    /// If the caller has none; [`crate::observation::check`] refuses such a list of terms before.
    #[inline(always)]
    pub fn reference(&self) -> &ReferenceView<'a, V> {
        self.reference.as_ref().expect("an observation term needs a reference motion")
    }

    /// Ball and goal.
    ///
    /// # Panics
    /// If the caller has none; [`crate::observation::check`] refuses such a list of terms before.
    #[inline(always)]
    pub fn scene(&self) -> &SceneView<V> {
        self.scene.as_ref().expect("an observation term needs ball and goal")
    }
}

/// Direction of gravity in a frame with rotation `rot` (frame in the world): a unit vector.
#[inline(always)]
pub fn projected_gravity<V: Real>(rot: &Mat3<V>) -> Vec3<V> {
    Vec3([-rot.0[2][0], -rot.0[2][1], -rot.0[2][2]])
}

#[cfg(test)]
mod tests {
    use super::*;
    use paid_lanes::Quat;

    #[test]
    fn a_point_goes_into_the_body_and_back() {
        let turn = Quat::from_roll_pitch_yaw(0.3, -0.2, 1.1);
        let pose = Pose { pos: Vec3([1.0, 2.0, 0.5]), rot: turn.to_mat() };
        let there = pose.point_in_body(Vec3([0.4, -0.7, 0.2]));
        let back: Vec3<f64> = pose.point_in_world(there);
        for (k, expected) in [0.4, -0.7, 0.2].into_iter().enumerate() {
            assert!((back.0[k] - expected).abs() < 1e-12);
        }
        assert_eq!(pose.point_in_body(pose.pos).0, [0.0; 3]);
    }

    #[test]
    fn a_robot_on_its_back_feels_gravity_behind() {
        // Pitched up by 90 degrees, the x axis points to the sky and gravity along -x.
        let rot = Quat::from_roll_pitch_yaw(0.0, -std::f64::consts::FRAC_PI_2, 0.0).to_mat();
        let [x, y, z]: [f64; 3] = projected_gravity(&rot).0;
        assert!((x + 1.0).abs() < 1e-12 && y.abs() < 1e-12 && z.abs() < 1e-12, "{x} {y} {z}");
    }
}
