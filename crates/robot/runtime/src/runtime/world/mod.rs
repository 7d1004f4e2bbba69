//! Where ball and goal are: the senses' reports in, the policy's view out.
//!
//! Onboard perception ([`crate::eyes`]) gives the torso's pose and its estimate of the ball. Virtual senses give the pelvis's pose and
//! single images, which the shared tracker fuses here.

mod ball;
mod place;
#[cfg(test)]
mod tests;

use paid_lanes::Vec3;
use paid_play::{BelievedScene, KickTimes, RollingBall, SceneMemory};
use paid_policy::{Pose, SceneView};
use paid_track::Belief;

use super::body::Body;
use crate::message::{BallDetection, EyesReport, OdometryPose, TorsoPose};
use crate::player::Player;
use ball::Ball;
use place::Place;

/// Ball, goal and odometry as the robot believes them.
#[derive(Clone, Debug)]
pub(crate) struct WorldBelief {
    place: Place,
    ball: Ball,
    /// Center of the goal in odometry's frame `[m]`.
    pub goal: Option<[f64; 2]>,
    /// What is remembered of what the policy was shown.
    memory: SceneMemory<f64>,
    /// True if the ball is shown where it will be.
    predicts: bool,
}

impl WorldBelief {
    pub fn new(player: &Player) -> Self {
        Self {
            place: Place::new(),
            ball: Ball::new(player),
            goal: None,
            memory: SceneMemory::new(player.play.ball.after_strike.times()),
            predicts: player.play.predicts(),
        }
    }

    /// Takes in a pose of the pelvis.
    pub fn odometry(&mut self, pose: OdometryPose) {
        self.place.odometry(pose);
    }

    /// Takes in a pose of the torso: the joints of its time give the pelvis's place. True if it is of a new frame.
    pub fn torso_pose(&mut self, now_us: u64, pose: &TorsoPose) -> bool {
        let new_frame = self.place.torso_pose(now_us, pose);
        if new_frame {
            // What was known in the old frame means nothing in the new one.
            self.goal = None;
            self.ball.forget_report();
            self.memory.reset_lane(0, [0.0; 3]);
        }
        new_frame
    }

    /// Takes in perception's estimate.
    pub fn report(&mut self, now_us: u64, report: &EyesReport) {
        self.ball.report(now_us, report, self.place.frame());
    }

    /// Takes the operator's goal: ahead of the torso and to its left `[m]`.
    pub fn goal_ahead(&mut self, [ahead, left]: [f64; 2]) {
        let Some(torso) = self.torso() else { return };
        let (s, c) = torso.rot.yaw().sin_cos();
        self.goal = Some([torso.pos.x() + c * ahead - s * left, torso.pos.y() + s * ahead + c * left]);
    }

    /// Takes in an image, to be fused at the next policy step.
    pub fn sighting(&mut self, sighting: BallDetection) {
        self.ball.sighting(sighting);
    }

    /// Age of the last pose `[s]`; infinite without one.
    pub fn odometry_age(&self, now_us: u64) -> f64 {
        self.place.odometry_age(now_us)
    }

    /// The pelvis in odometry's frame: place from odometry, roll and pitch from the inertial sensor.
    pub fn base(&self, now_us: u64, body: &Body) -> Option<Pose<f64>> {
        self.place.base(now_us, body)
    }

    /// Remembers where the torso is now: images of this instant arrive later.
    pub fn remember(&mut self, now_us: u64, body: &Body, player: &Player) {
        self.ball.now(now_us);
        self.place.remember(now_us, body, player);
    }

    /// The torso now, in odometry's frame.
    pub fn torso(&self) -> Option<Pose<f64>> {
        self.place.torso()
    }

    /// A policy step of the tracker; `to_strike_s` is the time until the motion strikes `[s]`, infinite before a kick.
    pub fn advance(&mut self, now_us: u64, dt_s: f64, to_strike_s: f64) {
        self.ball.advance(now_us, dt_s, to_strike_s, &self.place);
    }

    /// Images in a row that showed the ball at its estimate.
    pub fn looks(&self) -> u32 {
        self.ball.looks()
    }

    /// The estimate: of onboard perception, continued since its report, or of the tracker here.
    pub fn belief(&self, to_strike_s: f64) -> Belief<f64> {
        self.ball.belief(to_strike_s)
    }

    /// The ball in the frame in which motions are chosen: origin below the torso, x along its heading.
    pub fn ball_ahead(&self, belief: &Belief<f64>) -> Option<RollingBall> {
        let torso = self.torso()?;
        let [x, y, _] = torso.pos.0;
        let (s, c) = torso.rot.yaw().sin_cos();
        let turned = |[x, y]: [f64; 2]| [c * x + s * y, c * y - s * x];
        let [bx, by] = belief.ball.position;
        let velocity = turned(belief.ball.velocity);
        Some(RollingBall { place: turned([bx - x, by - y]), velocity, decay: self.ball.decay })
    }

    /// Bearing of the goal from the torso's heading `[rad]`.
    pub fn goal_bearing(&self) -> Option<f64> {
        let ([gx, gy], torso) = (self.goal?, self.torso()?);
        let angle = (gy - torso.pos.y()).atan2(gx - torso.pos.x()) - torso.rot.yaw();
        Some(angle.sin().atan2(angle.cos()))
    }

    /// A kick begins: the ball lies at its estimate.
    pub fn begin_kick(&mut self) {
        let ball = self.ball_center(&self.belief(f64::INFINITY));
        self.memory.reset_lane(0, ball.0);
    }

    fn ball_center(&self, belief: &Belief<f64>) -> Vec3<f64> {
        let [x, y] = belief.ball.position;
        Vec3([x, y, self.ball.height()])
    }

    /// Ball and goal as the policy sees them, in the base frame `[m]`; `of_ball_s` is the tracker's strike: infinite once the next ball
    /// is awaited.
    pub fn scene(&mut self, base: &Pose<f64>, times: KickTimes, of_ball_s: f64) -> SceneView<f64> {
        let belief = self.belief(of_ball_s);
        let [gx, gy] = self.goal.unwrap_or_default();
        let believed = BelievedScene {
            ball: self.ball_center(&belief),
            velocity: belief.ball.velocity,
            decay: self.ball.decay,
            goal: Vec3([gx, gy, self.ball.height()]),
        };
        let mut scene = believed.view(base, times.to_contact_s, self.predicts);
        self.memory.show(base, times.to_strike_s, &mut scene);
        scene
    }
}
