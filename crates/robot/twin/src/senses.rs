//! The virtual robot's view of ball, goal and itself. Small traits, so that a rendered camera and a LiDAR can take their place.

use std::collections::VecDeque;

use paid_lanes::rng::Rng;
use paid_lanes::{Mat3, Vec3};
use paid_policy::Pose;
use paid_runtime::{BallDetection, OdometryPose, Packet, quaternion};
use paid_track::{Camera, EyesDraw, EyesPreset, OdometryDrift};

/// What is true, for senses that do not know it exactly.
#[derive(Clone, Copy, Debug)]
pub struct TrueState {
    /// Pelvis in the world.
    pub base: Pose<f64>,
    /// Its velocity `[m/s]`.
    pub base_vel: Vec3<f64>,
    /// Torso in the world.
    pub torso: Pose<f64>,
    /// Center of the ball `[m]`.
    pub ball: Vec3<f64>,
    /// Its velocity `[m/s]`.
    pub ball_vel: Vec3<f64>,
}

/// A source of images of the ball.
pub trait BallSource {
    /// The image that arrives at `now_us`, if one does; called every 2 ms.
    fn step(&mut self, now_us: u64, truth: &TrueState) -> Option<BallDetection>;
}

/// A source of poses.
pub trait PoseSource {
    /// The pose that arrives at `now_us`, if one does; called every 2 ms.
    fn step(&mut self, now_us: u64, truth: &TrueState) -> Option<OdometryPose>;
    /// Where it puts a point of the world (x, y) `[m]` that is measured from the robot.
    fn placed(&self, point: [f64; 2], truth: &TrueState) -> [f64; 2];
}

/// A detector with a camera's image, noise, drop-outs, false detections and latency, like training's simulated perception.
#[derive(Clone, Debug)]
pub struct NoisyDetector {
    preset: EyesPreset,
    camera: Camera,
    draw: EyesDraw,
    radius: f64,
    rng: Rng,
    next_us: f64,
    on_the_way: VecDeque<BallDetection>,
}

impl NoisyDetector {
    /// A detector whose constants are drawn from `preset`, for a ball of this radius `[m]`.
    pub fn new(preset: &EyesPreset, radius: f64, seed: u64) -> Self {
        let mut rng = Rng::new(seed, 0, 0x0B01);
        Self {
            camera: preset.camera.geometry(),
            draw: preset.draw(&mut rng),
            preset: preset.clone(),
            radius,
            rng,
            next_us: 0.0,
            on_the_way: VecDeque::new(),
        }
    }

    fn picture(&mut self, now_us: u64, truth: &TrueState) -> BallDetection {
        let TrueState { torso, ball, base, base_vel, ball_vel } = truth;
        let in_torso = torso.point_in_body(*ball);
        let range = (in_torso - self.camera.mount()).norm();
        let [near, far] = self.preset.range_m;
        let visible = self.camera.sees(in_torso) && near <= range && range <= far;
        let found = visible && self.rng.unit() >= self.draw.dropout;
        let noise = self.preset.noise();
        let deviation_m = noise.deviation((*ball_vel - *base_vel).norm(), (*ball - base.pos).norm());
        let mut seen = found.then(|| {
            let sigma = deviation_m * self.draw.noise_scale;
            in_torso.0.map(|x| x + sigma * self.rng.normal())
        });
        if self.rng.unit() < self.preset.false_share {
            // Something on the ground, anywhere in the image.
            let (left, up) = (self.rng.uniform(-1.0, 1.0), self.rng.uniform(-1.0, 1.0));
            let ray: Vec3<f64> = self.camera.ray(left, up);
            let eye = torso.point_in_world(self.camera.mount());
            let down = -torso.rot.mul_vec(ray).z();
            if down > 1e-3 {
                let depth = (eye.z() - self.radius) / down;
                let place: Vec3<f64> = self.camera.mount::<f64>() + ray.scale(depth);
                seen = (ray.norm() * depth <= far).then_some(place.0).or(seen);
            }
        }
        BallDetection { captured_us: now_us, ball: seen, deviation_m }
    }
}

