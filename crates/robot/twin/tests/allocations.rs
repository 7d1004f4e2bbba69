//! The control threads allocate nothing between transitions.

mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use common::player;
use paid_runtime::log::{LogHeader, LogReader, LogWriter};
use paid_runtime::wire::LowCmd;
use paid_runtime::{
    Inlet, LastWords, Limits, Link, LinkError, Live, LiveReport, Mailbox, Outlet, Packet, Player, PlayerSpec,
    Runtime, State, Writer, run_live,
};
use paid_twin::{Lockstep, LockstepOptions};

/// The system's allocator, which counts what this thread asks for while it watches.
struct Counting;

thread_local! {
    static COUNT: Cell<Option<u64>> = const { Cell::new(None) };
}

fn count() {
    // A thread that ends may have dropped its counter already.
    let _ = COUNT.try_with(|count| count.set(count.get().map(|n| n + 1)));
}

// SAFETY: everything is passed on to the system's allocator as it came; counting allocates nothing.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: the caller's promise.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: the caller's promise.
        unsafe { System.dealloc(memory, layout) }
    }
    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        // SAFETY: the caller's promise.
        unsafe { System.realloc(memory, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Allocations of this thread in `act`.
fn allocations<R>(act: impl FnOnce() -> R) -> (R, u64) {
    COUNT.set(Some(0));
    let result = act();
    (result, COUNT.replace(None).unwrap_or_default())
}

/// A way out that keeps nothing.
struct Nowhere(u64);

impl Outlet for Nowhere {
    fn send(&mut self, _packet: Packet) -> Result<(), LinkError> {
        Ok(())
    }
    fn command(&mut self, command: &LowCmd) -> Result<(), LinkError> {
        self.0 += u64::from(command.motors[0].mode);
        Ok(())
    }
}

#[test]
fn the_counter_counts() {
    assert_eq!(allocations(|| vec![1_u8; 100]).1, 1);
    assert_eq!(allocations(|| 1 + 1).1, 0);
}

/// A kick in lockstep: when each step of the runtime was, and what had come.
fn a_kick(player: &Arc<Player>, limits: &Limits) -> Vec<(u64, Vec<Packet>)> {
    let dir = tempfile::tempdir().expect("dir");
    let file = dir.path().join("kick.log");
    let spec = PlayerSpec { policy: PathBuf::new(), motions: None, sets: Vec::new() };
    let header = LogHeader { player: spec, limits: limits.clone() };
    let options = LockstepOptions { limits: limits.clone(), seed: 1, ..LockstepOptions::default() };
    let mut sim = Lockstep::new(player, &options).expect("MuJoCo");
    sim.set_log(LogWriter::create(&file, &header).expect("log"));
    sim.make_ready(false).expect("ready");
    sim.robot.place_ball([1.2, 0.0], [0.0; 2]);
    let settled = sim.run_until(8.0, |sim| sim.runtime().state() == State::Settle).expect("run");
    assert!(settled, "{:?}", sim.events().last().map(|event| (event.to, &event.reason)));
    sim.take_log().expect("log").finish().expect("log");
    let mut reader = LogReader::open(&file).expect("log");
    let mut steps = Vec::new();
    while let Some(frame) = reader.next_frame().expect("frame") {
        steps.push((frame.now_us, frame.packets));
    }
    steps
}

#[test]
fn a_runtime_that_kicks_allocates_nothing_between_transitions() {
    if !common::mujoco("a_runtime_that_kicks_allocates_nothing_between_transitions") {
        return;
    }
    let player = player();
    let limits = Limits { stand_up_s: 0.3, listen_s: 0.0, ..Limits::default() };
    let steps = a_kick(&player, &limits);
    let mut runtime = Runtime::new(Arc::clone(&player), limits);
    let (mut policy_steps, mut told, mut allocated) = (0, 0, Vec::new());
    for (now_us, packets) in &steps {
        let (output, count) = allocations(|| runtime.step(*now_us, packets, false));
        policy_steps += usize::from(output.acted);
        told += output.events.len();
        // A transition writes its sentence. The network's buffers are filled by the first policy step.
        if count > 0 && output.events.is_empty() && policy_steps != 1 {
            allocated.push((*now_us, count));
        }
    }
    assert!(policy_steps > 50 && told >= 4, "{policy_steps} policy steps, {told} events");
    assert_eq!(allocated, []);
}

/// A recorded kick, handed to the thinking thread one step at a time. From the first call of a step on it counts what that thread asks for,
/// less its own share.
struct Recorded {
    steps: std::vec::IntoIter<(u64, Vec<Packet>)>,
    waiting: Vec<Packet>,
    fresh: bool,
    over: Arc<AtomicBool>,
    /// Allocations of each step, its packets' own left out.
    counts: Arc<Mutex<Vec<u64>>>,
}

impl Inlet for Recorded {
    fn receive(&mut self) -> Result<Option<Packet>, LinkError> {
        let counted = COUNT.replace(None);
        if self.fresh {
            self.counts.lock().expect("alone").extend(counted);
            match self.steps.next() {
                Some((_, packets)) => self.waiting = packets.into_iter().rev().collect(),
                None => self.over.store(true, Ordering::Relaxed),
            }
        }
        let packet = self.waiting.pop();
        self.fresh = packet.is_none();
        COUNT.set(Some(if self.fresh { 0 } else { counted.unwrap_or(0) }));
        Ok(packet)
    }
}

impl Outlet for Recorded {
    fn send(&mut self, _packet: Packet) -> Result<(), LinkError> {
        Ok(())
    }
}

impl Link for Recorded {
    fn split(self) -> (Box<dyn Outlet>, Box<dyn Inlet>) {
        (Box::new(Nowhere(0)), Box::new(self))
    }
}

/// A disk that keeps nothing.
struct Void;

impl Write for Void {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        Ok(bytes.len())
    }
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for Void {
    fn seek(&mut self, _to: SeekFrom) -> io::Result<u64> {
        Ok(0)
    }
}

/// A log that keeps nothing.
fn void() -> LogWriter {
    let spec = PlayerSpec { policy: PathBuf::new(), motions: None, sets: Vec::new() };
    let header = LogHeader { player: spec, limits: Limits::default() };
    LogWriter::to(Path::new("nowhere"), Box::new(Void), &header).expect("log")
}

/// Steps of the thinking thread that allocated, of how many, and how the run ended.
fn thinking(log: Option<LogWriter>) -> (usize, usize, LiveReport) {
    let player = player();
    // The machine may be busy: its clock stops nothing here.
    let limits = Limits {
        stand_up_s: 0.3,
        listen_s: 0.0,
        state_gap_s: 0.1,
        command_age_s: 0.1,
        writer_age_s: 0.5,
        late_s: 0.1,
        late_steps: 10,
        ..Limits::default()
    };
    let steps = a_kick(&player, &limits);
    let (over, counts) = (Arc::new(AtomicBool::new(false)), Arc::<Mutex<Vec<u64>>>::default());
    let link = Recorded {
        steps: steps.into_iter(),
        waiting: Vec::new(),
        fresh: true,
        over: Arc::clone(&over),
        counts: Arc::clone(&counts),
    };
    let live = Live {
        writer: Writer::new(&limits, player.joints()),
        runtime: Runtime::new(player, limits),
        dry_run: false,
        log,
        switcher: None,
        keys: None,
        last_words: LastWords::default(),
        duration: None,
    };
    let report = run_live(live, link, &over, |_| {}).expect("a run");
    COUNT.set(None);
    let counts = counts.lock().expect("alone");
    (counts.iter().filter(|count| **count > 0).count(), counts.len(), report)
}

#[test]
fn the_whole_thinking_step_allocates_nothing_between_transitions_with_a_log_and_without() {
    let test = "the_whole_thinking_step_allocates_nothing_between_transitions_with_a_log_and_without";
    if !common::mujoco(test) {
        return;
    }
    for logs in [false, true] {
        // The recorded packets do not wait for a machine that is busy: then the kick may be missed. A kick's own steps are counted above, in
        // simulated time.
        let (allocated, steps, report) = thinking(logs.then(void));
        // A transition writes its sentence; the network's buffers and the list of packets grow in the first steps.
        let events = report.events.len();
        assert!(steps > 1000 && events >= 1, "{steps} steps, {events} events, log {logs}");
        assert!(allocated <= events + 4, "{allocated} of {steps} steps, {events} events, log {logs}");
    }
}

#[test]
fn the_writer_and_the_handover_to_it_allocate_nothing() {
    let mut writer = Writer::new(&Limits::default(), 29);
    let (mailbox, mut out) = (Mailbox::default(), Nowhere(0));
    let command = LowCmd::damping(5, 29, 3.0);
    let (sent, count) = allocations(|| {
        for k in 0..100_u64 {
            // The runtime falls silent half way: the writer's own damping allocates nothing either.
            if k < 50 {
                mailbox.put((Some(command.clone()), 2_000 * k));
            }
            if let Some((command, given_us)) = mailbox.take() {
                writer.give(command, given_us);
            }
            if let Some(command) = writer.write(2_000 * k) {
                out.command(&command).expect("nowhere");
            }
        }
        out.0
    });
    assert_eq!((sent, count), (100, 0));
    assert!(writer.stopped());
}
