//! Long short-term memory layer (Hochreiter and Schmidhuber 1997, with forget gate), gates in the order i, f, g, o.

use core::ops::Range;

use paid_lanes::rng::Rng;
use paid_lanes::{Real, Scalar};

use super::Weights;
use super::layout::Layout;
use crate::bf16::Scratch;
use crate::element::{Element, Lanewise, load, store};
use crate::matrix::{Mat, MatMut};

/// `c' = f c + i g`, `h' = o tanh(c')` with `i, f, o = sigmoid(.)`, `g = tanh(.)` of `W_ih x + W_hh h + b`.
#[derive(Clone, Debug)]
pub struct Lstm {
    /// Place of `W_ih`, `[4 size, input]`.
    pub weight_ih: Range<usize>,
    /// Place of `W_hh`, `[4 size, size]`.
    pub weight_hh: Range<usize>,
    /// Place of `b`, `[4 size]`.
    pub bias: Range<usize>,
    /// Features in.
    pub input: usize,
    /// Cells.
    pub size: usize,
}

impl Lstm {
    /// Appends the layer's tensors to a layout.
    pub fn new(layout: &mut Layout, name: &str, input: usize, size: usize) -> Self {
        let weight_ih = layout.add(format!("{name}.weight_ih"), &[4 * size, input]);
        let weight_hh = layout.add(format!("{name}.weight_hh"), &[4 * size, size]);
        let bias = layout.add(format!("{name}.bias"), &[4 * size]);
        Self { weight_ih, weight_hh, bias, input, size }
    }

    /// Uniform in +-1/sqrt(size): PyTorch's default, see [`super::Linear::initialize`].
    pub fn initialize<S: Element>(&self, params: &mut [S], rng: &mut Rng) {
        let bound = 1.0 / (self.size as f64).sqrt();
        for range in [self.weight_ih.clone(), self.weight_hh.clone(), self.bias.clone()] {
            for value in &mut params[range] {
                *value = S::from_f64(rng.uniform(-bound, bound));
            }
        }
    }

    /// Biases with which a cell keeps what it holds for 1 to 50 steps, so that it has something to forget from the start
    /// (Tallec and Ollivier 2018): log U(1, 50) at the forget gate, minus that at the input gate.
    pub fn initialize_spans<S: Element>(&self, params: &mut [S], rng: &mut Rng) {
        let (input, forget) = params[self.bias.clone()][..2 * self.size].split_at_mut(self.size);
        for (input, forget) in input.iter_mut().zip(forget) {
            let bias = rng.uniform(1.0, 50.0).ln();
            (*input, *forget) = (S::from_f64(-bias), S::from_f64(bias));
        }
    }

    /// One step without caches: `x` `[input, n]`, `h` and `c` `[size, n]` are replaced; `gates` is scratch of `4 size * n`.
    pub fn step<S: Element>(
        &self,
        weights: Weights<'_, S>,
        x: Mat<'_, S>,
        h: MatMut<'_, S>,
        c: MatMut<'_, S>,
        gates: &mut [S],
        scratch: &mut Scratch,
    ) {
        let n = x.cols();
        let gates = &mut gates[..4 * self.size * n];
        let into = MatMut::new(gates, 4 * self.size, n, n);
        weights.times(&self.weight_ih, x, into, false, scratch);
        let into = MatMut::new(gates, 4 * self.size, n, n);
        weights.times(&self.weight_hh, h.as_ref(), into, true, scratch);
        let bias = &weights.values()[self.bias.clone()];
        S::launch(Cell { gates: MatMut::new(gates, 4 * self.size, n, n), bias, c, h, tanh_c: None });
    }
}

#[inline(always)]
fn sigmoid<V: Real>(x: V) -> V {
    ((-x).exp() + V::one()).recip()
}

/// The elementwise part of a step, a kernel for [`Element::launch`].
#[derive(Debug)]
pub struct Cell<'a, S> {
    /// Gates before the bias, `[4 size, n]`; with `tanh_c` they are overwritten by the activated gates.
    pub gates: MatMut<'a, S>,
    /// `b`, `[4 size]`.
    pub bias: &'a [S],
    /// Cell state `[size, n]`, replaced.
    pub c: MatMut<'a, S>,
    /// Hidden state `[size, n]`, replaced.
    pub h: MatMut<'a, S>,
    /// Where training stores `tanh` of the new cell state, `[size, n]`; a step without training gives none.
    pub tanh_c: Option<MatMut<'a, S>>,
}

impl<S: Scalar + Element> Lanewise<S> for Cell<'_, S> {
    type Output = ();
    #[inline(always)]
    fn run<V: Real<Scalar = S>>(mut self) {
        let size = self.bias.len() / 4;
        let n = self.gates.cols();
        for r in 0..size {
            let bias = [
                V::splat(self.bias[r]),
                V::splat(self.bias[size + r]),
                V::splat(self.bias[2 * size + r]),
                V::splat(self.bias[3 * size + r]),
            ];
            let mut k = 0;
            while k < n {
                let i = sigmoid(load::<V>(self.gates.row(r), k) + bias[0]);
                let f = sigmoid(load::<V>(self.gates.row(size + r), k) + bias[1]);
                let g = (load::<V>(self.gates.row(2 * size + r), k) + bias[2]).tanh();
                let o = sigmoid(load::<V>(self.gates.row(3 * size + r), k) + bias[3]);
                let c = f.mul_add(load::<V>(self.c.row(r), k), i * g);
                let tanh_c = c.tanh();
                store(c, self.c.row(r), k);
                store(o * tanh_c, self.h.row(r), k);
                if let Some(cache) = &mut self.tanh_c {
                    store(i, self.gates.row(r), k);
                    store(f, self.gates.row(size + r), k);
                    store(g, self.gates.row(2 * size + r), k);
                    store(o, self.gates.row(3 * size + r), k);
                    store(tanh_c, cache.row(r), k);
                }
                k += V::LANES;
            }
        }
    }
}
