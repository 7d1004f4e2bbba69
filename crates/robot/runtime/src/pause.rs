//! A computer that stood still, distinguished from a peer that is silent.

use crate::limits::Limits;
use crate::wire::COMMAND_US;

/// Lateness from which a thread was not run, rather than scheduled a little late `[us]`: two periods.
const PAUSE_US: u64 = 2 * COMMAND_US;

/// Counts the silence of a peer. While this thread is not run, it receives nothing, so a short pause of its own says nothing about the
/// peer. The default forgives none.
#[derive(Clone, Debug, Default)]
pub(crate) struct Silence {
    /// Pauses between two messages of the peer that are forgiven in total `[us]`.
    limit_us: u64,
    step_us: Option<u64>,
    forgiven_us: u64,
}

impl Silence {
    /// Nothing was received yet.
    pub fn new(limits: &Limits) -> Self {
        Self { limit_us: (limits.forgiven_pause_s * 1e6) as u64, step_us: None, forgiven_us: 0 }
    }

    /// A period of this thread begins at `now_us` `[us]`.
    pub fn step(&mut self, now_us: u64) {
        let Some(last_us) = self.step_us.replace(now_us) else { return };
        let pause_us = now_us.saturating_sub(last_us + COMMAND_US);
        if pause_us >= PAUSE_US && self.forgiven_us + pause_us <= self.limit_us {
            self.forgiven_us += pause_us;
        }
    }

    /// The peer has spoken.
    pub fn heard(&mut self) {
        self.forgiven_us = 0;
    }

    /// How long the peer has been silent since it spoke at `heard_us`, without forgiven pauses `[us]`.
    pub fn since_us(&self, heard_us: u64, now_us: u64) -> u64 {
        now_us.saturating_sub(heard_us).saturating_sub(self.forgiven_us)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Periods at these times `[ms]` after the peer's last message at 0, and the silence counted at each `[ms]`.
    fn counted(at_ms: &[u64]) -> Vec<u64> {
        let mut silence = Silence::new(&Limits { forgiven_pause_s: 0.05, ..Limits::default() });
        silence.step(0);
        let count = |at: &u64| {
            silence.step(1000 * at);
            silence.since_us(0, 1000 * at) / 1000
        };
        at_ms.iter().map(count).collect()
    }

    #[test]
    fn a_pause_of_its_own_does_not_count_and_silence_after_it_does() {
        // 23 ms between two periods: 21 of them are the pause.
        assert_eq!(counted(&[2, 4, 27, 29, 31]), [2, 4, 6, 8, 10]);
    }

    #[test]
    fn small_delays_long_pauses_and_many_pauses_count() {
        assert_eq!(counted(&[5, 10, 15, 20]), [5, 10, 15, 20], "3 ms late each");
        assert_eq!(counted(&[60]), [60]);
        assert_eq!(counted(&[30, 60]), [2, 32], "28 ms of 50 are spent");
    }

    #[test]
    fn a_word_ends_what_was_forgiven() {
        let mut silence = Silence::new(&Limits::default());
        (0..2).for_each(|k| silence.step(30_000 * k));
        assert_eq!(silence.since_us(0, 30_000), 2_000);
        silence.heard();
        assert_eq!(silence.since_us(30_000, 50_000), 20_000);
    }
}
