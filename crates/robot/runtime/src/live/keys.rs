//! Keys of the remote from the keyboard.

use std::sync::atomic::{AtomicU16, Ordering};

/// Keys of the remote that the operator has typed, a bit each, on their way to the thinking thread. A key replaces no other one: stop keys that
/// were not taken yet stay. Neither side waits for the other.
#[derive(Debug, Default)]
pub struct TypedKeys(AtomicU16);

impl TypedKeys {
    /// Adds keys to those that were not taken yet.
    pub fn press(&self, bits: u16) {
        self.0.fetch_or(bits, Ordering::Relaxed);
    }

    /// Takes the keys that were typed since the last call, if there are any.
    pub fn take(&self) -> Option<u16> {
        Some(self.0.swap(0, Ordering::Relaxed)).filter(|bits| *bits != 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::{DAMPING_KEYS, Key, Remote};

    #[test]
    fn stop_keys_are_not_lost_to_a_key_that_is_typed_right_after_them() {
        let bits = |keys: &[Key]| keys.iter().fold(0_u16, |bits, key| bits | 1 << *key as u16);
        let typed = TypedKeys::default();
        assert_eq!(typed.take(), None);
        typed.press(bits(&DAMPING_KEYS));
        typed.press(bits(&[Key::R1, Key::X]));
        let keys = typed.take().expect("typed");
        assert!(Remote { keys, present: true }.holds(&DAMPING_KEYS), "{keys:#06x}");
        assert_eq!(typed.take(), None, "once");
    }
}
