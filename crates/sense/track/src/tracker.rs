//! Where the ball is, from images that come late and not always.
//!
//! A Kalman filter over the ball's horizontal position and velocity in the odometry frame. The ball rolls straight on and slows down
//! with the identified decay; what else may happen to it is process noise. Noise, prior and motion are the same on both axes, so one
//! 2 x 2 covariance serves both.
//!
//! **Late images are fused exactly.** An image says where the ball was when it was taken. The filter's own state stays in the past,
//! `horizon` seconds behind, where such an image adds information; [`BallTracker::belief`] predicts from there. Images in the
//! order of their capture with ages up to the horizon then give the same estimate as without any delay.
//!
//! **Resting or rolling** is decided by the evidence. A ball at rest is a rolling ball with velocity zero, so the odds of the two are the
//! posterior density of zero velocity over its prior density (the Savage-Dickey ratio). They weigh the process noise, and the belief.
//!
//! **Around the strike** any velocity is possible. That noise is kept apart until an image comes: a ball not seen since is
//! estimated to lie where it lay. It is no part of the prior either, so a ball that was struck rests only once that is well known.

use paid_lanes::{Mask, Real};

use crate::{BallEstimate, Belief, Measurement, Rolling, TrackerPreset, effective_time};

/// Covariances grow to this variance and no further: far more than any place `[m^2]`.
const LOST: f64 = 1e4;
/// A refused image is dropped after this time `[s]`.
const STALE_S: f64 = 0.5;

/// The tracker, one ball a lane.
#[derive(Clone, Debug)]
pub struct BallTracker<V> {
    /// The ball `lag_s` ago.
    state: BallEstimate<V>,
    /// Variance that the velocity would have without any image and without a strike `[m^2/s^2]`.
    prior: V,
    /// What a strike since the last accepted image may have added to the state's covariance; the next one takes it in.
    strike: [V; 3],
    /// The state's distance to the present `[s]`.
    lag_s: V,
    /// Time since the capture of the last accepted image `[s]`.
    age_s: V,
    /// 1 where the ball was ever seen.
    known: V,
    /// The last refused image `[m]`, the time since its capture `[s]`, and how many in a row fit each other.
    refused: [V; 2],
    refused_age_s: V,
    refused_count: V,
}

impl<V: Real> Default for BallTracker<V> {
    fn default() -> Self {
        Self::new()
    }
}

impl<V: Real> BallTracker<V> {
    /// A tracker that has seen nothing.
    pub fn new() -> Self {
        let zero = V::zero();
        Self {
            state: BallEstimate {
                position: [zero; 2],
                velocity: [zero; 2],
                covariance: [V::c(LOST), zero, zero],
            },
            prior: zero,
            strike: [zero; 3],
            lag_s: zero,
            age_s: zero,
            known: zero,
            refused: [zero; 2],
            refused_age_s: zero,
            refused_count: zero,
        }
    }

    /// Every number, for save and restore.
    pub fn fields(&mut self) -> [&mut V; 18] {
        let BallEstimate { position: [x, y], velocity: [vx, vy], covariance: [pp, pv, vv] } = &mut self.state;
        let [refused_x, refused_y] = &mut self.refused;
        let [strike_pp, strike_pv, strike_vv] = &mut self.strike;
        [
            x,
            y,
            vx,
            vy,
            pp,
            pv,
            vv,
            &mut self.prior,
            strike_pp,
            strike_pv,
            strike_vv,
            &mut self.lag_s,
            &mut self.age_s,
            &mut self.known,
            refused_x,
            refused_y,
            &mut self.refused_age_s,
            &mut self.refused_count,
        ]
    }

    /// One lane becomes what `other` is.
    pub fn set_lane(&mut self, lane: usize, other: &BallTracker<f64>) {
        let mut other = other.clone();
        for (to, from) in self.fields().into_iter().zip(other.fields()) {
            to.set_lane(lane, *from);
        }
    }

    /// The same tracker in axes that are turned by `angle` `[rad]` and then moved by `by` `[m]`: its numbers seen from outside.
    #[must_use]
    pub fn moved(&self, angle: V, by: [V; 2]) -> Self {
        let (s, c) = angle.sin_cos();
        let turned = |[x, y]: [V; 2]| [c * x - s * y, s * x + c * y];
        let placed = |xy: [V; 2]| {
            let [x, y] = turned(xy);
            [x + by[0], y + by[1]]
        };
        let state = BallEstimate {
            position: placed(self.state.position),
            velocity: turned(self.state.velocity),
            ..self.state
        };
        Self { state, refused: placed(self.refused), ..self.clone() }
    }

