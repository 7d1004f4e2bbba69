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
use crate::sim::device::{Frames, IMU_HZ, SensorModel, Shake, Stamps};
use crate::sim::pattern::Pattern;
use crate::sim::pose_list::PoseList;
use crate::sim::scene::Scene;
use crate::sim::walk::Trajectory;
use crate::so3::log;

/// Scans a second, about.
pub(crate) const SCANS_PER_S: f64 = 10.0;
/// Duration of a scan, about `[s]`.
pub(crate) const SCAN_S: f64 = 1.0 / SCANS_PER_S;
/// Rays between two poses of the motion: 0.5 ms at full rate, in which a torso moves by less than 1 mm.
const RAYS_PER_POSE: u64 = 100;
/// No longer than this lies between two poses, however few rays there are `[s]`: a turn of more than a degree is no small one.
const POSE_S: f64 = 0.01;

/// Data of one scan's time.
#[derive(Clone, Debug)]
pub struct Frame {
    /// IMU samples, in order, up to the first that is not before the scan's end.
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
    gyro_offset: Vector3<f64>,
    accel_bias: Vector3<f64>,
    stamps: Stamps,
    shake: Shake,
    frames: Frames,
    /// Rays of the frames so far.
    rays: u64,
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
        let mut vector = || Vector3::from_fn(|_, _| draw.normal());
        let (gyro_offset, accel_bias) =
            (vector().normalize() * model.gyro_offset, vector() * model.accel_bias);
        Self {
            scene,
            trajectory,
            pattern: Pattern { points_per_s: model.points_per_s },
            model,
            torso_from_lidar,
            torso_from_imu: torso_from_lidar * imu_from_lidar.inverse(),
            noise: Rng::new(seed, 0, 61),
            gyro_offset,
            accel_bias,
            stamps: Stamps::new(seed),
            shake: Shake::new(seed),
            frames: Frames::new(seed),
            rays: 0,
        }
    }

    /// True pose of the torso in the scene at `time_s`.
    pub fn torso(&self, time_s: f64) -> Isometry3<f64> {
        self.trajectory.pose(time_s)
    }

    /// Data of the next 0.1 s.
    pub fn next_frame(&mut self) -> Frame {
        let mut imu = self.next_imu(self.frames.next_s());
        let scan = self.scan();
        let offset_s = self.model.imu_offset_s;
        while imu.last().is_none_or(|s| s.time_s - offset_s < scan.end_s) {
            imu.push(self.imu_sample());
        }
        Frame { imu, scan }
    }

    /// The IMU's samples up to `end_s` `[s]`, for those who do not wait for a scan's end. The motion must be known 2.5 ms longer.
    pub fn next_imu(&mut self, end_s: f64) -> Vec<ImuSample> {
        let mut out = Vec::new();
        while self.stamps.next_s() <= end_s + 1e-9 {
            out.push(self.imu_sample());
        }
        out
    }

    /// The next scan, once it has ended by `now_s` `[s]`; its samples come from [`Self::next_imu`].
    pub fn next_scan(&mut self, now_s: f64) -> Option<Scan> {
        (self.frames.next_s() <= now_s + 1e-9).then(|| self.scan())
    }

    /// The motion, to be continued.
    pub fn trajectory_mut(&mut self) -> &mut T {
        &mut self.trajectory
    }

    /// Puts another scene around the sensor. The old one, moved: what the LiDAR sees after it was carried off.
    pub fn surround(&mut self, scene: Scene) {
        self.scene = scene;
    }

    fn imu_sample(&mut self) -> ImuSample {
        let time_s = self.stamps.next_s();
        let stamp_s = time_s + self.stamps.take(&self.model) + self.model.imu_offset_s;
        // The mean over a sample's time, as an IMU's low-pass filter gives it.
        let h = 0.5 / IMU_HZ;
        let pose = |t: f64| self.trajectory.pose(t) * self.torso_from_imu;
        let [before, now, after] = [pose(time_s - h), pose(time_s), pose(time_s + h)];
        let accel =
            (after.translation.vector - now.translation.vector * 2.0 + before.translation.vector) / (h * h);
        let force = now.rotation.inverse() * (accel + Vector3::z() * crate::gravity::GRAVITY);
        let gyro = log(&(before.rotation.inverse() * after.rotation)) / (2.0 * h);
        let [gyro_noise, accel_noise] = self.shake.at(time_s, &self.model);
        let gyro = gyro + self.gyro_offset + gyro_noise;
        let range = self.model.accel_range;
        let accel = (force + self.accel_bias) * self.model.accel_scale + accel_noise;
        ImuSample { time_s: stamp_s, gyro, accel: accel.map(|a| a.clamp(-range, range)) }
    }

    fn scan(&mut self) -> Scan {
        let rate = self.model.points_per_s;
        let last = self.frames.take(rate);
        let (start_s, end_s) = (self.rays as f64 / rate, last as f64 / rate);
        let mut points = Vec::with_capacity((last - self.rays) as usize);
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
                let measured = range.map(|range| range + self.noise.normal() * self.model.range_noise_m);
                let (near, far) = (self.model.blind_m, self.model.range_m);
                let returned = measured.filter(|measured| {
                    (near..far).contains(measured) && self.noise.unit() >= self.model.zero_share
                });
                let position = returned.map_or_else(Vector3::zeros, |measured| ray * measured);
                points.push(Point { offset_s: time_s - start_s, position });
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
        assert!((21..=23).contains(&frame.imu.len()), "{}", frame.imu.len());
        let accel: Vector3<f64> = frame.imu.iter().map(|s| s.accel).sum::<Vector3<f64>>() / 21.0;
        assert!((accel.z + 9.8).abs() < 0.35, "{accel}");
        // 20.8 packets of 96 points in 0.1 s, of which the last is not whole.
        assert_eq!(frame.scan.points.len(), 20 * 96);
        let lidar = sensor.torso(0.05) * g1_torso_from_lidar();
        let on_ground = frame
            .scan
            .points
            .iter()
            .filter(|p| (lidar * nalgebra::Point3::from(p.position)).z.abs() < 0.06)
            .count();
        assert!(on_ground > 500, "{on_ground}");
        // Arms hang 0.2 to 0.6 m from the head.
        assert!(frame.scan.points.iter().any(|p| (0.1..0.5).contains(&p.position.norm())));
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
            zero_share: 0.0,
            self_hits: false,
            ..SensorModel::default()
        };
        let hall = || Scene::new(SceneKind::Hall, 5);
        let imu = Config::default().imu_from_lidar;
        let mut sensor = SimulatedMid360::new(hall(), Turning, model, g1_torso_from_lidar(), &imu, 5);
        let scan = sensor.next_frame().scan;
        let mut off: Vec<f64> = scan
            .points
            .iter()
            .filter(|p| p.position != Vector3::zeros())
            .map(|p| {
                let lidar = Turning.pose(p.offset_s) * g1_torso_from_lidar();
                let range = p.position.norm();
                let ray = lidar.rotation * (p.position / range);
                let seen = hall().range(&lidar.translation.vector, &ray, p.offset_s, 0.0);
                seen.map_or(1.0, |seen| (seen - range).abs())
            })
            .collect();
        off.sort_by(f64::total_cmp);
        assert!(off.len() > 50, "{}", off.len());
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
    }

    fn at_rest(model: SensorModel) -> SimulatedMid360<PoseList> {
        let torso = Pose { pos: Vec3([0.0, 0.0, 0.8]), ..Pose::identity() };
        SimulatedMid360::on_g1(Scene::new(SceneKind::Hall, 5), model, &torso, 5).expect("a pose")
    }

    #[test]
    fn frames_are_whole_packets_of_which_29_percent_of_what_was_hit_is_zero() {
        let count = |zero_share| {
            let mut sensor = at_rest(SensorModel { zero_share, ..SensorModel::default() });
            let (mut all, mut zero, mut end_s) = (0, 0, 0.0);
            for _ in 0..10 {
                let scan = sensor.next_frame().scan;
                let points = scan.points.len();
                // 205 to 211 packets: 98.4 to 101.28 ms.
                assert!(points.is_multiple_of(96) && (19_680..=20_256).contains(&points), "{points}");
                assert!((scan.end_s - scan.start_s - points as f64 / 200_000.0).abs() < 1e-9);
                assert!((scan.start_s - end_s).abs() < 1e-12, "no ray is missing");
                end_s = scan.end_s;
                all += points;
                zero += scan.points.iter().filter(|p| p.position == Vector3::zeros()).count();
            }
            zero as f64 / f64::from(all as u32)
        };
        // Too flat on a surface, or too near.
        let missed = count(0.0);
        assert!(missed < 0.1, "{missed}");
        // 200 000 draws: the share is right to 0.1%.
        let zero = count(0.29);
        assert!((zero - (missed + (1.0 - missed) * 0.29)).abs() < 0.004, "{zero}, {missed} missed");
    }

    #[test]
    fn ranges_have_5_mm_of_noise() {
        let model = SensorModel { points_per_s: 20_000.0, self_hits: false, ..SensorModel::default() };
        let mut sensor = at_rest(model);
        let lidar = sensor.torso(0.0) * g1_torso_from_lidar();
        let hall = Scene::new(SceneKind::Hall, 5);
        let squares: Vec<f64> = (0..5)
            .flat_map(|_| sensor.next_frame().scan.points)
            .filter(|p| p.position != Vector3::zeros())
            .filter_map(|p| {
                let range = p.position.norm();
                let seen =
                    hall.range(&lidar.translation.vector, &(lidar.rotation * (p.position / range)), 0.0, 0.0);
                seen.map(|seen| (seen - range).powi(2))
            })
            .collect();
        let deviation = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
        assert!(squares.len() > 5000 && (deviation - 0.005).abs() < 2e-4, "{deviation} m");
    }

    #[test]
    fn a_resting_imu_shows_its_offset_and_less_than_gravity() {
        let model = SensorModel { points_per_s: 1000.0, accel_bias: 0.0, ..SensorModel::default() };
        let mut sensor = at_rest(model);
        let samples = sensor.next_imu(20.0);
        let mean = |of: fn(&ImuSample) -> Vector3<f64>| {
            samples.iter().map(of).sum::<Vector3<f64>>() / samples.len() as f64
        };
        // White noise of 0.27 x 0.017 rad/s in 4000 samples: 0.0001.
        assert!((mean(|s| s.gyro).norm() - 0.046).abs() < 4e-4, "{}", mean(|s| s.gyro));
        // 0.993 x 9.81 m/s^2
        assert!((mean(|s| s.accel).norm() - 9.7413).abs() < 4e-3, "{}", mean(|s| s.accel));
    }
}
