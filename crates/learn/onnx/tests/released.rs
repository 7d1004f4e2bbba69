//! Files with the released interface but without this project's contract.

use std::path::{Path, PathBuf};

use paid_onnx::proto::{EXTERNAL, ModelProto, StringStringEntry};
use paid_onnx::{
    CONTRACT_KEY, Contract, DenseLayer, FORMAT, JointContract, LstmLayer, ObservationTerm, OnnxError,
    OnnxPolicy, PolicyWeights, RecurrentContract, encode, load_released,
};
use prost::Message;

fn contract() -> Contract {
    let joint = |name: &str, default_pos, stiffness| JointContract {
        name: name.to_owned(),
        default_pos,
        stiffness,
        damping: 2.5,
        action_scale: 0.44,
    };
    let term = |name: &str, size, order: &str| ObservationTerm {
        name: name.to_owned(),
        size,
        order: order.to_owned(),
        frame: "base".to_owned(),
        unit: "rad".to_owned(),
        scale: 1.0,
    };
    Contract {
        format: FORMAT,
        robot: "arm".to_owned(),
        mode_machines: Vec::new(),
        license: "test".to_owned(),
        control_period_s: 0.02,
        action: "target".to_owned(),
        joints: vec![joint("shoulder", 0.1, 40.0), joint("elbow", 0.6, 30.0)],
        anchor_body: "base".to_owned(),
        bodies: vec!["base".to_owned(), "hand".to_owned()],
        observation: vec![term("joint_pos", 2, "joints"), term("target", 2, "x,y")],
        commands: vec!["motion".to_owned()],
        recurrent: Some(RecurrentContract { layers: 1, hidden: 3 }),
        reference: None,
        play: None,
    }
}

fn weights() -> PolicyWeights {
    let numbers = |n: usize| (0..n).map(|i| (i as f32 * 0.7).sin()).collect::<Vec<_>>();
    PolicyWeights {
        normalizer: None,
        lstm: vec![LstmLayer {
            inputs: 4,
            hidden: 3,
            w_input: numbers(48),
            w_hidden: numbers(36),
            bias: numbers(12),
        }],
        layers: vec![DenseLayer { inputs: 3, outputs: 2, w: numbers(6), b: numbers(2) }],
        mirror: None,
    }
}

/// The file as another program would write it: no contract, and whatever `change` does.
fn foreign(folder: &Path, change: impl FnOnce(&mut ModelProto)) -> PathBuf {
    let bytes = encode(&weights(), &contract(), None, "run", None).expect("encodes");
    let mut model = ModelProto::decode(&bytes[..]).expect("decodes");
    model.metadata_props.retain(|e| e.key.as_deref() != Some(CONTRACT_KEY));
    change(&mut model);
    let path = folder.join("policy.onnx");
    std::fs::write(&path, model.encode_to_vec()).expect("writes");
    path
}

fn entry<'a>(model: &'a mut ModelProto, key: &str) -> &'a mut String {
    let entry = model.metadata_props.iter_mut().find(|e| e.key.as_deref() == Some(key)).expect("the key");
    entry.value.as_mut().expect("a value")
}

#[test]
fn a_policy_without_our_contract_acts_as_the_same_policy_with_it() {
    let folder = tempfile::tempdir().expect("folder");
    let bytes = encode(&weights(), &contract(), None, "run", None).expect("encodes");
    let own = OnnxPolicy::from_bytes(&bytes, Path::new("own.onnx")).expect("reads");
    let path = foreign(folder.path(), |_| ());
    assert!(matches!(OnnxPolicy::load(&path), Err(OnnxError::MissingMetadata { key: CONTRACT_KEY, .. })));
    let read = load_released(&path, &contract()).expect("reads");
    assert_eq!(read.contract().recurrent, contract().recurrent);
    let (mut a, mut b) = (own.initial_state(), read.initial_state());
    for step in 0..4 {
        let obs = [0.1 * step as f32, -0.3, 0.7, 0.2];
        assert_eq!(own.act(&obs, &mut a).expect("acts"), read.act(&obs, &mut b).expect("acts"));
    }
    assert_eq!(a, b);
}

