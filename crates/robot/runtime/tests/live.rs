//! What becomes of the robot when a part of the running program dies.

use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::common::player;
use paid_runtime::log::{LogHeader, LogWriter};
use paid_runtime::switcher::Line;
use paid_runtime::wire::{Key, LowCmd, LowState, Remote};
use paid_runtime::{
    DeployError, Inlet, LastWords, Limits, Link, LinkError, Live, LiveReport, Outlet, Packet, PlayerSpec,
    Runtime, State, Told, Writer, run_live,
};

/// What goes wrong, some states after the robot stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Wrong {
    /// One command cannot be sent; later ones can.
    OneCommand,
    /// No command can be sent any more.
    Commands,
    /// The link's code panics in the writing thread.
    WriterPanics,
    /// Nothing is sent for a quarter of a second, without an error.
    WriterHangs,
    /// The link's code panics in the thinking thread.
    ThinkerPanics,
    /// Reading takes a quarter of a second once; then all is well again.
    ThinkerHangs,
    /// Nothing can be read any more.
    Reading,
    /// The reporting callback panics.
    TellerPanics,
    /// The log's sink panics.
    LogPanics,
    /// The way to the motion switcher panics.
    SwitcherPanics,
    /// A thread outside the run panics, like one of perception or the keyboard.
    BesidePanics,
}

/// A disk, or a way to the motion switcher, that panics once the robot stands.
struct Cracked(Arc<Patient>);

impl Cracked {
    fn crack(&self) {
        assert!(!self.0.begins(), "a crack");
    }
}

impl Write for Cracked {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.crack();
        Ok(bytes.len())
    }
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for Cracked {
    fn seek(&mut self, _to: SeekFrom) -> io::Result<u64> {
        Ok(0)
    }
}

impl Line for Cracked {
    fn send(&mut self, _bytes: Vec<u8>) -> Result<(), LinkError> {
        Ok(())
    }
    fn receive(&mut self) -> Result<Option<Vec<u8>>, LinkError> {
        self.crack();
        Ok(None)
    }
}

/// A robot that is well, for ever, at the other end of a link that is not.
#[derive(Debug)]
struct Patient {
    wrong: Wrong,
    begin: Instant,
    /// States that were read.
    states: AtomicU64,
    /// The fault has begun.
    begun: AtomicBool,
    /// When, and when the first damping command came after it.
    reaction: Mutex<[Option<Instant>; 2]>,
    /// Commands after that: damping, and others.
    damping: AtomicUsize,
    others: AtomicUsize,
    /// True if another command came after a damping one.
    moved_again: AtomicBool,
}

struct Way(Arc<Patient>);

impl Patient {
    fn link(wrong: Wrong) -> (Arc<Self>, Way) {
        let patient = Arc::new(Self {
            wrong,
            begin: Instant::now(),
            states: AtomicU64::new(0),
            begun: AtomicBool::new(false),
            reaction: Mutex::new([None; 2]),
            damping: AtomicUsize::new(0),
            others: AtomicUsize::new(0),
            moved_again: AtomicBool::new(false),
        });
        (Arc::clone(&patient), Way(patient))
    }
    /// True once the robot stands: 2 ms each.
    fn stands(&self) -> bool {
        self.states.load(Ordering::Relaxed) > 200
    }
    /// True for the first call after the robot stands.
    fn begins(&self) -> bool {
        let first = self.stands() && !self.begun.swap(true, Ordering::Relaxed);
        if first {
            self.reaction.lock().unwrap_or_else(PoisonError::into_inner)[0] = Some(Instant::now());
        }
        first
    }
    /// Clock time from the fault to the first damping command.
    fn reacted(&self) -> Duration {
        match *self.reaction.lock().unwrap_or_else(PoisonError::into_inner) {
            [Some(fault), Some(damped)] => damped - fault,
            other => panic!("never damped: {other:?}"),
        }
    }
}

impl Outlet for Way {
    fn send(&mut self, _packet: Packet) -> Result<(), LinkError> {
        Ok(())
    }
    fn command(&mut self, command: &LowCmd) -> Result<(), LinkError> {
        let patient = &self.0;
        let before = !patient.begun.load(Ordering::Relaxed);
        match patient.wrong {
            Wrong::OneCommand if patient.begins() => return Err(LinkError::Closed),
            Wrong::Commands if patient.stands() => return Err(LinkError::Closed),
            Wrong::WriterPanics if patient.begins() => panic!("a bolt is loose"),
            Wrong::WriterHangs if patient.begins() => std::thread::sleep(Duration::from_millis(250)),
            _ => {}
        }
        if !before || !patient.stands() {
            let damps = command.motors[..29].iter().all(|m| m.kp == 0.0 && m.kd > 0.0);
            if !before && damps {
                let mut reaction = patient.reaction.lock().unwrap_or_else(PoisonError::into_inner);
                reaction[1].get_or_insert_with(Instant::now);
            }
            let again = !before && !damps && patient.damping.load(Ordering::Relaxed) > 0;
            patient.moved_again.fetch_or(again, Ordering::Relaxed);
            let counter = if damps { &patient.damping } else { &patient.others };
            counter.fetch_add(usize::from(!before), Ordering::Relaxed);
        }
        Ok(())
    }
}

