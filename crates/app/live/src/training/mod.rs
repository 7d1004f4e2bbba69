//! The page of a training run: its curves, and its current policy next to them.
//!
//! A thread of its own reads the run folder and nothing else, so that the training's result is the same with and without it.

mod act;
mod course;
mod follow;
mod time;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use paid_eval::subject::{Subject, SubjectSpec};
use paid_train::TrainedPolicy;
use paid_train::folder::checkpoints;

use crate::live::AT_ONCE;
use crate::scene::Scene;
use crate::{Command, LiveError, ServeOptions, Server};

use act::Act;
use course::Course;
use time::Time;

/// How often the thread checks whether it should end, or whether a page is open.
const PATIENCE: Duration = Duration::from_millis(100);
/// How often it reads the run folder while a page is open.
const LOOK: Duration = Duration::from_secs(2);
/// What a page of a training has done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Seen {
    /// Control steps.
    pub steps: u64,
    /// Policies that were read.
    pub policies: u64,
}

/// What the training says to the thread, and it to the training.
#[derive(Default)]
struct Shared {
    stop: AtomicBool,
    run: Mutex<Option<PathBuf>>,
    steps: AtomicU64,
    policies: AtomicU64,
}

/// A page that shows a training. Dropping it ends it.
///
/// ```no_run
/// use std::path::Path;
///
/// use paid_live::{ServeOptions, TrainingPage};
///
/// let page = TrainingPage::start(&ServeOptions::default(), |error| eprintln!("{error}"))?;
/// println!("{}", page.url());
/// page.follow(Path::new("runs/stage1"));
/// // ... train into runs/stage1 ...
/// # Ok::<(), paid_live::LiveError>(())
/// ```
pub struct TrainingPage {
    url: String,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

impl TrainingPage {
    /// Serves the page in a thread. `failed` is called once if it cannot continue.
    ///
    /// # Errors
    /// If the address cannot be had, or the system gives no thread or no random numbers.
    pub fn start(
        options: &ServeOptions,
        failed: impl FnOnce(&LiveError) + Send + 'static,
    ) -> Result<Self, LiveError> {
        let (server, commands) = Server::start(options, String::new())?;
        let url = server.url();
        let shared = Arc::new(Shared::default());
        let mut desk = Desk {
            server,
            commands,
            shared: Arc::clone(&shared),
            run: None,
            course: None,
            looked: None,
            playing: None,
        };
        let work = move || {
            if let Err(error) = desk.work() {
                failed(&error);
            }
        };
        let thread = thread::Builder::new().name("live".to_owned()).spawn(work).map_err(LiveError::Server)?;
        Ok(Self { url, shared, thread: Some(thread) })
    }

    /// What to open in a browser.
    pub fn url(&self) -> &str {
        &self.url
    }

    /// Switches to the training run in this folder. The last policy plays until the run has one.
    pub fn follow(&self, run: &Path) {
        *self.shared.run.lock().unwrap_or_else(PoisonError::into_inner) = Some(run.to_owned());
    }

    /// What the page has done so far.
    pub fn seen(&self) -> Seen {
        let Shared { steps, policies, .. } = &*self.shared;
        Seen { steps: steps.load(Ordering::Relaxed), policies: policies.load(Ordering::Relaxed) }
    }
}

impl Drop for TrainingPage {
    fn drop(&mut self) {
        self.shared.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // A panic was printed where it happened; training continues.
            let _ = thread.join();
        }
    }
}

/// A checkpoint.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Found {
    run: PathBuf,
    iteration: u64,
    path: PathBuf,
}

/// The thread.
struct Desk {
    server: Server,
    commands: Receiver<Command>,
    shared: Arc<Shared>,
    run: Option<PathBuf>,
    course: Option<Course>,
    looked: Option<Instant>,
    playing: Option<Found>,
}

impl Desk {
    fn work(&mut self) -> Result<(), LiveError> {
        let mut next = None;
        while !self.shared.stop.load(Ordering::Relaxed) {
            next = match next {
                Some(found) => self.play(found)?,
                None => {
                    // There is nothing to command yet.
                    while self.commands.try_recv().is_ok() {}
                    thread::sleep(PATIENCE);
                    self.look()?
                }
            };
        }
        Ok(())
    }

