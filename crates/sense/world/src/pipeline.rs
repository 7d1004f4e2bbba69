//! From messages to beliefs.

use nalgebra::Vector3;
use paid_lanes::Vec3;
use paid_lidar::{ImuSample, Odometry, Point, Scan, stamped};
use paid_track::{BallMemory, Candidate, Glance, Pose, PoseBuffer, Rolling, TrackedBall};
use paid_vision::detect::{Depth, Detection};
use paid_vision::locate::BallFinder;
use paid_vision::{DepthImage, PictureFault, PictureWatch, VisionError};

use crate::body::OwnBody;
use crate::horizon::Horizon;
use crate::message::{ImuMessage, PictureMessage, PoseMessage, ScanMessage, seconds};
use crate::pose_watch::{NoPose, OdometryState, PoseWatch};
use crate::{Arrived, Finder, Message, SightError, SightSetup};

/// Poses that are farther apart `[s]` say nothing of the time between them: odometry comes at 10 Hz or more.
const HOLE_S: f64 = 0.15;
/// A ball on the ground is no higher above it than this and its radius `[m]`: what is higher is a hand.
const HIGHEST_M: f64 = 0.35;
/// Velocity of the torso is taken over this time `[s]`.
const VELOCITY_S: f64 = 0.05;

/// The estimate at a step.
#[derive(Clone, Copy, Debug)]
pub struct Believed {
    /// The step's time `[ns]`.
    pub at_ns: u64,
    /// The torso in the odometry frame, now.
    pub torso: Option<Pose>,
    /// The base in the odometry frame, now.
    pub base: Option<Pose>,
    /// Height of the floor in the odometry frame `[m]`.
    pub floor_m: Option<f64>,
    /// The ball to kick.
    pub ball: Option<TrackedBall>,
    /// How well the torso's pose is known.
    pub odometry: OdometryState,
    /// What is wrong with the last image.
    pub picture: Option<PictureFault>,
}

/// A detection that got a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sighted {
    /// When its image was taken `[ns]`.
    pub captured_ns: u64,
    /// When it was fused `[ns]`.
    pub fused_ns: u64,
    /// Center, odometry frame `[m]`.
    pub position: [f64; 3],
    /// Variance that the tracker was given `[m^2]`.
    pub variance: f64,
    /// The detector's score.
    pub score: f64,
    /// Whether it was taken for the ball to kick.
    pub own: bool,
}

/// The eyes.
#[derive(Debug)]
pub struct Sight {
    finder: Finder,
    place: BallFinder,
    watch: PictureWatch,
    body: OwnBody,
    memory: BallMemory,
    horizon: Horizon,
    lidar: Option<Odometry>,
    frame: Option<u32>,
    state: OdometryState,
    no_pose: Option<NoPose>,
    /// Poses as they were known at their time, or those of another odometry.
    poses: PoseBuffer,
    /// Watches those of another odometry.
    pose_watch: PoseWatch,
    floor: Option<f64>,
    radius: f64,
    rolling: Rolling<f64>,
    last_ns: Option<u64>,
    fault: Option<PictureFault>,
    sighted: Vec<Sighted>,
}

impl Sight {
    /// Eyes that have seen nothing.
    ///
    /// # Errors
    /// If a part of the setup makes no sense.
    pub fn new(setup: SightSetup) -> Result<Self, SightError> {
        setup.memory.check()?;
        setup.tracker.check()?;
        let place = BallFinder::new(setup.intrinsics, setup.torso_from_camera, setup.radius_m)?;
        Ok(Self {
            finder: setup.finder,
            place: place.with_noise(setup.noise).with_floor(None),
            watch: PictureWatch::new(setup.intrinsics),
            body: OwnBody::new(setup.robot, &setup.torso)?,
            memory: BallMemory::new(setup.memory, setup.tracker),
            horizon: Horizon::default(),
            lidar: setup.lidar.map(Odometry::new).transpose()?,
            frame: None,
            state: OdometryState::Waiting,
            no_pose: None,
            poses: no_poses(),
            pose_watch: PoseWatch::default(),
            floor: None,
            radius: setup.radius_m,
            rolling: Rolling { decay: setup.decay, to_strike_s: f64::INFINITY },
            last_ns: None,
            fault: None,
            sighted: Vec::new(),
        })
    }

    /// Takes in a message. A step is answered.
    ///
    /// # Errors
    /// If the detector fails, or joint angles do not fit the robot.
    pub fn take(&mut self, arrived: &Arrived) -> Result<Option<Believed>, SightError> {
        let at_ns = arrived.at_ns;
        match &arrived.message {
            Message::Imu(imu) => self.imu(imu, at_ns),
            Message::Scan(scan) => self.scan(scan, at_ns),
            Message::Pose(pose) => self.pose(pose, at_ns),
            Message::Joints(joints) => self.body.take(joints)?,
            Message::Picture(picture) => self.picture(picture, at_ns)?,
            Message::Step { to_strike_s } => return Ok(Some(self.step(at_ns, *to_strike_s))),
        }
        Ok(None)
    }

