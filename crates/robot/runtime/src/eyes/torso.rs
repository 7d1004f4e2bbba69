//! Where the torso is: LiDAR-inertial odometry, or another odometry's poses.

use nalgebra::Isometry3;
use paid_lidar::{Config, DataFault, Health, ImuSample, Odometry, Scan};
use paid_world::{NoPose, OdometryState, PoseMessage, PoseWatch, seconds};

use super::DeviceClock;
use crate::DeployError;
use crate::message::TorsoPose;

/// Poses come at this interval `[s]`: ten to an image, and a fifth of the age that the runtime calls old.
const PERIOD_S: f64 = 0.01;
/// A sample that is early by less is on time `[s]`: half the interval of a Mid-360's inertial sensor, whose stamps jitter by 0.8 ms.
const EARLY_S: f64 = 0.0025;

/// The torso at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TorsoFix {
    /// When it was there, local clock `[ns]`.
    pub at_ns: u64,
    /// Numbers odometry's frames.
    pub frame: u32,
    /// Place `[m]` and orientation w, x, y, z in odometry's frame.
    pub pose: PoseMessage,
}

impl TorsoFix {
    /// As the runtime gets it at `now_ns` `[ns]`.
    pub fn handed_over(&self, now_ns: u64) -> TorsoPose {
        TorsoPose {
            age_us: now_ns.saturating_sub(self.at_ns) / 1000,
            frame: self.frame,
            position: self.pose.position,
            quaternion: self.pose.quat,
        }
    }
}

/// Follows the torso.
#[derive(Debug)]
pub struct TorsoEyes {
    lidar: Option<Odometry>,
    /// From measurement to arrival of the fastest sample `[ns]`.
    way_ns: u64,
    clock: DeviceClock,
    state: OdometryState,
    no_pose: Option<NoPose>,
    frame: u32,
    last_s: f64,
    watch: PoseWatch,
}

impl TorsoEyes {
    /// By a Mid-360 that is mounted as given, whose fastest sample takes `latency_s` to come `[s]`.
    ///
    /// # Errors
    /// If a setting makes no sense.
    pub fn lidar(config: Config, latency_s: f64) -> Result<Self, DeployError> {
        let lidar = Some(Odometry::new(config).map_err(DeployError::eyes)?);
        Ok(Self { lidar, way_ns: (latency_s * 1e9) as u64, ..Self::other() })
    }

    /// By another odometry, whose poses come by [`Self::pose`].
    pub fn other() -> Self {
        Self {
            lidar: None,
            way_ns: 0,
            clock: DeviceClock::default(),
            state: OdometryState::Waiting,
            no_pose: None,
            frame: 0,
            last_s: f64::NEG_INFINITY,
            watch: PoseWatch::default(),
        }
    }

    /// How well the pose is known.
    pub fn state(&self) -> OdometryState {
        self.state
    }

    /// The same in words, with the reason where the LiDAR's odometry has one.
    pub fn words(&self) -> String {
        self.state.with_reason(self.no_pose.as_ref())
    }

    /// What is wrong with the data of LiDAR and IMU that come now.
    pub fn data_fault(&self) -> Option<DataFault> {
        self.lidar.as_ref()?.data_fault()
    }

    /// Takes in an inertial sample that came at `at_ns` `[ns]`; gives a pose where one is due.
    pub fn imu(&mut self, sample: ImuSample, at_ns: u64) -> Option<TorsoFix> {
        // Only samples set the clock: scans are longer on their way.
        // Its times are negative once its own clock has fallen back: it was restarted.
        let device_ns = |s: f64| (s * 1e9).round() as i64;
        let stamp_ns = device_ns(sample.time_s);
        let here_ns = self.clock.local_ns(stamp_ns, at_ns);
        self.lidar.as_mut()?.push_imu(sample, seconds(at_ns));
        self.poll(at_ns);
        let lidar = self.lidar.as_ref()?;
        if !matches!(self.state, OdometryState::Tracking | OdometryState::Degenerate(_)) {
            return None;
        }
        let newest_s = lidar.newest_s()?;
        if newest_s < self.last_s + PERIOD_S - EARLY_S && newest_s >= self.last_s {
            return None;
        }
        let pose = lidar.pose_at(newest_s)?;
        self.last_s = newest_s;
        let after_ns = device_ns(newest_s).saturating_sub(stamp_ns);
        let at_ns = here_ns.saturating_add_signed(after_ns).saturating_sub(self.way_ns);
        Some(TorsoFix { at_ns, frame: self.frame, pose: message(at_ns, &pose) })
    }

