//! Adam (Kingma and Ba 2015) over flat slices.

use paid_lanes::Real;

use paid_policy::element::{Element, Lanewise, load, store};

/// Decay of the first moment; the paper's default.
pub const BETA1: f64 = 0.9;
/// Decay of the second moment; the paper's default.
pub const BETA2: f64 = 0.999;
/// Added to the root of the second moment; the paper's default.
pub const EPSILON: f64 = 1e-8;

/// One step of a slice of parameters. `step` counts from 1; the gradient is multiplied by `gradient_scale` first.
#[derive(Debug)]
pub struct AdamStep<'a, S> {
    /// Parameters.
    pub params: &'a mut [S],
    /// Mean of the gradients.
    pub m: &'a mut [S],
    /// Mean of their squares.
    pub v: &'a mut [S],
    /// Gradient.
    pub gradient: &'a [S],
    /// Factor on the gradient (norm clipping).
    pub gradient_scale: f64,
    /// Step size.
    pub learning_rate: f64,
    /// Number of this step, from 1.
    pub step: u64,
}

impl<S: Element> AdamStep<'_, S> {
    /// Takes the step.
    pub fn apply(self) {
        let n = self.params.len();
        assert!(self.m.len() == n && self.v.len() == n && self.gradient.len() == n, "equal lengths");
        S::launch(self);
    }
}

impl<S: Element> Lanewise<S> for AdamStep<'_, S> {
    type Output = ();
    #[inline(always)]
    fn run<V: Real<Scalar = S>>(self) {
        let correction1 = 1.0 - BETA1.powf(self.step as f64);
        let correction2 = 1.0 - BETA2.powf(self.step as f64);
        let rate = V::c(self.learning_rate / correction1);
        let inv_root2 = V::c(1.0 / correction2.sqrt());
        let scale = V::c(self.gradient_scale);
        let mut i = 0;
        while i < self.params.len() {
            let g = load::<V>(self.gradient, i) * scale;
            let m = load::<V>(self.m, i).mul_add(V::c(BETA1), g * V::c(1.0 - BETA1));
            let v = load::<V>(self.v, i).mul_add(V::c(BETA2), g * g * V::c(1.0 - BETA2));
            store(m, self.m, i);
            store(v, self.v, i);
            let step = rate * m / (v.sqrt().mul_add(inv_root2, V::c(EPSILON)));
            store(load::<V>(self.params, i) - step, self.params, i);
            i += V::LANES;
        }
    }
}

/// `total = sum of parts` in order, and the sum of its squares.
#[derive(Debug)]
pub struct Reduce<'a, S> {
    /// Where the sum goes.
    pub total: &'a mut [S],
    /// The parts, each at least as long.
    pub parts: &'a [&'a [S]],
}

impl<S: Element> Lanewise<S> for Reduce<'_, S> {
    type Output = f64;
    #[inline(always)]
    fn run<V: Real<Scalar = S>>(self) -> f64 {
        let mut squares = 0.0;
        let mut i = 0;
        while i < self.total.len() {
            let mut total = V::zero();
            for part in self.parts {
                total += load::<V>(part, i);
            }
            store(total, self.total, i);
            squares += paid_policy::element::sum(total * total);
            i += V::LANES;
        }
        squares
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_steps_match_the_published_recursion() {
        let (mut p, mut m, mut v) = (vec![1.0f64, -2.0], vec![0.0; 2], vec![0.0; 2]);
        let mut want = [1.0, -2.0];
        let (mut wm, mut wv) = ([0.0; 2], [0.0; 2]);
        for step in 1..=2u64 {
            let gradient = [0.5 * step as f64, -3.0];
            AdamStep {
                params: &mut p,
                m: &mut m,
                v: &mut v,
                gradient: &gradient,
                gradient_scale: 0.5,
                learning_rate: 0.01,
                step,
            }
            .apply();
            for k in 0..2 {
                let g = 0.5 * gradient[k];
                wm[k] = 0.9 * wm[k] + 0.1 * g;
                wv[k] = 0.999 * wv[k] + 0.001 * g * g;
                let m_hat = wm[k] / (1.0 - 0.9f64.powi(step as i32));
                let v_hat = wv[k] / (1.0 - 0.999f64.powi(step as i32));
                want[k] -= 0.01 * m_hat / (v_hat.sqrt() + 1e-8);
                assert!((p[k] - want[k]).abs() < 1e-12);
            }
        }
    }
}
