//! The runtime on a real clock: one thread thinks, one writes, one logs, one reports.
//!
//! The thinking thread takes in packets, checks, and lets the policy act. The writing thread sends the newest command 500 times a second and
//! sends damping once the thinking thread is silent, has panicked or has ended. Neither waits for the other, nor for logging or display:
//! the command and the status travel in a [`Mailbox`], log and events in channels that drop rather than wait. Steps of the log lie in
//! buffers that were made before, so that the thinking thread allocates nothing between transitions; what the network allocates for a
//! packet is its own.
//!
//! The thinking thread watches the others, those of perception and keyboard too ([`LastWords`]): one that has panicked, a link that has
//! failed, and a writer whose last command is too old end the run by damping, with the reason in the events, the log and the report.

mod keys;
mod panics;
mod report;
mod slot;
mod words;
mod write;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::{Duration, Instant};

use crate::DeployError;
use crate::cpu::{THINKER_PRIORITY, ask_for_real_time};
use crate::lateness::{Lateness, Pace};
use crate::link::{Link, LinkError};
use crate::log::LogWriter;
use crate::mailbox::Mailbox;
use crate::message::Packet;
use crate::runtime::{Event, Runtime, State, Status};
use crate::switcher::{Line, Reply, SwitcherClient};
use crate::wire::COMMAND_US;
use crate::writer::Writer;
pub use keys::TypedKeys;
use panics::{Prints, Watching, guarded, print_the_rest, said};
use report::Rates;
pub use report::{LiveReport, LiveStatus, Told};
use slot::Slot;
pub use words::LastWords;
use write::{Failure, Shared, write_on};

/// Frames that may wait for the disk.
const WAITING: usize = 500;
/// Events that may queue.
const UNTOLD: usize = 256;
/// Panic messages that may queue for the thinking thread: there are fewer threads.
const LAST_WORDS: usize = 8;
/// Steps from the request to end, or from a failure, to the end: a tenth of a second of damping that is logged.
const ENDING: u32 = 50;
/// Time between two statuses.
const STATUS_EVERY: Duration = Duration::from_millis(100);

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
    /// Keys of the remote that the operator has pressed on the keyboard.
    pub keys: Option<Arc<TypedKeys>>,
    /// Of other threads than this run's own: one that has panicked ends the run by damping.
    pub last_words: LastWords,
    /// Ends after this long.
    pub duration: Option<Duration>,
}

/// Steps of the thinking thread between two statuses: a fiftieth of a second, so that there is always a fresh one.
const STATUS_STEPS: u64 = 10;

/// Asks every second who is in command, until it is over.
fn watch_the_switcher(
    line: Box<dyn Line>,
    over: &AtomicBool,
    masters: &Mailbox<String>,
) -> Result<(), LinkError> {
    let mut client = SwitcherClient::new(line);
    for tick in 0_u64.. {
        if over.load(Ordering::Acquire) {
            break;
        }
        if tick % 20 == 0 {
            client.check()?;
        }
        std::thread::sleep(Duration::from_millis(50));
        while let Some(reply) = client.reply()? {
            if let Reply::Master(master) = reply {
                masters.put(master.name);
            }
        }
    }
    Ok(())
}

/// Where a thread's last words go.
fn into(broken: &SyncSender<String>) -> impl Fn(String) + 'static {
    let broken = broken.clone();
    move |words| {
        let _ = broken.try_send(words);
    }
}

