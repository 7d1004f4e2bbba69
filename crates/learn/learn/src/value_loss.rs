//! Squared value error with rsl_rl's clipping.

use paid_lanes::Real;

use paid_policy::element::{Element, Lanewise, load, store, sum_valid};

/// What the value loss reads of a batch of `n` samples.
#[derive(Clone, Copy, Debug)]
pub struct ValueBatch<'a, S> {
    /// Values when the samples were collected, `[n]`.
    pub old_value: &'a [S],
    /// Returns: the wanted values, `[n]`.
    pub returns: &'a [S],
}

/// `max((v - R)^2, (v_clip - R)^2)` with `v_clip` within `clip` of the old value (plain `(v - R)^2` without a clip).
/// Writes `weight` times its gradient to `dvalue` and returns the sum of the losses.
///
/// Within the clip range `v_clip` is `v` but for rounding, so the plain gradient holds there whatever a comparison of
/// the two squares says; outside, the clipped branch has no gradient and the plain one keeps it on a tie.
pub fn value_loss<S: Element>(
    clip: Option<f64>,
    weight: f64,
    value: &[S],
    batch: ValueBatch<'_, S>,
    dvalue: &mut [S],
) -> f64 {
    let n = value.len();
    assert!(batch.old_value.len() == n && batch.returns.len() == n && dvalue.len() == n, "equal batch sizes");
    S::launch(ValueKernel { clip, weight, value, batch, dvalue })
}

struct ValueKernel<'a, S> {
    clip: Option<f64>,
    weight: f64,
    value: &'a [S],
    batch: ValueBatch<'a, S>,
    dvalue: &'a mut [S],
}

impl<S: Element> Lanewise<S> for ValueKernel<'_, S> {
    type Output = f64;
    #[inline(always)]
    fn run<V: Real<Scalar = S>>(self) -> f64 {
        let n = self.value.len();
        let clip = V::c(self.clip.unwrap_or(f64::INFINITY));
        let mut total = 0.0;
        let mut i = 0;
        while i < n {
            let value = load::<V>(self.value, i);
            let old = load::<V>(self.batch.old_value, i);
            let returns = load::<V>(self.batch.returns, i);
            let change = value - old;
            let inside = change.abs().le(clip);
            let error = value - returns;
            let clipped_error = old + change.clamp(-clip, clip) - returns;
            let (plain, clipped) = (error * error, clipped_error * clipped_error);
            let clipped = V::select(inside, plain, clipped);
            let gradient = V::select(plain.lt(clipped), V::zero(), error * V::c(2.0 * self.weight));
            store(gradient, self.dvalue, i);
            total += sum_valid(plain.max(clipped), i, n);
            i += V::LANES;
        }
        total
    }
}
