//! A policy's numbers as plain arrays, independent of how they were learned.

use paid_policy::Mirrors;

/// Observation normalization: `clamp((obs - mean) * scale, -clip, clip)` per feature.
#[derive(Clone, Debug, PartialEq)]
pub struct NormalizerWeights {
    /// Mean `[features]`.
    pub mean: Vec<f32>,
    /// Factor `[features]`, positive: the inverse of the standard deviation and whatever the learner adds to it.
    pub scale: Vec<f32>,
    /// Bound of the normalized value, if the learner clips it.
    pub clip: Option<f32>,
}

/// One LSTM layer. The four gates are stacked in the order input, forget, cell, output.
#[derive(Clone, Debug, PartialEq)]
pub struct LstmLayer {
    /// Number of inputs `I`.
    pub inputs: usize,
    /// State size `H`.
    pub hidden: usize,
    /// Input weights `[4 H, I]`, row-major.
    pub w_input: Vec<f32>,
    /// Recurrent weights `[4 H, H]`, row-major.
    pub w_hidden: Vec<f32>,
    /// Bias `[4 H]`.
    pub bias: Vec<f32>,
}

/// A fully connected layer.
#[derive(Clone, Debug, PartialEq)]
pub struct DenseLayer {
    /// Number of inputs.
    pub inputs: usize,
    /// Number of outputs.
    pub outputs: usize,
    /// Weights `[outputs, inputs]`, row-major.
    pub w: Vec<f32>,
    /// Bias `[outputs]`.
    pub b: Vec<f32>,
}

/// The deterministic policy: normalizer, LSTM layers, dense layers with ELU between them and none after the last. Where the first dense
/// layer has more inputs than the LSTM has outputs, it reads the whole observation and, behind it, the LSTM's output; the LSTM reads as
/// many of the observation's last features as it has inputs.
#[derive(Clone, Debug, PartialEq)]
pub struct PolicyWeights {
    /// Observation normalization.
    pub normalizer: Option<NormalizerWeights>,
    /// Recurrent layers from input to output; empty for a feed-forward policy. All of one state size.
    pub lstm: Vec<LstmLayer>,
    /// Dense layers from input to output; at least one.
    pub layers: Vec<DenseLayer>,
    /// How observation and actions read in a mirrored world, of a policy that is played in the mirror too.
    pub mirror: Option<Mirrors>,
}

impl PolicyWeights {
    /// Number of observations, from the first layer; 0 if there is none.
    pub fn observations(&self) -> usize {
        let dense = self.layers.first().map_or(0, |l| l.inputs);
        match self.lstm.last() {
            None => dense,
            Some(last) if dense > last.hidden => dense - last.hidden,
            Some(_) => self.lstm[0].inputs,
        }
    }

    /// True if the first dense layer reads the observation beside the LSTM's output.
    pub(crate) fn is_beside(&self) -> bool {
        self.lstm.last().zip(self.layers.first()).is_some_and(|(last, dense)| dense.inputs > last.hidden)
    }

    /// Number of actions, from the last layer; 0 if there is none.
    pub fn actions(&self) -> usize {
        self.layers.last().map_or(0, |l| l.outputs)
    }

    /// Checks that the sizes chain from the observations to the actions and that every number is finite.
    ///
    /// # Errors
    /// A sentence that names the layer, the expected and the found size.
    pub fn check(&self) -> Result<(), String> {
        let mut width = self.observations();
        if let Some(n) = &self.normalizer {
            check("normalizer mean", &n.mean, width)?;
            check("normalizer scale", &n.scale, width)?;
            if let Some(i) = n.scale.iter().position(|&s| s <= 0.0) {
                return Err(format!("normalizer scale[{i}] is {}, expected a positive number", n.scale[i]));
            }
            if n.clip.is_some_and(|c| !c.is_finite() || c <= 0.0) {
                return Err("normalizer clip is not a positive number".to_owned());
            }
        }
        let hidden = self.lstm.first().map_or(0, |l| l.hidden);
        let direct = if self.is_beside() { width } else { 0 };
        if let Some(first) = self.lstm.first().filter(|_| direct > 0) {
            if first.inputs > width {
                let found = first.inputs;
                return Err(format!("LSTM layer 0 has {found} inputs, expected at most {width}"));
            }
            width = first.inputs;
        }
        for (i, l) in self.lstm.iter().enumerate() {
            if (l.inputs, l.hidden) != (width, hidden) {
                return Err(format!(
                    "LSTM layer {i} has {} inputs and state {}, expected {width} and {hidden}",
                    l.inputs, l.hidden
                ));
            }
            check(&format!("LSTM layer {i} input weights"), &l.w_input, 4 * l.hidden * l.inputs)?;
            check(&format!("LSTM layer {i} recurrent weights"), &l.w_hidden, 4 * l.hidden * l.hidden)?;
            check(&format!("LSTM layer {i} bias"), &l.bias, 4 * l.hidden)?;
            width = l.hidden;
        }
        width += direct;
        if self.layers.is_empty() {
            return Err("no dense layer".to_owned());
        }
        for (i, l) in self.layers.iter().enumerate() {
            if l.inputs != width {
                return Err(format!("layer {i} has {} inputs, expected {width}", l.inputs));
            }
            check(&format!("layer {i} weights"), &l.w, l.outputs * l.inputs)?;
            check(&format!("layer {i} bias"), &l.b, l.outputs)?;
            width = l.outputs;
        }
        if let Some(mirror) = &self.mirror {
            let (expected, found) =
                ((self.observations(), width), (mirror.observation.len(), mirror.action.len()));
            if expected != found {
                return Err(format!("mirror of {found:?} observations and actions, expected {expected:?}"));
            }
        }
        if width == 0 || self.observations() == 0 {
            return Err("no inputs or no outputs".to_owned());
        }
        Ok(())
    }
}

fn check(what: &str, values: &[f32], len: usize) -> Result<(), String> {
    if values.len() != len {
        return Err(format!("{what}: expected {len} numbers, found {}", values.len()));
    }
    match values.iter().position(|v| !v.is_finite()) {
        Some(i) => Err(format!("{what}[{i}] is {}, expected a finite number", values[i])),
        None => Ok(()),
    }
}
