//! Packets to scans and IMU samples, with everything that goes wrong on the way counted.

use std::net::IpAddr;

use crate::imu::ImuSample;
use crate::packet::header::{DataType, Header};
use crate::packet::payload::{Payload, RawPoint, read};
use crate::scan::{Point, Scan};

/// Duration of a scan `[ns]`.
const SCAN_NS: u64 = 100_000_000;
/// A time stamp farther from the last one `[ns]` is another time base, not a lost packet: the scan starts again.
const REBASE_NS: u64 = 1_000_000_000;
/// Most points of a scan, ten times what a Mid-360 sends: a sender that never lets time pass does not fill the memory.
const MOST_POINTS: usize = 200_000;
/// Packets whose numbers are remembered: five times those of a scan.
const MOST_SEEN: usize = 1024;
/// Doubts of the sensor about a point, any of the three pairs of bits at its highest ("low confidence").
const DOUBT: [u8; 3] = [0b0000_0010, 0b0000_1000, 0b0010_0000];

/// What came out of the packets.
#[derive(Clone, Debug, PartialEq)]
pub enum Data {
    /// A sample of the IMU.
    Imu(ImuSample),
    /// A whole scan.
    Scan(Scan),
}

/// What went wrong so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Counts {
    /// Packets taken.
    pub taken: u64,
    /// Packets that were cut, damaged or of an unknown kind.
    pub damaged: u64,
    /// Packets from another device than the first.
    pub foreign: u64,
    /// Packets that never came, by their numbers.
    pub lost: u64,
    /// Packets that came twice.
    pub doubled: u64,
    /// Packets that came after a later one. Their points are taken if their scan is still open.
    pub out_of_order: u64,
    /// Packets with a time before the open scan, or far from the last one.
    pub wrong_time: u64,
    /// Points that the sensor itself doubts.
    pub doubted_points: u64,
}

/// Numbers of one kind of packet.
#[derive(Clone, Copy, Debug, Default)]
struct Sequence {
    last: Option<(u16, u64)>,
}

/// How a packet follows the one before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Order {
    Next { lost: u64 },
    Doubled,
    Early,
}

impl Sequence {
    fn push(&mut self, header: &Header) -> Order {
        let here = (header.udp_cnt, header.timestamp_ns);
        let Some((number, time_ns)) = self.last else {
            self.last = Some(here);
            return Order::Next { lost: 0 };
        };
        if here == (number, time_ns) {
            return Order::Doubled;
        }
        // The device was restarted, or its clock was set.
        if here.1.abs_diff(time_ns) > REBASE_NS {
            self.last = Some(here);
            return Order::Next { lost: 0 };
        }
        if here.1 < time_ns {
            return Order::Early;
        }
        self.last = Some(here);
        let ahead = here.0.wrapping_sub(number);
        // Some firmware begins each frame with 0: that is no loss. A step back in numbers with a later time is such a begin.
        let lost = if here.0 == 0 || ahead > u16::MAX / 2 { 0 } else { u64::from(ahead).saturating_sub(1) };
        Order::Next { lost }
    }
}

/// Puts packets of one device together.
#[derive(Clone, Debug, Default)]
pub struct Assembler {
    device: Option<IpAddr>,
    points: Sequence,
    imu: Sequence,
    /// Time stamp that is 0 s in the output, so that seconds keep their nanoseconds.
    zero_ns: Option<u64>,
    open: Option<(u64, Vec<Point>)>,
    /// Packets of the open scan, by number and time: to know doubled ones among those out of order.
    seen: Vec<(u16, u64)>,
    counts: Counts,
}

impl Assembler {
    /// What went wrong so far.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// Takes a packet that came from `device`. The first device is the one that counts. Gives an IMU sample, or a scan that this
    /// packet shows to be over.
    pub fn push(&mut self, packet: &[u8], device: IpAddr) -> Option<Data> {
        if self.device.is_some_and(|d| d != device) {
            self.counts.foreign += 1;
            return None;
        }
        let Ok((header, payload)) = read(packet) else {
            self.counts.damaged += 1;
            return None;
        };
        self.device = Some(device);
        let sequence = if header.data_type == DataType::Imu { &mut self.imu } else { &mut self.points };
        let order = sequence.push(&header);
        match order {
            Order::Next { lost } => self.counts.lost += lost,
            Order::Doubled => {
                self.counts.doubled += 1;
                return None;
            }
            Order::Early => {
                if self.seen.contains(&(header.udp_cnt, header.timestamp_ns)) {
                    self.counts.doubled += 1;
                    return None;
                }
                self.counts.out_of_order += 1;
                // It was counted as lost when its follower came.
                self.counts.lost = self.counts.lost.saturating_sub(1);
            }
        }
        let zero_ns = *self.zero_ns.get_or_insert(header.timestamp_ns);
        let data = match payload {
            Payload::Imu(sample) => {
                // An IMU sample behind a later one is of no use.
                if order == Order::Early {
                    return None;
                }
                let time_s = seconds(header.timestamp_ns, zero_ns);
                Some(Data::Imu(ImuSample { time_s, ..sample }))
            }
            Payload::Points(points) => self.add(&header, &points, zero_ns).map(Data::Scan),
        };
        self.counts.taken += 1;
        data
    }

