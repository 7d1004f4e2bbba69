//! MuJoCo behind the [`Simulator`] interface.

use paid_lanes::{Mat3, Quat, Vec3};
use paid_physics::{BallState, BodyState, EnvParams, GroupState, LaneState, LateTargets, Simulator};
use paid_robot::{ControlSpec, RobotModel};

use crate::ground::Surface;
use crate::layout::model::ACTUATOR_PARAMETERS;
use crate::mjcf::mjcf_scene;
use crate::reports::ContactReport;
use crate::scene::{BALL, GROUND, PdControl, SceneOptions, ball_inertia};
use crate::world::{MujocoError, World};

/// Velocity coordinates of a free joint.
pub(crate) const FREE_NV: usize = 6;
/// Position coordinates of a free joint.
const FREE_NQ: usize = 7;

/// Environments that run in MuJoCo, one per group.
///
/// Joint targets are followed by PD control, by default explicit and clipped to the effort limits at every physics step, as
/// PAiD's public evaluation does. Forces are those of MuJoCo's solver. [`Simulator::set_params`] applies masses, inertias,
/// the base's center of mass, gains, and the ball's mass, radius and damping; surfaces (friction, restitution) and the
/// floor come from [`SceneOptions`] alone, since MuJoCo's contact model has other parameters.
#[derive(Debug)]
pub struct MujocoSim {
    model: RobotModel,
    control: ControlSpec,
    options: SceneOptions,
    effort: Vec<f64>,
    /// Principal inertias of all bodies as compiled.
    inertia: Vec<f64>,
    ball_body: Option<usize>,
    ball_geom: Option<usize>,
    surface: Surface,
    /// The body of rough ground.
    ground_body: Option<usize>,
    lanes: Vec<Lane>,
    /// The body whose pose is kept at every physics step.
    traced: Option<usize>,
}

#[derive(Debug)]
struct Lane {
    /// Poses of the traced body at the begin of every physics step of the last control step: place and row-major axes.
    trace: Vec<([f64; 3], [f64; 9])>,
    world: World,
    gain_scale: [f64; 2],
    report: ContactReport,
    state: GroupState<f64>,
    /// Where the ball is shown if the scene has none: position, velocity, angular velocity.
    marker: [[f64; 3]; 3],
}

fn array<const N: usize>(values: &[f64]) -> [f64; N] {
    std::array::from_fn(|i| values[i])
}

/// World angular velocity from that in the frame turned by `quat`.
fn to_world(quat: [f64; 4], local: [f64; 3]) -> [f64; 3] {
    Quat::<f64>::c(quat).rotate(Vec3(local)).0
}

fn to_local(quat: [f64; 4], world: [f64; 3]) -> [f64; 3] {
    Quat::<f64>::c(quat).conj().rotate(Vec3(world)).0
}

impl MujocoSim {
    /// `num_envs` environments of the scene that [`mjcf_scene`] writes, in its `home` pose, with default parameters and the
    /// ball of `options`.
    ///
    /// # Errors
    /// If MuJoCo is missing (the message names the command that fetches it) or refuses the scene, or if `control` does
    /// not fit the robot.
    pub fn new(
        model: &RobotModel,
        control: &ControlSpec,
        options: &SceneOptions,
        num_envs: usize,
    ) -> Result<Self, MujocoError> {
        let joints = model.joints.len();
        for (name, found) in [
            ("default_pos", control.default_pos.len()),
            ("stiffness", control.stiffness.len()),
            ("damping", control.damping.len()),
        ] {
            if found != joints {
                return Err(MujocoError::Length { name, expected: joints, found });
            }
        }
        let world = World::from_xml(&mjcf_scene(model, control, options))?;
        for (index, body) in model.bodies.iter().enumerate() {
            let found = world.body(&body.name);
            if found != Some(index + 1) {
                let found = found.map_or_else(|| "none".to_owned(), |n| n.to_string());
                return Err(MujocoError::BodyOrder { body: body.name.clone(), expected: index + 1, found });
            }
        }
        let (ball_body, ball_geom) = (world.body(BALL), world.geom(BALL));
        let mut sim = Self {
            model: model.clone(),
            control: control.clone(),
            options: options.clone(),
            effort: model.joints.iter().map(|j| options.effort(j)).collect(),
            inertia: world.body_inertia().to_vec(),
            ball_body,
            ball_geom,
            surface: Surface::new(options.ground),
            ground_body: world.body(GROUND),
            lanes: Vec::with_capacity(num_envs),
            traced: None,
        };
        let marker = [[1.0, 0.0, 0.0], [0.0; 3], [0.0; 3]];
        for _ in 0..num_envs {
            sim.lanes.push(Lane {
                trace: Vec::new(),
                world: world.duplicate()?,
                gain_scale: [1.0; 2],
                report: ContactReport::new(model.bodies.len()),
                state: GroupState::empty(model.joints.len(), model.bodies.len()),
                marker,
            });
        }
        let params =
            EnvParams { ball: options.ball.map(|b| b.params).unwrap_or_default(), ..EnvParams::default() };
        let home = LaneState {
            base_pos: model.bodies[0].pos,
            base_quat: [1.0, 0.0, 0.0, 0.0],
            base_lin_vel: [0.0; 3],
            base_ang_vel: [0.0; 3],
            joint_pos: control.default_pos.clone(),
            joint_vel: vec![0.0; joints],
            ball_pos: [1.0, 0.0, params.ball.radius_m],
            ball_vel: [0.0; 3],
            ball_ang_vel: [0.0; 3],
            warm_start: Vec::new(),
        };
        for group in 0..num_envs {
            sim.set_params(group, 0, &params);
            sim.reset_lane(group, 0, &home);
            sim.refresh(group);
        }
        Ok(sim)
    }

