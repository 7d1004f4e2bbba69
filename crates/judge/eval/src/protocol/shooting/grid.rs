//! Which ball, which robot start, which motion.

use paid_lanes::rng::Rng;
use paid_lanes::{Mat3, Quat, Vec3};
use paid_play::{RollingBall, motion_for};
use paid_robot::{RobotModel, Shape};
use paid_task::{BodySample, EnvSample, first_look, roll_decay};
use serde::{Deserialize, Serialize};

use super::{ShootingOptions, Variant};
use crate::episodes::EvalSetup;
use crate::{EvalError, Setting};

/// Redraws of a robot start before a ball place counts as impossible.
const REDRAWS: usize = 1000;

/// A trial as planned. Coordinates are those of the robot's own (displaced) first pose: origin at the anchor, x along its
/// heading, y left `[m]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trial {
    /// Grid place (x, y) `[m]`.
    pub place: [f64; 2],
    /// Number of the trial at this place.
    pub repeat: usize,
    /// Displacement of the robot from where the grid expects it `[m]`.
    pub displacement: [f64; 2],
    /// Ball center `[m]`.
    pub ball: [f64; 2],
    /// Ball velocity `[m/s]`.
    pub ball_velocity: [f64; 2],
    /// Goal center `[m]`. In the JSON `goal` is whether it was hit.
    #[serde(rename = "goal_xy")]
    pub goal: [f64; 2],
    /// The motion whose displacement is nearest to the ball, as the robot knows it; for a policy that sees a rolling ball ahead of time,
    /// to where it will be when the motion strikes.
    pub motion: usize,
}

/// What the choice of a motion and of a free ball position needs of each motion.
#[derive(Clone, Debug)]
pub struct Placement<'a> {
    setup: &'a EvalSetup,
    /// Rate at which a rolling ball is expected to slow down `[1/s]`.
    decay: f64,
}

impl<'a> Placement<'a> {
    /// From the setup's motions.
    pub fn new(setup: &'a EvalSetup) -> Self {
        Self { setup, decay: roll_decay(&setup.ball()) }
    }

    /// The motion for a ball at `place` `[m]` with `velocity` `[m/s]`, in the start frame, in trial number `trial`. Where the task's
    /// knowledge is perceived, it is chosen by the robot's estimate after its first look at the trial's ball number `look`, which the
    /// kick then starts with.
    pub fn motion(&self, trial: usize, look: u64, place: [f64; 2], velocity: [f64; 2]) -> usize {
        let EvalSetup { library, preset, spec, seed, .. } = self.setup;
        let mut ball = RollingBall { place, velocity, decay: self.decay };
        if preset.perceives() {
            let env = u32::try_from(trial).unwrap_or(u32::MAX);
            ball = first_look(&preset.eyes, &ball, spec.nominal_height_m, *seed, env, look);
        }
        motion_for(library.facts(), &ball.as_chosen_by(preset.predicts_ball()), preset.control_dt_s())
    }

    /// True if a ball lying at `ball` would touch the robot in the first frame of `motion`.
    pub fn overlaps(&self, motion: usize, ball: [f64; 2]) -> bool {
        let (clip, facts) = (&self.setup.library.clips()[motion], &self.setup.library.facts()[motion]);
        let radius = self.setup.preset.ball_params.radius_m;
        let (s, c) = facts.heading.sin_cos();
        let center = [
            facts.start_xy[0] + c * ball[0] - s * ball[1],
            facts.start_xy[1] + s * ball[0] + c * ball[1],
            radius,
        ];
        let poses = clip.body_pos.iter().zip(&clip.body_quat);
        robot_distance(&self.setup.robot, poses.map(|(p, q)| (*p, Quat(*q).to_mat())), center) < radius
    }

    /// True if a ball at `ball`, from the robot's anchor (a body's index) along its heading `[m]`, would touch the robot in its present pose.
    pub fn touches(&self, sample: &EnvSample, anchor: usize, ball: [f64; 2]) -> bool {
        let radius = self.setup.preset.ball_params.radius_m;
        let BodySample { pos, rot, .. } = &sample.bodies[anchor];
        let (s, c) = rot[1][0].atan2(rot[0][0]).sin_cos();
        let center = [
            pos[0] + c * ball[0] - s * ball[1],
            pos[1] + s * ball[0] + c * ball[1],
            sample.ground_m + radius,
        ];
        let poses = sample.bodies.iter().map(|b| (b.pos, Mat3(b.rot)));
        robot_distance(&self.setup.robot, poses, center) < radius
    }
}

/// Distance from a point to the nearest contact shape `[m]`, zero inside a box; poses of the bodies' frames in the world, model order.
pub fn robot_distance(
    model: &RobotModel,
    poses: impl Iterator<Item = ([f64; 3], Mat3<f64>)>,
    point: [f64; 3],
) -> f64 {
    let mut nearest = f64::INFINITY;
    for (body, (pos, rot)) in model.bodies.iter().zip(poses) {
        let local = rot.tr_mul_vec(Vec3(point) - Vec3(pos));
        for geom in body.geoms.iter().filter(|g| g.class != "referee") {
            let distance = match geom.shape {
                Shape::Sphere { center, radius } => (local - Vec3(center)).norm() - radius,
                Shape::Capsule { ends: [a, b], radius } => {
                    let (along, to) = (Vec3(b) - Vec3(a), local - Vec3(a));
                    let t = (to.dot(along) / along.norm2().max(1e-12)).clamp(0.0, 1.0);
                    (to - along.scale(t)).norm() - radius
                }
                Shape::Box { center, half_size, quat } => {
                    let Vec3(v) = Quat(quat).conj().rotate(local - Vec3(center));
                    Vec3([0, 1, 2].map(|k| (v[k].abs() - half_size[k]).max(0.0))).norm()
                }
            };
            nearest = nearest.min(distance);
        }
    }
    nearest
}

