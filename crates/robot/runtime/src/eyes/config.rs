//! Where the images and points of onboard perception come from: a TOML file.

use std::net::{IpAddr, SocketAddr};
use std::path::{Path, PathBuf};

use paid_lanes::{Quat, Vec3};
use paid_track::Pose;
use paid_vision::Intrinsics;
use serde::{Deserialize, Serialize};

use crate::DeployError;
use crate::wire::check_domain;

/// Which clock a device stamps by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum StampClock {
    /// This machine's, or one that is synchronized with it.
    #[default]
    System,
    /// One of its own: the fastest message shows its offset.
    Own,
}

/// Where the camera sits: its optical frame (right, down, ahead) in the torso's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraMount {
    /// Place `[m]`.
    pub position_m: [f64; 3],
    /// Orientation w, x, y, z.
    pub quat: [f64; 4],
}

impl CameraMount {
    /// As perception uses it.
    pub fn pose(&self) -> Pose {
        Pose { rot: Quat(self.quat).normalize().to_mat(), pos: Vec3(self.position_m) }
    }
}

/// The camera: topics of ROS 2.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CameraInput {
    /// `sensor_msgs/Image`, `rgb8` or `bgr8`. Default: the usual driver's, camera name `camera`.
    pub color: String,
    /// `sensor_msgs/Image`, `16UC1` in millimeters, aligned to color (`align_depth.enable` of the driver).
    pub depth: String,
    /// `sensor_msgs/CameraInfo` of the color image.
    pub info: String,
    /// The frame that all three must name; empty: any.
    pub frame: String,
    /// True: asks the driver to send again what was lost, which only works where it offers that. Default false, as sensor data.
    pub reliable: bool,
    /// Whose clock the stamps are of.
    pub clock: StampClock,
    /// With `clock = "own"`: from the exposure to the arrival of the fastest image `[s]`. Default 0.03: one image at 30 Hz.
    pub latency_s: f64,
    /// The camera's pixels, which its `CameraInfo` must repeat within 2%. Default: 424 x 240, 69 x 42 degrees.
    pub intrinsics: Intrinsics,
    /// Where it sits, as `paid perceive calibrate` measures it. Default: the robot's description.
    pub mount: Option<CameraMount>,
}

impl Default for CameraInput {
    fn default() -> Self {
        Self {
            color: "/camera/color/image_raw".to_owned(),
            depth: "/camera/aligned_depth_to_color/image_raw".to_owned(),
            info: "/camera/color/camera_info".to_owned(),
            frame: "camera_color_optical_frame".to_owned(),
            reliable: false,
            clock: StampClock::System,
            latency_s: 0.03,
            intrinsics: Intrinsics::g1_color(),
            mount: None,
        }
    }
}

/// Where the torso's pose comes from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase", tag = "source", deny_unknown_fields)]
pub enum OdometryInput {
    /// A Mid-360 whose packets come to these addresses of this machine.
    Lidar {
        /// Points, such as `192.168.123.99:56301`.
        points: SocketAddr,
        /// Inertial samples, such as `192.168.123.99:56401`.
        imu: SocketAddr,
        /// From the measurement to the arrival of the fastest sample `[s]`. Default 0.005: a sample's own time.
        #[serde(default = "sample")]
        latency_s: f64,
    },
    /// A LiDAR whose driver publishes ROS 2 topics, such as `/livox/lidar` and `/livox/imu`.
    #[serde(rename = "lidar-topics")]
    LidarTopics {
        /// `sensor_msgs/PointCloud2` whose points have a time.
        points_topic: String,
        /// `sensor_msgs/Imu` of the inertial sensor in the LiDAR.
        imu_topic: String,
        /// From the measurement to the arrival of the fastest sample `[s]`. Default 0.005.
        #[serde(default = "sample")]
        latency_s: f64,
    },
    /// Another odometry: a topic `nav_msgs/Odometry`.
    Topic {
        /// Its name, such as `/odometry`.
        topic: String,
        /// The body whose pose it gives, which must be the one that carries the camera.
        #[serde(default = "torso")]
        child: String,
        /// Whose clock the stamps are of.
        #[serde(default)]
        clock: StampClock,
    },
}

