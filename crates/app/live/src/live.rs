//! The scene in real time: steps when they are due, does what visitors want, shows every step.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

use paid_eval::subject::Subject;

use crate::board::Board;
use crate::game::Game;
use crate::pace::Pace;
use crate::scene::Scene;
use crate::{Command, Frame, LiveError, ServeOptions, Server};

/// How often a scene that stands still looks whether it should stop.
const PATIENCE: Duration = Duration::from_millis(100);

/// Commands that are executed before the next step and frame: visitors may send them faster than the simulation runs.
pub(crate) const AT_ONCE: usize = 64;

/// How a session begins.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlayOptions {
    /// Where the page is served.
    pub serve: ServeOptions,
    /// Balls come by themselves until a visitor takes one.
    pub auto: bool,
    /// The clip that every ball is kicked with; `None`: the one that suits the ball.
    pub clip: Option<u16>,
}

impl Default for PlayOptions {
    /// On this machine alone, playing by itself.
    fn default() -> Self {
        Self { serve: ServeOptions::default(), auto: true, clip: None }
    }
}

/// Summary of a session.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Summary {
    /// Control steps.
    pub steps: u64,
    /// Shots, and goals of these.
    pub shots: usize,
    /// Goals.
    pub goals: usize,
    /// Messages that were dropped.
    pub dropped: u64,
    /// Requests that were refused.
    pub refused: u64,
}

/// Serves the page and plays until `stop` is set. `ready` receives the address first. Time passes only while a page is open.
///
/// ```no_run
/// use std::sync::atomic::AtomicBool;
///
/// use paid_eval::subject::{Subject, SubjectSpec};
/// use paid_live::{PlayOptions, play};
///
/// let subject = Subject::load(&SubjectSpec::new("policies/demo/policy.onnx"))?;
/// let stop = AtomicBool::new(false);
/// play(&subject, &PlayOptions::default(), &stop, |url| println!("{url}"))?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If the address cannot be had, or policy, task and engine do not fit together.
pub fn play(
    subject: &Subject,
    options: &PlayOptions,
    stop: &AtomicBool,
    ready: impl FnOnce(&str),
) -> Result<Summary, LiveError> {
    let mut game = Game::new(subject, options.auto, options.clip)?;
    let scene = serde_json::to_string(&Scene::new(subject))?;
    let served = Server::start(&options.serve, scene)?;
    run(&mut game, served, stop, ready)
}

/// What runs in control steps and obeys commands.
pub(crate) trait Show {
    /// Length of a step `[s]`.
    fn dt_s(&self) -> f64;
    /// One step.
    fn step(&mut self) -> Result<(), LiveError>;
    /// Does what a visitor wants, but for the course of time.
    fn command(&mut self, command: Command) -> Result<(), LiveError>;
    /// The scene as it is now. `rate` is asked for and kept.
    fn frame(&self, rate: [f32; 2], paused: bool, late: bool, viewers: usize) -> Frame;
    /// What is counted and said.
    fn board(&self) -> &Board;
}

impl Show for Game<'_> {
    fn dt_s(&self) -> f64 {
        self.dt_s()
    }
    fn step(&mut self) -> Result<(), LiveError> {
        self.step()
    }
    fn command(&mut self, command: Command) -> Result<(), LiveError> {
        self.command(command)
    }
    fn frame(&self, rate: [f32; 2], paused: bool, late: bool, viewers: usize) -> Frame {
        self.frame(rate, paused, late, viewers)
    }
    fn board(&self) -> &Board {
        &self.board
    }
}

