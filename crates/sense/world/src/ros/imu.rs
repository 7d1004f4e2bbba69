//! `sensor_msgs/Imu`.

use super::{Stamped, header, named};
use crate::cdr::{CdrReader, CdrWriter, Wrong};
use crate::{ImuMessage, SightError};

/// A sample of an inertial sensor (`sensor_msgs/Imu`): angular velocity and specific force. Orientation and covariances are not used.
///
/// The message's accelerations are in m/s^2 by its definition; the usual driver of a Mid-360 writes multiples of gravity. The numbers are
/// given as they are.
///
/// # Errors
/// If the bytes are no such message, a number is not finite, or the message is marked as without velocity or acceleration.
pub fn read_imu(bytes: &[u8]) -> Result<Stamped<ImuMessage>, SightError> {
    named("IMU sample", imu(bytes))
}

fn imu(bytes: &[u8]) -> Result<Stamped<ImuMessage>, Wrong> {
    let mut cdr = CdrReader::new(bytes)?;
    let (stamp_ns, frame) = header(&mut cdr)?;
    // Orientation and its covariance.
    cdr.f64s::<13>()?;
    let mut measured = |what: &str| -> Result<[f64; 3], Wrong> {
        let value = cdr.f64s::<3>()?;
        // A message without this quantity says so by -1 as the first number of its covariance.
        let [first, ..] = cdr.f64s::<9>()?;
        if first == -1.0 || !value.iter().all(|x| x.is_finite()) {
            return Err((format!("a finite {what}"), format!("{value:?} with covariance {first}")));
        }
        Ok(value)
    };
    let value =
        ImuMessage { stamp_ns, gyro: measured("angular velocity")?, accel: measured("acceleration")? };
    Ok(Stamped { stamp_ns, frame, value })
}

/// A sample as a message, without an orientation.
pub fn write_imu(imu: &ImuMessage, frame: &str) -> Vec<u8> {
    let mut data = CdrWriter::new();
    data.header(imu.stamp_ns, frame);
    // No orientation: its covariance begins with -1.
    data.f64s(&[0.0, 0.0, 0.0, 1.0, -1.0]);
    data.f64s(&[0.0; 8]);
    data.f64s(&imu.gyro);
    data.f64s(&[0.0; 9]);
    data.f64s(&imu.accel);
    data.f64s(&[0.0; 9]);
    data.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A message by hand: stamp 5 s and 7 ns, frame "imu", then orientation, covariances, the two vectors.
    fn by_hand(gyro: [f64; 3], accel: [f64; 3], covariance: f64) -> Vec<u8> {
        let mut out = vec![0, 1, 0, 0];
        for word in [5_u32, 7, 4] {
            out.extend(word.to_le_bytes());
        }
        // 12 bytes, 4 of text: the next number is at 16, a multiple of 8.
        out.extend(b"imu\0");
        let mut numbers = vec![0.0; 13];
        numbers.extend(gyro);
        numbers.extend([0.0; 9]);
        numbers.extend(accel);
        numbers.push(covariance);
        numbers.extend([0.0; 8]);
        out.extend(numbers.iter().flat_map(|x: &f64| x.to_le_bytes()));
        out
    }

    #[test]
    fn a_sample_made_by_hand_is_read() {
        let read = read_imu(&by_hand([0.1, -0.2, 0.3], [0.0, 0.5, -9.81], 0.0)).expect("a sample");
        assert_eq!((read.stamp_ns, read.frame.as_str()), (5_000_000_007, "imu"));
        let expected =
            ImuMessage { stamp_ns: 5_000_000_007, gyro: [0.1, -0.2, 0.3], accel: [0.0, 0.5, -9.81] };
        assert_eq!(read.value, expected);
        assert_eq!(read_imu(&write_imu(&expected, "imu")).expect("a sample"), read);
    }

    #[test]
    fn a_sample_without_acceleration_or_cut_off_is_refused() {
        let error = |bytes: &[u8]| read_imu(bytes).expect_err("refused").to_string();
        assert_eq!(
            error(&by_hand([0.0; 3], [0.0; 3], -1.0)),
            "IMU sample: expected a finite acceleration, found [0.0, 0.0, 0.0] with covariance -1"
        );
        assert!(error(&by_hand([f64::NAN, 0.0, 0.0], [0.0; 3], 0.0)).contains("a finite angular velocity"));
        // Header 16, then 37 numbers: the last one is at 16 + 36 * 8.
        let whole = by_hand([0.0; 3], [0.0; 3], 0.0);
        assert!(error(&whole[..whole.len() - 1]).ends_with("expected 8 bytes at 304, found the end at 311"));
    }
}
