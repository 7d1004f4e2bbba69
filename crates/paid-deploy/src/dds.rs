//! The robot's own network: DDS by `rustdds`, on one domain and one interface that the caller names.
//!
//! The robot's topics have no key. Messages are read and written as bytes of CDR, so that [`crate::wire`] alone knows their fields.
//! DDS as the robot uses it has no authentication: whoever reaches the network can command the robot.

use std::collections::VecDeque;
use std::net::IpAddr;
use std::sync::{Arc, Mutex};

use rustdds::bytes::Bytes;
use rustdds::no_key::{
    DataReader, DataWriter, Decode, DefaultDecoder, DeserializerAdapter, SerializerAdapter,
};
use rustdds::policy::{History, Reliability};
use rustdds::{
    DomainParticipant, DomainParticipantBuilder, QosPolicies, QosPolicyBuilder, RepresentationIdentifier,
    TopicKind,
};
use serde::{Deserialize, Serialize};

use crate::link::{Inlet, Link, LinkError, Outlet};
use crate::message::Packet;
use crate::wire::LowCmd;

/// Topics and types of the robot, and the one of this project beside them.
const LOW_STATE: [&str; 2] = ["rt/lowstate", "unitree_hg::msg::dds_::LowState_"];
const LOW_CMD: [&str; 2] = ["rt/lowcmd", "unitree_hg::msg::dds_::LowCmd_"];
const SENSES: [&str; 2] = ["paid/senses", "paid::msg::Senses_"];
/// Commands that this process has sent are known again for so many commands.
const OWN: usize = 256;

/// Who speaks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The robot: says states, hears commands.
    Robot,
    /// The runtime: says commands, hears states.
    Runtime,
}

/// Bytes of CDR, unread.
struct Raw;

#[derive(Debug, thiserror::Error)]
#[error("the encoding is not CDR_LE")]
struct RawError;

impl SerializerAdapter<Vec<u8>> for Raw {
    type Error = RawError;
    fn output_encoding() -> RepresentationIdentifier {
        RepresentationIdentifier::CDR_LE
    }
    fn to_bytes(value: &Vec<u8>) -> Result<Bytes, RawError> {
        Ok(Bytes::copy_from_slice(value))
    }
}

impl DeserializerAdapter<Vec<u8>> for Raw {
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
struct RawDecoder;

impl DefaultDecoder<Vec<u8>> for Raw {
    type Decoder = RawDecoder;
    const DECODER: RawDecoder = RawDecoder;
}

impl Decode<'_, Vec<u8>> for RawDecoder {
    type Error = RawError;
    fn decode_bytes(self, bytes: &[u8], encoding: RepresentationIdentifier) -> Result<Vec<u8>, RawError> {
        if encoding == RepresentationIdentifier::CDR_LE { Ok(bytes.to_vec()) } else { Err(RawError) }
    }
}

/// What travels on the project's own topic: a CDR sequence of bytes with a packet in postcard.
#[derive(Serialize, Deserialize)]
struct Senses(Packet);

type RawWriter = DataWriter<Vec<u8>, Raw>;
type RawReader = DataReader<Vec<u8>, Raw>;

/// An end of the link on the network.
pub struct DdsLink {
    outlet: DdsOutlet,
    inlet: DdsInlet,
}

struct DdsOutlet {
    writer: RawWriter,
    senses: Option<RawWriter>,
    own: Arc<Mutex<VecDeque<u32>>>,
    _participant: DomainParticipant,
}

struct DdsInlet {
    side: Side,
    main: RawReader,
    senses: Option<RawReader>,
    /// Commands on the network, to notice those of others.
    commands: Option<RawReader>,
    own: Arc<Mutex<VecDeque<u32>>>,
}

fn network(what: &'static str) -> impl Fn(String) -> LinkError {
    move |message| LinkError::Network { what, message }
}

