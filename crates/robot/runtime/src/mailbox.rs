//! The newest value from one thread to another. Neither side waits for the other.

use std::sync::{Mutex, TryLockError};

/// Holds the newest value. A side that finds it in use continues without it: the next value is milliseconds away.
#[derive(Debug)]
pub struct Mailbox<T>(Mutex<Option<T>>);

impl<T> Default for Mailbox<T> {
    fn default() -> Self {
        Self(Mutex::new(None))
    }
}

impl<T> Mailbox<T> {
    fn try_with<R>(&self, act: impl FnOnce(&mut Option<T>) -> R) -> Option<R> {
        match self.0.try_lock() {
            Ok(mut slot) => Some(act(&mut slot)),
            // A thread that panicked between two whole values has left a whole one.
            Err(TryLockError::Poisoned(slot)) => Some(act(&mut slot.into_inner())),
            Err(TryLockError::WouldBlock) => None,
        }
    }

    /// Puts a value in the place of the last one; false if the other side was just looking.
    pub fn put(&self, value: T) -> bool {
        self.try_with(|slot| *slot = Some(value)).is_some()
    }

    /// Takes the newest value, if there is one that was not taken yet and the other side is not just writing.
    pub fn take(&self) -> Option<T> {
        self.try_with(Option::take).flatten()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_value_is_taken_once_and_neither_side_waits() {
        let mailbox = Mailbox::default();
        assert_eq!(mailbox.take(), None);
        assert!(mailbox.put(1) && mailbox.put(2));
        assert_eq!(mailbox.take(), Some(2));
        assert_eq!(mailbox.take(), None);
        // While one side is inside, the other continues without it.
        let inside = mailbox.0.lock().expect("free");
        assert!(!mailbox.put(3));
        assert_eq!(mailbox.take(), None);
        drop(inside);
        assert!(mailbox.put(4));
    }

    #[test]
    fn a_panic_inside_does_not_close_it() {
        let mailbox = std::sync::Arc::new(Mailbox::<u32>::default());
        let other = std::sync::Arc::clone(&mailbox);
        let ended = std::thread::spawn(move || {
            let _inside = other.0.lock().expect("free");
            panic!("inside");
        });
        assert!(ended.join().is_err());
        assert!(mailbox.put(5));
        assert_eq!(mailbox.take(), Some(5));
    }
}
