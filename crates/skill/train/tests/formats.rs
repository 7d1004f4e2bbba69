//! Files of earlier and later programs: what still can be read is read, and the rest gets one clear sentence.

use std::fs;
use std::path::{Path, PathBuf};

use paid_onnx::OnnxPolicy;
use paid_policy::Checkpoint;
use paid_train::{RunPreset, TrainedPolicy};

fn sample(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/samples").join(name)
}

#[test]
fn a_policy_of_the_first_format_acts_as_its_onnx_file_does() {
    let trained = TrainedPolicy::load(&sample("policy.safetensors")).expect("reads");
    assert_eq!((trained.preset.stage.as_str(), trained.preset.task.rewards.speed.weight), ("stage2", 24.0));
    let file = OnnxPolicy::load(&sample("policy.onnx")).expect("reads");
    let obs: Vec<f32> = (0..trained.policy.obs_dim()).map(|k| (k as f32 * 0.7).sin()).collect();
    let mut expected = vec![0.0; trained.policy.action_dim()];
    trained.policy.act(&obs, &mut trained.policy.start(1), &mut expected);
    let found = file.act(&obs, &mut file.initial_state()).expect("acts");
    assert!(expected.iter().zip(&found).all(|(a, b)| (a - b).abs() < 1e-5), "{expected:?} {found:?}");
    assert!(expected.iter().any(|action| *action != 0.0));
}

#[test]
fn a_checkpoint_of_the_first_format_is_read_with_the_values_of_its_phase() {
    let checkpoint = Checkpoint::load(&sample("model_1.safetensors")).expect("reads");
    let preset = RunPreset::of_checkpoint(&checkpoint).expect("has a preset");
    assert_eq!((preset.task.observations.critic.len(), preset.task.hold_s), (1, [0.0, 0.0]));
    let policy = checkpoint.policy().expect("has a policy");
    assert_eq!((policy.obs_dim(), policy.action_dim()), (29, 29));
}

#[test]
fn the_preset_of_a_run_folder_of_the_first_format_is_read_with_its_phases() {
    let folder = tempfile::tempdir().expect("folder");
    fs::copy(sample("preset.toml"), folder.path().join("preset.toml")).expect("copies");
    let preset = RunPreset::of_run(folder.path(), &[]).expect("reads");
    assert_eq!((preset.phases.len(), preset.task.scene.substeps), (3, 4));
    assert_eq!(preset.in_phase(3).expect("valid").task.scene.substeps, 8);
}

#[test]
fn damaged_files_get_one_sentence_each() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("model_1.safetensors");
    let whole = fs::read(sample("model_1.safetensors")).expect("reads");
    let middle = whole.len() / 2;
    for (bytes, part) in [
        (whole[..middle].to_vec(), "not a checkpoint"),
        (vec![0x5a; middle], "not a checkpoint"),
        (Vec::new(), "not a checkpoint"),
    ] {
        fs::write(&path, bytes).expect("writes");
        let error = TrainedPolicy::load(&path).expect_err("damaged").to_string();
        assert!(error.contains(part) && error.lines().count() == 1, "{error}");
    }
}

#[test]
fn a_checkpoint_of_a_later_format_is_read_if_this_program_knows_all_of_it() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("model_1.safetensors");
    let load = |version: &str| {
        let mut file = Checkpoint::load(&sample("model_1.safetensors")).expect("reads").tensors().clone();
        let meta = file.metadata["paid"].replacen("\"version\":1", version, 1);
        file.metadata.insert("paid".to_owned(), meta);
        file.path.clone_from(&path);
        file.save().expect("writes");
        Checkpoint::load(&path)
    };
    assert_eq!(load("\"version\":2").expect("nothing new").meta().policy_obs, 29);
    let error = load("\"version\":2,\"wings\":4").expect_err("new").to_string();
    let expected = "it has format 2, which is newer than this program's format 1, and cannot be read (unknown field `wings`";
    assert!(error.contains(expected), "{error}");
}
