//! Soft contacts: the exact motion of a spring and damper over a physics step, as a target at velocity level.
//!
//! The gap obeys `x'' = -2 a x' - (a^2 + w^2) x` while that pushes ([`Compliance`]: `a = 1/t`, `w = a sqrt(1/z^2 - 1)`). Its motion over a step
//! does not depend on masses, so the velocity at the end of the step is known beforehand, and the contact's impulse is what
//! reaches it. Sliding is slowed at the same rate `2 a` as long as the friction suffices.

use paid_lanes::Real;

use crate::Compliance;

/// [`Compliance`] prepared for the steps, one value per lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SpringLanes<V> {
    /// Some lane is soft.
    pub any: bool,
    /// 1 in soft lanes, else 0.
    soft: V,
    /// `a` and `w` `[1/s]`, `1 / w`, and `a^2 + w^2`.
    rate: V,
    wave: V,
    inv_wave: V,
    stiffness: V,
}

/// What a soft contact requires of a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SpringTarget<V> {
    /// Normal speed at the end of the step `[m/s]`.
    pub speed: V,
    /// Gap at the end of the step beyond straight motion with that speed `[m]`.
    pub shift: V,
    /// Share of the sliding speed that stays without limit of friction.
    pub slide: V,
    /// 1 where the surfaces are in touch at some time of the step, else 0.
    pub on: V,
}

impl<V: Real> SpringLanes<V> {
    /// All lanes hard.
    pub fn hard() -> Self {
        let (z, one) = (V::zero(), V::one());
        Self { any: false, soft: z, rate: one, wave: one, inv_wave: one, stiffness: one }
    }

    /// Sets one lane. `any` is still to be set over all lanes.
    pub fn set_lane(&mut self, lane: usize, compliance: &Compliance) {
        if !compliance.is_soft() {
            self.soft.set_lane(lane, 0.0);
            return;
        }
        let [a, w] = compliance.rates();
        self.soft.set_lane(lane, 1.0);
        self.rate.set_lane(lane, a);
        self.wave.set_lane(lane, w);
        self.inv_wave.set_lane(lane, 1.0 / w);
        self.stiffness.set_lane(lane, a * a + w * w);
    }

    /// 1 where the lane is soft.
    #[inline(always)]
    pub fn is_soft(&self) -> V::Mask {
        V::c(0.5).lt(self.soft)
    }

