//! The wireless remote's 40 bytes.

use std::str::FromStr;

/// The keys for damping, as the vendor's.
pub const DAMPING_KEYS: [Key; 2] = [Key::L2, Key::B];

/// A key of the remote; the number is its bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Key {
    /// Right shoulder.
    R1 = 0,
    /// Left shoulder.
    L1 = 1,
    /// Start.
    Start = 2,
    /// Select.
    Select = 3,
    /// Right trigger.
    R2 = 4,
    /// Left trigger.
    L2 = 5,
    /// F1.
    F1 = 6,
    /// F2.
    F2 = 7,
    /// A.
    A = 8,
    /// B.
    B = 9,
    /// X.
    X = 10,
    /// Y.
    Y = 11,
    /// Cross up.
    Up = 12,
    /// Cross right.
    Right = 13,
    /// Cross down.
    Down = 14,
    /// Cross left.
    Left = 15,
}

impl FromStr for Key {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        const KEYS: [(&str, Key); 16] = [
            ("r1", Key::R1),
            ("l1", Key::L1),
            ("start", Key::Start),
            ("select", Key::Select),
            ("r2", Key::R2),
            ("l2", Key::L2),
            ("f1", Key::F1),
            ("f2", Key::F2),
            ("a", Key::A),
            ("b", Key::B),
            ("x", Key::X),
            ("y", Key::Y),
            ("up", Key::Up),
            ("right", Key::Right),
            ("down", Key::Down),
            ("left", Key::Left),
        ];
        let found = KEYS.iter().find(|(name, _)| text.eq_ignore_ascii_case(name));
        found.map(|(_, key)| *key).ok_or_else(|| format!("a key: expected L2, Up, ..., found '{text}'"))
    }
}

/// The remote's message: two bytes of head, two of keys, then the sticks `lx`, `rx`, `ry`, the left trigger and `ly` as floats.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Remote {
    /// One bit a key.
    pub keys: u16,
    /// True where any byte is set: a remote that is off leaves all of them zero.
    pub present: bool,
}

impl Remote {
    /// The head that the virtual robot sends for a remote that is switched on.
    pub const HEAD: [u8; 2] = [0x55, 0x51];

    /// From the message's bytes.
    pub fn new(bytes: &[u8; 40]) -> Self {
        Self { keys: u16::from_le_bytes([bytes[2], bytes[3]]), present: bytes.iter().any(|b| *b != 0) }
    }

    /// A remote with these keys down.
    pub fn pressing(keys: &[Key]) -> [u8; 40] {
        let mut bytes = [0; 40];
        bytes[..2].copy_from_slice(&Self::HEAD);
        let bits = keys.iter().fold(0_u16, |bits, key| bits | 1 << *key as u16);
        bytes[2..4].copy_from_slice(&bits.to_le_bytes());
        bytes
    }

    /// True if all of these keys are down.
    pub fn holds(&self, keys: &[Key]) -> bool {
        keys.iter().all(|key| self.keys >> *key as u16 & 1 == 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stop_keys_are_bits_5_and_9() {
        let bytes = Remote::pressing(&[Key::L2, Key::B]);
        assert_eq!(bytes[2..4], [0x20, 0x02]);
        let remote = Remote::new(&bytes);
        assert!(remote.holds(&[Key::L2, Key::B]) && !remote.holds(&[Key::L2, Key::Up]) && remote.present);
        assert!(!Remote::new(&[0; 40]).present);
    }
}