impl DdsLink {
    /// Joins a domain through the interface that has this address. Nothing is chosen by itself.
    ///
    /// # Errors
    /// If the network cannot be joined.
    pub fn open(domain: u16, interface: IpAddr, side: Side) -> Result<Self, LinkError> {
        let fail = network("DDS");
        let builder = DomainParticipantBuilder::new(domain)
            .same_host_loopback(interface.is_loopback())
            .with_only_networks([interface]);
        let participant = builder.build().map_err(|e| fail(e.to_string()))?;
        let qos: QosPolicies = QosPolicyBuilder::new()
            .reliability(Reliability::BestEffort)
            .history(History::KeepLast { depth: 1 })
            .build();
        let own = Arc::new(Mutex::new(VecDeque::with_capacity(OWN + 1)));
        let publisher = participant.create_publisher(&qos).map_err(|e| fail(e.to_string()))?;
        let subscriber = participant.create_subscriber(&qos).map_err(|e| fail(e.to_string()))?;
        let topic = |[name, kind]: [&str; 2]| {
            participant
                .create_topic(name.to_owned(), kind.to_owned(), &qos, TopicKind::NoKey)
                .map_err(|e| fail(e.to_string()))
        };
        let reliable: QosPolicies = QosPolicyBuilder::new()
            .reliability(Reliability::Reliable { max_blocking_time: rustdds::Duration::from_millis(1) })
            .history(History::KeepLast { depth: 16 })
            .build();
        let writer = |name: [&str; 2], qos: &QosPolicies| {
            publisher
                .create_datawriter_no_key::<Vec<u8>, Raw>(&topic(name)?, Some(qos.clone()))
                .map_err(|e| fail(e.to_string()))
        };
        let reader = |name: [&str; 2], qos: &QosPolicies| {
            subscriber
                .create_datareader_no_key::<Vec<u8>, Raw>(&topic(name)?, Some(qos.clone()))
                .map_err(|e| fail(e.to_string()))
        };
        let (out, main) = match side {
            Side::Robot => (LOW_STATE, LOW_CMD),
            Side::Runtime => (LOW_CMD, LOW_STATE),
        };
        let senses_out = if side == Side::Robot { Some(writer(SENSES, &reliable)?) } else { None };
        let at_runtime = side == Side::Runtime;
        let senses_in = if at_runtime { Some(reader(SENSES, &reliable)?) } else { None };
        let commands = if at_runtime { Some(reader(LOW_CMD, &qos)?) } else { None };
        // A reliable writer serves readers of either kind.
        let writer = writer(out, &reliable)?;
        let main = reader(main, &qos)?;
        Ok(Self {
            outlet: DdsOutlet {
                writer,
                senses: senses_out,
                own: Arc::clone(&own),
                _participant: participant,
            },
            inlet: DdsInlet { side, main, senses: senses_in, commands, own },
        })
    }
}

impl Outlet for DdsOutlet {
    fn send(&mut self, packet: Packet) -> Result<(), LinkError> {
        let fail = network("DDS write");
        let (writer, bytes) = match packet {
            Packet::LowState(bytes) => (&self.writer, bytes),
            Packet::LowCmd(bytes) => {
                if let Some(crc) = bytes.last_chunk().map(|crc| u32::from_le_bytes(*crc)) {
                    let mut own = self.own.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
                    own.push_back(crc);
                    if own.len() > OWN {
                        own.pop_front();
                    }
                }
                (&self.writer, bytes)
            }
            Packet::OthersCommand => return Ok(()),
            other => {
                let Some(senses) = &self.senses else { return Ok(()) };
                let content = postcard::to_stdvec(&Senses(other)).map_err(|e| fail(e.to_string()))?;
                let mut bytes = (content.len() as u32).to_le_bytes().to_vec();
                bytes.extend(content);
                (senses, bytes)
            }
        };
        // A full queue loses a packet, as a network does; the next one comes 2 ms later.
        match writer.write(bytes, None) {
            Ok(()) | Err(rustdds::dds::WriteError::WouldBlock { .. }) => Ok(()),
            Err(error) => Err(fail(error.to_string())),
        }
    }
}

/// The next sample, if there is one.
fn take(reader: &mut RawReader) -> Result<Option<Vec<u8>>, LinkError> {
    match reader.take_next_sample() {
        Ok(sample) => Ok(sample.map(|sample| sample.into_value())),
        Err(error) => Err(network("DDS read")(error.to_string())),
    }
}

impl Inlet for DdsInlet {
    fn receive(&mut self) -> Result<Option<Packet>, LinkError> {
        if let Some(bytes) = take(&mut self.main)? {
            return Ok(Some(match self.side {
                Side::Robot => Packet::LowCmd(bytes),
                Side::Runtime => Packet::LowState(bytes),
            }));
        }
        if let Some(reader) = &mut self.senses
            && let Some(bytes) = take(reader)?
        {
            let content = bytes.get(4..).unwrap_or_default();
            if let Ok(Senses(packet)) = postcard::from_bytes(content) {
                return Ok(Some(packet));
            }
        }
        if let Some(reader) = &mut self.commands
            && let Some(bytes) = take(reader)?
        {
            let own = self.own.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
            let crc = LowCmd::from_cdr(&bytes).ok().map(|command| command.crc);
            if crc.is_none_or(|crc| !own.contains(&crc)) {
                return Ok(Some(Packet::OthersCommand));
            }
        }
        Ok(None)
    }
}

impl Outlet for DdsLink {
    fn send(&mut self, packet: Packet) -> Result<(), LinkError> {
        self.outlet.send(packet)
    }
}

impl Inlet for DdsLink {
    fn receive(&mut self) -> Result<Option<Packet>, LinkError> {
        self.inlet.receive()
    }
}

impl Link for DdsLink {
    fn split(self) -> (Box<dyn Outlet>, Box<dyn Inlet>) {
        (Box::new(self.outlet), Box::new(self.inlet))
    }
}
