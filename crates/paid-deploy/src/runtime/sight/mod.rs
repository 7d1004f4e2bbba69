//! Where ball and goal are: what the senses say in, the policy's view out.
//!
//! The robot's own eyes ([`crate::eyes`]) give the torso's pose and what they believe of the ball. Virtual senses give the pelvis's pose and
//! single pictures, which the shared tracker fuses here.

use paid_lanes::{Mat3, Quat, Vec3};
use paid_perceive::{
    AfterStrike, BallTracker, Belief, Estimate, Picture, PoseBuffer, PoseGap, Rolling, StampedPose,
    TrackerPreset, effective_time, predicted_displacement,
};
use paid_policy::{Pose, SceneView};
use paid_task::{RollingBall, roll_decay};

use super::body::Body;
use crate::message::{EyesReport, OdometryPose, Sighting, TorsoPose};
use crate::player::{Player, about_z};
use crate::sim::quaternion;

/// Poses are kept for so long `[s]`: pictures may be that late.
const KEPT_S: f64 = 0.4;
/// Poses of that time, and a few.
const ROOM: usize = 256;
/// No runtime runs so long `[s]`.
const NEVER_S: f64 = 1e9;
/// A picture that shows the ball farther from where it is believed to be shows another ball, or the same one after somebody has moved it `[m]`.
const SAME_M: f64 = 0.25;
/// The tracker stays so far behind the present `[s]`: pictures that are later are not used.
const HORIZON_S: f64 = 0.15;

/// A pose of odometry, as the runtime uses it.
#[derive(Clone, Copy, Debug)]
struct Placed {
    stamp_us: u64,
    /// Origin of the pelvis `[m]`.
    position: Vec3<f64>,
}

