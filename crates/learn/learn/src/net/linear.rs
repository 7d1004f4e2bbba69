//! Training of a fully connected layer: the way back.

use paid_lanes::{Real, Scalar};
use paid_policy::bf16::Scratch;
use paid_policy::element::{Element, Lanewise, load, store, sum};
use paid_policy::matrix::{Mat, MatMut};
use paid_policy::net::{Linear, Weights};

/// Turns `dy` (gradient of the output `y` for the input `x`) into the gradient before the activation, adds the gradients of `W` and
/// `b` to `grads`, and writes the gradient of the input, or of its last
/// `dx.rows()` features, to `dx` if wanted.
pub fn backward<S: Element>(
    layer: &Linear,
    weights: Weights<'_, S>,
    grads: &mut [S],
    [x, y]: [Mat<'_, S>; 2],
    mut dy: MatMut<'_, S>,
    dx: Option<MatMut<'_, S>>,
    scratch: &mut Scratch,
) {
    S::launch(EluBackward { y, dy: dy.reborrow(), dbias: &mut grads[layer.bias.clone()], elu: layer.elu });
    let dw = MatMut::new(&mut grads[layer.weight.clone()], layer.output, layer.input, layer.input);
    weights.add_outer(&layer.weight, dy.as_ref(), x, dw, scratch);
    if let Some(dx) = dx {
        weights.transposed_times(&layer.weight, dy.as_ref(), dx, scratch);
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