    /// The MuJoCo world of an environment: contacts, distances, whatever the interface does not show.
    pub fn world(&self, group: usize) -> &World {
        &self.lanes[group].world
    }

    /// The same for changes that the interface does not offer. Sizes must stay; the state reports follow at the next `refresh`.
    pub fn world_mut(&mut self, group: usize) -> &mut World {
        &mut self.lanes[group].world
    }

    /// Keeps the pose of a body (its model index) at every physics step: an inertial sensor needs more than the control
    /// steps show.
    pub fn trace_body(&mut self, body: Option<usize>) {
        self.traced = body;
    }

    /// Poses of the traced body in the last control step, one for the begin of each physics step: place `[m]` and row-major axes, world.
    pub fn trace(&self, group: usize) -> &[([f64; 3], [f64; 9])] {
        &self.lanes[group].trace
    }

    /// Lets rough ground follow the robot by whole periods, so that it has no end.
    fn follow_with_ground(&mut self, group: usize) {
        let world = &mut self.lanes[group].world;
        let base = array(world.qpos());
        if let Some((body, middle)) = self.ground_body.zip(self.surface.middle(base)) {
            world.body_pos_mut()[3 * body..3 * body + 2].copy_from_slice(&middle);
        }
    }

    /// The options of the scene.
    pub fn options(&self) -> &SceneOptions {
        &self.options
    }

    /// First position and velocity coordinate of the ball.
    fn ball_at(&self) -> (usize, usize) {
        (FREE_NQ + self.model.joints.len(), FREE_NV + self.model.joints.len())
    }

    /// The dynamic state as the interface has it, without warm start.
    fn public_state(&self, lane: &Lane) -> LaneState {
        let (q, v) = (lane.world.qpos(), lane.world.qvel());
        let joints = self.model.joints.len();
        let (bq, bv) = self.ball_at();
        let base_quat = array(&q[3..]);
        let ball = if self.ball_body.is_some() {
            let quat = array(&q[bq + 3..]);
            [array(&q[bq..]), array(&v[bv..]), to_world(quat, array(&v[bv + 3..]))]
        } else {
            lane.marker
        };
        LaneState {
            base_pos: array(q),
            base_quat,
            base_lin_vel: array(v),
            base_ang_vel: to_world(base_quat, array(&v[3..])),
            joint_pos: q[FREE_NQ..FREE_NQ + joints].to_vec(),
            joint_vel: v[FREE_NV..FREE_NV + joints].to_vec(),
            ball_pos: ball[0],
            ball_vel: ball[1],
            ball_ang_vel: ball[2],
            warm_start: Vec::new(),
        }
    }
}

impl Simulator<f64> for MujocoSim {
    fn model(&self) -> &RobotModel {
        &self.model
    }

    fn groups(&self) -> usize {
        self.lanes.len()
    }

    fn control_dt_s(&self) -> f64 {
        self.options.physics_dt_s * self.options.substeps as f64
    }

