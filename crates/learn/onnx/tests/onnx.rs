//! Policy files: what is written acts the same when read back, and what is wrong is refused with its reason.

use std::path::Path;

use paid_onnx::proto::{ModelProto, TensorProto};
use paid_onnx::{
    CONTRACT_KEY, Contract, DenseLayer, FORMAT, JointContract, LstmLayer, NormalizerWeights, ObservationTerm,
    OnnxError, OnnxPolicy, PolicyWeights, RELEASED_KEYS, RecurrentContract, Reference, encode, write,
};
use prost::Message;

const JOINTS: usize = 3;
const OBSERVATIONS: usize = 3 * JOINTS + 2;

/// A small linear congruential stream of numbers in [-1, 1).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 40) as f32) / ((1u64 << 23) as f32) - 1.0
    }
    fn many(&mut self, n: usize, scale: f32) -> Vec<f32> {
        (0..n).map(|_| scale * self.next()).collect()
    }
}

fn contract(recurrent: Option<(usize, usize)>) -> Contract {
    let term = |name: &str, size, order: &str, frame: &str| ObservationTerm {
        name: name.to_owned(),
        size,
        order: order.to_owned(),
        frame: frame.to_owned(),
        unit: "rad".to_owned(),
        scale: 1.0,
    };
    Contract {
        format: FORMAT,
        robot: "arm".to_owned(),
        mode_machines: Vec::new(),
        license: "test".to_owned(),
        control_period_s: 0.02,
        action: "joint position target = default + scale * action".to_owned(),
        joints: (0..JOINTS)
            .map(|i| JointContract {
                name: format!("joint_{i}"),
                default_pos: 0.1 * i as f64,
                stiffness: 40.0 + i as f64 / 3.0,
                damping: 2.5,
                action_scale: 0.44,
            })
            .collect(),
        anchor_body: "base".to_owned(),
        bodies: vec!["base".to_owned(), "hand".to_owned()],
        observation: vec![
            term("joint_pos", JOINTS, "joints", "joint"),
            term("joint_vel", JOINTS, "joints", "joint"),
            term("last_action", JOINTS, "joints", "joint"),
            term("target", 2, "x,y", "base"),
        ],
        commands: vec!["motion".to_owned()],
        recurrent: recurrent.map(|(layers, hidden)| RecurrentContract { layers, hidden }),
        reference: None,
        play: None,
    }
}

fn weights(seed: u64, lstm: Option<(usize, usize)>, hidden: &[usize], clip: Option<f32>) -> PolicyWeights {
    let mut r = Numbers(seed);
    let normalizer = Some(NormalizerWeights {
        mean: r.many(OBSERVATIONS, 1.0),
        scale: r.many(OBSERVATIONS, 1.0).iter().map(|v| 0.3 + v.abs()).collect(),
        clip,
    });
    let mut width = OBSERVATIONS;
    let mut layers = Vec::new();
    let mut cells = Vec::new();
    for _ in 0..lstm.map_or(0, |l| l.0) {
        let h = lstm.map_or(0, |l| l.1);
        cells.push(LstmLayer {
            inputs: width,
            hidden: h,
            w_input: r.many(4 * h * width, 0.5),
            w_hidden: r.many(4 * h * h, 0.5),
            bias: r.many(4 * h, 0.5),
        });
        width = h;
    }
    for &outputs in hidden.iter().chain(&[JOINTS]) {
        let w = r.many(outputs * width, 1.5 / (width as f32).sqrt());
        layers.push(DenseLayer { inputs: width, outputs, w, b: r.many(outputs, 0.5) });
        width = outputs;
    }
    PolicyWeights { normalizer, lstm: cells, layers, mirror: None }
}

/// The same with a memory beside the input, of which it reads the last `inputs`.
fn beside(seed: u64, lstm: (usize, usize), inputs: usize, hidden: &[usize]) -> PolicyWeights {
    let mut p = weights(seed, Some(lstm), hidden, Some(3.0));
    let mut r = Numbers(seed + 100);
    let first = &mut p.lstm[0];
    (first.inputs, first.w_input) = (inputs, r.many(4 * lstm.1 * inputs, 0.5));
    let first = &mut p.layers[0];
    first.inputs = OBSERVATIONS + lstm.1;
    first.w = r.many(first.inputs * first.outputs, 0.4);
    p
}

fn affine(w: &[f32], x: &[f64]) -> Vec<f64> {
    w.chunks(x.len()).map(|row| row.iter().zip(x).map(|(&w, x)| f64::from(w) * x).sum()).collect()
}

