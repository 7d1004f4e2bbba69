//! A page to watch: what is shown runs elsewhere, and the page can only stop it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use paid_eval::subject::Subject;
use paid_robot::RobotModel;
use paid_task::TaskPreset;

use crate::board::{Board, Shot};
use crate::scene::Scene;
use crate::{Frame, LiveError, ServeOptions, Server};

/// What is watched.
#[derive(Clone, Debug)]
pub struct Watched<'a> {
    /// Where the policy came from.
    pub policy: String,
    /// The robot.
    pub robot: &'a RobotModel,
    /// Number of the body that carries the camera.
    pub anchor: usize,
    /// Ball, goal and camera.
    pub task: &'a TaskPreset,
    /// Names of the clips.
    pub clips: Vec<String>,
    /// What moves it: an engine, or the robot itself.
    pub engine: &'static str,
    /// What the page's stop does, in a few words.
    pub stop: &'static str,
}

/// A page to watch.
///
/// ```no_run
/// use paid_live::{Frame, ServeOptions, WatchPage, Watched};
/// use paid_robot::RobotModel;
///
/// let robot = RobotModel::g1();
/// let task = paid_train::task_preset("stage2", &[])?;
/// let watched = Watched {
///     policy: "mine".into(),
///     robot: &robot,
///     anchor: 0,
///     task: &task,
///     clips: Vec::new(),
///     engine: "MuJoCo",
///     stop: "It ends",
/// };
/// let page = WatchPage::start(watched, String::new(), &ServeOptions::default())?;
/// println!("{}", page.url());
/// while !page.stop_asked() {
///     page.show(Frame::default());
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct WatchPage {
    server: Server,
    /// The page's stop was pressed.
    asked: Arc<AtomicBool>,
    board: Board,
}

impl WatchPage {
    /// Serves the page. `knowledge` states what the policy is given of ball and goal.
    ///
    /// # Errors
    /// If the address cannot be had, or the system gives no thread or no random numbers.
    pub fn start(watched: Watched<'_>, knowledge: String, options: &ServeOptions) -> Result<Self, LiveError> {
        Self::serve(&Scene::watched(watched, knowledge), options, None)
    }

    /// The same; the page's stop also sets `stop`, even while the program that sends the frames is busy.
    ///
    /// # Errors
    /// As [`WatchPage::start`].
    pub fn start_with_stop(
        watched: Watched<'_>,
        knowledge: String,
        options: &ServeOptions,
        stop: &Arc<AtomicBool>,
    ) -> Result<Self, LiveError> {
        Self::serve(&Scene::watched(watched, knowledge), options, Some(Arc::clone(stop)))
    }

    /// Serves the page for what a subject plays.
    pub(crate) fn of_subject(subject: &Subject, options: &ServeOptions) -> Result<Self, LiveError> {
        Self::serve(&Scene::looked_on(subject), options, None)
    }

    fn serve(
        scene: &Scene,
        options: &ServeOptions,
        stop: Option<Arc<AtomicBool>>,
    ) -> Result<Self, LiveError> {
        let scene = serde_json::to_string(scene)?;
        let asked = Arc::<AtomicBool>::default();
        let stops = [Some(Arc::clone(&asked)), stop].into_iter().flatten().collect();
        let server = Server::that_stops(options, scene, stops)?;
        let board = Board::default();
        server.tell(serde_json::to_string(&board)?);
        Ok(Self { server, asked, board })
    }

    /// What to open in a browser.
    pub fn url(&self) -> String {
        self.server.url()
    }

    /// Number of open pages.
    pub fn viewers(&self) -> usize {
        self.server.viewers()
    }

    /// Shows a frame. A slow page misses some of them; nothing waits for it.
    pub fn show(&self, frame: Frame) {
        let viewers = self.server.viewers().min(255) as u8;
        self.server.show(Frame { viewers, ..frame }.encode());
    }

    /// Lists a shot and counts it.
    ///
    /// # Errors
    /// If the score cannot be written as JSON.
    pub fn count(&mut self, shot: Shot) -> Result<(), LiveError> {
        self.board.count(shot);
        self.tell()
    }

    /// Counts a fall.
    ///
    /// # Errors
    /// As [`WatchPage::count`].
    pub fn fell(&mut self) -> Result<(), LiveError> {
        self.board.fell();
        self.tell()
    }

    /// Shows a message on all open pages.
    ///
    /// # Errors
    /// As [`WatchPage::count`].
    pub fn say(&mut self, words: impl Into<String>) -> Result<(), LiveError> {
        self.board.say(words);
        self.tell()
    }

    /// True once after the page's stop was pressed. Everything else that a page sends is ignored.
    pub fn stop_asked(&self) -> bool {
        self.asked.swap(false, Ordering::Relaxed)
    }

    fn tell(&self) -> Result<(), LiveError> {
        self.server.tell(serde_json::to_string(&self.board)?);
        Ok(())
    }
}
