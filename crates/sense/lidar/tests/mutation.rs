//! Damaged datagrams of a Mid-360: each is counted, none panics, and no scan lasts longer than 100 ms. `PAID_MUTATIONS=10000000` makes it longer.

use std::net::{IpAddr, Ipv4Addr};

use nalgebra::Vector3;
use paid_lidar::ImuSample;
use paid_lidar::packet::{Assembler, Data, DataType, Header, Payload, RawPoint, write};
use paid_testing::damaged;

/// A sound packet with number and time of its own: points, or every fifth time an inertial sample.
fn packet(number: u32) -> Vec<u8> {
    let header = Header {
        time_interval: 4750,
        dot_num: 0,
        udp_cnt: number as u16,
        frame_cnt: 0,
        data_type: DataType::CartesianMm,
        time_type: 0,
        timestamp_ns: 1_000_000_000 + u64::from(number) * 2_000_000,
    };
    if number.is_multiple_of(5) {
        let sample = ImuSample { time_s: 0.0, gyro: Vector3::zeros(), accel: Vector3::z() * 9.81 };
        return write(&header, &Payload::Imu(sample));
    }
    let point = RawPoint { offset_s: 0.0, position: Vector3::x(), reflectivity: 0, tag: 0 };
    write(&header, &Payload::Points(vec![point; 4]))
}

#[test]
fn damaged_datagrams_are_counted_and_scans_stay_whole() {
    let usual = 20_000;
    let count: u32 = std::env::var("PAID_MUTATIONS").ok().and_then(|text| text.parse().ok()).unwrap_or(usual);
    let mut assembler = Assembler::default();
    let (mut scans, mut samples) = (0_u64, 0_u64);
    for number in 0..count {
        // Two of three are sound, so that scans come to an end between the damaged ones.
        let bytes = packet(number / 3);
        let bytes = if number % 3 == 1 { damaged(&bytes, number) } else { bytes };
        let device = IpAddr::V4(Ipv4Addr::new(192, 168, 1, if number % 31 == 30 { 9 } else { 12 }));
        match assembler.push(&bytes, device) {
            Some(Data::Scan(scan)) => {
                scans += 1;
                assert!(scan.end_s - scan.start_s < 0.101 && !scan.points.is_empty(), "{number}");
            }
            Some(Data::Imu(sample)) => {
                samples += 1;
                assert!(sample.time_s.is_finite(), "{number}");
            }
            None => {}
        }
    }
    let c = assembler.counts();
    println!("livox: {count} datagrams, {scans} scans, {samples} samples, {c:?}");
    assert_eq!(c.taken + c.damaged + c.foreign + c.doubled + c.out_of_order, u64::from(count));
    assert!(scans > 0 && samples > 0 && c.damaged > u64::from(count) / 10, "{scans} {samples} {c:?}");
}