    /// Reads the log and looks for a new checkpoint, every two seconds while a page is open.
    fn look(&mut self) -> Result<Option<Found>, LiveError> {
        if self.server.viewers() == 0 || self.looked.is_some_and(|looked| looked.elapsed() < LOOK) {
            return Ok(None);
        }
        self.looked = Some(Instant::now());
        let run = self.shared.run.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let Some(run) = run else { return Ok(None) };
        let other = self.run.as_ref() != Some(&run);
        if other {
            (self.run, self.course) = (Some(run.clone()), Some(Course::of(&run)));
        }
        // Before the first iteration there is no folder.
        let newest = checkpoints(&run).ok().and_then(|mut all| all.pop());
        let found = newest.map(|(iteration, path)| Found { run, iteration, path });
        let found = found.filter(|found| self.playing.as_ref() != Some(found));
        let read = self.course.as_mut().is_some_and(Course::read);
        if read || other {
            self.plot()?;
        }
        Ok(found)
    }

    /// Sends the curves, and which policy plays.
    fn plot(&self) -> Result<(), LiveError> {
        let playing = self.playing.as_ref().filter(|found| Some(&found.run) == self.run.as_ref());
        if let Some(course) = &self.course {
            self.server.plot(course.json(playing.map(|found| found.iteration))?);
        }
        Ok(())
    }

    /// Plays until there is a checkpoint of another run: that, or `None` at the end.
    fn play(&mut self, found: Found) -> Result<Option<Found>, LiveError> {
        let spec = SubjectSpec { threads: 1, ..SubjectSpec::new(&found.path) };
        let subject = match Subject::load(&spec) {
            Ok(subject) => subject,
            // The training removes old checkpoints; there is a newer one.
            Err(_) if !found.path.exists() => return Ok(None),
            Err(error) => return Err(error.into()),
        };
        let mut act = Act::new(&subject)?;
        self.shared.policies.fetch_add(1, Ordering::Relaxed);
        self.server.set_scene(serde_json::to_string(&Scene::new(&subject))?);
        let run = found.run.clone();
        self.playing = Some(found);
        self.plot()?;
        let mut time = Time::new(subject.setup.preset.control_dt_s());
        let mut told = None;
        let mut watched = false;
        while !self.shared.stop.load(Ordering::Relaxed) {
            if let Some(found) = self.look()? {
                if found.run != run {
                    return Ok(Some(found));
                }
                match TrainedPolicy::load(&found.path) {
                    Ok(policy) => act.act_by(policy)?,
                    Err(_) if !found.path.exists() => continue,
                    Err(error) => return Err(paid_eval::EvalError::from(error).into()),
                }
                self.shared.policies.fetch_add(1, Ordering::Relaxed);
                self.playing = Some(found);
                self.plot()?;
            }
            let looks_on = self.server.viewers() > 0;
            if looks_on && !watched {
                time.pace.resume(Instant::now(), time.rate);
            }
            watched = looks_on;
            let runs = looks_on && (!time.paused || time.once);
            let wait =
                if runs { time.pace.due().saturating_duration_since(Instant::now()) } else { PATIENCE };
            let mut changed = told.is_none();
            match self.commands.recv_timeout(wait.min(PATIENCE)) {
                Ok(first) => {
                    for command in std::iter::once(first).chain(self.commands.try_iter()).take(AT_ONCE) {
                        if self.shared.stop.load(Ordering::Relaxed) {
                            break;
                        }
                        if !time.obey(command) {
                            act.command(command)?;
                        }
                    }
                    changed = true;
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            let begun = Instant::now();
            let due = runs && begun >= time.pace.due();
            if due {
                act.step()?;
                self.shared.steps.fetch_add(1, Ordering::Relaxed);
                time.once = false;
            }
            if told != Some(act.board().revision) {
                told = Some(act.board().revision);
                self.server.tell(serde_json::to_string(act.board())?);
            }
            if changed || due {
                self.show(&act, &time);
            }
            if due {
                time.stepped(begun, Instant::now());
            }
        }
        Ok(None)
    }

    fn show(&self, act: &Act<'_>, time: &Time) {
        let frame = act.frame(time, self.server.viewers());
        self.server.show(frame.encode());
    }
}
