//! Threads whose panic must not pass unheard.

use std::sync::Arc;

use super::panics::guarded;
use crate::mailbox::Mailbox;

/// Where threads other than the control threads (perception, keyboard) report a panic. The thinking thread checks it every step, and damps.
#[derive(Clone, Debug, Default)]
pub struct LastWords(Arc<Mailbox<String>>);

impl LastWords {
    /// Runs a thread's work; its panic is reported under this name, before anything is printed.
    ///
    /// ```
    /// let words = paid_runtime::LastWords::default();
    /// assert_eq!(words.guard("counting", || 1 + 1), Some(2));
    /// assert_eq!(words.heard(), None);
    /// ```
    pub fn guard<R>(&self, name: &str, act: impl FnOnce() -> R) -> Option<R> {
        let to = Arc::clone(&self.0);
        // The other side is inside for well under a microsecond.
        guarded(name, move |words| while !to.put(words.clone()) {}, act)
    }

    /// A panic not yet read. Never waits.
    pub fn heard(&self) -> Option<String> {
        self.0.take()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_reported_once_and_with_its_thread() {
        let words = LastWords::default();
        let from = words.clone();
        let thread = std::thread::spawn(move || from.guard("eyes' ball", || panic!("a mote")));
        assert!(matches!(thread.join(), Ok(None::<()>)));
        assert_eq!(words.heard().as_deref(), Some("the eyes' ball thread has panicked: a mote"));
        assert_eq!(words.heard(), None);
    }
}