    fn step_late(&mut self, group: usize, targets: LateTargets<'_, f64>) {
        let joints = self.model.joints.len();
        let mut joint_target = vec![0.0; joints];
        self.follow_with_ground(group);
        let lane = &mut self.lanes[group];
        lane.report.clear();
        lane.trace.clear();
        for i in 0..self.options.substeps {
            targets.fill(i, self.options.substeps, &mut joint_target);
            match self.options.pd {
                PdControl::Explicit => {
                    for j in 0..joints {
                        let (q, v) = (lane.world.qpos()[FREE_NQ + j], lane.world.qvel()[FREE_NV + j]);
                        let stiffness = self.control.stiffness[j] * lane.gain_scale[0];
                        let damping = self.control.damping[j] * lane.gain_scale[1];
                        let torque = stiffness * (joint_target[j] - q) - damping * v;
                        lane.world.ctrl_mut()[j] = torque.clamp(-self.effort[j], self.effort[j]);
                    }
                }
                PdControl::Implicit => lane.world.ctrl_mut().copy_from_slice(&joint_target),
            }
            lane.world.step();
            if let Some(body) = self.traced {
                // MuJoCo computes where the bodies are at the begin of a step, and leaves that.
                let b = body + 1;
                let pose = (array(&lane.world.xpos()[3 * b..]), array(&lane.world.xmat()[9 * b..]));
                lane.trace.push(pose);
            }
            lane.report.take(&lane.world, self.ball_body);
        }
        lane.state.joint_torque.copy_from_slice(lane.world.actuator_force());
        self.refresh(group);
    }

    fn state(&self, group: usize) -> &GroupState<f64> {
        &self.lanes[group].state
    }

    fn reset_lane(&mut self, group: usize, lane: usize, state: &LaneState) {
        assert_eq!(lane, 0, "MuJoCo has one lane per group");
        let joints = self.model.joints.len();
        let (bq, bv) = self.ball_at();
        let has_ball = self.ball_body.is_some();
        let lane = &mut self.lanes[group];
        lane.world.reset();
        let (nq, nv) = (lane.world.nq(), lane.world.nv());
        if state.warm_start.len() == nq + 2 * nv {
            let (q, rest) = state.warm_start.split_at(nq);
            lane.world.qpos_mut().copy_from_slice(q);
            lane.world.qvel_mut().copy_from_slice(&rest[..nv]);
            lane.world.qacc_warmstart_mut().copy_from_slice(&rest[nv..]);
            lane.marker = [state.ball_pos, state.ball_vel, state.ball_ang_vel];
        }
        // What was saved continues bit for bit; a state that was changed since is taken from its public part.
        let lane = &self.lanes[group];
        let restored = self.public_state(lane);
        let same = LaneState { warm_start: state.warm_start.clone(), ..restored } == *state;
        let lane = &mut self.lanes[group];
        if !(same && state.warm_start.len() == nq + 2 * nv) {
            let q = lane.world.qpos_mut();
            q[..3].copy_from_slice(&state.base_pos);
            q[3..7].copy_from_slice(&state.base_quat);
            q[FREE_NQ..FREE_NQ + joints].copy_from_slice(&state.joint_pos);
            if has_ball {
                q[bq..bq + 3].copy_from_slice(&state.ball_pos);
                q[bq + 3..bq + 7].copy_from_slice(&[1.0, 0.0, 0.0, 0.0]);
            }
            let v = lane.world.qvel_mut();
            v[..3].copy_from_slice(&state.base_lin_vel);
            v[3..6].copy_from_slice(&to_local(state.base_quat, state.base_ang_vel));
            v[FREE_NV..FREE_NV + joints].copy_from_slice(&state.joint_vel);
            if has_ball {
                v[bv..bv + 3].copy_from_slice(&state.ball_vel);
                v[bv + 3..bv + 6].copy_from_slice(&state.ball_ang_vel);
            }
            lane.marker = [state.ball_pos, state.ball_vel, state.ball_ang_vel];
        }
        lane.report.clear();
        lane.state.joint_torque.fill(0.0);
    }

    fn refresh(&mut self, group: usize) {
        self.lanes[group].world.kinematics();
        let public = self.public_state(&self.lanes[group]);
        let lane = &mut self.lanes[group];
        lane.state.joint_pos.copy_from_slice(&public.joint_pos);
        lane.state.joint_vel.copy_from_slice(&public.joint_vel);
        for (index, out) in lane.state.bodies.iter_mut().enumerate() {
            let b = index + 1;
            let (ang, lin) = lane.world.body_velocity(b);
            let pos = Vec3(array(&lane.world.xpos()[3 * b..]));
            let com = Vec3(array(&lane.world.xipos()[3 * b..]));
            let m: [f64; 9] = array(&lane.world.xmat()[9 * b..]);
            let rot = Mat3([[m[0], m[1], m[2]], [m[3], m[4], m[5]], [m[6], m[7], m[8]]]);
            let com_vel = Vec3(ang).cross_add(com - pos, Vec3(lin));
            *out = BodyState { pos, rot, lin_vel: Vec3(lin), com_vel, ang_vel: Vec3(ang) };
        }
        for (force, report) in lane.state.contact_force.iter_mut().zip(&lane.report.body) {
            *force = Vec3(*report);
        }
        lane.state.ball = BallState {
            pos: Vec3(public.ball_pos),
            vel: Vec3(public.ball_vel),
            ang_vel: Vec3(public.ball_ang_vel),
            robot_force: Vec3(lane.report.ball_robot),
            ground_force: Vec3(lane.report.ball_ground),
            touched_by: lane.report.touched_by.map_or(-1.0, |b| b as f64),
        };
    }

