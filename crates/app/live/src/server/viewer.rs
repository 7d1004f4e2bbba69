//! One open page.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use axum::extract::State;
use axum::extract::ws::{CloseFrame, Message, Utf8Bytes, WebSocket, WebSocketUpgrade};
use axum::http::{HeaderMap, StatusCode, Uri};
use axum::response::{IntoResponse, Response};
use futures_util::stream::{SplitSink, SplitStream};
use futures_util::{SinkExt, StreamExt};
use tokio::sync::watch;

use super::guard::check;
use super::{Counts, Shared};
use crate::wire::CommandError;
use crate::{Command, VERSION};

/// Pages at once; more are sent away.
const MOST_VIEWERS: usize = 32;
/// Commands of a page per second; more are dropped. The page sends once per drawing; single steps may come faster.
const MOST_COMMANDS: f64 = 2000.0;
/// A longer message ends the connection `[bytes]`; one that is longer than any command is dropped.
const LONGEST_MESSAGE: usize = 1 << 14;
/// A page that receives nothing for this long is closed.
const STALLED: Duration = Duration::from_secs(20);
/// Close codes: another version of the messages; too many pages.
const CLOSE_VERSION: u16 = 4001;
const CLOSE_FULL: u16 = 4002;

/// Opens the WebSocket.
pub(super) async fn connect(
    State(shared): State<Arc<Shared>>,
    headers: HeaderMap,
    uri: Uri,
    upgrade: WebSocketUpgrade,
) -> Response {
    if let Err(refusal) = check(&headers, &uri, shared.address, shared.token.as_deref()) {
        shared.counts.refused.fetch_add(1, Ordering::Relaxed);
        return (StatusCode::FORBIDDEN, refusal.words()).into_response();
    }
    upgrade
        .max_message_size(LONGEST_MESSAGE)
        .max_frame_size(LONGEST_MESSAGE)
        .write_buffer_size(0)
        .max_write_buffer_size(1 << 20)
        .on_upgrade(move |socket| serve(socket, shared))
}

/// Counts a viewer for as long as it lives.
struct Present(Arc<Counts>);

impl Present {
    fn enter(counts: &Arc<Counts>) -> Option<Self> {
        let before = counts.viewers.fetch_add(1, Ordering::Relaxed);
        let present = Self(Arc::clone(counts));
        (before < MOST_VIEWERS).then_some(present)
    }
}

impl Drop for Present {
    fn drop(&mut self) {
        self.0.viewers.fetch_sub(1, Ordering::Relaxed);
    }
}

async fn serve(socket: WebSocket, shared: Arc<Shared>) {
    let (mut sink, stream) = socket.split();
    let reason = match Present::enter(&shared.counts) {
        None => Some((CLOSE_FULL, format!("{MOST_VIEWERS} pages are open already"))),
        Some(_present) => tokio::select! {
            () = write(&mut sink, &shared) => None,
            reason = read(stream, &shared) => reason,
        },
    };
    if let Some((code, reason)) = reason {
        let close = Message::Close(Some(CloseFrame { code, reason: reason.into() }));
        // The page may have gone.
        let _ = tokio::time::timeout(STALLED, sink.send(close)).await;
    }
}

/// The scene, the curves and the board whenever they change, and the newest frame whenever the page is through with the last one.
async fn write(sink: &mut SplitSink<WebSocket, Message>, shared: &Shared) {
    let mut texts = [&shared.scene, &shared.curves, &shared.board].map(Clone::clone);
    let mut frames = shared.frames.clone();
    texts.iter_mut().for_each(watch::Receiver::mark_changed);
    frames.mark_changed();
    let [scene, curves, board] = &mut texts;
    let mut last_step = None;
    loop {
        let next = loop {
            let message = tokio::select! {
                biased;
                text = newest(scene) => match text {
                    Some(text) => Message::Text(text),
                    None => return,
                },
                text = newest(curves) => match text {
                    Some(text) => Message::Text(text),
                    None => return,
                },
                text = newest(board) => match text {
                    Some(text) => Message::Text(text),
                    None => return,
                },
                changed = frames.changed() => match changed {
                    Ok(()) => {
                        let frame = frames.borrow_and_update().clone();
                        count_skipped(&mut last_step, &frame, &shared.counts);
                        Message::Binary(frame)
                    }
                    Err(_) => return,
                },
            };
            // Nothing has been shown yet.
            let empty = match &message {
                Message::Text(text) => text.as_str().is_empty(),
                Message::Binary(bytes) => bytes.is_empty(),
                Message::Ping(_) | Message::Pong(_) | Message::Close(_) => false,
            };
            if !empty {
                break message;
            }
        };
        match tokio::time::timeout(STALLED, sink.send(next)).await {
            Ok(Ok(())) => {}
            Ok(Err(_)) | Err(_) => return,
        }
    }
}

