//! The log after a killed program and on a full disk.

use std::io::{self, BufRead, BufReader, Cursor, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Duration;

use crate::common::player;
use paid_runtime::log::{Frame, LogHeader, LogReader, LogWriter};
use paid_runtime::wire::LowState;
use paid_runtime::{
    ChannelLink, Inlet, LastWords, Limits, Live, Outlet, Packet, PlayerSpec, PolicyTrace, Runtime, State,
    Told, Writer, run_live,
};

const CHILD: &str = "PAID_LOG_OF_A_CHILD";

fn header() -> LogHeader {
    let player = PlayerSpec { policy: PathBuf::from("p"), motions: None, sets: Vec::new() };
    LogHeader { player, limits: Limits::default() }
}

fn frame(k: u64) -> Frame {
    let trace = PolicyTrace { observation: vec![k as f32; 100], action: vec![0.5; 29] };
    Frame {
        now_us: 2_000 * k,
        packets: vec![Packet::Battery(k as f64)],
        stop: false,
        command: vec![k as u8; 1004],
        state: State::Ready,
        trace: k.is_multiple_of(10).then_some(trace),
        events: Vec::new(),
    }
}

/// Not a test of its own: the program that the next one kills.
#[test]
fn child_that_logs_until_it_is_killed() {
    let Some(file) = std::env::var_os(CHILD) else { return };
    let mut log = LogWriter::create(Path::new(&file), &header()).expect("log");
    let mut out = io::stdout();
    for k in 0..1_000_000 {
        log.write(&frame(k));
        writeln!(out, "logged {k}").and_then(|()| out.flush()).expect("told");
    }
}

#[test]
fn after_kill_9_no_more_than_a_tenth_of_a_second_is_missing() {
    let dir = tempfile::tempdir().expect("dir");
    let file = dir.path().join("killed.mcap");
    let mut child = Command::new(std::env::current_exe().expect("this program"))
        .args(["--exact", "log::child_that_logs_until_it_is_killed", "--nocapture"])
        .env(CHILD, &file)
        .stdout(Stdio::piped())
        .spawn()
        .expect("child");
    let lines = BufReader::new(child.stdout.take().expect("output")).lines();
    let logged = lines.map_while(Result::ok).find(|line| line.ends_with("logged 1234"));
    // SIGKILL on Unix.
    child.kill().expect("kill");
    child.wait().expect("wait");
    assert!(logged.is_some(), "the child has ended early");
    let mut reader = LogReader::open(&file).expect("log");
    let mut found = 0;
    while let Some(read) = reader.next_frame().expect("frame") {
        assert_eq!(read, frame(found));
        found += 1;
    }
    // 1235 frames were logged at least, 500 a second.
    assert!(found >= 1235 - 50, "{found} frames");
}

/// The last step of a log, and what is said of its end.
fn end_of(file: &Path) -> (Option<u64>, Option<String>) {
    let mut reader = LogReader::open(file).expect("log");
    let mut last = None;
    while let Some(read) = reader.next_frame().expect("frame") {
        last = Some(read.now_us);
    }
    (last, reader.cut_off())
}

#[test]
fn a_log_that_is_cut_off_says_after_which_step() {
    let dir = tempfile::tempdir().expect("dir");
    let file = dir.path().join("cut.mcap");
    let mut log = LogWriter::create(&file, &header()).expect("log");
    (0..100).for_each(|k| log.write(&frame(k)));
    log.finish().expect("ended");
    assert_eq!(end_of(&file), (Some(198_000), None));
    let whole = std::fs::read(&file).expect("read");
    std::fs::write(&file, &whole[..whole.len() / 2]).expect("write");
    let (last, cut) = end_of(&file);
    let (last, cut) = (last.expect("a step"), cut.expect("cut off"));
    assert!((2_000..198_000).contains(&last), "{last}");
    let step = format!(
        "cut.mcap: the log is cut off after the step at {:.3} s: its program was killed",
        last as f64 * 1e-6
    );
    assert!(cut.contains(&step), "{cut}");
}

#[test]
fn a_pointer_and_a_compressed_log_are_told_with_what_to_do() {
    let dir = tempfile::tempdir().expect("dir");
    let said = |name: &str, bytes: &[u8]| {
        let file = dir.path().join(name);
        std::fs::write(&file, bytes).expect("write");
        LogReader::open(&file).map(drop).expect_err("refused").to_string()
    };
    let pointer = b"version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12\n";
    let error = said("pointer.mcap", pointer);
    assert!(
        error.contains("expected a log (MCAP), found a Git LFS pointer") && error.contains("git lfs pull"),
        "{error}"
    );
    // The magic; a header with two empty texts; a chunk: two times, a size, a check sum, the compression, the length of what follows.
    let record =
        |kind: u8, content: &[u8]| [&[kind][..], &(content.len() as u64).to_le_bytes(), content].concat();
    for compression in ["zstd", "lz4"] {
        let name = [&(compression.len() as u32).to_le_bytes(), compression.as_bytes()].concat();
        let chunk =
            [&[0; 16][..], &8_u64.to_le_bytes(), &[0; 4], &name, &8_u64.to_le_bytes(), &[7; 8]].concat();
        let bytes = [b"\x89MCAP0\r\n", &record(1, &[0; 8])[..], &record(6, &chunk)].concat();
        let error = said("small.mcap", &bytes);
        let expected = format!(
            "small.mcap: expected chunks without compression, found chunks compressed with {compression}; `mcap decompress IN.mcap"
        );
        assert!(error.contains(&expected), "{error}");
    }
}

#[test]
fn a_log_that_is_there_already_is_refused_and_stays_whole() {
    let dir = tempfile::tempdir().expect("dir");
    let file = dir.path().join("old.mcap");
    assert!(LogWriter::check_new(&file).is_ok());
    std::fs::write(&file, "a robot's only log").expect("write");
    let refusals = [LogWriter::check_new(&file).err(), LogWriter::create(&file, &header()).err()];
    for error in refusals {
        let error = error.expect("occupied").to_string();
        assert!(error.contains("old.mcap: expected a new file, found one that is there"), "{error}");
    }
    assert_eq!(std::fs::read(&file).expect("read"), b"a robot's only log");
}

#[test]
fn a_log_without_a_step_goes_with_the_start_that_was_refused() {
    let dir = tempfile::tempdir().expect("dir");
    let file = dir.path().join("new.mcap");
    drop(LogWriter::create(&file, &header()).expect("log"));
    assert!(!file.exists(), "the next start may use the name");
    // One that has a step, or was ended in order, stays.
    let mut log = LogWriter::create(&file, &header()).expect("log");
    log.write(&frame(0));
    drop(log);
    let mut reader = LogReader::open(&file).expect("log");
    assert_eq!(reader.next_frame().expect("frame"), Some(frame(0)));
    let file = dir.path().join("ended.mcap");
    assert_eq!(LogWriter::create(&file, &header()).expect("log").finish().expect("ended"), 0);
    assert!(file.exists());
}

/// A disk with room for this many bytes.
struct Disk(Cursor<Vec<u8>>, Arc<AtomicUsize>);

impl Disk {
    fn new(room: usize) -> (Box<Self>, Arc<AtomicUsize>) {
        let room = Arc::new(AtomicUsize::new(room));
        (Box::new(Self(Cursor::new(Vec::new()), Arc::clone(&room))), room)
    }
}

impl Write for Disk {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.0.position() as usize + bytes.len() > self.1.load(Ordering::Relaxed) {
            return Err(io::ErrorKind::StorageFull.into());
        }
        self.0.write(bytes)
    }
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for Disk {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.0.seek(to)
    }
}

