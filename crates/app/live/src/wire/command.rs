//! What a visitor wants.

use thiserror::Error;

use super::VERSION;

/// Farthest place from the pitch's middle `[m]`.
const FARTHEST_M: f32 = 30.0;
/// Fastest ball that a hand can let go `[m/s]`.
const FASTEST_M_S: f32 = 12.0;
/// Hardest push `[N s]`: a G1 of 33 kg then moves at 3.6 m/s.
const HARDEST_N_S: f32 = 120.0;
/// Slowest and fastest course of time.
const RATES: [f32; 2] = [0.05, 1.0];

/// A message of the page: version, kind, then the values in order.
///
/// ```
/// use paid_live::{Command, VERSION};
///
/// let bytes = Command::Pause(true).encode();
/// assert_eq!(bytes, [VERSION, 6, 1]);
/// assert_eq!(Command::decode(&bytes), Ok(Command::Pause(true)));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Command {
    /// Kind 1: a hand holds the ball at (x, y) `[m]`.
    Hold([f32; 2]),
    /// Kind 2: the hand lets go of the ball at (x, y) `[m]` with this velocity `[m/s]`.
    Drop {
        /// Where.
        at: [f32; 2],
        /// How fast.
        velocity: [f32; 2],
    },
    /// Kind 3: the goal's middle is at (x, y) `[m]`.
    Goal([f32; 2]),
    /// Kind 4: a horizontal impulse on the robot `[N s]`.
    Push([f32; 2]),
    /// Kind 5: kick with this clip; `None` (-1): the one that suits the ball.
    Clip(Option<u16>),
    /// Kind 6: time stands still, or continues.
    Pause(bool),
    /// Kind 7: one control step.
    Step,
    /// Kind 8: the course of time; 1 is real time.
    Rate(f32),
    /// Kind 9: 0 the built-in engine, 1 MuJoCo.
    Engine(u8),
    /// Kind 10: balls come by themselves.
    Auto(bool),
    /// Kind 11: the robot stands up where it began.
    Reset,
    /// Kind 12: score, shots and heat map start again.
    Clear,
    /// Kind 13: the robot takes its first pose before every kick; otherwise it continues from its present pose.
    Fresh(bool),
    /// Kind 14: a ball at a random place in reach.
    Another,
    /// Kind 15: the ball and ground of this number: 0 those of the scene, then the panel's in MuJoCo.
    Surface(u8),
    /// Kind 16: what is only watched ends, as its safety says: a robot is damped.
    Stop,
}

/// Why a message is dropped.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum CommandError {
    /// Another version, or an empty message.
    #[error("version: expected {VERSION}, found {0:?}")]
    Version(Option<u8>),
    /// No such kind.
    #[error("kind: expected 1 to 16, found {0:?}")]
    Kind(Option<u8>),
    /// Too short or too long.
    #[error("kind {kind}: expected {expected} bytes, found {found}")]
    Length {
        /// Kind of the message.
        kind: u8,
        /// Its bytes.
        expected: usize,
        /// The bytes that came.
        found: usize,
    },
    /// A number that is none, or beyond its limits.
    #[error("kind {kind}: a value is out of range")]
    Value {
        /// Kind of the message.
        kind: u8,
    },
}

/// Bytes of the values of each kind, from kind 1 on.
const SIZES: [usize; 16] = [8, 16, 8, 8, 2, 1, 0, 4, 1, 1, 0, 0, 1, 0, 1, 0];

fn f32_at(bytes: &[u8], at: usize) -> f32 {
    let mut word = [0; 4];
    word.copy_from_slice(&bytes[at..at + 4]);
    f32::from_le_bytes(word)
}

impl Command {
    /// Reads a message.
    ///
    /// # Errors
    /// If it is not exactly one command of this version with values within their limits.
    pub fn decode(bytes: &[u8]) -> Result<Self, CommandError> {
        if bytes.first() != Some(&VERSION) {
            return Err(CommandError::Version(bytes.first().copied()));
        }
        let kind = bytes.get(1).copied();
        let size = kind.and_then(|k| SIZES.get(usize::from(k).wrapping_sub(1)));
        let (Some(kind), Some(size)) = (kind, size) else { return Err(CommandError::Kind(kind)) };
        let values = &bytes[2..];
        if values.len() != *size {
            return Err(CommandError::Length { kind, expected: 2 + size, found: bytes.len() });
        }
        let bad = CommandError::Value { kind };
        let pair = |at: usize, limit: f32| {
            let v = [f32_at(values, at), f32_at(values, at + 4)];
            // Also false for what is no number.
            if v[0].hypot(v[1]) <= limit { Ok(v) } else { Err(bad) }
        };
        let flag = || match values[0] {
            0 => Ok(false),
            1 => Ok(true),
            _ => Err(bad),
        };
        Ok(match kind {
            1 => Self::Hold(pair(0, FARTHEST_M)?),
            2 => Self::Drop { at: pair(0, FARTHEST_M)?, velocity: pair(8, FASTEST_M_S)? },
            3 => Self::Goal(pair(0, FARTHEST_M)?),
            4 => Self::Push(pair(0, HARDEST_N_S)?),
            5 => match i16::from_le_bytes([values[0], values[1]]) {
                -1 => Self::Clip(None),
                clip => Self::Clip(Some(u16::try_from(clip).map_err(|_| bad)?)),
            },
            6 => Self::Pause(flag()?),
            7 => Self::Step,
            8 => {
                let rate = f32_at(values, 0);
                if !(RATES[0]..=RATES[1]).contains(&rate) {
                    return Err(bad);
                }
                Self::Rate(rate)
            }
            9 => Self::Engine(u8::from(flag()?)),
            10 => Self::Auto(flag()?),
            11 => Self::Reset,
            12 => Self::Clear,
            13 => Self::Fresh(flag()?),
            14 => Self::Another,
            15 => Self::Surface(values[0]),
            _ => Self::Stop,
        })
    }