    /// Probability that the ball lies still: the odds of zero velocity after and before the images.
    #[inline(always)]
    fn rest(estimate: &BallEstimate<V>, prior: V, preset: &TrackerPreset) -> V {
        let ([vx, vy], vv) = (estimate.velocity, estimate.covariance[2].max(V::c(1e-12)));
        let speed2 = vx.mul_add(vx, vy * vy);
        let odds = V::c(preset.rest_odds) * prior / vv * (speed2 * V::c(-0.5) / vv).exp();
        odds / (odds + V::one())
    }

    /// The state, the prior and the strike's part `time` `[s]` later. The process noise of a step is that of a ball that does not slow
    /// down, `q (t^3 / 3, t^2 / 2, t)` with the spectral density `q` of the acceleration.
    #[inline(always)]
    fn predicted(&self, time: V, rolling: &Rolling<V>, preset: &TrackerPreset) -> Then<V> {
        let square = |x: f64| V::c(x * x);
        let (roll, rest) = (square(preset.rolling_noise), square(preset.resting_noise));
        let q = Self::rest(&self.state, self.prior, preset).mul_add(rest - roll, roll);
        let [from, to] = preset.strike_window_s;
        let striking = rolling.to_strike_s.le(V::c(-from)).and(rolling.to_strike_s.ge(V::c(-to)));
        let q_strike = V::select(striking, square(preset.strike_noise), V::zero());
        let way = effective_time(time, rolling.decay);
        let kept = V::one() - rolling.decay * way;
        let ([x, y], [vx, vy]) = (self.state.position, self.state.velocity);
        let moved = Moved { time, way, kept };
        let most = V::c(preset.fastest_m_s * preset.fastest_m_s);
        let state = BallEstimate {
            position: [vx.mul_add(way, x), vy.mul_add(way, y)],
            velocity: [vx * kept, vy * kept],
            covariance: moved.covariance(self.state.covariance, q, most),
        };
        let strike = moved.covariance(self.strike, q_strike, most);
        Then { state, strike, prior: (kept * kept).mul_add(self.prior, q * time).min(most) }
    }

    /// Time passes, `dt_s` `[s]`. The state follows, `horizon_s` `[s]` behind: images that are older will not be used.
    #[inline(always)]
    pub fn advance(&mut self, dt_s: V, horizon_s: V, rolling: &Rolling<V>, preset: &TrackerPreset) {
        self.age_s += dt_s;
        self.refused_age_s += dt_s;
        self.lag_s += dt_s;
        let step = (self.lag_s - horizon_s).max(V::zero());
        let then = self.predicted(step, &self.back_then(rolling), preset);
        (self.state, self.prior, self.strike) = (then.state, then.prior, then.strike);
        self.lag_s -= step;
    }

    /// The ball's motion at the state's time.
    #[inline(always)]
    fn back_then(&self, rolling: &Rolling<V>) -> Rolling<V> {
        Rolling { to_strike_s: rolling.to_strike_s + self.lag_s, ..*rolling }
    }

