//! Bytes on DDS: what the robot's topics and those of ROS 2 share.

use std::net::IpAddr;

use rustdds::bytes::Bytes;
use rustdds::dds::{CreateError, CreateResult, WriteError, WriteResult};
use rustdds::no_key::{Decode, DefaultDecoder, DeserializerAdapter, SerializerAdapter};
use rustdds::{DomainParticipant, DomainParticipantBuilder, RepresentationIdentifier};

use crate::wire::check_domain;

/// The header of little-endian CDR.
const LITTLE_ENDIAN: [u8; 4] = [0, 1, 0, 0];

/// Bytes of CDR, unread; the first `HEADER` (0 or 4) of them are the header, which on the network is DDS's own affair.
pub(crate) struct Raw<const HEADER: usize>;

#[derive(Debug, thiserror::Error)]
#[error("the encoding is not little-endian CDR")]
pub(crate) struct RawError;

impl<const HEADER: usize> SerializerAdapter<Vec<u8>> for Raw<HEADER> {
    type Error = RawError;
    fn output_encoding() -> RepresentationIdentifier {
        RepresentationIdentifier::CDR_LE
    }
    fn to_bytes(value: &Vec<u8>) -> Result<Bytes, RawError> {
        value.get(HEADER..).map(Bytes::copy_from_slice).ok_or(RawError)
    }
}

impl<const HEADER: usize> DeserializerAdapter<Vec<u8>> for Raw<HEADER> {
    type Error = RawError;
    type Decoded = Vec<u8>;
    fn supported_encodings() -> &'static [RepresentationIdentifier] {
        &[RepresentationIdentifier::CDR_LE]
    }
    fn transform_decoded(decoded: Vec<u8>) -> Vec<u8> {
        decoded
    }
}

#[derive(Clone)]
pub(crate) struct RawDecoder<const HEADER: usize>;

impl<const HEADER: usize> DefaultDecoder<Vec<u8>> for Raw<HEADER> {
    type Decoder = RawDecoder<HEADER>;
    const DECODER: RawDecoder<HEADER> = RawDecoder;
}

impl<const HEADER: usize> Decode<'_, Vec<u8>> for RawDecoder<HEADER> {
    type Error = RawError;
    fn decode_bytes(self, bytes: &[u8], encoding: RepresentationIdentifier) -> Result<Vec<u8>, RawError> {
        if encoding != RepresentationIdentifier::CDR_LE {
            return Err(RawError);
        }
        let mut out = Vec::with_capacity(HEADER + bytes.len());
        out.extend(&LITTLE_ENDIAN[..HEADER]);
        out.extend(bytes);
        Ok(out)
    }
}

/// Joins a domain through the interface that has this address.
pub(crate) fn participant(domain: u16, interface: IpAddr) -> CreateResult<DomainParticipant> {
    check_domain(Some(domain)).map_err(|expected| CreateError::BadParameter {
        reason: format!("domain: {expected}, found {domain}"),
    })?;
    let builder = DomainParticipantBuilder::new(domain);
    builder.same_host_loopback(interface.is_loopback()).with_only_networks([interface]).build()
}

/// A full queue loses a message, as a network does; the next one is on its way.
pub(crate) fn sent<T>(result: WriteResult<(), T>) -> WriteResult<(), T> {
    match result {
        Err(WriteError::WouldBlock { .. }) => Ok(()),
        other => other,
    }
}
