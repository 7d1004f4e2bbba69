//! The interface between the task and any engine.

use paid_lanes::{Mat3, Real, Vec3};
use paid_robot::RobotModel;
use serde::{Deserialize, Serialize};

use crate::EnvParams;

/// Pose and velocity of a body, world axes, one environment per lane.
#[derive(Clone, Copy, Debug)]
pub struct BodyState<V> {
    /// Origin of the body frame `[m]`.
    pub pos: Vec3<V>,
    /// Body frame in the world.
    pub rot: Mat3<V>,
    /// Velocity of the body frame's origin `[m/s]`.
    pub lin_vel: Vec3<V>,
    /// Velocity of the center of mass `[m/s]` (what the motion files call `body_lin_vel_w`).
    pub com_vel: Vec3<V>,
    /// Angular velocity in world axes `[rad/s]`.
    pub ang_vel: Vec3<V>,
}

/// The ball, world axes.
#[derive(Clone, Copy, Debug)]
pub struct BallState<V> {
    /// Center `[m]`.
    pub pos: Vec3<V>,
    /// Velocity of the center `[m/s]`.
    pub vel: Vec3<V>,
    /// Angular velocity `[rad/s]`.
    pub ang_vel: Vec3<V>,
    /// Force of the robot on the ball, world axes, where it was largest in the last control step `[N]`.
    pub robot_force: Vec3<V>,
    /// Force of the ground on the ball, world axes, where it was largest in the last control step `[N]`.
    pub ground_force: Vec3<V>,
    /// Model index of the body that exerted `robot_force`; -1 if none.
    pub touched_by: V,
}

/// What the task sees of `LANES` environments after a control step. Vectors are in model order.
#[derive(Clone, Debug)]
pub struct GroupState<V> {
    /// Joint angles `[rad]`.
    pub joint_pos: Vec<V>,
    /// Joint velocities `[rad/s]`.
    pub joint_vel: Vec<V>,
    /// Actuator torques of the last physics step, within the effort limits `[N m]`.
    pub joint_torque: Vec<V>,
    /// Bodies; index 0 is the base.
    pub bodies: Vec<BodyState<V>>,
    /// Net contact force on each body (ground, ball, other bodies), world axes, where it was largest in the last control step `[N]`.
    pub contact_force: Vec<Vec3<V>>,
    /// The ball.
    pub ball: BallState<V>,
}

impl<V: Real> GroupState<V> {
    /// Everything at rest at the origin, touched by nothing.
    pub fn empty(joints: usize, bodies: usize) -> Self {
        let (z, zero) = (V::zero(), Vec3::zero());
        let body =
            BodyState { pos: zero, rot: Mat3::identity(), lin_vel: zero, com_vel: zero, ang_vel: zero };
        Self {
            joint_pos: vec![z; joints],
            joint_vel: vec![z; joints],
            joint_torque: vec![z; joints],
            bodies: vec![body; bodies],
            contact_force: vec![zero; bodies],
            ball: BallState {
                pos: zero,
                vel: zero,
                ang_vel: zero,
                robot_force: zero,
                ground_force: zero,
                touched_by: V::c(-1.0),
            },
        }
    }
}

/// Full dynamic state of one environment: reset to it, save it, restore it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LaneState {
    /// Base origin in the world `[m]`.
    pub base_pos: [f64; 3],
    /// Base orientation w, x, y, z.
    pub base_quat: [f64; 4],
    /// Velocity of the base origin, world axes `[m/s]`.
    pub base_lin_vel: [f64; 3],
    /// Angular velocity of the base, world axes `[rad/s]`.
    pub base_ang_vel: [f64; 3],
    /// Joint angles, model order `[rad]`.
    pub joint_pos: Vec<f64>,
    /// Joint velocities, model order `[rad/s]`.
    pub joint_vel: Vec<f64>,
    /// Ball center `[m]`.
    pub ball_pos: [f64; 3],
    /// Ball velocity `[m/s]`.
    pub ball_vel: [f64; 3],
    /// Ball angular velocity, world axes `[rad/s]`.
    pub ball_ang_vel: [f64; 3],
    /// Engine-private warm start (contact impulses); empty for a fresh state.
    pub warm_start: Vec<f64>,
}

