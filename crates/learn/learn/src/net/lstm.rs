//! Training of an LSTM layer: forward with caches, and back through time.

use paid_lanes::{Real, Scalar};
use paid_policy::bf16::Scratch;
use paid_policy::element::{Element, Lanewise, load, store, sum};
use paid_policy::matrix::{Mat, MatMut};
use paid_policy::net::{Cell, Lstm, Weights};

/// What the forward pass over a sequence keeps for the backward pass; matrices of `steps * width` columns, step `t` in
/// columns `t * width ..`.
#[derive(Clone, Debug, Default)]
pub struct LstmCache<S> {
    cols: usize,
    /// Gates after activation, `[4 size, cols]`; their gradients after the backward pass.
    gates: Vec<S>,
    /// Cell state before each step (after masking), `[size, cols]`.
    c_prev: Vec<S>,
    /// Hidden state before each step (after masking).
    h_prev: Vec<S>,
    /// `tanh` of the cell state after each step.
    tanh_c: Vec<S>,
    /// Hidden state after each step: the layer's output.
    h: Vec<S>,
    /// Gradient of the output; [`backward`] reads and overwrites it.
    dh: Vec<S>,
    /// Cell state, and its gradient on the way back, of one step `[size, width]`.
    c: Vec<S>,
}

impl<S: Element> LstmCache<S> {
    fn resize(&mut self, size: usize, cols: usize, width: usize) {
        self.cols = cols;
        self.gates.resize(4 * size * cols, S::default());
        for v in [&mut self.c_prev, &mut self.h_prev, &mut self.tanh_c, &mut self.h, &mut self.dh] {
            v.resize(size * cols, S::default());
        }
        self.c.resize(size * width, S::default());
    }

    /// The layer's output, `[size, cols]`.
    pub fn output(&self) -> Mat<'_, S> {
        Mat::new(&self.h, self.h.len() / self.cols, self.cols, self.cols)
    }

    /// The activated gates i, f, g, o, `[4 size, cols]`, before the backward pass.
    pub fn gates(&self) -> Mat<'_, S> {
        Mat::new(&self.gates, self.gates.len() / self.cols, self.cols, self.cols)
    }

    /// The output and where its gradient goes.
    pub fn output_and_gradient(&mut self) -> (Mat<'_, S>, MatMut<'_, S>) {
        let rows = self.h.len() / self.cols;
        (Mat::new(&self.h, rows, self.cols, self.cols), MatMut::new(&mut self.dh, rows, self.cols, self.cols))
    }
}

/// Shape of a sequence: `steps` steps of `width` parallel environments, step-major columns.
#[derive(Clone, Copy, Debug)]
pub struct Steps<'a, S> {
    /// Number of steps.
    pub steps: usize,
    /// Environments per step.
    pub width: usize,
    /// `[steps * width]`: 0 where an episode began at that step (the state is cleared before it), else 1.
    pub mask: &'a [S],
}

/// Runs `layer` over a whole sequence `x` `[input, steps * width]` from the states `h0`, `c0` `[size, width]`.
pub fn forward<S: Element>(
    layer: &Lstm,
    weights: Weights<'_, S>,
    x: Mat<'_, S>,
    steps: Steps<'_, S>,
    (h0, c0): (&[S], &[S]),
    cache: &mut LstmCache<S>,
    scratch: &mut Scratch,
) {
    let Steps { steps, width, mask } = steps;
    let (size, cols) = (layer.size, steps * width);
    cache.resize(size, cols, width);
    let gates = MatMut::new(&mut cache.gates, 4 * size, cols, cols);
    weights.times(&layer.weight_ih, x, gates, false, scratch);
    cache.c.copy_from_slice(&c0[..size * width]);
    for t in 0..steps {
        let first = t * width;
        let h = if t == 0 {
            Mat::new(h0, size, width, width)
        } else {
            Mat::new(&cache.h, size, cols, cols).columns(first - width, width)
        };
        S::launch(Begin {
            mask: &mask[first..first + width],
            h,
            c: MatMut::new(&mut cache.c, size, width, width),
            h_prev: MatMut::new(&mut cache.h_prev, size, cols, cols).columns(first, width),
            c_prev: MatMut::new(&mut cache.c_prev, size, cols, cols).columns(first, width),
        });
        let h_prev = Mat::new(&cache.h_prev, size, cols, cols).columns(first, width);
        let mut gates = MatMut::new(&mut cache.gates, 4 * size, cols, cols);
        weights.times(&layer.weight_hh, h_prev, gates.columns(first, width), true, scratch);
        S::launch(Cell {
            gates: gates.columns(first, width),
            bias: &weights.values()[layer.bias.clone()],
            c: MatMut::new(&mut cache.c, size, width, width),
            h: MatMut::new(&mut cache.h, size, cols, cols).columns(first, width),
            tanh_c: Some(MatMut::new(&mut cache.tanh_c, size, cols, cols).columns(first, width)),
        });
    }
}

