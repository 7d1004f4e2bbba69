//! The runtime on a real clock: one thread thinks, one writes, one logs, one tells.
//!
//! The thinking thread takes in packets, checks, and lets the policy act. The writing thread sends the newest command 500 times a second and
//! sends damping once the thinking thread is silent, has panicked or has ended. Neither waits for the other, nor for whoever logs or shows:
//! the command and the status travel in a [`Mailbox`], log and diary in channels that drop rather than wait.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::time::{Duration, Instant};

use serde::Serialize;

use crate::DeployError;
use crate::lateness::{Lateness, Pace};
use crate::link::Link;
use crate::log::{Frame, LogWriter};
use crate::mailbox::Mailbox;
use crate::message::Packet;
use crate::runtime::{COMMAND_US, Event, Latency, Runtime, State, Status};
use crate::switcher::{Line, Reply, SwitcherClient};
use crate::wire::LowCmd;
use crate::writer::Writer;

/// Frames that may wait for the disk.
const WAITING: usize = 500;
/// Lines of the diary that may wait to be told.
const UNTOLD: usize = 256;
/// Time between two statuses.
const STATUS_EVERY: Duration = Duration::from_millis(100);
/// Real-time priorities of the writing and the thinking thread.
pub(crate) const WRITER_PRIORITY: i32 = 60;
const THINKER_PRIORITY: i32 = 50;

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
    /// The motion switcher's topics: every second it is asked who is in command.
    pub switcher: Option<Box<dyn Line>>,
    /// Keys of the remote that the operator has pressed on the keyboard, a bit each.
    pub keys: Option<Arc<Mailbox<u16>>>,
    /// Ends after so long.
    pub duration: Option<Duration>,
}

/// What is told while it runs, from a thread of its own that may take its time.
#[derive(Clone, Copy, Debug)]
pub enum Told<'a> {
    /// A transition or a note.
    Event(&'a Event),
    /// The state of things, ten times a second.
    Status(&'a LiveStatus),
}

/// The runtime's status and the machine's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LiveStatus {
    /// The runtime's.
    #[serde(flatten)]
    pub runtime: Status,
    /// States of the robot and commands to it a second, over the last tenth.
    pub rates_hz: [f64; 2],
    /// The longest step of the runtime and the latest command since the last status `[us]`.
    pub longest_step_us: u64,
    /// See `longest_step_us`.
    pub latest_command_us: u64,
    /// True if the robot is told nothing.
    pub dry_run: bool,
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
    /// The longest step of the runtime, clock time `[us]`.
    pub longest_step_us: u64,
    /// How long steps took in which the policy acted, as a lateness: the packets' intake, tracker, observation, network and command.
    pub policy_steps: Lateness,
    /// How late commands were.
    pub lateness: Lateness,
    /// From the capture of a picture of the ball to the first joint targets that it has a part in.
    pub latency: Latency,
    /// Why the log is not complete, if the disk has failed.
    pub log_failed: Option<String>,
    /// Frames that the log had to drop.
    pub dropped_frames: u64,
    /// True where the system granted real-time priority.
    pub real_time: bool,
    /// What the thinking thread died of, if it did.
    pub died: Option<String>,
}

/// Steps of the thinking thread between two statuses: a fiftieth of a second, so that there is always a fresh one.
const STATUS_STEPS: u64 = 10;

/// Counts a second.
#[derive(Debug, Default)]
struct Rates {
    before: Option<(f64, [u64; 2])>,
}

impl Rates {
    /// Rates since the last call `[Hz]`, whose time was earlier than `now_s` `[s]`; zeros at the first one.
    fn since_last(&mut self, now_s: f64, counts: [u64; 2]) -> [f64; 2] {
        let before = self.before.replace((now_s, counts));
        before.map_or([0.0; 2], |(then_s, old)| {
            let time = (now_s - then_s).max(1e-6);
            [0, 1].map(|k| counts[k].saturating_sub(old[k]) as f64 / time)
        })
    }
}

