//! The topic of the robot's states: why no state comes.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use crate::published::{Published, Wanted};
use crate::wire::LowState;

/// Without a state for this long the reason is told: programs find each other within some seconds.
const PATIENCE: Duration = Duration::from_secs(3);
/// A reason that lasts is told again after this time.
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
    told: Option<(String, Instant)>,
}

impl StateTopic {
    pub(crate) fn new(published: Published, [topic, kind]: [&str; 2], odd: Arc<AtomicUsize>) -> Self {
        let wanted = Wanted { topic: topic.to_owned(), kind: kind.to_owned(), reliable: false, ros: false };
        Self { published, wanted, odd, states: 0, came: Instant::now(), told: None }
    }

    /// Why no state comes: another type, messages of another length, or nobody who publishes.
    pub fn why(&self) -> String {
        why(&self.published.why(&self.wanted), &self.wanted.topic, self.odd.load(Ordering::Relaxed))
    }

    /// Why no state comes, if `states` (so far) have not become more for three seconds. The same reason is told every five.
    pub fn overdue(&mut self, states: u64) -> Option<String> {
        self.published.update();
        if states != self.states {
            (self.states, self.came, self.told) = (states, Instant::now(), None);
        }
        if self.came.elapsed() < PATIENCE {
            return None;
        }
        let why = self.why();
        if self.told.as_ref().is_some_and(|(told, at)| *told == why && at.elapsed() < AGAIN) {
            return None;
        }
        self.told = Some((why.clone(), Instant::now()));
        Some(why)
    }
}

/// What discovery knows, and the length of the last message that was no state.
fn why(published: &str, topic: &str, odd: usize) -> String {
    let other_type = published.contains(" is published as ");
    let length = format!("expected messages of {} bytes, found {odd}", LowState::CDR_SIZE);
    let what = match (other_type, odd) {
        (_, 0) => published.to_owned(),
        (true, _) => format!("{published}; {length}"),
        (false, _) => format!("{topic}: {length}"),
    };
    let advice = if other_type || odd > 0 {
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
    fn another_robots_states_are_told_by_type_and_length_and_what_is_expected() {
        let hg = "unitree_hg::msg::dds_::LowState_";
        let go = format!("rt/lowstate is published as unitree_go::msg::dds_::LowState_, expected {hg}");
        let advice = ": this program drives a G1 with 29 joints; a Go2, B2 or H1 sends another LowState_, and so may other firmware";
        let nobody = "found nobody who publishes rt/lowstate";
        assert_eq!(why(nobody, "rt/lowstate", 0), format!("no state of the robot: {nobody}"));
        assert_eq!(why(&go, "rt/lowstate", 0), format!("no state of the robot: {go}{advice}"));
        let length = "expected messages of 2088 bytes, found 1180";
        assert_eq!(why(&go, "rt/lowstate", 1180), format!("no state of the robot: {go}; {length}{advice}"));
        let silent = format!("rt/lowstate is published ({hg}), but nothing arrives");
        assert_eq!(
            why(&silent, "rt/lowstate", 1180),
            format!("no state of the robot: rt/lowstate: {length}{advice}")
        );
    }
}