    /// Target from gap `[m]` and normal speed `[m/s]` at the start of a step of `dt`; lanes that are hard are to be ignored. Surfaces are in
    /// touch up to a gap of `reach`: what rests has a gap near zero of either sign and must not lose its friction every other step.
    ///
    /// The surfaces move straight until they meet, then as the spring does until its force ends, then straight again. A spring that would
    /// pull from the start has the whole step: it can only slow down what parts, which the contact does not do.
    #[inline(always)]
    pub fn target(&self, gap: V, speed: V, dt: V, reach: f64) -> SpringTarget<V> {
        let (zero, one) = (V::zero(), V::one());
        let (a, k) = (self.rate, self.stiffness);
        let apart = V::c(reach).lt(gap);
        let meets = speed.mul_add(dt, gap).lt(zero);
        let until = V::select(apart, gap * (-speed).max(V::c(1e-6)).recip(), zero).min(dt);
        let x = V::select(apart, zero, gap);
        let left = dt - until;
        // x'' = e^(-a s) (p cos w s + q sin w s): it ends where tan w s = -p / q.
        let p = -(k.mul_add(x, V::c(2.0) * a * speed));
        let q = -(a.mul_add(p, k * speed) * self.inv_wave);
        let ends = p.atan2(-q) * self.inv_wave;
        let pulls = p.le(zero);
        let time = V::select(pulls, left, left.min(ends));
        let (s, c) = (self.wave * time).sin_cos();
        let (e, s) = ((-(a * time)).exp(), s * self.inv_wave);
        let end_speed = e * speed.mul_add(a.neg_mul_add(s, c), -(k * x * s));
        let end = e * x.mul_add(a.mul_add(s, c), speed * s);
        let shift = V::select(pulls, zero, (until + time).neg_mul_add(end_speed, end - gap));
        let open = -(gap * dt.recip());
        let touch = |inside: V, outside: V| V::select(apart, V::select(meets, inside, outside), inside);
        SpringTarget {
            speed: touch(end_speed, open),
            shift: touch(shift, zero),
            slide: touch(e * e, one),
            on: touch(one, zero),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spring(time_constant_s: f64, damping_ratio: f64) -> SpringLanes<f64> {
        let mut lanes = SpringLanes::hard();
        lanes.set_lane(0, &Compliance { time_constant_s, damping_ratio });
        lanes
    }

    /// The motion until the spring lets go, integrated in steps of a microsecond: speed at the end and how long it took.
    fn reference(t: f64, z: f64, mut speed: f64) -> (f64, f64) {
        let (mut x, mut time, h) = (0.0, 0.0, 1e-6);
        loop {
            let force = -2.0 * speed / t - x / (t * z).powi(2);
            if force < 0.0 {
                return (speed, time);
            }
            speed += force * h;
            x += speed * h;
            time += h;
        }
    }

    #[test]
    fn an_impact_ends_with_the_springs_speed_wherever_the_steps_fall() {
        for (t, z) in [(0.02, 1.0), (0.02, 0.5), (0.01, 0.2), (0.004, 0.3), (0.025, 0.999)] {
            let (want, lasts) = reference(t, z, -3.0);
            for dt in [0.005, 0.002] {
                for phase in 0..10 {
                    let spring = spring(t, z);
                    let mut gap = 3.0 * dt * f64::from(phase) / 10.0;
                    let mut speed = -3.0;
                    let mut time = 0.0;
                    while time < lasts + 2.0 * dt {
                        let target = spring.target(gap, speed, dt, 0.0);
                        // No pull.
                        if target.speed > speed {
                            gap += target.speed.mul_add(dt, target.shift);
                            speed = target.speed;
                        } else {
                            gap += speed * dt;
                        }
                        time += dt;
                    }
                    let error = (speed - want).abs() / 3.0;
                    assert!(error < 1e-3, "t {t} z {z} dt {dt} phase {phase}: {speed}, expected {want}");
                }
            }
        }
    }

    #[test]
    fn what_rests_stays_at_rest() {
        let target = spring(0.02, 1.0).target(0.0, 0.0, 0.005, 0.0);
        assert_eq!((target.speed, target.shift), (0.0, 0.0), "{target:?}");
    }

    #[test]
    fn what_is_pressed_into_a_surface_comes_to_rest_on_it() {
        let spring = spring(0.01, 1.0);
        let (mut gap, mut speed) = (-0.01, 0.0);
        for _ in 0..200 {
            let target = spring.target(gap, speed, 0.005, 0.0);
            let free = speed - 9.81 * 0.005;
            let pushed = free < target.speed;
            speed = free.max(target.speed);
            gap += speed.mul_add(0.005, if pushed { target.shift } else { 0.0 });
        }
        assert!(gap.abs() < 1e-6 && speed.abs() < 1e-4, "{gap} {speed}");
    }

    #[test]
    fn what_rests_within_reach_is_slowed_and_what_is_beyond_slides_on() {
        let spring = spring(0.01, 1.0);
        let slide = |gap: f64| spring.target(gap, 0.0, 0.005, 0.001).slide;
        // e^(-2 dt / t).
        assert!((slide(0.0005) - (-1.0_f64).exp()).abs() < 1e-12);
        assert_eq!((slide(0.002), spring.target(0.002, 0.0, 0.005, 0.001).on), (1.0, 0.0));
    }

    #[test]
    fn a_surface_that_does_not_meet_the_other_may_close_the_gap() {
        let target = spring(0.02, 1.0).target(0.01, -1.0, 0.005, 0.001);
        assert_eq!((target.speed, target.shift, target.slide), (-2.0, 0.0, 1.0));
    }
}
