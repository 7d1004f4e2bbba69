//! What the eyes are made of.

use paid_lidar::Config;
use paid_perceive::{MemoryPreset, Pose, PositionNoise, TrackerPreset};
use paid_robot::RobotModel;
use paid_vision::Intrinsics;
use paid_vision::detect::Detector;

use crate::SightError;

/// Who finds balls in pictures.
#[derive(Debug)]
pub enum Finder {
    /// A network.
    Network(Box<Detector>),
    /// Nobody here: boxes come with the pictures.
    Boxes,
}

/// Everything that differs from robot to robot.
#[derive(Debug)]
pub struct SightSetup {
    /// The robot: its legs hide balls.
    pub robot: RobotModel,
    /// The body that carries camera and LiDAR.
    pub torso: String,
    /// The camera's pixels.
    pub intrinsics: Intrinsics,
    /// The camera's optical frame in the torso's.
    pub torso_from_camera: Pose,
    /// Radius of the ball `[m]`.
    pub radius_m: f64,
    /// Rate at which a rolling ball slows down `[1/s]`.
    pub decay: f64,
    /// Who finds balls.
    pub finder: Finder,
    /// Uncertainty of a place.
    pub noise: PositionNoise,
    /// The tracker of every ball.
    pub tracker: TrackerPreset,
    /// Which ball is the own one.
    pub memory: MemoryPreset,
    /// The LiDAR's odometry; `None`: poses come from another one.
    pub lidar: Option<Config>,
}

impl SightSetup {
    /// A Unitree G1 with its own camera and LiDAR, and the project's own network.
    ///
    /// # Errors
    /// If the network cannot be run.
    pub fn g1() -> Result<Self, SightError> {
        Ok(Self {
            robot: RobotModel::g1(),
            torso: "torso_link".to_owned(),
            intrinsics: Intrinsics::g1_color(),
            torso_from_camera: Pose::g1_camera(),
            radius_m: 0.11,
            decay: 0.0,
            finder: Finder::Network(Box::new(Detector::own()?)),
            noise: paid_perceive::EyesPreset::default().noise(),
            tracker: TrackerPreset::default(),
            memory: MemoryPreset::default(),
            lidar: Some(Config::g1()),
        })
    }
}