    /// Takes in a scan that came at `at_ns` `[ns]`.
    pub fn scan(&mut self, scan: Scan, at_ns: u64) {
        if let Some(lidar) = &mut self.lidar {
            lidar.push_scan(scan, seconds(at_ns));
            self.poll(at_ns);
        }
    }

    /// Time passes: a LiDAR that is silent is noticed.
    pub fn poll(&mut self, at_ns: u64) {
        let Some(lidar) = &mut self.lidar else { return };
        while let Some(estimate) = lidar.poll(seconds(at_ns)) {
            self.frame = estimate.frame;
            self.state = OdometryState::of(&estimate.health);
            self.no_pose = NoPose::of(&estimate.health);
            if matches!(estimate.health, Health::Lost { refused: true, .. }) {
                // It does not come back by itself: it waits for the robot to stand still and begins a new frame.
                lidar.restart();
            }
        }
    }

    /// Takes in a pose of another odometry, its stamp by the local clock, that came at `now_ns` `[ns]`. `None` of one that is late or jumps:
    /// [`Self::state`] says so.
    pub fn pose(&mut self, pose: PoseMessage, now_ns: u64) -> Option<TorsoFix> {
        match self.watch.check(&pose.stamped(), seconds(now_ns)) {
            Ok(new_frame) => {
                self.frame += u32::from(new_frame);
                self.state = OdometryState::Tracking;
                Some(TorsoFix { at_ns: pose.stamp_ns, frame: self.frame, pose })
            }
            Err(fault) => {
                self.state = OdometryState::Refused(fault);
                None
            }
        }
    }
}