fn sigmoid(x: f64) -> f64 {
    1.0 / (1.0 + (-x).exp())
}

/// The policy in double precision, one layer after the other.
fn forward(p: &PolicyWeights, obs: &[f32], h: &mut [Vec<f64>], c: &mut [Vec<f64>]) -> Vec<f64> {
    let mut x: Vec<f64> = obs.iter().map(|&v| f64::from(v)).collect();
    if let Some(n) = &p.normalizer {
        for i in 0..x.len() {
            x[i] = (x[i] - f64::from(n.mean[i])) * f64::from(n.scale[i]);
            if let Some(clip) = n.clip {
                x[i] = x[i].clamp(-f64::from(clip), f64::from(clip));
            }
        }
    }
    let observed = x.clone();
    let is_beside = !p.lstm.is_empty() && p.layers[0].inputs > p.lstm[0].hidden;
    if is_beside {
        x.drain(..OBSERVATIONS - p.lstm[0].inputs);
    }
    for (l, cell) in p.lstm.iter().enumerate() {
        let (a, b) = (affine(&cell.w_input, &x), affine(&cell.w_hidden, &h[l]));
        let gate = |g: usize, i: usize| {
            let k = g * cell.hidden + i;
            a[k] + b[k] + f64::from(cell.bias[k])
        };
        for i in 0..cell.hidden {
            let kept = sigmoid(gate(1, i)) * c[l][i];
            c[l][i] = kept + sigmoid(gate(0, i)) * gate(2, i).tanh();
            h[l][i] = sigmoid(gate(3, i)) * c[l][i].tanh();
        }
        x = h[l].clone();
    }
    if is_beside {
        x.splice(..0, observed);
    }
    for (i, layer) in p.layers.iter().enumerate() {
        x = affine(&layer.w, &x);
        for (v, &b) in x.iter_mut().zip(&layer.b) {
            *v += f64::from(b);
            if i + 1 < p.layers.len() && *v < 0.0 {
                *v = v.exp_m1();
            }
        }
    }
    x
}

fn assert_acts_the_same(p: &PolicyWeights, contract: &Contract, seed: u64) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("policy.onnx");
    write(&path, p, contract, None, "test", None).unwrap();
    let policy = OnnxPolicy::load_expecting(&path, contract).unwrap();
    let mut state = policy.initial_state();
    let hidden = p.lstm.first().map_or(0, |l| l.hidden);
    let (mut h, mut c) = (vec![vec![0.0; hidden]; p.lstm.len()], vec![vec![0.0; hidden]; p.lstm.len()]);
    let mut r = Numbers(seed);
    for step in 0..12 {
        let obs = r.many(OBSERVATIONS, 2.0);
        let expected = forward(p, &obs, &mut h, &mut c);
        let found = policy.act(&obs, &mut state).unwrap();
        assert_eq!(found.len(), JOINTS);
        for (a, b) in expected.iter().zip(&found) {
            assert!(
                (a - f64::from(*b)).abs() < 1e-5 * a.abs().max(1.0),
                "step {step}: {expected:?} {found:?}"
            );
        }
        let numbers = |s: &[Vec<f64>]| s.concat();
        for (a, b) in numbers(&h).iter().chain(&numbers(&c)).zip(state.h.iter().chain(&state.c)) {
            assert!((a - f64::from(*b)).abs() < 1e-5, "step {step}: state {a} {b}");
        }
    }
    if !p.lstm.is_empty() {
        assert!(state.h.iter().any(|&v| v != 0.0));
        state.reset();
        assert_eq!(state, policy.initial_state());
    }
}

#[test]
fn feed_forward_policy_acts_the_same_when_read_back() {
    assert_acts_the_same(&weights(1, None, &[32, 16], None), &contract(None), 7);
    assert_acts_the_same(&weights(2, None, &[], Some(0.5)), &contract(None), 8);
}

#[test]
fn recurrent_policy_acts_the_same_when_read_back_over_steps() {
    assert_acts_the_same(&weights(3, Some((1, 12)), &[16], None), &contract(Some((1, 12))), 9);
    assert_acts_the_same(&weights(4, Some((2, 12)), &[16, 8], Some(3.0)), &contract(Some((2, 12))), 10);
}

