//! A set of motions: the robot shows one after the other, next to the figures of what the set covers.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use paid_lanes::Quat;
use paid_motion::Clip;
use paid_robot::{RobotModel, RobotSpec};
use paid_task::TaskPreset;

use crate::board::Board;
use crate::live::{Show, run};
use crate::scene::{Kicks, Scene};
use crate::server::Pictures;
use crate::wire::{Body, Flags, Frame};
use crate::{Command, LiveError, Pose2, ServeOptions, Server, Summary, Watched};

/// Length of a step `[s]`; clips keep their own rates.
const DT_S: f64 = 0.02;
/// Time from the end of a clip to the next one `[s]`.
const PAUSE_S: f64 = 0.6;

/// A set of motions and what it covers.
pub struct Motions {
    /// Where they came from, for the page's corner.
    pub name: String,
    /// The motions, one at least.
    pub clips: Vec<Clip>,
    /// Names of the drawings that show what they cover.
    pub pictures: [&'static str; 4],
    /// How much they cover, as a sentence.
    pub share: String,
    /// Which kick to record next, as a sentence.
    pub advice: String,
    /// A drawing as SVG, by its name.
    pub draw: Pictures,
    /// The robot.
    pub robot: RobotModel,
    /// Names of its parts.
    pub spec: RobotSpec,
}

/// Serves the page and shows the motions until `stop` is set: all in turn, or only `clip` again and again. `ready` receives the address first.
///
/// # Errors
/// If the address cannot be had.
pub fn play_motions(
    motions: &Motions,
    serve: &ServeOptions,
    clip: Option<u16>,
    stop: &AtomicBool,
    ready: impl FnOnce(&str),
) -> Result<Summary, LiveError> {
    let anchor = motions.robot.body_index(&motions.spec.anchor_body).unwrap_or(0);
    let shown = Watched {
        policy: motions.name.clone(),
        robot: &motions.robot,
        anchor,
        task: &TaskPreset::builtin("paper_stage1")?,
        clips: motions.clips.iter().map(|clip| clip.name.clone()).collect(),
        engine: "none",
        stop: "",
    };
    let kicks =
        Kicks { pictures: motions.pictures, share: motions.share.clone(), advice: motions.advice.clone() };
    let scene = serde_json::to_string(&Scene::of_kicks(shown, kicks))?;
    let served = Server::with_pictures(serve, scene, Arc::clone(&motions.draw))?;
    run(&mut Gallery::new(&motions.clips, anchor, clip), served, stop, ready)
}

/// The robot that shows them.
struct Gallery<'a> {
    clips: &'a [Clip],
    anchor: usize,
    board: Board,
    /// The clip that is repeated; `None`: each in its turn.
    chosen: Option<u16>,
    clip: usize,
    /// Time since the clip began `[s]`.
    time_s: f64,
    step: u32,
}

impl<'a> Gallery<'a> {
    fn new(clips: &'a [Clip], anchor: usize, clip: Option<u16>) -> Self {
        let board = Board::default();
        let chosen = clip.filter(|clip| usize::from(*clip) < clips.len());
        let mut gallery = Self { clips, anchor, board, chosen, clip: 0, time_s: 0.0, step: 0 };
        gallery.begin(chosen.map_or(0, usize::from));
        gallery
    }

    fn begin(&mut self, clip: usize) {
        (self.clip, self.time_s) = (clip, 0.0);
        self.board.say(self.clips[clip].name.clone());
    }

    /// The robot begins at the pitch's origin and looks along x.
    fn bodies(&self) -> Vec<Body> {
        let clip = &self.clips[self.clip];
        let frame = ((self.time_s * clip.fps).round() as usize).min(clip.frames - 1);
        let ([x, y, _], quat) = (clip.body_pos(0)[self.anchor], clip.body_quat(0)[self.anchor]);
        let first = Pose2 { xy: [x, y], heading: Quat(quat).to_mat().yaw() };
        let axes = Pose2::default().over(&first);
        let yaw: Quat<f64> = Quat::from_roll_pitch_yaw(0.0, 0.0, axes.heading);
        let body = |([x, y, z], quat): (&[f64; 3], &[f64; 4])| {
            let [x, y] = axes.point([*x, *y]);
            Body { pos: [x, y, *z], quat: yaw.mul(Quat(*quat)).0 }
        };
        clip.body_pos(frame).iter().zip(clip.body_quat(frame)).map(body).collect()
    }
}

impl Show for Gallery<'_> {
    fn dt_s(&self) -> f64 {
        DT_S
    }

    fn step(&mut self) -> Result<(), LiveError> {
        self.step = self.step.wrapping_add(1);
        self.time_s += DT_S;
        if self.time_s > self.clips[self.clip].duration_s() + PAUSE_S {
            let next = (self.clip + 1) % self.clips.len();
            self.begin(self.chosen.map_or(next, usize::from));
        }
        Ok(())
    }

    /// Another clip, the same again; what takes a ball or a body that can be pushed does nothing.
    fn command(&mut self, command: Command) -> Result<(), LiveError> {
        match command {
            Command::Clip(clip) => {
                self.chosen = clip.filter(|clip| usize::from(*clip) < self.clips.len());
                self.begin(self.chosen.map_or(self.clip, usize::from));
            }
            Command::Another => self.begin((self.clip + 1) % self.clips.len()),
            Command::Reset => self.begin(self.clip),
            _ => {}
        }
        Ok(())
    }

    fn frame(&self, rate: [f32; 2], paused: bool, late: bool, viewers: usize) -> Frame {
        Frame {
            flags: Flags { paused, late, auto: true, ..Flags::default() },
            step: self.step,
            time_s: f64::from(self.step) * DT_S,
            rate,
            goal: [5.0, 0.0, 0.0],
            viewers: viewers.min(255) as u8,
            clip: self.chosen,
            bodies: self.bodies(),
            ..Frame::default()
        }
    }

    fn board(&self) -> &Board {
        &self.board
    }
}
