//! Who is in command of the robot: the vendor's motion switcher, asked over its request and response topics.
//!
//! The vendor's own controller ("ai" and others) must be released before anybody else commands the joints. The robot answers requests by
//! number: 1001 asks who is in command, 1002 chooses a controller, 1003 releases it (the vendor's documentation of its motion switcher
//! service).

mod client;
mod message;
mod service;

pub use client::{Patience, Reply, SwitcherClient, await_release};
pub use message::{ApiRequest, ApiResponse};
pub use service::{Master, SwitcherService};

use crate::link::LinkError;

/// Topics of requests and responses.
pub const SWITCHER_TOPICS: [&str; 2] = ["rt/api/motion_switcher/request", "rt/api/motion_switcher/response"];
/// Their types.
pub const SWITCHER_TYPES: [&str; 2] =
    ["unitree_api::msg::dds_::Request_", "unitree_api::msg::dds_::Response_"];

/// Says who is in command.
pub const CHECK_MODE: i64 = 1001;
/// Chooses a controller of the vendor.
pub const SELECT_MODE: i64 = 1002;
/// Releases the vendor's controller.
pub const RELEASE_MODE: i64 = 1003;

/// One end of the pair of topics: bytes of CDR out, bytes of CDR in. Nothing here waits.
pub trait Line: Send {
    /// Sends a message. A network may lose it.
    ///
    /// # Errors
    /// If the network is broken.
    fn send(&mut self, bytes: Vec<u8>) -> Result<(), LinkError>;

    /// The next message that has come, if any.
    ///
    /// # Errors
    /// If the network is broken.
    fn receive(&mut self) -> Result<Option<Vec<u8>>, LinkError>;
}

impl<L: Line + ?Sized> Line for Box<L> {
    fn send(&mut self, bytes: Vec<u8>) -> Result<(), LinkError> {
        (**self).send(bytes)
    }
    fn receive(&mut self) -> Result<Option<Vec<u8>>, LinkError> {
        (**self).receive()
    }
}
