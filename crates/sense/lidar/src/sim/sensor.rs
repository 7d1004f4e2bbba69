//! The simulated Mid-360: scans and IMU samples from a motion through a scene.

use nalgebra::{Isometry3, Rotation3, Translation3, UnitQuaternion, Vector3};
use paid_lanes::Vec3;
use paid_lanes::rng::Rng;
use paid_track::Pose;

use crate::config::{Config, g1_torso_from_lidar};
use crate::error::LidarError;
use crate::imu::ImuSample;
use crate::scan::{Point, Scan};
use crate::sim::body::limbs;
use crate::sim::pattern::Pattern;
use crate::sim::pose_list::PoseList;
use crate::sim::scene::Scene;
use crate::sim::walk::Trajectory;
use crate::so3::log;

/// Samples of the IMU a second.
const IMU_HZ: f64 = 200.0;
/// Scans a second. Times are quotients by it, so that they equal those of the IMU's samples to the last bit.
pub(crate) const SCANS_PER_S: f64 = 10.0;
/// Duration of a scan `[s]`.
pub(crate) const SCAN_S: f64 = 1.0 / SCANS_PER_S;
/// Rays between two poses of the motion: 0.5 ms at full rate, in which a torso moves by less than 1 mm.
const RAYS_PER_POSE: u64 = 100;
/// No longer than this lies between two poses, however few rays there are `[s]`: a turn of more than a degree is no small one.
const POSE_S: f64 = 0.01;

/// How good the sensor is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorModel {
    /// Points a second. Mid-360: 200 000.
    pub points_per_s: f64,
    /// Standard deviation of the range `[m]`. Mid-360: 2 cm at 10 m.
    pub range_noise_m: f64,
    /// Farthest range `[m]`. Mid-360: 40 m at 10% reflectivity.
    pub range_m: f64,
    /// Nearest range that the sensor reports `[m]`.
    pub blind_m: f64,
    /// Whether the robot's arms and legs are seen.
    pub self_hits: bool,
    /// Standard deviation of the gyroscope `[rad/s]`.
    pub gyro_noise: f64,
    /// Standard deviation of the accelerometer `[m/s^2]`.
    pub accel_noise: f64,
    /// Standard deviation of an axis of the gyroscope's bias `[rad/s]`.
    pub gyro_bias: f64,
    /// Standard deviation of an axis of the accelerometer's bias `[m/s^2]`.
    pub accel_bias: f64,
    /// The accelerometer shows at most this `[m/s^2]`. Mid-360: 4 g.
    pub accel_range: f64,
    /// Time that the IMU's stamps are late `[s]`.
    pub imu_offset_s: f64,
}

impl Default for SensorModel {
    fn default() -> Self {
        Self {
            points_per_s: 200_000.0,
            range_noise_m: 0.02,
            range_m: 40.0,
            blind_m: 0.1,
            self_hits: true,
            gyro_noise: 0.002,
            accel_noise: 0.03,
            gyro_bias: 0.01,
            accel_bias: 0.05,
            accel_range: 4.0 * 9.81,
            imu_offset_s: 0.0,
        }
    }
}

/// Data of one scan's time.
#[derive(Clone, Debug)]
pub struct Frame {
    /// IMU samples, in order.
    pub imu: Vec<ImuSample>,
    /// The scan.
    pub scan: Scan,
}

/// A Mid-360 on a body that moves.
#[derive(Debug)]
pub struct SimulatedMid360<T> {
    scene: Scene,
    trajectory: T,
    model: SensorModel,
    pattern: Pattern,
    torso_from_lidar: Isometry3<f64>,
    torso_from_imu: Isometry3<f64>,
    noise: Rng,
    gyro_bias: Vector3<f64>,
    accel_bias: Vector3<f64>,
    rays: u64,
    samples: u64,
    frames: u64,
}

/// A pose as the sensor's motion takes it.
fn isometry(pose: &Pose) -> Isometry3<f64> {
    let Vec3([x, y, z]) = pose.pos;
    let matrix = nalgebra::Matrix3::from_fn(|i, k| pose.rot.0[i][k]);
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix));
    Isometry3::from_parts(Translation3::new(x, y, z), rotation)
}

impl SimulatedMid360<PoseList> {
    /// The sensor in the head of a G1 whose torso has stood at `torso`; [`Self::torso_at`] gives its motion from there.
    ///
    /// # Errors
    /// If the pose is none.
    pub fn on_g1(scene: Scene, model: SensorModel, torso: &Pose, seed: u64) -> Result<Self, LidarError> {
        let here = isometry(torso);
        let still = PoseList::new(vec![(-0.1, here), (0.0, here)])?;
        Ok(Self::new(scene, still, model, g1_torso_from_lidar(), &Config::g1().imu_from_lidar, seed))
    }

    /// The torso at a time of the sensor's clock `[s]`.
    pub fn torso_at(&mut self, time_s: f64, torso: &Pose) {
        self.trajectory.push(time_s, isometry(torso));
    }
}

