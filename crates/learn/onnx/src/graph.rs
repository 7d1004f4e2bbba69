//! From weights to an ONNX graph.

use paid_policy::Mirror;

use crate::proto::{
    ATTRIBUTE_FLOAT, ATTRIBUTE_INT, Attribute, GraphProto, INT64, NodeProto, TensorProto, ValueInfo,
};
use crate::reference::Reference;
use crate::weights::{LstmLayer, PolicyWeights};

/// Name of the input `[1, 1]` that is 1 where the policy acts in the mirror, and 0 elsewhere.
pub(crate) const MIRROR: &str = "mirror";
/// Whether it does.
const IS_MIRRORED: &str = "is_mirrored";

/// Builds the graph; `joints` and `bodies` are the reference's sizes.
pub(crate) fn build(
    weights: &PolicyWeights,
    reference: Option<&Reference>,
    joints: usize,
    bodies: usize,
) -> GraphProto {
    let mut g = Builder::default();
    g.graph.name = Some("policy".to_owned());
    g.graph.input.push(ValueInfo::float("obs", &[1, weights.observations()]));
    g.graph.output.push(ValueInfo::float("actions", &[1, weights.actions()]));
    let mut x = "obs".to_owned();
    if let Some(mirror) = &weights.mirror {
        g.graph.input.push(ValueInfo::float(MIRROR, &[1, 1]));
        let half = g.float("mirror.half", &[], &[0.5]);
        g.node("Greater", &[MIRROR, &half], IS_MIRRORED);
        x = g.mirrored("observation", &mirror.observation, &x, "obs_shown");
    }
    if let Some(n) = &weights.normalizer {
        let size = n.mean.len();
        let mean = g.float("normalizer.mean", &[1, size], &n.mean);
        let scale = g.float("normalizer.scale", &[1, size], &n.scale);
        x = g.node("Sub", &[&x, &mean], "obs_centered");
        x = g.node("Mul", &[&x, &scale], "obs_normalized");
        if let Some(clip) = n.clip {
            let low = g.float("normalizer.low", &[], &[-clip]);
            let high = g.float("normalizer.high", &[], &[clip]);
            x = g.node("Clip", &[&x, &low, &high], "obs_clipped");
        }
    }
    if let Some(first) = weights.lstm.first() {
        let observed = weights.observations();
        if weights.is_beside() {
            let seen = g.last_features(&x, first.inputs, observed);
            let remembered = g.lstm(&weights.lstm, first.hidden, seen);
            x = g.node("Concat", &[&x, &remembered], "observed_and_remembered");
            g.attribute(int("axis", 1));
        } else {
            x = g.lstm(&weights.lstm, first.hidden, x);
        }
    }
    let last = weights.layers.len() - 1;
    let actions = if weights.mirror.is_some() { "actions_shown" } else { "actions" };
    for (i, layer) in weights.layers.iter().enumerate() {
        let w = g.float(&format!("actor.{i}.weight"), &[layer.outputs, layer.inputs], &layer.w);
        let b = g.float(&format!("actor.{i}.bias"), &[layer.outputs], &layer.b);
        let out = if i == last { actions.to_owned() } else { format!("linear_{i}") };
        x = g.node("Gemm", &[&x, &w, &b], &out);
        g.attribute(int("transB", 1));
        if i != last {
            x = g.node("Elu", &[&x], &format!("elu_{i}"));
            g.attribute(float("alpha", 1.0));
        }
    }
    if let Some(mirror) = &weights.mirror {
        g.mirrored("action", &mirror.action, &x, "actions");
    }
    g.graph.input.push(ValueInfo::float("time_step", &[1, 1]));
    if let Some(r) = reference {
        g.reference(r, joints, bodies);
    }
    g.graph
}

#[derive(Default)]
struct Builder {
    graph: GraphProto,
}

impl Builder {
    fn float(&mut self, name: &str, dims: &[usize], values: &[f32]) -> String {
        self.graph.initializer.push(TensorProto::float(name, dims, values));
        name.to_owned()
    }