#[test]
fn a_memory_beside_the_input_acts_the_same_when_read_back_over_steps() {
    for (seed, lstm, inputs, hidden) in
        [(5, (1, 12), 3, vec![16]), (6, (2, 5), OBSERVATIONS, vec![16, 8]), (7, (1, 1), 1, vec![])]
    {
        assert_acts_the_same(&beside(seed, lstm, inputs, &hidden), &contract(Some(lstm)), seed + 1);
    }
    let bytes =
        encode(&beside(5, (1, 12), OBSERVATIONS + 1, &[16]), &contract(Some((1, 12))), None, "run", None);
    let error = bytes.expect_err("more than there is").to_string();
    let found = format!("has {} inputs, expected at most {OBSERVATIONS}", OBSERVATIONS + 1);
    assert!(error.contains(&found), "{error}");
}

#[test]
fn every_number_of_layers_and_odd_sizes_act_the_same_when_read_back() {
    for (seed, lstm, hidden) in [
        (20, None, vec![1]),
        (21, None, vec![7, 5, 3]),
        (22, Some((1, 1)), vec![]),
        (23, Some((3, 7)), vec![9, 4]),
        (24, Some((4, 2)), vec![3]),
    ] {
        assert_acts_the_same(&weights(seed, lstm, &hidden, None), &contract(lstm), seed + 1);
    }
}

#[test]
fn embedded_reference_is_read_out_by_frame_and_held_at_its_end() {
    let (frames, bodies) = (5, 2);
    let mut r = Numbers(11);
    let reference = Reference {
        name: "wave".to_owned(),
        frames,
        joint_pos: r.many(frames * JOINTS, 1.0),
        joint_vel: r.many(frames * JOINTS, 1.0),
        body_pos_w: r.many(frames * bodies * 3, 1.0),
        body_quat_w: r.many(frames * bodies * 4, 1.0),
        body_lin_vel_w: r.many(frames * bodies * 3, 1.0),
        body_ang_vel_w: r.many(frames * bodies * 3, 1.0),
    };
    let contract = Contract { reference: Some("wave".to_owned()), ..contract(Some((1, 4))) };
    let bytes =
        encode(&weights(5, Some((1, 4)), &[8], None), &contract, Some(&reference), "run", None).unwrap();
    let policy = OnnxPolicy::from_bytes(&bytes, Path::new("memory")).unwrap();
    let arrays = [
        ("joint_pos", &reference.joint_pos, JOINTS),
        ("joint_vel", &reference.joint_vel, JOINTS),
        ("body_pos_w", &reference.body_pos_w, 3 * bodies),
        ("body_quat_w", &reference.body_quat_w, 4 * bodies),
        ("body_lin_vel_w", &reference.body_lin_vel_w, 3 * bodies),
        ("body_ang_vel_w", &reference.body_ang_vel_w, 3 * bodies),
    ];
    for (step, frame) in [(0, 0), (3, 3), (4, 4), (99, 4)] {
        let expected = arrays.map(|(name, a, size)| (name, a[frame * size..(frame + 1) * size].to_vec()));
        assert_eq!(policy.reference(step).unwrap(), expected);
    }
}

#[test]
fn a_policy_has_no_reference_by_default() {
    let policy = load(&model().encode_to_vec()).unwrap();
    assert_eq!(policy.reference(0).unwrap(), []);
    assert!(model().graph.unwrap().initializer.iter().all(|t| !t.name().starts_with("reference")));
}

fn load(bytes: &[u8]) -> Result<OnnxPolicy, OnnxError> {
    OnnxPolicy::from_bytes(bytes, Path::new("policy.onnx"))
}

fn model() -> ModelProto {
    let bytes =
        encode(&weights(6, Some((2, 4)), &[8], None), &contract(Some((2, 4))), None, "a", None).unwrap();
    ModelProto::decode(&bytes[..]).unwrap()
}

/// The error that a change of a good file leads to.
fn error_after(change: impl FnOnce(&mut ModelProto)) -> OnnxError {
    let mut m = model();
    load(&m.encode_to_vec()).expect("the unchanged file is good");
    change(&mut m);
    load(&m.encode_to_vec()).expect_err("the changed file is refused")
}

fn initializer<'a>(m: &'a mut ModelProto, name: &str) -> &'a mut TensorProto {
    m.graph.as_mut().unwrap().initializer.iter_mut().find(|t| t.name.as_deref() == Some(name)).unwrap()
}

#[test]
fn metadata_has_the_released_keys_in_the_released_form() {
    let policy = load(&model().encode_to_vec()).unwrap();
    for key in RELEASED_KEYS {
        assert!(policy.metadata(key).is_some(), "{key}");
    }
    assert_eq!(policy.metadata("joint_names"), Some("joint_0,joint_1,joint_2"));
    assert_eq!(policy.metadata("joint_stiffness"), Some("40.000000000,40.333333333,40.666666667"));
    assert_eq!(policy.metadata("observation_names"), Some("joint_pos,joint_vel,last_action,target"));
    assert_eq!(policy.metadata("run_path"), Some("a"));
    assert_eq!(policy.contract(), &contract(Some((2, 4))));
}

