//! A simulated frame as the packets that a Mid-360 would send.

use crate::packet::{DataType, Header, Payload, RawPoint, write};
use crate::scan::Point;
use crate::sim::sensor::Frame;

/// Points of a packet.
const POINTS: usize = 96;
/// Longest pause between two points of a packet `[s]`: the header gives only the time from the first to the last.
const PAUSE_S: f64 = 20e-6;

/// Numbers the packets of a simulated device.
#[derive(Clone, Copy, Debug, Default)]
pub struct PacketWriter {
    points: u16,
    imu: u16,
}

impl PacketWriter {
    /// The packets of `frame`, IMU before points, all in order of time within their kind.
    pub fn packets(&mut self, frame: &Frame) -> Vec<Vec<u8>> {
        let mut packets = Vec::new();
        for sample in &frame.imu {
            let header = header(DataType::Imu, self.imu, sample.time_s, 0.0);
            self.imu = self.imu.wrapping_add(1);
            packets.push(write(&header, &Payload::Imu(*sample)));
        }
        let mut rest = frame.scan.points.as_slice();
        while let Some(first) = rest.first() {
            let pause =
                rest.windows(2).take(POINTS - 1).position(|w| w[1].offset_s - w[0].offset_s > PAUSE_S);
            let count = pause.map_or(POINTS.min(rest.len()), |at| at + 1);
            let (packet, later) = rest.split_at(count);
            rest = later;
            let span_s = packet.last().map_or(0.0, |last| last.offset_s - first.offset_s);
            let header =
                header(DataType::CartesianMm, self.points, frame.scan.start_s + first.offset_s, span_s);
            self.points = self.points.wrapping_add(1);
            packets.push(write(&header, &Payload::Points(packet.iter().map(raw).collect())));
        }
        packets
    }
}

fn raw(point: &Point) -> RawPoint {
    RawPoint { offset_s: point.offset_s, position: point.position, reflectivity: 100, tag: 0 }
}

fn header(data_type: DataType, number: u16, time_s: f64, span_s: f64) -> Header {
    Header {
        time_interval: (span_s * 1e7).round() as u16,
        dot_num: 0,
        udp_cnt: number,
        frame_cnt: 0,
        data_type,
        time_type: 0,
        // A device that is on for 100 s.
        timestamp_ns: ((time_s + 100.0) * 1e9).round() as u64,
    }
}
