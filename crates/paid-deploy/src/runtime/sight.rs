//! Where ball and goal are: pictures and odometry in, the shared tracker between, the policy's view out.

use std::collections::VecDeque;

use paid_lanes::{Mat3, Vec3};
use paid_perceive::{
    AfterStrike, BallTracker, Belief, Picture, Rolling, TrackerPreset, effective_time, predicted_displacement,
};
use paid_policy::{Pose, SceneView};
use paid_task::{RollingBall, roll_decay};

use super::body::Body;
use crate::message::{OdometryPose, Sighting};
use crate::player::{Player, about_z};

/// Poses are kept for so long `[us]`: pictures may be that late.
const KEPT_US: u64 = 400_000;
/// A picture that shows the ball farther from where it is believed to be shows another ball, or the same one after somebody has moved it `[m]`.
const SAME_M: f64 = 0.25;
/// The tracker stays so far behind the present `[s]`: pictures that are later are not used.
const HORIZON_S: f64 = 0.15;

/// The robot at one time.
#[derive(Clone, Copy, Debug)]
struct Past {
    at_us: u64,
    /// Heading of the inertial sensor `[rad]`.
    imu_heading: f64,
    /// Torso in odometry's frame.
    torso: Option<Pose<f64>>,
}

/// Ball, goal and odometry as the robot believes them.
#[derive(Clone, Debug)]
pub(crate) struct Sight {
    tracker: BallTracker<f64>,
    preset: TrackerPreset,
    decay: f64,
    radius: f64,
    past: VecDeque<Past>,
    odometry: Option<OdometryPose>,
    /// Velocity between the last two poses `[m/s]`.
    velocity: Vec3<f64>,
    /// Heading of odometry's frame less the inertial sensor's `[rad]`.
    turn: f64,
    pictures: Vec<Sighting>,
    /// Pictures in a row that showed the ball where it was believed to be.
    looks: u32,
    /// Center of the goal in odometry's frame `[m]`.
    pub goal: Option<[f64; 2]>,
    /// What is shown of the ball after the strike.
    pub after_strike: AfterStrike<f64>,
}

impl Sight {
    pub fn new(player: &Player) -> Self {
        Self {
            tracker: BallTracker::new(),
            preset: player.task.eyes.tracker.clone(),
            decay: roll_decay(&player.task.ball_params),
            radius: player.task.ball_params.radius_m,
            past: VecDeque::with_capacity(256),
            odometry: None,
            velocity: Vec3::zero(),
            turn: 0.0,
            pictures: Vec::with_capacity(64),
            looks: 0,
            goal: None,
            after_strike: AfterStrike::new(),
        }
    }

    /// Takes in a pose.
    pub fn odometry(&mut self, pose: OdometryPose) {
        let finite = pose.position.iter().chain(&pose.quaternion).all(|x| x.is_finite());
        if !finite || self.odometry.is_some_and(|old| pose.stamp_us <= old.stamp_us) {
            return;
        }
        if let Some(old) = self.odometry {
            let dt = (pose.stamp_us - old.stamp_us) as f64 * 1e-6;
            self.velocity = (Vec3(pose.position) - Vec3(old.position)).scale(1.0 / dt);
        }
        let rot = paid_lanes::Quat(pose.quaternion).normalize().to_mat();
        let imu = self.past.iter().min_by_key(|past| past.at_us.abs_diff(pose.stamp_us));
        if let Some(past) = imu {
            self.turn = rot.yaw() - past.imu_heading;
        }
        self.odometry = Some(pose);
    }

    /// Takes in a picture, to be fused at the next policy step.
    pub fn sighting(&mut self, sighting: Sighting) {
        let finite = sighting.ball.is_none_or(|ball| ball.iter().all(|x| x.is_finite()));
        if finite && sighting.deviation_m > 0.0 && self.pictures.len() < 64 {
            self.pictures.push(sighting);
        }
    }

    /// Age of the last pose `[s]`; infinite without one.
    pub fn odometry_age(&self, now_us: u64) -> f64 {
        self.odometry.map_or(f64::INFINITY, |pose| now_us.saturating_sub(pose.stamp_us) as f64 * 1e-6)
    }

    /// The pelvis in odometry's frame: place from odometry, roll and pitch from the inertial sensor.
    pub fn base(&self, now_us: u64, body: &Body) -> Option<Pose<f64>> {
        let pose = self.odometry?;
        let age = self.odometry_age(now_us).min(0.1);
        let rot: Mat3<f64> = about_z(self.turn).mul_mat(&body.base_rot);
        Some(Pose { pos: self.velocity.scale_add(age, Vec3(pose.position)), rot })
    }

