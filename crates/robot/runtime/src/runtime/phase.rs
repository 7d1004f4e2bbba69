//! What perception needs to know of the runtime.

use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

/// The robot's phase, from the thinking thread to the ball's perception. Neither side waits.
#[derive(Debug)]
pub struct Phase {
    to_strike: AtomicU64,
    looks: AtomicU32,
}

impl Default for Phase {
    /// No motion, and not ready yet.
    fn default() -> Self {
        Self { to_strike: AtomicU64::new(f64::INFINITY.to_bits()), looks: AtomicU32::new(0) }
    }
}

impl Phase {
    pub(super) fn set(&self, to_strike_s: f64) {
        self.to_strike.store(to_strike_s.to_bits(), Ordering::Relaxed);
    }

    pub(super) fn look_again(&self) {
        self.looks.fetch_add(1, Ordering::Relaxed);
    }

    /// Time until the motion strikes at the last policy step `[s]`; infinite while none is played, negative after the strike.
    pub fn to_strike_s(&self) -> f64 {
        f64::from_bits(self.to_strike.load(Ordering::Relaxed))
    }

    /// How often perception had to look again for the floor and a ball: the robot has become ready, and the ball of its last kick is no
    /// longer its own, or kicks are allowed, and it stands on the floor.
    pub fn looks_anew(&self) -> u32 {
        self.looks.load(Ordering::Relaxed)
    }
}
