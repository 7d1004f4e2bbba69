//! The robot's own network: DDS by `rustdds`, on one domain and one interface that the caller names.
//!
//! The robot's topics have no key. Messages are read and written as bytes of CDR, so that [`crate::wire`] alone knows their fields.
//! DDS as the robot uses it has no authentication: anyone who reaches the network can command the robot.

use std::net::IpAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

use rustdds::bytes::Bytes;
use rustdds::dds::WriteError;
use rustdds::no_key::{DataReader, DataWriter, SerializerAdapter};
use rustdds::policy::{History, Reliability};
use rustdds::{DomainParticipant, QosPolicies, QosPolicyBuilder, RepresentationIdentifier, TopicKind};
use serde::{Deserialize, Serialize};

use crate::link::{Inlet, Link, LinkError, Outlet};
use crate::message::Packet;
use crate::published::Published;
use crate::raw::{Raw, RawError, participant, sent};
use crate::state_topic::StateTopic;
use crate::switcher::{Line, SWITCHER_TOPICS, SWITCHER_TYPES};
use crate::wire::{BmsState, Layout, LowCmd, LowState, Message};

/// Topics and types of the robot, and this project's own one.
const LOW_STATE: [&str; 2] = ["rt/lowstate", "unitree_hg::msg::dds_::LowState_"];
const LOW_CMD: [&str; 2] = ["rt/lowcmd", "unitree_hg::msg::dds_::LowCmd_"];
/// Low rate: the battery.
const BATTERY: [&str; 2] = ["rt/lf/bmsstate", "unitree_hg::msg::dds_::BmsState_"];
const SENSES: [&str; 2] = ["paid/senses", "paid::msg::Senses_"];
/// Commands on the network that may wait for the thinking thread: some periods of its own, with another program's in between.
const COMMANDS: i32 = 64;
/// This many of its own last commands are recognized when they come back.
const OWN: usize = 256;
/// This many commands in a row that found the way out full are a link that is broken, not a network that loses one: 50 ms.
const STUCK: u32 = 25;

/// Which side this is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The robot: sends states, receives commands.
    Robot,
    /// The runtime: sends commands, receives states.
    Runtime,
}

impl SerializerAdapter<LowCmd> for Raw<0> {
    type Error = RawError;
    fn output_encoding() -> RepresentationIdentifier {
        RepresentationIdentifier::CDR_LE
    }
    fn to_bytes(value: &LowCmd) -> Result<Bytes, RawError> {
        Ok(Bytes::copy_from_slice(&value.packed(Layout::Cdr)))
    }
}

/// What travels on the project's own topic: a CDR sequence of bytes with a packet in postcard.
#[derive(Serialize, Deserialize)]
struct Senses(Packet);

impl Senses {
    /// What a virtual robot's senses may send. Commands, states, keys and the like have topics of their own, or none.
    fn heard(self) -> Option<Packet> {
        let senses = matches!(
            self.0,
            Packet::Detection(_) | Packet::Odometry(_) | Packet::Goal(_) | Packet::GoalAhead(_)
        );
        senses.then_some(self.0)
    }
}

type RawWriter = DataWriter<Vec<u8>, Raw<0>>;
type CommandWriter = DataWriter<LowCmd, Raw<0>>;
type RawReader = DataReader<Vec<u8>, Raw<0>>;

/// An end of the link on the network.
pub struct DdsLink {
    outlet: DdsOutlet,
    inlet: DdsInlet,
}

/// Checksums of the commands that this process has sent last, without a lock: the writer must not wait for the reader.
struct Own {
    sums: [AtomicU64; OWN],
    next: AtomicUsize,
}

impl Own {
    fn new() -> Self {
        Self { sums: [const { AtomicU64::new(u64::MAX) }; OWN], next: AtomicUsize::new(0) }
    }
    fn add(&self, crc: u32) {
        let at = self.next.fetch_add(1, Ordering::Relaxed) % OWN;
        self.sums[at].store(u64::from(crc), Ordering::Release);
    }
    fn has(&self, crc: u32) -> bool {
        self.sums.iter().any(|own| own.load(Ordering::Acquire) == u64::from(crc))
    }
}

struct DdsOutlet {
    states: Option<RawWriter>,
    commands: Option<CommandWriter>,
    battery: Option<RawWriter>,
    senses: Option<RawWriter>,
    own: Arc<Own>,
    /// Commands in a row that found the way out full.
    stuck: u32,
    participant: DomainParticipant,
}

