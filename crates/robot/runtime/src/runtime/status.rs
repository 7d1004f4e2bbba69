//! What an operator wants to see of the runtime, ten times a second.

use serde::Serialize;

use super::{Controller, Runtime, State};
use crate::motors::G1_MOTORS;

/// A joint at a moment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct JointStatus {
    /// Angle `[rad]`.
    pub pos_rad: f32,
    /// The target of the program that moves it `[rad]`; the last one while none does.
    pub target_rad: f32,
    /// Speed `[rad/s]`.
    pub vel_rad_s: f32,
    /// Estimated torque `[N m]`.
    pub torque_nm: f32,
    /// Temperatures of winding and casing in degrees Celsius.
    pub temperature_c: [i16; 2],
}

/// A moment of the runtime. Ages are infinite (in JSON null) where nothing has come.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Status {
    /// When `[us]`.
    pub at_us: u64,
    /// The state.
    pub state: State,
    /// True while the policy moves the joints.
    pub policy: bool,
    /// Kicks that have begun.
    pub kicks: usize,
    /// What a robot that is ready waits for; empty if for nothing.
    pub waiting: &'static str,
    /// States of the robot so far.
    pub states: u64,
    /// Age of the last state, pose and image of the ball `[s]`.
    pub ages_s: [f64; 3],
    /// Pelvis from upright `[rad]`.
    pub tilt_rad: f64,
    /// Highest temperatures of winding and casing in degrees Celsius, each with its joint (model order).
    pub hottest: [(i16, usize); 2],
    /// Charge in percent, where it is known.
    pub battery: Option<f64>,
    /// The ball ahead of the torso and to its left `[m]`.
    pub ball_m: Option<[f64; 2]>,
    /// Standard deviation of the ball's x and y `[m]`; 0 without a ball.
    pub ball_deviation_m: f64,
    /// Bearing of the goal from the torso's heading `[rad]`.
    pub goal_rad: Option<f64>,
    /// What the robot calls itself; 5 is a G1 with 29 free joints.
    pub mode_machine: u8,
    /// True if another program has commanded the robot.
    pub others_command: bool,
    /// True while the vendor's controller is in command; null where the motion switcher was not asked.
    pub vendor_commands: Option<bool>,
    /// The pelvis by odometry (x, y, z), odometry's frame `[m]`.
    pub odometry_m: Option<[f64; 3]>,
    /// The goal's center by odometry (x, y), odometry's frame `[m]`.
    pub goal_m: Option<[f64; 2]>,
    /// Orientation of the pelvis w, x, y, z: by odometry where that is known, else the inertial sensor's.
    pub base_quat: [f64; 4],
    /// The joints, model order, which is the motors'.
    pub joints: [JointStatus; G1_MOTORS.len()],
    /// True while the remote is received.
    pub remote: bool,
}

impl Runtime {
    /// The runtime after its last step, which was at `now_us` `[us]`.
    pub fn status(&self, now_us: u64) -> Status {
        let belief = self.world.belief(f64::INFINITY);
        let ball = if belief.known { self.world.ball_ahead(&belief) } else { None };
        let seen_s = if belief.known { belief.age_s } else { f64::INFINITY };
        let mut joints = [JointStatus::default(); G1_MOTORS.len()];
        for (j, joint) in joints.iter_mut().enumerate().take(self.player.joints()) {
            *joint = JointStatus {
                pos_rad: self.body.joint_pos[j] as f32,
                target_rad: self.limited[j] as f32,
                vel_rad_s: self.body.joint_vel[j] as f32,
                torque_nm: self.body.torque[j] as f32,
                temperature_c: self.body.temperature[j],
            };
        }
        let base = self.world.base(now_us, &self.body);
        Status {
            at_us: now_us,
            state: self.state,
            policy: self.controller == Controller::Policy,
            kicks: self.kicks,
            waiting: self.waiting,
            states: self.intake.states,
            ages_s: [self.intake.state_age(now_us), self.world.odometry_age(now_us), seen_s],
            tilt_rad: self.body.tilt(),
            hottest: self.body.hottest,
            battery: self.intake.battery,
            ball_m: ball.map(|ball| ball.place),
            ball_deviation_m: if ball.is_some() { belief.ball.covariance[0].max(0.0).sqrt() } else { 0.0 },
            goal_rad: self.world.goal_bearing(),
            mode_machine: self.intake.mode_machine,
            others_command: self.intake.others,
            vendor_commands: self.intake.master.as_ref().map(|name| !name.is_empty()),
            odometry_m: base.as_ref().map(|base| base.pos.0),
            goal_m: self.world.goal,
            base_quat: base.as_ref().map_or(&self.body.base_rot, |base| &base.rot).to_quat().0,
            joints,
            remote: self.intake.remote.present,
        }
    }
}
