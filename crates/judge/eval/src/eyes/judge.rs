//! What the eyes believed of a trial, held against the truth afterwards.

use serde::Serialize;

use super::Cause;

/// A detection of the ball, or of something else, compared with the true position at its capture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SightingError {
    /// Distance of the true ball from the torso along the ground `[m]`.
    pub distance_m: f64,
    /// Speed of the ball relative to the torso along the ground `[m/s]`.
    pub speed_m_s: f64,
    /// Age of the image when it was fused `[s]`.
    pub age_s: f64,
    /// Error along the ray, away from the robot, and to the left of it `[m]`.
    pub error_m: [f64; 2],
    /// Share of the ball's outline that the image showed, 0 to 1.
    pub shown: f64,
    /// Whether the tracker accepted it as the ball.
    pub own: bool,
}

/// What the eyes made of a trial.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct EyesOutcome {
    /// Whether the whole ball was in the image while the robot stood and waited.
    pub in_view_at_start: bool,
    /// How far from its place the ball was believed when the motion was chosen `[m]`; `None`: no ball was found.
    pub start_error_m: Option<f64>,
    /// The same 0.2 s before the strike, seen from the torso `[m]`.
    pub strike_error_m: Option<f64>,
    /// Age of the last image of the ball then `[s]`.
    pub strike_age_s: Option<f64>,
    /// The part due to odometry since that image `[m]`.
    pub odometry_error_m: Option<f64>,
    /// The ball's state then: seen, remembered or lost.
    pub strike_state: Option<&'static str>,
    /// Images that were taken since odometry had its first pose.
    pub pictures: usize,
    /// Those that showed a quarter or more of the ball.
    pub with_ball: usize,
    /// Those of them in which it was found within 0.3 m of its place.
    pub found: usize,
    /// Detections more than 0.3 m away from it.
    pub false_finds: usize,
    /// Steps at which odometry did not track.
    pub untracked_steps: usize,
    /// Processor time of the sensors' simulation `[s]`.
    pub sensors_cpu_s: f64,
    /// Processor time of the pipeline `[s]`.
    pub sight_cpu_s: f64,
    /// Processor time of the whole trial `[s]`.
    pub cpu_s: f64,
    /// Why it missed; `None` for a goal.
    pub cause: Option<Cause>,
    /// All detections.
    #[serde(skip)]
    pub sightings: Vec<SightingError>,
}