/// Ball, goal and odometry as the robot believes them.
#[derive(Clone, Debug)]
pub(crate) struct Sight {
    tracker: BallTracker<f64>,
    preset: TrackerPreset,
    decay: f64,
    radius: f64,
    /// The pelvis in the inertial sensor's world, whose origin goes with it.
    pelvis: PoseBuffer,
    /// The torso in the same world.
    carried: PoseBuffer,
    /// The torso in odometry's frame.
    torsos: PoseBuffer,
    torso: Option<Pose<f64>>,
    now_us: u64,
    odometry: Option<Placed>,
    /// Number of the eyes' odometry frame.
    frame: Option<u32>,
    /// Height of the floor in odometry's frame `[m]`: 0 for virtual senses, whose frame begins on it.
    floor: f64,
    /// What the eyes believe, and when it held `[us]`.
    report: Option<(u64, EyesReport)>,
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
            pelvis: buffer(),
            carried: buffer(),
            torsos: buffer(),
            torso: None,
            now_us: 0,
            odometry: None,
            frame: None,
            floor: 0.0,
            report: None,
            velocity: Vec3::zero(),
            turn: 0.0,
            pictures: Vec::with_capacity(64),
            looks: 0,
            goal: None,
            after_strike: AfterStrike::new(),
        }
    }

    /// Takes in a pose of the pelvis.
    pub fn odometry(&mut self, pose: OdometryPose) {
        let finite = pose.position.iter().chain(&pose.quaternion).all(|x| x.is_finite());
        if !finite || self.odometry.is_some_and(|old| pose.stamp_us <= old.stamp_us) {
            return;
        }
        let rot = Quat(pose.quaternion).normalize().to_mat();
        if let Some(pelvis) = nearest(&self.pelvis, pose.stamp_us) {
            self.turn = rot.yaw() - pelvis.rot.yaw();
        }
        self.place(Placed { stamp_us: pose.stamp_us, position: Vec3(pose.position) });
    }

    /// Takes in a pose of the torso: the joints of its time say where the pelvis was.
    pub fn torso_pose(&mut self, now_us: u64, pose: &TorsoPose) {
        let finite = pose.position.iter().chain(&pose.quaternion).all(|x| x.is_finite());
        let stamp_us = now_us.saturating_sub(pose.age_us);
        if !finite || self.odometry.is_some_and(|old| stamp_us <= old.stamp_us) {
            return;
        }
        let Some(carried) = nearest(&self.carried, stamp_us) else { return };
        if self.frame.replace(pose.frame).is_some_and(|old| old != pose.frame) {
            // What was known in the old frame means nothing in the new one.
            (self.goal, self.report, self.odometry) = (None, None, None);
            self.velocity = Vec3::zero();
        }
        let rot = Quat(pose.quaternion).normalize().to_mat();
        self.turn = rot.yaw() - carried.rot.yaw();
        let position = Vec3(pose.position) - about_z(self.turn).mul_vec(carried.pos);
        self.place(Placed { stamp_us, position });
    }

    fn place(&mut self, placed: Placed) {
        if let Some(old) = self.odometry {
            let dt = (placed.stamp_us - old.stamp_us) as f64 * 1e-6;
            self.velocity = (placed.position - old.position).scale(1.0 / dt);
        }
        self.odometry = Some(placed);
    }

    /// Takes in what the eyes believe.
    pub fn report(&mut self, now_us: u64, report: &EyesReport) {
        let finite = report.ball.is_none_or(|ball| {
            let numbers = ball.position.iter().chain(&ball.velocity).chain(&ball.covariance);
            numbers.chain([&ball.rest, &ball.age_s]).all(|x| x.is_finite())
        });
        if finite && self.frame == Some(report.frame) {
            // Without the floor nobody knows how far below the robot the ball is.
            let floor = report.floor_m.filter(|floor| floor.is_finite());
            self.floor = floor.unwrap_or(self.floor);
            let report = &EyesReport { ball: report.ball.filter(|_| floor.is_some()), ..*report };
            self.report = Some((now_us.saturating_sub(report.age_us), *report));
        }
    }

    /// Takes the operator's word for the goal: ahead of the torso and to its left `[m]`.
    pub fn goal_ahead(&mut self, [ahead, left]: [f64; 2]) {
        let Some(torso) = self.torso else { return };
        let (s, c) = torso.rot.yaw().sin_cos();
        self.goal = Some([torso.pos.x() + c * ahead - s * left, torso.pos.y() + s * ahead + c * left]);
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
        let placed = self.odometry?;
        let age = self.odometry_age(now_us).min(0.1);
        let rot: Mat3<f64> = about_z(self.turn).mul_mat(&body.base_rot);
        Some(Pose { pos: self.velocity.scale_add(age, placed.position), rot })
    }

    /// Remembers where the torso is now: pictures of now come later.
    pub fn remember(&mut self, now_us: u64, body: &Body, player: &Player) {
        self.now_us = now_us;
        let torso = player.anchor_in_base(&body.joint_pos);
        let stamped = |pos: Vec3<f64>, rot: &Mat3<f64>| StampedPose {
            time_s: now_us as f64 * 1e-6,
            quat: Quat(quaternion(rot)),
            pos,
        };
        self.pelvis.push(stamped(Vec3::zero(), &body.base_rot));
        let carried = body.base_rot.mul_mat(&torso.rot);
        self.carried.push(stamped(body.base_rot.mul_vec(torso.pos), &carried));
        self.torso = self
            .base(now_us, body)
            .map(|base| Pose { pos: base.point_in_world(torso.pos), rot: base.rot.mul_mat(&torso.rot) });
        if let Some(torso) = &self.torso {
            self.torsos.push(stamped(torso.pos, &torso.rot));
        }
    }

    /// The torso now, in odometry's frame.
    pub fn torso(&self) -> Option<Pose<f64>> {
        self.torso
    }

    /// A policy step of the tracker; `to_strike_s` is the time until the motion strikes `[s]`, infinite before a kick.
    pub fn advance(&mut self, now_us: u64, dt_s: f64, to_strike_s: f64) {
        let rolling = Rolling { decay: self.decay, to_strike_s };
        self.tracker.advance(dt_s, HORIZON_S, &rolling, &self.preset);
        self.pictures.sort_by_key(|picture| picture.captured_us);
        for picture in self.pictures.drain(..) {
            let (Some(torso), Some(ball)) = (nearest(&self.torsos, picture.captured_us), picture.ball) else {
                continue;
            };
            let [x, y, _] = torso.point(ball);
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
        self.report.map_or(self.looks, |(_, report)| report.ball.map_or(0, |ball| ball.looks))
    }

    /// What is believed: by the eyes, as it goes on since they said so, or by the tracker here.
    pub fn belief(&self, to_strike_s: f64) -> Belief<f64> {
        let ball = self.report.and_then(|(at_us, report)| report.ball.map(|ball| (at_us, ball)));
        let Some((at_us, ball)) = ball else {
            return self.tracker.belief(&Rolling { decay: self.decay, to_strike_s }, &self.preset);
        };
        let since_s = self.now_us.saturating_sub(at_us) as f64 * 1e-6;
        let way = effective_time(since_s, self.decay);
        let kept = 1.0 - self.decay * way;
        Belief {
            ball: Estimate {
                position: [0, 1].map(|k| ball.position[k] + way * ball.velocity[k]),
                velocity: ball.velocity.map(|v| kept * v),
                covariance: ball.covariance,
            },
            rest: ball.rest,
            age_s: ball.age_s + since_s,
            known: !ball.lost,
        }
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
        let ball = Vec3([x, y, self.floor + self.radius]);
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
            goal: base.point_in_body(Vec3([gx, gy, self.floor + self.radius])),
        }
    }
}

