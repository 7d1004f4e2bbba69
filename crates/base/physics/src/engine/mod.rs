//! The built-in engine: articulated-body dynamics with implicit joint controllers, contacts at velocity level.
//!
//! A physics step, for all lanes of a group at once:
//! 1. `outward`: poses, velocities, rigid inertias, bias forces, contact shapes.
//! 2. `inward`: articulated inertias with controllers, joint stops, friction loss and `soft` ground contacts implicit.
//! 3. `feet`, `ball`, `pairs`: contacts at velocity level by projected Gauss-Seidel, warm-started at the soles. Where contacts are
//!    soft, `spring` says which velocity they reach.
//! 4. `step`: new velocities and positions, semi-implicit Euler.
//!
//! Everything spatial is in world axes about the base's origin. Lanes never influence one another: a branch
//! skips work only if that work would have added exact zeros.

mod articulated;
mod ball;
mod block;
mod cone;
mod error;
mod feet;
mod foot;
mod forces;
mod ground;
mod group;
mod inward;
mod kernels;
mod layout;
mod outward;
mod pairs;
mod params;
mod phase;
mod plate;
mod report;
mod rows;
mod shapes;
#[cfg(test)]
mod slope_tests;
mod soft;
mod sole;
mod solver;
mod spatial;
mod spec;
mod spring;
mod step;
mod touch;
mod twist;
mod validate;

use paid_lanes::{Quat, Real, Vec3};
use paid_robot::RobotModel;

pub use error::PhysicsError;
pub use solver::SolverConstants;
pub use spec::EngineSpec;

use ground::Ground;
use group::{Group, Work};
use kernels::Kernels;
use layout::ModelLayout;
use params::GroupParams;

use crate::{EnvParams, GroupState, LaneState, LateTargets, SceneConfig, Simulator};

/// A batch of environments on the built-in engine, `V::LANES` per group.
pub struct Engine<V: Real> {
    model: RobotModel,
    scene: SceneConfig,
    layout: ModelLayout<V::Scalar>,
    ground: Ground<V::Scalar>,
    groups: Vec<Group<V>>,
    work: Work<V>,
    kernels: Kernels<V>,
}

fn check_scene(scene: &SceneConfig) -> Result<(), PhysicsError> {
    let bad = |what: &str, expected, found: String| {
        Err(PhysicsError::Value { what: what.to_owned(), expected, found })
    };
    if !(scene.physics_dt_s > 0.0 && scene.physics_dt_s <= 0.05) {
        return bad("physics_dt_s", "above 0, at most 0.05 s", scene.physics_dt_s.to_string());
    }
    if scene.substeps == 0 {
        return bad("substeps", "at least 1", scene.substeps.to_string());
    }
    if scene.solver_sweeps == 0 {
        return bad("solver_sweeps", "at least 1", scene.solver_sweeps.to_string());
    }
    if !(scene.gravity <= 0.0 && scene.gravity.is_finite()) {
        return bad("gravity", "along z, at most 0 m/s^2", scene.gravity.to_string());
    }
    if scene.max_joint_speed.is_nan() || scene.max_joint_speed <= 0.0 {
        return bad("max_joint_speed", "a positive number", scene.max_joint_speed.to_string());
    }
    Ok(())
}

impl<V: Real> Engine<V> {
    /// Builds `groups` groups of environments, all with the base at the model's height, joints at zero, and the ball 2 m
    /// ahead; reset each lane before use.
    ///
    /// # Errors
    /// If the model is no biped of hinge joints in model order, a contact shape is unknown, or a number is out of range.
    pub fn new(
        model: &RobotModel,
        spec: EngineSpec,
        scene: &SceneConfig,
        groups: usize,
    ) -> Result<Self, PhysicsError> {
        check_scene(scene)?;
        let layout = ModelLayout::new(model, &spec, scene)?;
        let ground = Ground::new(&scene.terrain)?;
        let joints = model.joints.len();
        let radius = EnvParams::default().ball.radius_m;
        let group = Group {
            pos: Vec3::c([0.0, 0.0, model.bodies[0].pos[2]]),
            quat: Quat::identity(),
            vel: Vec3::zero(),
            omega: Vec3::zero(),
            q: vec![V::zero(); joints],
            qd: vec![V::zero(); joints],
            ball_pos: Vec3::c([2.0, 0.0, radius]),
            ball_vel: Vec3::zero(),
            ball_omega: Vec3::zero(),
            warm: vec![[[V::zero(); 3]; 2]; layout.soles.len()],
            params: GroupParams::new(scene, joints + 1),
            state: GroupState::empty(joints, joints + 1),
            reset: 0,
        };
        let mut engine = Self {
            model: model.clone(),
            scene: scene.clone(),
            work: Work::new(&layout),
            layout,
            ground,
            groups: vec![group; groups],
            kernels: Kernels::for_lanes(),
        };
        for g in 0..groups {
            engine.refresh(g);
        }
        Ok(engine)
    }

    /// The scene.
    pub fn scene(&self) -> &SceneConfig {
        &self.scene
    }