/// Asks the system for real-time priority of the calling thread; true if it was granted.
pub(crate) fn ask_for_real_time(priority: i32) -> bool {
    // SAFETY: a plain structure of the system, for which all zeros is a value.
    let mut parameters: libc::sched_param = unsafe { std::mem::zeroed() };
    parameters.sched_priority = priority;
    // SAFETY: process 0 is the calling thread, and the structure lives through the call.
    unsafe { libc::sched_setscheduler(0, libc::SCHED_FIFO, &raw const parameters) == 0 }
}

/// Asks every second who is in command, until it is over. A network that fails here shows in the states, too.
fn watch_the_switcher(line: Box<dyn Line>, over: &AtomicBool, masters: &Mailbox<String>) {
    let mut client = SwitcherClient::new(line);
    for tick in 0_u64.. {
        if over.load(Ordering::Acquire) || (tick % 20 == 0 && client.check().is_err()) {
            return;
        }
        std::thread::sleep(Duration::from_millis(50));
        while let Ok(Some(reply)) = client.reply() {
            if let Reply::Master(master) = reply {
                masters.put(master.name);
            }
        }
    }
}

/// Runs until `stop` is set, the time is over, or the link breaks. In the end the robot is told to damp for half a second.
///
/// # Errors
/// If the link fails or a thread cannot begin. A full disk ends the log and is told at the end.
pub fn run_live(
    live: Live,
    link: impl Link,
    stop: &AtomicBool,
    mut told: impl FnMut(Told<'_>) + Send,
) -> Result<LiveReport, DeployError> {
    let Live { mut runtime, mut writer, dry_run, log, switcher, keys, duration } = live;
    let (mut out, mut input) = link.split();
    let begin = Instant::now();
    let micros = move || begin.elapsed().as_micros() as u64;
    let over = AtomicBool::new(false);
    let real_time = AtomicBool::new(false);
    let masters = Mailbox::<String>::default();
    let (commands, statuses) = (Mailbox::<(LowCmd, u64)>::default(), Mailbox::<Status>::default());
    let (written, latest_us, longest_us) = (AtomicU64::new(0), AtomicU64::new(0), AtomicU64::new(0));
    let (to_log, frames) = sync_channel::<Frame>(WAITING);
    let (to_tell, diary) = sync_channel::<Event>(UNTOLD);

    std::thread::scope(|scope| {
        let (from_log, mut ended) = (to_tell.clone(), false);
        let logging = scope.spawn(move || {
            let Some(mut log) = log else {
                while frames.recv().is_ok() {}
                return Ok(0);
            };
            for frame in frames {
                log.write(&frame);
                if let (Some(why), false) = (log.failed(), ended) {
                    ended = true;
                    let reason = format!("the log ends here: {why}");
                    let (from, to) = (frame.state, frame.state);
                    let _ = from_log.try_send(Event { at_us: frame.now_us, from, to, reason });
                }
            }
            log.finish()
        });
        let (statuses, written, longest_us, latest_us) = (&statuses, &written, &longest_us, &latest_us);
        let told = &mut told;
        let telling = scope.spawn(move || {
            let mut rates = Rates::default();
            let mut due = Instant::now();
            loop {
                match diary.recv_timeout(due.saturating_duration_since(Instant::now())) {
                    Ok(event) => told(Told::Event(&event)),
                    Err(RecvTimeoutError::Disconnected) => return,
                    Err(RecvTimeoutError::Timeout) => {
                        due = Instant::now() + STATUS_EVERY;
                        let Some(status) = statuses.take() else { continue };
                        let counts = [status.states, written.load(Ordering::Relaxed)];
                        let rates_hz = rates.since_last(begin.elapsed().as_secs_f64(), counts);
                        told(Told::Status(&LiveStatus {
                            runtime: status,
                            rates_hz,
                            longest_step_us: longest_us.swap(0, Ordering::Relaxed),
                            latest_command_us: latest_us.swap(0, Ordering::Relaxed),
                            dry_run,
                        }));
                    }
                }
            }
        });
        let writing = scope.spawn(|| {
            real_time.store(ask_for_real_time(WRITER_PRIORITY), Ordering::Relaxed);
            let (mut pace, mut lateness) = (Pace::new(COMMAND_US), Lateness::default());
            let mut rest = 250;
            let mut broken = Ok(());
            while rest > 0 && broken.is_ok() {
                let late = pace.wait();
                lateness.add(late);
                latest_us.fetch_max(late.as_micros() as u64, Ordering::Relaxed);
                if over.load(Ordering::Acquire) {
                    rest -= 1;
                }
                if let Some((command, given_us)) = commands.take() {
                    writer.give(Some(command), given_us);
                }
                if let (Some(command), false) = (writer.write(micros()), dry_run) {
                    broken = out.command(&command);
                    written.fetch_add(1, Ordering::Relaxed);
                }
            }
            (lateness, broken)
        });
        if let Some(line) = switcher {
            let (over, masters) = (&over, &masters);
            scope.spawn(move || watch_the_switcher(line, over, masters));
        }
        let mut events = Vec::new();
        let (mut steps, mut longest_step_us, mut dropped_frames) = (0, 0, 0);
        let mut policy_steps = Lateness::default();
        let thinking = catch_unwind(AssertUnwindSafe(|| -> Result<(), DeployError> {
            ask_for_real_time(THINKER_PRIORITY);
            let mut pace = Pace::new(COMMAND_US);
            let mut packets = Vec::with_capacity(64);
            let mut ending = 0;
            while ending < 50 {
                pace.wait();
                while let Some(packet) = input.receive()? {
                    packets.push(packet);
                }
                packets.extend(masters.take().map(Packet::Master));
                packets.extend(keys.as_ref().and_then(|keys| keys.take()).map(Packet::Keys));
                let now_us = micros();
                let stopping = stop.load(Ordering::Relaxed) || duration.is_some_and(|d| begin.elapsed() >= d);
                ending += u32::from(stopping);
                let mut output = runtime.step(now_us, &packets, stopping);
                let took_us = micros() - now_us;
                longest_step_us = longest_step_us.max(took_us);
                longest_us.fetch_max(took_us, Ordering::Relaxed);
                if output.acted {
                    policy_steps.add(Duration::from_micros(took_us));
                }
                // The writer is inside for well under a microsecond: if just now, the next command is 2 ms away.
                if let Some(command) = &output.command {
                    commands.put((command.clone(), now_us));
                }
                if steps % STATUS_STEPS == 0 {
                    statuses.put(runtime.status(now_us));
                }
                // Beyond this point nothing is urgent.
                for event in &output.events {
                    let _ = to_tell.try_send(event.clone());
                }
                let frame = Frame::new(now_us, &packets, stopping, &output, &runtime);
                dropped_frames += u64::from(to_log.try_send(frame).is_err());
                events.append(&mut output.events);
                packets.clear();
                steps += 1;
            }
            Ok(())
        }));
        over.store(true, Ordering::Release);
        drop((to_log, to_tell));
        let (lateness, broken) =
            writing.join().map_err(|_| DeployError::Refused("the writing thread has panicked".to_owned()))?;
        let logged =
            logging.join().map_err(|_| DeployError::Refused("the logging thread has panicked".to_owned()))?;
        telling.join().map_err(|_| DeployError::Refused("the telling thread has panicked".to_owned()))?;
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
        Ok(LiveReport {
            log_failed: logged.err().map(|error| error.to_string()),
            events,
            state: runtime.state(),
            kicks: runtime.kicks(),
            steps,
            longest_step_us,
            policy_steps,
            lateness,
            latency: runtime.latency().clone(),
            dropped_frames,
            real_time: real_time.load(Ordering::Relaxed),
            died,
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_counts_over_time() {
        let mut rates = Rates::default();
        assert_eq!(rates.since_last(1.0, [100, 7]), [0.0, 0.0]);
        assert_eq!(rates.since_last(1.5, [350, 7]), [500.0, 0.0]);
    }
}
