//! LiDAR-inertial odometry: where the sensor is, from its scans and its IMU, without any map made before.
//!
//! The method is that of FAST-LIO2's papers (Xu and others, 2022): an iterated error-state Kalman filter on the manifold of 23 degrees of
//! freedom, points freed of the sensor's own motion, planes through the five nearest points of a voxel map that moves with the sensor.
//! With the pose it reports how far the pose can be trusted ([`Health`]): it starts only from standing still, names the direction that
//! a corridor hides, and reports a covered, carried off or late sensor within three scans.
//!
//! - [`Odometry`]: samples and scans in, [`Estimate`]s out.
//! - [`packet`]: UDP packets of a Livox Mid-360, read and written.
//! - [`sim`]: a simulated Mid-360 on a walking, kicking robot, and the measurement behind `paid perceive odometry`.
//!
//! Frames: "odometry" has z up, its origin at the IMU's place at the start, x where the IMU's x axis pointed, seen from above. "LiDAR" and
//! "IMU" are those of the sensor as mounted: if it hangs upside down, so do both, and nothing is to be turned beforehand.
//!
//! A walking robot in a hall, for two seconds:
//!
//! ```
//! use paid_lidar::sim::{Scene, SceneKind, SensorModel, SimulatedMid360, Walk};
//! use paid_lidar::{Config, Odometry, g1_torso_from_lidar};
//!
//! let config = Config::g1();
//! let mut sensor = SimulatedMid360::new(
//!     Scene::new(SceneKind::Hall, 1),
//!     Walk::new(SceneKind::Hall, 1),
//!     SensorModel { points_per_s: 20_000.0, ..SensorModel::default() },
//!     g1_torso_from_lidar(),
//!     &config.imu_from_lidar,
//!     1,
//! );
//! let mut odometry = Odometry::new(config)?;
//! let mut last = None;
//! for _ in 0..20 {
//!     let frame = sensor.next_frame();
//!     let arrival_s = frame.scan.end_s;
//!     for sample in frame.imu {
//!         odometry.push_imu(sample, sample.time_s);
//!     }
//!     odometry.push_scan(frame.scan, arrival_s);
//!     while let Some(estimate) = odometry.poll(arrival_s) {
//!         last = Some(estimate);
//!     }
//! }
//! let last = last.expect("ten scans a second");
//! assert!(last.health.is_tracking(), "{}", last.health);
//! # Ok::<(), paid_lidar::LidarError>(())
//! ```

mod config;
mod data_fault;
mod error;
mod estimate;
mod filter;
mod gravity;
mod health;
mod history;
mod imu;
mod initializer;
mod lateness;
mod map;
mod observability;
mod odometry;
pub mod packet;
mod plane;
mod propagate;
mod registration;
mod scan;
pub mod sim;
mod so3;
mod state;
mod undistort;
mod update;
mod voxel;

pub use config::{Config, g1_torso_from_lidar};
pub use data_fault::DataFault;
pub use error::LidarError;
pub use estimate::Estimate;
pub use health::{Health, LostReason, NotStill};
pub use history::{isometry, stamped};
pub use imu::ImuSample;
pub use map::VoxelMap;
pub use odometry::{Dropped, Odometry};
pub use propagate::ImuNoise;
pub use scan::{Point, Scan};