fn message(stamp_ns: u64, pose: &Isometry3<f64>) -> PoseMessage {
    let q = pose.rotation;
    PoseMessage { stamp_ns, position: pose.translation.vector.into(), quat: [q.w, q.i, q.j, q.k] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use paid_lidar::g1_torso_from_lidar;
    use paid_lidar::sim::{PoseList, Scene, SceneKind, SensorModel, SimulatedMid360};

    #[test]
    fn poses_of_a_topic_that_are_late_or_jump_are_refused_and_a_new_frame_is_numbered() {
        let mut eyes = TorsoEyes::other();
        let mut see = |ms: u64, late_ms: u64, x: f64| {
            let pose =
                PoseMessage { stamp_ns: ms * 1_000_000, position: [x, 0.0, 0.8], quat: [1.0, 0.0, 0.0, 0.0] };
            let fix = eyes.pose(pose, (ms + late_ms) * 1_000_000);
            (fix.map(|fix| fix.frame), eyes.state().to_string())
        };
        assert_eq!(see(1000, 5, 0.0), (Some(0), "tracking".to_owned()));
        assert_eq!(see(1020, 120, 0.0), (None, "lost: pose 0.12 s old, expected 0 to 0.1 s".to_owned()));
        let (fix, state) = see(1040, 5, 1.0);
        assert!(fix.is_none() && state.starts_with("lost: pose jumps by 1.00 m"), "{state}");
        assert_eq!((0..4).map(|k| see(1060 + 20 * k, 5, 1.0).0).last(), Some(Some(1)));
    }

    /// A LiDAR on a torso that has these poses.
    fn in_the_hall(poses: Vec<(f64, Isometry3<f64>)>) -> SimulatedMid360<PoseList> {
        SimulatedMid360::new(
            Scene::new(SceneKind::Hall, 2),
            PoseList::new(poses).expect("poses"),
            SensorModel { points_per_s: 20_000.0, ..SensorModel::default() },
            g1_torso_from_lidar(),
            &Config::g1().imu_from_lidar,
            2,
        )
    }

    /// This machine's time of what the sensor stamps `s`, and what comes `ms` later: the sensor's clock began 40 s before this one; samples take
    /// 3 ms, scans 20.
    fn at(s: f64, ms: u64) -> u64 {
        40_000_000_000 + (s * 1e9).round() as u64 + ms * 1_000_000
    }

    #[test]
    fn a_torso_that_moves_a_meter_is_followed_by_the_clock_of_this_machine() {
        // It stands for a second and goes a meter along x in the next two.
        let x = |t: f64| (0.5 * (t - 1.0)).clamp(0.0, 1.0);
        let poses = (0..1700).map(|k| {
            let t = f64::from(k) * 0.002;
            (t, Isometry3::translation(x(t), 0.0, 0.8))
        });
        let mut sensor = in_the_hall(poses.collect());
        let (mut eyes, mut fixes) = (TorsoEyes::lidar(Config::g1(), 0.003).expect("a setup"), Vec::new());
        for _ in 0..32 {
            let frame = sensor.next_frame();
            for sample in frame.imu {
                fixes.extend(eyes.imu(sample, at(sample.time_s, 3)));
            }
            let end_s = frame.scan.end_s;
            eyes.scan(frame.scan, at(end_s, 20));
        }
        assert_eq!(eyes.state(), OdometryState::Tracking);
        // From the end of the first half second on a hundred times a second.
        assert!((260..=275).contains(&fixes.len()), "{}", fixes.len());
        let (first, last) = (fixes[0], fixes[fixes.len() - 1]);
        let gone = last.pose.position[0] - first.pose.position[0];
        assert!((gone - 1.0).abs() < 0.08, "{first:?} {last:?}");
        // Of one of the last two samples, by the time at which it was taken.
        assert!(last.at_ns.abs_diff(at(3.2, 0)) < 6_000_000, "{last:?}");
        assert_eq!(last.handed_over(last.at_ns + 7_000_000).age_us, 7000);
    }

    #[test]
    fn the_reasons_of_the_lidars_odometry_are_told() {
        let mut eyes = TorsoEyes::lidar(Config::g1(), 0.003).expect("a setup");
        assert_eq!((eyes.words().as_str(), eyes.data_fault()), ("waiting", None));
        let here = Isometry3::translation(0.0, 0.0, 0.8);
        let mut sensor = in_the_hall((0..800).map(|k| (f64::from(k) * 0.002, here)).collect());
        for _ in 0..6 {
            let scan = sensor.next_frame().scan;
            let end_s = scan.end_s;
            eyes.scan(scan, at(end_s, 20));
        }
        assert_eq!(eyes.data_fault(), Some(DataFault::NoImu));
        // Samples in multiples of gravity, 200 a second.
        for k in 0..200 {
            let time_s = 0.6 + 0.005 * f64::from(k);
            let sample = ImuSample { time_s, gyro: [0.0; 3].into(), accel: [0.0, 0.0, 1.0].into() };
            eyes.imu(sample, at(time_s, 3));
        }
        let scan = sensor.next_frame().scan;
        eyes.scan(scan, at(1.6, 20));
        let expected =
            "waiting: acceleration at rest: expected 9.81 m/s^2 within 10%, found 1.00 (values in g?)";
        assert_eq!((eyes.words().as_str(), eyes.data_fault()), (expected, None));
    }

    #[test]
    fn a_lidar_whose_clock_has_fallen_back_before_its_first_time_keeps_its_poses_in_order() {
        let here = Isometry3::translation(0.0, 0.0, 0.8);
        let mut sensor = in_the_hall((0..800).map(|k| (f64::from(k) * 0.002, here)).collect());
        let (mut eyes, mut fixes) = (TorsoEyes::lidar(Config::g1(), 0.003).expect("a setup"), Vec::new());
        for _ in 0..12 {
            let frame = sensor.next_frame();
            for sample in frame.imu {
                let stamped = ImuSample { time_s: sample.time_s - 100.0, ..sample };
                fixes.extend(eyes.imu(stamped, at(sample.time_s, 3)));
            }
            let Scan { start_s, end_s, points } = frame.scan;
            let stamped = Scan { start_s: start_s - 100.0, end_s: end_s - 100.0, points };
            eyes.scan(stamped, at(end_s, 20));
        }
        assert!(fixes.len() > 50, "{}", fixes.len());
        assert!(fixes.is_sorted_by(|a, b| a.at_ns < b.at_ns), "{fixes:?}");
        let last = fixes[fixes.len() - 1];
        assert!(last.at_ns.abs_diff(at(1.2, 0)) < 11_000_000, "{last:?}");
    }
}
