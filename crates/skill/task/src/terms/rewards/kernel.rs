//! Kernels over errors.

use paid_lanes::Real;
use serde::{Deserialize, Serialize};

/// Mean and exponential, in which order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BodyKernel {
    /// `exp(-mean over bodies of e^2 / sigma^2)`: release and BeyondMimic. One body far off lowers the whole term, so
    /// the swinging leg counts even while the other bodies track well.
    ExpOfMean,
    /// `mean over bodies of exp(-e^2 / sigma^2)`: as printed in the paper's table.
    MeanOfExp,
}

/// `exp(-error2 / sigma^2)`.
#[inline(always)]
pub(crate) fn gaussian<V: Real>(error2: V, sigma: f64) -> V {
    (error2 * V::c(-1.0 / (sigma * sigma))).exp()
}

/// The kernel of a squared error while the time to the strike is within `around_s` `[s]`; zero elsewhere. An `around_s` of 0 is
/// the whole motion.
#[inline(always)]
pub(crate) fn around_strike<V: Real>(error2: V, to_strike_s: V, sigma: f64, around_s: f64) -> V {
    let value = gaussian(error2, sigma);
    if around_s == 0.0 {
        return value;
    }
    V::select(to_strike_s.abs().le(V::c(around_s)), value, V::zero())
}

/// The kernel over the squared errors of several bodies, in [0, 1]; 1 for no body.
#[inline(always)]
pub(crate) fn over_bodies<V: Real>(errors2: impl Iterator<Item = V>, kind: BodyKernel, sigma: f64) -> V {
    let factor = V::c(-1.0 / (sigma * sigma));
    let (mut sum, mut count) = (V::zero(), 0.0);
    for error2 in errors2 {
        count += 1.0;
        let scaled = error2 * factor;
        sum += match kind {
            BodyKernel::ExpOfMean => scaled,
            BodyKernel::MeanOfExp => scaled.exp(),
        };
    }
    if count == 0.0 {
        return V::one();
    }
    let mean = sum * V::c(1.0 / count);
    match kind {
        BodyKernel::ExpOfMean => mean.exp(),
        BodyKernel::MeanOfExp => mean,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kernel_is_one_at_zero_and_falls_with_the_squared_error() {
        assert_eq!(gaussian(0.0, 0.3), 1.0);
        assert!((gaussian(0.09, 0.3) - (-1.0_f64).exp()).abs() < 1e-12);
    }

    #[test]
    fn a_kernel_around_the_strike_is_zero_elsewhere() {
        let inside = (-1.0_f64).exp();
        for (to_strike, around, expected) in
            [(0.2, 0.3, inside), (-0.2, 0.3, inside), (0.4, 0.3, 0.0), (-0.4, 0.3, 0.0), (9.0, 0.0, inside)]
        {
            let value: f64 = around_strike(4.0, to_strike, 2.0, around);
            assert!((value - expected).abs() < 1e-12, "{to_strike} {around}");
        }
    }

    #[test]
    fn the_two_forms_of_the_body_kernel_differ_as_they_should() {
        // Two bodies, squared errors 0 and 0.18, sigma 0.3: exp(-1) against (1 + exp(-2)) / 2.
        for (kind, expected) in [
            (BodyKernel::ExpOfMean, (-1.0_f64).exp()),
            (BodyKernel::MeanOfExp, f64::midpoint(1.0, (-2.0_f64).exp())),
        ] {
            let value: f64 = over_bodies([0.0, 0.18].into_iter(), kind, 0.3);
            assert!((value - expected).abs() < 1e-12);
        }
        assert_eq!(over_bodies(core::iter::empty::<f64>(), BodyKernel::ExpOfMean, 0.3), 1.0);
    }
}
