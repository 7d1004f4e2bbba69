//! What is wrong with the data of LiDAR and IMU themselves, whatever becomes of the pose.

use core::fmt;

use crate::scan::Scan;

/// A scan of fewer points may have one time by chance.
const LEAST_POINTS: usize = 100;
/// Scans without a sample of the IMU between them: half a second.
const SCANS_ALONE: u32 = 5;
/// Stamps of one clock are not farther apart than a scan is on its way `[s]`.
const APART_S: f64 = 0.15;
/// The fastest of this many scans shows how far apart the clocks are.
const SCANS_OF_CLOCKS: u32 = 10;

/// What is wrong with the data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DataFault {
    /// Scans come, but no samples of the IMU.
    NoImu,
    /// The points of a scan all have the same time.
    OneTime {
        /// Points of the scan.
        points: usize,
    },
    /// Scans and samples are stamped by clocks that are apart.
    TwoClocks {
        /// By how much the LiDAR's is ahead `[s]`.
        ahead_s: f64,
    },
}

impl fmt::Display for DataFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoImu => {
                f.write_str("scans come, but no samples of the IMU: without them there is no odometry")
            }
            Self::OneTime { points } => write!(
                f,
                "all {points} points of a scan have the same time, so the sensor's motion cannot be removed from it: expected each \
                 point's own time"
            ),
            Self::TwoClocks { ahead_s } => {
                let side = if *ahead_s > 0.0 { "ahead of" } else { "behind" };
                write!(
                    f,
                    "the scans' stamps are {:.2} s {side} the IMU's: expected both by one clock",
                    ahead_s.abs()
                )
            }
        }
    }
}

/// Watches the data as they come.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct DataWatch {
    /// Scans since the last sample.
    alone: u32,
    one_time: Option<usize>,
    /// Stamp less arrival of the last sample `[s]`.
    imu_s: Option<f64>,
    /// The most that a scan's clock was ahead of the IMU's `[s]`, and of how many scans.
    ahead_s: f64,
    scans: u32,
    apart_s: Option<f64>,
}

impl DataWatch {
    pub fn imu(&mut self, stamp_s: f64, arrival_s: f64) {
        (self.alone, self.imu_s) = (0, Some(stamp_s - arrival_s));
    }

    pub fn scan(&mut self, scan: &Scan, arrival_s: f64) {
        self.alone += 1;
        if scan.points.len() >= LEAST_POINTS {
            let first = scan.points[0].offset_s;
            self.one_time =
                scan.points.iter().all(|point| point.offset_s == first).then_some(scan.points.len());
        }
        let Some(imu_s) = self.imu_s else { return };
        let ahead_s = scan.end_s - arrival_s - imu_s;
        self.ahead_s = if self.scans == 0 { ahead_s } else { self.ahead_s.max(ahead_s) };
        self.scans += 1;
        if self.scans >= SCANS_OF_CLOCKS {
            self.scans = 0;
            self.apart_s = Some(self.ahead_s).filter(|apart| apart.abs() > APART_S);
        }
    }

    pub fn fault(&self) -> Option<DataFault> {
        if self.alone >= SCANS_ALONE {
            return Some(DataFault::NoImu);
        }
        let clocks = self.apart_s.map(|ahead_s| DataFault::TwoClocks { ahead_s });
        clocks.or_else(|| self.one_time.map(|points| DataFault::OneTime { points }))
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::scan::Point;

    /// What is said after two seconds of 10 scans and 200 samples a second. The LiDAR's clock is ahead by `ahead_s`; `step_s` lies between
    /// two points; the last second is without the IMU if it `ends`.
    fn said(ahead_s: f64, step_s: f64, ends: bool) -> Option<String> {
        let mut watch = DataWatch::default();
        for k in 1..=400_u32 {
            let now_s = f64::from(k) * 0.005;
            if !ends || k <= 200 {
                // A sample takes 3 ms, by a clock that began 100 s before this machine's.
                watch.imu(now_s + 100.0 - 0.003, now_s);
            }
            if k.is_multiple_of(20) {
                let point = |i: u32| Point { offset_s: f64::from(i) * step_s, position: Vector3::x() };
                let end_s = now_s + 100.0 - 0.02 + ahead_s;
                let scan = Scan { start_s: end_s - 0.1, end_s, points: (0..200).map(point).collect() };
                // Every other one was on its way for a quarter of a second more.
                watch.scan(&scan, now_s + if k.is_multiple_of(40) { 0.25 } else { 0.0 });
            }
        }
        watch.fault().map(|fault| fault.to_string())
    }

    #[test]
    fn one_time_for_all_points_two_clocks_and_a_missing_imu_are_told_and_late_scans_are_not() {
        assert_eq!(said(0.0, 0.0005, false), None);
        let one_time = "all 200 points of a scan have the same time, so the sensor's motion cannot be removed from it: expected each \
                        point's own time";
        assert_eq!(said(0.0, 0.0, false).as_deref(), Some(one_time));
        // Of the 20 ms on the way 3 are the sample's too.
        for (ahead_s, expected) in [
            (0.517, "the scans' stamps are 0.50 s ahead of the IMU's: expected both by one clock"),
            (-0.283, "the scans' stamps are 0.30 s behind the IMU's: expected both by one clock"),
        ] {
            assert_eq!(said(ahead_s, 0.0005, false).as_deref(), Some(expected));
        }
        let no_imu = "scans come, but no samples of the IMU: without them there is no odometry";
        assert_eq!(said(0.0, 0.0005, true).as_deref(), Some(no_imu));
    }
}