#[test]
fn a_run_name_with_a_path_is_refused() {
    for run in ["/home/someone/runs/a", "runs/a", "C:\\runs\\a"] {
        let error =
            encode(&weights(6, None, &[8], None), &contract(None), None, run, None).expect_err("a path");
        assert!(error.to_string().contains("path separator"), "{error}");
    }
}

#[test]
fn a_file_cut_anywhere_is_refused() {
    let bytes = model().encode_to_vec();
    for end in (0..bytes.len()).step_by(7) {
        match load(&bytes[..end]).expect_err("cut") {
            OnnxError::Decode { .. } | OnnxError::Opset { .. } | OnnxError::MissingMetadata { .. } => {}
            other => panic!("cut at {end}: {other}"),
        }
    }
}

#[test]
fn another_operator_set_is_refused() {
    let e = error_after(|m| m.opset_import[0].version = Some(11));
    assert_eq!(e.to_string(), "policy.onnx: expected ONNX operator set 17, found 11");
}

#[test]
fn each_missing_metadata_entry_is_named() {
    for key in RELEASED_KEYS.iter().chain(&[CONTRACT_KEY]) {
        let e = error_after(|m| m.metadata_props.retain(|p| p.key.as_deref() != Some(key)));
        assert!(matches!(&e, OnnxError::MissingMetadata { key: k, .. } if k == key), "{e}");
        assert!(e.to_string().contains(key));
    }
}

#[test]
fn metadata_that_contradicts_the_contract_is_refused() {
    let e = error_after(|m| m.metadata_props[0].value = Some("joint_0,joint_2,joint_1".to_owned()));
    assert!(matches!(&e, OnnxError::Metadata { key, .. } if key == "joint_names"), "{e}");
}

#[test]
fn a_contract_with_the_earlier_spelling_of_license_is_read() {
    let contract = contract(None);
    let text = serde_json::to_string(&contract).unwrap().replace("\"license\"", "\"licence\"");
    assert!(text.contains("licence"));
    assert_eq!(serde_json::from_str::<Contract>(&text).unwrap(), contract);
}

#[test]
fn a_newer_or_unreadable_contract_is_refused() {
    let set = |text: String| {
        error_after(|m| {
            let entry = m.metadata_props.iter_mut().find(|p| p.key.as_deref() == Some(CONTRACT_KEY)).unwrap();
            entry.value = Some(text);
        })
    };
    let good = serde_json::to_string(&contract(Some((2, 4)))).unwrap();
    let newer = good.replace("\"format\":2", "\"format\":9,\"wings\":2");
    let e = set(newer).to_string();
    let start = "policy.onnx: it has format 9, which is newer than this program's format 2, and cannot be read (unknown field `wings`";
    assert!(e.starts_with(start), "{e}");
    for bad in [
        "{".to_owned(),
        "{}".to_owned(),
        good.replace("\"robot\"", "\"robots\""),
        good.replace("joint_2", "joint_1"),
        good.replace("\"control_period_s\":0.02", "\"control_period_s\":-1.0"),
    ] {
        assert!(matches!(set(bad), OnnxError::Metadata { key, .. } if key == CONTRACT_KEY));
    }
}

#[test]
fn wrong_sizes_and_numbers_are_refused() {
    let e = error_after(|m| {
        initializer(m, "actor.0.bias").raw_data.as_mut().unwrap().pop();
    });
    assert!(e.to_string().contains("tensor 'actor.0.bias'"), "{e}");
    let e = error_after(|m| {
        initializer(m, "actor.1.weight").raw_data.as_mut().unwrap()[..4]
            .copy_from_slice(&f32::NAN.to_le_bytes());
    });
    assert!(e.to_string().contains("NaN or infinity at element 0"), "{e}");
    let e = error_after(|m| initializer(m, "actor.0.bias").dims = vec![i64::MAX, i64::MAX]);
    assert!(matches!(e, OnnxError::Shape { .. }), "{e}");
    // A layer whose own size is consistent but does not fit its neighbors.
    let e = error_after(|m| {
        *initializer(m, "actor.0.bias") = TensorProto::float("actor.0.bias", &[7], &[0.0; 7]);
    });
    assert!(matches!(e, OnnxError::Graph { .. }), "{e}");
    let e = error_after(|m| {
        let input = &mut m.graph.as_mut().unwrap().input[0];
        let dims =
            &mut input.r#type.as_mut().unwrap().tensor_type.as_mut().unwrap().shape.as_mut().unwrap().dim;
        dims[1].dim_value = Some(12);
    });
    assert_eq!(e.to_string(), "policy.onnx: input 'obs': expected [1, 11], found [1, 12]");
    let e = error_after(|m| m.graph.as_mut().unwrap().output[1].name = Some("h_other".to_owned()));
    assert_eq!(e.to_string(), "policy.onnx: output 'h_out': expected [2, 1, 4], found nothing");
}

