//! Where a warning and where a failure begins.

use crate::generate::BALL_RADIUS;

/// Two bounds of a measure: above the first a warning, above the second a failure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// Warn above.
    pub warn: f64,
    /// Fail above.
    pub fail: f64,
}

impl Limit {
    const fn new(warn: f64, fail: f64) -> Self {
        Self { warn, fail }
    }
}

/// Limits of all aspects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CheckLimits {
    /// Shortest clip without a warning `[s]`: less cannot hold an approach and a kick.
    pub shortest_s: f64,
    /// Shortest clip that does not fail `[s]`: retargeting and cleaning refuse shorter ones.
    pub least_s: f64,
    /// Slowest foot at its fastest that is a kick `[m/s]`: recorded and generated kicks reach 4 and more.
    pub least_foot_speed: f64,
    /// Fewest frames a second without a warning: a foot at 8 m/s moves 27 cm between two frames at 30.
    pub least_fps: f64,
    /// Clip length `[s]`: the task's episodes last 10 s.
    pub duration_s: Limit,
    /// Stored bodies against forward kinematics of the stored joints `[m]`.
    pub kinematics_m: Limit,
    /// Stored joint velocities against differences of the angles `[rad/s]`.
    pub joint_rate: Limit,
    /// Stored body velocities against differences of the centers of mass `[m/s]`.
    pub body_rate: Limit,
    /// Joint angle beyond its range `[rad]`.
    pub joint_range: Limit,
    /// Joint speed as a share of its limit.
    pub joint_speed: Limit,
    /// Change of a joint's velocity from one frame to the next, as a share of its speed limit.
    pub joint_jump: Limit,
    /// Speed of the base [m/s]: a robot that is elsewhere in the next frame.
    pub base_speed: Limit,
    /// Depth of the lowest point below the floor `[m]`.
    pub penetration_m: Limit,
    /// Height of the lowest point above the floor `[m]`; a jump or a clip that hovers.
    pub floating_m: Limit,
    /// Distance that a foot slides in one stance `[m]`.
    pub sliding_m: Limit,
    /// Depth of two parts of the robot in each other `[m]`.
    pub overlap_m: Limit,
    /// Share of frames whose center of pressure is more than 2 cm outside of the standing soles.
    pub unbalanced: Limit,
    /// Share of frames that need more friction than a sole gives.
    pub slippery: Limit,
    /// Angle between the start's heading and the foot's direction at the kick `[rad]`.
    pub heading: Limit,
    /// Joint speed in the last frame `[rad/s]`. A task that holds the last pose ends in it; the limits of the end only warn.
    pub end_joint_speed: Limit,
    /// Speed of the base in the last frame `[m/s]`.
    pub end_base_speed: Limit,
    /// Tilt of the base in the last frame `[rad]`.
    pub end_tilt: Limit,
    /// Distance of a stated kick frame from the fastest frame `[s]`.
    pub kick_frame_s: Limit,
    /// Height of the kicking foot's lowest point in the frame of the strike `[m]`: from a ball's top on it meets none on the floor.
    pub strike_height_m: Limit,
}

impl Default for CheckLimits {
    fn default() -> Self {
        Self {
            shortest_s: 1.0,
            least_s: 0.5,
            least_foot_speed: 1.0,
            least_fps: 30.0,
            duration_s: Limit::new(10.0, 120.0),
            kinematics_m: Limit::new(1e-3, 1e-2),
            joint_rate: Limit::new(0.5, 5.0),
            // Files that were made at another rate and smoothed differ by this much in the strike.
            body_rate: Limit::new(0.8, 3.0),
            // Retargeted clips lie on the limit to single precision.
            joint_range: Limit::new(1e-3, 0.05),
            joint_speed: Limit::new(0.9, 1.0),
            joint_jump: Limit::new(0.5, 1.0),
            base_speed: Limit::new(4.0, 8.0),
            // The depth to which a soft contact yields under the robot's weight, and one that throws the robot.
            penetration_m: Limit::new(0.010, 0.030),
            floating_m: Limit::new(0.030, 0.30),
            sliding_m: Limit::new(0.040, 0.25),
            // A hand that brushes a thigh is common in retargeted motions and harmless; one deep inside of it is not.
            overlap_m: Limit::new(0.002, 0.100),
            unbalanced: Limit::new(0.05, 0.80),
            slippery: Limit::new(0.05, 0.50),
            heading: Limit::new(0.8, 1.6),
            // The paper's clips end below 0.1 rad/s.
            end_joint_speed: Limit::new(0.5, f64::INFINITY),
            end_base_speed: Limit::new(0.15, f64::INFINITY),
            end_tilt: Limit::new(0.35, f64::INFINITY),
            kick_frame_s: Limit::new(0.06, 0.30),
            strike_height_m: Limit::new(2.0 * BALL_RADIUS, f64::INFINITY),
        }
    }
}