    /// Advances the balls of a group alone by `steps` physics steps: the robots neither move nor touch them. For experiments on
    /// the ball, at a small part of a full step's cost. The balls move even where the scene makes them markers; of
    /// `state`, only the ball and the contact forces are renewed.
    pub fn step_balls(&mut self, group: usize, steps: usize) {
        (self.kernels.balls)(self, group, steps);
    }
}

impl<V: Real> Simulator<V> for Engine<V> {
    fn model(&self) -> &RobotModel {
        &self.model
    }

    fn groups(&self) -> usize {
        self.groups.len()
    }

    fn control_dt_s(&self) -> f64 {
        self.scene.physics_dt_s * self.scene.substeps as f64
    }

    fn step_late(&mut self, group: usize, targets: LateTargets<'_, V>) {
        let joints = self.layout.links.len();
        assert!(targets.now.len() == joints && targets.before.len() == joints, "one target per joint");
        self.groups[group].reset = 0;
        (self.kernels.step)(self, group, targets);
    }

    fn state(&self, group: usize) -> &GroupState<V> {
        &self.groups[group].state
    }

    fn reset_lane(&mut self, group: usize, lane: usize, state: &LaneState) {
        let g = &mut self.groups[group];
        assert_eq!(state.joint_pos.len(), g.q.len(), "one angle per joint");
        assert_eq!(state.joint_vel.len(), g.q.len(), "one velocity per joint");
        let warm = g.warm.len() * 6;
        assert!(
            state.warm_start.is_empty() || state.warm_start.len() == warm,
            "warm_start: expected 0 or {warm} values, found {}",
            state.warm_start.len()
        );
        g.pos.set_lane(lane, state.base_pos);
        g.quat.set_lane(lane, state.base_quat);
        g.vel.set_lane(lane, state.base_lin_vel);
        g.omega.set_lane(lane, state.base_ang_vel);
        for j in 0..g.q.len() {
            g.q[j].set_lane(lane, state.joint_pos[j]);
            g.qd[j].set_lane(lane, state.joint_vel[j]);
        }
        g.ball_pos.set_lane(lane, state.ball_pos);
        g.ball_vel.set_lane(lane, state.ball_vel);
        g.ball_omega.set_lane(lane, state.ball_ang_vel);
        for (i, x) in g.warm.as_flattened_mut().as_flattened_mut().iter_mut().enumerate() {
            x.set_lane(lane, state.warm_start.get(i).copied().unwrap_or(0.0));
        }
        g.reset |= 1 << lane;
    }

    fn refresh(&mut self, group: usize) {
        let g = &mut self.groups[group];
        for lane in 0..V::LANES {
            if g.reset >> lane & 1 == 1 {
                report::clear_lane(&mut g.state, lane);
            }
        }
        g.reset = 0;
        (self.kernels.refresh)(self, group);
    }

    fn save_lane(&self, group: usize, lane: usize) -> LaneState {
        let g = &self.groups[group];
        LaneState {
            base_pos: g.pos.lane(lane),
            base_quat: g.quat.lane(lane),
            base_lin_vel: g.vel.lane(lane),
            base_ang_vel: g.omega.lane(lane),
            joint_pos: g.q.iter().map(|x| x.lane(lane)).collect(),
            joint_vel: g.qd.iter().map(|x| x.lane(lane)).collect(),
            ball_pos: g.ball_pos.lane(lane),
            ball_vel: g.ball_vel.lane(lane),
            ball_ang_vel: g.ball_omega.lane(lane),
            warm_start: g.warm.as_flattened().as_flattened().iter().map(|x| x.lane(lane)).collect(),
        }
    }

    fn set_params(&mut self, group: usize, lane: usize, params: &EnvParams) {
        let bodies = self.model.bodies.len();
        self.groups[group].params.set_lane(lane, params, &self.scene, bodies);
    }

    fn push_lane(&mut self, group: usize, lane: usize, lin_vel: [f64; 3], ang_vel: [f64; 3]) {
        let g = &mut self.groups[group];
        for k in 0..3 {
            g.vel.0[k].set_lane(lane, g.vel.0[k].lane(lane) + lin_vel[k]);
            g.omega.0[k].set_lane(lane, g.omega.0[k].lane(lane) + ang_vel[k]);
        }
    }

    fn set_ball(&mut self, group: usize, lane: usize, pos: [f64; 3], vel: [f64; 3], ang_vel: [f64; 3]) {
        let g = &mut self.groups[group];
        g.ball_pos.set_lane(lane, pos);
        g.ball_vel.set_lane(lane, vel);
        g.ball_omega.set_lane(lane, ang_vel);
        let ball = &mut g.state.ball;
        ball.pos.set_lane(lane, pos);
        ball.vel.set_lane(lane, vel);
        ball.ang_vel.set_lane(lane, ang_vel);
        ball.robot_force.set_lane(lane, [0.0; 3]);
        ball.ground_force.set_lane(lane, [0.0; 3]);
        ball.touched_by.set_lane(lane, -1.0);
    }

    fn ground_height(&self, group: usize, lane: usize, xy: [f64; 2]) -> f64 {
        let params = &self.groups[group].params;
        self.ground.at(V::c(xy[0]), V::c(xy[1]), params).0.lane(lane)
    }
}
