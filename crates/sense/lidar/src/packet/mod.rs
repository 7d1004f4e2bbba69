//! Packets of a Livox Mid-360: reading, writing, and putting them together.
//!
//! Layout from the manufacturer's protocol description of the Mid-360 (little-endian, header of 36 bytes, CRC-32 over time stamp
//! and data). An own reader of 36 bytes and three layouts, not the crate `livox2` 0.2: that one checks neither the data's CRC nor the
//! sequence, and brings an asynchronous runtime.

mod assembler;
mod header;
mod payload;
mod udp;

pub use assembler::{Assembler, Counts, Data};
pub use header::{DataType, HEADER_BYTES, Header, PacketError};
pub use payload::{Payload, RawPoint, read, write};
pub use udp::{IMU_PORT, POINT_PORT, UdpSource};