#[test]
fn a_full_disk_ends_the_log_and_nothing_else() {
    let (disk, _) = Disk::new(100_000);
    let mut log = LogWriter::to(Path::new("full.mcap"), disk, &header()).expect("log");
    for k in 0..500 {
        log.write(&frame(k));
    }
    assert!(log.failed().is_some());
    let error = log.finish().expect_err("full").to_string();
    assert!(error.starts_with("full.mcap: "), "{error}");
}

/// A passive runtime with this log.
fn live(log: LogWriter) -> Live {
    let player = player();
    let limits = Limits { listen_s: 0.0, ..Limits::default() };
    Live {
        writer: Writer::new(&limits, player.joints()),
        runtime: Runtime::new(player, limits),
        dry_run: false,
        log: Some(log),
        switcher: None,
        keys: None,
        last_words: LastWords::default(),
        duration: None,
    }
}

/// A disk that blocks writes until it is released.
struct Stuck(Box<Disk>, Arc<AtomicBool>);

impl Write for Stuck {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        while self.1.load(Ordering::Relaxed) {
            std::thread::sleep(Duration::from_millis(1));
        }
        self.0.write(bytes)
    }
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for Stuck {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.0.seek(to)
    }
}

#[test]
fn a_disk_that_hangs_costs_frames_and_nothing_else() {
    let (disk, _) = Disk::new(usize::MAX);
    let stuck = Arc::new(AtomicBool::new(false));
    let log = LogWriter::to(Path::new("stuck.mcap"), Box::new(Stuck(disk, Arc::clone(&stuck))), &header());
    stuck.store(true, Ordering::Relaxed);
    let (mut robot, link) = ChannelLink::pair();
    let state = LowState { mode_machine: 5, ..LowState::default() };
    robot.send(Packet::LowState(state.sealed().to_cdr())).expect("a state");
    let stop = AtomicBool::new(false);
    let mut commands = 0;
    let report = run_live(live(log.expect("log")), link, &stop, |told| {
        let Told::Status(status) = told else { return };
        // A passive robot is commanded to damp.
        while let Ok(Some(Packet::LowCmd(_))) = robot.receive() {
            commands += 1;
        }
        // The log's room is a second; the first flush hangs.
        if status.runtime.at_us > 2_500_000 {
            stop.store(true, Ordering::Relaxed);
            stuck.store(false, Ordering::Relaxed);
        }
    })
    .expect("the link is well");
    assert!(report.dropped_frames > 0 && report.dropped_frames < report.steps, "{report:?}");
    assert_eq!((report.log_failed, report.died, report.state), (None, None, State::Damping));
    // The robot was spoken to all the time.
    assert!(commands > 500, "{commands}");
}