/// Backward through time from the output gradient in the cache; adds to `grads`, writes the input gradient to `dx`
/// `[input, steps * width]` if wanted. The states at the start are constants (truncated backpropagation).
#[allow(clippy::too_many_arguments)]
pub fn backward<S: Element>(
    layer: &Lstm,
    weights: Weights<'_, S>,
    grads: &mut [S],
    x: Mat<'_, S>,
    steps: Steps<'_, S>,
    cache: &mut LstmCache<S>,
    dx: Option<MatMut<'_, S>>,
    scratch: &mut Scratch,
) {
    let Steps { steps, width, mask } = steps;
    let (size, cols) = (layer.size, steps * width);
    cache.c.fill(S::default());
    for t in (0..steps).rev() {
        let first = t * width;
        let view = |data, rows| Mat::new(data, rows, cols, cols).columns(first, width);
        let mut gates = MatMut::new(&mut cache.gates, 4 * size, cols, cols);
        S::launch(CellBackward {
            gates: gates.columns(first, width),
            c_prev: view(&cache.c_prev, size),
            tanh_c: view(&cache.tanh_c, size),
            dh: view(&cache.dh, size),
            mask: &mask[first..first + width],
            dc: MatMut::new(&mut cache.c, size, width, width),
            dbias: &mut grads[layer.bias.clone()],
        });
        if t > 0 {
            // The hidden state of step t-1 reaches step t only where no episode began: its gradient is computed
            // into this step's columns (already used) and added to those of step t-1 under the mask.
            let mut dh = MatMut::new(&mut cache.dh, size, cols, cols);
            let dgates = Mat::new(&cache.gates, 4 * size, cols, cols).columns(first, width);
            weights.transposed_times(&layer.weight_hh, dgates, dh.columns(first, width), scratch);
            S::launch(AddCarried { mask: &mask[first..first + width], first, dh });
        }
    }
    let dgates = Mat::new(&cache.gates, 4 * size, cols, cols);
    let h_prev = Mat::new(&cache.h_prev, size, cols, cols);
    let dw_hh = MatMut::new(&mut grads[layer.weight_hh.clone()], 4 * size, size, size);
    weights.add_outer(&layer.weight_hh, dgates, h_prev, dw_hh, scratch);
    let dw_ih = MatMut::new(&mut grads[layer.weight_ih.clone()], 4 * size, layer.input, layer.input);
    weights.add_outer(&layer.weight_ih, dgates, x, dw_ih, scratch);
    if let Some(dx) = dx {
        weights.transposed_times(&layer.weight_ih, dgates, dx, scratch);
    }
}

/// The states before a step: those after the last one, zero where an episode begins.
struct Begin<'a, S> {
    mask: &'a [S],
    /// Hidden state after the last step, `[size, width]`.
    h: Mat<'a, S>,
    /// Cell state after the last step, cleared in place.
    c: MatMut<'a, S>,
    h_prev: MatMut<'a, S>,
    c_prev: MatMut<'a, S>,
}

impl<S: Scalar + Element> Lanewise<S> for Begin<'_, S> {
    type Output = ();
    #[inline(always)]
    fn run<V: Real<Scalar = S>>(mut self) {
        for r in 0..self.h.rows() {
            let mut k = 0;
            while k < self.mask.len() {
                let alive = V::zero().lt(load::<V>(self.mask, k));
                let c = V::select(alive, load::<V>(self.c.row(r), k), V::zero());
                store(c, self.c.row(r), k);
                store(c, self.c_prev.row(r), k);
                store(V::select(alive, load::<V>(self.h.row(r), k), V::zero()), self.h_prev.row(r), k);
                k += V::LANES;
            }
        }
    }
}

/// Adds the hidden state's gradient of the step at column `first` to that of the step before, but where an episode begins.
struct AddCarried<'a, S> {
    mask: &'a [S],
    first: usize,
    dh: MatMut<'a, S>,
}

impl<S: Scalar + Element> Lanewise<S> for AddCarried<'_, S> {
    type Output = ();
    #[inline(always)]
    fn run<V: Real<Scalar = S>>(mut self) {
        let width = self.mask.len();
        for r in 0..self.dh.rows() {
            let (before, now) = self.dh.row(r).split_at_mut(self.first);
            let (before, now) = (&mut before[self.first - width..], &now[..width]);
            let mut k = 0;
            while k < width {
                let alive = V::zero().lt(load::<V>(self.mask, k));
                let here = load::<V>(before, k);
                store(V::select(alive, here + load::<V>(now, k), here), before, k);
                k += V::LANES;
            }
        }
    }
}

/// Backward of [`Cell`]: activated gates become gradients before activation; `dc` moves one step back.
struct CellBackward<'a, S> {
    gates: MatMut<'a, S>,
    c_prev: Mat<'a, S>,
    tanh_c: Mat<'a, S>,
    dh: Mat<'a, S>,
    mask: &'a [S],
    dc: MatMut<'a, S>,
    dbias: &'a mut [S],
}

impl<S: Scalar + Element> Lanewise<S> for CellBackward<'_, S> {
    type Output = ();
    #[inline(always)]
    fn run<V: Real<Scalar = S>>(mut self) {
        let size = self.dbias.len() / 4;
        let n = self.mask.len();
        let one = V::one();
        for r in 0..size {
            let mut totals = [V::zero(); 4];
            let mut k = 0;
            while k < n {
                let i = load::<V>(self.gates.row(r), k);
                let f = load::<V>(self.gates.row(size + r), k);
                let g = load::<V>(self.gates.row(2 * size + r), k);
                let o = load::<V>(self.gates.row(3 * size + r), k);
                let tanh_c = load::<V>(self.tanh_c.row(r), k);
                let dh = load::<V>(self.dh.row(r), k);
                let dc = load::<V>(self.dc.row(r), k) + dh * o * (one - tanh_c * tanh_c);
                let d = [
                    dc * g * i * (one - i),
                    dc * load::<V>(self.c_prev.row(r), k) * f * (one - f),
                    dc * i * (one - g * g),
                    dh * tanh_c * o * (one - o),
                ];
                for gate in 0..4 {
                    store(d[gate], self.gates.row(gate * size + r), k);
                    totals[gate] += d[gate];
                }
                store(dc * f * load::<V>(self.mask, k), self.dc.row(r), k);
                k += V::LANES;
            }
            for gate in 0..4 {
                let place = &mut self.dbias[gate * size + r];
                *place = S::from_f64(place.to_f64() + sum(totals[gate]));
            }
        }
    }
}