impl BallSource for NoisyDetector {
    fn step(&mut self, now_us: u64, truth: &TrueState) -> Option<BallDetection> {
        if now_us as f64 >= self.next_us {
            self.next_us = now_us as f64 + 1e6 * self.draw.period_s - (now_us as f64 - self.next_us).min(2e3);
            let picture = self.picture(now_us, truth);
            self.on_the_way.push_back(picture);
        }
        let latency_us = (self.draw.latency_s * 1e6) as u64;
        let arrived = self.on_the_way.front().is_some_and(|p| p.captured_us + latency_us <= now_us);
        if arrived { self.on_the_way.pop_front() } else { None }
    }
}

/// Poses a hundred times a second that drift, as the simulated odometry of training.
///
/// Training's errors are those of an episode, a few seconds long. A match is minutes long, and its heading may be off by a quarter of a
/// turn in the end. Odometry sums up its own steps: a way that the robot goes under a wrong heading is turned with it, so that what stands
/// still in the world stands still relative to the robot.
#[derive(Clone, Debug)]
pub struct DriftingOdometry {
    preset: EyesPreset,
    odometry: OdometryDrift<f64>,
    rng: Rng,
    next_us: u64,
    /// Where the body truly was, and where its turned steps have led (x, y) `[m]`.
    way: Option<[[f64; 2]; 2]>,
}

impl DriftingOdometry {
    /// Time between two poses `[us]`.
    pub(crate) const PERIOD_US: u64 = 10_000;

    /// Odometry whose errors are drawn from `preset`.
    pub fn new(preset: &EyesPreset, seed: u64) -> Self {
        let mut rng = Rng::new(seed, 0, 0x0B02);
        let mut odometry = OdometryDrift::new();
        odometry.begin_lane(0, 0.0, &preset.odometry, &mut rng);
        Self { preset: preset.clone(), odometry, rng, next_us: 0, way: None }
    }

    /// Goes on to `place` (x, y) `[m]`; where the turned steps lead.
    fn walk(&mut self, place: [f64; 2]) -> [f64; 2] {
        let [from, led] = self.way.unwrap_or([place; 2]);
        let (s, c) = self.odometry.error(0)[2].sin_cos();
        let [dx, dy] = [0, 1].map(|k| place[k] - from[k]);
        let led = [led[0] + c * dx - s * dy, led[1] + s * dx + c * dy];
        self.way = Some([place, led]);
        led
    }

    /// A period later: where it believes the body to be that truly is at `pos` `[m]`, turned by `rot`.
    pub(crate) fn advance(&mut self, pos: Vec3<f64>, rot: &Mat3<f64>) -> (Vec3<f64>, Mat3<f64>) {
        let numbers = [(); 3].map(|()| self.rng.normal());
        self.odometry.advance(Self::PERIOD_US as f64 * 1e-6, numbers, &self.preset.odometry);
        let [x, y] = self.walk([pos.x(), pos.y()]);
        self.odometry.pose(Vec3([x, y, pos.z()]), rot)
    }
}

impl PoseSource for DriftingOdometry {
    fn step(&mut self, now_us: u64, truth: &TrueState) -> Option<OdometryPose> {
        if now_us < self.next_us {
            return None;
        }
        self.next_us = now_us + Self::PERIOD_US;
        let (pos, rot) = self.advance(truth.base.pos, &truth.base.rot);
        Some(OdometryPose { stamp_us: now_us, position: pos.0, quaternion: quaternion(&rot) })
    }

    fn placed(&self, point: [f64; 2], truth: &TrueState) -> [f64; 2] {
        let [x, y, _] = truth.base.pos.0;
        let [_, led] = self.way.unwrap_or([[x, y]; 2]);
        self.odometry.placed([led[0] + point[0] - x, led[1] + point[1] - y], led)
    }
}

