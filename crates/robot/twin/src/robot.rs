//! The virtual G1: MuJoCo behind `LowCmd` and `LowState`.

use std::sync::Arc;

use paid_eval::metrics::shooting::fallen;
use paid_lanes::{Quat, Vec3};
use paid_mujoco::{MujocoSim, SceneOptions};
use paid_physics::{GroupState, LaneState, Simulator};
use paid_policy::Pose;
use paid_runtime::wire::{LowCmd, LowState, Remote};
use paid_runtime::{Inlet, LinkError, Outlet, Packet, Player, quaternion};

use crate::TwinError;
use crate::faults::Fault;
use crate::senses::TrueState;
use crate::task::trained_task;

/// Place of the pelvis's inertial sensor in the pelvis `[m]` (vendor's description of the robot).
const IMU: [f64; 3] = [0.04525, 0.0, -0.08339];
/// Joints of a free base in MuJoCo's arrays.
const FREE: [usize; 2] = [7, 6];
/// Time between two states `[us]`.
pub const STEP_US: u64 = 2_000;
/// Time between two messages of the battery `[us]`.
const BATTERY_US: u64 = 500_000;
/// Hands let go of a robot whose joints have held it for this long `[us]` ...
const HOLDS_US: u64 = 500_000;
/// ... each within this much of its target `[rad]`.
const HOLDS_RAD: f64 = 0.1;

/// What holds the pelvis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mount {
    /// Nothing: it stands or falls.
    Free,
    /// A gantry that holds it upright where it is and turns it about its y axis at this speed `[rad/s]`.
    Gantry {
        /// Pitch rate `[rad/s]`.
        pitch_rad_s: f64,
    },
    /// Hands that hold it upright where it is, until its joints have held the pose for half a second; then it is free.
    Hands,
}

/// A G1 that cannot break.
pub struct VirtualG1 {
    player: Arc<Player>,
    /// The body that carries camera and LiDAR.
    anchor: usize,
    sim: MujocoSim,
    mount: Mount,
    held: ([f64; 3], [f64; 4]),
    now_us: u64,
    command: LowCmd,
    command_us: Option<u64>,
    timeout_us: u64,
    refused: u64,
    imu_vel: Vec3<f64>,
    torque: Vec<f64>,
    remote: [u8; 40],
    battery: f64,
    /// Since when the joints hold the pose.
    holds_us: Option<u64>,
    fault: Option<Fault>,
    fault_us: u64,
}

impl VirtualG1 {
    /// Without a command for this long the robot stops by itself: damping `[us]`. An assumption: the vendor does not state its own.
    pub const TIMEOUT_US: u64 = 100_000;

    /// A robot in its default pose, held by a gantry with the feet on the ground, the ball 1 m behind it.
    ///
    /// # Errors
    /// If the policy's task cannot be read, or MuJoCo is missing or refuses the scene.
    pub fn new(player: Arc<Player>) -> Result<Self, TwinError> {
        // A rolling ball slows as the runtime's prediction and perception's ball memory expect it; a kicked one slides at first, so that it
        // takes the friction of training too.
        let scene =
            SceneOptions { physics_dt_s: STEP_US as f64 * 1e-6, substeps: 1, ..SceneOptions::default() };
        let task = trained_task(&player)?;
        let scene = scene.with_builtin_ball(task.ball_params, &task.scene);
        let sim = MujocoSim::new(&player.model, &player.control, &scene, 1).map_err(TwinError::simulation)?;
        let anchor = player.model.body_index(&player.spec.anchor_body).unwrap_or(0);
        let mut robot = Self {
            anchor,
            sim,
            mount: Mount::Gantry { pitch_rad_s: 0.0 },
            held: ([0.0, 0.0, player.spec.nominal_height_m], [1.0, 0.0, 0.0, 0.0]),
            now_us: 0,
            command: LowCmd::default(),
            command_us: None,
            timeout_us: Self::TIMEOUT_US,
            refused: 0,
            imu_vel: Vec3::zero(),
            torque: vec![0.0; player.joints()],
            remote: Remote::pressing(&[]),
            battery: 80.0,
            holds_us: None,
            fault: None,
            fault_us: 0,
            player,
        };
        let start = robot.at_rest();
        robot.set_state(&start);
        Ok(robot)
    }

    fn at_rest(&self) -> LaneState {
        let radius = self.player.play.ball_params.radius_m;
        LaneState {
            base_pos: self.held.0,
            base_quat: self.held.1,
            base_lin_vel: [0.0; 3],
            base_ang_vel: [0.0; 3],
            joint_pos: self.player.control.default_pos.clone(),
            joint_vel: vec![0.0; self.player.joints()],
            ball_pos: [-1.0, 0.0, radius],
            ball_vel: [0.0; 3],
            ball_ang_vel: [0.0; 3],
            warm_start: Vec::new(),
        }
    }

