//! A motion of our own and a policy that plays it, for tests without recorded data.

use std::path::Path;
use std::sync::Arc;

use paid_eval::EvalError;
use paid_eval::engine::EngineChoice;
use paid_eval::episodes::EvalSetup;
use paid_eval::monitor::Monitor;
use paid_eval::policy::{Driver, DriverInput};
use paid_lanes::Isa;
use paid_motion::{Clip, KickLeg, MotionLibrary, resample, write_npz};
use paid_play::{ReferenceLibrary, ShownAfterStrike};
use paid_policy::observation::ObservationId;
use paid_robot::{Permutation, RobotModel, RobotSpec};
use paid_task::TaskPreset;
use paid_train::TrainedPolicy;

/// Two seconds in which the robot stands and swings a leg to the front and back in the first of them.
fn swing(kick_leg: KickLeg) -> Clip {
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    let default_pos = spec.resolve(&model).expect("the built-in robot").default_pos;
    let joint = |name: &str| model.joints.iter().position(|j| j.name == format!("{kick_leg}_{name}_joint"));
    let hip = joint("hip_pitch").expect("a hip");
    let (frames, fps) = (60, 30.0);
    let angles = (0..frames).flat_map(|t| {
        let mut angles = default_pos.clone();
        let phase = core::f64::consts::TAU * f64::from(t) / f64::from(frames);
        if 2 * t < frames {
            angles[hip] -= 0.5 * (1.0 - (2.0 * phase).cos());
        }
        angles
    });
    let angles: Vec<f64> = angles.collect();
    let base = vec![([0.0, 0.0, spec.nominal_height_m], [1.0, 0.0, 0.0, 0.0]); frames as usize];
    let clip = Clip::from_poses(&model, fps, &base, &angles);
    let labels = Clip {
        name: format!("swing_{kick_leg}"),
        path: "swing.npz".into(),
        kick_leg,
        license: Some("CC0".to_owned()),
        ..clip
    };
    resample(&labels, &model, 50.0)
}

/// A task over a swing of each leg, on one thread, with arithmetic that every machine has.
pub fn setup(task: &str) -> EvalSetup {
    let (robot, spec) = (RobotModel::g1(), RobotSpec::g1());
    let folder = tempfile::tempdir().expect("a folder");
    for leg in [KickLeg::Left, KickLeg::Right] {
        let clip = swing(leg);
        write_npz(&folder.path().join(format!("{}.npz", clip.name)), &clip, &robot, &spec).expect("writes");
    }
    let motions = MotionLibrary::load(folder.path(), &robot, &spec, 50.0).expect("good motions");
    let library = ReferenceLibrary::from_motions(&motions, &robot, &spec).expect("fits the robot");
    EvalSetup {
        engine: EngineChoice::Builtin,
        isa: Isa::Portable,
        robot,
        spec,
        library: Arc::new(library),
        preset: TaskPreset::builtin(task).expect("built in"),
        threads: 1,
        seed: 5,
        monitor: Monitor::default(),
        ranks: Arc::new(paid_train::Alone),
    }
}

/// The demo policy on the kicks that it was trained on, in the paper's task with the ball shown where it will be.
pub fn demo() -> (EvalSetup, PlainNetwork) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../policies/demo/policy.onnx");
    let network = TrainedPolicy::load(&file).expect("the demo").policy;
    let mut setup = EvalSetup { seed: 3, ..setup("paper_stage2") };
    let motions = MotionLibrary::builtin(&setup.robot, &setup.spec, 50.0).expect("kicks");
    let library = ReferenceLibrary::from_motions(&motions, &setup.robot, &setup.spec).expect("fits");
    setup.library = Arc::new(library);
    // As it was trained: a ball that flies off makes it fall.
    setup.preset.ball.after_strike.show = ShownAfterStrike::WhereItLay;
    for term in &mut setup.preset.observations.policy {
        if *term == ObservationId::BallPos {
            *term = ObservationId::BallAtStrike;
        }
    }
    (setup, PlainNetwork(Arc::new(network)))
}

