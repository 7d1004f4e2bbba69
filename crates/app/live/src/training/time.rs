//! When the next control step of the policy in training is due.

use std::thread;
use std::time::{Duration, Instant};

use crate::Command;
use crate::pace::Pace;

/// The share of all cores that its control steps may take.
const SHARE: f64 = 0.015;
/// The cost of a step is the minimum over this many: the others were interrupted by the training.
const COSTS: usize = 16;

/// The course of time, which leaves the cores to the training.
pub(super) struct Time {
    pub pace: Pace,
    dt_s: f64,
    pub rate: f32,
    pub paused: bool,
    /// One step though time stands still.
    pub once: bool,
    /// Durations of the last steps.
    costs: [Duration; COSTS],
    count: usize,
    cores: f64,
}

impl Time {
    pub fn new(dt_s: f64) -> Self {
        Self {
            pace: Pace::new(Instant::now()),
            dt_s,
            rate: 1.0,
            paused: false,
            once: false,
            costs: [Duration::MAX; COSTS],
            count: 0,
            cores: thread::available_parallelism().map_or(1.0, |cores| cores.get() as f64),
        }
    }

    /// Does what concerns time; true if the command is done with. Engine and ground stay those that are trained in.
    pub fn obey(&mut self, command: Command) -> bool {
        match command {
            Command::Pause(on) => {
                self.paused = on;
                self.measure_anew();
            }
            Command::Step => (self.paused, self.once) = (true, true),
            Command::Rate(rate) => {
                self.rate = rate;
                self.measure_anew();
            }
            Command::Engine(_) | Command::Surface(_) | Command::Stop => {}
            _ => return false,
        }
        true
    }

    /// A pause is no lateness. The next step is due no sooner for it: visitors must not take more than the share of the cores.
    fn measure_anew(&mut self) {
        let due = self.pace.due();
        self.pace.resume(Instant::now(), self.rate);
        self.pace.not_before(due);
    }

    /// A step took from `begun` to `now`. The next one is due when real time requires it and the share of the cores allows it; a late
    /// one is not made up for.
    pub fn stepped(&mut self, begun: Instant, now: Instant) {
        self.costs[self.count % COSTS] = now - begun;
        self.count += 1;
        let cost = self.costs.iter().min().copied().unwrap_or_default();
        let share = cost.as_secs_f64() / (SHARE * self.cores);
        self.pace.stepped(now, self.dt_s, self.rate);
        self.pace.not_before(begun + Duration::from_secs_f64(share.max(self.dt_s / f64::from(self.rate))));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_take_their_share_of_the_cores_and_none_is_made_up_for() {
        let start = Instant::now();
        let ms = |ms: u64| start + Duration::from_millis(ms);
        let mut time = Time { cores: 2.0, pace: Pace::new(start), ..Time::new(0.02) };
        // A cheap step: real time. 0.5 ms of 2 cores' 1.5% are 16.7 ms.
        time.stepped(start, start + Duration::from_micros(500));
        assert_eq!(time.pace.due(), ms(20));
        // It came 300 ms late: the next one comes 20 ms after it and not at once.
        time.stepped(ms(320), ms(321));
        assert_eq!(time.pace.due(), ms(340));
        // 3 ms are 1.5% of what two cores do in 100 ms.
        let mut slow = Time { cores: 2.0, pace: Pace::new(start), ..Time::new(0.02) };
        slow.stepped(ms(1000), ms(1003));
        assert_eq!(slow.pace.due(), ms(1100));
        // Pausing and continuing brings no step earlier.
        assert!(slow.obey(Command::Pause(true)) && slow.obey(Command::Pause(false)));
        assert!(slow.pace.due() >= ms(1100) && !slow.pace.late());
    }
}
