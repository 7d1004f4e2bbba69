//! In which engine, and with which ball on which ground.

use paid_eval::engine::EngineChoice;
use paid_eval::panel::{PANEL, PanelBall};

use super::Game;
use crate::LiveError;
use crate::arena::Arena;

/// The ball and ground of a number; `None` for 0, the scene's own, and where there is none.
fn ball_of(number: u8) -> Option<&'static PanelBall> {
    PANEL.get(usize::from(number).checked_sub(1)?)
}

/// Name of the ball and ground of a number; empty for the scene's own.
pub(super) fn name(number: u8) -> &'static str {
    ball_of(number).map_or("", |ball| ball.name)
}

impl Game<'_> {
    /// `built-in` or `MuJoCo`.
    pub(super) fn engine_name(&self) -> &'static str {
        if self.engine == 1 { "MuJoCo" } else { "built-in" }
    }

    /// The scene continues in an engine with a ball and ground, from a standing robot. The panel's are MuJoCo's. A MuJoCo that is not here,
    /// or a number that is none, is said, not an error.
    pub(super) fn go_to(&mut self, engine: u8, surface: u8) -> Result<(), LiveError> {
        if (engine, surface) == (self.engine, self.board.surface) {
            return Ok(());
        }
        let (mut scene, mut setup) = (self.subject.scene.clone(), self.subject.setup.clone());
        match ball_of(surface) {
            Some(ball) => ball.apply(&mut scene, &mut setup.preset),
            None if surface == 0 => {}
            None => {
                let words =
                    format!("There are {} balls and grounds; there is no number {surface}.", PANEL.len());
                self.board.say(words);
                return Ok(());
            }
        }
        setup.engine =
            if engine == 1 { EngineChoice::Mujoco(Box::new(scene)) } else { EngineChoice::Builtin };
        match Arena::new(self.subject, setup) {
            Ok(arena) => {
                let (pose, ball) = (self.arena.anchor(), self.arena.ball());
                (self.arena, self.engine, self.board.surface) = (arena, engine, surface);
                self.playing = None;
                let ground = ball_of(surface)
                    .map_or(String::new(), |b| format!(" Ball and ground: {}, {}.", b.name, b.what));
                self.board.say(format!("{} simulates.{ground}", self.engine_name()));
                self.stand(&pose, [ball[0], ball[1]])
            }
            Err(error) => {
                self.board.say(format!("The engine was not changed: {error}"));
                Ok(())
            }
        }
    }
}
