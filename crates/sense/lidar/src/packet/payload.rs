//! Points and IMU samples in packets.

use nalgebra::Vector3;

use crate::gravity::GRAVITY;
use crate::imu::ImuSample;
use crate::packet::header::{DataType, Header, PacketError};

/// One return as it is in a packet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RawPoint {
    /// Time since the packet's time stamp `[s]`.
    pub offset_s: f64,
    /// Position in the LiDAR frame `[m]`; zero where nothing came back.
    pub position: Vector3<f64>,
    /// Reflectivity, 0 to 255.
    pub reflectivity: u8,
    /// The sensor's doubts about the point (rain, edges), in pairs of bits; 0 is none.
    pub tag: u8,
}

/// What a packet holds.
#[derive(Clone, Debug, PartialEq)]
pub enum Payload {
    /// Angular velocity `[rad/s]` and acceleration `[m/s^2]`. Its time is the header's, left 0 here.
    Imu(ImuSample),
    /// Returns.
    Points(Vec<RawPoint>),
}

/// Reads a packet: header and payload, CRC checked.
///
/// # Errors
///
/// See [`PacketError`].
pub fn read(packet: &[u8]) -> Result<(Header, Payload), PacketError> {
    let (header, data) = Header::read(packet)?;
    let payload = match header.data_type {
        DataType::Imu => Payload::Imu(imu(data)?),
        kind => {
            let items = data.chunks_exact(kind.item_bytes());
            let steps = f64::from(header.dot_num.saturating_sub(1).max(1));
            let step_s = f64::from(header.time_interval) * 1e-7 / steps;
            Payload::Points(items.enumerate().map(|(i, item)| point(kind, item, i as f64 * step_s)).collect())
        }
    };
    Ok((header, payload))
}

/// Writes a packet; the header's kind and number of points follow from `payload` where it is an IMU sample, and its number of points
/// where it holds points. Positions beyond the kind's range are clamped to it.
#[must_use]
pub fn write(header: &Header, payload: &Payload) -> Vec<u8> {
    let mut data = Vec::new();
    let mut header = *header;
    match payload {
        Payload::Imu(sample) => {
            header.data_type = DataType::Imu;
            header.dot_num = 1;
            for x in sample.gyro.iter().copied().chain(sample.accel.iter().map(|a| a / GRAVITY)) {
                data.extend_from_slice(&(x as f32).to_le_bytes());
            }
        }
        Payload::Points(points) => {
            header.dot_num = u16::try_from(points.len()).unwrap_or(u16::MAX);
            for point in points {
                put(header.data_type, point, &mut data);
            }
        }
    }
    header.write(&data)
}

fn imu(data: &[u8]) -> Result<ImuSample, PacketError> {
    let mut values = [0.0; 6];
    for (value, bytes) in values.iter_mut().zip(data.chunks_exact(4)) {
        *value = f64::from(f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]));
    }
    let [a, b, c, x, y, z] = values;
    let sample =
        ImuSample { time_s: 0.0, gyro: Vector3::new(a, b, c), accel: Vector3::new(x, y, z) * GRAVITY };
    if sample.is_finite() { Ok(sample) } else { Err(PacketError::NotFinite) }
}

fn point(kind: DataType, item: &[u8], offset_s: f64) -> RawPoint {
    let long =
        |at: usize| f64::from(i32::from_le_bytes([item[at], item[at + 1], item[at + 2], item[at + 3]]));
    let short = |at: usize| [item[at], item[at + 1]];
    let position = match kind {
        DataType::CartesianMm => Vector3::new(long(0), long(4), long(8)) * 1e-3,
        DataType::CartesianCm => {
            let axis = |at| f64::from(i16::from_le_bytes(short(at)));
            Vector3::new(axis(0), axis(2), axis(4)) * 1e-2
        }
        _ => {
            let depth = f64::from(u32::from_le_bytes([item[0], item[1], item[2], item[3]])) * 1e-3;
            let angle = |at| (f64::from(u16::from_le_bytes(short(at))) * 0.01).to_radians();
            let (zenith, azimuth) = (angle(4), angle(6));
            let across = zenith.sin();
            Vector3::new(across * azimuth.cos(), across * azimuth.sin(), zenith.cos()) * depth
        }
    };
    let end = item.len();
    RawPoint { offset_s, position, reflectivity: item[end - 2], tag: item[end - 1] }
}

