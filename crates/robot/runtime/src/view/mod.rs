//! The runtime on a terminal: drawn from the same status that the JSON lines have.

mod draw;
mod screen;

pub use screen::{Pressed, Screen};

use crate::live::{LiveStatus, Told};

/// What is shown: the newest status and the last event.
#[derive(Clone, Debug, Default)]
pub struct View {
    status: Option<LiveStatus>,
    last: String,
}

impl View {
    /// Takes in what is reported.
    pub fn take(&mut self, told: Told<'_>) {
        match told {
            Told::Event(event) => {
                let change = match (event.from, event.to) {
                    (from, to) if from == to => String::new(),
                    (from, to) => format!("{from} -> {to}: "),
                };
                self.last = format!("{:.2} s  {change}{}", event.at_us as f64 * 1e-6, event.reason);
            }
            Told::Status(status) => self.status = Some(*status),
        }
    }

    /// Takes in a line that is no transition, such as one of perception.
    pub fn note(&mut self, line: &str) {
        line.clone_into(&mut self.last);
    }
}
