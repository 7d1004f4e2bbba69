//! ROS 2's messages of a camera, a LiDAR and an odometry, as they are on the wire: CDR with its header of four bytes.
//!
//! What cannot be used is refused with what was expected and found. The usual driver of a D435i publishes `rgb8` images, depths as `16UC1`
//! aligned to them, and a `CameraInfo` with each; the usual driver of a Mid-360 publishes a `PointCloud2` with a time for each point, and `Imu`
//! samples in multiples of gravity.

mod camera;
mod imu;
mod odometry;
mod picture;
mod points;

pub use camera::{read_camera_info, write_camera_info};
pub use imu::{read_imu, write_imu};
pub use odometry::{read_odometry, write_odometry};
pub use picture::{read_color, read_depth, write_color, write_depth};
pub use points::{read_points, write_points};

use crate::SightError;
use crate::cdr::{CdrReader, Wrong};

/// Nanoseconds of a second.
const SECOND_NS: u64 = 1_000_000_000;

/// A message's content with its stamp and frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Stamped<T> {
    /// The header's time, by the publisher's clock `[ns]`.
    pub stamp_ns: u64,
    /// The header's frame.
    pub frame: String,
    /// The rest.
    pub value: T,
}

fn named<T>(what: &'static str, result: Result<T, Wrong>) -> Result<T, SightError> {
    result.map_err(|(expected, found)| SightError::Message { what, expected, found })
}

/// Reads a header. A stamp of zero is a driver that sets none.
fn header(cdr: &mut CdrReader<'_>) -> Result<(u64, String), Wrong> {
    let (stamp_ns, frame) = cdr.header()?;
    if stamp_ns < SECOND_NS {
        return Err(("a stamp".to_owned(), format!("{stamp_ns} ns")));
    }
    Ok((stamp_ns, frame))
}

#[cfg(test)]
mod tests {
    use paid_vision::{ColorImage, Intrinsics};

    use super::*;
    use crate::PoseMessage;

    #[test]
    fn what_is_written_is_read_again() {
        let color = ColorImage::new(2, 1, (0..6).collect()).expect("whole");
        let read = read_color(&write_color(9_000_000_001, &color)).expect("an image");
        assert_eq!(
            read,
            Stamped { stamp_ns: 9_000_000_001, frame: "camera_color_optical_frame".to_owned(), value: color }
        );
        let camera = Intrinsics::g1_color();
        assert_eq!(
            read_camera_info(&write_camera_info(9_000_000_001, &camera)).expect("a camera").value,
            camera
        );
        let pose =
            PoseMessage { stamp_ns: 3_000_000_000, position: [1.0, -2.0, 0.8], quat: [0.6, 0.0, 0.0, 0.8] };
        let (read, child) = read_odometry(&write_odometry(&pose, "odom", "torso_link")).expect("a pose");
        assert_eq!((read.value, read.frame.as_str(), child.as_str()), (pose, "odom", "torso_link"));
        let none = PoseMessage { quat: [0.0; 4], ..pose };
        assert!(read_odometry(&write_odometry(&none, "odom", "b")).is_err());
    }
}
