//! Motion tracking: errors between robot and reference, and the kernels over them.

use paid_lanes::{Mat3, Real, Vec3};

use crate::{BodyKernel, StrikeKernel};

/// `exp(-error2 / sigma^2)`.
#[inline(always)]
pub(crate) fn gaussian<V: Real>(error2: V, sigma: f64) -> V {
    (error2 * V::c(-1.0 / (sigma * sigma))).exp()
}

/// The kernel of a squared error, where the time to the strike is within the preset's; zero elsewhere.
#[inline(always)]
pub(crate) fn around_strike<V: Real>(error2: V, to_strike_s: V, preset: &StrikeKernel) -> V {
    let value = gaussian(error2, preset.sigma);
    if preset.around_s == 0.0 {
        return value;
    }
    V::select(to_strike_s.abs().le(V::c(preset.around_s)), value, V::zero())
}

/// A mean over bodies, either of squared errors (then the exponential) or of exponentials.
#[derive(Clone, Copy)]
pub(crate) struct KernelMean<V> {
    kind: BodyKernel,
    factor: V,
    sum: V,
    count: f64,
}

impl<V: Real> KernelMean<V> {
    /// An empty mean.
    #[inline(always)]
    pub(crate) fn new(kind: BodyKernel, sigma: f64) -> Self {
        Self { kind, factor: V::c(-1.0 / (sigma * sigma)), sum: V::zero(), count: 0.0 }
    }
    /// Adds a body's squared error.
    #[inline(always)]
    pub(crate) fn add(&mut self, error2: V) {
        self.count += 1.0;
        let scaled = error2 * self.factor;
        self.sum += match self.kind {
            BodyKernel::ExpOfMean => scaled,
            BodyKernel::MeanOfExp => scaled.exp(),
        };
    }
    /// The value in [0, 1]; 1 for no body.
    #[inline(always)]
    pub(crate) fn value(&self) -> V {
        if self.count == 0.0 {
            return V::one();
        }
        let mean = self.sum * V::c(1.0 / self.count);
        match self.kind {
            BodyKernel::ExpOfMean => mean.exp(),
            BodyKernel::MeanOfExp => mean,
        }
    }
}

/// Rotation about z that turns the reference's heading into the robot's: the yaw of (robot anchor x inverse reference anchor).
#[inline(always)]
pub(crate) fn yaw_alignment<V: Real>(robot_anchor: &Mat3<V>, reference_anchor: &Mat3<V>) -> Mat3<V> {
    robot_anchor.mul_mat(&reference_anchor.transpose()).yaw_only()
}

/// A reference position as the robot should have it: turned about the anchor, placed at the robot anchor's x, y and the
/// reference's z.
#[inline(always)]
pub(crate) fn aligned_position<V: Real>(
    alignment: &Mat3<V>,
    robot_anchor: Vec3<V>,
    reference_anchor: Vec3<V>,
    reference: Vec3<V>,
) -> Vec3<V> {
    let turned = alignment.mul_vec(reference - reference_anchor);
    Vec3::new(robot_anchor.x() + turned.x(), robot_anchor.y() + turned.y(), reference.z())
}

/// Angle between two orientations [rad].
#[inline(always)]
pub(crate) fn orientation_error<V: Real>(a: &Mat3<V>, b: &Mat3<V>) -> V {
    a.tr_mul_mat(b).angle()
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::FRAC_PI_2;
    use paid_lanes::Quat;

    fn yaw(angle: f64) -> Mat3<f64> {
        Quat::from_roll_pitch_yaw(0.0, 0.0, angle).to_mat()
    }

    #[test]
    fn a_kernel_is_one_at_zero_and_falls_with_the_squared_error() {
        assert_eq!(gaussian(0.0, 0.3), 1.0);
        assert!((gaussian(0.09, 0.3) - (-1.0_f64).exp()).abs() < 1e-12);
    }

    #[test]
    fn a_kernel_around_the_strike_pays_nothing_elsewhere() {
        let preset = |around_s| StrikeKernel { weight: 1.0, sigma: 2.0, around_s };
        let value = |to_strike: f64, around| around_strike(4.0, to_strike, &preset(around));
        let inside = (-1.0_f64).exp();
        for (to_strike, around, expected) in
            [(0.2, 0.3, inside), (-0.2, 0.3, inside), (0.4, 0.3, 0.0), (-0.4, 0.3, 0.0), (9.0, 0.0, inside)]
        {
            assert!((value(to_strike, around) - expected).abs() < 1e-12, "{to_strike} {around}");
        }
    }

    #[test]
    fn the_two_forms_of_the_body_kernel_differ_as_they_should() {
        // Two bodies, squared errors 0 and 0.18, sigma 0.3: exp(-1) against (1 + exp(-2)) / 2.
        for (kind, expected) in [
            (BodyKernel::ExpOfMean, (-1.0_f64).exp()),
            (BodyKernel::MeanOfExp, f64::midpoint(1.0, (-2.0_f64).exp())),
        ] {
            let mut mean = KernelMean::<f64>::new(kind, 0.3);
            mean.add(0.0);
            mean.add(0.18);
            assert!((mean.value() - expected).abs() < 1e-12);
        }
        assert_eq!(KernelMean::<f64>::new(BodyKernel::ExpOfMean, 0.3).value(), 1.0);
    }

    #[test]
    fn alignment_takes_only_the_heading() {
        let tilted: Mat3<f64> = Quat::from_roll_pitch_yaw(0.0, 0.4, 0.0).to_mat();
        let robot = yaw(FRAC_PI_2).mul_mat(&tilted);
        let alignment = yaw_alignment(&robot, &tilted);
        let x = alignment.mul_vec(Vec3([1.0, 0.0, 0.0])).0;
        assert!(x[0].abs() < 1e-9 && (x[1] - 1.0).abs() < 1e-9 && x[2].abs() < 1e-12);
    }

    #[test]
    fn an_aligned_target_turns_about_the_anchor_and_keeps_its_height() {
        let target = aligned_position(
            &yaw(FRAC_PI_2),
            Vec3([5.0, 6.0, 0.9]),
            Vec3([1.0, 1.0, 0.8]),
            Vec3([2.0, 1.0, 0.1]),
        );
        let expected = [5.0, 7.0, 0.1];
        for k in 0..3 {
            assert!((target.0[k] - expected[k]).abs() < 1e-12);
        }
    }

    #[test]
    fn orientation_error_is_the_angle_between() {
        assert!((orientation_error(&yaw(0.3), &yaw(-0.4)) - 0.7).abs() < 1e-12);
    }
}