/// Joint targets of a control step, and those that the motors still have at its start. Model order `[rad]`.
#[derive(Clone, Copy, Debug)]
pub struct LateTargets<'a, V> {
    /// Targets of the control step before.
    pub before: &'a [V],
    /// Targets of this one.
    pub now: &'a [V],
    /// When they arrive, in control steps after the step's start, 0 to 1.
    pub late: V,
}

impl<V: Real> LateTargets<'_, V> {
    /// The mean targets of physics step `i` of `steps`: the old ones, the new ones, or a mixture where they arrive within it.
    #[inline(always)]
    pub fn fill(&self, i: usize, steps: usize, targets: &mut [V]) {
        let old = self.late.mul_add(V::c(steps as f64), V::c(-(i as f64))).max(V::zero()).min(V::one());
        for ((target, &now), &before) in targets.iter_mut().zip(self.now).zip(self.before) {
            *target = (before - now).mul_add(old, now);
        }
    }
}

/// A batch of environments in groups of `V::LANES`.
pub trait Simulator<V: Real>: Send {
    /// The robot.
    fn model(&self) -> &RobotModel;
    /// Number of lane groups.
    fn groups(&self) -> usize;
    /// Duration of a control step `[s]`.
    fn control_dt_s(&self) -> f64;
    /// Advances one group by one control step under PD joint targets `[rad]` (model order).
    fn step(&mut self, group: usize, joint_target: &[V]) {
        self.step_late(group, LateTargets { before: joint_target, now: joint_target, late: V::zero() });
    }
    /// The same with targets that arrive during the step.
    fn step_late(&mut self, group: usize, targets: LateTargets<'_, V>);
    /// The state after the last `step` or `refresh`.
    fn state(&self, group: usize) -> &GroupState<V>;
    /// Puts one environment into a state. Call [`Simulator::refresh`] on the group before reading `state`.
    fn reset_lane(&mut self, group: usize, lane: usize, state: &LaneState);
    /// Recomputes body poses and velocities of a group from joint and base state; contact reports of lanes reset
    /// since the last step are cleared.
    fn refresh(&mut self, group: usize);
    /// The full state of one environment; restoring it continues bit for bit.
    fn save_lane(&self, group: usize, lane: usize) -> LaneState;
    /// Sets the physical parameters of one environment.
    fn set_params(&mut self, group: usize, lane: usize, params: &EnvParams);
    /// Adds to the base's linear `[m/s]` and angular `[rad/s]` velocity, world axes.
    fn push_lane(&mut self, group: usize, lane: usize, lin_vel: [f64; 3], ang_vel: [f64; 3]);
    /// Puts the ball of one environment to another place `[m]`, with these velocities `[m/s]`, `[rad/s]`, world axes; the robot is
    /// unchanged. `state` shows it at once, touched by nothing.
    fn set_ball(&mut self, group: usize, lane: usize, pos: [f64; 3], vel: [f64; 3], ang_vel: [f64; 3]);
    /// Height of the ground at a world point of one environment `[m]`.
    fn ground_height(&self, group: usize, lane: usize, xy: [f64; 2]) -> f64;
    /// Center of a ball of radius `radius` `[m]` that is put on the ground at a world point `[m]`. A ball that is to lie `still` may be put
    /// to where it does so next to that point.
    fn ball_on_ground(&self, group: usize, lane: usize, xy: [f64; 2], radius: f64, _still: bool) -> [f64; 3] {
        [xy[0], xy[1], self.ground_height(group, lane, xy) + radius]
    }
}
