//! Onboard perception in lockstep: a rendered camera, a simulated Mid-360, and the perception of a robot on the network without its
//! threads. Nothing of their ball or torso is taken from the simulation.

use std::collections::VecDeque;
use std::path::PathBuf;

use paid_lidar::sim::SceneKind;
use paid_lidar::{Config, Scan};
use paid_runtime::eyes::{BallEyes, TorsoEyes, TorsoFix};
use paid_runtime::{Packet, Phase, Player, quaternion};
use paid_track::Pose;
use paid_vision::Intrinsics;
use paid_world::{PictureMessage, PoseMessage, Recorder, SightSetup};

use crate::TwinError;
use crate::camera::{Moment, SimCamera};
use crate::lidar::SimLidar;
use crate::robot::VirtualG1;
use crate::senses::DriftingOdometry;

/// A scan takes this long to arrive `[us]`: a packet's way and the odometry's work.
const SCAN_US: u64 = 20_000;
/// Period at which joint angles reach perception, and perception reports `[us]`.
const JOINTS_US: u64 = 10_000;
/// See `JOINTS_US`.
const REPORT_US: u64 = 20_000;

/// What follows the torso.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TorsoSource {
    /// LiDAR-inertial odometry on a simulated Mid-360 in these surroundings; the robot begins there `[m]`.
    Lidar(SceneKind, [f64; 2]),
    /// The true pose with the drift and the jitter that the policy's preset has for training: where a LiDAR would be too slow.
    Modeled,
}

/// The eyes of a lockstep.
#[derive(Clone, Debug)]
pub struct OwnEyesOptions {
    /// Images a second. Default 25: the middle of training's.
    pub rate_hz: f64,
    /// Age of an image when it reaches perception `[s]`. Default 0.07: the middle of training's.
    pub latency_s: f64,
    /// The image's size. Default 424 x 240.
    pub intrinsics: Intrinsics,
    /// What follows the torso. Default: the LiDAR in the endless hall: a match of 50 kicks takes the robot 50 m away.
    pub torso: TorsoSource,
    /// Lowest score of a detection; `None`: the detector's own.
    pub confidence: Option<f64>,
    /// Records images, poses, joint angles and estimates to this MCAP file.
    pub record: Option<PathBuf>,
}

impl Default for OwnEyesOptions {
    fn default() -> Self {
        Self {
            rate_hz: 25.0,
            latency_s: 0.07,
            intrinsics: Intrinsics::g1_color(),
            torso: TorsoSource::Lidar(SceneKind::Endless, [0.0, 0.0]),
            confidence: None,
            record: None,
        }
    }
}

/// Camera, LiDAR and eyes in one.
pub struct OwnEyes {
    camera: SimCamera,
    period_us: f64,
    latency_us: u64,
    next_picture_us: f64,
    pictures: VecDeque<(u64, PictureMessage)>,
    torso: TorsoSide,
    ball: BallEyes,
    anchor: usize,
    /// False: odometry is silent.
    pub odometry: bool,
    /// False: the camera sends nothing.
    pub open: bool,
}

enum TorsoSide {
    Lidar { sensor: Box<SimLidar>, eyes: Box<TorsoEyes>, scans: VecDeque<(u64, Scan)> },
    Modeled(Box<DriftingOdometry>),
}

impl OwnEyes {
    /// Eyes of a robot that is there now. `seed` draws place, noise and drift.
    ///
    /// # Errors
    /// If the detector cannot be run, or the recording not be written.
    pub fn new(
        player: &Player,
        robot: &VirtualG1,
        options: &OwnEyesOptions,
        seed: u64,
    ) -> Result<Self, TwinError> {
        let anchor = player.model.body_index(&player.spec.anchor_body).unwrap_or(0);
        // The torso's poses come from outside of what is recorded.
        let mut setup =
            SightSetup { intrinsics: options.intrinsics, lidar: None, ..BallEyes::setup(player)? };
        if let Some(least) = options.confidence {
            setup.finder = setup.finder.with_confidence(least);
        }
        let recorder = options.record.as_deref().map(|path| Recorder::create(path, &setup));
        let recorder = recorder.transpose().map_err(TwinError::eyes)?;
        let here = Moment::of(robot, anchor).torso;
        let torso = match options.torso {
            TorsoSource::Lidar(surroundings, start_m) => TorsoSide::Lidar {
                sensor: Box::new(SimLidar::new(surroundings, start_m, 200_000.0, &here, seed)?),
                eyes: Box::new(TorsoEyes::lidar(Config::g1(), SimLidar::BEHIND_S)?),
                scans: VecDeque::new(),
            },
            TorsoSource::Modeled => {
                TorsoSide::Modeled(Box::new(DriftingOdometry::new(&player.play.eyes, seed)))
            }
        };
        Ok(Self {
            camera: SimCamera::new(options.intrinsics, player.play.ball_params.radius_m, seed)?,
            period_us: 1e6 / options.rate_hz,
            latency_us: (1e6 * options.latency_s).round() as u64,
            next_picture_us: 0.0,
            pictures: VecDeque::new(),
            torso,
            ball: BallEyes::new(setup)?.recorded_by(recorder),
            anchor,
            odometry: true,
            open: true,
        })
    }