impl<T: Trajectory> SimulatedMid360<T> {
    /// A sensor at `torso_from_lidar` with its IMU at `imu_from_lidar`. `seed` draws noise and biases.
    #[must_use]
    pub fn new(
        scene: Scene,
        trajectory: T,
        model: SensorModel,
        torso_from_lidar: Isometry3<f64>,
        imu_from_lidar: &Isometry3<f64>,
        seed: u64,
    ) -> Self {
        let mut draw = Rng::new(seed, 0, 60);
        let mut vector = |deviation: f64| Vector3::from_fn(|_, _| draw.normal() * deviation);
        let (gyro_bias, accel_bias) = (vector(model.gyro_bias), vector(model.accel_bias));
        Self {
            scene,
            trajectory,
            pattern: Pattern { points_per_s: model.points_per_s },
            model,
            torso_from_lidar,
            torso_from_imu: torso_from_lidar * imu_from_lidar.inverse(),
            noise: Rng::new(seed, 0, 61),
            gyro_bias,
            accel_bias,
            rays: 0,
            samples: 0,
            frames: 0,
        }
    }

    /// True pose of the torso in the scene at `time_s`.
    pub fn torso(&self, time_s: f64) -> Isometry3<f64> {
        self.trajectory.pose(time_s)
    }

    /// Data of the next 0.1 s.
    pub fn next_frame(&mut self) -> Frame {
        self.frames += 1;
        let end_s = self.frames as f64 / SCANS_PER_S;
        let imu = self.imu_until(end_s);
        Frame { imu, scan: self.scan_until(end_s) }
    }

    /// The IMU's samples up to `end_s` `[s]`, for those who do not wait for a scan's end. The motion must be known 2.5 ms longer.
    pub fn next_imu(&mut self, end_s: f64) -> Vec<ImuSample> {
        self.imu_until(end_s)
    }

    /// The next scan, once it has ended by `now_s` `[s]`; its samples come from [`Self::next_imu`].
    pub fn next_scan(&mut self, now_s: f64) -> Option<Scan> {
        let end_s = (self.frames + 1) as f64 / SCANS_PER_S;
        if end_s > now_s + 1e-9 {
            return None;
        }
        self.frames += 1;
        Some(self.scan_until(end_s))
    }

    /// The motion, to be continued.
    pub fn trajectory_mut(&mut self) -> &mut T {
        &mut self.trajectory
    }

    /// Puts another scene around the sensor. The old one, moved: what the LiDAR sees after it was carried off.
    pub fn surround(&mut self, scene: Scene) {
        self.scene = scene;
    }

    fn imu_until(&mut self, end_s: f64) -> Vec<ImuSample> {
        let mut out = Vec::new();
        loop {
            let time_s = self.samples as f64 / IMU_HZ;
            if time_s > end_s + 1e-9 {
                return out;
            }
            self.samples += 1;
            out.push(self.imu_sample(time_s));
        }
    }

    fn imu_sample(&mut self, time_s: f64) -> ImuSample {
        // The mean over a sample's time, as an IMU's low-pass filter gives it.
        let h = 0.5 / IMU_HZ;
        let pose = |t: f64| self.trajectory.pose(t) * self.torso_from_imu;
        let [before, now, after] = [pose(time_s - h), pose(time_s), pose(time_s + h)];
        let accel =
            (after.translation.vector - now.translation.vector * 2.0 + before.translation.vector) / (h * h);
        let force = now.rotation.inverse() * (accel + Vector3::z() * crate::gravity::GRAVITY);
        let gyro = log(&(before.rotation.inverse() * after.rotation)) / (2.0 * h);
        let mut noisy = |v: Vector3<f64>, bias: Vector3<f64>, deviation: f64| {
            v + bias + Vector3::from_fn(|_, _| self.noise.normal() * deviation)
        };
        let gyro = noisy(gyro, self.gyro_bias, self.model.gyro_noise);
        let range = self.model.accel_range;
        let accel = noisy(force, self.accel_bias, self.model.accel_noise).map(|a| a.clamp(-range, range));
        ImuSample { time_s: time_s + self.model.imu_offset_s, gyro, accel }
    }

