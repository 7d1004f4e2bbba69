//! The server: the page over http, the scene over a WebSocket. It runs in a thread of its own and never waits for the simulation, nor
//! the simulation for it.

mod guard;
mod page;
mod picture;
mod plain;
mod viewer;

use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::{self, JoinHandle};

use axum::Router;
use axum::body::Bytes;
use axum::extract::ws::Utf8Bytes;
use axum::routing::{any, get};
use tokio::net::TcpListener as AsyncListener;
use tokio::sync::{oneshot, watch};

use crate::{Command, LiveError};
use plain::PlainListener;

/// The port that is tried first.
pub const USUAL_PORT: u16 = 4747;
/// Commands that wait for the simulation; more are dropped.
const WAITING: usize = 256;

/// Draws the plot of a name as SVG; `None`: there is none of that name.
pub type Pictures = Arc<dyn Fn(&str) -> Option<String> + Send + Sync>;

/// Where the page is served.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ServeOptions {
    /// Port; `None`: [`USUAL_PORT`], or a free one if that is taken. 0: a free one.
    pub port: Option<u16>,
    /// An address that other machines reach, which then takes a token. `None`: this machine alone.
    pub listen: Option<SocketAddr>,
}

/// What the server counts.
#[derive(Debug, Default)]
pub struct Counts {
    /// Open pages.
    pub viewers: AtomicUsize,
    /// Messages that were dropped: malformed, hostile, or too many.
    pub dropped: AtomicU64,
    /// Requests that were refused: another origin, a foreign host name, no token.
    pub refused: AtomicU64,
    /// Frames that slow viewers did not get.
    pub skipped: AtomicU64,
}

/// What the server's tasks share.
pub(crate) struct Shared {
    address: SocketAddr,
    /// Asked for where other machines reach the address.
    token: Option<String>,
    scene: watch::Receiver<Utf8Bytes>,
    curves: watch::Receiver<Utf8Bytes>,
    frames: watch::Receiver<Bytes>,
    board: watch::Receiver<Utf8Bytes>,
    commands: SyncSender<Command>,
    /// Set as soon as a page's stop comes in.
    stops: Vec<Arc<AtomicBool>>,
    counts: Arc<Counts>,
    pictures: Option<Pictures>,
}

/// A running server. Dropping it ends it.
pub struct Server {
    address: SocketAddr,
    token: Option<String>,
    scene: watch::Sender<Utf8Bytes>,
    curves: watch::Sender<Utf8Bytes>,
    frames: watch::Sender<Bytes>,
    board: watch::Sender<Utf8Bytes>,
    counts: Arc<Counts>,
    stop: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

/// The address of the options.
fn bind(options: &ServeOptions) -> Result<TcpListener, LiveError> {
    let home = |port| SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), port);
    let open = |address| TcpListener::bind(address).map_err(|reason| LiveError::Bind { address, reason });
    match (options.listen, options.port) {
        (Some(address), _) => open(address),
        (None, Some(port)) => open(home(port)),
        (None, None) => open(home(USUAL_PORT)).or_else(|_| open(home(0))),
    }
}

/// 128 random bits in hexadecimal digits.
fn token() -> Result<String, LiveError> {
    let mut bytes = [0; 16];
    getrandom::fill(&mut bytes).map_err(LiveError::Token)?;
    Ok(bytes.iter().map(|b| format!("{b:02x}")).collect())
}

impl Server {
    /// Serves the page and the scene (JSON; empty: there is none yet); the visitors' commands come out of the receiver, except for
    /// the stop, which concerns only pages that watch.
    ///
    /// # Errors
    /// If the address cannot be had, or the system gives no thread or no random numbers.
    pub fn start(options: &ServeOptions, scene: String) -> Result<(Self, Receiver<Command>), LiveError> {
        Self::open(options, scene, None, Vec::new())
    }

