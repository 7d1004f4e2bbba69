//! Topics of ROS 2 on DDS, as bytes of CDR.
//!
//! A topic `/camera/color/image_raw` of ROS 2 is `rt/camera/color/image_raw` on DDS, and `sensor_msgs/Image` is
//! `sensor_msgs::msg::dds_::Image_`. That is all that a subscription needs: nodes, parameters and services of ROS 2 are other topics.
//!
//! By `rustdds`, which the robot's own topics use already, and not by `ros2-client` (0.12), which stands on it: that crate adds what a node
//! needs and these subscriptions do not (graph, services, actions, parameters and an executor), and reads messages field by field, an image
//! byte by byte. Both are maintained by the same people.
//!
//! Images have a participant of their own, and with it a thread and sockets: half a megabyte does not stand in the way of a command.
//! A reader takes what a driver offers, reliable or not (`best effort`). The writers are reliable, which serves readers of either kind.

mod lidar;

pub use lidar::{AccelUnit, LidarTopics};

use std::net::IpAddr;
use std::sync::Arc;
use std::time::{Duration, Instant};

use rustdds::no_key::{DataReader, DataWriter};
use rustdds::policy::{Durability, History, Reliability};
use rustdds::{DataWriterStatus, DomainParticipant, QosPolicies, QosPolicyBuilder, StatusEvented, TopicKind};

use crate::link::LinkError;
use crate::published::{Published, Wanted};
use crate::raw::{Raw, participant, sent};

/// `sensor_msgs/Image` on DDS.
pub const IMAGE: &str = "sensor_msgs::msg::dds_::Image_";
/// `sensor_msgs/CameraInfo`.
pub const CAMERA_INFO: &str = "sensor_msgs::msg::dds_::CameraInfo_";
/// `sensor_msgs/PointCloud2`.
pub const POINT_CLOUD: &str = "sensor_msgs::msg::dds_::PointCloud2_";
/// `sensor_msgs/Imu`.
pub const IMU: &str = "sensor_msgs::msg::dds_::Imu_";
/// `nav_msgs/Odometry`.
pub const ODOMETRY: &str = "nav_msgs::msg::dds_::Odometry_";

/// Messages that may wait for their reader: of most topics the newest ones are enough ...
const WAITING: i32 = 4;
/// ... but odometry needs every sample of an inertial sensor, also of the time in which it is busy with a scan: 0.6 s at 200 Hz.
const WAITING_SAMPLES: i32 = 128;
/// A topic without a message for this long is silent.
const SILENT: Duration = Duration::from_secs(1);

fn failed(error: impl ToString) -> LinkError {
    LinkError::Network { what: "ROS 2 topics", message: error.to_string() }
}

/// A participant for topics of ROS 2.
pub struct RosTopics {
    participant: DomainParticipant,
    published: Arc<Published>,
}

/// A subscription.
pub struct RosReader {
    reader: DataReader<Vec<u8>, Raw<4>>,
    wanted: Wanted,
    published: Arc<Published>,
    /// When the last message came; at first when the subscription began.
    came: Instant,
}

/// A publication.
pub struct RosWriter {
    writer: DataWriter<Vec<u8>, Raw<4>>,
    readers: i32,
}

impl RosTopics {
    /// Joins a domain through the interface that has this address.
    ///
    /// # Errors
    /// If this machine does not have the address, or the network cannot be joined.
    pub fn open(domain: u16, interface: IpAddr) -> Result<Self, LinkError> {
        crate::interface::check(interface)?;
        let participant = participant(domain, interface).map_err(failed)?;
        let published = Arc::new(Published::new(&participant));
        Ok(Self { participant, published })
    }

    /// Reads `name`, such as `/camera/color/image_raw`. `reliable` asks for what was lost, and receives only from writers that offer that.
    ///
    /// # Errors
    /// If the topic cannot be had.
    pub fn reader(&self, name: &str, kind: &str, reliable: bool) -> Result<RosReader, LinkError> {
        let qos = qos(reliable, if kind == IMU { WAITING_SAMPLES } else { WAITING });
        let topic = self.topic(name, kind, &qos)?;
        let subscriber = self.participant.create_subscriber(&qos).map_err(failed)?;
        let reader = subscriber.create_datareader_no_key(&topic, Some(qos)).map_err(failed)?;
        let wanted = Wanted { topic: on_dds(name), kind: kind.to_owned(), reliable, ros: true };
        Ok(RosReader { reader, wanted, published: Arc::clone(&self.published), came: Instant::now() })
    }

    /// Writes `name`.
    ///
    /// # Errors
    /// If the topic cannot be had.
    pub fn writer(&self, name: &str, kind: &str) -> Result<RosWriter, LinkError> {
        let qos = qos(true, 2);
        let topic = self.topic(name, kind, &qos)?;
        let publisher = self.participant.create_publisher(&qos).map_err(failed)?;
        let writer = publisher.create_datawriter_no_key(&topic, Some(qos)).map_err(failed)?;
        Ok(RosWriter { writer, readers: 0 })
    }

    fn topic(&self, name: &str, kind: &str, qos: &QosPolicies) -> Result<rustdds::Topic, LinkError> {
        self.participant.create_topic(on_dds(name), kind.to_owned(), qos, TopicKind::NoKey).map_err(failed)
    }
}

/// The name on DDS of a topic of ROS 2.
fn on_dds(name: &str) -> String {
    format!("rt{name}")
}

fn qos(reliable: bool, depth: i32) -> QosPolicies {
    let reliability = if reliable {
        Reliability::Reliable { max_blocking_time: rustdds::Duration::from_millis(1) }
    } else {
        Reliability::BestEffort
    };
    QosPolicyBuilder::new()
        .reliability(reliability)
        .durability(Durability::Volatile)
        .history(History::KeepLast { depth })
        .build()
}

impl RosReader {
    /// The next message in CDR with its header, if one has come.
    ///
    /// # Errors
    /// A message that cannot be read; the next ones may be.
    pub fn take(&mut self) -> Result<Option<Vec<u8>>, LinkError> {
        let sample = self.reader.take_next_sample().map_err(failed)?.map(|sample| sample.into_value());
        match &sample {
            Some(_) => self.came = Instant::now(),
            None => self.published.update(),
        }
        Ok(sample)
    }

    /// If nothing has come for a second: who publishes the topic, by DDS's discovery, which takes seconds where there is no multicast.
    pub fn silent(&self) -> Option<String> {
        (self.came.elapsed() > SILENT).then(|| self.published.why(&self.wanted).text)
    }
}

impl RosWriter {
    /// Sends a message in CDR with its header. A full queue drops it.
    ///
    /// # Errors
    /// If the network fails.
    pub fn send(&self, bytes: Vec<u8>) -> Result<(), LinkError> {
        sent(self.writer.write(bytes, None)).map_err(failed)
    }

    /// Whether it has a reader.
    pub fn is_heard(&mut self) -> bool {
        while let Some(status) = self.writer.try_recv_status() {
            if let DataWriterStatus::PublicationMatched { current, .. } = status {
                self.readers = current.count();
            }
        }
        self.readers > 0
    }
}