    fn scan_until(&mut self, end_s: f64) -> Scan {
        let rate = self.model.points_per_s;
        let start_s = end_s - SCAN_S;
        let mut points = Vec::with_capacity((rate * SCAN_S) as usize);
        let last = (end_s * rate).round() as u64;
        let rays_per_pose = ((rate * POSE_S).round() as u64).clamp(1, RAYS_PER_POSE);
        while self.rays < last {
            let upto = (self.rays + rays_per_pose).min(last);
            let (t0, t1) = (self.rays as f64 / rate, upto as f64 / rate);
            let lidar = |t: f64| self.trajectory.pose(t) * self.torso_from_lidar;
            let (a, b) = (lidar(t0), lidar(t1));
            let turn = log(&(a.rotation.inverse() * b.rotation));
            let rotation = a.rotation.to_rotation_matrix();
            let body = limbs(self.trajectory.swing(t0));
            for index in self.rays..upto {
                let time_s = index as f64 / rate;
                let share = (time_s - t0) / (t1 - t0);
                let ray = self.pattern.ray(index);
                // Over half a millisecond a turn is small: its first order is exact to 1e-5 of the range.
                let in_scene = (rotation * (ray + (turn * share).cross(&ray))).normalize();
                let origin = a.translation.vector.lerp(&b.translation.vector, share);
                let luck = self.noise.unit();
                let mut range = self.scene.range(&origin, &in_scene, time_s, luck);
                if self.model.self_hits {
                    let eye = self.torso_from_lidar.translation.vector;
                    let in_torso = self.torso_from_lidar.rotation * ray;
                    let own = body.iter().filter_map(|c| c.range(&eye, &in_torso)).reduce(f64::min);
                    range = [range, own].into_iter().flatten().reduce(f64::min);
                }
                let Some(range) = range else { continue };
                let measured = range + self.noise.normal() * self.model.range_noise_m;
                if measured > self.model.blind_m && measured < self.model.range_m {
                    points.push(Point { offset_s: time_s - start_s, position: ray * measured });
                }
            }
            self.rays = upto;
        }
        Scan { start_s, end_s, points }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{Config, g1_torso_from_lidar};
    use crate::sim::scene::SceneKind;
    use crate::sim::walk::Walk;

    fn sensor(model: SensorModel) -> SimulatedMid360<Walk> {
        let kind = SceneKind::Hall;
        let config = Config::default();
        SimulatedMid360::new(
            Scene::new(kind, 5),
            Walk::new(kind, 5),
            model,
            g1_torso_from_lidar(),
            &config.imu_from_lidar,
            5,
        )
    }

    #[test]
    fn a_standing_sensor_upside_down_shows_gravity_and_the_ground() {
        let model = SensorModel { points_per_s: 20_000.0, ..SensorModel::default() };
        let mut sensor = sensor(model);
        let frame = sensor.next_frame();
        assert_eq!(frame.imu.len(), 21);
        let accel: Vector3<f64> = frame.imu.iter().map(|s| s.accel).sum::<Vector3<f64>>() / 21.0;
        assert!((accel.z + 9.8).abs() < 0.25, "{accel}");
        assert!((1500..=2000).contains(&frame.scan.points.len()), "{}", frame.scan.points.len());
        let lidar = sensor.torso(0.05) * g1_torso_from_lidar();
        let on_ground = frame
            .scan
            .points
            .iter()
            .filter(|p| (lidar * nalgebra::Point3::from(p.position)).z.abs() < 0.06)
            .count();
        assert!(on_ground > 500, "{on_ground}");
        // Arms hang 0.2 to 0.6 m from the head.
        assert!(frame.scan.points.iter().any(|p| p.position.norm() < 0.5));
    }

    /// A torso that turns by a radian a second where it stands.
    struct Turning;

    impl Trajectory for Turning {
        fn pose(&self, time_s: f64) -> Isometry3<f64> {
            Isometry3::from_parts(
                Translation3::new(0.0, 0.0, 0.8),
                UnitQuaternion::from_euler_angles(0.0, 0.0, time_s),
            )
        }
    }

    #[test]
    fn a_sensor_of_few_points_that_turns_sees_the_hall_where_it_is() {
        let model = SensorModel {
            points_per_s: 1000.0,
            range_noise_m: 0.0,
            self_hits: false,
            ..SensorModel::default()
        };
        let hall = || Scene::new(SceneKind::Hall, 5);
        let imu = Config::default().imu_from_lidar;
        let mut sensor = SimulatedMid360::new(hall(), Turning, model, g1_torso_from_lidar(), &imu, 5);
        let scan = sensor.next_frame().scan;
        assert!(scan.points.len() > 50, "{}", scan.points.len());
        let mut off: Vec<f64> = scan
            .points
            .iter()
            .map(|p| {
                let lidar = Turning.pose(p.offset_s) * g1_torso_from_lidar();
                let range = p.position.norm();
                let ray = lidar.rotation * (p.position / range);
                let seen = hall().range(&lidar.translation.vector, &ray, p.offset_s, 0.0);
                seen.map_or(1.0, |seen| (seen - range).abs())
            })
            .collect();
        off.sort_by(f64::total_cmp);
        let most = off[off.len() * 9 / 10];
        assert!(most < 2e-3, "nine of ten points are off by up to {most} m");
    }

    #[test]
    fn impacts_are_clipped_at_4_g() {
        let model = SensorModel { points_per_s: 100.0, ..SensorModel::default() };
        let mut sensor = sensor(model);
        let samples: Vec<ImuSample> = (0..100).flat_map(|_| sensor.next_frame().imu).collect();
        let most = samples.iter().map(ImuSample::peak_accel).fold(0.0, f64::max);
        assert!((most - 4.0 * 9.81).abs() < 1e-9, "{most}");
        let clipped = samples.iter().filter(|s| s.peak_accel() > 39.0).count();
        assert!((2..60).contains(&clipped), "{clipped}");
        assert!(samples.windows(2).all(|w| (w[1].time_s - w[0].time_s - 0.005).abs() < 1e-9));
    }
}
