//! Weights from bytes and from paths.

use std::path::Path;

use paid_lanes::rng::Rng;
use paid_policy::checkpoint::{Meta, VERSION};
use paid_policy::net::Network;
use paid_policy::{Checkpoint, LstmConfig, NetworkConfig, NetworkKind, TensorFile};

const OBSERVATIONS: usize = 3;
const ACTIONS: usize = 2;

/// A checkpoint with weights and normalizer of a small policy with memory.
fn file(path: &Path) -> TensorFile {
    let actor = NetworkConfig {
        kind: NetworkKind::Lstm,
        hidden: vec![5],
        lstm: LstmConfig { layers: 1, size: 4 },
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