#[test]
fn a_differing_contract_is_refused_with_every_difference() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.onnx");
    write(&path, &weights(6, None, &[8], None), &contract(None), None, "", None).unwrap();
    let mut expected = contract(None);
    expected.robot = "leg".to_owned();
    expected.control_period_s = 0.01;
    expected.joints.swap(0, 1);
    expected.joints[2].stiffness = 41.0;
    expected.observation[3].frame = "world".to_owned();
    expected.observation[3].size = 3;
    expected.recurrent = Some(RecurrentContract { layers: 1, hidden: 8 });
    expected.license = "another license is no difference".to_owned();
    let Err(OnnxError::ContractDiffers { differences, .. }) = OnnxPolicy::load_expecting(&path, &expected)
    else {
        panic!("accepted");
    };
    let expected = [
        "robot: expected 'leg', found 'arm'",
        "control_period_s: expected 0.01, found 0.02",
        "joints[0]: expected 'joint_1', found 'joint_0'",
        "joints[1]: expected 'joint_0', found 'joint_1'",
        "joint joint_2 stiffness: expected 41, found 40.666666666666664",
        "observation target size: expected '3', found '2'",
        "observation target frame: expected 'world', found 'base'",
        "recurrent state: expected '1 x 8', found 'none'",
    ];
    assert_eq!(differences, expected);
}

#[test]
fn weights_that_do_not_fit_are_not_written() {
    let good = weights(6, None, &[8], None);
    let refused = |p: &PolicyWeights, c: &Contract| match encode(p, c, None, "", None) {
        Err(OnnxError::Weights(reason)) => reason,
        other => panic!("{other:?}"),
    };
    let mut bad = good.clone();
    bad.layers[0].w[3] = f32::INFINITY;
    assert_eq!(refused(&bad, &contract(None)), "layer 0 weights[3] is inf, expected a finite number");
    let mut bad = good.clone();
    bad.layers[1].inputs = 9;
    assert_eq!(refused(&bad, &contract(None)), "layer 1 has 9 inputs, expected 8");
    assert!(refused(&good, &contract(Some((1, 4)))).starts_with("recurrent state"));
    let mut short = contract(None);
    short.observation.pop();
    assert_eq!(refused(&good, &short), "observations: expected 9, found 11");
}

#[test]
fn a_failed_write_leaves_the_earlier_file_whole() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.onnx");
    let (p, c) = (weights(6, None, &[8], None), contract(None));
    write(&path, &p, &c, None, "first", None).unwrap();
    let before = std::fs::read(&path).unwrap();
    // A write that does not fit leaves it, and so does one where a folder stands in the file's place.
    assert!(matches!(
        write(&path, &p, &contract(Some((1, 4))), None, "second", None),
        Err(OnnxError::Weights(_))
    ));
    let taken = folder.path().join("taken.onnx");
    std::fs::create_dir(&taken).unwrap();
    let error = write(&taken, &p, &c, None, "second", None).expect_err("a folder is in the way");
    assert!(matches!(&error, OnnxError::Io { path, .. } if *path == taken), "{error}");
    assert_eq!(std::fs::read(&path).unwrap(), before);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2, "no temporary file stays");
}

#[test]
fn bad_observations_and_states_are_refused() {
    let policy = load(&model().encode_to_vec()).unwrap();
    let mut state = policy.initial_state();
    let e = policy.act(&[0.0; 10], &mut state).unwrap_err();
    assert_eq!(e.to_string(), "observation: expected 11 numbers, found 10");
    let mut obs = [0.0; OBSERVATIONS];
    obs[4] = f32::NAN;
    assert!(policy.act(&obs, &mut state).unwrap_err().to_string().contains("NaN at 4"));
    state.c.pop();
    let e = policy.act(&[0.0; OBSERVATIONS], &mut state).unwrap_err();
    assert_eq!(e.to_string(), "cell state: expected 8 numbers, found 7");
}