    /// Puts robot and ball into a state.
    pub fn set_state(&mut self, state: &LaneState) {
        self.sim.reset_lane(0, 0, state);
        self.held = (state.base_pos, state.base_quat);
        self.sim.refresh(0);
        self.imu_vel = self.imu_velocity();
    }

    /// Time since it was switched on `[us]`.
    pub fn now_us(&self) -> u64 {
        self.now_us
    }
    /// What is true of bodies, joints and ball.
    pub fn truth(&self) -> &GroupState<f64> {
        self.sim.state(0)
    }
    /// What senses may look at: pelvis, torso and ball.
    pub fn true_state(&self) -> TrueState {
        let state = self.truth();
        let pose = |body: usize| Pose { pos: state.bodies[body].pos, rot: state.bodies[body].rot };
        TrueState {
            base: pose(0),
            base_vel: state.bodies[0].lin_vel,
            torso: pose(self.anchor),
            ball: state.ball.pos,
            ball_vel: state.ball.vel,
        }
    }
    /// Root mean square of the joints' speeds `[rad/s]`.
    pub fn joint_speed(&self) -> f64 {
        let speeds = &self.truth().joint_vel;
        (speeds.iter().map(|v| v * v).sum::<f64>() / speeds.len().max(1) as f64).sqrt()
    }
    /// True if the pelvis is as low or as tilted as that of a robot that lies.
    pub fn lies(&self) -> bool {
        let base = &self.truth().bodies[0];
        fallen(base.pos.z(), base.rot.0[2][2], self.player.spec.nominal_height_m)
    }
    /// Torques of the joints in the last step, model order `[N m]`.
    pub fn torque(&self) -> &[f64] {
        &self.torque
    }
    /// The command in force.
    pub fn command(&self) -> &LowCmd {
        &self.command
    }
    /// True once it has stopped by itself for lack of commands.
    pub fn timed_out(&self) -> bool {
        self.command_us.is_some_and(|at| self.now_us - at >= self.timeout_us)
    }
    /// Commands with a wrong length or checksum.
    pub fn refused(&self) -> u64 {
        self.refused
    }
    /// The remote's bytes from now on, see [`Remote::pressing`].
    pub fn set_remote(&mut self, bytes: [u8; 40]) {
        self.remote = bytes;
    }
    /// Charge of the battery in percent, 80 at first.
    pub fn set_battery(&mut self, percent: f64) {
        self.battery = percent;
    }
    /// Takes the robot by the gantry where it is, or lets it go.
    pub fn set_mount(&mut self, mount: Mount) {
        let state = self.sim.save_lane(0, 0);
        self.held = (state.base_pos, state.base_quat);
        self.mount = mount;
        self.holds_us = None;
    }
    /// What holds the pelvis.
    pub fn mount(&self) -> Mount {
        self.mount
    }
    /// Injects a fault, or ends it.
    pub fn set_fault(&mut self, fault: Option<Fault>) {
        self.fault = fault;
        self.fault_us = self.now_us;
        match fault {
            Some(Fault::Tilt) => self.set_mount(Mount::Gantry { pitch_rad_s: 2.0 }),
            Some(Fault::Spin) => self.set_mount(Mount::Gantry { pitch_rad_s: 8.0 }),
            _ => {}
        }
    }
    /// Places the ball, center (x, y) in the world `[m]`; it rolls at `velocity` `[m/s]`.
    pub fn place_ball(&mut self, [x, y]: [f64; 2], [vx, vy]: [f64; 2]) {
        let r = self.player.play.ball_params.radius_m;
        self.sim.set_ball(0, 0, [x, y, r], [vx, vy, 0.0], [-vy / r, vx / r, 0.0]);
    }

    /// Takes in the commands that have come. Those with a wrong checksum are ignored, as the vendor's robot does.
    ///
    /// # Errors
    /// If the link fails.
    pub fn receive(&mut self, link: &mut (impl Inlet + ?Sized)) -> Result<(), TwinError> {
        loop {
            match link.receive() {
                Ok(Some(Packet::LowCmd(bytes))) => match LowCmd::from_cdr(&bytes) {
                    Ok(command) if command.crc == command.expected_crc() => {
                        self.command = command;
                        self.command_us = Some(self.now_us);
                    }
                    _ => self.refused += 1,
                },
                Ok(Some(_)) => {}
                Ok(None) => return Ok(()),
                // There are no commands any more.
                Err(LinkError::Closed) => return Ok(()),
                Err(error) => return Err(error.into()),
            }
        }
    }

