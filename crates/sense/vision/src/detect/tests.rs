//! Detectors from tiny ONNX files made here.

use paid_onnx::proto::{GraphProto, ModelProto, OperatorSetId, StringStringEntry, TensorProto, ValueInfo};
use paid_onnx::{IR_VERSION, OPSET};
use prost::Message;

use super::*;
use crate::net::{self, Convolution, LAYERS, encode_net, node};
use crate::render::render;
use crate::scatter::{Scatter, Use};

/// A file with one input `[1, 3, h, w]` whose outputs are constants.
fn constant(input: &[usize], outputs: &[(&str, Vec<usize>, Vec<f32>)]) -> OnnxFile {
    with_metadata(input, outputs, &[])
}

pub(super) fn with_metadata(
    input: &[usize],
    outputs: &[(&str, Vec<usize>, Vec<f32>)],
    metadata: &[(&str, &str)],
) -> OnnxFile {
    let mut graph = GraphProto { name: Some("test".to_owned()), ..GraphProto::default() };
    graph.input.push(ValueInfo::float("images", input));
    for (name, dims, values) in outputs {
        let constant = format!("{name}.constant");
        graph.initializer.push(TensorProto::float(&constant, dims, values));
        graph.node.push(node("Identity", &[&constant], name, Vec::new()));
        graph.output.push(ValueInfo::float(name, dims));
    }
    file_of(graph, metadata)
}

pub(super) fn file_of(graph: GraphProto, metadata: &[(&str, &str)]) -> OnnxFile {
    let entry = |(key, value): &(&str, &str)| StringStringEntry {
        key: Some((*key).to_owned()),
        value: Some((*value).to_owned()),
    };
    let model = ModelProto {
        ir_version: Some(IR_VERSION),
        graph: Some(graph),
        opset_import: vec![OperatorSetId { domain: Some(String::new()), version: Some(OPSET) }],
        metadata_props: metadata.iter().map(entry).collect(),
        ..ModelProto::default()
    };
    OnnxFile::from_bytes(model.encode_to_vec(), "test.onnx".as_ref()).expect("a model")
}

/// 64 x 32 has 32 + 8 + 2 cells.
pub(super) const CELLS: usize = 42;

#[test]
fn a_yolo_v8_export_finds_its_ball_in_picture_pixels() {
    let mut output = vec![0.0; 84 * CELLS];
    // Cell 5: a box of 16 x 8 around (40, 12); class 32 of COCO, and a surer person.
    for (row, value) in [(0, 40.0), (1, 12.0), (2, 16.0), (3, 8.0), (36, 0.8), (4, 0.99)] {
        output[row * CELLS + 5] = value;
    }
    let file = constant(&[1, 3, 32, 64], &[("output0", vec![1, 84, CELLS], output)]);
    let detector = Detector::from_file(file.clone(), None).expect("YOLOv8");
    assert_eq!(detector.kind(), Kind::YoloV8 { classes: 80, masks: false });
    assert_eq!(detector.options().class, 32);
    // An image of 128 x 48: half the size, 4 px of gray above.
    let found = detector.detect(&ColorImage::filled(128, 48, [0; 3]), None).expect("runs");
    assert_eq!(found.len(), 1);
    assert_eq!((found[0].outline.min, found[0].outline.max), ([64.0, 8.0], [96.0, 24.0]));
    assert!(!found[0].whole && found[0].mask.is_none());
    let person = Detector::from_file(file.clone(), Some(0)).expect("class 0");
    assert!(
        (person.detect(&ColorImage::filled(128, 48, [0; 3]), None).expect("runs")[0].score - 0.99).abs()
            < 1e-6
    );
    let error = Detector::from_file(file, Some(80)).expect_err("no such class").to_string();
    assert!(error.contains("0 to 79") && error.contains("80"), "{error}");
}

