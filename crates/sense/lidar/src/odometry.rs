//! The odometry: IMU samples and scans in, poses out.

mod outcome;

use std::collections::VecDeque;

use nalgebra::{Isometry3, Vector3};

use crate::config::Config;
use crate::data_fault::{DataFault, DataWatch};
use crate::error::LidarError;
use crate::estimate::Estimate;
use crate::filter::Filter;
use crate::health::LostReason;
use crate::history::History;
use crate::imu::ImuSample;
use crate::initializer::Initializer;
use crate::lateness::Lateness;
use crate::map::VoxelMap;
use crate::observability::Sight;
use crate::registration::Registration;
use crate::scan::Scan;
use crate::undistort::Motion;
use crate::update::iterate;
use crate::voxel::VoxelFilter;

/// Scans that wait for their IMU samples; an older one is dropped.
const WAITING_SCANS: usize = 3;
/// A scan that did not come by then is overdue `[s]`.
const OVERDUE_S: f64 = 0.15;
/// IMU samples that wait for their scan: 5 s.
const WAITING_SAMPLES: usize = 1000;

/// Counts of data that could not be used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Dropped {
    /// IMU samples that were not finite.
    pub not_finite: u64,
    /// IMU samples or scans with a time before an earlier one.
    pub backwards: u64,
    /// Scans whose IMU samples did not come.
    pub without_imu: u64,
}

/// Whether the filter follows the scans.
#[derive(Clone, Copy, Debug)]
enum Mode {
    Tracking,
    /// By the clock of the arrivals: since when, and when a scan fitted last (or when it began).
    Lost {
        since_s: f64,
        corrected_s: f64,
        reason: LostReason,
        good: u32,
    },
}

/// LiDAR-inertial odometry.
///
/// Feed it with [`Odometry::push_imu`] and [`Odometry::push_scan`], then take estimates with [`Odometry::poll`].
#[derive(Debug)]
pub struct Odometry {
    config: Config,
    initializer: Initializer,
    filter: Option<Filter>,
    mode: Mode,
    frame: u32,
    map: VoxelMap,
    samples: VecDeque<ImuSample>,
    scans: VecDeque<Scan>,
    last_stamp_s: Option<f64>,
    last_scan_end_s: Option<f64>,
    now_s: f64,
    last_output_s: Option<f64>,
    last_scan_s: Option<f64>,
    lateness: Lateness,
    data: DataWatch,
    fault: Option<LostReason>,
    usual_share: Option<f64>,
    usual_off_ground: Option<f64>,
    /// What the fitting scans see of translation.
    sight: Sight,
    dropped: Dropped,
    history: History,
    // Memory that is kept from scan to scan.
    motion: Motion,
    voxels: VoxelFilter,
    registration: Registration,
    undistorted: Vec<Vector3<f64>>,
    points: Vec<Vector3<f64>>,
}

impl Odometry {
    /// An odometry that waits for the sensor to stand still.
    ///
    /// # Errors
    ///
    /// A setting makes no sense.
    pub fn new(config: Config) -> Result<Self, LidarError> {
        config.check()?;
        Ok(Self {
            map: VoxelMap::new(config.map_voxel_m, config.map_half_width_m, config.map_capacity),
            config,
            initializer: Initializer::default(),
            filter: None,
            mode: Mode::Tracking,
            frame: 0,
            samples: VecDeque::new(),
            scans: VecDeque::new(),
            last_stamp_s: None,
            last_scan_end_s: None,
            now_s: 0.0,
            last_output_s: None,
            last_scan_s: None,
            lateness: Lateness::default(),
            data: DataWatch::default(),
            fault: None,
            usual_share: None,
            usual_off_ground: None,
            sight: Sight::default(),
            dropped: Dropped::default(),
            history: History::default(),
            motion: Motion::default(),
            voxels: VoxelFilter::default(),
            registration: Registration::default(),
            undistorted: Vec::new(),
            points: Vec::new(),
        })
    }

    /// Starts again: empty map, new odometry frame, waits for the sensor to stand still.
    pub fn restart(&mut self) {
        self.map =
            VoxelMap::new(self.config.map_voxel_m, self.config.map_half_width_m, self.config.map_capacity);
        self.initializer = Initializer::default();
        self.filter = None;
        self.mode = Mode::Tracking;
        self.frame += 1;
        self.samples.clear();
        self.scans.clear();
        self.last_stamp_s = None;
        self.last_scan_end_s = None;
        self.lateness = Lateness::default();
        self.data = DataWatch::default();
        self.fault = None;
        self.usual_share = None;
        self.usual_off_ground = None;
        self.sight = Sight::default();
        self.history = History::default();
    }

