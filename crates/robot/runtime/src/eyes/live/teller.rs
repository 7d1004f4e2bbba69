//! Messages of perception to the operator.

use std::sync::mpsc::SyncSender;

/// Says a line once until another one comes.
pub(super) struct Teller {
    to: SyncSender<String>,
    last: String,
}

impl Teller {
    pub fn new(to: SyncSender<String>) -> Self {
        Self { to, last: String::new() }
    }

    /// Says a line unless it was the last one.
    pub fn tell(&mut self, line: String) {
        if line != self.last {
            // No receiver, or a slow one: that must not stop perception.
            let _ = self.to.try_send(line.clone());
            self.last = line;
        }
    }
}
