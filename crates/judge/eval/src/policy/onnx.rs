//! Policies from ONNX files, the project's own and those with the released interface.

use std::sync::Arc;

use paid_onnx::{Contract, OnnxPolicy, OnnxState};

use super::{Driver, DriverInput};
use crate::EvalError;

/// Observation terms whose meaning depends on the policy's own conventions.
const RELATIVE_ANGLES: &str = "joint_pos_rel";
const LAST_ACTION: &str = "last_action";

/// Translates between the task's conventions and the file's: joint order, default pose, action scale.
#[derive(Clone, Debug)]
struct Adapter {
    /// Starts of the observation terms over joints.
    joint_terms: Vec<usize>,
    /// Start of the joint angles relative to the default pose.
    relative: Option<usize>,
    /// Start of the last action.
    last_action: Option<usize>,
    /// Task's joint of each of the file's.
    to_task: Vec<usize>,
    /// Task's default angle minus the file's, file order `[rad]`.
    default_shift: Vec<f64>,
    /// Action scales, file order: the file's, the task's `[rad]`.
    scales: Vec<[f64; 2]>,
}

impl Adapter {
    fn new(task: &Contract, file: &Contract) -> Result<Self, EvalError> {
        let wrong = |what: String| EvalError::Policy(what);
        let mut to_task = Vec::new();
        for joint in &file.joints {
            let place = task.joints.iter().position(|j| j.name == joint.name);
            to_task.push(place.ok_or_else(|| wrong(format!("the task has no joint '{}'", joint.name)))?);
        }
        if to_task.len() != task.joints.len() || file.observation_size() != task.observation_size() {
            return Err(wrong("joints or observation of another size than the task's".to_owned()));
        }
        let (mut start, mut joint_terms, mut relative, mut last_action) = (0, Vec::new(), None, None);
        for term in &task.observation {
            if term.order == "joints" {
                joint_terms.push(start);
            }
            match term.name.as_str() {
                RELATIVE_ANGLES => relative = Some(start),
                LAST_ACTION => last_action = Some(start),
                _ => {}
            }
            start += term.size;
        }
        let pairs = || file.joints.iter().zip(to_task.iter().map(|&j| &task.joints[j]));
        if let Some((joint, _)) = pairs().find(|(_, own)| own.action_scale == 0.0) {
            return Err(wrong(format!("the task does not move joint '{}'", joint.name)));
        }
        Ok(Self {
            joint_terms,
            relative,
            last_action,
            default_shift: pairs().map(|(f, t)| t.default_pos - f.default_pos).collect(),
            scales: pairs().map(|(f, t)| [f.action_scale, t.action_scale]).collect(),
            to_task,
        })
    }

    /// The file's observation from the task's (`envs` columns, column `env`).
    fn observation(&self, seen: &DriverInput<'_>, env: usize, last: &[f32], out: &mut [f32]) {
        for (k, value) in out.iter_mut().enumerate() {
            *value = seen.observations[k * seen.envs + env];
        }
        for &start in &self.joint_terms {
            for (i, &j) in self.to_task.iter().enumerate() {
                out[start + i] = seen.observations[(start + j) * seen.envs + env];
            }
        }
        if let Some(start) = self.relative {
            for (value, shift) in out[start..].iter_mut().zip(&self.default_shift) {
                *value += *shift as f32;
            }
        }
        if let Some(start) = self.last_action {
            out[start..start + last.len()].copy_from_slice(last);
        }
    }

    /// The task's action for the file's joint `i`: both mean the same target angle.
    fn action(&self, i: usize, action: f32) -> f32 {
        let [file, task] = self.scales[i];
        // The file's default is the task's minus the shift.
        ((f64::from(action) * file - self.default_shift[i]) / task) as f32
    }
}

/// Runs an ONNX policy, one robot after the other.
#[derive(Clone, Debug)]
pub struct OnnxDriver {
    policy: Arc<OnnxPolicy>,
    adapter: Arc<Adapter>,
    states: Vec<OnnxState>,
    last: Vec<Vec<f32>>,
    observation: Vec<f32>,
}

impl OnnxDriver {
    /// A driver for a task whose observations and actions are those of the contract `task`.
    ///
    /// # Errors
    /// If joints or observation are not the task's.
    pub fn new(policy: Arc<OnnxPolicy>, task: &Contract) -> Result<Self, EvalError> {
        let adapter = Arc::new(Adapter::new(task, policy.contract())?);
        let observation = vec![0.0; task.observation_size()];
        Ok(Self { policy, adapter, states: Vec::new(), last: Vec::new(), observation })
    }
}

