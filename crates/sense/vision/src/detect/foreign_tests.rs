//! Files of other tools: their metadata, and what else they may be.

use paid_onnx::proto::{ATTRIBUTE_INT, Attribute, GraphProto, TensorProto, ValueInfo};

use super::tests::{CELLS, file_of, with_metadata};
use super::*;
use crate::net::node;

/// `[1, 4 + classes, cells]` with these numbers of cell 5.
fn yolo_v8(cell: &[f32], metadata: &[(&str, &str)]) -> OnnxFile {
    let mut output = vec![0.0; cell.len() * CELLS];
    for (row, value) in cell.iter().enumerate() {
        output[row * CELLS + 5] = *value;
    }
    with_metadata(&[1, 3, 32, 64], &[("output0", vec![1, cell.len(), CELLS], output)], metadata)
}

/// `[1, cells, 5 + classes]` with these numbers of the cell (2, 1) of stride 8.
fn yolo_x(cell: &[f32], metadata: &[(&str, &str)]) -> OnnxFile {
    let mut output = vec![0.0; cell.len() * CELLS];
    output[10 * cell.len()..11 * cell.len()].copy_from_slice(cell);
    with_metadata(&[1, 3, 32, 64], &[("output", vec![1, CELLS, cell.len()], output)], metadata)
}

fn refusal(file: OnnxFile, class: Option<usize>) -> String {
    Detector::from_file(file, class).expect_err("refused").to_string()
}

#[test]
fn models_of_another_task_are_refused_with_what_they_are() {
    let cell = [40.0, 12.0, 16.0, 8.0, 0.9];
    for (task, names) in [("pose", "{0: 'ball'}"), ("obb", "{0: 'ball'}"), ("segment", "{0: 'ball'}")] {
        let error = refusal(yolo_v8(&cell, &[("task", task), ("names", names)]), None);
        let expected =
            format!("test.onnx: metadata 'task': expected 'detect', by its outputs, found \"{task}\"");
        assert!(error.starts_with(&expected), "{error}");
    }
    // Angles as a further row, and names for one class less.
    let oriented = yolo_v8(&[40.0, 12.0, 16.0, 8.0, 0.9, 0.7], &[("names", "{0: 'ball'}")]);
    let error = refusal(oriented, None);
    assert!(
        error.contains("metadata 'names': expected the names of 2 classes, by its outputs, found 1"),
        "{error}"
    );
    let transposed = yolo_x(&[40.0, 12.0, 16.0, 8.0, 0.9, 0.0], &[("task", "detect")]);
    let error = refusal(transposed, None);
    assert!(
        error.contains("expected the heads of YOLOv8 [1, 4 + classes, cells], found them transposed"),
        "{error}"
    );
}

#[test]
fn numbers_that_are_no_scores_and_boxes_are_refused_without_metadata_too() {
    for (file, parts) in [
        // Key points of a pose, angles of an oriented box, logits.
        (
            yolo_v8(&[40.0, 12.0, 16.0, 8.0, 0.9, 44.0], &[]),
            ["YOLOv8: scores: expected numbers from 0 to 1", "44"],
        ),
        (yolo_v8(&[40.0, 12.0, 16.0, 8.0, 0.9, -0.5], &[]), ["scores", "-0.5"]),
        (yolo_x(&[0.5, 0.5, 0.0, 0.0, 2.5, 0.9], &[]), ["YOLOX: scores", "2.5"]),
        // Shares of the input, a box outside it.
        (
            yolo_v8(&[0.6, 0.4, 0.2, 0.2, 0.9, 0.0], &[]),
            ["boxes in the input of 64 x 32 pixels", "0.2 x 0.2"],
        ),
        (yolo_v8(&[400.0, 12.0, 16.0, 8.0, 0.9, 0.0], &[]), ["boxes in the input", "at (400.0, 12.0)"]),
        // Boxes in pixels where cells and logarithms are expected: exp(16) cells.
        (yolo_x(&[20.0, 12.0, 16.0, 8.0, 0.9, 0.9], &[]), ["YOLOX: boxes in the input", "decoded twice"]),
        // Transposed: class 0 is read as whether there is something.
        (yolo_x(&[40.0, 12.0, 16.0, 8.0, 0.0, 0.9], &[]), ["YOLOX: boxes", "transposed"]),
        (
            yolo_v8(&[40.0, 12.0, 16.0, 8.0, f32::NAN, 0.0], &[]),
            ["output: expected finite numbers", "NaN at 173"],
        ),
    ] {
        let error = refusal(file, Some(0));
        for part in ["test.onnx: taken for "].iter().chain(&parts) {
            assert!(error.replace(": boxes: expected boxes", ": boxes").contains(part), "{part}: {error}");
        }
    }
}

