//! Random impacts: a leg that swings in free space, and a ball in its way.

use paid_lanes::rng::Rng;
use paid_lanes::{Quat, Vec3};
use paid_physics::LaneState;
use paid_robot::kinematics::{forward, forward_velocity};
use paid_robot::{ControlSpec, RobotModel, Shape, WorldAngVel};

/// Fastest joint of the leg `[rad/s]`: feet then move at up to some 6 m/s.
const JOINT_SPEED: f64 = 6.0;
/// Largest deviation of the leg's joints from the default pose `[rad]`.
const JOINT_SPREAD: f64 = 0.3;
/// Largest velocity of the ball along each axis `[m/s]`.
const BALL_SPEED: f64 = 1.5;
/// Largest spin of the ball about each axis `[rad/s]`.
const BALL_SPIN: f64 = 10.0;
/// Slowest approach of the two surfaces `[m/s]`.
const LEAST_APPROACH: f64 = 1.0;
/// The surfaces meet within this time of the start `[s]`: the start is not tied to the physics steps.
const LEAD_S: f64 = 0.01;
/// Height of the base `[m]`: nothing is near the ground.
const HEIGHT_M: f64 = 3.0;
/// Draws until a ball is found that the leg hits; one in three does.
const DRAWS: usize = 1000;

/// One impact.
#[derive(Clone, Debug)]
pub struct Impact {
    /// Robot and ball at the start.
    pub state: LaneState,
    /// Where the joints are driven to `[rad]`. The torques are zero at the start.
    pub targets: Vec<f64>,
    /// Factor of the joint gains: 1, or 0 for a free leg.
    pub gain: f64,
}

/// What impacts are drawn for.
#[derive(Clone, Copy, Debug)]
pub struct Leg<'a> {
    /// The robot.
    pub model: &'a RobotModel,
    /// Its default pose and gains.
    pub control: &'a ControlSpec,
    /// The feet's bodies.
    pub feet: [usize; 2],
    /// Radius of the ball `[m]`.
    pub radius_m: f64,
}

/// A capsule of the leg in the world.
struct Placed {
    body: usize,
    ends: [Vec3<f64>; 2],
    radius: f64,
}

impl Placed {
    /// The axis point nearest to `p`.
    fn nearest(&self, p: Vec3<f64>) -> Vec3<f64> {
        let along = self.ends[1] - self.ends[0];
        let t = (p - self.ends[0]).dot(along) / along.norm2().max(1e-12);
        along.scale_add(t.clamp(0.0, 1.0), self.ends[0])
    }
}

fn vector(rng: &mut Rng, size: f64) -> [f64; 3] {
    std::array::from_fn(|_| rng.uniform(-size, size))
}

impl Leg<'_> {
    /// Impact `index` of the stream `seed`; `None` if no draw hits (which a robot with shaped legs does not meet).
    pub fn impact(&self, seed: u64, index: u32) -> Option<Impact> {
        let mut rng = Rng::new(seed, index, 0);
        (0..DRAWS).find_map(|_| self.draw(&mut rng))
    }

    fn draw(&self, rng: &mut Rng) -> Option<Impact> {
        let (model, control) = (self.model, self.control);
        let foot = self.feet[rng.below(2)];
        let mut joint_pos = control.default_pos.clone();
        let mut joint_vel = vec![0.0; joint_pos.len()];
        let mut body = foot;
        while let Some(parent) = model.bodies[body].parent {
            let j = body - 1;
            let [lo, hi] = control.soft_range[j];
            joint_pos[j] = (joint_pos[j] + rng.uniform(-JOINT_SPREAD, JOINT_SPREAD)).clamp(lo, hi);
            joint_vel[j] = rng.uniform(-JOINT_SPEED, JOINT_SPEED);
            body = parent;
        }
        let base_pos = [0.0, 0.0, HEIGHT_M];
        let poses = forward(model, Vec3(base_pos), Quat::<f64>::identity(), &joint_pos);
        let still = WorldAngVel(Vec3([0.0; 3]));
        let velocities = forward_velocity(model, &poses, Vec3([0.0; 3]), still, &joint_vel);
        let mut shapes = Vec::new();
        let mut link = Some(foot);
        while let Some(b) = link {
            for geom in model.bodies[b].geoms.iter().filter(|g| g.class == "collision") {
                let (ends, radius) = match geom.shape {
                    Shape::Sphere { center, radius } => ([center; 2], radius),
                    Shape::Capsule { ends, radius } => (ends, radius),
                    Shape::Box { .. } => continue,
                };
                shapes.push(Placed { body: b, ends: ends.map(|e| poses[b].point(Vec3(e))), radius });
            }
            link = model.bodies[b].parent.filter(|p| *p > 0);
        }
        // Half of the balls meet the foot, the others the foot or the shin above it.
        let aimed = shapes.get(rng.below(2).min(shapes.len().saturating_sub(1)))?;
        let ball_vel = vector(rng, BALL_SPEED);
        let along = (aimed.ends[1] - aimed.ends[0]).scale_add(rng.unit(), aimed.ends[0]);
        let normal = Vec3(std::array::from_fn(|_| rng.normal()));
        let normal = normal.scale(1.0 / normal.norm().max(1e-9));
        let velocity = &velocities[aimed.body];
        let surface = normal.scale_add(aimed.radius, along);
        let moving = velocity.ang.0.cross_add(surface - poses[aimed.body].pos, velocity.origin);
        let approach = (moving - Vec3(ball_vel)).dot(normal);
        if approach < LEAST_APPROACH {
            return None;
        }
        let gap = approach * rng.uniform(0.0, LEAD_S);
        let center = normal.scale_add(aimed.radius + self.radius_m + gap, along);
        let clear = |s: &Placed| (center - s.nearest(center)).norm() - s.radius - self.radius_m;
        if shapes.iter().any(|s| clear(s) < 0.8 * gap) {
            return None;
        }
        let gain = if rng.unit() < 0.5 { 1.0 } else { 0.0 };
        let targets = (0..joint_pos.len())
            .map(|j| joint_pos[j] + joint_vel[j] * control.damping[j] / control.stiffness[j])
            .collect();
        let state = LaneState {
            base_pos,
            base_quat: [1.0, 0.0, 0.0, 0.0],
            base_lin_vel: [0.0; 3],
            base_ang_vel: [0.0; 3],
            joint_pos,
            joint_vel,
            ball_pos: center.0,
            ball_vel,
            ball_ang_vel: vector(rng, BALL_SPIN),
            warm_start: Vec::new(),
        };
        Some(Impact { state, targets, gain })
    }
}
