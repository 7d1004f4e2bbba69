//! Trained policies as files: weights, contract, preset and, on request, a reference in one ONNX file, which is read back to the same policy.

use std::path::{Path, PathBuf};

use paid_motion::Clip;
use paid_onnx::{
    Contract, DenseLayer, LstmLayer, NormalizerWeights, OnnxError, OnnxFile, PolicyWeights, Reference,
    StoredPolicy, Training,
};
use paid_play::{NO_PRESET, PRESET_FILE, PolicyFile, is_onnx, policy_contract};
use paid_policy::{Checkpoint, Policy};
use paid_robot::{Permutation, RobotModel, RobotSpec};

use crate::policy_weights::load_weights;
use crate::{RunPreset, TrainError};

/// Terms of a policy unless others are given.
pub const LICENSE: &str = "the terms of the motions that the policy was trained on";

/// A policy and everything that its file says about it.
#[derive(Clone, Debug)]
pub struct TrainedPolicy {
    /// The checkpoint or policy file.
    pub checkpoint: PathBuf,
    /// Stage and checkpoint that it comes from, without the folder, which only this machine has.
    pub run: String,
    /// The run's resolved preset.
    pub preset: RunPreset,
    /// Tree, limits.
    pub model: RobotModel,
    /// Gains and names.
    pub spec: RobotSpec,
    /// Networks and normalizer.
    pub policy: Policy,
}

impl TrainedPolicy {
    /// Reads a policy file, a checkpoint, or the policy of a run folder ([`load_weights`]).
    ///
    /// # Errors
    /// If there is none, it is damaged, holds no preset, or its sizes are not those of its preset's robot.
    pub fn load(path: &Path) -> Result<Self, TrainError> {
        if !is_onnx(path) {
            return Self::of(&load_weights(path)?);
        }
        Self::stored(&OnnxFile::read(path).map_err(unread)?)?
            .ok_or_else(|| TrainError::Checkpoint { path: path.to_owned(), message: NO_PRESET.to_owned() })
    }

    /// The policy in an ONNX file; `None` if it holds no preset: another program's file, or one of this program's first format.
    ///
    /// # Errors
    /// If it is damaged, its preset turns on what this program does not have, or its sizes are not those of its preset's robot.
    pub fn stored(file: &OnnxFile) -> Result<Option<Self>, TrainError> {
        let Some(StoredPolicy { preset, run, policy, .. }) = file.stored().map_err(unread)? else {
            return Ok(None);
        };
        let path = file.path().to_owned();
        let preset = RunPreset::from_resolved(PRESET_FILE, &preset, &[])
            .map_err(|error| TrainError::Checkpoint { path: path.clone(), message: error.to_string() })?;
        Self::new(path, run, preset, policy).map(Some)
    }

    /// The policy in a checkpoint.
    ///
    /// # Errors
    /// If it holds no preset, or its sizes are not those of its preset's robot.
    pub fn of(checkpoint: &Checkpoint) -> Result<Self, TrainError> {
        let preset = RunPreset::of_checkpoint(checkpoint)?;
        let path = checkpoint.path().to_owned();
        let run = run_name(&preset, &path);
        Self::new(path, run, preset, checkpoint.policy()?)
    }

    fn new(path: PathBuf, run: String, preset: RunPreset, policy: Policy) -> Result<Self, TrainError> {
        let (motions, play) = (preset.run.motions.clone(), preset.task.play_preset());
        let PolicyFile { path, model, spec, policy, .. } =
            PolicyFile::new(path, &preset.robot, motions, play, policy)?;
        Ok(Self { checkpoint: path, run, preset, model, spec, policy })
    }

    /// The contract of the policy's file; `license` are the terms of the motions that it was trained on.
    ///
    /// # Errors
    /// If the robot's gains cannot be resolved.
    pub fn contract(&self, license: &str) -> Result<Contract, TrainError> {
        let play = self.preset.task.play_preset();
        Ok(policy_contract(&self.model, &self.spec, &play, &self.policy, license)?)
    }

