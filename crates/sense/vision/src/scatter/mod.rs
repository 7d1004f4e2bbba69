//! Random scenes, for training and evaluating a detector: the robot walks or kicks, a ball lies or rolls somewhere, and everything else
//! that an image depends on is drawn again.

mod draw;
mod kick_camera;
mod place;
mod robots;
mod things;

pub use kick_camera::{GoalFrame, KickCamera, KickPicture, KickScene};
pub use place::Place;
pub use robots::{Robot, Stance};

use paid_lanes::rng::Rng;
use paid_lanes::{Mat3, Vec3};

use crate::render::{BallPattern, ColorSensor, DepthSensor, Form, Paint, Scene, Solid, View};
use crate::{Intrinsics, PixelBox, Pose, VisionError};
use draw::Draw;

/// What scenes are for. The two share no random numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Use {
    /// Training. [`UNSEEN_PATTERN`] does not occur.
    Training,
    /// Judging. All patterns occur.
    HeldOut,
}

/// The pattern of balls that training never shows.
pub const UNSEEN_PATTERN: BallPattern = BallPattern::Panels;

/// A scene, its camera, and what is true.
#[derive(Clone, Debug)]
pub struct Sample {
    /// What there is to see.
    pub scene: Scene,
    /// The camera.
    pub view: View,
    /// Pose of the torso in the world.
    pub torso: Pose,
    /// The color camera.
    pub color: ColorSensor,
    /// The depth camera.
    pub depth: DepthSensor,
    /// The ball; `None` in a scene without one.
    pub ball: Option<TrueBall>,
}

/// Where the ball is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrueBall {
    /// Center, world `[m]`.
    pub center: [f64; 3],
    /// Radius `[m]`.
    pub radius: f64,
    /// Distance from the robot's base along the ground `[m]`.
    pub distance: f64,
    /// The box around its whole outline, hidden or not; `None` if it is not before the camera.
    pub outline: Option<PixelBox>,
    /// How far it and the image move during the exposure, together `[px]`.
    pub blur_px: f64,
    /// Its layout of colors.
    pub pattern: BallPattern,
}

/// Draws scenes.
#[derive(Clone, Debug)]
pub struct Scatter {
    robot: Robot,
    purpose: Use,
    seed: u64,
}

impl Scatter {
    /// Scenes of this seed.
    ///
    /// # Errors
    /// If the robot's own description is broken.
    pub fn new(purpose: Use, seed: u64) -> Result<Self, VisionError> {
        Ok(Self { robot: Robot::g1()?, purpose, seed })
    }

    /// The robot whose eyes these are.
    pub fn robot(&self) -> &Robot {
        &self.robot
    }

    /// The scene of this number: the same for the same seed and number. `intrinsics` are the camera's; `with_ball` puts a ball at 0.3 to
    /// 4 m that is in the image, its middle at least.
    pub fn sample(&self, number: u32, intrinsics: Intrinsics, with_ball: bool) -> Sample {
        let stream = match self.purpose {
            Use::Training => 1,
            Use::HeldOut => 2,
        };
        let mut draw = Draw(Rng::new(self.seed, number, stream));
        let kick = draw.chance(0.3);
        let stance = self.robot.walking(&mut draw, [0.0; 2], 0.0, kick);
        let bodies = self.robot.bodies(&stance);
        let torso = self.robot.torso(&bodies);
        // The mount differs from robot to robot.
        let mut mount = Pose::g1_camera();
        mount.rot = mount.rot.mul_mat(&small_turn([0; 3].map(|_| draw.normal(0.02))));
        let mut camera = torso.compose(&mount);

        let light = things::light(&mut draw);
        let mut solids = self.robot.solids(&bodies, robot_colors(&mut draw));
        let exposure_s = draw.between(0.002, 0.02);
        let rolls = draw.chance(0.4);
        let ball = with_ball.then(|| {
            let distance = draw.between(0.3, 4.0);
            let radius = draw.between(0.09, 0.12);
            let bounce = if draw.chance(0.1) { draw.between(0.0, 0.5) } else { 0.0 };
            let aim = draw.between(-0.45, 0.45);
            let center = [distance * aim.cos(), distance * aim.sin(), radius + bounce];
            // The robot leans, or its head looks elsewhere: the ball may be anywhere in the image.
            let at = [0.02, 0.98];
            let pixel = [draw.between(at[0], at[1]), draw.between(at[0], at[1])];
            let pixel = [pixel[0] * intrinsics.width as f64, pixel[1] * intrinsics.height as f64];
            let natural =
                intrinsics.project(camera.inverse_point(center)).is_some_and(|p| inside(&intrinsics, p));
            if !natural || draw.chance(0.3) {
                look_at(&mut camera, &intrinsics, center, pixel);
            }
            let velocity = if rolls {
                let [c, s] = draw.heading();
                let speed = draw.between_f32(0.2, 3.0);
                [c * speed, s * speed, 0.0]
            } else {
                [0.0; 3]
            };
            let patterns: &[BallPattern] = match self.purpose {
                Use::Training => &BallPattern::ALL[..3],
                Use::HeldOut => &BallPattern::ALL,
            };
            let mut patterns = patterns.to_vec();
            if self.purpose == Use::Training {
                patterns.push(BallPattern::Blots);
            }
            (center, radius, distance, velocity, things::ball_paint(&mut draw, &patterns))
        });
        if !with_ball && draw.chance(0.5) {
            // Look about as with a ball.
            let aim = [draw.between(0.3, 4.0), draw.between(-1.5, 1.5), 0.1];
            let middle = intrinsics.center;
            look_at(&mut camera, &intrinsics, aim, middle);
        }
        for (share, put) in [(0.35, 0), (0.3, 1), (0.25, 2)] {
            if draw.chance(share) {
                let place = [draw.between(0.8, 4.5), draw.between(-1.8, 1.8)];
                solids.extend(match put {
                    0 => {
                        let heading = draw.between(-3.1, 3.1);
                        let stance = self.robot.walking(&mut draw, place, heading, false);
                        self.robot.solids(&self.robot.bodies(&stance), robot_colors(&mut draw))
                    }
                    1 => robots::person(&mut draw, place.map(|v| v as f32)),
                    _ => things::goal(&mut draw),
                });
            }
        }
        solids.extend(things::clutter(&mut draw));
        let turns = draw.chance(0.4);
        let shake = if turns {
            let rate = draw.between(0.0, 2.0) * exposure_s * intrinsics.focal[0];
            let [c, s] = draw.heading();
            [c * rate as f32, s * rate as f32]
        } else {
            [0.0; 2]
        };
        let truth = ball.map(|(center, radius, distance, velocity, paint)| {
            // A thing that the ball is in is taken away, except the robot's legs.
            let own = self.robot.solids(&bodies, [[0.0; 3]; 2]).len();
            let at = center.map(|v| v as f32);
            let mut index = 0;
            solids.retain(|solid| {
                index += 1;
                index <= own || !touches(solid, at, radius as f32)
            });
            solids.push(Solid {
                form: Form::Sphere { center: at, radius: radius as f32 },
                paint: Paint::Ball(paint),
                velocity,
            });
            let in_camera = camera.inverse_point(center);
            let speed = f64::from(velocity[0].hypot(velocity[1]));
            let way = speed * exposure_s * intrinsics.focal[0] / in_camera[2].max(0.1);
            TrueBall {
                center,
                radius,
                distance,
                outline: intrinsics.sphere_box(in_camera, radius),
                blur_px: way + f64::from(shake[0].hypot(shake[1])),
                pattern: paint.pattern,
            }
        });
        let color = things::color_sensor(&mut draw, &light, shake);
        let depth = things::depth_sensor(&mut draw);
        let background = [draw.color([0.0, 0.4], [0.1, 0.8]), draw.color([0.0, 0.4], [0.1, 0.9])];
        let scene = Scene { ground: things::ground(&mut draw), solids, light, background };
        Sample {
            scene,
            view: View { intrinsics, pose: camera, exposure_s },
            torso,
            color,
            depth,
            ball: truth,
        }
    }
}

