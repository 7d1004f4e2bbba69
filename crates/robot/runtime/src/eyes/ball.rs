//! The estimate of the ball.

use paid_vision::PictureFault;
use paid_world::{Arrived, Believed, JointMessage, Message, PictureMessage, Recorder, Sight, SightSetup};

use super::TorsoFix;
use crate::DeployError;
use crate::message::{BallReport, EyesReport};
use crate::player::Player;
use crate::runtime::Phase;

/// Images in, estimates out; poses and joints between.
#[derive(Debug)]
pub struct BallEyes {
    sight: Sight,
    frame: u32,
    /// When the last trusted image arrived, local clock `[ns]`.
    picture_ns: Option<u64>,
    /// Number of the ball to kick, and images that have shown it.
    own: Option<(u32, u32)>,
    /// See [`Phase::looks_anew`].
    looks_anew: u32,
    recorder: Option<Recorder>,
}

impl BallEyes {
    /// A setup for a player's ball and noise: the project's own detector, poses from outside.
    ///
    /// # Errors
    /// If the detector cannot be run.
    pub fn setup(player: &Player) -> Result<SightSetup, DeployError> {
        let base = SightSetup::g1().map_err(DeployError::eyes)?;
        Ok(SightSetup {
            torso: player.spec.anchor_body.clone(),
            radius_m: player.play.ball_params.radius_m,
            decay: player.play.ball_decay(),
            noise: player.play.eyes.noise(),
            tracker: player.play.eyes.tracker.clone(),
            ..base
        })
    }

    /// Eyes that have seen nothing.
    ///
    /// # Errors
    /// If a part of the setup makes no sense.
    pub fn new(setup: SightSetup) -> Result<Self, DeployError> {
        let sight = Sight::new(SightSetup { lidar: None, ..setup }).map_err(DeployError::eyes)?;
        Ok(Self { sight, frame: 0, picture_ns: None, own: None, looks_anew: 0, recorder: None })
    }

    /// The same eyes; what reaches them and what they believe is recorded from now on.
    pub fn recorded_by(self, recorder: Option<Recorder>) -> Self {
        Self { recorder, ..self }
    }

    /// Takes in where the torso was.
    ///
    /// # Errors
    /// None today: a pose that is none is passed over.
    pub fn torso(&mut self, fix: &TorsoFix) -> Result<(), DeployError> {
        if fix.frame != self.frame {
            self.frame = fix.frame;
            self.own = None;
            self.sight.forget();
        }
        self.take(fix.at_ns, Message::Pose(fix.pose)).map(drop)
    }

    /// A robot that has become ready, or may kick from now on, looks again: where the floor is, since it stands on it now, and for the next
    /// ball.
    fn follow(&mut self, phase: &Phase) -> f64 {
        if self.looks_anew != phase.looks_anew() {
            self.looks_anew = phase.looks_anew();
            self.own = None;
            self.sight.forget();
        }
        phase.to_strike_s()
    }

    /// Takes in joint angles of a time `[ns]`, model order `[rad]`: the robot's legs hide balls, and its feet are where the floor is.
    ///
    /// # Errors
    /// If there are more or fewer than the robot has.
    pub fn joints(&mut self, stamp_ns: u64, positions: Vec<f64>) -> Result<(), DeployError> {
        self.take(stamp_ns, Message::Joints(JointMessage { stamp_ns, positions })).map(drop)
    }

    /// Processes an image that arrived at `at_ns` `[ns]`; `phase` is the runtime's. Returns what is wrong with it, if anything.
    ///
    /// # Errors
    /// If the detector fails.
    pub fn picture(
        &mut self,
        picture: PictureMessage,
        at_ns: u64,
        phase: &Phase,
    ) -> Result<Option<PictureFault>, DeployError> {
        let to_strike_s = self.follow(phase);
        self.take(at_ns, Message::Picture(Box::new(picture)))?;
        let believed = self.step(at_ns, to_strike_s)?;
        let fault = believed.and_then(|believed| believed.picture);
        if fault.is_none_or(|fault| !fault.is_blind()) {
            self.picture_ns = Some(at_ns);
        }
        let seen = self.sight.take_sighted().iter().any(|sighted| sighted.own);
        let id = believed.and_then(|believed| believed.ball).map(|ball| ball.id);
        self.own = id.map(|id| {
            let before = self.own.filter(|(own, _)| *own == id).map_or(0, |(_, looks)| looks);
            (id, before.saturating_add(u32::from(seen)))
        });
        Ok(fault)
    }

    /// The estimate at `now_ns` `[ns]`.
    ///
    /// # Errors
    /// None today.
    pub fn report(&mut self, now_ns: u64, phase: &Phase) -> Result<EyesReport, DeployError> {
        let to_strike_s = self.follow(phase);
        let believed = self.step(now_ns, to_strike_s)?;
        let ball = believed.and_then(|believed| believed.ball).map(|ball| {
            let belief = ball.belief;
            BallReport {
                position: belief.ball.position,
                velocity: belief.ball.velocity,
                covariance: belief.ball.covariance,
                rest: belief.rest,
                age_s: belief.age_s,
                looks: self.own.filter(|(own, _)| *own == ball.id).map_or(0, |(_, looks)| looks),
                id: ball.id,
                lost: ball.state == paid_track::BallState::Lost,
            }
        });
        let picture_age_us = self.picture_ns.map(|at| now_ns.saturating_sub(at) / 1000);
        let floor_m = believed.and_then(|believed| believed.floor_m);
        Ok(EyesReport { age_us: 0, picture_age_us, frame: self.frame, floor_m, ball })
    }

    fn step(&mut self, now_ns: u64, to_strike_s: f64) -> Result<Option<Believed>, DeployError> {
        self.take(now_ns, Message::Step { to_strike_s })
    }

    fn take(&mut self, at_ns: u64, message: Message) -> Result<Option<Believed>, DeployError> {
        let arrived = Arrived { at_ns, message };
        let believed = self.sight.take(&arrived).map_err(DeployError::eyes)?;
        if let Some(recorder) = &mut self.recorder {
            recorder.message(&arrived).map_err(DeployError::eyes)?;
            if let Some(believed) = &believed {
                recorder.believed(believed).map_err(DeployError::eyes)?;
            }
        }
        Ok(believed)
    }
}
