//! A robot's own camera at a place to play.

use paid_lanes::Vec3;
use paid_robot::BodyPose;

use super::{Place, Robot};
use crate::render::{ColorSensor, DepthSensor, Form, Paint, Rendered, Scene, Solid, View, render};
use crate::{ColorImage, DepthImage, Intrinsics, Pose};

/// Radius of a goal's posts and bar `[m]`.
const POST_M: f64 = 0.05;

/// Two posts and a bar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GoalFrame {
    /// Its middle on the ground (x, y), world `[m]`.
    pub center: [f64; 2],
    /// The direction in which balls pass into it `[rad]`.
    pub heading: f64,
    /// Half of its width `[m]`.
    pub half_width: f64,
    /// Height of its bar `[m]`.
    pub height: f64,
}

impl GoalFrame {
    /// Its posts and its bar, white.
    fn solids(&self) -> impl Iterator<Item = Solid> + use<> {
        let Self { center: [x, y], half_width: half, height, .. } = *self;
        let (s, c) = self.heading.sin_cos();
        let corner =
            |side: f64, z: f64| [(x - side * half * s) as f32, (y + side * half * c) as f32, z as f32];
        let ends = [
            [corner(1.0, 0.0), corner(1.0, height)],
            [corner(-1.0, 0.0), corner(-1.0, height)],
            [corner(1.0, height), corner(-1.0, height)],
        ];
        ends.into_iter().map(|ends| Solid {
            form: Form::Capsule { ends, radius: POST_M as f32 },
            paint: Paint::Plain { color: [0.8; 3], gloss: 0.2 },
            velocity: [0.0; 3],
        })
    }
}

/// What there is to see at one time, world axes.
#[derive(Clone, Copy, Debug)]
pub struct KickScene<'a> {
    /// Bodies of the robot, model order.
    pub bodies: &'a [BodyPose<f64>],
    /// Its torso, which carries the camera.
    pub torso: &'a Pose,
    /// Angular velocity of the torso `[rad/s]`.
    pub torso_rate: Vec3<f64>,
    /// Center of the ball `[m]`.
    pub ball: [f64; 3],
    /// Its velocity `[m/s]`.
    pub ball_vel: [f64; 3],
}

/// An image, and what is true of it.
#[derive(Debug)]
pub struct KickPicture {
    /// As the color camera gives it.
    pub color: ColorImage,
    /// As the depth camera gives it.
    pub depth: DepthImage,
    /// The scene without the cameras' errors.
    pub rendered: Rendered,
    /// The camera in the world.
    pub camera: Pose,
}

/// Renders what a G1's camera shows of its own kick: color and depth with the errors of the place's cameras, each image with its own.
#[derive(Clone, Debug)]
pub struct KickCamera {
    /// The robot.
    pub robot: Robot,
    /// Where it plays.
    pub place: Place,
    /// Radius of the ball `[m]`.
    pub radius: f64,
    /// The camera's pixels.
    pub intrinsics: Intrinsics,
    /// The goal, if one stands there.
    pub goal: Option<GoalFrame>,
    seed: u32,
    number: u32,
}

impl KickCamera {
    /// A camera without a goal before it. `seed` draws the errors of the images.
    pub fn new(robot: Robot, place: Place, intrinsics: Intrinsics, radius: f64, seed: u64) -> Self {
        let seed = seed as u32 ^ (seed >> 32) as u32;
        Self { robot, place, radius, intrinsics, goal: None, seed, number: 0 }
    }

    /// The next image.
    pub fn take(&mut self, seen: &KickScene<'_>) -> KickPicture {
        let place = &self.place;
        let mut solids = self.robot.solids(seen.bodies, place.robot_colors);
        solids.extend(self.goal.iter().flat_map(GoalFrame::solids));
        solids.push(Solid {
            form: Form::Sphere { center: seen.ball.map(|v| v as f32), radius: self.radius as f32 },
            paint: Paint::Ball(place.ball),
            velocity: seen.ball_vel.map(|v| v as f32),
        });
        let camera = seen.torso.compose(&Pose::g1_camera());
        // Pixels that the image moves by while the camera turns.
        let rate = camera.rot.tr_mul_vec(seen.torso_rate);
        let way = place.exposure_s * self.intrinsics.focal[0];
        let shake_px = [(-rate.y() * way) as f32, (rate.x() * way) as f32];
        let scene =
            Scene { ground: place.ground.clone(), solids, light: place.light, background: place.background };
        let view = View { intrinsics: self.intrinsics, pose: camera, exposure_s: place.exposure_s };
        let rendered = render(&scene, &view);
        self.number = self.number.wrapping_add(1);
        let seed = self.seed.wrapping_add(self.number.wrapping_mul(0x85eb_ca6b));
        let color = rendered.color(&ColorSensor { shake_px, seed, ..place.color });
        let depth = rendered.depth(&DepthSensor { seed: seed ^ 0x5bd1_e995, ..place.depth });
        KickPicture { color, depth, rendered, camera }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scatter::{Scatter, Use};

    #[test]
    fn a_goal_stands_across_the_way_of_the_balls_that_pass_into_it() {
        let goal = GoalFrame {
            center: [1.0, 2.0],
            heading: core::f64::consts::FRAC_PI_2,
            half_width: 1.5,
            height: 1.8,
        };
        let ends: Vec<_> = goal.solids().map(|solid| solid.form).collect();
        let Form::Capsule { ends: [foot, top], .. } = ends[0] else { panic!("no post: {:?}", ends[0]) };
        let near = |a: [f32; 3], b: [f32; 3]| (0..3).all(|k| (a[k] - b[k]).abs() < 1e-6);
        assert!(near(foot, [-0.5, 2.0, 0.0]) && near(top, [-0.5, 2.0, 1.8]), "{foot:?} {top:?}");
        assert_eq!(ends.len(), 3);
    }

    #[test]
    fn the_box_of_a_ball_ahead_is_around_its_center_and_the_next_picture_has_other_noise() {
        let scatter = Scatter::new(Use::HeldOut, 5).expect("a robot");
        let robot = scatter.robot().clone();
        let bodies = robot.bodies(&robot.standing([0.0; 2], 0.0));
        let torso = robot.torso(&bodies);
        let mut camera = KickCamera::new(robot, scatter.place(1), Intrinsics::g1_color(), 0.11, 5);
        let seen = KickScene {
            bodies: &bodies,
            torso: &torso,
            torso_rate: Vec3::zero(),
            ball: [1.2, 0.0, 0.11],
            ball_vel: [0.0; 3],
        };
        let (first, second) = (camera.take(&seen), camera.take(&seen));
        let (found, pixels) = first.rendered.ball_box().expect("in view");
        let center = camera.intrinsics.project(first.camera.inverse_point(seen.ball)).expect("ahead");
        assert!(pixels > 100);
        assert!((0..2).all(|k| found.min[k] < center[k] && center[k] < found.max[k]), "{found:?} {center:?}");
        assert_ne!(first.color.data, second.color.data);
    }
}