/// The motion switcher's topics from one side.
struct DdsLine {
    writer: RawWriter,
    reader: RawReader,
    _participant: DomainParticipant,
}

struct DdsInlet {
    side: Side,
    main: RawReader,
    battery: Option<RawReader>,
    senses: Option<RawReader>,
    /// Commands on the network, to notice those of others.
    commands: Option<RawReader>,
    own: Arc<Own>,
    /// Length of the last message on the topic of states that was none `[bytes]`; 0: there was none.
    odd: Arc<AtomicUsize>,
}

fn network(what: &'static str) -> impl Fn(String) -> LinkError {
    move |message| LinkError::Network { what, message }
}

impl DdsLink {
    /// Joins a domain through the interface that has this address. Nothing is chosen by itself.
    ///
    /// # Errors
    /// If this machine does not have the address, or the network cannot be joined.
    pub fn open(domain: u16, interface: IpAddr, side: Side) -> Result<Self, LinkError> {
        let fail = network("DDS");
        crate::interface::check(interface)?;
        let participant = participant(domain, interface).map_err(|e| fail(e.to_string()))?;
        let best_effort = |depth: i32| -> QosPolicies {
            QosPolicyBuilder::new()
                .reliability(Reliability::BestEffort)
                .history(History::KeepLast { depth })
                .build()
        };
        let qos = best_effort(1);
        let own = Arc::new(Own::new());
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
                .create_datawriter_no_key::<Vec<u8>, Raw<0>>(&topic(name)?, Some(qos.clone()))
                .map_err(|e| fail(e.to_string()))
        };
        let reader = |name: [&str; 2], qos: &QosPolicies| {
            subscriber
                .create_datareader_no_key::<Vec<u8>, Raw<0>>(&topic(name)?, Some(qos.clone()))
                .map_err(|e| fail(e.to_string()))
        };
        let main = match side {
            Side::Robot => LOW_CMD,
            Side::Runtime => LOW_STATE,
        };
        let senses_out = if side == Side::Robot { Some(writer(SENSES, &reliable)?) } else { None };
        let at_runtime = side == Side::Runtime;
        let senses_in = if at_runtime { Some(reader(SENSES, &reliable)?) } else { None };
        // As a rule the newest command is its own: another program's would hide behind it.
        let commands = if at_runtime { Some(reader(LOW_CMD, &best_effort(COMMANDS))?) } else { None };
        // A reliable writer serves readers of either kind.
        let states = if at_runtime { None } else { Some(writer(LOW_STATE, &reliable)?) };
        let battery_out = if at_runtime { None } else { Some(writer(BATTERY, &reliable)?) };
        let battery_in = if at_runtime { Some(reader(BATTERY, &qos)?) } else { None };
        let command_writer = |topic| {
            publisher
                .create_datawriter_no_key::<LowCmd, Raw<0>>(&topic, Some(reliable.clone()))
                .map_err(|e| fail(e.to_string()))
        };
        let command_writer = if at_runtime { Some(command_writer(topic(LOW_CMD)?)?) } else { None };
        let main = reader(main, &qos)?;
        Ok(Self {
            outlet: DdsOutlet {
                states,
                commands: command_writer,
                battery: battery_out,
                senses: senses_out,
                own: Arc::clone(&own),
                stuck: 0,
                participant,
            },
            inlet: DdsInlet {
                side,
                main,
                battery: battery_in,
                senses: senses_in,
                commands,
                own,
                odd: Arc::default(),
            },
        })
    }

    /// Why no state comes, for a runtime's side. One for each link: discovery reports once.
    pub fn state_topic(&self) -> StateTopic {
        let published = Published::new(&self.outlet.participant);
        StateTopic::new(published, LOW_STATE, Arc::clone(&self.inlet.odd))
    }

    /// The motion switcher's topics: a robot reads requests, a runtime responses.
    ///
    /// # Errors
    /// If the network refuses.
    pub fn switcher(&self) -> Result<Box<dyn Line>, LinkError> {
        let fail = network("DDS");
        let qos: QosPolicies = QosPolicyBuilder::new()
            .reliability(Reliability::Reliable { max_blocking_time: rustdds::Duration::from_millis(100) })
            .history(History::KeepLast { depth: 16 })
            .build();
        let participant = &self.outlet.participant;
        let topic = |k: usize| {
            let (name, kind) = (SWITCHER_TOPICS[k].to_owned(), SWITCHER_TYPES[k].to_owned());
            participant.create_topic(name, kind, &qos, TopicKind::NoKey).map_err(|e| fail(e.to_string()))
        };
        let (out, into) = if self.inlet.side == Side::Robot { (1, 0) } else { (0, 1) };
        let publisher = participant.create_publisher(&qos).map_err(|e| fail(e.to_string()))?;
        let subscriber = participant.create_subscriber(&qos).map_err(|e| fail(e.to_string()))?;
        let writer =
            publisher.create_datawriter_no_key(&topic(out)?, None).map_err(|e| fail(e.to_string()))?;
        let reader =
            subscriber.create_datareader_no_key(&topic(into)?, None).map_err(|e| fail(e.to_string()))?;
        Ok(Box::new(DdsLine { writer, reader, _participant: participant.clone() }))
    }
}