#[test]
fn a_yolo_v8_seg_export_gives_the_mask_of_its_box() {
    let mut output = vec![0.0; (4 + 1 + 32) * CELLS];
    // A box of 32 x 16 around (32, 16) whose mask is 2 times prototype 0 minus prototype 1.
    for (row, value) in [(0, 32.0), (1, 16.0), (2, 32.0), (3, 16.0), (4, 0.9), (5, 2.0), (6, -1.0)] {
        output[row * CELLS + 7] = value;
    }
    let mut prototypes = vec![0.0; 32 * 8 * 16];
    for i in 0..128 {
        prototypes[i] = if i % 16 < 8 { 1.0 } else { 0.0 };
        prototypes[128 + i] = 1.0;
    }
    let file = constant(
        &[1, 3, 32, 64],
        &[("output0", vec![1, 37, CELLS], output), ("output1", vec![1, 32, 8, 16], prototypes)],
    );
    let detector = Detector::from_file(file, None).expect("YOLOv8-seg");
    assert_eq!(detector.kind(), Kind::YoloV8 { classes: 1, masks: true });
    let found = detector.detect(&ColorImage::filled(64, 32, [9; 3]), None).expect("runs");
    let mask = found[0].mask.as_ref().expect("a mask");
    // The left half of the box: 16 x 16.
    assert_eq!(mask.area(), 256);
    assert!(mask.holds(16, 8) && mask.holds(31, 23) && !mask.holds(32, 12));
}

#[test]
fn a_box_in_the_gray_around_the_image_is_no_detection() {
    let mut output = vec![0.0; (4 + 1 + 32) * CELLS];
    // A box of 10 x 16 around (55, 16) of the input, and a surer one around (32, 16).
    for (row, values) in [(0, [55.0, 32.0]), (1, [16.0; 2]), (2, [10.0; 2]), (3, [16.0; 2]), (4, [0.8, 0.9])]
    {
        output[row * CELLS + 7..row * CELLS + 9].copy_from_slice(&values);
    }
    let file = constant(
        &[1, 3, 32, 64],
        &[("output0", vec![1, 37, CELLS], output), ("output1", vec![1, 32, 8, 16], vec![0.0; 32 * 128])],
    );
    let detector = Detector::from_file(file, None).expect("YOLOv8-seg");
    // An upright image: from 28 to 36 px of the input, gray on both sides.
    let found = detector.detect(&ColorImage::filled(16, 64, [9; 3]), None).expect("runs");
    assert_eq!(found.iter().map(|find| find.outline.middle()).collect::<Vec<_>>(), [[8.0, 32.0]]);
}

#[test]
fn a_yolox_export_is_decoded_by_its_grid() {
    let mut output = vec![0.0; CELLS * 6];
    // Cell (2, 1) of stride 8: middle (20, 12), size 8 x 8.
    output[(8 + 2) * 6..(8 + 2) * 6 + 6].copy_from_slice(&[0.5, 0.5, 0.0, 0.0, 0.9, 0.9]);
    let file = constant(&[1, 3, 32, 64], &[("output", vec![1, CELLS, 6], output)]);
    let detector = Detector::from_file(file, None).expect("YOLOX");
    assert_eq!(detector.kind(), Kind::YoloX { classes: 1 });
    assert!(
        detector.taken_for().starts_with(
            "test.onnx: taken for YOLOX with an input of 64 x 32 pixels; the ball is class 0 of 1"
        )
    );
    let found = detector.detect(&ColorImage::filled(128, 64, [0; 3]), None).expect("runs");
    assert_eq!((found[0].outline.min, found[0].outline.max), ([32.0, 16.0], [48.0, 32.0]));
}

#[test]
fn other_files_are_refused_with_what_was_expected_and_found() {
    let built_in_nms = constant(&[1, 3, 32, 64], &[("output0", vec![1, 300, 6], vec![0.0; 1800])]);
    let odd_size = constant(&[1, 3, 30, 64], &[("output0", vec![1, 84, 40], vec![0.0; 84 * 40])]);
    let gray = constant(&[1, 1, 32, 64], &[("output0", vec![1, 84, CELLS], vec![0.0; 84 * CELLS])]);
    for (file, found) in
        [(built_in_nms, "[1, 300, 6]"), (odd_size, "[1, 3, 30, 64]"), (gray, "[1, 1, 32, 64]")]
    {
        let error = Detector::from_file(file, None).expect_err("no known kind").to_string();
        assert!(
            error.contains("test.onnx") && error.contains("4 + classes") && error.contains(found),
            "{error}"
        );
    }
}

