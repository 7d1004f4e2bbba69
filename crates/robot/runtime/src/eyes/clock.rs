//! Stamps of a device on the clock of this machine.

/// How fast two clocks may drift apart `[s/s]`: 100 ppm, twice what cheap quartz does.
const DRIFT: f64 = 1e-4;
/// A stamp this far from the expected one is of a clock that was set `[ns]`.
const SET_NS: i128 = 1_000_000_000;

/// Maps a device's stamps to the local clock by the shortest delay of a message so far. What is known of that way's own time is
/// added by the caller.
#[derive(Clone, Copy, Debug, Default)]
pub struct DeviceClock {
    /// Local time of arrival less stamp `[ns]`, and when it was seen.
    shortest: Option<(i128, u64)>,
}

impl DeviceClock {
    /// Local time of what is stamped `stamp_ns` and arrived at `arrival_ns` by the local clock `[ns]`; never later than its arrival. Stamps may
    /// be negative.
    pub fn local_ns(&mut self, stamp_ns: impl Into<i128>, arrival_ns: u64) -> u64 {
        let stamp_ns: i128 = stamp_ns.into();
        let delay = i128::from(arrival_ns) - stamp_ns;
        let usual = self
            .shortest
            .map(|(shortest, since)| shortest + (DRIFT * arrival_ns.saturating_sub(since) as f64) as i128);
        let usual = usual.filter(|usual| delay - usual < SET_NS && usual - delay < SET_NS);
        let usual = usual.map_or(delay, |usual| usual.min(delay));
        if usual == delay {
            self.shortest = Some((delay, arrival_ns));
        }
        u64::try_from(stamp_ns + usual).unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    #[test]
    fn stamps_count_from_the_message_that_came_fastest() {
        let mut clock = DeviceClock::default();
        // The device's clock is 7 s behind; ways of 9, 2 and 40 ms.
        let at = |ms: u64| 100_000 * MS + ms * MS;
        assert_eq!(clock.local_ns(at(0) - 7_000 * MS, at(9)), at(9));
        assert_eq!(clock.local_ns(at(10) - 7_000 * MS, at(12)), at(12));
        // It was measured at 20 ms; 2 ms are the shortest way, which is not known to be one.
        let late = clock.local_ns(at(20) - 7_000 * MS, at(60));
        assert!(late.abs_diff(at(22)) < MS / 100, "{late}");
    }

    #[test]
    fn a_clock_that_is_set_starts_again() {
        let mut clock = DeviceClock::default();
        assert_eq!(clock.local_ns(5_000 * MS, 9_000 * MS), 9_000 * MS);
        assert_eq!(clock.local_ns(90_000 * MS, 9_100 * MS), 9_100 * MS);
        assert_eq!(clock.local_ns(100 * MS, 9_200 * MS), 9_200 * MS);
        // To before its own zero.
        assert_eq!(clock.local_ns(-7_000_000_000_i64, 9_300 * MS), 9_300 * MS);
        assert_eq!(clock.local_ns(-6_990_000_000_i64, 9_310 * MS), 9_310 * MS);
    }
}