    /// Forgets balls, poses and floor: another odometry begins a new frame, in which places of the old one mean nothing.
    pub fn forget(&mut self) {
        self.memory.clear();
        self.poses = no_poses();
        self.pose_watch = PoseWatch::default();
        self.floor = None;
        self.place.set_floor(None);
        self.state = OdometryState::Waiting;
    }

    /// The detections since the last call, with their places.
    pub fn take_sighted(&mut self) -> Vec<Sighted> {
        std::mem::take(&mut self.sighted)
    }

    /// What the LiDAR's odometry says against its data and of a pose that it does not have.
    pub fn lidar_faults(&self) -> impl Iterator<Item = String> {
        let data = self.lidar.as_ref().and_then(|lidar| lidar.data_fault());
        let data = data.map(|fault| format!("LiDAR: {fault}"));
        let pose = self.no_pose.as_ref();
        data.into_iter().chain(pose.map(|why| format!("odometry: {}", self.state.with_reason(Some(why)))))
    }

    /// Every confirmed ball.
    pub fn balls(&self) -> Vec<TrackedBall> {
        self.memory.all(&self.rolling)
    }

    /// A pose of another odometry. One that jumps for good begins a new frame.
    fn pose(&mut self, pose: &PoseMessage, at_ns: u64) {
        let stamped = pose.stamped();
        match self.pose_watch.check(&stamped, seconds(at_ns)) {
            Ok(new_frame) => {
                if new_frame {
                    let watch = std::mem::take(&mut self.pose_watch);
                    self.forget();
                    self.pose_watch = watch;
                }
                self.poses.push(stamped);
                self.state = OdometryState::Tracking;
            }
            Err(fault) => self.state = OdometryState::Refused(fault),
        }
    }

    fn imu(&mut self, imu: &ImuMessage, at_ns: u64) {
        let Some(lidar) = &mut self.lidar else { return };
        let sample = ImuSample {
            time_s: seconds(imu.stamp_ns),
            gyro: Vector3::from(imu.gyro),
            accel: Vector3::from(imu.accel),
        };
        lidar.push_imu(sample, seconds(at_ns));
        self.poll(at_ns);
    }

    fn scan(&mut self, scan: &ScanMessage, at_ns: u64) {
        let Some(lidar) = &mut self.lidar else { return };
        let points = scan
            .points
            .iter()
            .map(|[x, y, z, offset_s]| Point { offset_s: *offset_s, position: Vector3::new(*x, *y, *z) });
        let scan =
            Scan { start_s: seconds(scan.start_ns), end_s: seconds(scan.end_ns), points: points.collect() };
        lidar.push_scan(scan, seconds(at_ns));
        self.poll(at_ns);
    }

    fn poll(&mut self, at_ns: u64) {
        let Some(lidar) = &mut self.lidar else { return };
        while let Some(estimate) = lidar.poll(seconds(at_ns)) {
            self.state = OdometryState::of(&estimate.health);
            self.no_pose = NoPose::of(&estimate.health);
            if self.frame.replace(estimate.frame).is_some_and(|old| old != estimate.frame) {
                // Places of the old frame mean nothing in the new one.
                self.memory.clear();
                self.poses = no_poses();
                self.floor = None;
            }
        }
    }

    /// The torso at a time of the past, as odometry knows it by now.
    pub fn torso(&self, time_s: f64) -> Option<Pose> {
        if !self.state.is_usable() {
            return None;
        }
        let known = self.lidar.as_ref().and_then(|lidar| lidar.pose_at(time_s));
        known.map(|pose| stamped(time_s, &pose).pose()).or_else(|| self.poses.at(time_s).ok())
    }

    /// Time passes for the balls.
    fn advance(&mut self, at_ns: u64) {
        let last = *self.last_ns.get_or_insert(at_ns);
        if at_ns > last {
            let dt_s = seconds(at_ns - last);
            self.memory.advance(dt_s, self.horizon.seconds(), &self.rolling);
            self.rolling.to_strike_s -= dt_s;
            self.last_ns = Some(at_ns);
        }
    }