    /// Remembers where the torso is now: pictures of now come later.
    pub fn remember(&mut self, now_us: u64, body: &Body, player: &Player) {
        let torso = self.base(now_us, body).map(|base| {
            let torso = player.anchor_in_base(&body.joint_pos);
            Pose { pos: base.point_in_world(torso.pos), rot: base.rot.mul_mat(&torso.rot) }
        });
        while self.past.front().is_some_and(|old| old.at_us + KEPT_US < now_us) {
            self.past.pop_front();
        }
        self.past.push_back(Past { at_us: now_us, imu_heading: body.base_rot.yaw(), torso });
    }

    /// The torso now, in odometry's frame.
    pub fn torso(&self) -> Option<Pose<f64>> {
        self.past.back().and_then(|past| past.torso)
    }

    /// A policy step of the tracker; `to_strike_s` is the time until the motion strikes `[s]`, infinite before a kick.
    pub fn advance(&mut self, now_us: u64, dt_s: f64, to_strike_s: f64) {
        let rolling = Rolling { decay: self.decay, to_strike_s };
        self.tracker.advance(dt_s, HORIZON_S, &rolling, &self.preset);
        self.pictures.sort_by_key(|picture| picture.captured_us);
        for picture in self.pictures.drain(..) {
            let then = self.past.iter().min_by_key(|past| past.at_us.abs_diff(picture.captured_us));
            let (Some(torso), Some(ball)) = (then.and_then(|past| past.torso), picture.ball) else {
                continue;
            };
            let [x, y, _] = torso.point_in_world(Vec3(ball)).0;
            let belief = self.tracker.belief(&rolling, &self.preset);
            let [bx, by] = belief.ball.position;
            let same = belief.known && (x - bx).hypot(y - by) < SAME_M;
            self.looks = if same { self.looks.saturating_add(1) } else { 0 };
            let picture = Picture {
                position: [x, y],
                variance: picture.deviation_m * picture.deviation_m,
                age_s: now_us.saturating_sub(picture.captured_us) as f64 * 1e-6,
                seen: true,
            };
            self.tracker.fuse(&picture, &rolling, &self.preset);
        }
    }

    /// Pictures in a row that showed the ball where it was believed to be.
    pub fn looks(&self) -> u32 {
        self.looks
    }

    /// What the tracker believes.
    pub fn belief(&self, to_strike_s: f64) -> Belief<f64> {
        self.tracker.belief(&Rolling { decay: self.decay, to_strike_s }, &self.preset)
    }

    /// The ball in the frame in which motions are chosen: origin below the torso, x along its heading.
    pub fn ball_ahead(&self, belief: &Belief<f64>) -> Option<RollingBall> {
        let torso = self.torso()?;
        let [x, y, _] = torso.pos.0;
        let (s, c) = torso.rot.yaw().sin_cos();
        let turned = |[x, y]: [f64; 2]| [c * x + s * y, c * y - s * x];
        let [bx, by] = belief.ball.position;
        let velocity = turned(belief.ball.velocity);
        Some(RollingBall { place: turned([bx - x, by - y]), velocity, decay: self.decay })
    }

    /// Bearing of the goal from the torso's heading `[rad]`.
    pub fn goal_bearing(&self) -> Option<f64> {
        let ([gx, gy], torso) = (self.goal?, self.torso()?);
        let angle = (gy - torso.pos.y()).atan2(gx - torso.pos.x()) - torso.rot.yaw();
        Some(angle.sin().atan2(angle.cos()))
    }

