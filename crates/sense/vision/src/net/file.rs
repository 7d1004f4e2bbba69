//! The network as an ONNX file.

use paid_onnx::proto::{
    ATTRIBUTE_INTS, ATTRIBUTE_STRING, Attribute, GraphProto, ModelProto, NodeProto, OperatorSetId,
    StringStringEntry, TensorProto, ValueInfo,
};
use paid_onnx::{IR_VERSION, OPSET};
use prost::Message;

use super::{CHANNELS, Convolution, FINE, HEIGHT, INPUTS, LAYERS, Layer, STRIDE, WIDTH};
use crate::VisionError;

/// Name of the output.
pub const OUTPUT: &str = "ball";

/// The bytes of the network's ONNX file. `notes` go into its metadata: what it was trained on, and for how long.
///
/// # Errors
/// If a layer has another number of weights than [`LAYERS`] gives, or one that is not finite.
pub fn encode_net(weights: &[Convolution], notes: &[(&str, String)]) -> Result<Vec<u8>, VisionError> {
    if weights.len() != LAYERS.len() {
        return Err(VisionError::value(
            "ball network",
            format!("{} layers", LAYERS.len()),
            weights.len().to_string(),
        ));
    }
    let mut graph = GraphProto { name: Some("ball_detector".to_owned()), ..GraphProto::default() };
    graph.input.push(ValueInfo::float("image", &[1, INPUTS, HEIGHT, WIDTH]));
    graph.output.push(ValueInfo::float(OUTPUT, &[1, CHANNELS, HEIGHT / STRIDE, WIDTH / STRIDE]));
    // Scales of the one enlargement: batch, channels, down, across.
    graph.initializer.push(TensorProto::float("double", &[4], &[1.0, 1.0, 2.0, 2.0]));
    // The name of the map so far, and of the last one of stride 8.
    let (mut x, mut fine) = ("image".to_owned(), String::new());
    for (k, ((layer, inputs, outputs), convolution)) in LAYERS.iter().zip(weights).enumerate() {
        let taps = layer.taps();
        let expected = [outputs * inputs * taps * taps, *outputs];
        let found = [convolution.weight.len(), convolution.bias.len()];
        if expected != found {
            return Err(VisionError::value(
                format!("layer {k}"),
                format!("{expected:?} numbers"),
                format!("{found:?}"),
            ));
        }
        if !convolution.weight.iter().chain(&convolution.bias).all(|v| v.is_finite()) {
            return Err(VisionError::value(format!("layer {k}"), "finite numbers", "NaN or infinity"));
        }
        let (w, b) = (format!("layer{k}.weight"), format!("layer{k}.bias"));
        graph.initializer.push(TensorProto::float(&w, &[*outputs, *inputs, taps, taps], &convolution.weight));
        graph.initializer.push(TensorProto::float(&b, &[*outputs], &convolution.bias));
        if *layer == Layer::Half && *inputs == FINE {
            fine.clone_from(&x);
        }
        let input = x.clone();
        let last = *layer == Layer::Out;
        x = if last { OUTPUT.to_owned() } else { format!("conv{k}") };
        let (stride, pad, taps) = (layer.stride() as i64, (taps / 2) as i64, taps as i64);
        let attributes = vec![
            integers("kernel_shape", &[taps, taps]),
            integers("pads", &[pad; 4]),
            integers("strides", &[stride, stride]),
        ];
        graph.node.push(node("Conv", &[&input, &w, &b], &x, attributes));
        let mut then = |op: &str, inputs: &[&str], attributes: Vec<Attribute>| {
            let output = format!("{}{k}", op.to_lowercase());
            graph.node.push(node(op, inputs, &output, attributes));
            output
        };
        if layer.relu() {
            x = then("Relu", &[&x], Vec::new());
        }
        match layer {
            Layer::Residual => x = then("Add", &[&input, &x], Vec::new()),
            Layer::Lateral => {
                let nearest = vec![
                    text("mode", "nearest"),
                    text("coordinate_transformation_mode", "asymmetric"),
                    text("nearest_mode", "floor"),
                ];
                x = then("Resize", &[&x, "", "double"], nearest);
                x = then("Add", &[&fine, &x], Vec::new());
            }
            Layer::Half | Layer::Head | Layer::Out => {}
        }
    }
    let entry = |(key, value): &(&str, String)| StringStringEntry {
        key: Some((*key).to_owned()),
        value: Some(value.clone()),
    };
    let model = ModelProto {
        ir_version: Some(IR_VERSION),
        producer_name: Some("paid".to_owned()),
        producer_version: Some(env!("CARGO_PKG_VERSION").to_owned()),
        graph: Some(graph),
        opset_import: vec![OperatorSetId { domain: Some(String::new()), version: Some(OPSET) }],
        metadata_props: notes.iter().map(entry).collect(),
    };
    Ok(model.encode_to_vec())
}

/// A node with one output.
pub(crate) fn node(op: &str, inputs: &[&str], output: &str, attribute: Vec<Attribute>) -> NodeProto {
    NodeProto {
        input: inputs.iter().map(|&s| s.to_owned()).collect(),
        output: vec![output.to_owned()],
        name: Some(format!("{}_{output}", op.to_lowercase())),
        op_type: Some(op.to_owned()),
        attribute,
    }
}

/// A list of integers.
pub(crate) fn integers(name: &str, ints: &[i64]) -> Attribute {
    let ints = ints.to_vec();
    Attribute { name: Some(name.to_owned()), ints, r#type: Some(ATTRIBUTE_INTS), ..Attribute::default() }
}

/// A text.
fn text(name: &str, s: &str) -> Attribute {
    let s = Some(s.as_bytes().to_vec());
    Attribute { name: Some(name.to_owned()), s, r#type: Some(ATTRIBUTE_STRING), ..Attribute::default() }
}