    /// Settings.
    #[must_use]
    pub fn config(&self) -> &Config {
        &self.config
    }

    /// The map.
    #[must_use]
    pub fn map(&self) -> &VoxelMap {
        &self.map
    }

    /// Counts of data that could not be used.
    #[must_use]
    pub fn dropped(&self) -> Dropped {
        self.dropped
    }

    /// What is wrong with the data that come now.
    #[must_use]
    pub fn data_fault(&self) -> Option<DataFault> {
        self.data.fault()
    }

    /// Time of the newest sample of the IMU `[s]`: [`Odometry::pose_at`] knows the pose up to there, once it tracks.
    #[must_use]
    pub fn newest_s(&self) -> Option<f64> {
        self.last_stamp_s
    }

    /// Takes a sample of the IMU that came at `arrival_s` `[s]`, by this machine's clock (any zero).
    pub fn push_imu(&mut self, sample: ImuSample, arrival_s: f64) {
        if !sample.is_finite() {
            self.dropped.not_finite += 1;
            return;
        }
        self.data.imu(sample.time_s, arrival_s);
        if let Some(last) = self.last_stamp_s {
            if sample.time_s <= last {
                self.dropped.backwards += 1;
                // The same stamp twice is a doubled sample and harmless.
                if sample.time_s < last {
                    self.note(LostReason::TimeBackwards { by_s: last - sample.time_s });
                }
                return;
            }
            let gap_s = sample.time_s - last;
            if gap_s > self.config.imu_gap_s {
                self.note(LostReason::ImuGap { gap_s });
            }
        }
        self.last_stamp_s = Some(sample.time_s);
        let by_s = self.lateness.push(sample.time_s, arrival_s);
        if by_s > self.config.late_s {
            self.note(LostReason::Late { by_s });
        }
        if self.filter.is_none() {
            if let Some(start) = self.initializer.push(sample, &self.config) {
                self.filter = Some(Filter::new(start));
                self.fault = None;
            }
            return;
        }
        if self.samples.len() >= WAITING_SAMPLES {
            self.predict_without_scan();
        }
        self.samples.push_back(sample);
    }

    /// Takes a scan that came at `arrival_s` `[s]`, by this machine's clock.
    pub fn push_scan(&mut self, scan: Scan, arrival_s: f64) {
        self.data.scan(&scan, arrival_s);
        if !(scan.start_s.is_finite() && scan.end_s.is_finite() && scan.end_s > scan.start_s) {
            self.dropped.not_finite += 1;
            return;
        }
        if let Some(last) = self.last_scan_end_s
            && scan.end_s <= last
        {
            self.dropped.backwards += 1;
            self.note(LostReason::TimeBackwards { by_s: last - scan.end_s });
            return;
        }
        self.last_scan_end_s = Some(scan.end_s);
        let by_s = self.lateness.push(scan.end_s, arrival_s);
        if by_s > self.config.late_s {
            self.note(LostReason::Late { by_s });
        }
        if self.scans.len() >= WAITING_SCANS {
            self.scans.pop_front();
            self.dropped.without_imu += 1;
            self.note(LostReason::ImuGap { gap_s: scan.end_s - self.last_stamp_s.unwrap_or(scan.start_s) });
        }
        self.scans.push_back(scan);
    }

