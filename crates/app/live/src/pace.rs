//! Real time: when the next control step is due, and whether it is kept.

use std::time::{Duration, Instant};

/// A loop that is later than this gives up what it missed.
const GIVE_UP: Duration = Duration::from_millis(100);
/// The kept course of time is measured over this window.
const WINDOW: Duration = Duration::from_millis(1000);
/// Less than this share of the asked course of time is late.
const LATE: f32 = 0.97;

/// The clock of a scene. The times are the caller's.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    due: Instant,
    window: Instant,
    /// Time of the scene that has passed in the window `[s]`.
    passed_s: f64,
    kept: f32,
    late: bool,
}

impl Pace {
    /// The first step is due now.
    pub fn new(now: Instant) -> Self {
        Self { due: now, window: now, passed_s: 0.0, kept: 1.0, late: false }
    }

    /// When the next step is due.
    pub fn due(&self) -> Instant {
        self.due
    }

    /// A step of `dt_s` has been made at the speed `rate`; the next one is due that much later.
    pub fn stepped(&mut self, now: Instant, dt_s: f64, rate: f32) {
        self.due += Duration::from_secs_f64(dt_s / f64::from(rate));
        if now > self.due + GIVE_UP {
            self.due = now;
        }
        self.passed_s += dt_s;
        let wall = now.saturating_duration_since(self.window);
        if wall >= WINDOW {
            self.kept = (self.passed_s / wall.as_secs_f64()) as f32;
            self.late = self.kept < LATE * rate;
            (self.window, self.passed_s) = (now, 0.0);
        }
    }

    /// The next step is due at `at` or later: a late step is not made up for.
    pub fn not_before(&mut self, at: Instant) {
        self.due = self.due.max(at);
    }

    /// Time stood still until now, or its speed has changed: measuring starts again.
    pub fn resume(&mut self, now: Instant, rate: f32) {
        *self = Self { kept: rate, ..Self::new(now) };
    }

    /// The course of time that is kept.
    pub fn kept(&self) -> f32 {
        self.kept
    }

    /// True if it is slower than asked.
    pub fn late(&self) -> bool {
        self.late
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(start: Instant, ms: u64) -> Instant {
        start + Duration::from_millis(ms)
    }

    #[test]
    fn fifty_steps_a_second_are_real_time() {
        let start = Instant::now();
        let mut pace = Pace::new(start);
        for k in 0..51 {
            assert!(pace.due() <= after(start, 20 * k) + Duration::from_micros(1));
            pace.stepped(pace.due(), 0.02, 1.0);
        }
        assert!((pace.kept() - 1.02).abs() < 0.01 && !pace.late());
    }

    #[test]
    fn slow_motion_is_no_lateness() {
        let start = Instant::now();
        let mut pace = Pace::new(start);
        for _ in 0..12 {
            pace.stepped(pace.due(), 0.02, 0.2);
        }
        let off = after(start, 1200).saturating_duration_since(pace.due());
        assert!(off < Duration::from_micros(1) && pace.due() <= after(start, 1200));
        assert!((pace.kept() - 0.22).abs() < 0.01 && !pace.late());
    }

    #[test]
    fn steps_that_take_too_long_are_late_and_are_not_made_up_for() {
        let start = Instant::now();
        let mut pace = Pace::new(start);
        for k in 1..=26 {
            pace.stepped(after(start, 40 * k), 0.02, 1.0);
        }
        // Half as fast as time; the next step is due within 100 ms of now, not half a second ago.
        assert!((pace.kept() - 0.5).abs() < 0.02 && pace.late());
        assert!(after(start, 1040).saturating_duration_since(pace.due()) <= GIVE_UP);
        pace.resume(after(start, 2000), 1.0);
        assert!(!pace.late());
    }
}
