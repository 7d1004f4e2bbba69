//! The setup of onboard perception.

use paid_lanes::{Mat3, Vec3};
use paid_lidar::Config;
use paid_robot::RobotModel;
use paid_track::{MemoryPreset, Pose, PositionNoise, TrackerPreset};
use paid_vision::Intrinsics;
use paid_vision::detect::Detector;
use serde::{Deserialize, Serialize};

use crate::SightError;

/// What detects balls in images.
#[derive(Debug)]
pub enum Finder {
    /// A network.
    Network(Box<Detector>),
    /// Nothing here: boxes come with the images.
    Boxes,
}

impl Finder {
    /// With another lowest score of a detection, 0 to 1, where a network detects.
    #[must_use]
    pub fn with_confidence(self, least: f64) -> Self {
        match self {
            Self::Network(detector) => Self::Network(Box::new(detector.with_confidence(least))),
            Self::Boxes => Self::Boxes,
        }
    }
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
    /// What detects balls.
    pub finder: Finder,
    /// Uncertainty of a place.
    pub noise: PositionNoise,
    /// The tracker of every ball.
    pub tracker: TrackerPreset,
    /// Which ball is the one to kick.
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
            noise: paid_track::EyesPreset::default().noise(),
            tracker: TrackerPreset::default(),
            memory: MemoryPreset::default(),
            lidar: Some(Config::g1()),
        })
    }
}

/// A setup as a recording keeps it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SetupRecord {
    pub robot: String,
    pub torso: String,
    pub intrinsics: Intrinsics,
    /// Rows of the rotation.
    pub camera_rot: [[f64; 3]; 3],
    pub camera_pos_m: [f64; 3],
    pub radius_m: f64,
    pub decay: f64,
    /// `own`, `boxes` or `file`.
    pub finder: String,
    /// Lowest score of the network's detections.
    pub confidence: Option<f64>,
    /// Which class a network of the user took for the ball; `None` in recordings of earlier programs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub class: Option<usize>,
    pub noise: [f64; 3],
    pub tracker: TrackerPreset,
    pub memory: MemoryPreset,
    pub lidar: bool,
}

impl SetupRecord {
    pub fn of(setup: &SightSetup) -> Self {
        let (finder, confidence, class) = match &setup.finder {
            Finder::Boxes => ("boxes", None, None),
            Finder::Network(detector) => {
                let own = detector.kind() == paid_vision::detect::Kind::Own;
                let (confidence, class) = (detector.options().confidence, detector.options().class);
                (if own { "own" } else { "file" }, Some(confidence), (!own).then_some(class))
            }
        };
        Self {
            robot: setup.robot.name.clone(),
            torso: setup.torso.clone(),
            intrinsics: setup.intrinsics,
            camera_rot: setup.torso_from_camera.rot.0,
            camera_pos_m: setup.torso_from_camera.pos.0,
            radius_m: setup.radius_m,
            decay: setup.decay,
            finder: finder.to_owned(),
            confidence,
            class,
            noise: [setup.noise.c_min, setup.noise.c_vel, setup.noise.c_dist],
            tracker: setup.tracker.clone(),
            memory: setup.memory.clone(),
            lidar: setup.lidar.is_some(),
        }
    }

    pub fn to_json(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }

    /// The setup again, with a network of the user where one was used.
    pub fn setup(&self, detector: Option<Detector>) -> Result<SightSetup, SightError> {
        let base = SightSetup::g1()?;
        let refuse = |expected: String, found: &str| {
            Err(SightError::Message { what: "setup of the recording", expected, found: found.to_owned() })
        };
        if self.robot != base.robot.name {
            return refuse(format!("the robot {}", base.robot.name), &self.robot);
        }
        let network = match (detector, self.finder.as_str()) {
            (Some(detector), _) => Some(detector),
            (None, "own") => Some(Detector::own()?),
            (None, "boxes") => None,
            (None, other) => return refuse("own or boxes, or --detector with the file".to_owned(), other),
        };
        if let (Some(class), Some(detector)) = (self.class, &network)
            && class != detector.options().class
        {
            let found = format!("class {}", detector.options().class);
            return refuse(format!("the ball as class {class} of the detector (--class {class})"), &found);
        }
        let network = network.map(|detector| match self.confidence {
            Some(least) => detector.with_confidence(least),
            None => detector,
        });
        let [c_min, c_vel, c_dist] = self.noise;
        Ok(SightSetup {
            torso: self.torso.clone(),
            intrinsics: self.intrinsics,
            torso_from_camera: Pose { rot: Mat3(self.camera_rot), pos: Vec3(self.camera_pos_m) },
            radius_m: self.radius_m,
            decay: self.decay,
            finder: network.map_or(Finder::Boxes, |detector| Finder::Network(Box::new(detector))),
            noise: PositionNoise { c_min, c_vel, c_dist },
            tracker: self.tracker.clone(),
            memory: self.memory.clone(),
            lidar: base.lidar.filter(|_| self.lidar),
            ..base
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_replay_takes_the_class_that_was_recorded() {
        let test = "a_replay_takes_the_class_that_was_recorded";
        let Some(path) = paid_testing::shared_data(test, "cases/names_ball_1.onnx") else { return };
        let detector = |class| Detector::load(&path, class).expect("reads");
        let finder = Finder::Network(Box::new(detector(Some(2))));
        let record = SetupRecord::of(&SightSetup { finder, ..SightSetup::g1().expect("the robot") });
        let error = record.setup(Some(detector(None))).expect_err("another class").to_string();
        assert!(
            error.contains("class 2 of the detector (--class 2)") && error.contains("class 1"),
            "{error}"
        );
        record.setup(Some(detector(Some(2)))).expect("the same");
        // Earlier recordings do not say.
        let earlier = SetupRecord { class: None, ..record };
        assert!(!earlier.to_json().contains("class"));
        earlier.setup(Some(detector(None))).expect("whatever is given");
    }
}