    /// The same, with plots that are drawn when a page requests them.
    pub(crate) fn with_pictures(
        options: &ServeOptions,
        scene: String,
        pictures: Pictures,
    ) -> Result<(Self, Receiver<Command>), LiveError> {
        Self::open(options, scene, Some(pictures), Vec::new())
    }

    /// A page's stop sets `stops` at once, in the server's thread; it waits in no queue. Whatever else visitors command is dropped.
    pub(crate) fn that_stops(
        options: &ServeOptions,
        scene: String,
        stops: Vec<Arc<AtomicBool>>,
    ) -> Result<Self, LiveError> {
        Self::open(options, scene, None, stops).map(|(server, _)| server)
    }

    fn open(
        options: &ServeOptions,
        scene: String,
        pictures: Option<Pictures>,
        stops: Vec<Arc<AtomicBool>>,
    ) -> Result<(Self, Receiver<Command>), LiveError> {
        let listener = bind(options)?;
        let address = listener.local_addr().map_err(LiveError::Server)?;
        listener.set_nonblocking(true).map_err(LiveError::Server)?;
        let token = if address.ip().is_loopback() { None } else { Some(token()?) };
        let (scene, see_scene) = watch::channel(Utf8Bytes::from(scene));
        let (curves, see_curves) = watch::channel(Utf8Bytes::from_static(""));
        let (frames, see_frames) = watch::channel(Bytes::new());
        let (board, see_board) = watch::channel(Utf8Bytes::from_static(""));
        let (commands, receiver) = sync_channel(WAITING);
        let counts = Arc::new(Counts::default());
        let shared = Arc::new(Shared {
            address,
            token: token.clone(),
            scene: see_scene,
            curves: see_curves,
            frames: see_frames,
            board: see_board,
            commands,
            stops,
            counts: Arc::clone(&counts),
            pictures,
        });
        let (stop, stopped) = oneshot::channel();
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_io()
            .enable_time()
            .build()
            .map_err(LiveError::Server)?;
        let work = move || {
            runtime.block_on(async {
                let routes = Router::new()
                    .route("/ws", any(viewer::connect))
                    .route("/kicks/{name}", get(picture::picture))
                    .fallback(get(page::file))
                    .with_state(shared);
                match AsyncListener::from_std(listener) {
                    Ok(listener) => tokio::select! {
                        _ = axum::serve(PlainListener(listener), routes) => {}
                        _ = stopped => {}
                    },
                    Err(error) => eprintln!("page: the server does not start: {error}"),
                }
            });
        };
        let thread = thread::Builder::new().name("page".to_owned()).spawn(work).map_err(LiveError::Server)?;
        let (stop, thread) = (Some(stop), Some(thread));
        Ok((Self { address, token, scene, curves, frames, board, counts, stop, thread }, receiver))
    }

    /// Where it listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// What to open in a browser: `http://127.0.0.1:4747/`, with the token where one is needed.
    pub fn url(&self) -> String {
        // After the number sign: a browser does not send it, so that it is in no log.
        let token = self.token.as_ref().map_or_else(String::new, |t| format!("#token={t}"));
        format!("http://{}/{token}", self.address)
    }

    /// What was counted so far.
    pub fn counts(&self) -> &Counts {
        &self.counts
    }

    /// Number of open pages.
    pub fn viewers(&self) -> usize {
        self.counts.viewers.load(Ordering::Relaxed)
    }

    /// Shows a frame; a viewer that is not through with its last one will get the newest.
    pub fn show(&self, frame: Vec<u8>) {
        self.frames.send_replace(frame.into());
    }

    /// Another scene (JSON).
    pub fn set_scene(&self, scene: String) {
        self.scene.send_replace(scene.into());
    }

    /// Shows the curves of a training (JSON).
    pub fn plot(&self, curves: String) {
        self.curves.send_replace(curves.into());
    }

    /// Shows the board (JSON).
    pub fn tell(&self, board: String) {
        self.board.send_replace(board.into());
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        // The receiver may have gone with a server that failed to start.
        if let Some(stop) = self.stop.take() {
            let _ = stop.send(());
        }
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