/// White or gray shells and dark joints.
fn robot_colors(draw: &mut Draw) -> [[f32; 3]; 2] {
    let shell = draw.between_f32(0.15, 0.85);
    let joint = draw.between_f32(0.01, 0.15);
    [draw.near([shell; 3], 0.08), draw.near([joint; 3], 0.08)]
}

fn inside(intrinsics: &Intrinsics, [x, y]: [f64; 2]) -> bool {
    (0.0..intrinsics.width as f64).contains(&x) && (0.0..intrinsics.height as f64).contains(&y)
}

/// A rotation by a small vector of angles `[rad]`.
fn small_turn(angles: [f64; 3]) -> Mat3<f64> {
    let quat = paid_lanes::Quat([1.0, 0.5 * angles[0], 0.5 * angles[1], 0.5 * angles[2]]).normalize();
    quat.to_mat()
}

/// Turns the camera up or down about its right axis and left or right about the vertical until a point is at a pixel.
fn look_at(camera: &mut Pose, intrinsics: &Intrinsics, point: [f64; 3], pixel: [f64; 2]) {
    for _ in 0..4 {
        let seen = Vec3(camera.inverse_point(point));
        let wanted = intrinsics.ray(pixel);
        let upright = seen.y().atan2(seen.z()) - wanted[1].atan2(1.0);
        let turn = paid_lanes::Quat::<f64>::from_axis_angle(Vec3([1.0, 0.0, 0.0]), -upright).to_mat();
        camera.rot = camera.rot.mul_mat(&turn);
        let seen = Vec3(camera.inverse_point(point));
        let across = seen.x().atan2(seen.z()) - wanted[0].atan2(1.0);
        let turn = paid_lanes::Quat::<f64>::from_axis_angle(Vec3([0.0, 0.0, 1.0]), -across).to_mat();
        camera.rot = turn.mul_mat(&camera.rot);
    }
}

/// Whether a thing and a sphere touch, about.
fn touches(solid: &Solid, center: [f32; 3], radius: f32) -> bool {
    match solid.form {
        Form::Sphere { center: c, radius: r } => distance(c, center) < r + radius,
        Form::Capsule { ends: [a, b], radius: r } => (0..=8).any(|k| {
            let t = k as f32 / 8.0;
            distance([0, 1, 2].map(|i| a[i] + t * (b[i] - a[i])), center) < r + radius
        }),
        Form::Box { center: c, half_size, .. } => {
            distance(c, center) < radius + half_size.iter().map(|h| h * h).sum::<f32>().sqrt()
        }
    }
}

fn distance(a: [f32; 3], b: [f32; 3]) -> f32 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f32>().sqrt()
}
