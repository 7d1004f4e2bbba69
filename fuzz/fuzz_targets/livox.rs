//! Any datagrams as a Mid-360's: counted, never a panic, and no scan that is not 100 ms long.
#![no_main]

use std::net::{IpAddr, Ipv4Addr};

use paid_lidar::packet::{Assembler, Data, DataType, Header};

const KINDS: [DataType; 4] =
    [DataType::Imu, DataType::CartesianMm, DataType::CartesianCm, DataType::Spherical];

libfuzzer_sys::fuzz_target!(|input: &[u8]| {
    let mut assembler = Assembler::default();
    let mut timestamp_ns = 0_u64;
    // The first byte of a piece says how it is sent: as it is, or behind a header with a right check sum.
    for piece in input.chunks(64) {
        let device = IpAddr::V4(Ipv4Addr::new(192, 168, 1, piece[0] & 1));
        let data = match piece {
            [mode, a, b, c, d, rest @ ..] if mode & 2 == 0 => {
                let data_type = KINDS[usize::from(mode >> 2 & 3)];
                let size = data_type.item_bytes();
                let step = u64::from(u16::from_le_bytes([*a, *b])) << (mode >> 4);
                timestamp_ns =
                    if c & 1 == 0 { timestamp_ns.wrapping_add(step) } else { timestamp_ns.wrapping_sub(step) };
                let items = rest.len() / size;
                let header = Header {
                    time_interval: u16::from_le_bytes([*c, *d]),
                    dot_num: items as u16,
                    udp_cnt: u16::from(*d),
                    frame_cnt: 0,
                    data_type,
                    time_type: 0,
                    timestamp_ns,
                };
                assembler.push(&header.write(&rest[..items * size]), device)
            }
            _ => assembler.push(piece, device),
        };
        if let Some(Data::Scan(scan)) = data {
            assert!((scan.end_s - scan.start_s - 0.1).abs() < 1e-3 * scan.end_s.abs().max(1.0));
        }
    }
});
