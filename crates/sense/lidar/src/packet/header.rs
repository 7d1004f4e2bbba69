//! The header of a data packet, and its checks.

use thiserror::Error;

/// Length of the header.
pub const HEADER_BYTES: usize = 36;
/// Where the part begins that the CRC covers: the time stamp.
const CHECKED_FROM: usize = 28;

/// Why a packet was refused.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum PacketError {
    /// Fewer bytes than a header.
    #[error("packet: expected at least {HEADER_BYTES} bytes, found {found}")]
    Short {
        /// Bytes found.
        found: usize,
    },
    /// The header names another length.
    #[error("length: expected {found} bytes as received, the header says {named}")]
    Length {
        /// In the header.
        named: usize,
        /// Received.
        found: usize,
    },
    /// A version that is not known.
    #[error("version: expected 0, found {found}")]
    Version {
        /// Found.
        found: u8,
    },
    /// A kind of data that is not known.
    #[error(
        "data_type: expected 0 (IMU), 1 (Cartesian, mm), 2 (Cartesian, cm) or 3 (spherical), found {found}"
    )]
    DataType {
        /// Found.
        found: u8,
    },
    /// The number of points does not fit the length.
    #[error("dot_num: expected {expected} points in {bytes} bytes of data, found {found}")]
    Points {
        /// Points that the data hold.
        expected: usize,
        /// Bytes of data.
        bytes: usize,
        /// In the header.
        found: usize,
    },
    /// The check sum differs.
    #[error("crc32: expected {expected:#010x}, found {found:#010x}")]
    Crc {
        /// Of the data.
        expected: u32,
        /// In the header.
        found: u32,
    },
    /// An IMU value that is not finite.
    #[error("IMU: expected finite numbers")]
    NotFinite,
}

/// Kind of data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DataType {
    /// Six `f32`: angular velocity `[rad/s]`, acceleration `[g]`.
    Imu,
    /// `i32` x, y, z `[mm]`, reflectivity, tag.
    CartesianMm,
    /// `i16` x, y, z `[cm]`, reflectivity, tag.
    CartesianCm,
    /// `u32` depth `[mm]`, `u16` zenith and azimuth `[0.01 deg]`, reflectivity, tag.
    Spherical,
}

impl DataType {
    /// Bytes of one point, or of the IMU's data.
    #[must_use]
    pub fn item_bytes(self) -> usize {
        match self {
            Self::Imu => 24,
            Self::CartesianMm => 14,
            Self::CartesianCm => 8,
            Self::Spherical => 10,
        }
    }

    pub(crate) fn code(self) -> u8 {
        match self {
            Self::Imu => 0,
            Self::CartesianMm => 1,
            Self::CartesianCm => 2,
            Self::Spherical => 3,
        }
    }

    fn from_code(code: u8) -> Option<Self> {
        [Self::Imu, Self::CartesianMm, Self::CartesianCm, Self::Spherical]
            .into_iter()
            .find(|t| t.code() == code)
    }
}

/// The header's content.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Header {
    /// Time from the first to the last point `[0.1 us]`.
    pub time_interval: u16,
    /// Points, 1 for the IMU.
    pub dot_num: u16,
    /// Number of the packet, modulo 2^16.
    pub udp_cnt: u16,
    /// Number of the frame.
    pub frame_cnt: u8,
    /// Kind of data.
    pub data_type: DataType,
    /// Source of the time stamp: 0 since power-on, 1 PTP, 2 GPS.
    pub time_type: u8,
    /// Time of the first point `[ns]`.
    pub timestamp_ns: u64,
}

fn bytes<const N: usize>(packet: &[u8], at: usize) -> [u8; N] {
    packet.get(at..at + N).and_then(|b| b.try_into().ok()).unwrap_or([0; N])
}

