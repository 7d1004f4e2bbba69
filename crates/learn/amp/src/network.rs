//! The discriminator's network: a perceptron with ReLU and one score, its gradient, and the gradient of its input gradient.

use core::ops::Range;

use paid_lanes::rng::Rng;
use paid_policy::element::Element;
use paid_policy::matrix::{Mat, MatMut, multiply};

/// Shape of the network. Parameters lie in one flat slice: of each layer the weights `[output, input]`, then the biases.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Perceptron {
    /// Input, hidden widths, 1.
    sizes: Vec<usize>,
}

/// What the way forward leaves for the ways back; samples are columns.
#[derive(Clone, Debug, Default)]
pub struct Tape<S> {
    samples: usize,
    /// Outputs of the hidden layers, `[width, samples]` each, then the scores.
    outputs: Vec<Vec<S>>,
    /// Gradients of the score with respect to the hidden layers before their ReLU, `[width, samples]` each.
    slopes: Vec<Vec<S>>,
    /// Gradient of the score with respect to the input, `[input, samples]`.
    input_slope: Vec<S>,
    /// Room for one layer's gradients, twice.
    scratch: [Vec<S>; 2],
}

impl<S: Element> Tape<S> {
    /// The scores of the last way forward.
    pub fn scores(&self) -> &[S] {
        self.outputs.last().map_or(&[], Vec::as_slice)
    }
}

/// Sets the length without keeping contents.
fn room<S: Element>(buffer: &mut Vec<S>, len: usize) -> &mut [S] {
    buffer.resize(len, S::from_f64(0.0));
    buffer
}

/// Sets `values` to zero where the ReLU's output is.
fn mask<S: Element>(values: &mut [S], outputs: &[S]) {
    let zero = S::from_f64(0.0);
    for (value, output) in values.iter_mut().zip(outputs) {
        if *output <= zero {
            *value = zero;
        }
    }
}

impl Perceptron {
    /// A network for inputs of `input` numbers.
    pub fn new(input: usize, hidden: &[usize]) -> Self {
        let mut sizes = vec![input];
        sizes.extend(hidden);
        sizes.push(1);
        Self { sizes }
    }

    /// Numbers of an input.
    pub fn input(&self) -> usize {
        self.sizes[0]
    }

    fn layers(&self) -> usize {
        self.sizes.len() - 1
    }

    /// Number of parameters.
    pub fn params(&self) -> usize {
        self.sizes.windows(2).map(|pair| pair[1] * (pair[0] + 1)).sum()
    }

    /// Where the weights of layer `l` are.
    pub fn weights(&self, l: usize) -> Range<usize> {
        let start: usize = self.sizes.windows(2).take(l).map(|pair| pair[1] * (pair[0] + 1)).sum();
        start..start + self.sizes[l + 1] * self.sizes[l]
    }

    /// Where the biases of layer `l` are.
    pub fn biases(&self, l: usize) -> Range<usize> {
        let start = self.weights(l).end;
        start..start + self.sizes[l + 1]
    }

    /// Where all weights are, layer by layer.
    pub fn all_weights(&self) -> impl Iterator<Item = Range<usize>> {
        (0..self.layers()).map(|l| self.weights(l))
    }

    /// Fresh parameters: normal weights of variance 2 over the fan-in (He et al. 2015), of a tenth of that deviation for the score;
    /// biases zero.
    pub fn initialize(&self, rng: &mut Rng) -> Vec<f32> {
        let mut params = vec![0.0; self.params()];
        for l in 0..self.layers() {
            let factor = if l + 1 == self.layers() { 0.1 } else { 1.0 };
            let deviation = factor * (2.0 / self.sizes[l] as f64).sqrt();
            for weight in &mut params[self.weights(l)] {
                *weight = (deviation * rng.normal()) as f32;
            }
        }
        params
    }

