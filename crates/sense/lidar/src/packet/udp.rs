//! Packets from the network.

use std::io::ErrorKind;
use std::net::{SocketAddr, UdpSocket};
use std::time::{Duration, Instant};

use crate::error::LidarError;
use crate::packet::assembler::{Assembler, Counts, Data};

/// Port of this machine that points come to.
pub const POINT_PORT: u16 = 56301;
/// Port of this machine that IMU samples come to.
pub const IMU_PORT: u16 = 56401;
/// Longest datagram.
const DATAGRAM: usize = 65_536;

/// Scans and IMU samples from a Mid-360 in the network. The device must be configured to send here (with its own tools).
#[derive(Debug)]
pub struct UdpSource {
    sockets: [UdpSocket; 2],
    assembler: Assembler,
    buffer: Vec<u8>,
    begin: Instant,
}

impl UdpSource {
    /// Listens on the two local addresses, for example `192.168.1.5:56301` and `:56401`.
    ///
    /// # Errors
    ///
    /// An address cannot be bound.
    pub fn bind(points: SocketAddr, imu: SocketAddr) -> Result<Self, LidarError> {
        let bind = |address: SocketAddr| {
            let wrong = |error| LidarError::Socket { address: address.to_string(), error };
            let socket = UdpSocket::bind(address).map_err(wrong)?;
            socket.set_nonblocking(true).map_err(wrong)?;
            Ok(socket)
        };
        Ok(Self {
            sockets: [bind(imu)?, bind(points)?],
            assembler: Assembler::default(),
            buffer: vec![0; DATAGRAM],
            begin: Instant::now(),
        })
    }

    /// Local addresses of points and IMU.
    ///
    /// # Errors
    ///
    /// The system does not report it.
    pub fn addresses(&self) -> Result<[SocketAddr; 2], LidarError> {
        let [imu, points] = &self.sockets;
        let address = |socket: &UdpSocket| {
            socket.local_addr().map_err(|error| LidarError::Socket { address: "local".to_owned(), error })
        };
        Ok([address(points)?, address(imu)?])
    }

    /// What went wrong so far.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.assembler.counts()
    }

    /// The next scan or IMU sample with its arrival `[s]` since [`UdpSource::bind`]; `None` if nothing came within `patience`.
    ///
    /// # Errors
    ///
    /// The network fails.
    pub fn next(&mut self, patience: Duration) -> Result<Option<(Data, f64)>, LidarError> {
        let until = Instant::now() + patience;
        loop {
            let mut idle = true;
            for socket in &self.sockets {
                match socket.recv_from(&mut self.buffer) {
                    Ok((length, from)) => {
                        idle = false;
                        let packet = self.buffer.get(..length).unwrap_or_default();
                        if let Some(data) = self.assembler.push(packet, from.ip()) {
                            return Ok(Some((data, self.begin.elapsed().as_secs_f64())));
                        }
                    }
                    // A port without a listener answers earlier packets so; it means nothing for the next ones.
                    Err(error)
                        if matches!(
                            error.kind(),
                            ErrorKind::WouldBlock | ErrorKind::Interrupted | ErrorKind::ConnectionReset
                        ) => {}
                    Err(error) => {
                        let address =
                            socket.local_addr().map_or_else(|_| "socket".to_owned(), |a| a.to_string());
                        return Err(LidarError::Socket { address, error });
                    }
                }
            }
            if idle {
                if Instant::now() >= until {
                    return Ok(None);
                }
                // A packet of points comes every half millisecond.
                std::thread::sleep(Duration::from_micros(200));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::packet::header::{DataType, Header};
    use crate::packet::payload::{Payload, RawPoint, write};

    #[test]
    fn packets_on_two_ports_become_a_scan_and_imu_samples() {
        let local = "127.0.0.1:0".parse().expect("an address");
        let mut source = UdpSource::bind(local, local).expect("free ports");
        let [points, imu] = source.addresses().expect("bound");
        let device = UdpSocket::bind("127.0.0.1:0").expect("a free port");
        let header = |number: u16| Header {
            time_interval: 4750,
            dot_num: 0,
            udp_cnt: number,
            frame_cnt: 0,
            data_type: DataType::CartesianMm,
            time_type: 0,
            timestamp_ns: 1_000_000_000 + u64::from(number) * 10_000_000,
        };
        let one = RawPoint { offset_s: 0.0, position: nalgebra::Vector3::x(), reflectivity: 0, tag: 0 };
        let sample = crate::imu::ImuSample {
            time_s: 0.0,
            gyro: nalgebra::Vector3::zeros(),
            accel: nalgebra::Vector3::z() * 9.81,
        };
        let (mut scans, mut samples) = (0, 0);
        for number in 0..21 {
            let packet = write(&header(number), &Payload::Points(vec![one; 10]));
            device.send_to(&packet, points).expect("sent");
            device.send_to(&write(&header(number), &Payload::Imu(sample)), imu).expect("sent");
            while let Some((data, _)) = source.next(Duration::from_millis(2)).expect("a network") {
                match data {
                    Data::Scan(scan) => {
                        scans += 1;
                        assert_eq!(scan.points.len(), 100);
                        assert!((scan.end_s - scan.start_s - 0.1).abs() < 1e-9);
                    }
                    Data::Imu(_) => samples += 1,
                }
            }
        }
        // Whatever is still on its way.
        while samples < 21 || scans < 2 {
            match source.next(Duration::from_secs(5)).expect("a network") {
                Some((Data::Scan(_), _)) => scans += 1,
                Some((Data::Imu(_), _)) => samples += 1,
                None => break,
            }
        }
        assert_eq!((scans, samples), (2, 21));
        assert_eq!(source.counts().taken, 42);
    }

    #[test]
    fn a_port_in_use_is_named() {
        let taken = UdpSocket::bind("127.0.0.1:0").expect("a free port");
        let address = taken.local_addr().expect("bound");
        let error = UdpSource::bind(address, address).expect_err("in use").to_string();
        assert!(error.starts_with(&address.to_string()), "{error}");
    }
}
