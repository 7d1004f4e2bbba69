//! The virtual robot's camera: what it would see, rendered.

use paid_lanes::Vec3;
use paid_runtime::quaternion;
use paid_track::Pose;
use paid_vision::scatter::{GoalFrame, KickCamera, KickScene, Scatter, Stance, Use};
use paid_vision::{ColorImage, DepthImage, Intrinsics};

/// Half of the goal's width, and its height `[m]`: the evaluation's.
const GOAL_M: [f64; 2] = [1.0, 1.8];

use crate::TwinError;
use crate::robot::VirtualG1;

/// Robot and ball at one time.
#[derive(Clone, Debug)]
pub struct Moment {
    /// When, simulated time `[us]`.
    pub at_us: u64,
    stance: Stance,
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
            stance: Stance { base: base.pos.0, quat: quaternion(&base.rot), joints: state.joint_pos.clone() },
            torso: Pose { rot: body.rot, pos: body.pos },
            torso_rate: body.ang_vel,
            ball: state.ball.pos.0,
            ball_vel: state.ball.vel.0,
        }
    }
}

/// Renders images: color and depth with the noise of a D435i, of a random place.
#[derive(Debug)]
pub struct SimCamera(KickCamera);

impl SimCamera {
    /// A camera of this size at the place of this number, for a ball of this radius `[m]`.
    ///
    /// # Errors
    /// If the robot's description lacks its torso.
    pub fn new(intrinsics: Intrinsics, radius: f64, seed: u64) -> Result<Self, TwinError> {
        let scatter = Scatter::new(Use::HeldOut, seed).map_err(TwinError::simulation)?;
        let (robot, place) = (scatter.robot().clone(), scatter.place(seed as u32));
        Ok(Self(KickCamera::new(robot, place, intrinsics, radius, seed)))
    }

    /// The camera's intrinsics.
    pub fn intrinsics(&self) -> &Intrinsics {
        &self.0.intrinsics
    }

    /// Puts a goal there: center (x, y) in the world `[m]`, facing along this heading `[rad]`.
    pub fn place_goal(&mut self, center: [f64; 2], heading: f64) {
        let [half_width, height] = GOAL_M;
        self.0.goal = Some(GoalFrame { center, heading, half_width, height });
    }

    /// An image of a moment, with its depth.
    pub fn picture(&mut self, moment: &Moment) -> (ColorImage, DepthImage) {
        let bodies = self.0.robot.bodies(&moment.stance);
        let picture = self.0.take(&KickScene {
            bodies: &bodies,
            torso: &moment.torso,
            torso_rate: moment.torso_rate,
            ball: moment.ball,
            ball_vel: moment.ball_vel,
        });
        (picture.color, picture.depth)
    }
}
