//! `paid robot run --view`: draws the robot's state, and takes keys.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use paid_runtime::view::{Pressed, Screen, View};
use paid_runtime::{LastWords, Told, TypedKeys};

use crate::network::no_terminal;
use paid_terminal::Failure;

/// The terminal's end of a run.
pub struct Viewer {
    view: View,
    screen: Screen,
    over: Arc<AtomicBool>,
    keys: JoinHandle<()>,
}

impl Viewer {
    /// Takes the terminal. Keys of the remote go into `keys`; the end is asked for by `stop`; a keyboard's
    /// thread that panics reports in `last_words`.
    pub fn begin(
        keys: &Arc<TypedKeys>,
        stop: &Arc<AtomicBool>,
        last_words: &LastWords,
    ) -> Result<Self, Failure> {
        let screen = Screen::take().map_err(no_terminal)?;
        let over = Arc::new(AtomicBool::new(false));
        let (keys, stop, ended) = (Arc::clone(keys), Arc::clone(stop), Arc::clone(&over));
        let words = last_words.clone();
        let keys = std::thread::spawn(move || {
            words.guard("keyboard", || read_keys(&keys, &stop, &ended));
        });
        Ok(Self { view: View::default(), screen, over, keys })
    }

    /// Draws. A terminal that is gone does not end the run: the keyboard's thread notices.
    pub fn tell(&mut self, told: Told<'_>) {
        self.view.take(told);
        let _ = self.screen.draw(&self.view);
    }

    /// A line next to the transitions.
    pub fn note(&mut self, line: &str) {
        self.view.note(line);
    }

    /// Gives the terminal back.
    pub fn end(self) {
        self.over.store(true, Ordering::Relaxed);
        let _ = self.keys.join();
    }
}

/// Takes keys until it is over.
fn read_keys(keys: &TypedKeys, stop: &AtomicBool, ended: &AtomicBool) {
    while !ended.load(Ordering::Relaxed) {
        match Screen::key(Duration::from_millis(50)) {
            Ok(Some(Pressed::Remote(bits))) => keys.press(bits),
            Ok(Some(Pressed::Quit)) => stop.store(true, Ordering::Relaxed),
            Ok(None) => {}
            // Without a keyboard the run does not continue unseen.
            Err(_) => {
                stop.store(true, Ordering::Relaxed);
                return;
            }
        }
    }
}
