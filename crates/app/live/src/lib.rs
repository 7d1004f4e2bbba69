//! The page where anyone can play with the kick.
//!
//! [`play`] serves one page on this machine and simulates one robot in real time, by 50 control steps a second. Visitors take the
//! ball, flick it, move the goal, push the robot; several people can watch. [`Server`] carries bytes and knows no robot, so that a
//! training shows its present policy on the same page ([`TrainingPage`]), a set of motions is shown with its figures ([`play_motions`]), and
//! what is played elsewhere can be watched ([`WatchPage`], [`MatchPage`]); [`Frame`] and [`Command`] are the bytes.
//!
//! ```
//! use paid_live::{Command, Frame, ServeOptions, Server, VERSION};
//!
//! // A page without a simulation: port 0 is any free one.
//! let (server, _commands) = Server::start(&ServeOptions { port: Some(0), listen: None }, "{}".to_owned())?;
//! assert!(server.url().starts_with("http://127.0.0.1:"));
//! server.show(Frame::default().encode());
//! assert_eq!(Command::decode(&[VERSION, 7]), Ok(Command::Step));
//! # Ok::<(), paid_live::LiveError>(())
//! ```

mod arena;
mod board;
mod drawn;
mod error;
mod game;
mod live;
mod match_page;
mod motions;
mod pace;
mod pose2;
mod scene;
mod server;
mod training;
mod watch;
mod wire;

pub use board::{Board, Cell, Outcome, Shot};
pub use error::LiveError;
pub use live::{PlayOptions, Summary, play};
pub use match_page::MatchPage;
pub use motions::{Motions, play_motions};
pub use pace::Pace;
pub use pose2::Pose2;
pub use server::{Counts, ServeOptions, Server, USUAL_PORT};
pub use training::{Seen, TrainingPage};
pub use watch::{WatchPage, Watched};
pub use wire::{Belief, Body, Command, CommandError, Flags, Force, Frame, LONGEST_COMMAND, VERSION};
