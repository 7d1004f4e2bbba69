//! LiDAR-inertial odometry.

mod config;
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
pub use error::LidarError;
pub use estimate::Estimate;
pub use health::{Health, LostReason, NotStill};
pub use imu::ImuSample;
pub use odometry::{Dropped, Odometry};
pub use propagate::ImuNoise;
pub use scan::{Point, Scan};