    /// Ball and goal as the policy sees them, in the base frame `[m]`. `to_strike_s` is the motion's, `of_ball_s` the tracker's: infinite
    /// once the next ball is awaited.
    pub fn scene(
        &mut self,
        base: &Pose<f64>,
        player: &Player,
        to_strike_s: f64,
        of_ball_s: f64,
    ) -> SceneView<f64> {
        let belief = self.belief(of_ball_s);
        let ([x, y], [vx, vy]) = (belief.ball.position, belief.ball.velocity);
        let ball = Vec3([x, y, self.radius]);
        let wait = effective_time(to_strike_s, self.decay);
        let at_strike = ball + predicted_displacement(Vec3([vx, vy, 0.0]), wait);
        let (mut ball, mut at_strike) = (ball, at_strike);
        if let Some(times) = player.task.ball.after_strike.times() {
            self.after_strike.advance(at_strike, to_strike_s, times);
            ball = self.after_strike.shown(ball, to_strike_s, times);
            at_strike = self.after_strike.shown(at_strike, to_strike_s, times);
        }
        let [gx, gy] = self.goal.unwrap_or_default();
        SceneView {
            ball: base.point_in_body(ball),
            ball_at_strike: base.point_in_body(at_strike),
            goal: base.point_in_body(Vec3([gx, gy, self.radius])),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PlayerSpec;

    fn player() -> Player {
        let policy =
            std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../policies/demo/stage2.safetensors");
        Player::load(&PlayerSpec { policy, motions: None, sets: Vec::new() }).expect("policy")
    }

    #[test]
    fn a_late_picture_counts_from_where_the_robot_was() {
        let player = player();
        let mut sight = Sight::new(&player);
        let mut body = Body::new(player.joints());
        let torso = player.anchor_in_base(&body.joint_pos);
        let ball = Vec3([2.0, 0.5, 0.11]);
        // The robot slides along x at 1 m/s and turns at 1 rad/s. The inertial sensor's heading is 0.3 rad beside odometry's.
        let at = |us: u64| Pose { pos: Vec3([us as f64 * 1e-6, 0.0, 0.76]), rot: about_z(us as f64 * 1e-6) };
        let mut pictures = Vec::new();
        for k in 0..300_u64 {
            let now_us = 2000 * k;
            let base = at(now_us);
            body.base_rot = about_z(-0.3).mul_mat(&base.rot);
            sight.remember(now_us, &body, &player);
            if k % 5 == 0 {
                let half = 0.5 * now_us as f64 * 1e-6;
                let quaternion = [half.cos(), 0.0, 0.0, half.sin()];
                sight.odometry(OdometryPose { stamp_us: now_us, position: base.pos.0, quaternion });
            }
            if k % 15 == 0 {
                let seen = torso.point_in_body(base.point_in_body(ball)).0;
                pictures.push(Sighting { captured_us: now_us, ball: Some(seen), deviation_m: 0.01 });
            }
            if pictures.first().is_some_and(|p| p.captured_us + 60_000 <= now_us) {
                sight.sighting(pictures.remove(0));
            }
            if k % 10 == 0 {
                sight.advance(now_us, 0.02, f64::INFINITY);
            }
        }
        let belief = sight.belief(f64::INFINITY);
        let [x, y] = belief.ball.position;
        assert!(belief.known && (x - 2.0).hypot(y - 0.5) < 0.01, "{x} {y}");
        // Without the times of capture it would be 6 cm and 0.06 rad off.
    }

    #[test]
    fn a_ball_that_was_put_elsewhere_must_be_looked_at_anew() {
        let player = player();
        let mut sight = Sight::new(&player);
        let body = Body::new(player.joints());
        let torso = player.anchor_in_base(&body.joint_pos);
        let mut looks = Vec::new();
        for k in 0..90_u64 {
            let now_us = 20_000 * (k + 1);
            let stamp_us = now_us;
            sight.odometry(OdometryPose {
                stamp_us,
                position: [0.0, 0.0, 0.76],
                quaternion: [1.0, 0.0, 0.0, 0.0],
            });
            sight.remember(now_us, &body, &player);
            // Somebody puts the ball a meter farther; later something else is taken for it once.
            let place = match k {
                0..40 => Vec3([1.0, 0.0, 0.11]),
                70 => Vec3([1.0, 0.9, 0.11]),
                _ => Vec3([2.0, 0.3, 0.11]),
            };
            let ball = torso.point_in_body(place - Vec3([0.0, 0.0, 0.76])).0;
            sight.sighting(Sighting { captured_us: now_us, ball: Some(ball), deviation_m: 0.01 });
            sight.advance(now_us, 0.02, f64::INFINITY);
            looks.push(sight.looks());
        }
        // The first picture makes it known, the next ones agree.
        assert_eq!((looks[0], looks[39]), (0, 39));
        // The tracker believes the third picture of the new place.
        assert_eq!(looks[40..44], [0, 0, 0, 1]);
        assert_eq!((looks[69], looks[70], looks[71]), (27, 0, 1));
        let [x, y] = sight.belief(f64::INFINITY).ball.position;
        assert!((x - 2.0).hypot(y - 0.3) < 0.01, "{x} {y}");
    }

    #[test]
    fn a_pose_that_is_no_number_or_older_is_not_taken() {
        let player = player();
        let mut sight = Sight::new(&player);
        let pose = |stamp_us, x| OdometryPose {
            stamp_us,
            position: [x, 0.0, 0.7],
            quaternion: [1.0, 0.0, 0.0, 0.0],
        };
        sight.odometry(pose(1000, 1.0));
        sight.odometry(pose(2000, f64::NAN));
        sight.odometry(pose(500, 9.0));
        let body = Body::new(player.joints());
        let base = sight.base(1000, &body).expect("a pose");
        assert_eq!(base.pos.0, [1.0, 0.0, 0.7]);
        assert!((sight.odometry_age(51_000) - 0.05).abs() < 1e-12);
    }
}
