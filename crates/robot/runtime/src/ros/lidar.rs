//! A LiDAR's two topics as what a Mid-360's packets give.

use std::time::{Duration, Instant};

use nalgebra::Vector3;
use paid_lidar::packet::Data;
use paid_lidar::{ImuSample, Point, Scan};
use paid_world::ros::{read_imu, read_points};
use paid_world::{ImuMessage, ScanMessage};

use super::{IMU, POINT_CLOUD, RosReader, RosTopics};
use crate::link::LinkError;

/// Gravity `[m/s^2]`.
const GRAVITY: f64 = 9.81;
/// Samples whose mean gives the unit of acceleration: a tenth of a second.
const TELLING: usize = 20;
/// A mean below this is in multiples of gravity: half way, as factors, between 1 and 9.81.
const LARGEST_IN_G: f64 = 3.1;

/// The unit of a topic's accelerations, inferred from their mean: `sensor_msgs/Imu` has m/s^2 by its definition, the usual driver of a
/// Mid-360 writes multiples of gravity.
#[derive(Clone, Copy, Debug, Default)]
pub struct AccelUnit {
    seen: usize,
    sum: f64,
}

impl AccelUnit {
    /// Takes in a sample; its acceleration in m/s^2, once the unit is known.
    pub fn convert(&mut self, accel: [f64; 3]) -> Option<[f64; 3]> {
        if self.seen < TELLING {
            self.seen += 1;
            self.sum += Vector3::from(accel).norm();
            return None;
        }
        let in_g = self.sum / (TELLING as f64) < LARGEST_IN_G;
        Some(if in_g { accel.map(|x| GRAVITY * x) } else { accel })
    }
}

/// Messages to scans and samples, with times since a second before the first of them: seconds that keep their nanoseconds.
#[derive(Debug, Default)]
struct Clock {
    zero_ns: Option<u64>,
}

impl Clock {
    fn seconds(&mut self, stamp_ns: u64) -> f64 {
        let zero_ns = *self.zero_ns.get_or_insert(stamp_ns.saturating_sub(1_000_000_000));
        (i128::from(stamp_ns) - i128::from(zero_ns)) as f64 * 1e-9
    }

    fn scan(&mut self, scan: &ScanMessage) -> Scan {
        let point = |[x, y, z, offset_s]: &[f64; 4]| Point {
            offset_s: *offset_s,
            position: Vector3::new(*x, *y, *z),
        };
        Scan {
            start_s: self.seconds(scan.start_ns),
            end_s: self.seconds(scan.end_ns),
            points: scan.points.iter().map(point).collect(),
        }
    }

    fn sample(&mut self, imu: &ImuMessage, accel: [f64; 3]) -> ImuSample {
        ImuSample { time_s: self.seconds(imu.stamp_ns), gyro: imu.gyro.into(), accel: accel.into() }
    }
}

/// A LiDAR whose driver publishes `sensor_msgs/PointCloud2` and `sensor_msgs/Imu`, both stamped by one clock.
pub struct LidarTopics {
    points: RosReader,
    imu: RosReader,
    unit: AccelUnit,
    clock: Clock,
}

impl LidarTopics {
    /// Reads the two topics.
    ///
    /// # Errors
    /// If a topic cannot be had.
    pub fn open(topics: &RosTopics, points: &str, imu: &str) -> Result<Self, LinkError> {
        Ok(Self {
            points: topics.reader(points, POINT_CLOUD, false)?,
            imu: topics.reader(imu, IMU, false)?,
            unit: AccelUnit::default(),
            clock: Clock::default(),
        })
    }

    /// For each of the two topics on which nothing has come for a second: who publishes it.
    pub fn silent(&self) -> impl Iterator<Item = String> {
        [&self.points, &self.imu].into_iter().filter_map(RosReader::silent)
    }

    /// The next scan or sample; `None` if nothing came within `patience`.
    ///
    /// # Errors
    /// A message that cannot be used, with what was expected and found; the next ones may be well.
    pub fn next(&mut self, patience: Duration) -> Result<Option<Data>, String> {
        let until = Instant::now() + patience;
        loop {
            // Samples first: a scan waits for those of its time.
            if let Some(bytes) = self.imu.take().map_err(|e| e.to_string())? {
                let imu = read_imu(&bytes).map_err(|e| e.to_string())?.value;
                if let Some(accel) = self.unit.convert(imu.accel) {
                    return Ok(Some(Data::Imu(self.clock.sample(&imu, accel))));
                }
                continue;
            }
            if let Some(bytes) = self.points.take().map_err(|e| e.to_string())? {
                let scan = read_points(&bytes).map_err(|e| e.to_string())?.value;
                return Ok(Some(Data::Scan(self.clock.scan(&scan))));
            }
            if Instant::now() >= until {
                return Ok(None);
            }
            std::thread::sleep(Duration::from_micros(500));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn multiples_of_gravity_are_distinguished_from_meters_by_the_first_samples() {
        for (rest, expected) in [(1.0, 9.81), (9.81, 9.81), (9.6, 9.6)] {
            let mut unit = AccelUnit::default();
            for _ in 0..20 {
                assert_eq!(unit.convert([0.0, 0.0, -rest]), None, "not yet known");
            }
            let [x, y, z] = unit.convert([0.0, 0.0, -rest]).expect("known");
            assert!(x == 0.0 && y == 0.0 && (z + expected).abs() < 1e-12, "{rest}: {z}");
            // A hard step does not change it.
            let [.., z] = unit.convert([0.0, 0.0, -4.0 * rest]).expect("known");
            assert!((z + 4.0 * expected).abs() < 1e-12, "{rest}: {z}");
        }
    }

    #[test]
    fn stamps_of_today_keep_their_nanoseconds() {
        let now_ns = 1_800_000_000_000_000_000;
        let mut clock = Clock::default();
        let scan = ScanMessage {
            start_ns: now_ns,
            end_ns: now_ns + 100_000_001,
            points: vec![[1.0, 2.0, 3.0, 0.05]],
        };
        let scan = clock.scan(&scan);
        let near = |x: f64, expected: f64| (x - expected).abs() < 1e-12;
        assert!(near(scan.start_s, 1.0) && near(scan.end_s, 1.100_000_001), "{scan:?}");
        assert_eq!(scan.points, [Point { offset_s: 0.05, position: Vector3::new(1.0, 2.0, 3.0) }]);
        let imu = ImuMessage { stamp_ns: now_ns - 5_000_000, gyro: [0.1, 0.0, 0.0], accel: [0.0; 3] };
        let sample = clock.sample(&imu, [0.0, 0.0, 9.81]);
        assert!(near(sample.time_s, 0.995) && sample.gyro.x == 0.1 && sample.accel.z == 9.81, "{sample:?}");
    }
}
