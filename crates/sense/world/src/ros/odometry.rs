//! `nav_msgs/Odometry`.

use super::{Stamped, header, named};
use crate::cdr::{CdrReader, CdrWriter, Wrong};
use crate::{PoseMessage, SightError};

/// A pose (`nav_msgs/Odometry`); the value's `stamp_ns` is the header's, and the second text is the child's frame.
///
/// # Errors
/// If the bytes are no such message, a number is not finite, or the quaternion is none.
pub fn read_odometry(bytes: &[u8]) -> Result<(Stamped<PoseMessage>, String), SightError> {
    named("odometry", odometry(bytes))
}

fn odometry(bytes: &[u8]) -> Result<(Stamped<PoseMessage>, String), Wrong> {
    let mut cdr = CdrReader::new(bytes)?;
    let (stamp_ns, frame) = header(&mut cdr)?;
    let child = cdr.string()?;
    let position = cdr.f64s::<3>()?;
    let [x, y, z, w] = cdr.f64s()?;
    let quat = [w, x, y, z];
    let norm2: f64 = quat.iter().map(|q| q * q).sum();
    if !position.iter().all(|p| p.is_finite()) || !(0.98..1.02).contains(&norm2) {
        let expected = "a finite place and a unit quaternion".to_owned();
        return Err((expected, format!("{position:?} m, {quat:?}")));
    }
    let value = PoseMessage { stamp_ns, position, quat };
    Ok((Stamped { stamp_ns, frame, value }, child))
}

/// A pose as a message: `child` in `frame`.
pub fn write_odometry(pose: &PoseMessage, frame: &str, child: &str) -> Vec<u8> {
    let mut data = CdrWriter::new();
    data.header(pose.stamp_ns, frame);
    data.string(child);
    let [w, x, y, z] = pose.quat;
    data.f64s(&pose.position);
    data.f64s(&[x, y, z, w]);
    // Covariance of the pose, the twist, and its covariance.
    data.f64s(&[0.0; 36]);
    data.f64s(&[0.0; 42]);
    data.finish()
}
