//! A page without a browser, and the scene that it looks at.

use std::net::{SocketAddr, TcpStream};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::channel;
use std::thread;
use std::time::Duration;

use paid_eval::subject::{Subject, SubjectSpec};
use paid_live::{Command, Frame, PlayOptions, ServeOptions, Summary, play};
use serde_json::Value;
use tungstenite::client::IntoClientRequest;
use tungstenite::{Error, HandshakeError, Message, WebSocket};

/// What comes from the server.
#[derive(Debug)]
pub enum News {
    Scene(Value),
    Board(Value),
    /// The curves of a training.
    Curves(Value),
    Frame(Frame),
    /// The close code.
    Closed(Option<u16>),
}

/// A viewer that reads when it wants to.
pub struct Page {
    pub socket: WebSocket<TcpStream>,
}

impl Page {
    /// Connects; the status of a refusal.
    pub fn open(address: SocketAddr, query: &str, origin: Option<&str>) -> Result<Self, u16> {
        let mut request = format!("ws://{address}/ws{query}").into_client_request().expect("an address");
        if let Some(origin) = origin {
            request.headers_mut().insert("Origin", origin.parse().expect("an origin"));
        }
        let stream = TcpStream::connect(address).expect("the server listens");
        stream.set_read_timeout(Some(Duration::from_secs(60))).expect("a socket");
        match tungstenite::client(request, stream) {
            Ok((socket, _)) => Ok(Self { socket }),
            Err(HandshakeError::Failure(Error::Http(response))) => Err(response.status().as_u16()),
            Err(error) => panic!("no handshake: {error}"),
        }
    }

    pub fn send(&mut self, command: Command) {
        self.raw(command.encode());
    }

    pub fn raw(&mut self, bytes: Vec<u8>) {
        self.socket.send(Message::Binary(bytes.into())).expect("sent");
    }

    pub fn next(&mut self) -> News {
        loop {
            match self.socket.read() {
                Ok(Message::Text(text)) => {
                    let value: Value = serde_json::from_str(text.as_str()).expect("JSON");
                    return match value["kind"].as_str() {
                        Some("board") => News::Board(value),
                        Some("training") => News::Curves(value),
                        _ => News::Scene(value),
                    };
                }
                Ok(Message::Binary(bytes)) => return News::Frame(Frame::decode(&bytes).expect("a frame")),
                Ok(Message::Close(frame)) => return News::Closed(frame.map(|f| f.code.into())),
                Ok(_) => {}
                Err(_) => return News::Closed(None),
            }
        }
    }

    /// The next frame that is `wanted`.
    pub fn frame(&mut self, wanted: impl Fn(&Frame) -> bool) -> Frame {
        loop {
            match self.next() {
                News::Frame(frame) if wanted(&frame) => return frame,
                News::Closed(code) => panic!("closed: {code:?}"),
                _ => {}
            }
        }
    }

    /// The next board that is `wanted`.
    pub fn board(&mut self, wanted: impl Fn(&Value) -> bool) -> Value {
        loop {
            match self.next() {
                News::Board(board) if wanted(&board) => return board,
                News::Closed(code) => panic!("closed: {code:?}"),
                _ => {}
            }
        }
    }

    /// Time stands still; the frame then.
    pub fn pause(&mut self) -> Frame {
        self.send(Command::Pause(true));
        self.frame(|f| f.flags.paused)
    }

    /// One control step.
    pub fn step(&mut self, last: &Frame) -> Frame {
        self.send(Command::Step);
        self.frame(|f| f.step > last.step)
    }

    /// This many control steps.
    pub fn steps(&mut self, last: &Frame, count: usize) -> Frame {
        (0..count).fold(last.clone(), |frame, _| self.step(&frame))
    }
}

/// The demo's policy.
pub fn demo() -> SubjectSpec {
    let policy = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../policies/demo/policy.onnx");
    SubjectSpec { threads: 1, ..SubjectSpec::new(policy) }
}

/// The same, loaded.
pub fn subject() -> Subject {
    Subject::load(&demo()).expect("the demo's policy")
}

/// The address in a URL without a token.
pub fn address(url: &str) -> SocketAddr {
    url.trim_start_matches("http://").trim_end_matches('/').parse().expect("IP:PORT")
}

/// Plays while `visit` watches; returns the result.
pub fn played<T>(subject: &Subject, port: u16, visit: impl FnOnce(SocketAddr) -> T) -> (T, Summary) {
    let stop = AtomicBool::new(false);
    let (say, hear) = channel();
    let serve = ServeOptions { port: Some(port), listen: None };
    let options = PlayOptions { serve, auto: false, clip: None };
    thread::scope(|scope| {
        let playing = scope.spawn(|| {
            play(subject, &options, &stop, |url| {
                say.send(address(url)).expect("heard");
            })
        });
        let stop_at_end = StopAtEnd(&stop);
        let seen = visit(hear.recv().expect("the scene begins"));
        drop(stop_at_end);
        (seen, playing.join().expect("no panic").expect("the scene continues"))
    })
}

/// Also after a panic, so that the test ends.
struct StopAtEnd<'a>(&'a AtomicBool);

impl Drop for StopAtEnd<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}