impl Inlet for Way {
    fn receive(&mut self) -> Result<Option<Packet>, LinkError> {
        let patient = &self.0;
        match patient.wrong {
            Wrong::ThinkerPanics if patient.begins() => panic!("a thought too many"),
            Wrong::ThinkerHangs if patient.begins() => std::thread::sleep(Duration::from_millis(250)),
            Wrong::Reading if patient.begins() => return Err(LinkError::Closed),
            _ => {}
        }
        // A state every 2 ms of the clock.
        let due = patient.begin.elapsed().as_millis() as u64 / 2;
        let k = patient.states.load(Ordering::Relaxed);
        if k >= due {
            return Ok(None);
        }
        patient.states.store(k + 1, Ordering::Relaxed);
        let mut state = LowState { mode_machine: 5, tick: 2 * k as u32, ..LowState::default() };
        state.imu.quaternion = [1.0, 0.0, 0.0, 0.0];
        let keys: &[Key] = if (50..60).contains(&k) { &[Key::L2, Key::Up] } else { &[] };
        state.wireless_remote = Remote::pressing(keys);
        Ok(Some(Packet::LowState(state.sealed().to_cdr())))
    }
}

impl Link for Way {
    fn split(self) -> (Box<dyn Outlet>, Box<dyn Inlet>) {
        (Box::new(Self(Arc::clone(&self.0))), Box::new(self))
    }
}

/// Runs a robot that stands until something goes wrong; the patient, what was reported of it, and how it ended.
fn run(wrong: Wrong) -> (Arc<Patient>, Vec<String>, Result<LiveReport, DeployError>) {
    let player = player();
    // The machine may be busy: only the fault may end it.
    let limits = Limits {
        listen_s: 0.0,
        stand_up_s: 0.1,
        state_gap_s: 0.1,
        command_age_s: 0.1,
        writer_age_s: if wrong == Wrong::WriterHangs { 0.05 } else { 0.5 },
        late_s: 0.1,
        late_steps: 10,
        ..Limits::default()
    };
    let (patient, link) = Patient::link(wrong);
    let log = (wrong == Wrong::LogPanics).then(|| {
        let spec = PlayerSpec { policy: PathBuf::new(), motions: None, sets: Vec::new() };
        let header = LogHeader { player: spec, limits: limits.clone() };
        LogWriter::to(Path::new("cracked.mcap"), Box::new(Cracked(Arc::clone(&patient))), &header)
            .expect("log")
    });
    let switcher: Option<Box<dyn Line>> =
        if wrong == Wrong::SwitcherPanics { Some(Box::new(Cracked(Arc::clone(&patient)))) } else { None };
    let last_words = LastWords::default();
    let beside = (wrong == Wrong::BesidePanics).then(|| {
        let (words, patient) = (last_words.clone(), Arc::clone(&patient));
        std::thread::spawn(move || {
            words.guard("eyes' ball", || {
                while !patient.begins() {
                    std::thread::sleep(Duration::from_millis(1));
                }
                panic!("a mote");
            })
        })
    });
    let live = Live {
        writer: Writer::new(&limits, player.joints()),
        runtime: Runtime::new(player, limits),
        dry_run: false,
        log,
        switcher,
        keys: None,
        last_words,
        duration: Some(Duration::from_secs(20)),
    };
    let mut said = Vec::new();
    let stop = AtomicBool::new(false);
    let report = run_live(live, link, &stop, |told| {
        assert!(wrong != Wrong::TellerPanics || !patient.begins(), "speechless");
        if let Told::Event(event) = told
            && event.to == State::Damping
        {
            said.push(event.reason.clone());
        }
    });
    if let Some(beside) = beside {
        assert!(matches!(beside.join(), Ok(None::<()>)));
    }
    (patient, said, report)
}

/// Damping and other commands after the fault.
fn commands(patient: &Patient) -> (usize, usize) {
    (patient.damping.load(Ordering::Relaxed), patient.others.load(Ordering::Relaxed))
}

#[test]
fn a_command_that_cannot_be_sent_is_noticed_and_followed_by_damping_alone() {
    let (patient, said, report) = run(Wrong::OneCommand);
    assert_eq!(said, ["commands cannot be sent: the link is closed: the other end has ended"]);
    assert_eq!(report.expect_err("broken").to_string(), "the link is closed: the other end has ended");
    let (damping, others) = commands(&patient);
    assert!(damping > 100 && others == 0, "{damping} of damping, {others} others");
}