    /// Writes the policy file: graph, contract and preset, with `clip` inside if given. The clip must be at the control rate. Nothing
    /// else in the file comes from the motions; of their folder it names the last part only, because a path is of no use on another machine.
    ///
    /// # Errors
    /// If the file cannot be written, or something does not fit; an earlier file stays whole.
    pub fn write_onnx(&self, path: &Path, license: &str, clip: Option<&Clip>) -> Result<(), TrainError> {
        let mut contract = self.contract(license)?;
        let reference = clip.map(|clip| self.reference(clip)).transpose()?;
        contract.reference = reference.as_ref().map(|r| r.name.clone());
        let mut weights = weights(&self.policy);
        let task = &self.preset.task;
        if task.mirror_left_kicks {
            let mirrors = paid_play::policy_mirrors(&self.model, &self.spec, &task.observations.policy);
            weights.mirror = Some(mirrors.map_err(TrainError::Setup)?);
        }
        let preset = self.preset.without_paths().to_toml()?;
        let training = Training { preset, std: self.policy.std.clone() };
        paid_onnx::write(path, &weights, &contract, reference.as_ref(), &self.run, Some(&training))
            .map_err(unread)
    }

    /// A clip (model order) in the file's orders: policy joints, tracked bodies.
    fn reference(&self, clip: &Clip) -> Result<Reference, TrainError> {
        let rate = 1.0 / self.preset.task.control_dt_s();
        if (clip.fps - rate).abs() > 1e-6 * rate {
            return Err(TrainError::Setup(format!(
                "motion '{}': expected {rate} frames a second, found {}",
                clip.name, clip.fps
            )));
        }
        let joints = Permutation::between(&self.model.joint_names(), &self.spec.policy_joint_order)
            .map_err(|e| TrainError::Setup(e.to_string()))?;
        let body = |name: &String| {
            let missing = || TrainError::Setup(format!("the robot has no tracked body '{name}'"));
            self.model.body_index(name).ok_or_else(missing)
        };
        let bodies = self.spec.tracked_bodies.iter().map(body).collect::<Result<Vec<_>, _>>()?;
        let over_joints = |rows: &[f64]| -> Vec<f32> {
            let rows = rows.chunks(clip.joints);
            rows.flat_map(|row| joints.indices().iter().map(|&j| row[j] as f32)).collect()
        };
        Ok(Reference {
            name: clip.name.clone(),
            frames: clip.frames,
            joint_pos: over_joints(&clip.joint_pos),
            joint_vel: over_joints(&clip.joint_vel),
            body_pos_w: over_bodies(&clip.body_pos, clip.bodies, &bodies),
            body_quat_w: over_bodies(&clip.body_quat, clip.bodies, &bodies),
            body_lin_vel_w: over_bodies(&clip.body_lin_vel, clip.bodies, &bodies),
            body_ang_vel_w: over_bodies(&clip.body_ang_vel, clip.bodies, &bodies),
        })
    }
}

/// Where a policy comes from: stage and checkpoint.
pub(crate) fn run_name(preset: &RunPreset, checkpoint: &Path) -> String {
    let stem = checkpoint.file_stem().unwrap_or_default().to_string_lossy();
    format!("{} {stem}", preset.stage).replace(['/', '\\'], "-")
}

/// An error that names its file.
pub(crate) fn unread(error: OnnxError) -> TrainError {
    TrainError::Setup(error.to_string())
}

/// Chosen bodies of every frame, flattened.
fn over_bodies<const N: usize>(rows: &[[f64; N]], per_frame: usize, chosen: &[usize]) -> Vec<f32> {
    let frames = rows.chunks(per_frame);
    frames.flat_map(|f| chosen.iter().flat_map(|&b| f[b].iter().map(|&x| x as f32))).collect()
}

