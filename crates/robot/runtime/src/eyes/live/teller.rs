//! What onboard perception reports to the operator.

use std::sync::mpsc::SyncSender;
use std::time::{Duration, Instant};

use paid_world::fault_kind;

/// A fault that lasts is reported again after this time.
const AGAIN: Duration = Duration::from_secs(5);
/// A sensor works again once it has had no fault for this long.
const QUIET: Duration = Duration::from_secs(1);
/// More kinds of lines within [`AGAIN`] are not kept apart: text from the network must not fill the memory.
const MOST_KINDS: usize = 32;

/// Reports a fault once, again while it lasts, and once when it is over.
pub(super) struct Teller {
    to: SyncSender<String>,
    /// The kinds of lines that were reported lately, with the time.
    lately: Vec<(String, Instant)>,
    /// The last fault.
    fault: Option<Instant>,
    works: bool,
}

impl Teller {
    pub fn new(to: SyncSender<String>) -> Self {
        Self { to, lately: Vec::new(), fault: None, works: false }
    }

    /// Reports a fault, unless one of the same kind, which may have other figures, was reported lately.
    pub fn tell(&mut self, line: String) {
        self.tell_at(Instant::now(), line);
    }

    /// Reports that a sensor works, once after its faults.
    pub fn well(&mut self, line: &str) {
        self.well_at(Instant::now(), line);
    }

    fn tell_at(&mut self, now: Instant, line: String) {
        (self.fault, self.works) = (Some(now), false);
        self.lately.retain(|(_, at)| now.duration_since(*at) < AGAIN);
        let kind = fault_kind(&line);
        if self.lately.len() < MOST_KINDS && self.lately.iter().all(|(other, _)| *other != kind) {
            self.lately.push((kind, now));
            // If no one reads the lines, or too slowly, that must not stop perception.
            let _ = self.to.try_send(line);
        }
    }

    fn well_at(&mut self, now: Instant, line: &str) {
        let quiet = self.fault.is_none_or(|fault| now.duration_since(fault) >= QUIET);
        if quiet && !std::mem::replace(&mut self.works, true) {
            self.lately.clear();
            let _ = self.to.try_send(line.to_owned());
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::sync_channel;

    use super::*;

    #[test]
    fn a_fault_is_reported_once_again_while_it_lasts_and_once_when_it_is_over() {
        let (to, lines) = sync_channel(64);
        let mut teller = Teller::new(to);
        let begin = Instant::now();
        let at = |ms: u64| begin + Duration::from_millis(ms);
        // Two faults in turns, thirty times a second for six seconds, with good images between them.
        for k in 0..180_u64 {
            teller.tell_at(at(33 * k), format!("camera: an image of {k} pixels"));
            teller.tell_at(at(33 * k + 5), "camera: frame 'a'".to_owned());
            teller.well_at(at(33 * k + 10), "camera: images arriving");
        }
        for ms in [6500, 7100, 7200] {
            teller.well_at(at(ms), "camera: images arriving");
        }
        teller.tell_at(at(7300), "camera: frame 'a'".to_owned());
        let said: Vec<String> = lines.try_iter().collect();
        let expected = [
            "camera: an image of 0 pixels",
            "camera: frame 'a'",
            "camera: an image of 152 pixels",
            "camera: frame 'a'",
            "camera: images arriving",
            "camera: frame 'a'",
        ];
        assert_eq!(said, expected);
    }
}