#[test]
fn a_score_that_is_none_is_a_fault_and_not_a_picture_without_a_ball() {
    // Every number of the output plus 0 log(mean of the image): as it is for gray, none for black.
    let mut graph = GraphProto { name: Some("test".to_owned()), ..GraphProto::default() };
    let numbers = [
        TensorProto::float("boxes", &[1, 5, CELLS], &[0.0; 5 * CELLS]),
        TensorProto::float("zero", &[1], &[0.0]),
    ];
    graph.initializer.extend(numbers);
    let flat = Attribute {
        name: Some("keepdims".to_owned()),
        i: Some(0),
        r#type: Some(ATTRIBUTE_INT),
        ..Attribute::default()
    };
    graph.node.extend([
        node("ReduceMean", &["images"], "mean", vec![flat]),
        node("Log", &["mean"], "log", Vec::new()),
        node("Mul", &["log", "zero"], "nothing", Vec::new()),
        node("Add", &["boxes", "nothing"], "output0", Vec::new()),
    ]);
    graph.input.push(ValueInfo::float("images", &[1, 3, 32, 64]));
    graph.output.push(ValueInfo::float("output0", &[1, 5, CELLS]));
    let detector = Detector::from_file(file_of(graph, &[]), None).expect("finite for gray");
    assert!(detector.detect(&ColorImage::filled(64, 32, [99; 3]), None).expect("finite").is_empty());
    let error = detector.detect(&ColorImage::filled(64, 32, [0; 3]), None).expect_err("NaN").to_string();
    assert_eq!(error, "test.onnx: taken for YOLOv8: output: expected finite numbers, found NaN at 0");
}

#[test]
fn the_class_that_is_named_so_is_the_ball() {
    let three =
        |names| yolo_v8(&[40.0, 12.0, 16.0, 8.0, 0.0, 0.9, 0.3], &[("task", "detect"), ("names", names)]);
    for (names, class) in [
        ("{0: 'person', 1: 'ball', 2: 'goalpost'}", 1),
        ("{0: 'ball boy', 1: \"keeper's ball\", 2: 'Soccer-Ball'}", 2),
        ("['a', 'b', 'match ball']", 2),
        ("{\"0\": \"football\", \"1\": \"tennis ball\", \"2\": \"it's: \\\"x\\\"\"}", 0),
        ("{0: 'sports ball', 1: 'baseball bat', 2: 'tennis ball'}", 0),
    ] {
        assert_eq!(Detector::from_file(three(names), None).expect(names).options().class, class, "{names}");
    }
    let words = Detector::from_file(three("{0: 'person', 1: 'ball', 2: 'goalpost'}"), None)
        .expect("reads")
        .taken_for();
    assert_eq!(
        words,
        "test.onnx: taken for YOLOv8 with an input of 64 x 32 pixels; the ball is class 1 of 3, \"ball\""
    );
    // What is given goes first.
    assert_eq!(Detector::from_file(three("['ball', 'b', 'c']"), Some(2)).expect("reads").options().class, 2);
    for (names, found) in [
        ("{0: 'person', 1: 'goal', 2: 'line'}", "classes are 0 \"person\", 1 \"goal\", 2 \"line\""),
        ("['ball', 'football', 'c']", "0 \"ball\", 1 \"football\""),
        ("['basketball', 'volleyball', 'c']", "0 \"basketball\""),
    ] {
        let error = refusal(three(names), None);
        assert!(
            error.contains("class: expected the number of the ball's class") && error.contains(found),
            "{error}"
        );
    }
    let error = refusal(yolo_v8(&[40.0, 12.0, 16.0, 8.0, 0.0, 0.9], &[]), None);
    assert!(error.contains("found none, and 2 classes without names"), "{error}");
}

#[test]
fn the_recorded_cases_are_what_they_are_taken_for() {
    let test = "the_recorded_cases_are_what_they_are_taken_for";
    let case = |name: &str| {
        let path = paid_testing::shared_data(test, &format!("cases/{name}.onnx"))?;
        Some(Detector::load(&path, None).map_err(|error| error.to_string()))
    };
    for (name, part) in [
        ("pose", "expected 'detect', by its outputs, found \"pose\""),
        ("v8_transposed", "found them transposed"),
    ] {
        let Some(read) = case(name) else { return };
        let error = read.expect_err("refused");
        assert!(error.contains(part), "{error}");
    }
    for name in ["names_ball_1", "external"] {
        let Some(read) = case(name) else { return };
        let detector = read.expect("reads");
        assert_eq!(detector.options().class, 1, "{name}");
        let found = detector.detect(&ColorImage::filled(320, 320, [0; 3]), None).expect("runs");
        // Cell 57: 30 x 30 around (100, 250), the ball with 0.9; the person of cell 50 is none.
        assert_eq!((found.len(), found[0].outline.middle()), (1, [100.0, 250.0]), "{name}");
    }
}
