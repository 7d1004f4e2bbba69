//! The public TWIST2 tracker (amazon-far/TWIST2, MIT) as a peer: its interface, as its repository publishes it.
//!
//! Input 1432 numbers: now (127), the ten observations before it, oldest first (1270), the motion block again (35). The 127
//! are the motion block, of the reference one step ahead (root velocity x, y in its own frame; root height; roll, pitch; yaw
//! rate in its own frame; 29 joints), and proprioception (0.25 angular velocity; roll, pitch; joints minus default; 0.05 joint
//! velocities, ankles zero; last raw action). Joints are in depth-first order. Target = default + 0.5 clip(action, +-10).

use std::collections::VecDeque;
use std::sync::Arc;

use paid_lanes::{Quat, Vec3};
use paid_onnx::{OnnxFile, RawModel};
use paid_play::ReferenceLibrary;
use paid_robot::{ControlSpec, Permutation, RobotModel, RobotSpec};
use paid_task::EnvSample;

use super::{Driver, DriverInput, Gains};
use crate::EvalError;

const JOINTS: usize = 29;
const MOTION: usize = 6 + JOINTS;
const NOW: usize = MOTION + 5 + 3 * JOINTS;
const HISTORY: usize = 10;
const INPUT: usize = NOW * (1 + HISTORY) + MOTION;
const ACTION_CLIP: f32 = 10.0;
const ACTION_SCALE: f64 = 0.5;

/// Default angles `[rad]`, stiffness `[N m/rad]`, damping `[N m s/rad]` and torque limits `[N m]` of a leg, of the waist, and of an arm. The
/// limits are those of its published controller; where the robot's own are lower, these hold.
const LEG: [[f64; 6]; 4] = [
    [-0.2, 0.0, 0.0, 0.4, -0.2, 0.0],
    [100.0, 100.0, 100.0, 150.0, 40.0, 40.0],
    [2.0, 2.0, 2.0, 4.0, 2.0, 2.0],
    [100.0, 100.0, 100.0, 150.0, 40.0, 40.0],
];
const WAIST: [[f64; 3]; 4] = [[0.0; 3], [150.0; 3], [4.0; 3], [150.0; 3]];
const ARM: [[f64; 7]; 4] = [
    [0.0, 0.4, 0.0, 1.2, 0.0, 0.0, 0.0],
    [40.0, 40.0, 40.0, 40.0, 4.0, 4.0, 4.0],
    [5.0, 5.0, 5.0, 5.0, 0.2, 0.2, 0.2],
    [40.0, 40.0, 40.0, 40.0, 4.0, 4.0, 4.0],
];
/// Ankle joints, whose velocities it does not see.
const ANKLES: [usize; 4] = [4, 5, 10, 11];

/// Row `k` of the tables over all joints; shoulder roll (the second of an arm) is mirrored in the default pose.
fn joints(k: usize) -> Vec<f64> {
    let mut right = ARM[k];
    if k == 0 {
        right[1] = -right[1];
    }
    [&LEG[k][..], &LEG[k], &WAIST[k], &ARM[k], &right].concat()
}

/// Runs the tracker.
#[derive(Clone, Debug)]
pub struct Twist2 {
    model: Arc<RawModel>,
    library: Arc<ReferenceLibrary>,
    default: Vec<f64>,
    /// The task's joint (policy order), default angle and action scale of each joint in model order.
    task: Vec<(usize, f64, f64)>,
    memory: Vec<Memory>,
}

/// What it remembers of one robot.
#[derive(Clone, Debug)]
struct Memory {
    history: VecDeque<Vec<f32>>,
    last_action: Vec<f32>,
}

/// Roll and pitch (about x, then y, then z fixed axes) of an orientation `[rad]`.
fn roll_pitch([w, x, y, z]: [f64; 4]) -> [f64; 2] {
    let roll = (2.0 * (w * x + y * z)).atan2(1.0 - 2.0 * (x * x + y * y));
    let pitch = (2.0 * (w * y - z * x)).clamp(-1.0, 1.0).asin();
    [roll, pitch]
}

impl Twist2 {
    /// True if a file has the tracker's interface.
    pub fn fits(file: &OnnxFile) -> bool {
        file.width("input") == Some(INPUT) && file.width("output") == Some(JOINTS)
    }

    /// Its joint control.
    pub fn gains() -> Gains {
        Gains { stiffness: joints(1), damping: joints(2), effort: Some(joints(3)) }
    }

    /// The tracker for a robot with 29 joints in depth-first order and its motions; robot and spec have its joint control already.
    ///
    /// # Errors
    /// If the file has another interface or the robot other joints.
    pub fn new(
        file: OnnxFile,
        library: Arc<ReferenceLibrary>,
        robot: &RobotModel,
        spec: &RobotSpec,
    ) -> Result<Self, EvalError> {
        let wrong = |e: &dyn std::fmt::Display| EvalError::Policy(e.to_string());
        if !Self::fits(&file) {
            return Err(EvalError::Policy(format!(
                "{}: expected input 'input' of {INPUT} and output 'output' of {JOINTS} numbers (TWIST2), found {:?} and {:?}",
                file.path().display(),
                file.width("input"),
                file.width("output")
            )));
        }
        if robot.joints.len() != JOINTS {
            return Err(EvalError::Policy(format!(
                "TWIST2: expected {JOINTS} joints, found {}",
                robot.joints.len()
            )));
        }
        let control: ControlSpec = spec.resolve(robot).map_err(|e| wrong(&e))?;
        let order =
            Permutation::between(&spec.policy_joint_order, &robot.joint_names()).map_err(|e| wrong(&e))?;
        let task = order.indices().iter().enumerate();
        let task = task.map(|(m, &p)| (p, control.default_pos[m], control.action_scale[m])).collect();
        let model = Arc::new(RawModel::new(file).map_err(|e| wrong(&e))?);
        Ok(Self { model, library, default: joints(0), task, memory: Vec::new() })
    }