    fn step(&mut self, at_ns: u64, to_strike_s: f64) -> Believed {
        self.advance(at_ns);
        self.rolling.to_strike_s = to_strike_s;
        if let Some(lidar) = &self.lidar
            && !matches!(self.state, OdometryState::Waiting)
            && let Some(newest_s) = lidar.newest_s()
            && let Some(pose) = lidar.pose_at(newest_s)
        {
            self.poses.push(stamped(newest_s, &pose));
        }
        if self.lidar.is_none()
            && self.state.is_usable()
            && let Some(fault) = self.pose_watch.silent(seconds(at_ns))
        {
            self.state = OdometryState::Refused(fault);
        }
        let torso = self.poses.at(seconds(at_ns)).ok().filter(|_| self.state.is_usable());
        if let (None, Some(torso)) = (self.floor, &torso) {
            self.floor = self.body.ground(torso);
            self.place.set_floor(self.floor);
        }
        Believed {
            at_ns,
            torso,
            base: torso.and_then(|torso| self.body.base(&torso)),
            floor_m: self.floor,
            ball: self.memory.own(&self.rolling),
            odometry: self.state,
            picture: self.fault,
        }
    }

    fn picture(&mut self, picture: &PictureMessage, at_ns: u64) -> Result<(), SightError> {
        self.advance(at_ns);
        let captured_s = seconds(picture.captured_ns);
        let depth = picture.depth.as_ref();
        let checked =
            self.watch.check(&picture.color, depth, &picture.intrinsics, captured_s, seconds(at_ns));
        self.fault = checked.err();
        if self.fault.is_some_and(|fault| fault.is_blind()) {
            return Ok(());
        }
        let age_s = seconds(at_ns.saturating_sub(picture.captured_ns));
        // The tracker could not use its detections, which must not count then.
        if !self.horizon.reaches(age_s) {
            return Ok(());
        }
        let depth = depth.filter(|_| self.fault.is_none());
        let Some(torso) = self.torso(captured_s) else { return Ok(()) };
        let velocity = self
            .torso(captured_s - VELOCITY_S)
            .map_or(Vec3::zero(), |before| (torso.pos - before.pos).scale(1.0 / VELOCITY_S));
        let of_ball = self.memory.own(&self.rolling).map_or([0.0; 2], |own| own.belief.ball.velocity);
        let speed = (velocity.x() - of_ball[0]).hypot(velocity.y() - of_ball[1]);
        let mut found = Vec::new();
        for detection in self.detect(picture, depth)? {
            let Ok(ball) = self.place.sight_from(&torso, &detection, depth, captured_s, speed) else {
                continue;
            };
            let in_torso = torso.inverse_point(ball.position);
            let too_high = self.floor.is_some_and(|floor| ball.position[2] > floor + self.radius + HIGHEST_M);
            if too_high || self.body.is_foot(picture.captured_ns, in_torso) {
                continue;
            }
            found.push(ball);
        }
        let finds: Vec<Candidate> = found
            .iter()
            .map(|ball| Candidate { measurement: ball.measurement(seconds(at_ns)), score: ball.score })
            .collect();
        let (camera, intrinsics) = (self.place.camera(&torso), *self.place.intrinsics());
        let eye = torso.inverse_point(camera.pos.0);
        let height = self.floor.unwrap_or(torso.pos.z() - 0.8) + self.radius;
        let (body, radius) = (&self.body, self.radius);
        let shows = |[x, y]: [f64; 2]| {
            let center = [x, y, height];
            let in_camera = camera.inverse_point(center);
            let Some([u, v]) = intrinsics.project(in_camera) else { return false };
            let margin = 0.5 * radius * intrinsics.focal[0] / in_camera[2];
            let inside = u > margin
                && v > margin
                && u < intrinsics.width as f64 - margin
                && v < intrinsics.height as f64 - margin;
            inside && !body.hides(picture.captured_ns, eye, torso.inverse_point(center))
        };
        let own = self.memory.look(&Glance { age_s, finds: &finds, shows: &shows }, &self.rolling);
        for (index, ball) in found.iter().enumerate() {
            self.sighted.push(Sighted {
                captured_ns: picture.captured_ns,
                fused_ns: at_ns,
                position: ball.position,
                variance: ball.variance,
                score: ball.score,
                own: own == Some(index),
            });
        }
        Ok(())
    }

    fn detect(
        &self,
        picture: &PictureMessage,
        depth: Option<&DepthImage>,
    ) -> Result<Vec<Detection>, VisionError> {
        if let Some(boxes) = &picture.boxes {
            let detection = |outline: &paid_vision::PixelBox| Detection {
                outline: *outline,
                score: 1.0,
                mask: None,
                whole: false,
            };
            return Ok(boxes.iter().map(detection).collect());
        }
        match &self.finder {
            Finder::Network(detector) => {
                let depth = depth.map(|image| Depth { image, intrinsics: &picture.intrinsics });
                detector.detect(&picture.color, depth)
            }
            Finder::Boxes => Ok(Vec::new()),
        }
    }
}

/// Poses of a second, and up to 0.05 s after the last one; none yet.
fn no_poses() -> PoseBuffer {
    PoseBuffer::new(1.0, 0.05).with_longest_gap(HOLE_S)
}
