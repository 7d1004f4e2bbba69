//! The virtual robot's view of ball, goal and itself. Small traits, so that a rendered camera and a LiDAR can take their place.

use std::collections::VecDeque;

use paid_lanes::Vec3;
use paid_lanes::rng::Rng;
use paid_perceive::{Camera, EyesDraw, EyesPreset, Odometry};
use paid_policy::Pose;

use super::robot::quaternion;
use crate::message::{OdometryPose, Packet, Sighting};

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

/// A source of pictures of the ball.
pub trait BallSource {
    /// The picture that arrives at `now_us`, if one does; called every 2 ms.
    fn step(&mut self, now_us: u64, truth: &TrueState) -> Option<Sighting>;
}

/// A source of poses.
pub trait PoseSource {
    /// The pose that arrives at `now_us`, if one does; called every 2 ms.
    fn step(&mut self, now_us: u64, truth: &TrueState) -> Option<OdometryPose>;
    /// Where it puts a point of the world (x, y) `[m]` that is measured from the robot.
    fn placed(&self, point: [f64; 2], truth: &TrueState) -> [f64; 2];
}

/// A detector with a camera's picture, noise, drop-outs, false detections and latency, as the simulated eyes of training.
#[derive(Clone, Debug)]
pub struct NoisyDetector {
    preset: EyesPreset,
    camera: Camera,
    draw: EyesDraw,
    radius: f64,
    rng: Rng,
    next_us: f64,
    on_the_way: VecDeque<Sighting>,
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

    fn picture(&mut self, now_us: u64, truth: &TrueState) -> Sighting {
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
            // Something on the ground, anywhere in the picture.
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
        Sighting { captured_us: now_us, ball: seen, deviation_m }
    }
}

impl BallSource for NoisyDetector {
    fn step(&mut self, now_us: u64, truth: &TrueState) -> Option<Sighting> {
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
#[derive(Clone, Debug)]
pub struct DriftingOdometry {
    preset: EyesPreset,
    odometry: Odometry<f64>,
    rng: Rng,
    next_us: u64,
}

impl DriftingOdometry {
    const PERIOD_US: u64 = 10_000;

    /// Odometry whose errors are drawn from `preset`.
    pub fn new(preset: &EyesPreset, seed: u64) -> Self {
        let mut rng = Rng::new(seed, 0, 0x0B02);
        let mut odometry = Odometry::new();
        odometry.begin_lane(0, 0.0, &preset.odometry, &mut rng);
        Self { preset: preset.clone(), odometry, rng, next_us: 0 }
    }
}

impl PoseSource for DriftingOdometry {
    fn step(&mut self, now_us: u64, truth: &TrueState) -> Option<OdometryPose> {
        if now_us < self.next_us {
            return None;
        }
        self.next_us = now_us + Self::PERIOD_US;
        let numbers = [(); 3].map(|()| self.rng.normal());
        self.odometry.advance(Self::PERIOD_US as f64 * 1e-6, numbers, &self.preset.odometry);
        let (pos, rot) = self.odometry.pose(truth.base.pos, &truth.base.rot);
        Some(OdometryPose { stamp_us: now_us, position: pos.0, quaternion: quaternion(&rot) })
    }

    fn placed(&self, point: [f64; 2], truth: &TrueState) -> [f64; 2] {
        self.odometry.placed(point, [truth.base.pos.x(), truth.base.pos.y()])
    }
}

/// Detector and odometry.
pub struct Senses {
    ball: Box<dyn BallSource>,
    pose: Box<dyn PoseSource>,
    /// False: odometry is silent.
    pub odometry: bool,
    /// False: pictures come without a ball.
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
            send(Packet::Sighting(sighting));
        }
    }

    /// Where odometry puts a point of the world (x, y) `[m]`.
    pub fn placed(&self, point: [f64; 2], truth: &TrueState) -> [f64; 2] {
        self.pose.placed(point, truth)
    }
}
