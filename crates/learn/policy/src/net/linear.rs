//! Fully connected layer with optional ELU.

use core::ops::Range;

use paid_lanes::rng::Rng;
use paid_lanes::{Real, Scalar};

use super::Weights;
use super::layout::Layout;
use crate::bf16::Scratch;
use crate::element::{Element, Lanewise, load, store};
use crate::matrix::{Mat, MatMut};

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
        self.initialize_first(self.input, params, rng);
    }

    /// As [`Linear::initialize`] if there were only the `first` inputs. The weights of the others stay as they are.
    pub fn initialize_first<S: Element>(&self, first: usize, params: &mut [S], rng: &mut Rng) {
        let bound = 1.0 / (first.max(1) as f64).sqrt();
        let mut draw = || S::from_f64(rng.uniform(-bound, bound));
        for row in params[self.weight.clone()].chunks_exact_mut(self.input.max(1)) {
            row[..first].fill_with(&mut draw);
        }
        params[self.bias.clone()].fill_with(draw);
    }

    /// `x` `[input, n]` to `y` `[output, n]`, activation included.
    pub fn forward<S: Element>(
        &self,
        weights: Weights<'_, S>,
        x: Mat<'_, S>,
        mut y: MatMut<'_, S>,
        scratch: &mut Scratch,
    ) {
        weights.times(&self.weight, x, y.reborrow(), false, scratch);
        S::launch(BiasElu { y, bias: &weights.values()[self.bias.clone()], elu: self.elu });
    }
}

/// Adds each row's bias, then applies ELU.
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