impl Driver for OnnxDriver {
    fn obs_dim(&self) -> Option<usize> {
        Some(self.observation.len())
    }
    fn action_dim(&self) -> usize {
        self.adapter.to_task.len()
    }
    fn begin(&mut self, envs: usize) {
        self.states = vec![self.policy.initial_state(); envs];
        self.last = vec![vec![0.0; self.action_dim()]; envs];
    }
    fn forget(&mut self, env: usize) {
        self.states[env].reset();
    }
    fn act(&mut self, seen: DriverInput<'_>, actions: &mut [f32]) -> Result<(), EvalError> {
        for env in 0..seen.envs {
            self.adapter.observation(&seen, env, &self.last[env], &mut self.observation);
            let own = self
                .policy
                .act(&self.observation, &mut self.states[env])
                .map_err(|e| EvalError::Policy(e.to_string()))?;
            for (i, &j) in self.adapter.to_task.iter().enumerate() {
                actions[j * seen.envs + env] = self.adapter.action(i, own[i]);
            }
            self.last[env] = own;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use paid_onnx::{FORMAT, JointContract, ObservationTerm};

    fn contract(joints: &[(&str, f64, f64)]) -> Contract {
        let term = |name: &str, size, order: &str| ObservationTerm {
            name: name.into(),
            size,
            order: order.into(),
            frame: String::new(),
            unit: String::new(),
            scale: 1.0,
        };
        let joint = |&(name, default_pos, action_scale): &(&str, f64, f64)| JointContract {
            name: name.into(),
            default_pos,
            stiffness: 1.0,
            damping: 1.0,
            action_scale,
        };
        Contract {
            format: FORMAT,
            robot: "r".into(),
            mode_machines: Vec::new(),
            license: String::new(),
            control_period_s: 0.02,
            action: String::new(),
            joints: joints.iter().map(joint).collect(),
            anchor_body: "b".into(),
            bodies: vec![],
            observation: vec![
                term("gravity", 1, "x"),
                term(RELATIVE_ANGLES, 2, "joints"),
                term(LAST_ACTION, 2, "joints"),
            ],
            commands: vec![],
            recurrent: None,
            reference: None,
            play: None,
        }
    }

    struct Nothing;
    impl paid_task::EvalControl for Nothing {
        fn set_rules(&mut self, _: paid_task::EpisodeRules) {}
        fn force_start(&mut self, _: usize, _: &paid_task::InitialState) -> Result<(), paid_task::TaskError> {
            Ok(())
        }
        fn next_kick(&mut self, _: usize, _: &paid_task::NextKick) -> Result<(), paid_task::TaskError> {
            Ok(())
        }
        fn show(&mut self, _: usize, _: Option<&paid_task::Shown>) -> Result<(), paid_task::TaskError> {
            Ok(())
        }
        fn disturb(&mut self, _: usize, _: &paid_task::Disturbance) -> Result<(), paid_task::TaskError> {
            Ok(())
        }
        fn ball_spin(&self, _: usize) -> Result<[f64; 3], paid_task::TaskError> {
            Ok([0.0; 3])
        }
        fn believed_ball(&self, _: usize) -> Result<Option<paid_task::BelievedBall>, paid_task::TaskError> {
            Ok(None)
        }
        fn sample(&self, _: usize) -> Result<paid_task::EnvSample, paid_task::TaskError> {
            Err(paid_task::TaskError::Simulator("no world".into()))
        }
    }

    #[test]
    fn angles_and_actions_mean_the_same_in_both_conventions() {
        let task = contract(&[("hip", 0.1, 0.5), ("knee", 0.6, 0.25)]);
        let file = contract(&[("knee", 0.4, 0.1), ("hip", 0.1, 0.5)]);
        let adapter = Adapter::new(&task, &file).expect("the same joints");
        // Two environments; the second one has the hip at 0.3 and the knee at 1.0 rad.
        let columns = [[9.0, 0.0, 0.0, 7.0, 7.0], [8.0, 0.2, 0.4, 7.0, 7.0]];
        let observations: Vec<f32> = (0..5).flat_map(|k| [columns[0][k], columns[1][k]]).collect();
        let seen = DriverInput { observations: &observations, envs: 2, world: &Nothing };
        let mut out = vec![0.0; 5];
        adapter.observation(&seen, 1, &[1.5, -2.0], &mut out);
        // File order is knee, hip; the file's knee default is 0.4: 1.0 - 0.4 = 0.6.
        for (found, expected) in out.iter().zip([8.0, 0.6, 0.2, 1.5, -2.0]) {
            assert!((found - expected).abs() < 1e-6, "{out:?}");
        }
        // Knee: target 0.4 + 0.1 * 3 = 0.7 = 0.6 + 0.25 * 0.4.
        assert!((adapter.action(0, 3.0) - 0.4).abs() < 1e-6);
        assert!((adapter.action(1, 3.0) - 3.0).abs() < 1e-6);
    }

    #[test]
    fn a_joint_that_the_task_lacks_is_named() {
        let task = contract(&[("hip", 0.1, 0.5), ("knee", 0.6, 0.25)]);
        let file = contract(&[("hip", 0.1, 0.5), ("tail", 0.6, 0.25)]);
        let error = Adapter::new(&task, &file).expect_err("no tail").to_string();
        assert!(error.contains("'tail'"), "{error}");
    }
}
