//! The virtual robot's camera: what it would see, rendered.

use paid_lanes::{Quat, Vec3};
use paid_perceive::Pose;
use paid_robot::kinematics;
use paid_vision::render::{ColorSensor, DepthSensor, Form, Paint, Scene, Solid, View, render};
use paid_vision::scatter::{Place, Robot, Scatter, Use};
use paid_vision::{ColorImage, DepthImage, Intrinsics};

use super::robot::{VirtualG1, quaternion};
use crate::DeployError;

/// Half of the goal's width, and its height `[m]`: the judge's.
const GOAL_M: [f64; 2] = [1.0, 1.8];

/// Robot and ball at one time.
#[derive(Clone, Debug)]
pub struct Moment {
    /// When, simulated time `[us]`.
    pub at_us: u64,
    base: ([f64; 3], [f64; 4]),
    joints: Vec<f64>,
    /// The torso in the world.
    pub torso: Pose,
    torso_rate: Vec3<f64>,
    ball: [f64; 3],
    ball_vel: [f64; 3],
}

impl Moment {
    /// The virtual robot as it is now; `torso` is the body that carries camera and LiDAR.
    pub fn of(robot: &VirtualG1, torso: usize) -> Self {
        let state = robot.truth();
        let (base, body) = (&state.bodies[0], &state.bodies[torso]);
        Self {
            at_us: robot.now_us(),
            base: (base.pos.0, quaternion(&base.rot)),
            joints: state.joint_pos.clone(),
            torso: Pose { rot: body.rot, pos: body.pos },
            torso_rate: body.ang_vel,
            ball: state.ball.pos.0,
            ball_vel: state.ball.vel.0,
        }
    }
}

/// Renders pictures: color and depth with the noise of a D435i, of a place by chance.
#[derive(Debug)]
pub struct SimCamera {
    robot: Robot,
    place: Place,
    radius: f64,
    intrinsics: Intrinsics,
    /// Center (x, y) in the world `[m]`, and the direction that it faces `[rad]`.
    goal: Option<([f64; 2], f64)>,
    seed: u32,
    number: u32,
}

impl SimCamera {
    /// A camera of this size at the place of this number, for a ball of this radius `[m]`.
    ///
    /// # Errors
    /// If the robot's description lacks its torso.
    pub fn new(intrinsics: Intrinsics, radius: f64, seed: u64) -> Result<Self, DeployError> {
        let scatter = Scatter::new(Use::HeldOut, seed).map_err(DeployError::simulation)?;
        Ok(Self {
            robot: Robot::g1().map_err(DeployError::simulation)?,
            place: scatter.place(seed as u32),
            radius,
            intrinsics,
            goal: None,
            seed: seed as u32 ^ (seed >> 32) as u32,
            number: 0,
        })
    }

    /// The camera as it says itself.
    pub fn intrinsics(&self) -> &Intrinsics {
        &self.intrinsics
    }

    /// Puts a goal there: center (x, y) in the world `[m]`, facing along this heading `[rad]`.
    pub fn place_goal(&mut self, center: [f64; 2], heading: f64) {
        self.goal = Some((center, heading));
    }

    /// A picture of a moment, with its depth.
    pub fn picture(&mut self, moment: &Moment) -> (ColorImage, DepthImage) {
        let place = &self.place;
        let (pos, quat) = moment.base;
        let bodies = kinematics::forward(self.robot.model(), Vec3(pos), Quat(quat), &moment.joints);
        let mut solids = self.robot.solids(&bodies, place.robot_colors);
        solids.extend(self.goal.iter().flat_map(|goal| goal_frame(*goal)));
        solids.push(Solid {
            form: Form::Sphere { center: moment.ball.map(|v| v as f32), radius: self.radius as f32 },
            paint: Paint::Ball(place.ball),
            velocity: moment.ball_vel.map(|v| v as f32),
        });
        let camera = moment.torso.compose(&Pose::g1_camera());
        // Pixels that the picture moves by while the camera turns.
        let rate = camera.rot.tr_mul_vec(moment.torso_rate);
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
        (color, depth)
    }
}

/// Two posts and a bar, white.
fn goal_frame(([x, y], heading): ([f64; 2], f64)) -> impl Iterator<Item = Solid> {
    let ([half, height], (s, c)) = (GOAL_M, heading.sin_cos());
    let corner = |side: f64, z: f64| [(x - side * half * s) as f32, (y + side * half * c) as f32, z as f32];
    let ends = [
        [corner(1.0, 0.0), corner(1.0, height)],
        [corner(-1.0, 0.0), corner(-1.0, height)],
        [corner(1.0, height), corner(-1.0, height)],
    ];
    ends.into_iter().map(|ends| Solid {
        form: Form::Capsule { ends, radius: 0.05 },
        paint: Paint::Plain { color: [0.8; 3], gloss: 0.2 },
        velocity: [0.0; 3],
    })
}