fn sample() -> f64 {
    0.005
}

fn torso() -> String {
    "torso_link".to_owned()
}

/// The settings of onboard perception.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EyesConfig {
    /// DDS domain of the ROS 2 topics; without it the robot's.
    pub domain: Option<u16>,
    /// Address of this machine's interface to them; without it the one to the robot.
    pub interface: Option<IpAddr>,
    /// The goal's center ahead of the torso and to its left when odometry has its first pose `[m]`.
    pub goal_m: Option<[f64; 2]>,
    /// True: a virtual robot's order `goal` may set the goal over the network, too. Default false: anyone who reaches the network could.
    #[serde(default)]
    pub goal_from_senses: bool,
    /// A ball detector (ONNX); without it the project's own.
    pub detector: Option<PathBuf>,
    /// Number of the ball's class in its file; without it the class that the file names so.
    pub class: Option<usize>,
    /// Lowest score of a detection, 0 to 1; without it the detector's own.
    pub confidence: Option<f64>,
    /// The camera.
    #[serde(default)]
    pub camera: CameraInput,
    /// The odometry.
    pub odometry: OdometryInput,
}

impl EyesConfig {
    /// Reads a TOML file.
    ///
    /// # Errors
    /// If the file is missing, is no TOML, has an unknown key or a value that makes no sense.
    ///
    /// ```
    /// # let dir = std::env::temp_dir().join(format!("eyes-{}", std::process::id()));
    /// # std::fs::create_dir_all(&dir)?;
    /// # let file = dir.join("eyes.toml");
    /// std::fs::write(&file, "odometry = { source = \"topic\", topic = \"/odometry\" }\ngoal_m = [5.0, 0.0]\n")?;
    /// let eyes = paid_runtime::eyes::EyesConfig::read(&file)?;
    /// assert_eq!(eyes.camera.color, "/camera/color/image_raw");
    /// # std::fs::remove_dir_all(&dir)?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn read(path: &Path) -> Result<Self, DeployError> {
        let fail = |message: String| DeployError::Limits { file: path.to_owned(), message };
        let text = std::fs::read_to_string(path).map_err(|e| fail(e.to_string()))?;
        let config: Self = toml::from_str(&text).map_err(|e| fail(e.to_string().trim_end().to_owned()))?;
        config.check().map_err(fail)?;
        Ok(config)
    }

    /// Checks every value.
    ///
    /// # Errors
    /// A sentence that names the key.
    pub fn check(&self) -> Result<(), String> {
        if let Some(domain) = self.domain {
            check_domain(Some(domain)).map_err(|expected| format!("'domain': {expected}, found {domain}"))?;
        }
        let camera = &self.camera;
        let mut topics = vec![
            ("camera.color", &camera.color),
            ("camera.depth", &camera.depth),
            ("camera.info", &camera.info),
        ];
        match &self.odometry {
            OdometryInput::Topic { topic, .. } => topics.push(("odometry.topic", topic)),
            OdometryInput::LidarTopics { points_topic, imu_topic, .. } => {
                topics.push(("odometry.points_topic", points_topic));
                topics.push(("odometry.imu_topic", imu_topic));
            }
            OdometryInput::Lidar { .. } => {}
        }
        for (key, name) in topics {
            let sound = name.len() > 1 && name.starts_with('/') && !name.contains(char::is_whitespace);
            if !sound {
                return Err(format!(
                    "'{key}': expected a topic such as /camera/color/image_raw, found '{name}'"
                ));
            }
        }
        camera.intrinsics.check().map_err(|error| format!("'camera.intrinsics': {error}"))?;
        if let Some(mount) = camera.mount {
            let norm2: f64 = mount.quat.iter().map(|q| q * q).sum();
            let near = mount.position_m.iter().all(|x| x.abs() < 2.0);
            if !near || !(0.98..1.02).contains(&norm2) {
                return Err(format!(
                    "'camera.mount': expected a place within 2 m and a unit quaternion, found {mount:?}"
                ));
            }
        }
        if !(0.0..=0.5).contains(&camera.latency_s) {
            return Err(format!("'camera.latency_s': expected 0 to 0.5, found {}", camera.latency_s));
        }
        if let OdometryInput::Lidar { latency_s, .. } | OdometryInput::LidarTopics { latency_s, .. } =
            &self.odometry
            && !(0.0..=0.1).contains(latency_s)
        {
            return Err(format!("'odometry.latency_s': expected 0 to 0.1, found {latency_s}"));
        }
        if let Some(goal) = self.goal_m
            && !goal.iter().all(|x| x.abs() <= 50.0)
        {
            return Err(format!("'goal_m': expected [ahead, left] within 50 m, found {goal:?}"));
        }
        if self.class.is_some() && self.detector.is_none() {
            return Err("'class': expected with 'detector', found without it".to_owned());
        }
        if let Some(least) = self.confidence
            && !(0.0..=1.0).contains(&least)
        {
            return Err(format!("'confidence': expected 0 to 1, found {least}"));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<EyesConfig, String> {
        let dir = tempfile::tempdir().expect("dir");
        let path = dir.path().join("eyes.toml");
        std::fs::write(&path, text).expect("write");
        EyesConfig::read(&path).map_err(|error| error.to_string())
    }

    const LIDAR: &str =
        "[odometry]\nsource = \"lidar\"\npoints = \"127.0.0.1:56301\"\nimu = \"127.0.0.1:56401\"\n";

    #[test]
    fn a_file_names_its_odometry_and_keeps_the_usual_topics() {
        let config = read(&format!("domain = 1\n[camera]\ncolor = \"/head/image\"\n{LIDAR}")).expect("eyes");
        assert_eq!((config.domain, config.camera.color.as_str()), (Some(1), "/head/image"));
        assert_eq!(config.camera.info, CameraInput::default().info);
        assert!(matches!(config.odometry, OdometryInput::Lidar { points, .. } if points.port() == 56301));
    }

    #[test]
    fn a_lidar_may_come_by_two_topics() {
        let text = "[odometry]\nsource = \"lidar-topics\"\npoints_topic = \"/livox/lidar\"\nimu_topic = ";
        let config = read(&format!("{text}\"/livox/imu\"\n")).expect("eyes");
        let expected = OdometryInput::LidarTopics {
            points_topic: "/livox/lidar".to_owned(),
            imu_topic: "/livox/imu".to_owned(),
            latency_s: 0.005,
        };
        assert_eq!(config.odometry, expected);
        let error = read(&format!("{text}\"imu\"\n")).expect_err("no topic");
        assert!(error.contains("'odometry.imu_topic': expected a topic"), "{error}");
        let error = read(&format!("{text}\"/imu\"\nlatency_s = 1.0\n")).expect_err("late");
        assert!(error.contains("'odometry.latency_s': expected 0 to 0.1, found 1"), "{error}");
    }

    #[test]
    fn each_wrong_value_is_named_with_what_was_expected() {
        for (text, expected) in [
            ("goal_m = [5.0, 0.0]\n".to_owned(), "odometry"),
            (format!("domain = 233\n{LIDAR}"), "'domain': expected a whole number from 0 to 232, found 233"),
            (format!("colour = 1\n{LIDAR}"), "colour"),
            (format!("[camera]\ndepth = \"depth\"\n{LIDAR}"), "'camera.depth': expected a topic"),
            (format!("[camera]\nlatency_s = 2.0\n{LIDAR}"), "'camera.latency_s': expected 0 to 0.5, found 2"),
            (
                format!("[camera.mount]\nposition_m = [0.0, 0.0, 0.4]\nquat = [2.0, 0.0, 0.0, 0.0]\n{LIDAR}"),
                "'camera.mount': expected a place within 2 m and a unit quaternion",
            ),
            (format!("confidence = 30.0\n{LIDAR}"), "'confidence': expected 0 to 1, found 30"),
            (format!("class = 1\n{LIDAR}"), "'class': expected with 'detector'"),
            (format!("goal_m = [nan, 0.0]\n{LIDAR}"), "'goal_m'"),
        ] {
            let error = read(&text).expect_err(&text);
            assert!(error.contains(expected) && error.contains("eyes.toml"), "{error}");
        }
    }
}
