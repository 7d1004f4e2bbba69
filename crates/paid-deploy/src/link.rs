//! The link between robot and runtime: a trait, and channels within one process.

use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, TrySendError, sync_channel};

use thiserror::Error;

use crate::message::Packet;

/// Packets that wait in a channel before new ones are dropped: half a second of everything.
const DEPTH: usize = 1024;

/// The link failed.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum LinkError {
    /// The other end is gone.
    #[error("the link is closed: the other end has ended")]
    Closed,
    /// The network refuses.
    #[error("{what}: {message}")]
    Network {
        /// What was attempted.
        what: &'static str,
        /// What the system says.
        message: String,
    },
}

/// One end of the link. Nothing here waits.
pub trait Link {
    /// Sends a packet. A network may lose it.
    ///
    /// # Errors
    /// If the link is closed or broken.
    fn send(&mut self, packet: Packet) -> Result<(), LinkError>;
    /// The next packet that has come, if any.
    ///
    /// # Errors
    /// If the link is closed or broken.
    fn receive(&mut self) -> Result<Option<Packet>, LinkError>;
}

/// An end of two channels.
#[derive(Debug)]
pub struct ChannelLink {
    to: SyncSender<Packet>,
    from: Receiver<Packet>,
}

impl ChannelLink {
    /// Both ends: what one sends the other receives, in order.
    ///
    /// ```
    /// use paid_deploy::{ChannelLink, Link, Packet};
    ///
    /// let (mut robot, mut runtime) = ChannelLink::pair();
    /// robot.send(Packet::Goal([5.0, 0.0]))?;
    /// assert_eq!(runtime.receive()?, Some(Packet::Goal([5.0, 0.0])));
    /// assert_eq!(runtime.receive()?, None);
    /// # Ok::<(), paid_deploy::LinkError>(())
    /// ```
    pub fn pair() -> (Self, Self) {
        let ((to_a, from_b), (to_b, from_a)) = (sync_channel(DEPTH), sync_channel(DEPTH));
        (Self { to: to_b, from: from_b }, Self { to: to_a, from: from_a })
    }
}

impl Link for ChannelLink {
    fn send(&mut self, packet: Packet) -> Result<(), LinkError> {
        match self.to.try_send(packet) {
            Ok(()) | Err(TrySendError::Full(_)) => Ok(()),
            Err(TrySendError::Disconnected(_)) => Err(LinkError::Closed),
        }
    }

    fn receive(&mut self) -> Result<Option<Packet>, LinkError> {
        match self.from.try_recv() {
            Ok(packet) => Ok(Some(packet)),
            Err(TryRecvError::Empty) => Ok(None),
            Err(TryRecvError::Disconnected) => Err(LinkError::Closed),
        }
    }
}
