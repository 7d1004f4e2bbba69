//! The topic of the robot's states: why no state comes.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use crate::published::{Published, Wanted, Why};
use crate::wire::LowState;

/// Without a state for this long the reason is reported: programs find each other within some seconds.
const PATIENCE: Duration = Duration::from_secs(3);
/// A reason that lasts is reported again after this time.
const AGAIN: Duration = Duration::from_secs(5);

/// What a runtime's end of the link knows of the topic of the robot's states. From another thread than the one that receives.
pub struct StateTopic {
    published: Published,
    wanted: Wanted,
    /// Length of the last message that was no state `[bytes]`; 0: there was none.
    odd: Arc<AtomicUsize>,
    states: u64,
    /// When a state came last.
    came: Instant,
    reported: Option<(String, Instant)>,
}

impl StateTopic {
    pub(crate) fn new(published: Published, [topic, kind]: [&str; 2], odd: Arc<AtomicUsize>) -> Self {
        let wanted = Wanted { topic: topic.to_owned(), kind: kind.to_owned(), reliable: false, ros: false };
        Self { published, wanted, odd, states: 0, came: Instant::now(), reported: None }
    }

    /// Why no state comes: another type, messages of another length, or no publisher.
    pub fn why(&self) -> String {
        why(&self.published.why(&self.wanted), &self.wanted.topic, self.odd.load(Ordering::Relaxed))
    }

    /// Why no state comes, if `states` (so far) have not become more for three seconds. The same reason is repeated every five.
    pub fn overdue(&mut self, states: u64) -> Option<String> {
        self.published.update();
        if states != self.states {
            (self.states, self.came, self.reported) = (states, Instant::now(), None);
        }
        if self.came.elapsed() < PATIENCE {
            return None;
        }
        let why = self.why();
        if self.reported.as_ref().is_some_and(|(last, at)| *last == why && at.elapsed() < AGAIN) {
            return None;
        }
        self.reported = Some((why.clone(), Instant::now()));
        Some(why)
    }
}

/// What discovery knows, and the length of the last message that was no state.
fn why(published: &Why, topic: &str, odd: usize) -> String {
    let Why { text, other_type } = published;
    let length = format!("expected messages of {} bytes, found {odd}", LowState::CDR_SIZE);
    let what = match (other_type, odd) {
        (_, 0) => text.clone(),
        (true, _) => format!("{text}; {length}"),
        (false, _) => format!("{topic}: {length}"),
    };
    let advice = if *other_type || odd > 0 {
        ": this program drives a G1 with 29 joints; a Go2, B2 or H1 sends another LowState_, and so may other firmware"
    } else {
        ""
    };
    format!("no state of the robot: {what}{advice}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_robots_states_are_recognized_by_type_and_length_and_what_is_expected() {
        let hg = "unitree_hg::msg::dds_::LowState_";
        let go = format!("rt/lowstate is published as unitree_go::msg::dds_::LowState_, expected {hg}");
        let advice = ": this program drives a G1 with 29 joints; a Go2, B2 or H1 sends another LowState_, and so may other firmware";
        let none = "found no publisher of rt/lowstate";
        let said =
            |text: &str, odd| why(&Why { text: text.to_owned(), other_type: text == go }, "rt/lowstate", odd);
        assert_eq!(said(none, 0), format!("no state of the robot: {none}"));
        assert_eq!(said(&go, 0), format!("no state of the robot: {go}{advice}"));
        let length = "expected messages of 2088 bytes, found 1180";
        assert_eq!(said(&go, 1180), format!("no state of the robot: {go}; {length}{advice}"));
        let silent = format!("rt/lowstate is published ({hg}), but nothing arrives");
        assert_eq!(said(&silent, 1180), format!("no state of the robot: rt/lowstate: {length}{advice}"));
    }
}
