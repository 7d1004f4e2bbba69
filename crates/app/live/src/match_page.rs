//! A page to watch while matches are played.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use paid_eval::engine::EngineChoice;
use paid_eval::matches::{KickOutcome, Spectacle, Spectator};
use paid_eval::metrics::shooting::fallen;
use paid_eval::monitor::Monitor;
use paid_eval::subject::Subject;
use paid_lanes::{Mat3, Quat, Vec3};
use paid_play::ReferenceLibrary;

use crate::drawn::Drawn;
use crate::pace::Pace;
use crate::wire::{Flags, Frame};
use crate::{LiveError, Outcome, Pose2, ServeOptions, Shot, WatchPage};

/// How often to check for the first open page.
const PATIENCE: Duration = Duration::from_millis(50);
/// No match is shown.
const NONE: usize = usize::MAX;

/// Shows the matches of `paid eval match`, one after the other. The first one waits for an open page. While there is one, the match
/// that is shown keeps real time; else it goes as fast as it can. The page's stop ends the evaluation.
///
/// ```no_run
/// use paid_eval::matches::{Audience, MatchOptions, evaluate};
/// use paid_eval::subject::{Subject, SubjectSpec};
/// use paid_live::{MatchPage, ServeOptions};
///
/// let subject = Subject::load(&SubjectSpec::new("policies/demo/policy.onnx"))?;
/// let page = MatchPage::start(&subject, &ServeOptions::default())?;
/// println!("{}", page.url());
/// let audience = Audience { filmed: 0, spectator: Some(&page) };
/// let (report, _) = evaluate(&subject.setup, &*subject.maker, &MatchOptions::default(), audience)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct MatchPage {
    url: String,
    /// Number of the match that is shown.
    number: AtomicUsize,
    shown: Mutex<Shown>,
    monitor: Monitor,
}

/// The match that is shown.
struct Shown {
    page: WatchPage,
    pace: Pace,
    watched: bool,
    engine: &'static str,
    library: Arc<ReferenceLibrary>,
    anchor: usize,
    nominal_height_m: f64,
    dt_s: f64,
    /// The world's axes on the pitch.
    axes: Pose2,
    ball_quat: Quat<f64>,
    /// Fastest that the ball was in this kick `[m/s]`.
    fastest: f64,
}

impl MatchPage {
    /// Serves the page.
    ///
    /// # Errors
    /// If the address cannot be had, or the system gives no thread or no random numbers.
    pub fn start(subject: &Subject, options: &ServeOptions) -> Result<Self, LiveError> {
        let setup = &subject.setup;
        let page = WatchPage::of_subject(subject, options)?;
        let shown = Shown {
            pace: Pace::new(Instant::now()),
            watched: false,
            engine: if matches!(setup.engine, EngineChoice::Builtin) { "built-in" } else { "MuJoCo" },
            library: Arc::clone(&setup.library),
            anchor: setup.robot.body_index(&setup.spec.anchor_body).unwrap_or(0),
            nominal_height_m: setup.spec.nominal_height_m,
            dt_s: setup.preset.control_dt_s(),
            axes: Pose2::default(),
            ball_quat: Quat::identity(),
            fastest: 0.0,
            page,
        };
        let url = shown.page.url();
        let monitor = setup.monitor.clone();
        Ok(Self { url, number: AtomicUsize::new(NONE), shown: Mutex::new(shown), monitor })
    }

    /// What to open in a browser.
    pub fn url(&self) -> &str {
        &self.url
    }