#[test]
fn a_network_written_here_runs_as_its_layers_say() {
    // Every layer is zero but the biases of the output: the answer is those biases in every cell.
    let mut weights: Vec<Convolution> = (LAYERS.iter())
        .map(|(layer, inputs, outputs)| Convolution {
            weight: vec![0.0; outputs * inputs * layer.taps().pow(2)],
            bias: vec![0.0; *outputs],
        })
        .collect();
    weights[LAYERS.len() - 1].bias = vec![1.0, 0.0, 0.0, 0.5, 0.25];
    let bytes = encode_net(&weights, &[("data", "none".to_owned())]).expect("fits");
    let detector =
        Detector::from_file(OnnxFile::from_bytes(bytes, "own.onnx".as_ref()).expect("a model"), None)
            .expect("runs");
    assert_eq!(detector.kind(), Kind::Own);
    let found = detector.detect(&ColorImage::filled(320, 192, [0; 3]), None).expect("runs");
    // A flat map has one peak, its first cell.
    assert_eq!(found.len(), 1);
    assert!((found[0].score - 1.0 / (1.0 + (-1.0_f64).exp())).abs() < 1e-6);
    assert!((found[0].outline.size()[0] - 8.0 * 0.5_f64.exp()).abs() < 1e-4);
    weights[3].bias.pop();
    assert!(encode_net(&weights, &[]).expect_err("a bias is missing").to_string().contains("layer 3"));
}

#[test]
fn the_committed_network_is_small_and_its_own() {
    assert!(OWN.len() <= 2_000_000 && net::parameters() <= 1_000_000);
    let detector = Detector::own().expect("the committed network");
    assert_eq!((detector.kind(), detector.input_size()), (Kind::Own, [320, 192]));
    assert!(
        detector.detect(&ColorImage::filled(640, 480, [0; 3]), None).expect("runs").is_empty(),
        "a black image has no ball"
    );
}

#[test]
fn the_committed_network_finds_balls_with_depth_and_most_without() {
    let (detector, scatter) =
        (Detector::own().expect("runs"), Scatter::new(Use::HeldOut, 11).expect("the robot"));
    let (mut balls, mut with_depth, mut without, mut others) = (0, 0, 0, 0);
    for number in 0..60 {
        let sample = scatter.sample(number, Intrinsics::g1_color(), true);
        let rendered = render(&sample.scene, &sample.view);
        let Some(outline) = sample.ball.and_then(|ball| ball.outline) else { continue };
        if (rendered.ball_pixels() as f64) < 0.6 * outline.area() {
            continue;
        }
        balls += 1;
        let (color, depth) = (rendered.color(&sample.color), rendered.depth(&sample.depth));
        let depth = Depth { image: &depth, intrinsics: &sample.view.intrinsics };
        let near = |d: &Detection| {
            let (a, b) = (d.outline.middle(), outline.middle());
            (a[0] - b[0]).hypot(a[1] - b[1]) < 0.25 * (outline.size()[0] + outline.size()[1])
        };
        let found = detector.detect(&color, Some(depth)).expect("runs");
        with_depth += usize::from(found.iter().any(near));
        others += found.iter().filter(|d| !near(d)).count();
        without += usize::from(detector.detect(&color, None).expect("runs").iter().any(near));
    }
    assert!(balls > 40, "{balls} balls");
    assert!(with_depth * 10 >= balls * 9 && others * 10 <= balls, "{with_depth} of {balls}, {others} others");
    assert!(without * 10 >= balls * 6 && without <= with_depth, "{without} of {balls} without depth");
}