#[test]
fn a_link_that_takes_no_command_ends_the_run_with_its_error() {
    let (patient, said, report) = run(Wrong::Commands);
    assert_eq!(said, ["commands cannot be sent: the link is closed: the other end has ended"]);
    assert!(matches!(report, Err(DeployError::Link(LinkError::Closed))), "{report:?}");
    assert!(patient.begin.elapsed() < Duration::from_secs(15), "it went on");
}

#[test]
fn a_writer_that_panics_damps_the_robot_and_says_why() {
    let (patient, said, report) = run(Wrong::WriterPanics);
    let why = "the writing thread has panicked: a bolt is loose";
    assert_eq!(said, [why]);
    let report = report.expect("a report");
    assert_eq!((report.died.as_deref(), report.state), (Some(why), State::Damping));
    let (damping, others) = commands(&patient);
    assert!(damping > 100 && others == 0, "{damping} of damping, {others} others");
}

#[test]
fn a_writer_that_hangs_is_missed_and_damps_when_it_is_back() {
    let (patient, said, report) = run(Wrong::WriterHangs);
    let report = report.expect("a report");
    assert!(said.len() == 1 && said[0].starts_with("the writing thread has sent nothing for "), "{said:?}");
    assert_eq!((report.died.as_ref(), report.state), (Some(&said[0]), State::Damping));
    // The command that hung was an old one.
    let (damping, others) = commands(&patient);
    assert!(damping > 100 && others <= 1, "{damping} of damping, {others} others");
}

#[test]
fn a_thinker_that_panics_leaves_damping_and_its_words_behind() {
    let (patient, said, report) = run(Wrong::ThinkerPanics);
    let why = "the thinking thread has panicked: a thought too many";
    assert_eq!(said, [why]);
    let report = report.expect("a report");
    assert_eq!((report.died.as_deref(), report.state), (Some(why), State::Damping));
    assert_eq!(report.events.last().map(|event| event.reason.as_str()), Some(why));
    // No more than the writer may have had in its hands.
    let (damping, others) = commands(&patient);
    assert!(damping > 200 && others <= 2, "{damping} of damping, {others} others");
}

#[test]
fn a_thinker_that_hangs_finds_the_robot_damped_and_hears_why() {
    let (patient, said, report) = run(Wrong::ThinkerHangs);
    let report = report.expect("a report");
    assert!(said.len() == 1 && said[0].starts_with("the thinking thread gave no command for "), "{said:?}");
    assert_eq!((report.died.as_ref(), report.state), (Some(&said[0]), State::Damping));
    // The writer repeats the last command until it is too old. After that it only damps.
    let (damping, others) = commands(&patient);
    assert!(damping > 100, "{damping} of damping, {others} others");
    assert!(!patient.moved_again.load(Ordering::Relaxed), "it moved again");
}

#[test]
fn a_link_that_cannot_be_read_damps_and_says_so() {
    let (patient, said, report) = run(Wrong::Reading);
    assert_eq!(said, ["nothing can be received: the link is closed: the other end has ended"]);
    assert!(matches!(report, Err(DeployError::Link(LinkError::Closed))), "{report:?}");
    assert!(commands(&patient).0 > 200);
}

#[test]
fn a_teller_that_panics_ends_the_run_by_damping() {
    let (patient, _, report) = run(Wrong::TellerPanics);
    let report = report.expect("a report");
    let why = "the telling thread has panicked: speechless";
    assert_eq!((report.died.as_deref(), report.state), (Some(why), State::Damping));
    assert_eq!(report.events.last().map(|event| event.reason.as_str()), Some(why));
    assert!(commands(&patient).0 > 200);
}

/// A thread's panic ends the run by damping, with its name, and soon. The bound is generous: the machine may be busy.
fn is_named(wrong: Wrong, why: &str) {
    let (patient, said, report) = run(wrong);
    assert_eq!(said, [why]);
    let report = report.expect("a report");
    assert_eq!((report.died.as_deref(), report.state), (Some(why), State::Damping));
    assert!(commands(&patient).0 > 200);
    let reacted = patient.reacted();
    println!("{wrong:?}: damped {:.1} ms after the panic", reacted.as_secs_f64() * 1e3);
    assert!(reacted < Duration::from_secs(5), "{reacted:?}");
}

#[test]
fn a_log_that_panics_ends_the_run_by_damping() {
    is_named(Wrong::LogPanics, "the logging thread has panicked: a crack");
}

#[test]
fn a_way_to_the_switcher_that_panics_ends_the_run_by_damping() {
    is_named(Wrong::SwitcherPanics, "the switcher's thread has panicked: a crack");
}

#[test]
fn a_thread_outside_the_run_that_panics_ends_it_by_damping() {
    is_named(Wrong::BesidePanics, "the eyes' ball thread has panicked: a mote");
}