impl Outlet for DdsOutlet {
    fn send(&mut self, packet: Packet) -> Result<(), LinkError> {
        let fail = network("DDS write");
        let (writer, bytes) = match packet {
            Packet::LowState(bytes) => {
                let Some(states) = &self.states else { return Ok(()) };
                (states, bytes)
            }
            Packet::LowCmd(bytes) => {
                return LowCmd::from_cdr(&bytes).map_or(Ok(()), |command| self.command(&command));
            }
            Packet::Battery(percent) => {
                let Some(battery) = &self.battery else { return Ok(()) };
                (battery, BmsState::charged(percent).to_cdr())
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
        sent(writer.write(bytes, None)).map_err(|e| fail(e.to_string()))
    }

    fn command(&mut self, command: &LowCmd) -> Result<(), LinkError> {
        let Some(commands) = &self.commands else { return Ok(()) };
        self.own.add(command.crc);
        let fail = network("DDS write");
        match commands.write(command.clone(), None) {
            Ok(()) => self.stuck = 0,
            Err(WriteError::WouldBlock { .. }) if self.stuck < STUCK => self.stuck += 1,
            Err(WriteError::WouldBlock { .. }) => {
                return Err(fail("the send queue has been full for 50 ms".to_owned()));
            }
            Err(error) => return Err(fail(error.to_string())),
        }
        Ok(())
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
                Side::Runtime => {
                    if !(LowState::CDR_SIZE..=LowState::CDR_SIZE + 3).contains(&bytes.len()) {
                        self.odd.store(bytes.len(), Ordering::Relaxed);
                    }
                    Packet::LowState(bytes)
                }
            }));
        }
        if let Some(reader) = &mut self.battery {
            while let Some(bytes) = take(reader)? {
                if let Some(percent) = BmsState::from_cdr(&bytes).ok().and_then(|battery| battery.percent()) {
                    return Ok(Some(Packet::Battery(percent)));
                }
            }
        }
        if let Some(reader) = &mut self.senses {
            while let Some(bytes) = take(reader)? {
                let content = bytes.get(4..).unwrap_or_default();
                if let Some(packet) = postcard::from_bytes(content).ok().and_then(Senses::heard) {
                    return Ok(Some(packet));
                }
            }
        }
        if let Some(reader) = &mut self.commands {
            while let Some(bytes) = take(reader)? {
                let crc = LowCmd::from_cdr(&bytes).ok().map(|command| command.crc);
                if crc.is_none_or(|crc| !self.own.has(crc)) {
                    return Ok(Some(Packet::OthersCommand));
                }
            }
        }
        Ok(None)
    }
}

impl Line for DdsLine {
    fn send(&mut self, bytes: Vec<u8>) -> Result<(), LinkError> {
        sent(self.writer.write(bytes, None)).map_err(|e| network("DDS write")(e.to_string()))
    }
    fn receive(&mut self) -> Result<Option<Vec<u8>>, LinkError> {
        take(&mut self.reader)
    }
}

impl Outlet for DdsLink {
    fn send(&mut self, packet: Packet) -> Result<(), LinkError> {
        self.outlet.send(packet)
    }
    fn command(&mut self, command: &LowCmd) -> Result<(), LinkError> {
        self.outlet.command(command)
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
