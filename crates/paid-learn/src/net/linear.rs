//! Fully connected layer with optional ELU.

use core::ops::Range;

use paid_lanes::rng::Rng;
use paid_lanes::{Real, Scalar};

use super::layout::Layout;
use crate::element::{Element, Lanewise, load, store, sum};
use crate::matrix::{Mat, MatMut, multiply};

/// `y = W x + b`, then ELU (`alpha` 1) if `elu`. `W` is `[output, input]`, row-major.
#[derive(Clone, Debug)]
pub struct Linear {
    /// Place of `W` in the parameters.
    pub weight: Range<usize>,
    /// Place of `b` in the parameters.
    pub bias: Range<usize>,
    /// Features in.
    pub input: usize,
    /// Features out.
    pub output: usize,
    /// ELU behind it.
    pub elu: bool,
}

impl Linear {
    /// Appends the layer's tensors `<name>.weight` and `<name>.bias` to a layout.
    pub fn new(layout: &mut Layout, name: &str, input: usize, output: usize, elu: bool) -> Self {
        let weight = layout.add(format!("{name}.weight"), &[output, input]);
        let bias = layout.add(format!("{name}.bias"), &[output]);
        Self { weight, bias, input, output, elu }
    }

    /// Uniform in +-1/sqrt(input) for weights and biases: PyTorch's default, under which the release's PPO constants
    /// were chosen; for a network with few layers it keeps the outputs near unit scale without an orthogonal basis.
    pub fn initialize<S: Element>(&self, params: &mut [S], rng: &mut Rng) {
        let bound = 1.0 / (self.input.max(1) as f64).sqrt();
        for range in [self.weight.clone(), self.bias.clone()] {
            for value in &mut params[range] {
                *value = S::from_f64(rng.uniform(-bound, bound));
            }
        }
    }

    fn weights<'a, S: Element>(&self, params: &'a [S]) -> Mat<'a, S> {
        Mat::new(&params[self.weight.clone()], self.output, self.input, self.input)
    }

    /// `x` `[input, n]` to `y` `[output, n]`, activation included.
    pub fn forward<S: Element>(&self, params: &[S], x: Mat<'_, S>, mut y: MatMut<'_, S>) {
        multiply(y.reborrow(), self.weights(params), x, false);
        S::launch(BiasElu { y, bias: &params[self.bias.clone()], elu: self.elu });
    }

    /// Turns `dy` (gradient of the output `y`) into the gradient before the activation, adds the gradients of `W` and
    /// `b` to `grads`, and writes the gradient of the input to `dx` if wanted.
    pub fn backward<S: Element>(
        &self,
        params: &[S],
        grads: &mut [S],
        x: Mat<'_, S>,
        y: Mat<'_, S>,
        mut dy: MatMut<'_, S>,
        dx: Option<MatMut<'_, S>>,
    ) {
        S::launch(EluBackward { y, dy: dy.reborrow(), dbias: &mut grads[self.bias.clone()], elu: self.elu });
        let dw = MatMut::new(&mut grads[self.weight.clone()], self.output, self.input, self.input);
        multiply(dw, dy.as_ref(), x.t(), true);
        if let Some(dx) = dx {
            multiply(dx, self.weights(params).t(), dy.as_ref(), false);
        }
    }
}

/// Adds a bias a row, then applies ELU.
struct BiasElu<'a, S> {
    y: MatMut<'a, S>,
    bias: &'a [S],
    elu: bool,
}

impl<S: Scalar + Element> Lanewise<S> for BiasElu<'_, S> {
    type Output = ();
    #[inline(always)]
    fn run<V: Real<Scalar = S>>(mut self) {
        for r in 0..self.bias.len() {
            let bias = V::splat(self.bias[r]);
            let row = self.y.row(r);
            let mut i = 0;
            while i < row.len() {
                let mut y = load::<V>(row, i) + bias;
                if self.elu {
                    y = V::select(V::zero().lt(y), y, y.exp() - V::one());
                }
                store(y, row, i);
                i += V::LANES;
            }
        }
    }
}

/// Multiplies by the derivative of ELU (from its output) and sums rows into the bias gradient.
struct EluBackward<'a, S> {
    y: Mat<'a, S>,
    dy: MatMut<'a, S>,
    dbias: &'a mut [S],
    elu: bool,
}

impl<S: Scalar + Element> Lanewise<S> for EluBackward<'_, S> {
    type Output = ();
    #[inline(always)]
    fn run<V: Real<Scalar = S>>(mut self) {
        for r in 0..self.dbias.len() {
            let y = self.y.row(r);
            let dy = self.dy.row(r);
            let mut total = V::zero();
            let mut i = 0;
            while i < y.len() {
                let mut d = load::<V>(dy, i);
                if self.elu {
                    let out = load::<V>(y, i);
                    d *= out.min(V::zero()) + V::one();
                    store(d, dy, i);
                }
                total += d;
                i += V::LANES;
            }
            self.dbias[r] = S::from_f64(self.dbias[r].to_f64() + sum(total));
        }
    }
}
