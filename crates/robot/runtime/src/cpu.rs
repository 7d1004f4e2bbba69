//! What the program takes of the machine, and the real-time priority of its threads.

use std::time::Instant;

use serde::Serialize;

/// What this program has taken of the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Usage {
    /// Processor time of all threads since the program began `[s]`.
    pub cpu_s: f64,
    /// Clock time since the measurement began `[s]`.
    pub clock_s: f64,
    /// Processor time since the measurement began over clock time: 1 is a whole core.
    pub cores: f64,
    /// The most memory that it has held at once `[MiB]`.
    pub peak_rss_mib: f64,
}

impl Usage {
    /// Of the whole program, measured from `begin` on, at which it had taken `before`.
    pub fn since(begin: Instant, before: &Self) -> Self {
        // SAFETY: a plain structure of the system, for which all zeros is a value.
        let mut usage: libc::rusage = unsafe { std::mem::zeroed() };
        // SAFETY: the structure lives through the call, which writes nothing else.
        if unsafe { libc::getrusage(libc::RUSAGE_SELF, &raw mut usage) } != 0 {
            return Self::default();
        }
        let seconds = |time: libc::timeval| time.tv_sec as f64 + time.tv_usec as f64 * 1e-6;
        let cpu_s = seconds(usage.ru_utime) + seconds(usage.ru_stime);
        let clock_s = begin.elapsed().as_secs_f64();
        // Linux counts in KiB, macOS in bytes.
        let per_mib = if cfg!(target_os = "macos") { 1024.0 * 1024.0 } else { 1024.0 };
        let peak_rss_mib = usage.ru_maxrss as f64 / per_mib;
        Self { cpu_s, clock_s, cores: (cpu_s - before.cpu_s) / clock_s.max(1e-3), peak_rss_mib }
    }

    /// At the begin of a measurement.
    pub fn now() -> Self {
        Self::since(Instant::now(), &Self::default())
    }
}

/// Real-time priority of the thread that writes commands.
pub(crate) const WRITER_PRIORITY: i32 = 60;
/// Real-time priority of the thread that runs the policy.
pub(crate) const THINKER_PRIORITY: i32 = 50;

/// Asks the system for real-time priority of the calling thread; true if it was granted. Only Linux has it.
pub(crate) fn ask_for_real_time(priority: i32) -> bool {
    #[cfg(target_os = "linux")]
    {
        // SAFETY: a plain structure of the system, for which all zeros is a value.
        let mut parameters: libc::sched_param = unsafe { std::mem::zeroed() };
        parameters.sched_priority = priority;
        // SAFETY: process 0 is the calling thread, and the structure lives through the call.
        unsafe { libc::sched_setscheduler(0, libc::SCHED_FIFO, &raw const parameters) == 0 }
    }
    #[cfg(not(target_os = "linux"))]
    {
        let _ = priority;
        false
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use cpu_time::ThreadTime;

    use super::*;

    #[test]
    fn work_is_counted_and_memory_is_there() {
        let (begin, before) = (Instant::now(), Usage::now());
        let start = ThreadTime::now();
        let mut x = 1_u64;
        while start.elapsed() < Duration::from_millis(50) {
            x = std::hint::black_box(x.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1));
        }
        let usage = Usage::since(begin, &before);
        assert!(usage.cpu_s >= before.cpu_s + 0.045, "{usage:?} after {before:?}");
        assert!(usage.cores > 0.0 && usage.peak_rss_mib > 1.0, "{usage:?}");
    }
}