/// All trials, place by place; trial `i` depends on the seed and `i` only.
///
/// # Errors
/// If an option makes no sense, or no robot start in the disc leaves room for the ball at some place.
pub fn plan(setup: &EvalSetup, options: &ShootingOptions) -> Result<Vec<Trial>, EvalError> {
    options.check()?;
    let placement = Placement::new(setup);
    let mut trials = Vec::new();
    for x in options.grid.places(options.grid.x) {
        for y in options.grid.places(options.grid.y) {
            for repeat in 0..options.trials {
                // A stream of its own: the numbers must not be those of the environment's resets.
                let number = trials.len();
                let mut rng = Rng::new(setup.seed, number as u32, STREAM);
                let trial = (0..REDRAWS)
                    .map(|_| draw(&mut rng, &placement, options, number, ([x, y], repeat)))
                    .find(|t| !placement.overlaps(t.motion, t.ball));
                trials.push(trial.ok_or_else(|| EvalError::Option {
                    option: Setting::Named("grid"),
                    expected: "positions that leave room for the ball next to the robot".to_owned(),
                    found: format!("({x}, {y})"),
                })?);
            }
        }
    }
    Ok(trials)
}

/// Random stream of the plan.
const STREAM: u32 = 0x5107;

fn draw(
    rng: &mut Rng,
    placement: &Placement,
    options: &ShootingOptions,
    number: usize,
    (place, repeat): ([f64; 2], usize),
) -> Trial {
    use std::f64::consts::TAU;
    let radius = options.start_radius_m * rng.unit().sqrt();
    let (s, c) = (TAU * rng.unit()).sin_cos();
    let displacement = [radius * c, radius * s];
    let (speed, angle) = (rng.unit(), TAU * rng.unit());
    let ball_velocity = options.rolling.map_or([0.0; 2], |[lo, hi]| {
        let v = lo + (hi - lo) * speed;
        [v * angle.cos(), v * angle.sin()]
    });
    let spot = place.map(|p| p + options.scatter_m * (2.0 * rng.unit() - 1.0));
    let (ball, goal) = match options.variant {
        Variant::Robot => (spot, [options.goal_distance_m, 0.0]),
        // DriverInput from the displaced robot, what stands still in the world moved the other way.
        Variant::World => (
            [spot[0] - displacement[0], spot[1] - displacement[1]],
            [options.goal_distance_m - displacement[0], -displacement[1]],
        ),
    };
    Trial {
        place,
        repeat,
        displacement,
        ball,
        ball_velocity,
        goal,
        motion: placement.motion(number, 0, ball, ball_velocity),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::protocol::shooting::Grid;
    use paid_robot::{Body, Geom};

    #[test]
    fn the_grids_have_the_papers_places() {
        let count = |g: Grid| (g.places(g.x).len(), g.places(g.y).len());
        assert_eq!(count(Grid::EFFECTIVE), (7, 9));
        assert_eq!(count(Grid::WHOLE), (11, 13));
        assert_eq!(Grid::EFFECTIVE.places([0.5, 2.0]).last(), Some(&2.0));
    }

    #[test]
    fn distances_to_the_three_shapes_by_hand() {
        let turned = [0.5_f64.sqrt(), 0.0, 0.0, 0.5_f64.sqrt()]; // 90 degrees about z
        let distance = |shape| {
            let body = Body {
                name: "b".into(),
                parent: None,
                pos: [0.0; 3],
                quat: [1.0, 0.0, 0.0, 0.0],
                mass: 1.0,
                com: [0.0; 3],
                inertia: [1.0, 1.0, 1.0, 0.0, 0.0, 0.0],
                geoms: vec![Geom { name: "g".into(), class: "collision".into(), shape }],
            };
            let model = RobotModel {
                name: "m".into(),
                bodies: vec![body],
                joints: vec![],
                contact_exclusions: vec![],
            };
            // The body stands at (1, 0, 0) and is turned: its x axis is the world's y.
            robot_distance(&model, [([1.0, 0.0, 0.0], Quat(turned).to_mat())].into_iter(), [1.0, 2.0, 0.0])
        };
        assert!((distance(Shape::Sphere { center: [1.0, 0.0, 0.0], radius: 0.25 }) - 0.75).abs() < 1e-12);
        let capsule = Shape::Capsule { ends: [[0.0; 3], [0.5, 0.0, 0.0]], radius: 0.1 };
        assert!((distance(capsule) - 1.4).abs() < 1e-12);
        let cuboid = Shape::Box { center: [0.0; 3], half_size: [0.5, 3.0, 1.0], quat: [1.0, 0.0, 0.0, 0.0] };
        assert!((distance(cuboid) - 1.5).abs() < 1e-12);
    }
}