/// A buffer that has its room from the begin, since the thread that fills it must not allocate. The poses that took the room are of a time
/// that never comes: the first real one is older by more than is kept, and they are forgotten.
fn buffer() -> PoseBuffer {
    let mut buffer = PoseBuffer::new(KEPT_S, 0.0);
    for k in 0..ROOM {
        let time_s = NEVER_S + KEPT_S * k as f64 / ROOM as f64;
        buffer.push(StampedPose { time_s, quat: Quat::identity(), pos: Vec3::zero() });
    }
    buffer
}

/// A pose at a time; the newest one for a time after it.
fn nearest(poses: &PoseBuffer, at_us: u64) -> Option<paid_perceive::Pose> {
    match poses.at(at_us as f64 * 1e-6) {
        Ok(pose) => Some(pose),
        Err(PoseGap::TooNew) => poses.last().map(StampedPose::pose),
        Err(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PlayerSpec;
    use crate::message::KnownBall;

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

    #[test]
    fn what_the_eyes_say_counts_from_the_joints_and_the_time_at_which_it_held() {
        let player = player();
        let mut sight = Sight::new(&player);
        let mut body = Body::new(player.joints());
        // The waist turns at 2 rad/s while the pelvis stands at (1, 0, 0.76), its inertial sensor's heading 0.3 rad beside odometry's.
        let yaw = player.model.joint_index("waist_yaw_joint").expect("a waist");
        body.base_rot = about_z(-0.3);
        let base = Pose { pos: Vec3([1.0, 0.0, 0.76]), rot: about_z(0.0) };
        let mut torsos = Vec::new();
        for k in 0..60_u64 {
            let now_us = 2000 * (k + 1);
            body.joint_pos[yaw] = 2.0 * now_us as f64 * 1e-6;
            let torso = player.anchor_in_base(&body.joint_pos);
            torsos.push((base.point_in_world(torso.pos), base.rot.mul_mat(&torso.rot)));
            sight.remember(now_us, &body, &player);
            // A pose that is 20 ms old when it comes.
            if k >= 10 {
                let (pos, rot) = torsos[k as usize - 10];
                let quaternion = quaternion(&rot);
                sight
                    .torso_pose(now_us, &TorsoPose { age_us: 20_000, frame: 0, position: pos.0, quaternion });
            }
        }
        let found = sight.base(120_000, &body).expect("a pose");
        assert!((found.pos - base.pos).norm() < 1e-9 && found.rot.yaw().abs() < 1e-9, "{found:?}");
        // A ball that rolls at 1 m/s and lay at x = 2 m 30 ms ago.
        let ball = KnownBall {
            position: [2.0, 0.5],
            velocity: [1.0, 0.0],
            covariance: [1e-4, 0.0, 1e-4],
            rest: 0.0,
            age_s: 0.07,
            looks: 33,
            id: 4,
            lost: false,
        };
        let report = EyesReport {
            age_us: 30_000,
            picture_age_us: Some(0),
            frame: 0,
            floor_m: Some(-1.2),
            ball: Some(ball),
        };
        sight.report(120_000, &report);
        let (belief, way) = (sight.belief(f64::INFINITY), effective_time(0.03, sight.decay));
        assert!(belief.known && (belief.ball.position[0] - 2.0 - way).abs() < 1e-12 && way > 0.025);
        assert!((belief.age_s - 0.1).abs() < 1e-12 && sight.looks() == 33);
        // The floor is 1.2 m below odometry's origin.
        let scene = sight.scene(&base, &player, f64::INFINITY, f64::INFINITY);
        assert!((scene.ball.z() + 1.2 - sight.radius + 0.76).abs() < 1e-9, "{scene:?}");
        sight.goal_ahead([5.0, 0.0]);
        assert!(sight.goal.is_some() && sight.goal_bearing().expect("a goal").abs() < 1e-9);
        // Odometry begins anew: ball and goal are gone, and a report of the old frame is not taken.
        body.joint_pos[yaw] = 0.0;
        sight.remember(122_000, &body, &player);
        let pose = TorsoPose { age_us: 0, frame: 1, position: [0.0; 3], quaternion: [1.0, 0.0, 0.0, 0.0] };
        sight.torso_pose(122_000, &pose);
        sight.report(122_000, &report);
        assert!(sight.goal.is_none() && !sight.belief(f64::INFINITY).known && sight.looks() == 0);
    }
}
