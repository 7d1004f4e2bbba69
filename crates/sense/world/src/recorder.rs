//! Writes what reaches perception, and its estimates, to an MCAP file.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use mcap::records::MessageHeader;
use mcap::{McapError, WriteOptions, Writer};
use paid_lidar::stamped;
use paid_track::Pose;
use paid_vision::{ColorImage, DepthImage, Intrinsics};

use crate::cdr::CdrWriter;
use crate::schema::{self, Topic};
use crate::setup::SetupRecord;
use crate::{Arrived, Believed, Message, PictureMessage, SightError, SightSetup, ros};

/// The frames of a recording.
const ODOMETRY: &str = "odom";
const TORSO: &str = "torso_link";
const CAMERA: &str = "camera_color_optical_frame";
const LIDAR: &str = "livox_frame";

/// Writes a recording in the MCAP format with ROS 2's messages. Foxglove and Rerun read this format; neither was tried.
pub struct Recorder {
    path: PathBuf,
    out: Writer<BufWriter<File>>,
    channels: Vec<u16>,
    sequence: u32,
    /// Names of the robot's joints, in the order of their angles.
    joints: Vec<String>,
    /// Camera and LiDAR in the torso's frame, by name.
    mounts: Vec<(&'static str, Pose)>,
}

impl std::fmt::Debug for Recorder {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Recorder").field("path", &self.path).field("messages", &self.sequence).finish()
    }
}

impl Recorder {
    /// A recording of eyes with this setup.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn create(path: &Path, setup: &SightSetup) -> Result<Self, SightError> {
        let file = File::create(path).map_err(|source| SightError::File { path: path.to_owned(), source })?;
        let options = WriteOptions::new().compression(None).profile("ros2").library("paid");
        let mut out = options.create(BufWriter::new(file)).map_err(|error| wrong(path, &error))?;
        let mut channels = Vec::new();
        for topic in schema::ALL {
            let id = out
                .add_schema(topic.schema, "ros2msg", topic.definition.as_bytes())
                .and_then(|id| out.add_channel(id, topic.name, "cdr", &BTreeMap::new()));
            channels.push(id.map_err(|error| wrong(path, &error))?);
        }
        let joints = setup.robot.joints.iter().map(|joint| joint.name.clone()).collect();
        let lidar = setup.lidar.as_ref().map(|config| stamped(0.0, &config.body_from_lidar).pose());
        let mut mounts = vec![(CAMERA, setup.torso_from_camera)];
        mounts.extend(lidar.map(|lidar| (LIDAR, lidar)));
        let mut recorder = Self { path: path.to_owned(), out, channels, sequence: 0, joints, mounts };
        let mut data = CdrWriter::new();
        data.string(&SetupRecord::of(setup).to_json());
        recorder.write(&schema::SETUP, [0, 0], data)?;
        Ok(recorder)
    }

    /// Adds a message.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn message(&mut self, arrived: &Arrived) -> Result<(), SightError> {
        let at = arrived.at_ns;
        match &arrived.message {
            Message::Picture(picture) => self.picture(picture, at),
            Message::Imu(imu) => {
                self.write_bytes(&schema::IMU, [at, imu.stamp_ns], &ros::write_imu(imu, LIDAR))
            }
            Message::Scan(scan) => {
                let mut data = CdrWriter::new();
                data.header(scan.start_ns, LIDAR);
                data.u32(1);
                data.length(scan.points.len());
                data.length(4);
                for (k, name) in ["x", "y", "z", "t"].into_iter().enumerate() {
                    data.string(name);
                    data.length(8 * k);
                    // FLOAT64
                    data.u8(8);
                    data.u32(1);
                }
                data.bool(false);
                data.u32(32);
                data.length(32 * scan.points.len());
                let bytes: Vec<u8> = scan.points.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
                data.bytes(&bytes);
                data.bool(true);
                self.write(&schema::LIDAR, [at, scan.end_ns], data)
            }
            Message::Joints(joints) => {
                let mut data = CdrWriter::new();
                data.header(joints.stamp_ns, "");
                data.length(self.joints.len());
                for name in &self.joints {
                    data.string(name);
                }
                data.f64_list(&joints.positions);
                data.length(0);
                data.length(0);
                self.write(&schema::JOINTS, [at, joints.stamp_ns], data)
            }
            Message::Pose(pose) => {
                let data = ros::write_odometry(pose, ODOMETRY, TORSO);
                self.write_bytes(&schema::ODOMETRY, [at, pose.stamp_ns], &data)
            }
            Message::Step { to_strike_s } => {
                let mut data = CdrWriter::new();
                data.f64(*to_strike_s);
                self.write(&schema::STEP, [at, at], data)
            }
        }
    }

    fn picture(&mut self, picture: &PictureMessage, at: u64) -> Result<(), SightError> {
        let stamp = picture.captured_ns;
        let times = [at, stamp];
        self.write(&schema::CAMERA, times, camera(stamp, &picture.intrinsics))?;
        if let Some(depth) = &picture.depth {
            self.write(&schema::DEPTH, times, depth_image(stamp, depth))?;
        }
        if let Some(boxes) = &picture.boxes {
            let mut data = CdrWriter::new();
            data.header(stamp, CAMERA);
            let sides: Vec<f64> = boxes.iter().flat_map(|b| [b.min, b.max]).flatten().collect();
            data.f64_list(&sides);
            self.write(&schema::BOXES, times, data)?;
        }
        // The last part: a reader has the others by then.
        self.write(&schema::COLOR, times, color_image(stamp, &picture.color))
    }

    /// Adds an estimate.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn believed(&mut self, believed: &Believed) -> Result<(), SightError> {
        let times = [believed.at_ns; 2];
        self.write_bytes(&schema::BELIEVED, times, &believed_bytes(believed))?;
        if let Some(torso) = believed.torso {
            let mut data = CdrWriter::new();
            data.length(1 + self.mounts.len());
            transform(&mut data, believed.at_ns, [ODOMETRY, TORSO], &torso);
            for (name, pose) in &self.mounts {
                transform(&mut data, believed.at_ns, [TORSO, name], pose);
            }
            self.write(&schema::TRANSFORMS, times, data)?;
        }
        if let Some(ball) = believed.ball {
            let mut data = CdrWriter::new();
            data.header(believed.at_ns, ODOMETRY);
            let [x, y] = ball.belief.ball.position;
            data.f64s(&[x, y, believed.floor_m.unwrap_or(0.0)]);
            self.write(&schema::BALL, times, data)?;
        }
        Ok(())
    }

    /// Ends the file.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn finish(mut self) -> Result<(), SightError> {
        self.out.finish().map_err(|error| wrong(&self.path, &error))?;
        Ok(())
    }

    fn write(&mut self, topic: &Topic, times: [u64; 2], data: CdrWriter) -> Result<(), SightError> {
        self.write_bytes(topic, times, &data.finish())
    }

    /// `times`: when it came, and when it was made.
    fn write_bytes(&mut self, topic: &Topic, times: [u64; 2], data: &[u8]) -> Result<(), SightError> {
        let index = schema::ALL.iter().position(|other| other.name == topic.name).unwrap_or(0);
        let [log_time, publish_time] = times;
        let header = MessageHeader {
            channel_id: self.channels[index],
            sequence: self.sequence,
            log_time,
            publish_time,
        };
        self.sequence += 1;
        self.out.write_to_known_channel(&header, data).map_err(|error| wrong(&self.path, &error))
    }
}