    fn add(&mut self, header: &Header, points: &[RawPoint], zero_ns: u64) -> Option<Scan> {
        let time_ns = header.timestamp_ns;
        let mut done = None;
        let mut start_ns = time_ns;
        if let Some((open_ns, _)) = self.open {
            if time_ns.abs_diff(open_ns) > REBASE_NS {
                // Another time base: the end of what is open would be wrong.
                self.counts.wrong_time += 1;
                self.open = None;
                self.seen.clear();
            } else if time_ns < open_ns {
                self.counts.wrong_time += 1;
                return None;
            } else if time_ns - open_ns >= SCAN_NS
                && let Some((open_ns, points)) = self.open.take()
            {
                let start_s = seconds(open_ns, zero_ns);
                done = Some(Scan { start_s, end_s: start_s + SCAN_NS as f64 * 1e-9, points });
                // On the grid of the last one, so that a lost packet does not shift it.
                start_ns = time_ns - (time_ns - open_ns) % SCAN_NS;
                self.seen.clear();
            }
        }
        let (start_ns, open) = self.open.get_or_insert((start_ns, Vec::new()));
        let packet_s = (time_ns - *start_ns) as f64 * 1e-9;
        for point in points {
            if DOUBT.iter().any(|bit| point.tag & bit != 0) {
                self.counts.doubted_points += 1;
                continue;
            }
            // Where nothing came back the sensor writes the origin.
            if point.position.norm_squared() > 0.0 && open.len() < MOST_POINTS {
                open.push(Point { offset_s: packet_s + point.offset_s, position: point.position });
            }
        }
        if self.seen.len() < MOST_SEEN {
            self.seen.push((header.udp_cnt, time_ns));
        }
        done
    }
}