/// Runs until `stop` is set, the time is over, or something fails: then the robot is damped, and that is reported and logged with its
/// reason. At the end the robot is commanded to damp for half a second.
///
/// # Errors
/// If the link has failed, at the end. A thread's panic is in the report. A full disk ends the log and is reported at the end.
pub fn run_live(
    live: Live,
    link: impl Link,
    stop: &AtomicBool,
    mut told: impl FnMut(Told<'_>) + Send,
) -> Result<LiveReport, DeployError> {
    let Live { mut runtime, writer, dry_run, log, switcher, keys, last_words: others, duration } = live;
    let (out, mut input) = link.split();
    let begin = Instant::now();
    let micros = move || begin.elapsed().as_micros() as u64;
    let shared = Shared::default();
    let masters = Mailbox::<String>::default();
    let statuses = Mailbox::<Status>::default();
    let longest_us = AtomicU64::new(0);
    let (to_log, frames) = sync_channel::<Slot>(WAITING);
    let (emptied, room) = sync_channel::<Slot>(WAITING);
    let logs = log.is_some();
    for _ in 0..if logs { WAITING } else { 0 } {
        let _ = emptied.try_send(Slot::new(&runtime));
    }
    let (to_tell, queued) = sync_channel::<Event>(UNTOLD);
    let (broken, last_words) = sync_channel::<String>(LAST_WORDS);

    std::thread::scope(|scope| {
        let from_log = to_tell.clone();
        let (statuses, longest_us, shared) = (&statuses, &longest_us, &shared);
        let last_word = broken.clone();
        let logging = scope.spawn(move || {
            guarded("logging", into(&last_word), || keep_log(log, frames, &emptied, &from_log))
        });
        let last_word = broken.clone();
        let told = &mut told;
        let telling = scope.spawn(move || {
            guarded("telling", into(&last_word), || {
                let mut rates = Rates::default();
                let mut due = Instant::now();
                loop {
                    match queued.recv_timeout(due.saturating_duration_since(Instant::now())) {
                        Ok(event) => told(Told::Event(&event)),
                        Err(RecvTimeoutError::Disconnected) => return,
                        Err(RecvTimeoutError::Timeout) => {
                            due = Instant::now() + STATUS_EVERY;
                            let Some(status) = statuses.take() else { continue };
                            let counts = [status.states, shared.sent.load(Ordering::Relaxed)];
                            let rates_hz = rates.since_last(begin.elapsed().as_secs_f64(), counts);
                            told(Told::Status(&LiveStatus {
                                runtime: status,
                                rates_hz,
                                longest_step_us: longest_us.swap(0, Ordering::Relaxed),
                                latest_command_us: shared.latest_us.swap(0, Ordering::Relaxed),
                                dry_run,
                            }));
                        }
                    }
                }
            })
        });
        let last_word = broken.clone();
        let writing = scope.spawn(move || write_on(writer, out, shared, begin, dry_run, &last_word));
        if let Some(line) = switcher {
            let (last_word, masters) = (broken.clone(), &masters);
            scope.spawn(move || {
                let watched = guarded("switcher's", into(&last_word), || {
                    watch_the_switcher(line, &shared.over, masters)
                });
                if let Some(Err(error)) = watched {
                    let _ = last_word
                        .try_send(format!("cannot ask the motion switcher who is in command: {error}"));
                }
            });
        }
        let mut events = Vec::new();
        let (mut steps, mut longest_step_us, mut dropped_frames) = (0, 0, 0);
        let mut policy_steps = Lateness::default();
        // What has failed, and the link's error.
        let (mut failed, mut deaf): (Option<String>, Option<LinkError>) = (None, None);
        // Told below, as soon as it is caught; printed in the end.
        let watching = Watching::begin("thinking", Prints::Later, |_| {});
        let thinking = catch_unwind(AssertUnwindSafe(|| {
            ask_for_real_time(THINKER_PRIORITY);
            let mut pace = Pace::new(COMMAND_US);
            let mut packets = Vec::with_capacity(64);
            let mut ending = 0;
            while ending < ENDING {
                pace.wait();
                while deaf.is_none() {
                    match input.receive() {
                        Ok(Some(packet)) => packets.push(packet),
                        Ok(None) => break,
                        Err(error) => deaf = Some(error),
                    }
                }
                packets.extend(masters.take().map(Packet::Master));
                packets.extend(keys.as_ref().and_then(|keys| keys.take()).map(Packet::Keys));
                let now_us = micros();
                if failed.is_none() {
                    failed = last_words.try_recv().ok().or_else(|| others.heard());
                    failed = failed
                        .take()
                        .or_else(|| deaf.as_ref().map(|error| format!("nothing can be received: {error}")));
                    failed = failed.take().or_else(|| silent_writer(shared, &runtime, now_us));
                    packets.extend(failed.clone().map(Packet::Broken));
                }
                let stopping = stop.load(Ordering::Relaxed) || duration.is_some_and(|d| begin.elapsed() >= d);
                ending += u32::from(stopping || failed.is_some());
                let mut output = runtime.step(now_us, &packets, stopping);
                let took_us = micros() - now_us;
                longest_step_us = longest_step_us.max(took_us);
                longest_us.fetch_max(took_us, Ordering::Relaxed);
                if output.acted {
                    policy_steps.add(Duration::from_micros(took_us));
                }
                // The writer is inside for well under a microsecond: if just now, the next command is 2 ms away.
                shared.commands.put((output.command.clone(), now_us));
                if steps % STATUS_STEPS == 0 {
                    statuses.put(runtime.status(now_us));
                }
                // Beyond this point nothing is urgent.
                for event in &output.events {
                    let _ = to_tell.try_send(event.clone());
                }
                if logs {
                    let kept = room.try_recv().is_ok_and(|mut slot| {
                        slot.fill(now_us, &mut packets, stopping, &output, &runtime);
                        to_log.try_send(slot).is_ok()
                    });
                    dropped_frames += u64::from(!kept);
                }
                events.append(&mut output.events);
                packets.clear();
                steps += 1;
            }
        }));
        drop(watching);
        shared.over.store(true, Ordering::Release);
        let mut state = runtime.state();
        if let Err(panic) = thinking {
            let reason = format!("the thinking thread has panicked: {}", said(&*panic));
            let event = Event { at_us: micros(), from: state, to: State::Damping, reason: reason.clone() };
            let _ = to_tell.try_send(event.clone());
            events.push(event);
            (failed, state) = (Some(reason), State::Damping);
        }
        drop((to_log, to_tell));
        let (lateness, unsent) =
            writing.join().unwrap_or_else(|panic| (Lateness::default(), Some(Failure::Panic(said(&*panic)))));
        // Their panics were reported.
        let logged = logging.join().ok().flatten();
        let _ = telling.join();
        print_the_rest();
        match (deaf, unsent) {
            (Some(error), _) | (None, Some(Failure::Link(error))) => return Err(error.into()),
            (None, Some(Failure::Panic(_)) | None) => {}
        }
        Ok(LiveReport {
            log_failed: match logged {
                Some(logged) => logged.err().map(|error| error.to_string()),
                None => Some("the logging thread has panicked".to_owned()),
            },
            events,
            state,
            kicks: runtime.kicks(),
            steps,
            longest_step_us,
            policy_steps,
            lateness,
            latency: runtime.latency().clone(),
            dropped_frames,
            real_time: shared.real_time.load(Ordering::Relaxed),
            died: failed,
        })
    })
}

/// Writes steps to the log until there are no more, and gives their room back. A disk that fails is reported once.
fn keep_log(
    log: Option<LogWriter>,
    steps: Receiver<Slot>,
    emptied: &SyncSender<Slot>,
    tell: &SyncSender<Event>,
) -> Result<usize, DeployError> {
    let mut ended = false;
    let Some(mut log) = log else { return Ok(0) };
    for mut slot in steps {
        let frame = slot.frame();
        log.write(&frame);
        if let (Some(why), false) = (log.failed(), ended) {
            ended = true;
            let reason = format!("the log ends here: {why}");
            let (from, to) = (frame.state, frame.state);
            let _ = tell.try_send(Event { at_us: frame.now_us, from, to, reason });
        }
        slot.again(frame);
        let _ = emptied.try_send(slot);
    }
    log.finish()
}

/// The message about a writer whose last period is too long ago, while the joints are under control.
fn silent_writer(shared: &Shared, runtime: &Runtime, now_us: u64) -> Option<String> {
    let silent_s = shared.silent_s(now_us);
    let moves = !matches!(runtime.state(), State::Passive | State::Damping);
    (moves && silent_s > runtime.limits().writer_age_s)
        .then(|| format!("the writing thread has sent nothing for {:.0} ms", 1e3 * silent_s))
}