/// Plays the reference's next joint angles, whatever the robot does.
#[derive(Clone)]
pub struct Puppet {
    library: Arc<ReferenceLibrary>,
    /// The task's joint, default angle and action scale of each joint in model order.
    task: Vec<(usize, f64, f64)>,
    /// A monitor that it stops when it acts.
    pub stop: Option<Monitor>,
}

impl Puppet {
    pub fn new(setup: &EvalSetup) -> Self {
        let control = setup.spec.resolve(&setup.robot).expect("the built-in robot");
        let order = Permutation::between(&setup.spec.policy_joint_order, &setup.robot.joint_names());
        let order = order.expect("the same joints");
        let joints = order.indices().iter().enumerate();
        let task = joints.map(|(m, &p)| (p, control.default_pos[m], control.action_scale[m])).collect();
        Self { library: Arc::clone(&setup.library), task, stop: None }
    }
}

impl Driver for Puppet {
    fn obs_dim(&self) -> Option<usize> {
        None
    }
    fn action_dim(&self) -> usize {
        self.task.len()
    }
    fn begin(&mut self, _envs: usize) {}
    fn act(&mut self, seen: DriverInput<'_>, actions: &mut [f32]) -> Result<(), EvalError> {
        if let Some(monitor) = &self.stop {
            monitor.stop();
        }
        for env in 0..seen.envs {
            let sample = seen.world.sample(env)?;
            let clip = &self.library.clips()[sample.motion];
            let frame = (sample.frame + 1).min(clip.frames - 1);
            for (m, &(p, default, scale)) in self.task.iter().enumerate() {
                let target = clip.joint_pos[frame * self.task.len() + m];
                actions[p * seen.envs + env] = ((target - default) / scale) as f32;
            }
        }
        Ok(())
    }
}

/// A trained network in plain loops: the same actions on every machine, whatever its instruction set.
#[derive(Clone)]
pub struct PlainNetwork(pub Arc<paid_policy::Policy>);

impl PlainNetwork {
    /// The mean action for one observation.
    fn action(&self, observation: impl Iterator<Item = f32>) -> Vec<f64> {
        let Self(policy) = self;
        let normalizer = &policy.normalizer;
        let scales = normalizer.mean().iter().zip(normalizer.inv_std());
        let mut x: Vec<f64> = observation
            .zip(scales)
            .map(|(x, (mean, scale))| (f64::from(x) - f64::from(*mean)) * f64::from(*scale))
            .collect();
        for layer in &policy.net.mlp {
            let weights = policy.params[layer.weight.clone()].chunks(layer.input);
            let biases = &policy.params[layer.bias.clone()];
            x = weights
                .zip(biases)
                .map(|(row, bias)| {
                    let products = row.iter().zip(&x).map(|(w, x)| f64::from(*w) * x);
                    let y = products.sum::<f64>() + f64::from(*bias);
                    if layer.elu && y < 0.0 { y.exp() - 1.0 } else { y }
                })
                .collect();
        }
        x
    }
}

impl Driver for PlainNetwork {
    fn obs_dim(&self) -> Option<usize> {
        Some(self.0.obs_dim())
    }
    fn action_dim(&self) -> usize {
        self.0.action_dim()
    }
    fn begin(&mut self, _envs: usize) {
        assert!(self.0.net.lstm.is_empty(), "a network without memory");
    }
    fn act(&mut self, seen: DriverInput<'_>, actions: &mut [f32]) -> Result<(), EvalError> {
        for env in 0..seen.envs {
            let own = self.action(seen.observations.iter().skip(env).step_by(seen.envs).copied());
            for (k, action) in own.into_iter().enumerate() {
                actions[k * seen.envs + env] = action as f32;
            }
        }
        Ok(())
    }
}