#[test]
fn a_disk_that_fills_up_in_a_run_is_reported_and_the_runtime_continues() {
    let (disk, room) = Disk::new(usize::MAX);
    let log = LogWriter::to(Path::new("full.mcap"), disk, &header()).expect("log");
    room.store(0, Ordering::Relaxed);
    let live = live(log);
    let (mut robot, link) = ChannelLink::pair();
    let state = LowState { mode_machine: 5, ..LowState::default() };
    robot.send(Packet::LowState(state.sealed().to_cdr())).expect("a state");
    let stop = AtomicBool::new(false);
    let mut said = None;
    let report = run_live(live, link, &stop, |told| match told {
        Told::Event(event) if event.reason.starts_with("the log ends here") => said = Some(event.at_us),
        // Status reports continue for half a second, past the second in which it only listens; then Ctrl-C is pressed.
        Told::Status(status) if said.is_some_and(|at| status.runtime.at_us > 1_500_000.max(at + 500_000)) => {
            stop.store(true, Ordering::Relaxed);
        }
        _ => {}
    })
    .expect("the link is well");
    assert!(report.log_failed.as_ref().is_some_and(|why| why.starts_with("full.mcap: ")), "{report:?}");
    assert_eq!((report.died, report.state), (None, State::Damping));
    // It damps in the end, as if there had been no log.
    let mut commands = 0;
    while let Ok(Some(Packet::LowCmd(_))) = robot.receive() {
        commands += 1;
    }
    assert!(commands > 100, "{commands}");
}
