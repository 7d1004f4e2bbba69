//! The simulated sensors of a trial: camera, LiDAR with its inertial sensor, joint angles; or another odometry.

use std::collections::VecDeque;

use nalgebra::{Rotation3, UnitQuaternion};
use paid_lanes::rng::Rng;
use paid_lanes::{Mat3, Quat, Vec3};
use paid_lidar::sim::{PoseList, Scene as LidarScene, SensorModel, SimulatedMid360};
use paid_robot::BodyPose;
use paid_track::{EyesPreset, OdometryDrift, Pose};
use paid_vision::Intrinsics;
use paid_vision::scatter::{GoalFrame, KickCamera, KickPicture, KickScene, Place, Robot};
use paid_world::{
    Arrived, ImuMessage, JointMessage, Message, PictureMessage, PoseMessage, ScanMessage, seconds,
};

use super::{DetectorChoice, EyesOptions, OdometryChoice};
use crate::EvalError;

/// Latency of a sample of the inertial sensor `[ns]`.
const IMU_NS: u64 = 5_000_000;
/// Latency of a scan `[ns]`.
const SCAN_NS: u64 = 20_000_000;
/// Poses of another odometry come so often `[ns]`.
const POSE_NS: u64 = 20_000_000;
/// Height of the goal's bar in the images `[m]`.
const RENDERED_GOAL_HEIGHT_M: f64 = 1.8;
/// Fewest pixels that a box is drawn around.
const FEWEST_PIXELS: usize = 30;

/// Robot and ball at one time, in the frame of the trial's start.
#[derive(Clone, Debug)]
pub(super) struct Moment {
    pub at_ns: u64,
    /// Bodies, model order.
    pub bodies: Vec<BodyPose<f64>>,
    pub joints: Vec<f64>,
    pub torso: Pose,
    /// Angular velocity of the torso `[rad/s]`.
    pub torso_rate: Vec3<f64>,
    pub ball: [f64; 3],
    pub ball_vel: [f64; 3],
}

/// What an image really showed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Showed {
    pub captured_ns: u64,
    /// Share of the ball's outline that it showed.
    pub shown: f64,
}

/// The sensors of a trial.
pub(super) struct Senses {
    camera: KickCamera,
    exact_box: bool,
    period_ns: f64,
    latency_ns: u64,
    next_picture_ns: f64,
    pictures: VecDeque<Arrived>,
    waiting: VecDeque<Arrived>,
    lidar: Option<SimulatedMid360<PoseList>>,
    modeled: Option<(OdometryDrift<f64>, EyesPreset, Rng)>,
    next_pose_ns: u64,
    /// Ground truth of every image, for the evaluation.
    pub showed: Vec<Showed>,
}

/// What a trial's sensors are made of.
pub(super) struct SensesSetup<'a> {
    pub options: &'a EyesOptions,
    pub preset: &'a EyesPreset,
    pub robot: Robot,
    pub place: Place,
    pub radius: f64,
    pub goal: [f64; 2],
    pub goal_half_width: f64,
    pub rate_hz: f64,
    pub latency_s: f64,
    pub seed: u64,
    pub trial: u32,
}

impl Senses {
    pub fn new(setup: SensesSetup<'_>, torso: &Pose) -> Result<Self, EvalError> {
        let seed = setup.seed ^ (u64::from(setup.trial) << 32);
        let lidar = match setup.options.odometry {
            OdometryChoice::Modeled => None,
            OdometryChoice::Lidar => {
                let model =
                    SensorModel { points_per_s: setup.options.points_per_s, ..SensorModel::default() };
                let surroundings = LidarScene::new(setup.options.surroundings, seed);
                Some(SimulatedMid360::on_g1(surroundings, model, torso, seed).map_err(eyes_error)?)
            }
        };
        let modeled = (setup.options.odometry == OdometryChoice::Modeled).then(|| {
            let mut rng = Rng::new(setup.seed, setup.trial, 0x0E7E);
            let mut odometry = OdometryDrift::new();
            odometry.begin_lane(0, 0.0, &setup.preset.odometry, &mut rng);
            (odometry, setup.preset.clone(), rng)
        });
        let intrinsics = Intrinsics::g1_color();
        let mut camera = KickCamera::new(setup.robot, setup.place, intrinsics, setup.radius, seed);
        camera.goal = Some(GoalFrame {
            center: setup.goal,
            heading: 0.0,
            half_width: setup.goal_half_width,
            height: RENDERED_GOAL_HEIGHT_M,
        });
        Ok(Self {
            camera,
            exact_box: setup.options.detector == DetectorChoice::ExactBox,
            period_ns: 1e9 / setup.rate_hz,
            latency_ns: (1e9 * setup.latency_s).round() as u64,
            next_picture_ns: 0.0,
            pictures: VecDeque::new(),
            waiting: VecDeque::new(),
            lidar,
            modeled,
            next_pose_ns: 0,
            showed: Vec::new(),
        })
    }

    /// The torso at a physics step, before [`Self::step`] of the control step that it is in.
    pub fn torso(&mut self, at_ns: u64, torso: &Pose) {
        if let Some(lidar) = &mut self.lidar {
            lidar.torso_at(seconds(at_ns), torso);
        }
    }

