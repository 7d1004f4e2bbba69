//! What the policy in training does on the page: kick, or follow.

use paid_eval::policy::NetworkDriver;
use paid_eval::subject::Subject;
use paid_train::TrainedPolicy;

use super::follow::Follow;
use super::time::Time;
use crate::board::Board;
use crate::game::Game;
use crate::wire::Frame;
use crate::{Command, LiveError};

/// What the policy does.
pub(super) enum Act<'a> {
    Kicks(Box<Game<'a>>),
    Follows(Box<Follow>),
}

impl<'a> Act<'a> {
    pub fn new(subject: &'a Subject) -> Result<Self, LiveError> {
        Ok(if subject.setup.preset.scene.ball {
            Self::Kicks(Box::new(Game::new(subject, true, None)?))
        } else {
            Self::Follows(Box::new(Follow::new(subject)?))
        })
    }

    pub fn step(&mut self) -> Result<(), LiveError> {
        match self {
            Self::Kicks(game) => game.step(),
            Self::Follows(follow) => follow.step(),
        }
    }

    pub fn command(&mut self, command: Command) -> Result<(), LiveError> {
        match self {
            Self::Kicks(game) => game.command(command),
            Self::Follows(follow) => follow.command(command),
        }
    }

    pub fn board(&self) -> &Board {
        match self {
            Self::Kicks(game) => &game.board,
            Self::Follows(follow) => &follow.board,
        }
    }

    /// The next policy acts.
    pub fn act_by(&mut self, policy: TrainedPolicy) -> Result<(), LiveError> {
        let driver = NetworkDriver::maker(policy.policy)()?;
        match self {
            Self::Kicks(game) => game.act_by(driver),
            Self::Follows(follow) => follow.arena.act_by(driver),
        }
        Ok(())
    }

    /// The scene as it is now.
    pub fn frame(&self, time: &Time, viewers: usize) -> Frame {
        let rate = [time.rate, if time.paused { 0.0 } else { time.pace.kept() }];
        let late = time.pace.late();
        match self {
            Self::Kicks(game) => game.frame(rate, time.paused, late, viewers),
            Self::Follows(follow) => follow.frame(rate, time.paused, late, viewers),
        }
    }
}
