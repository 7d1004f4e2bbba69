//! The virtual robot's Mid-360, which follows the torso through a scene.

use nalgebra::Vector3;
use paid_lanes::rng::Rng;
use paid_lidar::sim::{
    Frame, PacketWriter, Pattern, PoseList, Scene, SceneKind, SensorModel, SimulatedMid360, Trajectory,
};
use paid_lidar::{ImuSample, Point, Scan, g1_torso_from_lidar};
use paid_track::Pose;

/// Rays of one pose of the sensor: 0.1 ms, in which a torso that runs and turns moves a ray's end by a millimeter.
const RAYS_A_POSE: u64 = 20;

use crate::TwinError;
/// Poses are kept this long `[s]`.
const KEPT_S: f64 = 0.3;

/// A Mid-360 in the virtual robot's head.
#[derive(Debug)]
pub struct SimLidar {
    sensor: SimulatedMid360<PoseList>,
    writer: PacketWriter,
    scene: Scene,
    model: SensorModel,
    noise: Rng,
    /// Rays that were sent as packets.
    rays: u64,
}

impl SimLidar {
    /// Samples and points are known this much later than they were measured `[s]`: a sample is the mean over its time.
    pub const BEHIND_S: f64 = 0.005;

    /// In these surroundings, at this many points a second. The robot begins at `start_m` of them `[m]`, with its torso there in its own
    /// world.
    ///
    /// # Errors
    /// If the pose is none.
    pub fn new(
        surroundings: SceneKind,
        start_m: [f64; 2],
        points_per_s: f64,
        torso: &Pose,
        seed: u64,
    ) -> Result<Self, TwinError> {
        let scene = Scene::new(surroundings, seed).moved(&Vector3::new(-start_m[0], -start_m[1], 0.0));
        let model = SensorModel { points_per_s, ..SensorModel::default() };
        let sensor =
            SimulatedMid360::on_g1(scene.clone(), model, torso, seed).map_err(TwinError::simulation)?;
        let (writer, noise) = (PacketWriter::default(), Rng::new(seed, 0, 0x0B03));
        Ok(Self { sensor, writer, scene, model, noise, rays: 0 })
    }

    /// The torso at a time of the sensor's clock `[s]`, every 2 ms.
    pub fn torso(&mut self, at_s: f64, torso: &Pose) {
        self.sensor.torso_at(at_s, torso);
    }

    /// Samples and the scan that are ready at `now_s` `[s]`, 5 ms after they were measured.
    pub fn measured(&mut self, now_s: f64) -> (Vec<ImuSample>, Option<Scan>) {
        if now_s < Self::BEHIND_S {
            return (Vec::new(), None);
        }
        let samples = self.sensor.next_imu(now_s - Self::BEHIND_S);
        let scan = self.sensor.next_scan(now_s - Self::BEHIND_S);
        if scan.is_some() {
            self.sensor.trajectory_mut().forget_before(now_s - KEPT_S);
        }
        (samples, scan)
    }

    /// The same as packets of the device, those of samples before those of points: a real one sends points as they come, not scan by scan. The
    /// robot's own arms are not among them.
    pub fn packets(&mut self, now_s: f64) -> Vec<Vec<u8>> {
        if now_s < Self::BEHIND_S {
            return Vec::new();
        }
        let end_s = now_s - Self::BEHIND_S;
        let imu = self.sensor.next_imu(end_s);
        let rate = self.model.points_per_s;
        let (pattern, start_s) = (Pattern { points_per_s: rate }, self.rays as f64 / rate);
        let mut points = Vec::new();
        let last = (end_s * rate) as u64;
        while self.rays < last {
            let upto = (self.rays + RAYS_A_POSE).min(last);
            let lidar = self.sensor.trajectory_mut().pose(self.rays as f64 / rate) * g1_torso_from_lidar();
            for index in self.rays..upto {
                let (time_s, ray) = (index as f64 / rate, pattern.ray(index));
                let (origin, along) = (lidar.translation.vector, lidar.rotation * ray);
                let Some(range) = self.scene.range(&origin, &along, time_s, self.noise.unit()) else {
                    continue;
                };
                let measured = range + self.noise.normal() * self.model.range_noise_m;
                if measured > self.model.blind_m && measured < self.model.range_m {
                    points.push(Point { offset_s: time_s - start_s, position: ray * measured });
                }
            }
            self.rays = upto;
        }
        self.sensor.trajectory_mut().forget_before(now_s - KEPT_S);
        self.writer.packets(&Frame { imu, scan: Scan { start_s, end_s, points } })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use paid_lanes::Vec3;
    use paid_lidar::Config;
    use paid_lidar::packet::{Assembler, Data};
    use paid_runtime::eyes::TorsoEyes;
    use paid_world::OdometryState;

    #[test]
    fn its_packets_are_those_of_a_device_and_odometry_follows_them() {
        let torso = |t: f64| Pose { pos: Vec3([(0.4 * (t - 1.0)).max(0.0), 0.0, 0.8]), ..Pose::identity() };
        let mut lidar =
            SimLidar::new(SceneKind::Hall, [-8.0, 0.0], 200_000.0, &torso(0.0), 3).expect("a sensor");
        let (mut assembler, mut eyes) =
            (Assembler::default(), TorsoEyes::lidar(Config::g1(), 0.0).expect("a setup"));
        let (mut first, mut last) = (None, None);
        for k in 1..1100_u64 {
            let now_s = 0.002 * k as f64;
            lidar.torso(now_s, &torso(now_s));
            if !k.is_multiple_of(5) {
                continue;
            }
            for packet in lidar.packets(now_s) {
                let at_ns = 2_000_000 * k;
                match assembler.push(&packet, std::net::IpAddr::from([127, 0, 0, 1])) {
                    Some(Data::Imu(sample)) => {
                        let fix = eyes.imu(sample, at_ns);
                        first = first.or(fix);
                        last = fix.or(last);
                    }
                    Some(Data::Scan(scan)) => eyes.scan(scan, at_ns),
                    None => {}
                }
            }
        }
        let counts = assembler.counts();
        assert_eq!((counts.damaged, counts.lost, counts.doubled, counts.wrong_time), (0, 0, 0, 0));
        assert_eq!(eyes.state(), OdometryState::Tracking);
        let (first, last) = (first.expect("a pose"), last.expect("a pose"));
        // It went on until the last sample.
        let gone = torso(last.at_ns as f64 * 1e-9).pos.x();
        assert!(
            (last.pose.position[0] - first.pose.position[0] - gone).abs() < 0.04 && gone > 0.4,
            "{last:?}"
        );
    }
}