    /// A control step: takes what is due, and gives what has arrived by now. `open`: the camera looks.
    pub fn step(&mut self, moment: &Moment, open: bool) -> Vec<Arrived> {
        let at_ns = moment.at_ns;
        self.torso(at_ns, &moment.torso);
        let mut out = Vec::new();
        let joints = JointMessage { stamp_ns: at_ns, positions: moment.joints.clone() };
        out.push(Arrived { at_ns, message: Message::Joints(joints) });
        self.inertial(at_ns, &mut out);
        self.other_odometry(moment, &mut out);
        if at_ns as f64 >= self.next_picture_ns - 1.0 {
            self.next_picture_ns += self.period_ns;
            if open {
                let picture = self.picture(moment);
                let arrives = at_ns + self.latency_ns;
                self.pictures
                    .push_back(Arrived { at_ns: arrives, message: Message::Picture(Box::new(picture)) });
            }
        }
        while self.pictures.front().is_some_and(|picture| picture.at_ns <= at_ns) {
            out.extend(self.pictures.pop_front());
        }
        out
    }

    fn inertial(&mut self, at_ns: u64, out: &mut Vec<Arrived>) {
        let Some(lidar) = &mut self.lidar else { return };
        if at_ns < IMU_NS {
            return;
        }
        for sample in lidar.next_imu(seconds(at_ns - IMU_NS)) {
            let stamp_ns = (1e9 * sample.time_s).round() as u64;
            let imu = ImuMessage { stamp_ns, gyro: sample.gyro.into(), accel: sample.accel.into() };
            out.push(Arrived { at_ns: stamp_ns + IMU_NS, message: Message::Imu(imu) });
        }
        if let Some(scan) = lidar.next_scan(seconds(at_ns - IMU_NS)) {
            let ns = |time_s: f64| (1e9 * time_s).round() as u64;
            let (start_ns, end_ns) = (ns(scan.start_s), ns(scan.end_s));
            let points = scan.points.iter().map(|point| {
                let [x, y, z]: [f64; 3] = point.position.into();
                [x, y, z, point.offset_s]
            });
            let message = Message::Scan(ScanMessage { start_ns, end_ns, points: points.collect() });
            self.waiting.push_back(Arrived { at_ns: end_ns + SCAN_NS, message });
            lidar.trajectory_mut().forget_before(seconds(at_ns) - 0.3);
        }
        while self.waiting.front().is_some_and(|scan| scan.at_ns <= at_ns) {
            out.extend(self.waiting.pop_front());
        }
    }

    fn other_odometry(&mut self, moment: &Moment, out: &mut Vec<Arrived>) {
        let Some((odometry, preset, rng)) = &mut self.modeled else { return };
        if moment.at_ns < self.next_pose_ns {
            return;
        }
        self.next_pose_ns = moment.at_ns + POSE_NS;
        let numbers = [(); 3].map(|()| rng.normal());
        odometry.advance(seconds(POSE_NS), numbers, &preset.odometry);
        let (pos, rot) = odometry.pose(moment.torso.pos, &moment.torso.rot);
        let quat = quat_of(&rot).0;
        let pose = PoseMessage { stamp_ns: moment.at_ns, position: pos.0, quat };
        out.push(Arrived { at_ns: moment.at_ns, message: Message::Pose(pose) });
    }

    /// Renders what the camera sees.
    fn picture(&mut self, moment: &Moment) -> PictureMessage {
        let KickPicture { color, depth, rendered, camera } = self.camera.take(&KickScene {
            bodies: &moment.bodies,
            torso: &moment.torso,
            torso_rate: moment.torso_rate,
            ball: moment.ball,
            ball_vel: moment.ball_vel,
        });
        let intrinsics = self.camera.intrinsics;
        let visible = rendered.ball_box();
        let outline = intrinsics.sphere_box(camera.inverse_point(moment.ball), self.camera.radius);
        let shown = match (&visible, outline) {
            (Some((_, pixels)), Some(outline)) => {
                (*pixels as f64 / (core::f64::consts::FRAC_PI_4 * outline.area()).max(1.0)).min(1.0)
            }
            _ => 0.0,
        };
        self.showed.push(Showed { captured_ns: moment.at_ns, shown });
        let boxes = self.exact_box.then(|| {
            visible
                .filter(|(_, pixels)| *pixels >= FEWEST_PIXELS)
                .map(|(found, _)| found)
                .into_iter()
                .collect()
        });
        PictureMessage { captured_ns: moment.at_ns, color, depth: Some(depth), intrinsics, boxes }
    }
}

/// An error of the eyes as one of the evaluation.
pub(super) fn eyes_error(error: impl std::fmt::Display) -> EvalError {
    EvalError::Eyes(error.to_string())
}

/// The unit quaternion of a rotation.
pub(super) fn quat_of(rot: &Mat3<f64>) -> Quat<f64> {
    let matrix = nalgebra::Matrix3::from_fn(|i, k| rot.0[i][k]);
    let q = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix));
    Quat([q.w, q.i, q.j, q.k])
}
