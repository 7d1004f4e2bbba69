//! The runtime on a real clock: one thread thinks, one writes, one logs.
//!
//! The thinking thread takes in packets, checks, and lets the policy act. The writing thread sends its last command 500 times a second and
//! sends damping once the thinking thread is silent, has panicked or has ended. The log goes through a channel that drops frames
//! rather than wait.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::sync_channel;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::DeployError;
use crate::link::Link;
use crate::log::{Frame, LogWriter};
use crate::message::Packet;
use crate::runtime::{COMMAND_US, Event, Runtime, State};
use crate::writer::Writer;

/// Frames that may wait for the disk.
const WAITING: usize = 500;

/// How late a loop came, in steps of 10 microseconds.
#[derive(Clone, Debug)]
pub struct Lateness {
    counts: Vec<u64>,
}

impl Default for Lateness {
    fn default() -> Self {
        Self { counts: vec![0; 10_000] }
    }
}

impl Lateness {
    fn add(&mut self, late: Duration) {
        let at = (late.as_micros() / 10) as usize;
        let last = self.counts.len() - 1;
        self.counts[at.min(last)] += 1;
    }

    /// The lateness that a share of the periods stayed within `[ms]`.
    pub fn quantile_ms(&self, share: f64) -> f64 {
        let total: u64 = self.counts.iter().sum();
        let wanted = (share * total as f64).ceil() as u64;
        let mut seen = 0;
        for (k, count) in self.counts.iter().enumerate() {
            seen += count;
            if seen >= wanted.max(1) {
                return (k + 1) as f64 * 0.01;
            }
        }
        f64::NAN
    }

    /// A bare loop of the command period on this machine, for comparison.
    pub fn of_bare_timer(duration: Duration) -> Self {
        let mut out = Self::default();
        let mut pace = Pace::new(COMMAND_US);
        let begin = Instant::now();
        while begin.elapsed() < duration {
            out.add(pace.wait());
        }
        out
    }
}

/// Wakes up at whole periods.
struct Pace {
    next: Instant,
    period: Duration,
}

impl Pace {
    fn new(period_us: u64) -> Self {
        let period = Duration::from_micros(period_us);
        Self { next: Instant::now() + period, period }
    }

    /// Sleeps until the next period begins; how late it is. Periods that were slept through are left out.
    fn wait(&mut self) -> Duration {
        let now = Instant::now();
        if now < self.next {
            std::thread::sleep(self.next - now);
        }
        let now = Instant::now();
        let late = now.saturating_duration_since(self.next);
        self.next += self.period;
        if self.next < now {
            self.next = now + self.period;
        }
        late
    }
}

/// What to run live.
pub struct Live {
    /// The runtime.
    pub runtime: Runtime,
    /// The writer.
    pub writer: Writer,
    /// True: everything but commands.
    pub dry_run: bool,
    /// The log, if one is wanted.
    pub log: Option<LogWriter>,
    /// Ends after so long.
    pub duration: Option<Duration>,
}

/// How it went.
#[derive(Clone, Debug)]
pub struct LiveReport {
    /// Every transition.
    pub events: Vec<Event>,
    /// The last state.
    pub state: State,
    /// Kicks that have begun.
    pub kicks: usize,
    /// Steps of the runtime.
    pub steps: u64,
    /// Processor time of a policy step's whole runtime step, the longest `[us]`.
    pub longest_step_us: u64,
    /// How late commands were.
    pub lateness: Lateness,
    /// Frames that the log had to drop.
    pub dropped_frames: u64,
    /// True where the system granted real-time priority.
    pub real_time: bool,
    /// What the thinking thread died of, if it did.
    pub died: Option<String>,
}

/// Asks the system for real-time priority of the calling thread; true if it was granted.
fn ask_for_real_time(priority: i32) -> bool {
    // SAFETY: a plain structure of the system, for which all zeros is a value.
    let mut parameters: libc::sched_param = unsafe { std::mem::zeroed() };
    parameters.sched_priority = priority;
    // SAFETY: process 0 is the calling thread, and the structure lives through the call.
    unsafe { libc::sched_setscheduler(0, libc::SCHED_FIFO, &raw const parameters) == 0 }
}