/// Detector and odometry.
pub struct Senses {
    ball: Box<dyn BallSource>,
    pose: Box<dyn PoseSource>,
    /// False: odometry is silent.
    pub odometry: bool,
    /// False: images come without a ball.
    pub ball_visible: bool,
}

impl Senses {
    /// Senses as in training, with errors drawn from `preset`.
    pub fn simulated(preset: &EyesPreset, ball_radius_m: f64, seed: u64) -> Self {
        let ball = Box::new(NoisyDetector::new(preset, ball_radius_m, seed));
        Self::new(ball, Box::new(DriftingOdometry::new(preset, seed)))
    }

    /// Any senses.
    pub fn new(ball: Box<dyn BallSource>, pose: Box<dyn PoseSource>) -> Self {
        Self { ball, pose, odometry: true, ball_visible: true }
    }

    /// What arrives at `now_us`.
    pub fn step(&mut self, now_us: u64, truth: &TrueState, mut send: impl FnMut(Packet)) {
        if let Some(pose) = self.pose.step(now_us, truth).filter(|_| self.odometry) {
            send(Packet::Odometry(pose));
        }
        if let Some(mut sighting) = self.ball.step(now_us, truth) {
            sighting.ball = sighting.ball.filter(|_| self.ball_visible);
            send(Packet::Detection(sighting));
        }
    }

    /// Where odometry puts a point of the world (x, y) `[m]`.
    pub fn placed(&self, point: [f64; 2], truth: &TrueState) -> [f64; 2] {
        self.pose.placed(point, truth)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use paid_track::OdometryPreset;

    /// A robot at `(x, 0)` that looks along x.
    fn truth(x: f64) -> TrueState {
        let base = Pose { pos: Vec3([x, 0.0, 0.75]), ..Pose::identity() };
        TrueState {
            base,
            base_vel: Vec3::zero(),
            torso: base,
            ball: Vec3([2.0, 0.0, 0.11]),
            ball_vel: Vec3::zero(),
        }
    }

    #[test]
    fn what_stands_still_stays_where_odometry_has_put_it_however_far_the_heading_has_drifted() {
        let odometry = OdometryPreset {
            offset_m: [0.0; 2],
            drift_m_s: [0.0; 2],
            heading_drift_deg_s: [1.0; 2],
            jitter_m: 0.0,
            jitter_deg: 0.0,
        };
        let mut source = DriftingOdometry::new(&EyesPreset { odometry, ..EyesPreset::default() }, 3);
        // A minute on the spot: the heading is off by 60 degrees.
        let mut last = None;
        for k in 0..6_000 {
            last = source.step(10_000 * k, &truth(0.0)).or(last);
        }
        let heading = |pose: OdometryPose| 2.0 * pose.quaternion[3].atan2(pose.quaternion[0]);
        let before = last.expect("a pose");
        assert!((heading(before).abs() - 60_f64.to_radians()).abs() < 1e-9, "{before:?}");
        let ball = source.placed([2.0, 0.0], &truth(0.0));
        // A meter toward the ball in a second, in which another degree comes.
        for k in 0..=100 {
            let now_us = 60_000_000 + 10_000 * k;
            last = source.step(now_us, &truth(0.01 * k as f64)).or(last);
        }
        let again = source.placed([2.0, 0.0], &truth(1.0));
        let moved = (again[0] - ball[0]).hypot(again[1] - ball[1]);
        // Half a degree of a meter on the way, and a degree of the last one; without the turned steps it would be a whole meter.
        assert!(moved < 0.03, "{ball:?} {again:?}");
        let after = last.expect("a pose");
        let gone = [0, 1].map(|k| after.position[k] - before.position[k]);
        let along = heading(before);
        assert!((gone[0] - along.cos()).hypot(gone[1] - along.sin()) < 0.02, "{gone:?}");
    }
}