/// Shows it until `stop` is set.
pub(crate) fn run(
    show: &mut impl Show,
    (server, commands): (Server, Receiver<Command>),
    stop: &AtomicBool,
    ready: impl FnOnce(&str),
) -> Result<Summary, LiveError> {
    let mut live = Live { pace: Pace::new(Instant::now()), rate: 1.0, paused: false, server };
    live.show(show);
    live.server.tell(serde_json::to_string(show.board())?);
    ready(&live.server.url());
    let dt_s = show.dt_s();
    let (mut steps, mut told, mut watched) = (0, show.board().revision, 0);
    while !stop.load(Ordering::Relaxed) {
        let viewers = live.server.viewers();
        if watched == 0 && viewers > 0 {
            live.pace.resume(Instant::now(), live.rate);
        }
        watched = viewers;
        let runs = !live.paused && viewers > 0;
        let wait = if runs { live.pace.due().saturating_duration_since(Instant::now()) } else { PATIENCE };
        let mut changed = false;
        match commands.recv_timeout(wait.min(PATIENCE)) {
            Ok(first) => {
                for command in std::iter::once(first).chain(commands.try_iter()).take(AT_ONCE) {
                    if stop.load(Ordering::Relaxed) {
                        break;
                    }
                    steps += u64::from(live.obey(command, show)?);
                }
                changed = true;
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => break,
        }
        if runs && !live.paused && Instant::now() >= live.pace.due() {
            show.step()?;
            steps += 1;
            live.pace.stepped(Instant::now(), dt_s, live.rate);
            changed = true;
        }
        // The board first: a page that sees the end of a shot can read its outcome.
        if told != show.board().revision {
            told = show.board().revision;
            live.server.tell(serde_json::to_string(show.board())?);
        }
        if changed {
            live.show(show);
        }
    }
    let counts = live.server.counts();
    Ok(Summary {
        steps,
        shots: show.board().shots,
        goals: show.board().goals,
        dropped: counts.dropped.load(Ordering::Relaxed),
        refused: counts.refused.load(Ordering::Relaxed),
    })
}

/// The speed of time, and the open pages.
struct Live {
    pace: Pace,
    rate: f32,
    paused: bool,
    server: Server,
}

impl Live {
    /// Does what a visitor wants; true if that was a control step.
    fn obey(&mut self, command: Command, show: &mut impl Show) -> Result<bool, LiveError> {
        match command {
            Command::Pause(on) => {
                self.paused = on;
                self.pace.resume(Instant::now(), self.rate);
            }
            Command::Step => {
                self.paused = true;
                show.step()?;
                return Ok(true);
            }
            Command::Rate(rate) => {
                self.rate = rate;
                self.pace.resume(Instant::now(), rate);
            }
            other => show.command(other)?,
        }
        Ok(false)
    }

    fn show(&self, show: &impl Show) {
        let rate = [self.rate, if self.paused { 0.0 } else { self.pace.kept() }];
        let frame = show.frame(rate, self.paused, self.pace.late(), self.server.viewers());
        self.server.show(frame.encode());
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::sync::mpsc::{SyncSender, sync_channel};

    use super::*;

    /// Visitors who are faster than the show: for every command there is another one.
    struct Flooded<'a> {
        more: SyncSender<Command>,
        stop: &'a AtomicBool,
        board: Board,
        commands: usize,
        /// Commands since the last frame, and the most of them.
        since: Cell<usize>,
        most: usize,
    }

    impl Show for Flooded<'_> {
        fn dt_s(&self) -> f64 {
            0.02
        }
        fn step(&mut self) -> Result<(), LiveError> {
            Ok(())
        }
        fn command(&mut self, command: Command) -> Result<(), LiveError> {
            self.commands += 1;
            self.since.set(self.since.get() + 1);
            self.most = self.most.max(self.since.get());
            self.stop.store(self.commands >= 200, Ordering::Relaxed);
            // A thread that never ends must fail the test, not block it.
            if self.commands < 10_000 {
                self.more.try_send(command).expect("room");
            }
            Ok(())
        }
        fn frame(&self, _rate: [f32; 2], _paused: bool, _late: bool, _viewers: usize) -> Frame {
            self.since.set(0);
            Frame::default()
        }
        fn board(&self) -> &Board {
            &self.board
        }
    }

    #[test]
    fn a_flood_of_commands_holds_up_neither_the_pictures_nor_the_end() {
        let stop = AtomicBool::new(false);
        let (more, commands) = sync_channel(256);
        for _ in 0..200 {
            more.try_send(Command::Reset).expect("room");
        }
        let options = ServeOptions { port: Some(0), listen: None };
        let (server, _visitors) = Server::start(&options, "{}".to_owned()).expect("a free port");
        let (board, since) = (Board::default(), Cell::new(0));
        let mut show = Flooded { more, stop: &stop, board, commands: 0, since, most: 0 };
        run(&mut show, (server, commands), &stop, |_| {}).expect("it ends");
        assert_eq!((show.most, show.commands), (AT_ONCE, 200));
    }
}
