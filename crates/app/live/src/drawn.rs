//! A state of the engine's world as the page draws it.

use paid_lanes::{Mat3, Quat, Vec3};
use paid_play::ReferenceLibrary;
use paid_task::{BelievedBall, BodySample, EnvSample};

use crate::Pose2;
use crate::pose2::turned;
use crate::wire::{Belief, Body, Flags, Force, Frame};

/// Contact forces below this are not shown `[N]`.
const LEAST_FORCE_N: f64 = 5.0;

/// A state of the world, and where it is on the pitch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Drawn<'a> {
    /// The world's axes on the pitch.
    pub axes: Pose2,
    /// The state, world axes.
    pub sample: &'a EnvSample,
    /// Orientation of the ball in the world.
    pub ball_quat: Quat<f64>,
    /// Where the robot believes the ball to be, world axes.
    pub believed: Option<BelievedBall>,
    /// What the state's motion is one of.
    pub library: &'a ReferenceLibrary,
    /// Model index of the body that anchors the reference.
    pub anchor: usize,
}

impl Drawn<'_> {
    /// Everything that the state says: bodies, ball, belief, reference, forces, rewards. The rest of the frame is empty.
    pub fn frame(&self) -> Frame {
        let sample = self.sample;
        Frame {
            flags: Flags {
                touched: sample.kick.is_some(),
                in_view: self.believed.is_some_and(|ball| ball.in_view),
                ..Flags::default()
            },
            ball: Body { pos: self.place(sample.ball_pos), quat: self.yaw().mul(self.ball_quat).0 },
            ball_speed: Vec3(sample.ball_vel).norm() as f32,
            bodies: sample.bodies.iter().map(|body| self.body(body)).collect(),
            ghost: self.ghost(),
            forces: self.forces(),
            rewards: sample.rewards.iter().map(|r| *r as f32).collect(),
            belief: self.believed.map(|ball| Belief {
                pos: self.place(ball.pos).map(|x| x as f32),
                deviation_m: ball.deviation_m as f32,
                age_s: ball.age_s as f32,
            }),
            ..Frame::default()
        }
    }

    /// A point of the world on the pitch `[m]`.
    pub fn place(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let [x, y] = self.axes.point([x, y]);
        [x, y, z]
    }

    fn vector(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let [x, y] = turned([x, y], self.axes.heading);
        [x, y, z]
    }

    fn yaw(&self) -> Quat<f64> {
        Quat::from_roll_pitch_yaw(0.0, 0.0, self.axes.heading)
    }

    fn body(&self, body: &BodySample) -> Body {
        Body { pos: self.place(body.pos), quat: self.yaw().mul(Mat3(body.rot).to_quat()).0 }
    }

    /// The reference, model order.
    fn ghost(&self) -> Vec<Body> {
        let (sample, clip) = (self.sample, &self.library.clips()[self.sample.motion]);
        let count = sample.bodies.len();
        let rows = sample.frame * count..(sample.frame + 1) * count;
        let (pos, quat) = (&clip.body_pos[rows.clone()], &clip.body_quat[rows]);
        let anchor_rot: Mat3<f64> = Quat(quat[self.anchor]).to_mat();
        let [x, y, _] = pos[self.anchor];
        let in_clip = Pose2 { xy: [x, y], heading: anchor_rot.yaw() };
        let (xy, heading) = sample.reference_anchor;
        let axes = self.axes.pose(&Pose2 { xy, heading }.over(&in_clip));
        let yaw: Quat<f64> = Quat::from_roll_pitch_yaw(0.0, 0.0, axes.heading);
        let body = |([x, y, z], q): ([f64; 3], [f64; 4])| {
            let [x, y] = axes.point([x, y]);
            Body { pos: [x, y, z], quat: yaw.mul(Quat(q)).0 }
        };
        pos.iter().copied().zip(quat.iter().copied()).map(body).collect()
    }

    /// Contact forces that can be seen.
    fn forces(&self) -> Vec<Force> {
        let seen = |f: &[f64; 3]| Vec3(*f).norm() >= LEAST_FORCE_N;
        let bodies = self.sample.contact_force.iter().enumerate();
        let on_ball = [self.sample.ball_force];
        bodies
            .filter(|(_, f)| seen(f))
            .filter_map(|(i, f)| Some(Force { body: Some(u8::try_from(i).ok()?), newton: self.vector(*f) }))
            .chain(on_ball.iter().filter(|f| seen(f)).map(|f| Force { body: None, newton: self.vector(*f) }))
            .collect()
    }
}
