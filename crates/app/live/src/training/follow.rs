//! A robot that follows clips, one after the other, without a ball.

use paid_eval::metrics::shooting::fallen;
use paid_eval::subject::Subject;

use crate::arena::Arena;
use crate::board::Board;
use crate::wire::{Flags, Frame};
use crate::{Command, LiveError};

/// Time from the end of a clip, or from a fall, to the next clip `[s]`.
const PAUSE_S: f64 = 0.6;

pub(super) struct Follow {
    pub arena: Arena,
    pub board: Board,
    /// The clip that is repeated; `None`: each in its turn.
    clip: Option<u16>,
    motion: usize,
    down: bool,
    /// Control steps since the clip ended or the robot fell.
    over: u32,
    step: u32,
}

impl Follow {
    /// The robot starts with the first clip.
    pub fn new(subject: &Subject) -> Result<Self, LiveError> {
        let mut arena = Arena::new(subject, subject.setup.clone())?;
        arena.follow(0)?;
        let board = Board::default();
        Ok(Self { arena, board, clip: None, motion: 0, down: false, over: 0, step: 0 })
    }

    fn begin(&mut self, motion: usize) -> Result<(), LiveError> {
        (self.motion, self.down, self.over) = (motion, false, 0);
        self.arena.follow(motion)
    }

    /// A push, another clip, the same again; what takes a ball does nothing.
    pub fn command(&mut self, command: Command) -> Result<(), LiveError> {
        let clips = self.arena.setup().library.len();
        match command {
            Command::Push(impulse) => self.arena.push(impulse),
            Command::Clip(clip) => {
                self.clip = clip.filter(|clip| usize::from(*clip) < clips);
                self.begin(self.clip.map_or(self.motion, usize::from))
            }
            Command::Another => self.begin((self.motion + 1) % clips),
            Command::Reset => self.begin(self.motion),
            _ => Ok(()),
        }
    }

    pub fn step(&mut self) -> Result<(), LiveError> {
        self.step = self.step.wrapping_add(1);
        self.arena.step()?;
        let (sample, setup) = (self.arena.sample(), self.arena.setup());
        let base = &sample.bodies[0];
        if fallen(base.pos[2], base.rot[2][2], setup.spec.nominal_height_m) && !self.down {
            self.down = true;
            self.board.fell();
        }
        self.over += u32::from(self.down || self.arena.sample().motion_ended);
        if f64::from(self.over) * self.arena.setup().preset.control_dt_s() > PAUSE_S {
            let next = (self.motion + 1) % self.arena.setup().library.len();
            return self.begin(self.clip.map_or(next, usize::from));
        }
        Ok(())
    }

    /// The scene as it is now. `rate` is asked for and kept. There is no ball; the goal only gives the view its direction.
    pub fn frame(&self, rate: [f32; 2], paused: bool, late: bool, viewers: usize) -> Frame {
        Frame {
            flags: Flags { paused, late, auto: true, fresh: true, fallen: self.down, ..Flags::default() },
            step: self.step,
            time_s: f64::from(self.step) * self.arena.setup().preset.control_dt_s(),
            rate,
            goal: [5.0, 0.0, 0.0],
            viewers: viewers.min(255) as u8,
            clip: self.clip,
            cost_ms: self.arena.cost.as_secs_f32() * 1e3,
            ..self.arena.drawn().frame()
        }
    }
}
