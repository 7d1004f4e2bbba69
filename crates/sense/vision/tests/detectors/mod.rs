//! Detectors as small as they can be, with the operators that a real one has. The fuzz target begins with them too.

use paid_onnx::proto::{
    ATTRIBUTE_INT, ATTRIBUTE_INTS, Attribute, GraphProto, ModelProto, NodeProto, OperatorSetId,
    StringStringEntry, TensorProto, ValueInfo,
};
use paid_onnx::{IR_VERSION, OPSET};
use prost::Message;

/// Side of the input `[px]`: the smallest that is taken.
const SIDE: usize = 32;
/// Cells of the strides 8, 16 and 32.
const CELLS: usize = 21;

/// One of each kind that other people export: YOLOv8, YOLOv8-seg, YOLOX.
pub fn all() -> Vec<Vec<u8>> {
    vec![yolo_v8(), yolo_v8_seg(), yolo_x()]
}

/// YOLOv8 with two classes: a convolution a stride, each a row of cells, side by side.
pub fn yolo_v8() -> Vec<u8> {
    let mut graph = Builder::default();
    graph.heads(6, "cells");
    graph.boxes_and_scores(6);
    graph.names = Some("{0: 'person', 1: 'ball'}");
    graph.encode(&[("output0", vec![1, 6, CELLS])])
}

/// YOLOv8-seg with one class: prototypes by a convolution that is enlarged, with a leap over it.
pub fn yolo_v8_seg() -> Vec<u8> {
    let mut graph = Builder::default();
    graph.heads(37, "cells");
    graph.boxes_and_scores(37);
    graph.convolution(32, 8, "coarse");
    graph.graph.initializer.push(TensorProto::float("scales", &[4], &[1.0, 1.0, 2.0, 2.0]));
    graph.node("Resize", &["coarse", "", "scales"], "enlarged", Vec::new());
    graph.convolution(32, 4, "fine");
    graph.node("Relu", &["fine"], "positive", Vec::new());
    graph.node("Add", &["enlarged", "positive"], "output1", Vec::new());
    graph.encode(&[("output0", vec![1, 37, CELLS]), ("output1", vec![1, 32, SIDE / 4, SIDE / 4])])
}

/// YOLOX with one class: the cells turned.
pub fn yolo_x() -> Vec<u8> {
    let mut graph = Builder::default();
    graph.heads(6, "cells");
    graph.node("Sigmoid", &["cells"], "shares", Vec::new());
    graph.node("Transpose", &["shares"], "output", vec![integers("perm", &[0, 2, 1])]);
    graph.encode(&[("output", vec![1, CELLS, 6])])
}

#[derive(Default)]
struct Builder {
    graph: GraphProto,
    names: Option<&'static str>,
}

impl Builder {
    fn node(&mut self, op: &str, inputs: &[&str], output: &str, attribute: Vec<Attribute>) {
        self.graph.node.push(NodeProto {
            input: inputs.iter().map(|&s| s.to_owned()).collect(),
            output: vec![output.to_owned()],
            name: None,
            op_type: Some(op.to_owned()),
            attribute,
        });
    }

    /// One pixel of every square of `stride` pixels, weighted.
    fn convolution(&mut self, channels: usize, stride: usize, output: &str) {
        let (weight, bias) = (format!("{output}.w"), format!("{output}.b"));
        let values =
            |count: usize, by: f32| (0..count).map(|i| by * ((i % 7) as f32 - 3.0)).collect::<Vec<_>>();
        let (w, b) = (values(3 * channels, 0.5), values(channels, 1.0));
        self.graph.initializer.push(TensorProto::float(&weight, &[channels, 3, 1, 1], &w));
        self.graph.initializer.push(TensorProto::float(&bias, &[channels], &b));
        let attributes = vec![integers("kernel_shape", &[1, 1]), integers("strides", &[stride as i64; 2])];
        self.node("Conv", &["images", &weight, &bias], output, attributes);
    }

    /// `[1, rows, cells]`.
    fn heads(&mut self, rows: usize, output: &str) {
        let heads = [8, 16, 32].map(|stride| {
            let [map, list, shape] = ["map", "list", "shape"].map(|name| format!("{name}{stride}"));
            self.convolution(rows, stride, &map);
            self.graph.initializer.push(TensorProto::int64(&shape, &[1, rows as i64, -1]));
            self.node("Reshape", &[&map, &shape], &list, Vec::new());
            list
        });
        let axis = Attribute {
            name: Some("axis".to_owned()),
            i: Some(2),
            r#type: Some(ATTRIBUTE_INT),
            ..Attribute::default()
        };
        self.node("Concat", &[&heads[0], &heads[1], &heads[2]], output, vec![axis]);
    }

    /// Boxes inside the input and scores from 0 to 1.
    fn boxes_and_scores(&mut self, rows: usize) {
        let scale: Vec<f32> = (0..rows).map(|row| if row < 4 { SIDE as f32 } else { 1.0 }).collect();
        self.graph.initializer.push(TensorProto::float("scale", &[1, rows, 1], &scale));
        self.node("Sigmoid", &["cells"], "shares", Vec::new());
        self.node("Mul", &["shares", "scale"], "output0", Vec::new());
    }

    fn encode(mut self, outputs: &[(&str, Vec<usize>)]) -> Vec<u8> {
        self.graph.input.push(ValueInfo::float("images", &[1, 3, SIDE, SIDE]));
        self.graph.output = outputs.iter().map(|(name, dims)| ValueInfo::float(name, dims)).collect();
        let entry =
            |value: &str| StringStringEntry { key: Some("names".to_owned()), value: Some(value.to_owned()) };
        let metadata = self.names.map(entry).into_iter().collect();
        let model = ModelProto {
            ir_version: Some(IR_VERSION),
            graph: Some(self.graph),
            opset_import: vec![OperatorSetId { domain: Some(String::new()), version: Some(OPSET) }],
            metadata_props: metadata,
            ..ModelProto::default()
        };
        model.encode_to_vec()
    }
}

fn integers(name: &str, ints: &[i64]) -> Attribute {
    let ints = ints.to_vec();
    Attribute { name: Some(name.to_owned()), ints, r#type: Some(ATTRIBUTE_INTS), ..Attribute::default() }
}