/// Runs until `stop` is set, the time is over, or the link breaks. In the end the robot is told to damp for half a second.
///
/// # Errors
/// If the link fails or a thread cannot begin. A full disk ends the log and is told at the end.
pub fn run_live(
    live: Live,
    link: impl Link,
    stop: &AtomicBool,
    mut told: impl FnMut(&Event) + Send,
) -> Result<LiveReport, DeployError> {
    let Live { mut runtime, writer, dry_run, log, duration } = live;
    let (mut out, mut input) = link.split();
    let begin = Instant::now();
    let micros = move || begin.elapsed().as_micros() as u64;
    let writer = Mutex::new(writer);
    let over = AtomicBool::new(false);
    let real_time = AtomicBool::new(false);
    let (to_log, frames) = sync_channel::<Frame>(WAITING);
    let lock = || writer.lock().unwrap_or_else(PoisonError::into_inner);

    std::thread::scope(|scope| {
        let logging = scope.spawn(move || {
            let Some(mut log) = log else {
                while frames.recv().is_ok() {}
                return Ok(0);
            };
            for frame in frames {
                log.write(&frame);
            }
            log.finish()
        });
        let writing = scope.spawn(|| {
            real_time.store(ask_for_real_time(60), Ordering::Relaxed);
            let (mut pace, mut lateness) = (Pace::new(COMMAND_US), Lateness::default());
            let mut rest = 250;
            let mut broken = Ok(());
            while rest > 0 && broken.is_ok() {
                lateness.add(pace.wait());
                if over.load(Ordering::Acquire) {
                    rest -= 1;
                }
                let command = lock().write(micros());
                if let (Some(command), false) = (command, dry_run) {
                    broken = out.send(Packet::LowCmd(command.to_cdr()));
                }
            }
            (lateness, broken)
        });
        let mut events = Vec::new();
        let (mut steps, mut longest_step_us, mut dropped_frames) = (0, 0, 0);
        let thinking = catch_unwind(AssertUnwindSafe(|| -> Result<(), DeployError> {
            ask_for_real_time(50);
            let mut pace = Pace::new(COMMAND_US);
            let mut packets = Vec::with_capacity(64);
            let mut ending = 0;
            while ending < 50 {
                pace.wait();
                while let Some(packet) = input.receive()? {
                    packets.push(packet);
                }
                let now_us = micros();
                let stopping = stop.load(Ordering::Relaxed) || duration.is_some_and(|d| begin.elapsed() >= d);
                ending += u32::from(stopping);
                let output = runtime.step(now_us, &packets, stopping);
                longest_step_us = longest_step_us.max(micros() - now_us);
                lock().give(output.command.clone(), now_us);
                for event in &output.events {
                    told(event);
                    events.push(event.clone());
                }
                let frame = Frame::new(now_us, &packets, stopping, &output);
                dropped_frames += u64::from(to_log.try_send(frame).is_err());
                packets.clear();
                steps += 1;
            }
            Ok(())
        }));
        over.store(true, Ordering::Release);
        drop(to_log);
        let (lateness, broken) =
            writing.join().map_err(|_| DeployError::Refused("the writing thread has panicked".to_owned()))?;
        let logged =
            logging.join().map_err(|_| DeployError::Refused("the logging thread has panicked".to_owned()))?;
        broken?;
        let died = match thinking {
            Ok(result) => {
                result?;
                None
            }
            Err(panic) => Some(
                panic
                    .downcast_ref::<&str>()
                    .map(ToString::to_string)
                    .or_else(|| panic.downcast_ref::<String>().cloned())
                    .unwrap_or_default(),
            ),
        };
        logged?;
        Ok(LiveReport {
            events,
            state: runtime.state(),
            kicks: runtime.kicks(),
            steps,
            longest_step_us,
            lateness,
            dropped_frames,
            real_time: real_time.load(Ordering::Relaxed),
            died,
        })
    })
}