    fn with<T>(&self, act: impl FnOnce(&mut Shown) -> T) -> T {
        act(&mut self.shown.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// True if this match is shown; if none is, this one will be.
    fn shows(&self, moment: &Spectacle<'_>) -> bool {
        let order = Ordering::Relaxed;
        match self.number.compare_exchange(NONE, moment.number, order, order) {
            Ok(_) => {
                self.with(|shown| shown.begin(moment));
                true
            }
            Err(number) => number == moment.number,
        }
    }
}

impl Spectator for MatchPage {
    fn see(&self, moment: &Spectacle<'_>) {
        if !self.shows(moment) {
            return;
        }
        let due = loop {
            let (due, watched) = self.with(|shown| shown.see(moment, &self.monitor));
            if watched || self.monitor.stopped() {
                break due;
            }
            thread::sleep(PATIENCE);
        };
        thread::sleep(due.saturating_duration_since(Instant::now()));
    }

    fn kicked(&self, number: usize, kick: &KickOutcome, last: bool) {
        if self.number.load(Ordering::Relaxed) == number {
            self.with(|shown| shown.count(kick));
            if last {
                self.number.store(NONE, Ordering::Relaxed);
            }
        }
    }
}

impl Shown {
    /// Another match: its robot is at the pitch's origin and looks along x.
    fn begin(&mut self, moment: &Spectacle<'_>) {
        let body = &moment.sample.bodies[self.anchor];
        let in_world = Pose2 { xy: [body.pos[0], body.pos[1]], heading: Mat3(body.rot).yaw() };
        self.axes = Pose2::default().over(&in_world);
        (self.ball_quat, self.fastest) = (Quat::identity(), 0.0);
        // Words on the page are no reason to end an evaluation.
        let _ = self.page.say(format!("Match {}", moment.number + 1));
    }

    /// Shows a frame: when the next one is due, and whether a page has been open yet.
    fn see(&mut self, moment: &Spectacle<'_>, monitor: &Monitor) -> (Instant, bool) {
        if self.page.stop_asked() {
            monitor.stop();
        }
        let viewers = self.page.viewers();
        let now = Instant::now();
        if viewers > 0 && !self.watched {
            self.watched = true;
            self.pace.resume(now, 1.0);
        }
        self.ball_quat = self.ball_quat.integrate(Vec3(moment.ball_spin), self.dt_s);
        self.fastest = self.fastest.max(Vec3(moment.sample.ball_vel).norm());
        if viewers > 0 {
            self.pace.stepped(now, self.dt_s, 1.0);
        } else {
            self.pace.resume(now, 1.0);
        }
        self.page.show(self.frame(moment));
        (self.pace.due(), self.watched)
    }

    fn frame(&self, moment: &Spectacle<'_>) -> Frame {
        let sample = moment.sample;
        let base = &sample.bodies[0];
        let drawn = Drawn {
            axes: self.axes,
            sample,
            ball_quat: self.ball_quat,
            believed: moment.believed,
            library: &self.library,
            anchor: self.anchor,
        };
        let [x, y, _] = drawn.place(sample.goal_pos).map(|x| x as f32);
        let frame = drawn.frame();
        Frame {
            flags: Flags {
                fallen: fallen(base.pos[2], base.rot[2][2], self.nominal_height_m),
                late: self.pace.late(),
                kicking: !sample.motion_ended,
                ..frame.flags
            },
            step: sample.step,
            time_s: f64::from(sample.step) * self.dt_s,
            rate: [1.0, self.pace.kept()],
            goal: [x, y, (sample.heading + self.axes.heading) as f32],
            engine: u8::from(self.engine == "MuJoCo"),
            ..frame
        }
    }

    fn count(&mut self, kick: &KickOutcome) {
        let (outcome, miss_m) = Outcome::judged(kick.goal, kick.contact, kick.lateral_m);
        let shot = Shot {
            number: 0,
            outcome,
            speed_m_s: std::mem::take(&mut self.fastest),
            lateral_m: kick.lateral_m,
            miss_m,
            ball: kick.ball,
            rolling: kick.ball_velocity != [0.0; 2],
            clip: kick.motion_name.clone(),
            engine: self.engine,
            surface: "",
        };
        let _ = self.page.count(shot);
        if kick.fell {
            let _ = self.page.fell();
        }
    }
}
