//! What an operator wants to see of the runtime, ten times a second.

use serde::Serialize;

use super::{Controller, Runtime, State};

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
    /// Age of the last state, pose and picture of the ball `[s]`.
    pub ages_s: [f64; 3],
    /// Pelvis from upright `[rad]`.
    pub tilt_rad: f64,
    /// Highest temperatures of winding and casing in degrees Celsius, each with its joint (model order).
    pub hottest: [(i16, usize); 2],
    /// Charge in percent, where it is told.
    pub battery: Option<f64>,
    /// The ball ahead of the torso and to its left `[m]`.
    pub ball_m: Option<[f64; 2]>,
    /// Bearing of the goal from the torso's heading `[rad]`.
    pub goal_rad: Option<f64>,
    /// What the robot calls itself; 5 is a G1 with 29 free joints.
    pub mode_machine: u8,
    /// True if somebody else has commanded the robot.
    pub others_command: bool,
    /// True while the remote is heard.
    pub remote: bool,
}

impl Runtime {
    /// The runtime after its last step, which was at `now_us` `[us]`.
    pub fn status(&self, now_us: u64) -> Status {
        let belief = self.sight.belief(f64::INFINITY);
        let ball = if belief.known { self.sight.ball_ahead(&belief) } else { None };
        let seen_s = if belief.known { belief.age_s } else { f64::INFINITY };
        Status {
            at_us: now_us,
            state: self.state,
            policy: self.controller == Controller::Policy,
            kicks: self.kicks,
            waiting: self.waiting,
            states: self.intake.states,
            ages_s: [self.intake.state_age(now_us), self.sight.odometry_age(now_us), seen_s],
            tilt_rad: self.body.tilt(),
            hottest: self.body.hottest,
            battery: self.intake.battery,
            ball_m: ball.map(|ball| ball.place),
            goal_rad: self.sight.goal_bearing(),
            mode_machine: self.intake.mode_machine,
            others_command: self.intake.others,
            remote: self.intake.remote.present,
        }
    }
}