/// The policy's numbers without their layout.
pub fn weights(policy: &Policy) -> PolicyWeights {
    let part = |range: &core::ops::Range<usize>| policy.params[range.clone()].to_vec();
    let normalizer = &policy.normalizer;
    PolicyWeights {
        normalizer: Some(NormalizerWeights {
            mean: normalizer.mean().to_vec(),
            scale: normalizer.inv_std().to_vec(),
            clip: None,
        }),
        lstm: (policy.net.lstm.iter())
            .map(|l| LstmLayer {
                inputs: l.input,
                hidden: l.size,
                w_input: part(&l.weight_ih),
                w_hidden: part(&l.weight_hh),
                bias: part(&l.bias),
            })
            .collect(),
        layers: (policy.net.mlp.iter())
            .map(|l| DenseLayer { inputs: l.input, outputs: l.output, w: part(&l.weight), b: part(&l.bias) })
            .collect(),
        mirror: None,
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use paid_lanes::rng::Rng;
    use paid_onnx::OnnxPolicy;
    use paid_play::ShownAfterStrike;
    use paid_policy::net::Network;
    use paid_policy::normalizer::{Moments, Normalizer};
    use paid_policy::{
        Dimensions, LstmConfig, NetworkConfig, NetworkKind, ObservationTerms, PlayContract, WhereItLay,
    };

    use super::*;

    /// A policy with random weights and statistics for the built-in robot.
    pub(crate) fn trained(kind: NetworkKind) -> TrainedPolicy {
        let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
        let mut rng = Rng::new(5, 0, 0);
        let preset = RunPreset::resolve("stage1", &[]).expect("built in");
        let terms = ObservationTerms::new(&preset.task.observations.policy, Dimensions::of(&spec));
        let features = terms.dim();
        let mut draw = |lo: f64, hi: f64| (0..features).map(|_| rng.uniform(lo, hi)).collect::<Vec<_>>();
        let moments = Moments { count: 50.0, mean: draw(-1.0, 1.0), m2: draw(1.0, 99.0) };
        let inputs = if kind == NetworkKind::Memory { 15 } else { 0 };
        let config = NetworkConfig {
            kind,
            hidden: vec![40, 24],
            lstm: LstmConfig { layers: 2, size: 16, inputs },
            ..NetworkConfig::default()
        };
        let net = Network::new(features, spec.policy_joint_order.len(), &config);
        let mut params = net.initialize(&mut Rng::new(6, 0, 0));
        // A memory that weighs something.
        params.iter_mut().filter(|x| **x == 0.0).for_each(|x| *x = rng.uniform(-0.1, 0.1) as f32);
        let std = vec![0.4; net.output];
        let policy = Policy { net, params, normalizer: Normalizer::from_moments(moments), std };
        let checkpoint = PathBuf::from("/home/someone/runs/x/model_10.safetensors");
        TrainedPolicy { run: run_name(&preset, &checkpoint), checkpoint, preset, model, spec, policy }
    }

    #[test]
    fn an_exported_policy_acts_as_the_learners_does() {
        let folder = tempfile::tempdir().expect("folder");
        for kind in [NetworkKind::Mlp, NetworkKind::Lstm, NetworkKind::Memory] {
            let trained = trained(kind);
            let path = folder.path().join("policy.onnx");
            trained.write_onnx(&path, "none", None).expect("writes");
            let contract = trained.contract("none").expect("contract");
            let file = OnnxPolicy::load_expecting(&path, &contract).expect("reads");
            assert!(file.reference(0).expect("none").is_empty());
            let (mut ours, mut theirs) = (trained.policy.start(1), file.initial_state());
            let mut rng = Rng::new(7, 0, 0);
            let mut expected = vec![0.0; trained.policy.action_dim()];
            for step in 0..10 {
                let obs: Vec<f32> =
                    (0..trained.policy.obs_dim()).map(|_| 2.0 * rng.normal() as f32).collect();
                trained.policy.act(&obs, &mut ours, &mut expected);
                let found = file.act(&obs, &mut theirs).expect("acts");
                for (a, b) in expected.iter().zip(&found) {
                    assert!((a - b).abs() < 1e-5, "{kind:?} step {step}: {a} {b}");
                }
            }
            assert!(expected.iter().any(|x| x.abs() > 1e-3));
            // No path of this machine leaves with the policy.
            assert_eq!(file.metadata("run_path"), Some("stage1 model_10"));
        }
    }

    #[test]
    fn a_policy_file_is_read_back_to_the_same_numbers() {
        let folder = tempfile::tempdir().expect("folder");
        for kind in [NetworkKind::Mlp, NetworkKind::Lstm, NetworkKind::Memory] {
            let mut trained = trained(kind);
            trained.preset.run.motions = "/home/someone/kicks".to_owned();
            trained.policy.std[3] = 0.123_456_79;
            let path = folder.path().join("policy.onnx");
            trained.write_onnx(&path, "none", None).expect("writes");
            let read = TrainedPolicy::load(&path).expect("reads");
            assert_eq!((&read.checkpoint, &read.run), (&path, &trained.run));
            assert_eq!(read.preset, trained.preset.without_paths());
            assert_eq!(read.preset.run.motions, "kicks");
            let numbers = |policy: &Policy| {
                let normalizer = [policy.normalizer.mean(), policy.normalizer.inv_std()].concat();
                [&policy.params, &normalizer, &policy.std]
                    .map(|x| x.iter().map(|x| x.to_bits()).collect::<Vec<_>>())
            };
            assert_eq!(numbers(&read.policy), numbers(&trained.policy), "{kind:?}");
            assert_eq!(read.policy.net.layout(), trained.policy.net.layout());
            // Written again it is the same file.
            let bytes = std::fs::read(&path).expect("reads");
            read.write_onnx(&path, "none", None).expect("writes");
            assert!(std::fs::read(&path).expect("reads") == bytes, "{kind:?}");
        }
    }

    #[test]
    fn the_graph_mirrors_where_its_input_says_so() {
        for kind in [NetworkKind::Mlp, NetworkKind::Lstm, NetworkKind::Memory] {
            mirrored_by_the_graph(trained(kind));
        }
    }

    fn mirrored_by_the_graph(mut trained: TrainedPolicy) {
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("policy.onnx");
        trained.write_onnx(&path, "none", None).expect("writes");
        let file = OnnxPolicy::load(&path).expect("reads");
        let error = file.act_in_mirror(&[], &mut file.initial_state()).expect_err("no mirror").to_string();
        assert!(error.contains("mirror: expected a policy that is played in it"), "{error}");
        trained.preset.task.mirror_left_kicks = true;
        trained.write_onnx(&path, "none", None).expect("writes");
        let file = OnnxPolicy::load(&path).expect("reads");
        let terms = &trained.preset.task.observations.policy;
        let mirrors = paid_play::policy_mirrors(&trained.model, &trained.spec, terms).expect("has two sides");
        let mut rng = Rng::new(7, 0, 0);
        let mut room = Vec::new();
        let [mut world, mut image, mut state] =
            [file.initial_state(), file.initial_state(), file.initial_state()];
        for _ in 0..3 {
            let obs: Vec<f32> = (0..trained.policy.obs_dim()).map(|_| 2.0 * rng.normal() as f32).collect();
            let plain = file.act(&obs, &mut world).expect("acts");
            let mut seen = obs.clone();
            mirrors.observation.apply_to_marked(&mut seen, &[true], &mut room);
            let mut expected = file.act(&seen, &mut image).expect("acts");
            mirrors.action.apply_to_marked(&mut expected, &[true], &mut room);
            let found = file.act_in_mirror(&obs, &mut state).expect("acts");
            assert_eq!((&found, &state), (&expected, &image));
            assert_ne!(found, plain);
        }
    }

    #[test]
    fn the_contract_says_how_the_policy_is_played() {
        let mut trained = trained(NetworkKind::Mlp);
        assert_eq!(trained.contract("none").expect("contract").play, None);
        trained.preset.task.mirror_left_kicks = true;
        trained.preset.task.ball.contact_s.insert("kick".to_owned(), 1.25);
        let rule = &mut trained.preset.task.ball.after_strike;
        (rule.show, rule.from_s, rule.captured_s) = (ShownAfterStrike::WhereItLay, 0.3, 0.2);
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("policy.onnx");
        trained.write_onnx(&path, "none", None).expect("writes");
        let contact_s = [("kick".to_owned(), 1.25)].into();
        let where_it_lay = Some(WhereItLay { captured_s: 0.2, from_s: 0.3 });
        let play = PlayContract { contact_s, mirror_left_kicks: true, where_it_lay };
        assert_eq!(OnnxPolicy::load(&path).expect("reads").contract().play, Some(play));
        trained.preset.task.ball.after_strike.from_s = 9.0;
        let error = trained.write_onnx(&path, "none", None).expect_err("no time").to_string();
        assert!(error.contains("play.where_it_lay.from_s is 9, expected 0 to 5 s"), "{error}");
    }

    #[test]
    fn the_contract_names_gains_and_terms_of_the_robot() {
        let contract = trained(NetworkKind::Mlp).contract("none").expect("contract");
        assert_eq!((contract.joints.len(), contract.bodies.len()), (29, 14));
        assert_eq!((contract.observation_size(), contract.control_period_s), (160, 0.02));
        // The public release: the order is breadth-first; hip pitch: armature 0.010177520, 10 Hz, default -0.312 rad.
        let hip = &contract.joints[0];
        let w = 2.0 * core::f64::consts::PI * 10.0;
        assert_eq!((hip.name.as_str(), hip.default_pos), ("left_hip_pitch_joint", -0.312));
        assert!((hip.stiffness - 0.010177520 * w * w).abs() < 1e-6, "{hip:?}");
        assert!((hip.damping - 4.0 * 0.010177520 * w).abs() < 1e-6, "{hip:?}");
        assert!((hip.action_scale * hip.stiffness - 0.25 * 88.0).abs() < 1e-6, "{hip:?}");
        assert_eq!(contract.joints[2].name, "waist_yaw_joint");
    }

    #[test]
    fn an_embedded_clip_is_in_the_files_orders() {
        let trained = trained(NetworkKind::Mlp);
        let (joints, bodies, frames) = (trained.model.joints.len(), trained.model.bodies.len(), 4);
        let per_body = |t: usize, b: usize| [t as f64, b as f64, 0.5];
        let all: Vec<[f64; 3]> = (0..frames).flat_map(|t| (0..bodies).map(move |b| per_body(t, b))).collect();
        let clip = Clip {
            name: "wave".into(),
            path: "wave.npz".into(),
            fps: 50.0,
            kick_leg: paid_motion::KickLeg::Left,
            kick_frame: None,
            license: None,
            frames,
            joints,
            bodies,
            joint_pos: (0..frames * joints).map(|i| i as f64).collect(),
            joint_vel: (0..frames * joints).map(|i| -(i as f64)).collect(),
            body_pos: all.clone(),
            body_quat: vec![[1.0, 0.0, 0.0, 0.0]; frames * bodies],
            body_lin_vel: all.clone(),
            body_ang_vel: all,
        };
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("policy.onnx");
        trained.write_onnx(&path, "none", Some(&clip)).expect("writes");
        let file = OnnxPolicy::load(&path).expect("reads");
        assert_eq!(file.contract().reference.as_deref(), Some("wave"));
        let arrays = file.reference(2).expect("runs");
        for (i, name) in trained.spec.policy_joint_order.iter().enumerate() {
            let j = trained.model.joint_index(name).expect("a joint");
            assert_eq!(arrays[0].1[i], (2 * joints + j) as f32, "{name}");
            assert_eq!(arrays[1].1[i], -((2 * joints + j) as f32), "{name}");
        }
        for (i, name) in trained.spec.tracked_bodies.iter().enumerate() {
            let b = trained.model.body_index(name).expect("a body");
            assert_eq!(arrays[2].1[3 * i..3 * i + 3], [2.0, b as f32, 0.5], "{name}");
        }
        let slow = Clip { fps: 30.0, ..clip };
        let error = trained.write_onnx(&path, "none", Some(&slow)).expect_err("another rate").to_string();
        assert_eq!(error, "motion 'wave': expected 50 frames a second, found 30");
    }
}