    /// Two milliseconds of physics.
    pub fn step(&mut self) {
        let timed_out = self.timed_out();
        let (q, v) = (self.sim.world(0).qpos(), self.sim.world(0).qvel());
        for (j, torque) in self.torque.iter_mut().enumerate() {
            let motor = &self.command.motors[self.player.motors[j]];
            let (angle, speed) = (q[FREE[0] + j], v[FREE[1] + j]);
            let wanted = if timed_out {
                -3.0 * speed
            } else if motor.mode == 1 {
                let [q, dq, kp, kd, tau] = [motor.q, motor.dq, motor.kp, motor.kd, motor.tau].map(f64::from);
                kp * (q - angle) + kd * (dq - speed) + tau
            } else {
                0.0
            };
            let effort = self.player.model.joints[j].effort_limit;
            *torque = if wanted.is_finite() { wanted.clamp(-effort, effort) } else { 0.0 };
        }
        let world = self.sim.world_mut(0);
        world.ctrl_mut().copy_from_slice(&self.torque);
        world.step();
        self.now_us += STEP_US;
        let held = match self.mount {
            Mount::Free => None,
            Mount::Gantry { pitch_rad_s } => Some(pitch_rad_s),
            Mount::Hands => Some(0.0),
        };
        if let Some(pitch_rad_s) = held {
            let turn = Quat::from_axis_angle(Vec3([0.0, 1.0, 0.0]), pitch_rad_s * STEP_US as f64 * 1e-6);
            self.held.1 = Quat(self.held.1).mul(turn).normalize().0;
            let world = self.sim.world_mut(0);
            let q = world.qpos_mut();
            q[..3].copy_from_slice(&self.held.0);
            q[3..7].copy_from_slice(&self.held.1);
            let v = world.qvel_mut();
            v[..6].copy_from_slice(&[0.0, 0.0, 0.0, 0.0, pitch_rad_s, 0.0]);
        }
        self.sim.refresh(0);
        if self.mount == Mount::Hands {
            self.let_go();
        }
    }

    /// Hands let go once the joints hold the pose.
    fn let_go(&mut self) {
        let (joints, command) = (&self.truth().joint_pos, &self.command);
        let holds = !self.timed_out()
            && self.player.motors.iter().zip(joints).all(|(&m, q)| {
                let motor = &command.motors[m];
                motor.mode == 1 && motor.kp > 0.0 && (f64::from(motor.q) - q).abs() < HOLDS_RAD
            });
        let now_us = self.now_us;
        self.holds_us = if holds { self.holds_us.or(Some(now_us)) } else { None };
        if self.holds_us.is_some_and(|since| now_us - since >= HOLDS_US) {
            self.set_mount(Mount::Free);
        }
    }

    /// Velocity of the inertial sensor, world axes `[m/s]`.
    fn imu_velocity(&self) -> Vec3<f64> {
        let base = &self.truth().bodies[0];
        base.ang_vel.cross_add(base.rot.mul_vec(Vec3(IMU)), base.lin_vel)
    }

    /// The robot's state message now, with its faults.
    pub fn low_state(&mut self) -> LowState {
        let velocity = self.imu_velocity();
        let rate = 1e6 / STEP_US as f64;
        let acceleration = (velocity - self.imu_vel).scale(rate) + Vec3([0.0, 0.0, 9.81]);
        self.imu_vel = velocity;
        let truth = self.truth();
        let base = &truth.bodies[0];
        let quaternion = quaternion(&base.rot);
        let f32s = |v: Vec3<f64>| v.0.map(|x| x as f32);
        let mut state = LowState {
            mode_machine: self.player.mode_machine,
            tick: (self.now_us / 1000) as u32,
            wireless_remote: self.remote,
            ..LowState::default()
        };
        state.imu.quaternion = quaternion.map(|x| x as f32);
        state.imu.gyroscope = f32s(base.rot.tr_mul_vec(base.ang_vel));
        state.imu.accelerometer = f32s(base.rot.tr_mul_vec(acceleration));
        let r = &base.rot.0;
        state.imu.rpy = [r[2][1].atan2(r[2][2]), -r[2][0].clamp(-1.0, 1.0).asin(), r[1][0].atan2(r[0][0])]
            .map(|x| x as f32);
        state.imu.temperature = 40;
        for (j, &m) in self.player.motors.iter().enumerate() {
            let motor = &mut state.motors[m];
            motor.mode = self.command.motors[m].mode;
            motor.q = truth.joint_pos[j] as f32;
            motor.dq = truth.joint_vel[j] as f32;
            motor.tau_est = self.torque[j] as f32;
            motor.temperature = [45, 50];
            motor.vol = 54.0;
        }
        if let Some(fault) = self.fault {
            fault.tamper(&mut state, self.fault_us);
        }
        let mut state = state.sealed();
        if self.fault == Some(Fault::Checksum) {
            state.crc ^= 1;
        }
        state
    }

    /// Sends the state, and now and then the battery's charge, unless a fault keeps the robot silent.
    ///
    /// # Errors
    /// If the link fails.
    pub fn publish(&mut self, link: &mut (impl Outlet + ?Sized)) -> Result<(), TwinError> {
        let state = self.low_state();
        if self.fault == Some(Fault::Silence) {
            return Ok(());
        }
        if self.fault == Some(Fault::OthersCommand) {
            link.send(Packet::OthersCommand)?;
        }
        link.send(Packet::LowState(state.to_cdr()))?;
        if self.now_us.is_multiple_of(BATTERY_US) {
            link.send(Packet::Battery(self.battery))?;
        }
        Ok(())
    }
}