    /// The next estimate, if there is one at `now_s` `[s]`, by the clock of the arrivals. Call it until it returns `None`. If the sensor
    /// falls silent it reports that, some four times a second.
    pub fn poll(&mut self, now_s: f64) -> Option<Estimate> {
        self.now_s = now_s;
        let newest = self.samples.back().map(|s| s.time_s);
        let ready = match (&self.filter, self.scans.front()) {
            (None, Some(_)) => true,
            (Some(filter), Some(scan)) => {
                scan.end_s <= filter.time_s() || newest.is_some_and(|newest| newest >= scan.end_s)
            }
            (_, None) => false,
        };
        if ready && let Some(scan) = self.scans.pop_front() {
            self.last_output_s = Some(now_s);
            self.last_scan_s = Some(now_s);
            return Some(self.process(scan));
        }
        let last = *self.last_output_s.get_or_insert(now_s);
        // A fault is reported when the next scan is overdue, plain silence later.
        let patience_s = if self.fault.is_some() { OVERDUE_S } else { self.config.silence_s };
        if now_s - last <= patience_s {
            return None;
        }
        self.last_output_s = Some(now_s);
        let since_s = now_s - *self.last_scan_s.get_or_insert(last);
        self.note(if self.scans.is_empty() {
            LostReason::NoScan { silent_s: since_s }
        } else {
            LostReason::ImuGap { gap_s: since_s }
        });
        self.predict_without_scan();
        Some(self.lose(0.0))
    }

    /// Pose of the body at `time_s` (sensor's clock), in the last second or up to the newest IMU sample: for a camera, the moment of
    /// its exposure. `None` outside of that or before the start.
    #[must_use]
    pub fn pose_at(&self, time_s: f64) -> Option<Isometry3<f64>> {
        let filter = self.filter.as_ref()?;
        let pose = if time_s <= filter.time_s() {
            self.history.pose_at(time_s)?
        } else {
            filter.ahead(&self.samples, time_s)?
        };
        Some(pose * self.imu_from_body(filter))
    }

    /// Keeps the first fault since the last output.
    fn note(&mut self, reason: LostReason) {
        self.fault.get_or_insert(reason);
    }

    fn imu_from_body(&self, filter: &Filter) -> Isometry3<f64> {
        filter.state.imu_from_lidar() * self.config.body_from_lidar.inverse()
    }

    /// Uses up waiting samples although no scan came.
    fn predict_without_scan(&mut self) {
        if let Some(filter) = &mut self.filter
            && let Some(newest) = self.samples.back().map(|s| s.time_s)
        {
            self.motion.clear();
            filter.predict(&mut self.samples, newest, &self.config, &mut self.motion);
        }
    }

    fn process(&mut self, mut scan: Scan) -> Estimate {
        let Some(filter) = &mut self.filter else {
            return self.waiting(scan.end_s);
        };
        if scan.end_s <= filter.time_s() {
            // Its time is used up: it came with or before the samples of the start, or after a silence.
            self.dropped.backwards += 1;
            return self.output(scan.end_s, 0.0, None);
        }
        self.motion.clear();
        filter.predict(&mut self.samples, scan.end_s, &self.config, &mut self.motion);
        // What did not come back is at the origin; freed of the motion it would be a point beside it.
        scan.points.retain(|p| p.position != Vector3::zeros());
        self.motion.undistort(&scan.points, scan.start_s, &filter.state, &mut self.undistorted);
        let (near, far) = (self.config.blind_m.powi(2), self.config.range_m.powi(2));
        let usable = self.undistorted.iter().copied().filter(|p| {
            let square = p.norm_squared();
            square > near && square < far
        });
        self.voxels.filter(usable, self.config.scan_voxel_m, &mut self.points);

        if self.map.is_empty() && self.points.len() >= self.config.min_points {
            self.remember();
            self.history.push(&self.motion, scan.end_s, &Isometry3::identity());
            return self.output(scan.end_s, 0.0, None);
        }
        if self.points.len() < self.config.min_points {
            self.note(LostReason::TooFewPoints { found: self.points.len(), needed: self.config.min_points });
            return self.lose(0.0);
        }
        let before = self.sight;
        let corrected = iterate(
            &filter.state,
            filter.covariance(),
            self.config.plane_variance,
            self.config.iterations,
            |state, iteration| {
                self.registration.linearize(&self.points, &self.map, state, iteration, &before, &self.config)
            },
        );
        match corrected {
            Some(posterior) => self.judge(&scan, posterior),
            None => {
                self.note(LostReason::Diverged);
                self.lose(0.0)
            }
        }
    }

    /// Puts the thinned scan into the map.
    fn remember(&mut self) {
        let Some(filter) = &self.filter else { return };
        let odometry_from_lidar = filter.state.odometry_from_imu() * filter.state.imu_from_lidar();
        self.map.follow(&odometry_from_lidar.translation.vector);
        for point in &self.points {
            self.map.insert(odometry_from_lidar.rotation * point + odometry_from_lidar.translation.vector);
        }
    }
}
