//! The link between robot and runtime: a trait, and channels within one process.

use std::net::IpAddr;
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, TrySendError, sync_channel};

use thiserror::Error;

use crate::message::Packet;
use crate::wire::LowCmd;

/// Packets that wait in a channel before new ones are dropped: half a second of everything.
const DEPTH: usize = 1024;

/// The link failed.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum LinkError {
    /// The other end is gone.
    #[error("the link is closed: the other end has ended")]
    Closed,
    /// This machine does not have the address.
    #[error("interface: expected an address of this machine ({}), found {found}", listed(here))]
    Interface {
        /// What was named.
        found: IpAddr,
        /// Those that it has.
        here: Vec<IpAddr>,
    },
    /// The network refuses.
    #[error("{what}: {message}")]
    Network {
        /// What was attempted.
        what: &'static str,
        /// The system's error.
        message: String,
    },
}

fn listed(addresses: &[IpAddr]) -> String {
    addresses.iter().map(IpAddr::to_string).collect::<Vec<_>>().join(", ")
}

/// Where packets go out. Nothing here waits.
pub trait Outlet: Send {
    /// Sends a packet. A network may lose it.
    ///
    /// # Errors
    /// If the link is closed or broken.
    fn send(&mut self, packet: Packet) -> Result<(), LinkError>;

    /// Sends a command; the writer's way out, which allocates nothing before the network does.
    ///
    /// # Errors
    /// As [`Outlet::send`].
    fn command(&mut self, command: &LowCmd) -> Result<(), LinkError> {
        self.send(Packet::LowCmd(command.to_cdr()))
    }
}

/// Where packets come in. Nothing here waits.
pub trait Inlet: Send {
    /// The next packet that has come, if any.
    ///
    /// # Errors
    /// If the link is closed or broken.
    fn receive(&mut self) -> Result<Option<Packet>, LinkError>;
}

/// One end of the link.
pub trait Link: Outlet + Inlet {
    /// Its two directions, for two threads.
    fn split(self) -> (Box<dyn Outlet>, Box<dyn Inlet>);
}

/// An end of two channels.
#[derive(Debug)]
pub struct ChannelLink {
    to: ChannelOutlet,
    from: ChannelInlet,
}

#[derive(Debug)]
struct ChannelOutlet(SyncSender<Packet>);

#[derive(Debug)]
struct ChannelInlet(Receiver<Packet>);

impl ChannelLink {
    /// Both ends: what one sends the other receives, in order.
    ///
    /// ```
    /// use paid_runtime::{ChannelLink, Inlet, Outlet, Packet};
    ///
    /// let (mut robot, mut runtime) = ChannelLink::pair();
    /// robot.send(Packet::Goal([5.0, 0.0]))?;
    /// assert_eq!(runtime.receive()?, Some(Packet::Goal([5.0, 0.0])));
    /// assert_eq!(runtime.receive()?, None);
    /// # Ok::<(), paid_runtime::LinkError>(())
    /// ```
    pub fn pair() -> (Self, Self) {
        let ((to_a, from_b), (to_b, from_a)) = (sync_channel(DEPTH), sync_channel(DEPTH));
        let end = |to, from| Self { to: ChannelOutlet(to), from: ChannelInlet(from) };
        (end(to_b, from_b), end(to_a, from_a))
    }
}

impl Outlet for ChannelOutlet {
    fn send(&mut self, packet: Packet) -> Result<(), LinkError> {
        match self.0.try_send(packet) {
            Ok(()) | Err(TrySendError::Full(_)) => Ok(()),
            Err(TrySendError::Disconnected(_)) => Err(LinkError::Closed),
        }
    }
}

impl Inlet for ChannelInlet {
    fn receive(&mut self) -> Result<Option<Packet>, LinkError> {
        match self.0.try_recv() {
            Ok(packet) => Ok(Some(packet)),
            Err(TryRecvError::Empty) => Ok(None),
            Err(TryRecvError::Disconnected) => Err(LinkError::Closed),
        }
    }
}

impl Outlet for ChannelLink {
    fn send(&mut self, packet: Packet) -> Result<(), LinkError> {
        self.to.send(packet)
    }
}

impl Inlet for ChannelLink {
    fn receive(&mut self) -> Result<Option<Packet>, LinkError> {
        self.from.receive()
    }
}

impl Link for ChannelLink {
    fn split(self) -> (Box<dyn Outlet>, Box<dyn Inlet>) {
        (Box::new(self.to), Box::new(self.from))
    }
}