    fn save_lane(&self, group: usize, lane: usize) -> LaneState {
        assert_eq!(lane, 0, "MuJoCo has one lane per group");
        let lane = &self.lanes[group];
        let w = &lane.world;
        let warm_start = [w.qpos(), w.qvel(), w.qacc_warmstart()].concat();
        LaneState { warm_start, ..self.public_state(lane) }
    }

    fn set_params(&mut self, group: usize, lane: usize, params: &EnvParams) {
        assert_eq!(lane, 0, "MuJoCo has one lane per group");
        let ball_at = self.ball_at().1;
        let lane = &mut self.lanes[group];
        for (index, body) in self.model.bodies.iter().enumerate() {
            let b = index + 1;
            let scale = params.mass_scale.get(index).copied().unwrap_or(1.0);
            lane.world.body_mass_mut()[b] = body.mass * scale;
            for k in 3 * b..3 * b + 3 {
                lane.world.body_inertia_mut()[k] = self.inertia[k] * scale;
            }
        }
        for k in 0..3 {
            lane.world.body_ipos_mut()[3 + k] = self.model.bodies[0].com[k] + params.base_com_offset[k];
        }
        lane.gain_scale = params.gain_scale;
        if self.options.pd == PdControl::Implicit {
            for j in 0..self.model.joints.len() {
                let stiffness = self.control.stiffness[j] * params.gain_scale[0];
                let damping = self.control.damping[j] * params.gain_scale[1];
                let first = j * ACTUATOR_PARAMETERS;
                lane.world.actuator_gainprm_mut()[first] = stiffness;
                lane.world.actuator_biasprm_mut()[first + 1..first + 3]
                    .copy_from_slice(&[-stiffness, -damping]);
            }
        }
        if let (Some(body), Some(geom)) = (self.ball_body, self.ball_geom) {
            let ball = &params.ball;
            let inertia = ball_inertia(ball);
            lane.world.body_mass_mut()[body] = ball.mass_kg;
            lane.world.body_inertia_mut()[3 * body..3 * body + 3].fill(inertia);
            lane.world.geom_size_mut()[3 * geom] = ball.radius_m;
            if self.options.ball.is_some_and(|b| b.damped) {
                let damping = lane.world.dof_damping_mut();
                damping[ball_at..ball_at + 3].fill(ball.linear_damping * ball.mass_kg);
                damping[ball_at + 3..ball_at + 6].fill(ball.angular_damping * inertia);
            }
        }
        lane.world.refresh_constants();
    }

    fn push_lane(&mut self, group: usize, lane: usize, lin_vel: [f64; 3], ang_vel: [f64; 3]) {
        assert_eq!(lane, 0, "MuJoCo has one lane per group");
        let world = &mut self.lanes[group].world;
        let local = to_local(array(&world.qpos()[3..]), ang_vel);
        let v = world.qvel_mut();
        for k in 0..3 {
            v[k] += lin_vel[k];
            v[3 + k] += local[k];
        }
    }

    fn set_ball(&mut self, group: usize, lane: usize, pos: [f64; 3], vel: [f64; 3], ang_vel: [f64; 3]) {
        assert_eq!(lane, 0, "MuJoCo has one lane per group");
        let (bq, bv) = self.ball_at();
        let lane = &mut self.lanes[group];
        if self.ball_body.is_some() {
            let q = lane.world.qpos_mut();
            q[bq..bq + 3].copy_from_slice(&pos);
            q[bq + 3..bq + 7].copy_from_slice(&[1.0, 0.0, 0.0, 0.0]);
            let v = lane.world.qvel_mut();
            v[bv..bv + 3].copy_from_slice(&vel);
            v[bv + 3..bv + 6].copy_from_slice(&ang_vel);
            lane.world.qacc_warmstart_mut()[bv..bv + 6].fill(0.0);
        }
        lane.marker = [pos, vel, ang_vel];
        lane.state.ball = BallState {
            pos: Vec3(pos),
            vel: Vec3(vel),
            ang_vel: Vec3(ang_vel),
            robot_force: Vec3::zero(),
            ground_force: Vec3::zero(),
            touched_by: -1.0,
        };
    }

    fn ground_height(&self, _group: usize, _lane: usize, xy: [f64; 2]) -> f64 {
        self.surface.height(xy)
    }

    fn ball_on_ground(
        &self,
        _group: usize,
        _lane: usize,
        xy: [f64; 2],
        radius: f64,
        still: bool,
    ) -> [f64; 3] {
        self.surface.ball(xy, radius, still)
    }
}