fn wrong(path: &Path, error: &McapError) -> SightError {
    SightError::Recording {
        path: path.to_owned(),
        place: "the file".to_owned(),
        expected: "room for a recording".to_owned(),
        found: error.to_string(),
    }
}

/// The estimate, as the recording has it: equal estimates give equal bytes, to the last bit of every number.
pub(crate) fn believed_bytes(believed: &Believed) -> Vec<u8> {
    let mut data = CdrWriter::new();
    data.header(believed.at_ns, ODOMETRY);
    let torso = believed.torso.map(|torso| {
        let mut numbers: Vec<f64> = torso.rot.0.into_iter().flatten().collect();
        numbers.extend(torso.pos.0);
        numbers
    });
    data.f64_list(&torso.unwrap_or_default());
    data.f64_list(believed.floor_m.as_slice());
    let ball = believed.ball.map(|known| {
        let b = &known.belief;
        let [x, y] = b.ball.position;
        let [vx, vy] = b.ball.velocity;
        let [pp, pv, vv] = b.ball.covariance;
        vec![x, y, vx, vy, pp, pv, vv, b.rest, b.age_s]
    });
    data.f64_list(&ball.unwrap_or_default());
    data.string(believed.ball.map_or("", |ball| ball.state.name()));
    data.u32(believed.ball.map_or(0, |ball| ball.id));
    data.string(&believed.odometry.to_string());
    data.string(&believed.picture.map_or(String::new(), |fault| fault.to_string()));
    data.finish()
}

pub(crate) fn camera(stamp: u64, camera: &Intrinsics) -> CdrWriter {
    let mut data = CdrWriter::new();
    data.header(stamp, CAMERA);
    data.length(camera.height);
    data.length(camera.width);
    data.string("plumb_bob");
    data.f64_list(&[0.0; 5]);
    let ([fx, fy], [cx, cy]) = (camera.focal, camera.center);
    data.f64s(&[fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0]);
    data.f64s(&[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    data.f64s(&[fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0]);
    for _ in 0..6 {
        data.u32(0);
    }
    data.bool(false);
    data
}

fn image(stamp: u64, [width, height]: [usize; 2], encoding: &str, step: usize, bytes: &[u8]) -> CdrWriter {
    let mut data = CdrWriter::new();
    data.header(stamp, CAMERA);
    data.length(height);
    data.length(width);
    data.string(encoding);
    data.u8(0);
    data.length(step);
    data.bytes(bytes);
    data
}

pub(crate) fn color_image(stamp: u64, color: &ColorImage) -> CdrWriter {
    image(stamp, [color.width, color.height], "rgb8", 3 * color.width, &color.data)
}

pub(crate) fn depth_image(stamp: u64, depth: &DepthImage) -> CdrWriter {
    let bytes: Vec<u8> = depth.data.iter().flat_map(|mm| mm.to_le_bytes()).collect();
    image(stamp, [depth.width, depth.height], "16UC1", 2 * depth.width, &bytes)
}

/// A frame in another one: their names, the parent first, and its pose there.
fn transform(data: &mut CdrWriter, at: u64, [parent, child]: [&str; 2], pose: &Pose) {
    data.header(at, parent);
    data.string(child);
    data.f64s(&pose.pos.0);
    let [w, x, y, z] = quat_of(&pose.rot.0);
    data.f64s(&[x, y, z, w]);
}

/// A unit quaternion w, x, y, z of a rotation.
fn quat_of(rot: &[[f64; 3]; 3]) -> [f64; 4] {
    let matrix = nalgebra::Matrix3::from_fn(|i, k| rot[i][k]);
    let rotation = nalgebra::Rotation3::from_matrix_unchecked(matrix);
    let q = nalgebra::UnitQuaternion::from_rotation_matrix(&rotation);
    [q.w, q.i, q.j, q.k]
}