    /// The message.
    pub fn encode(&self) -> Vec<u8> {
        let floats = |values: &[f32]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
        let (kind, values) = match *self {
            Self::Hold(at) => (1, floats(&at)),
            Self::Drop { at, velocity } => (2, floats(&[at, velocity].concat())),
            Self::Goal(at) => (3, floats(&at)),
            Self::Push(impulse) => (4, floats(&impulse)),
            Self::Clip(clip) => {
                let number = clip.map_or(-1, |c| i16::try_from(c).unwrap_or(i16::MAX));
                (5, number.to_le_bytes().to_vec())
            }
            Self::Pause(on) => (6, vec![u8::from(on)]),
            Self::Step => (7, Vec::new()),
            Self::Rate(rate) => (8, floats(&[rate])),
            Self::Engine(engine) => (9, vec![engine]),
            Self::Auto(on) => (10, vec![u8::from(on)]),
            Self::Reset => (11, Vec::new()),
            Self::Clear => (12, Vec::new()),
            Self::Fresh(on) => (13, vec![u8::from(on)]),
            Self::Another => (14, Vec::new()),
            Self::Surface(number) => (15, vec![number]),
            Self::Stop => (16, Vec::new()),
        };
        [vec![VERSION, kind], values].concat()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_ball_let_go_is_these_eighteen_bytes() {
        let drop = Command::Drop { at: [1.0, -0.5], velocity: [0.0, 2.0] };
        // 1.0 is 0x3F800000, -0.5 is 0xBF000000, 2.0 is 0x40000000.
        let bytes = [VERSION, 2, 0, 0, 0x80, 0x3F, 0, 0, 0, 0xBF, 0, 0, 0, 0, 0, 0, 0, 0x40];
        assert_eq!(drop.encode(), bytes);
        assert_eq!(Command::decode(&bytes), Ok(drop));
    }

    #[test]
    fn clips_are_numbers_and_minus_one_is_none() {
        assert_eq!(Command::Clip(None).encode(), [VERSION, 5, 0xFF, 0xFF]);
        assert_eq!(Command::decode(&[VERSION, 5, 0x02, 0x01]), Ok(Command::Clip(Some(258))));
        assert_eq!(Command::decode(&[VERSION, 5, 0xFE, 0xFF]), Err(CommandError::Value { kind: 5 }));
    }

    #[test]
    fn another_version_a_wrong_length_or_a_value_beyond_its_limits_is_refused() {
        assert_eq!(Command::decode(&[]), Err(CommandError::Version(None)));
        assert_eq!(Command::decode(&[VERSION + 1, 7]), Err(CommandError::Version(Some(VERSION + 1))));
        assert_eq!(Command::decode(&[VERSION]), Err(CommandError::Kind(None)));
        assert_eq!(Command::decode(&[VERSION, 0]), Err(CommandError::Kind(Some(0))));
        assert_eq!(Command::decode(&[VERSION, 17]), Err(CommandError::Kind(Some(17))));
        assert_eq!(
            Command::decode(&[VERSION, 7, 0]),
            Err(CommandError::Length { kind: 7, expected: 2, found: 3 })
        );
        assert_eq!(Command::decode(&[VERSION, 6, 2]), Err(CommandError::Value { kind: 6 }));
        for bad in [f32::NAN, f32::INFINITY, 31.0] {
            assert_eq!(
                Command::decode(&Command::Hold([bad, 0.0]).encode()),
                Err(CommandError::Value { kind: 1 })
            );
        }
        assert_eq!(Command::decode(&Command::Rate(0.0).encode()), Err(CommandError::Value { kind: 8 }));
    }

    fn safe(command: &Command) -> bool {
        let near = |v: [f32; 2], limit: f32| v[0].hypot(v[1]) <= limit;
        match *command {
            Command::Hold(at) | Command::Goal(at) => near(at, FARTHEST_M),
            Command::Drop { at, velocity } => near(at, FARTHEST_M) && near(velocity, FASTEST_M_S),
            Command::Push(impulse) => near(impulse, HARDEST_N_S),
            Command::Rate(rate) => (RATES[0]..=RATES[1]).contains(&rate),
            _ => true,
        }
    }

    proptest! {
        #[test]
        fn whatever_comes_is_a_safe_command_or_refused(bytes in proptest::collection::vec(any::<u8>(), 0..64)) {
            if let Ok(command) = Command::decode(&bytes) {
                prop_assert!(safe(&command));
            }
        }

        #[test]
        fn what_is_decoded_encodes_to_the_same_bytes(kind in 1_u8..=16, noise in proptest::collection::vec(any::<u8>(), 16)) {
            let size = SIZES[usize::from(kind) - 1];
            let bytes = [vec![VERSION, kind], noise[..size].to_vec()].concat();
            if let Ok(command) = Command::decode(&bytes) {
                prop_assert!(safe(&command));
                prop_assert_eq!(command.encode(), bytes);
            }
        }
    }
}
