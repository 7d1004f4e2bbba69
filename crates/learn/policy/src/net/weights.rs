//! A network's parameters as its products read them: as they are, or packed in bfloat16.

use core::ops::Range;

use super::{Layout, Network};
use crate::bf16::{Kernel, Rows, Scratch};
use crate::element::Element;
use crate::matrix::{Mat, MatMut, multiply};

/// Weight matrices of a network in bfloat16. The last layer is not among them: the output is computed in f32.
#[derive(Clone, Debug)]
pub struct PackedWeights {
    kernel: Kernel,
    tensors: Vec<Tensor>,
}

/// One weight matrix.
#[derive(Clone, Debug)]
struct Tensor {
    /// Its place in the parameters.
    range: Range<usize>,
    shape: [usize; 2],
    straight: Rows,
    /// For the gradient of the input, but of the first `fixed` features, which needs none.
    transposed: Rows,
    fixed: usize,
}

impl PackedWeights {
    /// Rounds and packs the parameters of `net`.
    pub fn new(kernel: Kernel, net: &Network, params: &[f32]) -> Self {
        let inner = net.mlp.len().saturating_sub(1);
        let lstm = net.lstm.iter().flat_map(|layer| [&layer.weight_ih, &layer.weight_hh]);
        let mlp = net.mlp[..inner].iter().map(|layer| &layer.weight);
        let tensor = |range: &Range<usize>| Tensor {
            range: range.clone(),
            shape: shape(net.layout(), range),
            straight: Rows::default(),
            transposed: Rows::default(),
            fixed: net.fixed_inputs(range),
        };
        let mut packed = Self { kernel, tensors: lstm.chain(mlp).map(tensor).collect() };
        packed.pack(params);
        packed
    }

    /// Rounds and packs newer parameters of the same network.
    pub fn pack(&mut self, params: &[f32]) {
        for Tensor { range, shape: [rows, cols], straight, transposed, fixed } in &mut self.tensors {
            let matrix = Mat::new(&params[range.clone()], *rows, *cols, *cols);
            straight.pack(self.kernel, matrix);
            if *fixed < *cols {
                transposed.pack(self.kernel, matrix.columns(*fixed, *cols - *fixed).t());
            }
        }
    }

    fn tensor(&self, range: &Range<usize>) -> Option<&Tensor> {
        self.tensors.iter().find(|tensor| tensor.range == *range)
    }
}

/// Rows and columns of the weight matrix at a place.
fn shape(layout: &Layout, range: &Range<usize>) -> [usize; 2] {
    let spec = layout.tensors().iter().find(|spec| spec.range == *range);
    spec.map_or([0; 2], |spec| [spec.shape[0], spec.shape[1]])
}

/// Parameters of a network, and its weight matrices in bfloat16 if the products are to be in that.
#[derive(Clone, Copy, Debug)]
pub struct Weights<'a, S> {
    values: &'a [S],
    packed: Option<&'a PackedWeights>,
}

impl<'a, S: Element> Weights<'a, S> {
    /// `packed` must come from the same `values`.
    pub fn new(values: &'a [S], packed: Option<&'a PackedWeights>) -> Self {
        Self { values, packed }
    }

    /// The parameters as they are.
    pub fn values(&self) -> &'a [S] {
        self.values
    }

    /// `dst = W x`, or `dst += W x`, of the weight matrix `[dst.rows(), x.rows()]` at `place`.
    pub fn times(
        &self,
        place: &Range<usize>,
        x: Mat<'_, S>,
        mut dst: MatMut<'_, S>,
        accumulate: bool,
        scratch: &mut Scratch,
    ) {
        if let Some(packed) = self.packed
            && let Some(tensor) = packed.tensor(place)
            && let (Some(x), Some(dst)) = (x.f32(), dst.f32_mut())
        {
            scratch.panels.pack(packed.kernel, x);
            packed.kernel.multiply(dst, &tensor.straight, &scratch.panels, accumulate);
        } else {
            let (rows, cols) = (dst.rows(), x.rows());
            multiply(dst, Mat::new(&self.values[place.clone()], rows, cols, cols), x, accumulate);
        }
    }

    /// `dst = W^T y` of the weight matrix with `y.rows()` rows at `place`, or the last `dst.rows()` rows of that product.
    pub fn transposed_times(
        &self,
        place: &Range<usize>,
        y: Mat<'_, S>,
        mut dst: MatMut<'_, S>,
        scratch: &mut Scratch,
    ) {
        if let Some(packed) = self.packed
            && let Some(tensor) = packed.tensor(place)
            && tensor.transposed.rows() == dst.rows()
            && let (Some(y), Some(dst)) = (y.f32(), dst.f32_mut())
        {
            scratch.panels.pack(packed.kernel, y);
            packed.kernel.multiply(dst, &tensor.transposed, &scratch.panels, false);
        } else {
            let (rows, cols) = (y.rows(), place.len() / y.rows().max(1));
            let matrix = Mat::new(&self.values[place.clone()], rows, cols, cols);
            let wanted = dst.rows();
            multiply(dst, matrix.columns(cols - wanted, wanted).t(), y, false);
        }
    }

    /// `dst += y x^T`, the gradient of the weight matrix at `place`, in that matrix's precision.
    pub fn add_outer(
        &self,
        place: &Range<usize>,
        y: Mat<'_, S>,
        x: Mat<'_, S>,
        mut dst: MatMut<'_, S>,
        scratch: &mut Scratch,
    ) {
        if let Some(packed) = self.packed
            && packed.tensor(place).is_some()
            && let (Some(y), Some(x), Some(dst)) = (y.f32(), x.f32(), dst.f32_mut())
        {
            scratch.rows.pack(packed.kernel, y);
            scratch.panels.pack(packed.kernel, x.t());
            packed.kernel.multiply(dst, &scratch.rows, &scratch.panels, true);
        } else {
            multiply(dst, y, x.t(), true);
        }
    }
}

impl<'a, S> From<&'a [S]> for Weights<'a, S> {
    fn from(values: &'a [S]) -> Self {
        Self { values, packed: None }
    }
}

impl<'a, S> From<&'a Vec<S>> for Weights<'a, S> {
    fn from(values: &'a Vec<S>) -> Self {
        Self { values, packed: None }
    }
}