    /// The motion block: the reference at `frame`.
    fn motion(&self, motion: usize, frame: usize) -> Vec<f32> {
        let clip = &self.library.clips()[motion];
        let t = frame.min(clip.frames - 1);
        let row = t * (clip.body_pos.len() / clip.frames);
        let quat = Quat(clip.body_quat[row]);
        let turn = Vec3(clip.body_ang_vel[row]);
        // The center of mass's velocity, as motion files store it: measured to track better than the origin's.
        let velocity = quat.conj().rotate(Vec3(clip.body_com_vel[row])).0;
        let yaw_rate = quat.conj().rotate(turn).0[2];
        let [roll, pitch] = roll_pitch(clip.body_quat[row]);
        let mut block = vec![velocity[0], velocity[1], clip.body_pos[row][2], roll, pitch, yaw_rate];
        block.extend(&clip.joint_pos[t * JOINTS..(t + 1) * JOINTS]);
        block.into_iter().map(|x| x as f32).collect()
    }

    /// Proprioception.
    fn proprioception(&self, sample: &EnvSample, last_action: &[f32]) -> Vec<f32> {
        let base = &sample.bodies[0];
        let r = base.rot;
        let local = |k: usize| (0..3).map(|i| r[i][k] * base.ang_vel[i]).sum::<f64>();
        // The same angles from the rotation matrix: roll about x, pitch about y.
        let (roll, pitch) = (r[2][1].atan2(r[2][2]), (-r[2][0]).clamp(-1.0, 1.0).asin());
        let mut out: Vec<f64> = (0..3).map(|k| 0.25 * local(k)).collect();
        out.extend([roll, pitch]);
        out.extend(sample.joint_pos.iter().zip(&self.default).map(|(q, q0)| q - q0));
        out.extend(sample.joint_vel.iter().enumerate().map(
            |(j, v)| {
                if ANKLES.contains(&j) { 0.0 } else { 0.05 * v }
            },
        ));
        out.into_iter().map(|x| x as f32).chain(last_action.iter().copied()).collect()
    }
}

impl Driver for Twist2 {
    fn obs_dim(&self) -> Option<usize> {
        None
    }
    fn action_dim(&self) -> usize {
        JOINTS
    }
    fn begin(&mut self, envs: usize) {
        let fresh = Memory {
            history: std::iter::repeat_n(vec![0.0; NOW], HISTORY).collect(),
            last_action: vec![0.0; JOINTS],
        };
        self.memory = vec![fresh; envs];
    }
    fn act(&mut self, seen: DriverInput<'_>, actions: &mut [f32]) -> Result<(), EvalError> {
        for env in 0..seen.envs {
            let sample = seen.world.sample(env)?;
            let motion = self.motion(sample.motion, sample.frame + 1);
            let now = [&motion[..], &self.proprioception(&sample, &self.memory[env].last_action)].concat();
            let memory = &mut self.memory[env];
            let history = memory.history.iter().flatten().copied();
            let input: Vec<f32> = now.iter().copied().chain(history).chain(motion).collect();
            let out = self
                .model
                .run(&[("input", vec![1, INPUT], &input)], &[("output", JOINTS)])
                .map_err(|e| EvalError::Policy(e.to_string()))?;
            memory.history.pop_front();
            memory.history.push_back(now);
            memory.last_action = out.into_iter().next().unwrap_or_default();
            for (m, &(p, default, scale)) in self.task.iter().enumerate() {
                let raw = memory.last_action[m].clamp(-ACTION_CLIP, ACTION_CLIP);
                let target = self.default[m] + ACTION_SCALE * f64::from(raw);
                actions[p * seen.envs + env] = ((target - default) / scale) as f32;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tables_cover_every_joint_and_mirror_the_shoulders() {
        for k in 0..4 {
            assert_eq!(joints(k).len(), JOINTS);
        }
        let default = joints(0);
        assert_eq!((default[16], default[23]), (0.4, -0.4));
        assert_eq!((joints(1)[3], joints(1)[12], joints(2)[28]), (150.0, 150.0, 0.2));
        assert_eq!((NOW, INPUT), (127, 1432));
    }

    #[test]
    fn roll_and_pitch_of_known_turns() {
        let about = |axis: usize, angle: f64| {
            let mut q = [(0.5 * angle).cos(), 0.0, 0.0, 0.0];
            q[1 + axis] = (0.5 * angle).sin();
            q
        };
        let near = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).abs() + (a[1] - b[1]).abs() < 1e-12;
        assert!(near(roll_pitch(about(0, 0.3)), [0.3, 0.0]));
        assert!(near(roll_pitch(about(1, -0.4)), [0.0, -0.4]));
        assert!(near(roll_pitch(about(2, 1.0)), [0.0, 0.0]));
    }
}