    fn matrix<'a, S: Element>(&self, params: &'a [S], l: usize) -> Mat<'a, S> {
        Mat::new(&params[self.weights(l)], self.sizes[l + 1], self.sizes[l], self.sizes[l])
    }

    /// Scores of the columns of `x` `[input, samples]`, row-major without gaps; they lie in the tape.
    ///
    /// # Panics
    /// If parameters or input have another length.
    pub fn forward<S: Element>(&self, params: &[S], x: &[S], samples: usize, tape: &mut Tape<S>) {
        assert_eq!((params.len(), x.len()), (self.params(), self.input() * samples), "parameters and input");
        let zero = S::from_f64(0.0);
        tape.samples = samples;
        tape.outputs.resize(self.layers(), Vec::new());
        for l in 0..self.layers() {
            let (before, after) = tape.outputs.split_at_mut(l);
            let out = room(&mut after[0], self.sizes[l + 1] * samples);
            for (row, bias) in out.chunks_exact_mut(samples).zip(&params[self.biases(l)]) {
                row.fill(*bias);
            }
            let input = before.last().map_or(x, Vec::as_slice);
            let input = Mat::new(input, self.sizes[l], samples, samples);
            let rows = self.sizes[l + 1];
            multiply(MatMut::new(out, rows, samples, samples), self.matrix(params, l), input, true);
            if l + 1 < self.layers() {
                for value in out {
                    if *value < zero {
                        *value = zero;
                    }
                }
            }
        }
    }

    /// Adds the gradient of a loss to `grads`: `score_gradient` `[samples]` is its gradient with respect to the scores of the last way
    /// forward, whose input was `x`.
    pub fn backward<S: Element>(
        &self,
        params: &[S],
        x: &[S],
        score_gradient: &[S],
        tape: &mut Tape<S>,
        grads: &mut [S],
    ) {
        let n = tape.samples;
        let [mut gradient, mut other] = core::mem::take(&mut tape.scratch);
        gradient.clear();
        gradient.extend_from_slice(score_gradient);
        for l in (0..self.layers()).rev() {
            let (rows, cols) = (self.sizes[l + 1], self.sizes[l]);
            let input = if l == 0 { x } else { &tape.outputs[l - 1] };
            for (bias, row) in grads[self.biases(l)].iter_mut().zip(gradient.chunks_exact(n)) {
                let sum: f64 = row.iter().map(|value| value.to_f64()).sum();
                *bias = S::from_f64(bias.to_f64() + sum);
            }
            let dw = MatMut::new(&mut grads[self.weights(l)], rows, cols, cols);
            let out = Mat::new(&gradient, rows, n, n);
            multiply(dw, out, Mat::new(input, cols, n, n).t(), true);
            if l > 0 {
                let into = room(&mut other, cols * n);
                multiply(MatMut::new(into, cols, n, n), self.matrix(params, l).t(), out, false);
                mask(into, input);
                core::mem::swap(&mut gradient, &mut other);
            }
        }
        tape.scratch = [gradient, other];
    }

    /// Gradient of each score with respect to its input, `[input, samples]`, after a way forward.
    pub fn input_gradient<'a, S: Element>(&self, params: &[S], tape: &'a mut Tape<S>) -> &'a [S] {
        let (n, hidden) = (tape.samples, self.layers() - 1);
        tape.slopes.resize(hidden, Vec::new());
        for l in (0..hidden).rev() {
            let rows = self.sizes[l + 1];
            let (here, above) = tape.slopes.split_at_mut(l + 1);
            let slope = room(&mut here[l], rows * n);
            match above.first() {
                // The score's own weights, alike for all samples.
                None => {
                    let weights = &params[self.weights(hidden)];
                    for (row, weight) in slope.chunks_exact_mut(n).zip(weights) {
                        row.fill(*weight);
                    }
                }
                Some(above) => {
                    let above = Mat::new(above, self.sizes[l + 2], n, n);
                    let dst = MatMut::new(slope, rows, n, n);
                    multiply(dst, self.matrix(params, l + 1).t(), above, false);
                }
            }
            mask(slope, &tape.outputs[l]);
        }
        let input = room(&mut tape.input_slope, self.input() * n);
        let first = Mat::new(&tape.slopes[0], self.sizes[1], n, n);
        multiply(MatMut::new(input, self.input(), n, n), self.matrix(params, 0).t(), first, false);
        &tape.input_slope
    }

    /// Adds the gradient of a loss of the input gradient to `grads`: `gradient` `[input, samples]` is that loss's gradient with respect to
    /// what [`Perceptron::input_gradient`] gave. ReLU has no curvature, so only the weights' products count.
    pub fn backward_input_gradient<S: Element>(
        &self,
        params: &[S],
        gradient: &[S],
        tape: &mut Tape<S>,
        grads: &mut [S],
    ) {
        let (n, hidden) = (tape.samples, self.layers() - 1);
        let [mut below, mut here] = core::mem::take(&mut tape.scratch);
        below.clear();
        below.extend_from_slice(gradient);
        for l in 0..hidden {
            let (rows, cols) = (self.sizes[l + 1], self.sizes[l]);
            let from = Mat::new(&below, cols, n, n);
            let dw = MatMut::new(&mut grads[self.weights(l)], rows, cols, cols);
            multiply(dw, Mat::new(&tape.slopes[l], rows, n, n), from.t(), true);
            let into = room(&mut here, rows * n);
            multiply(MatMut::new(into, rows, n, n), self.matrix(params, l), from, false);
            mask(into, &tape.outputs[l]);
            core::mem::swap(&mut below, &mut here);
        }
        for (weight, row) in grads[self.weights(hidden)].iter_mut().zip(below.chunks_exact(n)) {
            let sum: f64 = row.iter().map(|value| value.to_f64()).sum();
            *weight = S::from_f64(weight.to_f64() + sum);
        }
        tape.scratch = [below, here];
    }
}