    fn int64(&mut self, name: &str, values: &[i64]) -> String {
        self.graph.initializer.push(TensorProto::int64(name, values));
        name.to_owned()
    }

    fn nodes(&mut self, op: &str, inputs: &[&str], outputs: &[&str]) {
        self.graph.node.push(NodeProto {
            input: inputs.iter().map(|&s| s.to_owned()).collect(),
            output: outputs.iter().map(|&s| s.to_owned()).collect(),
            name: Some(format!("{}_{}", op.to_lowercase(), self.graph.node.len())),
            op_type: Some(op.to_owned()),
            attribute: Vec::new(),
        });
    }

    fn node(&mut self, op: &str, inputs: &[&str], output: &str) -> String {
        self.nodes(op, inputs, &[output]);
        output.to_owned()
    }

    /// Adds an attribute to the last node.
    fn attribute(&mut self, a: Attribute) {
        if let Some(n) = self.graph.node.last_mut() {
            n.attribute.push(a);
        }
    }

    /// `out` is `x` `[1, n]`, or its image where the policy acts in the mirror. The products are exact: the factors are 1 and -1.
    fn mirrored(&mut self, name: &str, mirror: &Mirror, x: &str, out: &str) -> String {
        let (from, signs): (Vec<i64>, Vec<f32>) =
            mirror.signs().map(|(from, sign)| (from as i64, sign)).unzip();
        let from = self.int64(&format!("mirror.{name}.from"), &from);
        let signs = self.float(&format!("mirror.{name}.sign"), &[1, signs.len()], &signs);
        let image = self.node("Gather", &[x, &from], &format!("{name}_swapped"));
        self.attribute(int("axis", 1));
        let image = self.node("Mul", &[&image, &signs], &format!("{name}_mirrored"));
        self.node("Where", &[IS_MIRRORED, &image, x], out)
    }

    /// The last `count` of the features `x` `[1, all]`.
    fn last_features(&mut self, x: &str, count: usize, all: usize) -> String {
        if count == all {
            return x.to_owned();
        }
        let first = self.int64("lstm.first_feature", &[(all - count) as i64]);
        let end = self.int64("lstm.features", &[all as i64]);
        let axis = self.int64("lstm.feature_axis", &[1]);
        self.node("Slice", &[x, &first, &end, &axis], "lstm_features")
    }

