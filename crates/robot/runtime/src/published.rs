//! Who publishes a topic, by DDS's discovery: why nothing arrives on it.

use std::sync::{Mutex, PoisonError};

use rustdds::policy::Reliability;
use rustdds::{
    DomainParticipant, DomainParticipantStatusEvent, DomainParticipantStatusListener, GUID, RTPSEntity,
    StatusEvented,
};

/// More writers are not kept apart: what comes from the network must not fill the memory.
const MOST_WRITERS: usize = 4096;
/// This many other topics of the same type are named.
const MOST_NAMED: usize = 3;
/// Longest name that is repeated to the operator, in letters.
const LONGEST_NAME: usize = 100;

/// What a reader asks for, by the names that the operator knows.
#[derive(Clone, Debug)]
pub(crate) struct Wanted {
    /// The topic's name on DDS.
    pub topic: String,
    /// The type's name on DDS.
    pub kind: String,
    /// Whether it receives only from writers that send again what was lost.
    pub reliable: bool,
    /// Whether both are names of ROS 2, to be shown as ROS 2 does.
    pub ros: bool,
}

/// A writer on the network.
#[derive(Clone, Debug)]
struct Found {
    topic: String,
    kind: String,
    reliable: bool,
}

/// Why nothing arrives on a topic.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Why {
    /// The reason, for the operator.
    pub text: String,
    /// True if the topic is published, but with another type.
    pub other_type: bool,
}

/// The writers that a participant has discovered.
pub(crate) struct Published {
    listener: DomainParticipantStatusListener,
    own: GUID,
    writers: Mutex<Vec<(GUID, Found)>>,
}

impl Published {
    /// What `participant` discovers from now on. It must be the only one that asks this participant.
    pub fn new(participant: &DomainParticipant) -> Self {
        let (listener, own) = (participant.status_listener(), participant.guid());
        Self { listener, own, writers: Mutex::default() }
    }

    /// Why nothing arrives, as far as discovery knows.
    pub fn why(&self, wanted: &Wanted) -> Why {
        self.update();
        let writers = self.writers.lock().unwrap_or_else(PoisonError::into_inner);
        why(wanted, writers.iter().map(|(_, found)| found))
    }

    /// Takes in what was discovered, to be called now and then: it waits in a queue that can be full.
    pub fn update(&self) {
        let mut writers = self.writers.lock().unwrap_or_else(PoisonError::into_inner);
        while let Some(event) = self.listener.try_recv_status() {
            match event {
                DomainParticipantStatusEvent::WriterDetected { writer }
                    if writer.guid.prefix != self.own.prefix =>
                {
                    let found = Found {
                        reliable: matches!(writer.qos.reliability(), Some(Reliability::Reliable { .. })),
                        topic: writer.topic_name,
                        kind: writer.type_name,
                    };
                    writers.retain(|(guid, _)| *guid != writer.guid);
                    if writers.len() < MOST_WRITERS {
                        writers.push((writer.guid, found));
                    }
                }
                DomainParticipantStatusEvent::WriterLost { guid, .. } => {
                    writers.retain(|(other, _)| *other != guid);
                }
                DomainParticipantStatusEvent::ParticipantLost { id, .. } => {
                    writers.retain(|(guid, _)| guid.prefix != id);
                }
                _ => {}
            }
        }
    }
}

fn why<'a>(wanted: &Wanted, all: impl Iterator<Item = &'a Found> + Clone) -> Why {
    let because = |text: String| Why { text, other_type: false };
    let (topic, kind) = (wanted.topic_name(&wanted.topic), wanted.kind_name(&wanted.kind));
    let here = || all.clone().filter(|found| found.topic == wanted.topic);
    let fitting = || here().filter(|found| found.kind == wanted.kind);
    if let (Some(other), None) = (here().next(), fitting().next()) {
        let text = format!("{topic} is published as {}, expected {kind}", wanted.kind_name(&other.kind));
        return Why { text, other_type: true };
    }
    if fitting().next().is_none() {
        let mut elsewhere: Vec<String> = all
            .filter(|found| found.kind == wanted.kind)
            .map(|found| wanted.topic_name(&found.topic))
            .collect();
        elsewhere.sort();
        elsewhere.dedup();
        elsewhere.truncate(MOST_NAMED);
        return because(match elsewhere.as_slice() {
            [] => format!("found no publisher of {topic}"),
            some => format!("found no publisher of {topic}; {kind} is published on {}", some.join(", ")),
        });
    }
    if wanted.reliable && fitting().all(|found| !found.reliable) {
        return because(format!(
            "{topic} is published best effort, expected reliable: read it with reliable = false"
        ));
    }
    because(format!("{topic} is published ({kind}), but nothing arrives"))
}

impl Wanted {
    /// A topic's name as the operator knows it.
    pub fn topic_name(&self, topic: &str) -> String {
        printable(if self.ros { topic.strip_prefix("rt").unwrap_or(topic) } else { topic })
    }

    fn kind_name(&self, kind: &str) -> String {
        let name = printable(kind);
        if self.ros {
            name.replace("::dds_::", "/").replace("::", "/").trim_end_matches('_').to_owned()
        } else {
            name
        }
    }
}

/// Text from the network, on one line.
fn printable(text: &str) -> String {
    text.chars().take(LONGEST_NAME).flat_map(char::escape_debug).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const IMAGE: &str = "sensor_msgs::msg::dds_::Image_";

    fn said(reliable: bool, writers: &[(&str, &str, bool)]) -> String {
        let found = |&(topic, kind, reliable): &(&str, &str, bool)| Found {
            topic: topic.to_owned(),
            kind: kind.to_owned(),
            reliable,
        };
        let writers: Vec<Found> = writers.iter().map(found).collect();
        let wanted = Wanted { topic: "rt/color".to_owned(), kind: IMAGE.to_owned(), reliable, ros: true };
        why(&wanted, writers.iter()).text
    }

    #[test]
    fn a_missing_publisher_another_type_and_another_quality_of_service_are_distinguished() {
        assert_eq!(said(false, &[("rt/rosout", "x", true)]), "found no publisher of /color");
        assert_eq!(
            said(
                false,
                &[("rt/b/color", IMAGE, true), ("rt/a/color", IMAGE, false), ("rt/a/color", IMAGE, true)]
            ),
            "found no publisher of /color; sensor_msgs/msg/Image is published on /a/color, /b/color"
        );
        assert_eq!(
            said(false, &[("rt/color", "sensor_msgs::msg::dds_::CompressedImage_", true)]),
            "/color is published as sensor_msgs/msg/CompressedImage, expected sensor_msgs/msg/Image"
        );
        assert_eq!(
            said(true, &[("rt/color", IMAGE, false)]),
            "/color is published best effort, expected reliable: read it with reliable = false"
        );
        let silent = "/color is published (sensor_msgs/msg/Image), but nothing arrives";
        assert_eq!(said(false, &[("rt/color", IMAGE, false)]), silent);
        assert_eq!(said(true, &[("rt/color", IMAGE, false), ("rt/color", IMAGE, true)]), silent);
        assert_eq!(said(false, &[("rt/color", "a\u{1b}[2J\n", true)]).matches(char::is_control).count(), 0);
    }
}
