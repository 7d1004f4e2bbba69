//! Delay of data on their way here, without knowing the offset of the two clocks: against the shortest delay seen.

/// How fast two clocks may drift apart `[s/s]`: 100 ppm, twice what cheap quartz does.
const DRIFT: f64 = 1e-4;

/// The shortest delay so far.
#[derive(Clone, Copy, Debug, Default)]
pub struct Lateness {
    shortest: Option<(f64, f64)>,
}

impl Lateness {
    /// How much later than usual `[s]` data of `stamp_s` (sensor's clock) came at `arrival_s` (this machine's clock).
    pub fn push(&mut self, stamp_s: f64, arrival_s: f64) -> f64 {
        let delay = arrival_s - stamp_s;
        if !delay.is_finite() {
            return f64::INFINITY;
        }
        let usual =
            self.shortest.map_or(delay, |(shortest, since)| shortest + DRIFT * (arrival_s - since).max(0.0));
        if delay <= usual {
            self.shortest = Some((delay, arrival_s));
            return 0.0;
        }
        delay - usual
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_delay_of_100_ms_shows_whatever_the_offset_of_the_clocks() {
        let mut lateness = Lateness::default();
        for i in 0..100 {
            let stamp = f64::from(i) * 0.1;
            assert!(lateness.push(stamp, stamp + 1000.002) < 0.001);
        }
        let late = lateness.push(10.0, 1010.102);
        assert!((late - 0.1).abs() < 1e-3, "{late}");
    }

    #[test]
    fn drifting_clocks_are_not_late() {
        let mut lateness = Lateness::default();
        for i in 0..36_000 {
            let stamp = f64::from(i) * 0.1;
            assert!(lateness.push(stamp, stamp * 1.000_05) < 0.001);
        }
    }
}