fn put(kind: DataType, point: &RawPoint, data: &mut Vec<u8>) {
    let p = point.position;
    match kind {
        // Not a kind of points: nothing to put.
        DataType::Imu => return,
        DataType::CartesianMm => {
            for x in p.iter() {
                data.extend_from_slice(&((x * 1e3).round() as i32).to_le_bytes());
            }
        }
        DataType::CartesianCm => {
            for x in p.iter() {
                data.extend_from_slice(&((x * 1e2).round() as i16).to_le_bytes());
            }
        }
        DataType::Spherical => {
            let depth = p.norm();
            let zenith = if depth > 0.0 { (p.z / depth).clamp(-1.0, 1.0).acos() } else { 0.0 };
            let azimuth = p.y.atan2(p.x).rem_euclid(core::f64::consts::TAU);
            data.extend_from_slice(&((depth * 1e3).round() as u32).to_le_bytes());
            for angle in [zenith, azimuth] {
                data.extend_from_slice(&((angle.to_degrees() * 100.0).round() as u16).to_le_bytes());
            }
        }
    }
    data.extend_from_slice(&[point.reflectivity, point.tag]);
}

#[cfg(test)]
pub(crate) mod tests {
    use proptest::prelude::*;

    use super::*;

    pub(crate) fn header(data_type: DataType) -> Header {
        Header {
            time_interval: 4750,
            dot_num: 0,
            udp_cnt: 1,
            frame_cnt: 0,
            data_type,
            time_type: 0,
            timestamp_ns: 5_000_000,
        }
    }

    #[test]
    fn a_point_of_type_1_is_three_numbers_of_millimeters() {
        let mut data = Vec::new();
        for x in [1500_i32, -20, 7] {
            data.extend_from_slice(&x.to_le_bytes());
        }
        data.extend_from_slice(&[200, 3]);
        let packet = Header { dot_num: 1, ..header(DataType::CartesianMm) }.write(&data);
        let (_, payload) = read(&packet).expect("sound");
        let wanted =
            RawPoint { offset_s: 0.0, position: Vector3::new(1.5, -0.02, 0.007), reflectivity: 200, tag: 3 };
        assert_eq!(payload, Payload::Points(vec![wanted]));
    }

    #[test]
    fn the_last_of_96_points_is_the_packets_time_interval_after_the_first() {
        let one = RawPoint { offset_s: 0.0, position: Vector3::x(), reflectivity: 0, tag: 0 };
        let packet = write(&header(DataType::CartesianMm), &Payload::Points(vec![one; 96]));
        assert_eq!(packet.len(), 36 + 96 * 14);
        let Ok((_, Payload::Points(points))) = read(&packet) else { unreachable!("points were written") };
        assert!((points[95].offset_s - 475e-6).abs() < 1e-12);
        assert!((points[1].offset_s - 5e-6).abs() < 1e-12);
    }

    #[test]
    fn acceleration_of_1_g_becomes_9_81() {
        let sample =
            ImuSample { time_s: 0.0, gyro: Vector3::new(0.5, -0.25, 1.0), accel: Vector3::z() * -9.81 };
        let packet = write(&header(DataType::CartesianMm), &Payload::Imu(sample));
        assert_eq!(packet[36 + 20..], (-1.0_f32).to_le_bytes());
        assert_eq!(read(&packet).expect("sound").1, Payload::Imu(sample));
    }

    #[test]
    fn an_imu_value_that_is_not_finite_is_refused() {
        let mut data = [0_u8; 24];
        data[8..12].copy_from_slice(&f32::NAN.to_le_bytes());
        let packet = header(DataType::Imu).write(&data);
        assert_eq!(read(&packet), Err(PacketError::NotFinite));
    }

    proptest! {
        #[test]
        fn points_come_back_within_the_kinds_resolution(
            x in -30.0..30.0_f64, y in -30.0..30.0_f64, z in -30.0..30.0_f64,
        ) {
            let position = Vector3::new(x, y, z);
            let one = RawPoint { offset_s: 0.0, position, reflectivity: 9, tag: 1 };
            // Half a step of 0.01 deg, on two axes, at 52 m is 6 mm.
            for (kind, most) in
                [(DataType::CartesianMm, 0.001), (DataType::CartesianCm, 0.009), (DataType::Spherical, 0.008)]
            {
                let packet = write(&header(kind), &Payload::Points(vec![one]));
                let (found, payload) = read(&packet).expect("sound");
                prop_assert_eq!(found.dot_num, 1);
                let Payload::Points(points) = payload else { unreachable!("points were written") };
                prop_assert!((points[0].position - position).norm() < most);
            }
        }

        #[test]
        fn any_bytes_are_a_packet_or_an_error(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
            let _ = read(&bytes);
        }

        #[test]
        fn any_data_behind_a_sound_header_are_a_payload_or_an_error(
            data in proptest::collection::vec(any::<u8>(), 0..300), dots in 0_u16..40, kind in 0_u8..4,
        ) {
            let kinds = [DataType::Imu, DataType::CartesianMm, DataType::CartesianCm, DataType::Spherical];
            let header = Header { dot_num: dots, ..header(kinds[usize::from(kind)]) };
            if let Ok((_, Payload::Points(points))) = read(&header.write(&data)) {
                prop_assert!(points.iter().all(|p| p.position.iter().all(|x| x.is_finite())));
            }
        }
    }
}