impl Header {
    /// Reads and checks the header of a whole packet; gives the data behind it too.
    ///
    /// # Errors
    ///
    /// Length, version, kind, number of points or CRC do not hold.
    pub fn read(packet: &[u8]) -> Result<(Self, &[u8]), PacketError> {
        let Some(data) = packet.get(HEADER_BYTES..) else {
            return Err(PacketError::Short { found: packet.len() });
        };
        if packet[0] != 0 {
            return Err(PacketError::Version { found: packet[0] });
        }
        let named = usize::from(u16::from_le_bytes(bytes(packet, 1)));
        if named != packet.len() {
            return Err(PacketError::Length { named, found: packet.len() });
        }
        let data_type = DataType::from_code(packet[10]).ok_or(PacketError::DataType { found: packet[10] })?;
        let dot_num = u16::from_le_bytes(bytes(packet, 5));
        let expected = data.len() / data_type.item_bytes();
        let whole = data.len() % data_type.item_bytes() == 0;
        // An IMU packet is one item, whatever it names.
        let found = if data_type == DataType::Imu { 1 } else { usize::from(dot_num) };
        if !whole || expected != found {
            return Err(PacketError::Points { expected, bytes: data.len(), found });
        }
        let found = u32::from_le_bytes(bytes(packet, 24));
        let expected = checksum(packet);
        if found != expected {
            return Err(PacketError::Crc { expected, found });
        }
        let header = Self {
            time_interval: u16::from_le_bytes(bytes(packet, 3)),
            dot_num,
            udp_cnt: u16::from_le_bytes(bytes(packet, 7)),
            frame_cnt: packet[9],
            data_type,
            time_type: packet[11],
            timestamp_ns: u64::from_le_bytes(bytes(packet, 28)),
        };
        Ok((header, data))
    }

    /// The packet of this header and `data`, with length and CRC. `data` longer than a datagram makes a packet that
    /// [`Header::read`] refuses.
    #[must_use]
    pub fn write(&self, data: &[u8]) -> Vec<u8> {
        let mut packet = vec![0; HEADER_BYTES];
        packet.extend_from_slice(data);
        let length = u16::try_from(packet.len()).unwrap_or(u16::MAX);
        packet[1..3].copy_from_slice(&length.to_le_bytes());
        packet[3..5].copy_from_slice(&self.time_interval.to_le_bytes());
        packet[5..7].copy_from_slice(&self.dot_num.to_le_bytes());
        packet[7..9].copy_from_slice(&self.udp_cnt.to_le_bytes());
        packet[9] = self.frame_cnt;
        packet[10] = self.data_type.code();
        packet[11] = self.time_type;
        packet[28..36].copy_from_slice(&self.timestamp_ns.to_le_bytes());
        let crc = checksum(&packet);
        packet[24..28].copy_from_slice(&crc.to_le_bytes());
        packet
    }
}

fn checksum(packet: &[u8]) -> u32 {
    crc32fast::hash(packet.get(CHECKED_FROM..).unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header() -> Header {
        Header {
            time_interval: 4750,
            dot_num: 2,
            udp_cnt: 0x1234,
            frame_cnt: 7,
            data_type: DataType::CartesianCm,
            time_type: 0,
            timestamp_ns: 0x0102_0304_0506_0708,
        }
    }

    #[test]
    fn bytes_lie_where_the_protocol_puts_them() {
        let packet = header().write(&[9; 16]);
        assert_eq!(packet.len(), 52);
        assert_eq!(packet[..12], [0, 52, 0, 0x8E, 0x12, 2, 0, 0x34, 0x12, 7, 2, 0]);
        assert_eq!(packet[28..36], [8, 7, 6, 5, 4, 3, 2, 1]);
        // CRC-32 (ISO-HDLC), whose value for "123456789" is 0xcbf43926.
        assert_eq!(crc32fast::hash(b"123456789"), 0xcbf4_3926);
        assert_eq!(packet[24..28], crc32fast::hash(&packet[28..]).to_le_bytes());
        assert_eq!(Header::read(&packet), Ok((header(), &[9_u8; 16][..])));
    }

    #[test]
    fn each_damage_has_its_error() {
        let good = header().write(&[9; 16]);
        let damaged = |at: usize, value: u8| {
            let mut packet = good.clone();
            packet[at] = value;
            Header::read(&packet).map(|_| ())
        };
        assert_eq!(Header::read(&good[..20]).map(|_| ()), Err(PacketError::Short { found: 20 }));
        let cut = Header::read(&good[..51]).map(|_| ());
        assert_eq!(cut, Err(PacketError::Length { named: 52, found: 51 }));
        assert_eq!(damaged(0, 3), Err(PacketError::Version { found: 3 }));
        assert_eq!(damaged(10, 9), Err(PacketError::DataType { found: 9 }));
        assert_eq!(damaged(5, 3), Err(PacketError::Points { expected: 2, bytes: 16, found: 3 }));
        assert!(matches!(damaged(40, 8), Err(PacketError::Crc { .. })));
        assert!(matches!(damaged(30, 8), Err(PacketError::Crc { .. })));
    }
}
