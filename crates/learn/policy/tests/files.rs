//! Weights from bytes and from paths.

use std::path::Path;

use paid_lanes::rng::Rng;
use paid_policy::checkpoint::{Meta, VERSION};
use paid_policy::net::Network;
use paid_policy::{Checkpoint, LstmConfig, NetworkConfig, NetworkKind, TensorFile};

const OBSERVATIONS: usize = 3;
const ACTIONS: usize = 2;

/// A checkpoint with weights and normalizer of a small recurrent policy.
fn file(path: &Path) -> TensorFile {
    let actor = NetworkConfig {
        kind: NetworkKind::Lstm,
        hidden: vec![5],
        lstm: LstmConfig { layers: 1, size: 4, inputs: 0 },
        ..NetworkConfig::default()
    };
    let net = Network::new(OBSERVATIONS, ACTIONS, &actor);
    let params: Vec<f32> = net.initialize(&mut Rng::new(3, 0, 0));
    let mut file = TensorFile { path: path.to_owned(), ..TensorFile::default() };
    for spec in net.layout().tensors() {
        file.put_f32s(format!("actor.{}", spec.name), &spec.shape, &params[spec.range.clone()]);
    }
    file.put_f32s("actor.log_std", &[ACTIONS], &[-1.0, -2.0]);
    file.put_f64s("normalizer.policy.mean", &[OBSERVATIONS], &[0.5, 0.0, -1.0]);
    file.put_f64s("normalizer.policy.m2", &[OBSERVATIONS], &[1.0, 4.0, 9.0]);
    file.put_f64s("normalizer.policy.count", &[1], &[4.0]);
    let meta = Meta {
        version: VERSION,
        policy_obs: OBSERVATIONS,
        critic_obs: 1,
        actions: ACTIONS,
        actor,
        critic: NetworkConfig::default(),
        iteration: 7,
    };
    let meta = serde_json::to_string(&meta).expect("serializes");
    file.metadata.insert("paid".to_owned(), meta);
    file
}

#[test]
fn a_policy_from_bytes_acts_as_the_one_from_the_file() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("policy.safetensors");
    let file = file(&path);
    file.save().expect("writes");
    let from_path = Checkpoint::load(&path).expect("reads").policy().expect("policy");
    let bytes = file.to_bytes().expect("bytes");
    assert_eq!(std::fs::read(&path).expect("reads").len(), bytes.len());
    let from_bytes = Checkpoint::from_bytes(&bytes, Path::new("built in")).expect("reads");
    assert_eq!(from_bytes.meta().iteration, 7);
    let from_bytes = from_bytes.policy().expect("policy");
    let (mut a, mut b) = (from_path.start(2), from_bytes.start(2));
    let (mut x, mut y) = ([0.0; 2 * ACTIONS], [0.0; 2 * ACTIONS]);
    for step in 0..3 {
        let obs: Vec<f32> = (0..2 * OBSERVATIONS).map(|k| (k + step) as f32).collect();
        from_path.act(&obs, &mut a, &mut x);
        from_bytes.act(&obs, &mut b, &mut y);
        assert_eq!(x, y);
    }
    assert!(x.iter().any(|x| x.abs() > 1e-3));
}

/// What is said of the file after a change of its metadata.
fn refused(change: fn(&mut Meta)) -> String {
    let source = Path::new("bytes");
    let mut file = file(source);
    let mut meta: Meta = serde_json::from_str(&file.metadata["paid"]).expect("reads");
    change(&mut meta);
    file.metadata.insert("paid".to_owned(), serde_json::to_string(&meta).expect("serializes"));
    let checkpoint = Checkpoint::from_bytes(&file.to_bytes().expect("bytes"), source);
    checkpoint.and_then(|checkpoint| checkpoint.policy()).expect_err("refused").to_string()
}

/// A damaged file must not have networks made that fill the memory, or take forever.
#[test]
fn sizes_that_no_network_has_are_refused_before_one_is_made() {
    type Change = fn(&mut Meta);
    let sizes: [(Change, &str); 6] = [
        (
            |meta| meta.actor.hidden = vec![1_000_000_000_000],
            "actor.hidden: expected widths of 1 to 65536, found [1000000000000]",
        ),
        (
            |meta| meta.actor.lstm.layers = 10_000_000_000,
            "actor.lstm: expected 1 to 64 layers of 1 to 65536 cells, found 10000000000 x 4",
        ),
        (|meta| meta.critic.hidden = vec![0], "critic.hidden: expected widths of 1 to 65536, found [0]"),
        (|meta| meta.policy_obs = 0, "policy_obs: expected 1 to 65536, found 0"),
        (|meta| meta.critic_obs = 65_537, "critic_obs: expected 1 to 65536, found 65537"),
        (|meta| meta.actions = usize::MAX, "actions: expected 1 to 65536, found 18446744073709551615"),
    ];
    for (change, expected) in sizes {
        let error = refused(change);
        assert_eq!(error, format!("bytes: not a checkpoint: metadata: {expected}"));
    }
    // The largest network that may be is in no file.
    let error = refused(|meta| {
        meta.actor.hidden = vec![65_536; 64];
        meta.actor.lstm = LstmConfig { layers: 64, size: 65_536, inputs: 0 };
    });
    assert!(
        error.contains("tensor actor.lstm.0.weight_ih: expected F32 [262144, 3], found F32 [16, 3]"),
        "{error}"
    );
}