/// A text once it has changed; `None` if the server ends.
async fn newest(texts: &mut watch::Receiver<Utf8Bytes>) -> Option<Utf8Bytes> {
    texts.changed().await.ok()?;
    Some(texts.borrow_and_update().clone())
}

/// Counts the control steps between two frames of a viewer.
fn count_skipped(last: &mut Option<u32>, frame: &[u8], counts: &Counts) {
    let Some(word) = frame.get(4..8).and_then(|w| <[u8; 4]>::try_from(w).ok()) else { return };
    let step = u32::from_le_bytes(word);
    let between = last.map_or(0, |last| step.wrapping_sub(last).saturating_sub(1));
    *last = Some(step);
    // A new scene counts from the beginning.
    if between < u32::MAX / 2 {
        counts.skipped.fetch_add(u64::from(between), Ordering::Relaxed);
    }
}

/// Takes commands until the page goes, or speaks another version: the close code and the reason.
async fn read(mut stream: SplitStream<WebSocket>, shared: &Shared) -> Option<(u16, String)> {
    let mut budget = Budget { left: MOST_COMMANDS, since: Instant::now() };
    let drop_one = || {
        shared.counts.dropped.fetch_add(1, Ordering::Relaxed);
    };
    while let Some(message) = stream.next().await {
        let bytes = match message {
            Ok(Message::Binary(bytes)) => bytes,
            Ok(Message::Close(_)) => return None,
            Ok(Message::Ping(_) | Message::Pong(_)) => continue,
            Ok(Message::Text(_)) => {
                drop_one();
                continue;
            }
            // The page has gone, or what it sent is far too long or no message at all.
            Err(_) => return None,
        };
        match Command::decode(&bytes) {
            // Before the budget and outside the queue: neither a flood of commands nor a full queue may delay it.
            Ok(Command::Stop) => {
                for stop in &shared.stops {
                    stop.store(true, Ordering::Relaxed);
                }
            }
            Ok(command) if budget.take(Instant::now()) => {
                if shared.commands.try_send(command).is_err() {
                    drop_one();
                }
            }
            Ok(_) => drop_one(),
            Err(CommandError::Version(Some(found))) => {
                drop_one();
                return Some((CLOSE_VERSION, format!("version: expected {VERSION}, found {found}")));
            }
            Err(_) => drop_one(),
        }
    }
    None
}

/// This many commands per second, and as many at once.
struct Budget {
    left: f64,
    since: Instant,
}

impl Budget {
    fn take(&mut self, now: Instant) -> bool {
        let passed_s = now.saturating_duration_since(self.since).as_secs_f64();
        self.left = (self.left + MOST_COMMANDS * passed_s).min(MOST_COMMANDS);
        self.since = now;
        let enough = self.left >= 1.0;
        if enough {
            self.left -= 1.0;
        }
        enough
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flood_of_commands_is_thinned_to_2000_a_second() {
        let start = Instant::now();
        let mut budget = Budget { left: MOST_COMMANDS, since: start };
        let passed = |budget: &mut Budget, now| (0..10_000).filter(|_| budget.take(now)).count();
        assert_eq!(passed(&mut budget, start), 2000);
        assert_eq!(passed(&mut budget, start + Duration::from_millis(100)), 200);
        assert_eq!(passed(&mut budget, start + Duration::from_secs(100)), 2000);
    }

    #[test]
    fn the_steps_between_two_frames_are_skipped_ones() {
        let counts = Counts::default();
        let mut last = None;
        for step in [7_u32, 8, 12, 0, 1] {
            let frame = [vec![1, 1, 0, 0], step.to_le_bytes().to_vec()].concat();
            count_skipped(&mut last, &frame, &counts);
        }
        // Between 8 and 12 there are three; 0 is a new scene.
        assert_eq!(counts.skipped.load(Ordering::Relaxed), 3);
    }
}
