//! Runs perception again on a recording.

use crate::{Believed, Message, Recorded, Recording, Sight, SightError, schema, seconds};

/// What a replay was.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Replay {
    /// Messages that reached perception.
    pub messages: usize,
    /// Images among them.
    pub pictures: usize,
    /// Steps that were answered.
    pub steps: usize,
    /// Recorded beliefs that came out again, to the last bit of every number.
    pub equal: usize,
    /// Time of the first recorded belief that did not `[s]`.
    pub first_different_s: Option<f64>,
    /// From the first message to the last `[s]`.
    pub span_s: f64,
    /// What the LiDAR's odometry said of its faults: each kind once, with its first time `[s]`.
    pub faults: Vec<(f64, String)>,
}

/// More kinds of faults are not kept.
const MOST_FAULTS: usize = 32;

impl Replay {
    /// Keeps a fault of a new kind: others have other figures.
    fn fault(&mut self, at_s: f64, fault: String) {
        let kind = fault_kind(&fault);
        let new = self.faults.iter().all(|(_, old)| fault_kind(old) != kind);
        if new && self.faults.len() < MOST_FAULTS {
            self.faults.push((at_s, fault));
        }
    }
}

/// The kind of a fault: its line without the figures.
pub fn fault_kind(line: &str) -> String {
    line.replace(|c: char| c.is_ascii_digit(), "")
}

/// Feeds `sight` with what a recording holds, and compares its estimates with the recorded ones. `see` gets every estimate.
///
/// # Errors
/// If the recording is damaged, does not fit this perception, or has no beliefs.
pub fn replay(
    recording: &Recording,
    sight: &mut Sight,
    mut see: impl FnMut(&Believed),
) -> Result<Replay, SightError> {
    let mut tally = Replay::default();
    let (mut first_s, mut last) = (None, None);
    recording.read(|recorded| {
        match &recorded {
            Recorded::Message(arrived) => {
                tally.messages += 1;
                tally.pictures += usize::from(matches!(arrived.message, Message::Picture(_)));
                let at_s = seconds(arrived.at_ns);
                tally.span_s = at_s - *first_s.get_or_insert(at_s);
                if let Some(believed) = sight.take(arrived)? {
                    see(&believed);
                    tally.steps += 1;
                    last = Some(believed);
                }
                if matches!(arrived.message, Message::Scan(_)) {
                    sight.lidar_faults().for_each(|fault| tally.fault(at_s, fault));
                }
            }
            Recorded::Believed { at_ns, .. } => {
                if last.as_ref().is_some_and(|believed| recorded.is(believed)) {
                    tally.equal += 1;
                } else {
                    tally.first_different_s.get_or_insert(seconds(*at_ns));
                }
            }
        }
        Ok(())
    })?;
    if tally.equal == 0 && tally.first_different_s.is_none() {
        let expected = "beliefs to compare with";
        return Err(recording.wrong(schema::BELIEVED.name, expected, "none".to_owned()));
    }
    Ok(tally)
}