    /// The goal in the images: center (x, y) in the world `[m]`, facing along this heading `[rad]`.
    pub fn place_goal(&mut self, center: [f64; 2], heading: f64) {
        self.camera.place_goal(center, heading);
    }

    /// Their reports at the robot's time, called every 2 ms; `phase` is the runtime's.
    ///
    /// # Errors
    /// If the detector fails, or the recording cannot be written.
    pub fn step(
        &mut self,
        robot: &VirtualG1,
        phase: &Phase,
        mut send: impl FnMut(Packet),
    ) -> Result<(), TwinError> {
        let (now_us, moment) = (robot.now_us(), Moment::of(robot, self.anchor));
        let now_ns = 1000 * now_us;
        let fix = self.torso.step(now_us, &moment.torso).filter(|_| self.odometry);
        if let Some(fix) = fix {
            self.ball.torso(&fix)?;
            send(Packet::Torso(fix.handed_over(now_ns)));
        }
        if now_us.is_multiple_of(JOINTS_US) {
            self.ball.joints(now_ns, robot.truth().joint_pos.clone())?;
        }
        if now_us as f64 >= self.next_picture_us - 1.0 {
            self.next_picture_us += self.period_us;
            if self.open {
                let (color, depth) = self.camera.picture(&moment);
                let intrinsics = *self.camera.intrinsics();
                let picture = PictureMessage {
                    captured_ns: now_ns,
                    color,
                    depth: Some(depth),
                    intrinsics,
                    boxes: None,
                };
                self.pictures.push_back((now_us + self.latency_us, picture));
            }
        }
        let mut looked = false;
        while self.pictures.front().is_some_and(|(arrives_us, _)| *arrives_us <= now_us) {
            let Some((_, picture)) = self.pictures.pop_front() else { break };
            self.ball.picture(picture, now_ns, phase)?;
            looked = true;
        }
        if looked || now_us.is_multiple_of(REPORT_US) {
            send(Packet::Eyes(self.ball.report(now_ns, phase)?));
        }
        Ok(())
    }
}

impl TorsoSide {
    fn step(&mut self, now_us: u64, torso: &Pose) -> Option<TorsoFix> {
        let now_s = now_us as f64 * 1e-6;
        match self {
            Self::Lidar { sensor, eyes, scans } => {
                sensor.torso(now_s, torso);
                let (new, scan) = sensor.measured(now_s);
                scans.extend(scan.map(|scan| (now_us + SCAN_US, scan)));
                let mut fix = None;
                for sample in new {
                    fix = eyes.imu(sample, 1000 * now_us).or(fix);
                }
                while scans.front().is_some_and(|(at, _)| *at <= now_us) {
                    let Some((_, scan)) = scans.pop_front() else { break };
                    eyes.scan(scan, 1000 * now_us);
                }
                fix
            }
            Self::Modeled(odometry) => {
                if !now_us.is_multiple_of(DriftingOdometry::PERIOD_US) {
                    return None;
                }
                let (pos, rot) = odometry.advance(torso.pos, &torso.rot);
                let stamp_ns = 1000 * now_us;
                let pose = PoseMessage { stamp_ns, position: pos.0, quat: quaternion(&rot) };
                Some(TorsoFix { at_ns: stamp_ns, frame: 0, pose })
            }
        }
    }
}
