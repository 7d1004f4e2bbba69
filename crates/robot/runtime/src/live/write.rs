//! The writing thread: the newest command 500 times a second, and what becomes of a link that fails.

use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::SyncSender;
use std::time::Instant;

use super::panics::{Prints, Watching, said};
use crate::cpu::{WRITER_PRIORITY, ask_for_real_time};
use crate::lateness::{Lateness, Pace};
use crate::link::{LinkError, Outlet};
use crate::mailbox::Mailbox;
use crate::wire::{COMMAND_US, LowCmd};
use crate::writer::Writer;

/// Damping is sent for this many periods once the thinking thread has ended: half a second.
const REST: u32 = 250;
/// Commands that may fail before the link is given up. After the first one there is only damping.
const TRIES: u32 = 10;

/// Why a command was not sent.
#[derive(Clone, Debug)]
pub(super) enum Failure {
    /// The link has reported it.
    Link(LinkError),
    /// The link's code has panicked.
    Panic(String),
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Link(error) => write!(f, "commands cannot be sent: {error}"),
            Self::Panic(why) => write!(f, "the writing thread has panicked: {why}"),
        }
    }
}

/// What the writing thread shares with the others.
#[derive(Default)]
pub(super) struct Shared {
    /// The command of the runtime to send, if any, and its time `[us]`.
    pub commands: Mailbox<(Option<LowCmd>, u64)>,
    /// The thinking thread has ended.
    pub over: AtomicBool,
    /// The system has granted real-time priority.
    pub real_time: AtomicBool,
    /// Commands sent.
    pub sent: AtomicU64,
    /// How late the latest command since the last status was `[us]`.
    pub latest_us: AtomicU64,
    /// When the last period went well `[us]`; 0 before the first.
    pub beat_us: AtomicU64,
}

impl Shared {
    /// Time since the last period that went well `[s]`; 0 before the first.
    pub fn silent_s(&self, now_us: u64) -> f64 {
        match self.beat_us.load(Ordering::Acquire) {
            0 => 0.0,
            beat_us => now_us.saturating_sub(beat_us) as f64 * 1e-6,
        }
    }
}

/// Writes until the thinking thread has ended and the robot was commanded to damp for half a second after it. A failure goes to `broken` at
/// once; from then on nothing but damping is tried.
pub(super) fn write_on(
    mut writer: Writer,
    mut out: Box<dyn Outlet>,
    shared: &Shared,
    begin: Instant,
    dry_run: bool,
    broken: &SyncSender<String>,
) -> (Lateness, Option<Failure>) {
    // The panic of a link's code is reported in the hook: the writer must not print, for it has damping to send.
    let told = broken.clone();
    let _watching = Watching::begin("writing", Prints::Later, move |words| {
        let _ = told.try_send(words);
    });
    shared.real_time.store(ask_for_real_time(WRITER_PRIORITY), Ordering::Relaxed);
    let (mut pace, mut lateness) = (Pace::new(COMMAND_US), Lateness::default());
    let (mut rest, mut tries, mut first) = (REST, TRIES, None);
    while rest > 0 && tries > 0 {
        let late = pace.wait();
        lateness.add(late);
        shared.latest_us.fetch_max(late.as_micros() as u64, Ordering::Relaxed);
        if shared.over.load(Ordering::Acquire) {
            rest -= 1;
            writer.stop();
        }
        if let Some((command, given_us)) = shared.commands.take() {
            writer.give(command, given_us);
        }
        let now_us = begin.elapsed().as_micros() as u64;
        let damped = writer.stopped();
        let sent = catch_unwind(AssertUnwindSafe(|| match writer.write(now_us) {
            Some(command) if !dry_run => out.command(&command).map(|()| 1),
            _ => Ok(0),
        }));
        // A thinking thread that hung and came back must learn that its commands are no longer used.
        if !damped
            && writer.stopped()
            && let Some(age_us) = writer.age_us(now_us)
        {
            let _ = broken.try_send(format!("the thinking thread gave no command for {} ms", age_us / 1000));
        }
        let failure = match sent {
            Ok(Ok(commands)) => {
                shared.sent.fetch_add(commands, Ordering::Relaxed);
                shared.beat_us.store(now_us.max(1), Ordering::Release);
                continue;
            }
            Ok(Err(error)) => Failure::Link(error),
            Err(panic) => Failure::Panic(said(&*panic)),
        };
        writer.stop();
        tries -= 1;
        if first.is_none() {
            // The channel has room for the messages of all threads.
            if let Failure::Link(_) = failure {
                let _ = broken.try_send(failure.to_string());
            }
            first = Some(failure);
        }
    }
    (lateness, first)
}