    /// The LSTM stack from `x` `[1, inputs]`; returns the last layer's output `[1, hidden]`.
    fn lstm(&mut self, layers: &[LstmLayer], hidden: usize, x: String) -> String {
        let (count, state) = (layers.len(), [layers.len(), 1, hidden]);
        for name in ["h_in", "c_in"] {
            self.graph.input.push(ValueInfo::float(name, &state));
        }
        for name in ["h_out", "c_out"] {
            self.graph.output.push(ValueInfo::float(name, &state));
        }
        let sequence = self.int64("lstm.sequence_shape", &[1, 1, -1]);
        let flat = self.int64("lstm.flat_shape", &[1, -1]);
        if count > 1 {
            self.int64("lstm.axis", &[0]);
        }
        let mut x = self.node("Reshape", &[&x, &sequence], "lstm_input");
        let (mut h_outs, mut c_outs) = (Vec::new(), Vec::new());
        for (i, layer) in layers.iter().enumerate() {
            let (mut h, mut c) = ("h_in".to_owned(), "c_in".to_owned());
            let (mut h_out, mut c_out) = ("h_out".to_owned(), "c_out".to_owned());
            if count > 1 {
                let start = self.int64(&format!("lstm.{i}.start"), &[i as i64]);
                let end = self.int64(&format!("lstm.{i}.end"), &[i as i64 + 1]);
                h = self.node("Slice", &[&h, &start, &end, "lstm.axis"], &format!("h_in_{i}"));
                c = self.node("Slice", &[&c, &start, &end, "lstm.axis"], &format!("c_in_{i}"));
                h_out = format!("h_out_{i}");
                c_out = format!("c_out_{i}");
            }
            let (rows, inputs) = (4 * hidden, layer.inputs);
            let w = gates_iofc(&layer.w_input, hidden, inputs);
            let r = gates_iofc(&layer.w_hidden, hidden, hidden);
            // ONNX adds an input and a recurrent bias; the second is zero.
            let mut b = gates_iofc(&layer.bias, hidden, 1);
            b.resize(2 * rows, 0.0);
            let w = self.float(&format!("lstm.{i}.W"), &[1, rows, inputs], &w);
            let r = self.float(&format!("lstm.{i}.R"), &[1, rows, hidden], &r);
            let b = self.float(&format!("lstm.{i}.B"), &[1, 2 * rows], &b);
            let y = format!("lstm_y_{i}");
            self.nodes("LSTM", &[&x, &w, &r, &b, "", &h, &c], &[&y, &h_out, &c_out]);
            self.attribute(int("hidden_size", hidden as i64));
            // The output [1, 1, 1, hidden] becomes the next layer's sequence.
            x = self.node("Reshape", &[&y, &sequence], &format!("lstm_output_{i}"));
            h_outs.push(h_out);
            c_outs.push(c_out);
        }
        if count > 1 {
            for (parts, name) in [(&h_outs, "h_out"), (&c_outs, "c_out")] {
                let parts: Vec<&str> = parts.iter().map(String::as_str).collect();
                self.node("Concat", &parts, name);
                self.attribute(int("axis", 0));
            }
        }
        self.node("Reshape", &[&x, &flat], "lstm_flat")
    }

    /// Outputs of the reference at `time_step`, which is held inside the clip.
    fn reference(&mut self, r: &Reference, joints: usize, bodies: usize) {
        let first = self.float("reference.first", &[], &[0.0]);
        let last = self.float("reference.last", &[], &[(r.frames - 1) as f32]);
        let one = self.int64("reference.index_shape", &[1]);
        let held = self.node("Clip", &["time_step", &first, &last], "time_step_held");
        let flat = self.node("Reshape", &[&held, &one], "time_step_flat");
        let index = self.node("Cast", &[&flat], "frame");
        self.attribute(int("to", i64::from(INT64)));
        for (name, shape, data) in r.arrays(joints, bodies) {
            let all: Vec<usize> = std::iter::once(r.frames).chain(shape.iter().copied()).collect();
            let array = self.float(&format!("reference.{name}"), &all, data);
            self.node("Gather", &[&array, &index], name);
            self.attribute(int("axis", 0));
            let out: Vec<usize> = std::iter::once(1).chain(shape).collect();
            self.graph.output.push(ValueInfo::float(name, &out));
        }
    }
}

/// The reverse of [`gates_iofc`].
pub(crate) fn gates_ifco(values: &[f32], hidden: usize, columns: usize) -> Vec<f32> {
    let block = hidden * columns;
    [0, 2, 3, 1].iter().flat_map(|&g| values[g * block..(g + 1) * block].iter().copied()).collect()
}

/// Rows of a gate-stacked matrix from our order (input, forget, cell, output) to ONNX's (input, output, forget, cell).
fn gates_iofc(values: &[f32], hidden: usize, columns: usize) -> Vec<f32> {
    let block = hidden * columns;
    [0, 3, 1, 2].iter().flat_map(|&g| values[g * block..(g + 1) * block].iter().copied()).collect()
}

fn int(name: &str, i: i64) -> Attribute {
    Attribute { name: Some(name.to_owned()), i: Some(i), r#type: Some(ATTRIBUTE_INT), ..Attribute::default() }
}

fn float(name: &str, f: f32) -> Attribute {
    Attribute {
        name: Some(name.to_owned()),
        f: Some(f),
        r#type: Some(ATTRIBUTE_FLOAT),
        ..Attribute::default()
    }
}