/// Time since `zero_ns` `[s]`, which may be negative.
fn seconds(time_ns: u64, zero_ns: u64) -> f64 {
    let span = time_ns.abs_diff(zero_ns) as f64 * 1e-9;
    if time_ns < zero_ns { -span } else { span }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;
    use proptest::prelude::*;

    use super::*;
    use crate::packet::payload::write;

    const DEVICE: IpAddr = IpAddr::V4(std::net::Ipv4Addr::new(192, 168, 1, 12));

    /// Packet number `number` of ten points, 10 ms after the one before.
    fn packet(number: u16) -> Vec<u8> {
        packet_at(number, 7_000_000_000 + u64::from(number) * 10_000_000)
    }

    fn packet_at(number: u16, timestamp_ns: u64) -> Vec<u8> {
        let header = Header {
            time_interval: 900,
            dot_num: 0,
            udp_cnt: number,
            frame_cnt: 0,
            data_type: DataType::CartesianMm,
            time_type: 0,
            timestamp_ns,
        };
        let one = RawPoint { offset_s: 0.0, position: Vector3::x(), reflectivity: 0, tag: 0 };
        write(&header, &Payload::Points(vec![one; 10]))
    }

    fn scans(assembler: &mut Assembler, numbers: impl IntoIterator<Item = u16>) -> Vec<Scan> {
        let pushed = numbers.into_iter().filter_map(|n| assembler.push(&packet(n), DEVICE));
        pushed.filter_map(|data| if let Data::Scan(scan) = data { Some(scan) } else { None }).collect()
    }

    #[test]
    fn ten_packets_of_10_ms_are_a_scan() {
        let mut assembler = Assembler::default();
        let found = scans(&mut assembler, 0..21);
        assert_eq!(found.len(), 2);
        assert_eq!(found[0].points.len(), 100);
        assert!((found[1].start_s - 0.1).abs() < 1e-12 && (found[1].end_s - 0.2).abs() < 1e-12);
        assert!((found[1].points[15].offset_s - 0.01005).abs() < 1e-9, "{}", found[1].points[15].offset_s);
        assert_eq!(assembler.counts(), Counts { taken: 21, ..Counts::default() });
    }

    #[test]
    fn zero_returns_are_left_out_and_a_scan_of_nothing_else_is_empty() {
        let mut assembler = Assembler::default();
        let mut found = Vec::new();
        // Packets of 96 points, 0.475 ms long, every 10 ms. In the first scan 28 of them did not come back, in the second none did.
        for number in 0..21_u16 {
            let header = Header {
                time_interval: 4750,
                dot_num: 0,
                udp_cnt: number,
                frame_cnt: 0,
                data_type: DataType::CartesianMm,
                time_type: 0,
                timestamp_ns: 7_000_000_000 + u64::from(number) * 10_000_000,
            };
            let back = if number < 10 { 68 } else { 0 };
            let points: Vec<RawPoint> = (0..96)
                .map(|i| {
                    // The last ones of each packet came back.
                    let position = if i >= 96 - back { Vector3::x() } else { Vector3::zeros() };
                    RawPoint { offset_s: 0.0, position, reflectivity: 0, tag: 0 }
                })
                .collect();
            if let Some(Data::Scan(scan)) = assembler.push(&write(&header, &Payload::Points(points)), DEVICE)
            {
                found.push(scan);
            }
        }
        assert_eq!(found.iter().map(|s| s.points.len()).collect::<Vec<_>>(), [680, 0]);
        // They keep their own times: 28 x 5 us after the packet's.
        let first = found[0].points[0];
        assert!(first.position == Vector3::x() && (first.offset_s - 140e-6).abs() < 1e-9, "{first:?}");
        assert!((found[1].end_s - found[1].start_s - 0.1).abs() < 1e-9, "an empty scan lasts as long");
    }

    #[test]
    fn a_lost_packet_is_counted_and_does_not_shift_the_scans() {
        let mut assembler = Assembler::default();
        // 10 and 11 are missing: the second scan has no begin.
        let found = scans(&mut assembler, (0..10).chain(12..25));
        assert_eq!(assembler.counts().lost, 2);
        assert_eq!(found.iter().map(|s| s.points.len()).collect::<Vec<_>>(), [100, 80]);
        assert!((found[1].start_s - 0.1).abs() < 1e-12);
    }

    #[test]
    fn doubled_and_late_packets_are_distinguished() {
        let mut assembler = Assembler::default();
        let found = scans(&mut assembler, [0, 1, 1, 3, 2, 2, 4, 5, 6, 7, 8, 9, 10]);
        assert_eq!(found[0].points.len(), 100, "each packet once, the late one too");
        let counts = assembler.counts();
        assert_eq!((counts.doubled, counts.out_of_order, counts.lost), (2, 1, 0));
        // One that comes after its scan is over is refused.
        assert!(scans(&mut assembler, [9]).is_empty());
        assert_eq!(assembler.counts().wrong_time, 1);
    }

    #[test]
    fn another_device_and_damaged_packets_are_counted_and_left_out() {
        let mut assembler = Assembler::default();
        scans(&mut assembler, 0..2);
        assert_eq!(assembler.push(&packet(2), IpAddr::V4(std::net::Ipv4Addr::LOCALHOST)), None);
        let mut torn = packet(2);
        torn.truncate(100);
        assert_eq!(assembler.push(&torn, DEVICE), None);
        let wanted = Counts { taken: 2, foreign: 1, damaged: 1, ..Counts::default() };
        assert_eq!(assembler.counts(), wanted);
    }

    #[test]
    fn numbers_that_wrap_or_restart_are_no_loss() {
        let mut assembler = Assembler::default();
        for (i, number) in [65_534, 65_535, 0, 1, 0, 1].into_iter().enumerate() {
            assembler.push(&packet_at(number, 1_000_000 + i as u64 * 480_000), DEVICE);
        }
        assert_eq!(assembler.counts(), Counts { taken: 6, ..Counts::default() });
    }

    #[test]
    fn another_time_base_drops_the_open_scan() {
        let mut assembler = Assembler::default();
        scans(&mut assembler, 0..5);
        for i in 0..11_u16 {
            let data = assembler.push(&packet_at(i, u64::from(i) * 10_000_000), DEVICE);
            assert_eq!(data.is_some(), i == 10, "packet {i}");
        }
        assert_eq!(assembler.counts().wrong_time, 1);
    }

    proptest! {
        #[test]
        fn packets_at_any_time_and_number_make_scans_of_100_ms(
            packets in proptest::collection::vec((any::<u16>(), any::<u64>(), any::<bool>()), 1..60),
        ) {
            let mut assembler = Assembler::default();
            let mut near = 0;
            for (number, time, far) in packets {
                // Half of them near the last one, half anywhere.
                near = if far { time } else { u64::wrapping_add(near, time % 50_000_000) };
                if let Some(Data::Scan(scan)) = assembler.push(&packet_at(number, near), DEVICE) {
                    prop_assert!((scan.end_s - scan.start_s - 0.1).abs() < 1e-3 * scan.end_s.abs().max(1.0));
                    prop_assert!(scan.points.iter().all(|p| (0.0..0.11).contains(&p.offset_s)));
                }
            }
        }

        #[test]
        fn any_bytes_from_any_device_are_counted(packets in proptest::collection::vec(
            (proptest::collection::vec(any::<u8>(), 0..80), any::<bool>()), 1..20,
        )) {
            let mut assembler = Assembler::default();
            let count = packets.len() as u64;
            for (bytes, other) in packets {
                let device = if other { IpAddr::V4(std::net::Ipv4Addr::LOCALHOST) } else { DEVICE };
                assembler.push(&bytes, device);
            }
            let c = assembler.counts();
            prop_assert_eq!(c.taken + c.damaged + c.foreign + c.doubled + c.out_of_order, count);
        }
    }
}