    /// Takes in an image. One that is older than the state is not used.
    #[inline(always)]
    pub fn fuse(&mut self, picture: &Measurement<V>, rolling: &Rolling<V>, preset: &TrackerPreset) {
        let (zero, one) = (V::zero(), V::one());
        let step = self.lag_s - picture.age_s;
        let known = self.known.gt(V::c(0.5));
        let seen = picture.seen.and(step.gt(V::c(-1e-4)).or(known.not()));
        if !seen.any() {
            return;
        }
        let Then { state: at, prior, strike } =
            self.predicted(step.max(zero), &self.back_then(rolling), preset);
        let r = picture.variance;
        let [pp, pv, vv] = sum(at.covariance, strike);
        let innovation = [0, 1].map(|k| picture.position[k] - at.position[k]);
        let weight = one / (pp + r);
        let distance2 = innovation[0].mul_add(innovation[0], innovation[1] * innovation[1]) * weight;
        let fits = distance2.le(V::c(preset.gate * preset.gate));
        let fused = seen.and(known).and(fits);

        // Refused images that fit each other.
        let refused = seen.and(known).and(fits.not());
        let gap = (self.refused_age_s - picture.age_s).max(V::c(1e-3));
        let apart = [0, 1].map(|k| picture.position[k] - self.refused[k]);
        let reach = gap.mul_add(V::c(preset.fastest_m_s), (r + r).sqrt() * V::c(preset.gate));
        let fit = apart[0].mul_add(apart[0], apart[1] * apart[1]).le(reach * reach);
        let row = fit.and(gap.lt(V::c(STALE_S))).and(self.refused_count.gt(zero));
        let count = V::select(row, self.refused_count + one, one);
        let again = refused.and(count.ge(V::c(preset.reacquire as f64)));
        let count = V::select(refused, count, V::select(fused, zero, self.refused_count));
        self.refused_count = V::select(again, zero, count);
        self.refused_age_s = V::select(refused, picture.age_s, self.refused_age_s);
        for k in 0..2 {
            self.refused[k] = V::select(refused, picture.position[k], self.refused[k]);
        }

        // A ball that is new, or was found again, begins at the image; the latter with the velocity between the last two.
        let new = seen.and(known.not());
        let begins = new.or(again);
        let taken = fused.or(begins);
        let speed2 = V::c(preset.speed_m_s * preset.speed_m_s);
        let per_gap = one / gap;
        let most = V::c(preset.fastest_m_s * preset.fastest_m_s);
        let found_vv = ((r + r) * per_gap * per_gap).min(most);
        let gain = [pp * weight, pv * weight];
        for k in 0..2 {
            let position = gain[0].mul_add(innovation[k], at.position[k]);
            let velocity = gain[1].mul_add(innovation[k], at.velocity[k]);
            let begun = V::select(again, apart[k] * per_gap, zero);
            let position = V::select(begins, picture.position[k], position);
            self.state.position[k] = V::select(taken, position, self.state.position[k]);
            self.state.velocity[k] =
                V::select(taken, V::select(begins, begun, velocity), self.state.velocity[k]);
        }
        let found_pv = (r * per_gap).min((r * found_vv * V::c(0.5)).sqrt());
        let begun = [r, V::select(again, found_pv, zero), V::select(again, found_vv, speed2)];
        let updated = [gain[0] * r, gain[1] * r, gain[1].neg_mul_add(pv, vv)];
        for k in 0..3 {
            let next = V::select(begins, begun[k], updated[k]);
            self.state.covariance[k] = V::select(taken, next, self.state.covariance[k]);
            self.strike[k] = V::select(taken, zero, self.strike[k]);
        }
        self.prior = V::select(taken, V::select(begins, begun[2], prior), self.prior);
        self.lag_s = V::select(taken, picture.age_s, self.lag_s);
        self.age_s = V::select(taken, picture.age_s, self.age_s);
        self.known = V::select(new, one, self.known);
    }

    /// The filter's estimate of the ball now, whether it rests or rolls.
    #[inline(always)]
    pub fn estimate(&self, rolling: &Rolling<V>, preset: &TrackerPreset) -> BallEstimate<V> {
        let then = self.predicted(self.lag_s, &self.back_then(rolling), preset);
        BallEstimate { covariance: sum(then.state.covariance, then.strike), ..then.state }
    }

    /// The tracker's estimate now. A ball at rest lies where the filter's position would be if its velocity were known to be zero.
    #[inline(always)]
    pub fn belief(&self, rolling: &Rolling<V>, preset: &TrackerPreset) -> Belief<V> {
        let then = self.predicted(self.lag_s, &self.back_then(rolling), preset);
        let mut ball = then.state;
        let rest = Self::rest(&ball, then.prior, preset);
        let [_, pv, vv] = ball.covariance;
        let back = rest * pv / vv.max(V::c(1e-12));
        for k in 0..2 {
            ball.position[k] = back.neg_mul_add(ball.velocity[k], ball.position[k]);
            ball.velocity[k] = rest.neg_mul_add(ball.velocity[k], ball.velocity[k]);
        }
        ball.covariance = sum(ball.covariance, then.strike);
        Belief { ball, rest, age_s: self.age_s, known: self.known.gt(V::c(0.5)) }
    }
}

/// A tracker some time later.
struct Then<V> {
    state: BallEstimate<V>,
    prior: V,
    strike: [V; 3],
}

/// A step in time.
struct Moved<V> {
    time: V,
    /// What a velocity is multiplied by for the displacement `[s]`, and for the velocity at the end.
    way: V,
    kept: V,
}

impl<V: Real> Moved<V> {
    /// A covariance at the end of the step, with process noise of density `q`; variances of the velocity are cut at `most`.
    #[inline(always)]
    fn covariance(&self, [pp, pv, vv]: [V; 3], q: V, most: V) -> [V; 3] {
        let Self { time, way, kept } = *self;
        let qt = q * time;
        let to_pv = way.mul_add(vv, pv);
        let pp = way.mul_add(pv + to_pv, pp) + qt * time * time * V::c(1.0 / 3.0);
        let pv = kept.mul_add(to_pv, qt * time * V::c(0.5));
        let vv = (kept * kept).mul_add(vv, qt);
        // A variance that is cut takes the correlation along.
        let (cut_p, cut_v) = (V::c(LOST) / pp.max(V::c(LOST)), most / vv.max(most));
        [pp * cut_p, pv * (cut_p * cut_v).sqrt(), vv * cut_v]
    }
}

#[inline(always)]
fn sum<V: Real>(a: [V; 3], b: [V; 3]) -> [V; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}