#[test]
fn weights_in_a_second_file_act_as_those_in_one() {
    let folder = tempfile::tempdir().expect("folder");
    let mut data = Vec::new();
    let path = foreign(folder.path(), |m| {
        for tensor in &mut m.graph.as_mut().expect("a graph").initializer {
            let numbers = tensor.raw_data.take().expect("numbers");
            let entries = [("location", "policy.onnx.data".to_owned()), ("offset", data.len().to_string())];
            let length = [("length", numbers.len().to_string())];
            let entry = |(key, value): (&str, String)| StringStringEntry {
                key: Some(key.to_owned()),
                value: Some(value),
            };
            tensor.external_data = entries.into_iter().chain(length).map(entry).collect();
            tensor.data_location = Some(EXTERNAL);
            data.extend(numbers);
        }
    });
    let error = load_released(&path, &contract()).expect_err("alone").to_string();
    assert!(error.contains("policy.onnx.data") && error.contains("keep both files in one folder"), "{error}");
    std::fs::write(folder.path().join("policy.onnx.data"), data).expect("writes");
    let read = load_released(&path, &contract()).expect("reads");
    let whole = foreign(folder.path(), |_| ());
    let whole = load_released(&whole, &contract()).expect("reads");
    let (mut a, mut b) = (whole.initial_state(), read.initial_state());
    let obs = [0.1, -0.3, 0.7, 0.2];
    assert_eq!(whole.act(&obs, &mut a).expect("acts"), read.act(&obs, &mut b).expect("acts"));
}

#[test]
fn the_files_own_gains_and_joint_order_are_kept() {
    let folder = tempfile::tempdir().expect("folder");
    let path = foreign(folder.path(), |m| {
        *entry(m, "joint_names") = "elbow,shoulder".to_owned();
        *entry(m, "joint_stiffness") = "33.5, 41".to_owned();
    });
    let policy = load_released(&path, &contract()).expect("reads");
    let joints: Vec<_> = policy.contract().joints.iter().map(|j| (j.name.as_str(), j.stiffness)).collect();
    assert_eq!(joints, [("elbow", 33.5), ("shoulder", 41.0)]);
}

#[test]
fn what_is_missing_or_wrong_is_refused_term_by_term() {
    let refused = |change: &dyn Fn(&mut ModelProto)| {
        let folder = tempfile::tempdir().expect("folder");
        let path = foreign(folder.path(), change);
        load_released(&path, &contract()).expect_err("must be refused").to_string()
    };
    let error = refused(&|m| m.metadata_props.retain(|e| e.key.as_deref() != Some("action_scale")));
    assert!(error.contains("policy.onnx") && error.contains("'action_scale'"), "{error}");
    let error = refused(&|m| *entry(m, "joint_damping") = "2.5".to_owned());
    assert!(
        error.contains("joint_damping") && error.contains("expected 2") && error.contains("found 1"),
        "{error}"
    );
    let error = refused(&|m| *entry(m, "default_joint_pos") = "0.1,soft".to_owned());
    assert!(
        error.contains("default_joint_pos") && error.contains("entry 1") && error.contains("'soft'"),
        "{error}"
    );
    let error = refused(&|m| {
        *entry(m, "joint_names") = "shoulder,tail".to_owned();
        *entry(m, "anchor_body_name") = "torso".to_owned();
    });
    assert!(error.contains("tail") && error.contains("torso") && error.contains("2 place(s)"), "{error}");
    let folder = tempfile::tempdir().expect("folder");
    let path = foreign(folder.path(), |_| ());
    let mut wider = contract();
    wider.observation[1].size = 3;
    let error = load_released(&path, &wider).expect_err("another size").to_string();
    assert!(error.contains("input 'obs'") && error.contains("[1, 5]") && error.contains("[1, 4]"), "{error}");
}