/// With the root of a negative number the policy would see zeros.
#[test]
fn a_normalizer_that_no_samples_have_is_refused() {
    let source = Path::new("bytes");
    for (tensor, values, expected) in [
        ("m2", &[1.0, -4.0, 9.0][..], "m2: element 1: expected 0 or more, found -4"),
        ("count", &[-4.0], "count: element 0: expected 0 or more, found -4"),
        ("count", &[0.0], "mean: element 0: expected 0 without samples, found 0.5"),
    ] {
        let mut file = file(source);
        file.put_f64s(format!("normalizer.policy.{tensor}"), &[values.len()], values);
        let checkpoint = Checkpoint::from_bytes(&file.to_bytes().expect("bytes"), source).expect("reads");
        let error = checkpoint.policy().expect_err("refused").to_string();
        assert_eq!(error, format!("bytes: not a checkpoint: tensor normalizer.policy.{expected}"));
    }
}

#[test]
fn a_file_is_saved_with_all_that_it_holds() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("full.safetensors");
    let mut file = file(&path);
    file.put_u64s("learner.counters", &[2], &[7, 8]);
    file.put_bytes("blob.state", b"where it was");
    file.put_bytes("blob.note", b"old");
    file.save().expect("writes");
    let mut checkpoint = Checkpoint::load(&path).expect("reads");
    checkpoint.set_blob("note", b"newer");
    checkpoint.save().expect("writes");
    file.put_bytes("blob.note", b"newer");
    let found = TensorFile::load(&path).expect("reads");
    assert_eq!((found.tensors, found.metadata), (file.tensors, file.metadata));
}

#[test]
fn all_critics_take_their_inputs_in_another_order() {
    let source = Path::new("bytes");
    let mut file = file(source);
    let mut meta: Meta = serde_json::from_str(&file.metadata["paid"]).expect("reads");
    (meta.critic_obs, meta.critic.hidden) = (2, vec![1]);
    file.metadata.insert("paid".to_owned(), serde_json::to_string(&meta).expect("serializes"));
    for (network, weights) in [("critic", [1.0, 2.0]), ("critic_style", [3.0, 4.0])] {
        file.put_f32s(format!("{network}.mlp.0.weight"), &[1, 2], &weights);
        file.put_f32s(format!("{network}.mlp.0.bias"), &[1], &[0.5]);
    }
    file.put_f64s("normalizer.critic.mean", &[2], &[5.0, 6.0]);
    file.put_f64s("normalizer.critic.m2", &[2], &[7.0, 8.0]);
    file.put_f64s("normalizer.critic.count", &[1], &[4.0]);
    let before = Checkpoint::from_bytes(&file.to_bytes().expect("bytes"), source).expect("reads");
    let after = before.with_critic_inputs(&[Some(1), Some(0)]).expect("turned");
    for (network, weights) in [("critic", [2.0, 1.0]), ("critic_style", [4.0, 3.0])] {
        file.put_f32s(format!("{network}.mlp.0.weight"), &[1, 2], &weights);
    }
    file.put_f64s("normalizer.critic.mean", &[2], &[6.0, 5.0]);
    file.put_f64s("normalizer.critic.m2", &[2], &[8.0, 7.0]);
    assert_eq!(after.tensors().tensors, file.tensors, "and nothing else changes");
    assert_eq!(after.meta(), before.meta());
}

#[test]
fn errors_in_bytes_name_their_source() {
    let source = Path::new("demo policy (built in)");
    let error = Checkpoint::from_bytes(b"not a checkpoint", source).expect_err("refused").to_string();
    assert!(error.starts_with("demo policy (built in): "), "{error}");
    let mut other = file(source);
    other.put_f32s("actor.mlp.1.bias", &[ACTIONS + 1], &[0.0; ACTIONS + 1]);
    let checkpoint = Checkpoint::from_bytes(&other.to_bytes().expect("bytes"), source).expect("reads");
    let error = checkpoint.policy().expect_err("refused").to_string();
    assert!(error.starts_with("demo policy (built in): ") && error.contains("mlp.1.bias"), "{error}");
}
