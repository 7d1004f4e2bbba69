//! Where the ball was shown a short time ago: what a policy without prediction and without memory may learn the velocity from.

use paid_lanes::{Real, Vec3};

/// Moments of the history, control steps ago: 0.1, 0.2 and 0.3 s at 50 Hz.
pub const STEPS_AGO: [usize; 3] = [5, 10, 15];

const KEPT: usize = STEPS_AGO[STEPS_AGO.len() - 1];

/// The places of the last control steps, in a frame that stays where it is: the world's or odometry's.
///
/// Look as often as you like in a control step: the last look counts. Then advance.
///
/// ```
/// use paid_lanes::Vec3;
/// use paid_play::BallHistory;
///
/// let mut history = BallHistory::<f64>::new();
/// // 2 cm a step. Before the first look the ball counts as lying there.
/// for step in 0..8_u32 {
///     let before = history.look(Vec3([f64::from(step) * 0.02, 0.0, 0.1]));
///     let expected = f64::from(step.saturating_sub(5)) * 0.02;
///     assert!((before[0].x() - expected).abs() < 1e-12 && before[1].x() == 0.0);
///     history.advance();
/// }
/// ```
#[derive(Clone, Debug)]
pub struct BallHistory<V> {
    /// At the last look.
    now: Vec3<V>,
    /// At the steps before, the latest first.
    before: [Vec3<V>; KEPT],
    /// 1 where nothing is remembered, else 0.
    fresh: V,
}

impl<V: Real> Default for BallHistory<V> {
    fn default() -> Self {
        Self::new()
    }
}

impl<V: Real> BallHistory<V> {
    /// Remembers nothing.
    pub fn new() -> Self {
        Self { now: Vec3::zero(), before: [Vec3::zero(); KEPT], fresh: V::one() }
    }

    /// Forgets one lane's places: another ball, or another episode.
    pub fn reset_lane(&mut self, lane: usize) {
        self.fresh.set_lane(lane, 1.0);
    }

    /// The numbers to save.
    pub fn fields(&mut self) -> impl Iterator<Item = &mut V> {
        let places = std::iter::once(&mut self.now).chain(&mut self.before);
        places.flat_map(|place| &mut place.0).chain(std::iter::once(&mut self.fresh))
    }

    /// Takes in where the ball is shown now `[m]`, and says where it was shown [`STEPS_AGO`] `[m]`; at `place` where nothing is remembered.
    #[inline(always)]
    pub fn look(&mut self, place: Vec3<V>) -> [Vec3<V>; STEPS_AGO.len()] {
        let fresh = self.fresh.ge(V::c(0.5));
        self.now = place;
        STEPS_AGO.map(|steps| Vec3::select(fresh, place, self.before[steps - 1]))
    }

    /// A control step is over.
    #[inline(always)]
    pub fn advance(&mut self) {
        let fresh = self.fresh.ge(V::c(0.5));
        for k in (1..KEPT).rev() {
            self.before[k] = Vec3::select(fresh, self.now, self.before[k - 1]);
        }
        self.before[0] = self.now;
        self.fresh = V::zero();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The place at step `k`: no two alike.
    fn place(k: u32) -> Vec3<f64> {
        Vec3([f64::from(k), -2.0 * f64::from(k), 0.1])
    }

    #[test]
    fn the_places_of_five_ten_and_fifteen_steps_ago() {
        let mut history = BallHistory::<f64>::new();
        for k in 0..40 {
            let seen = history.look(place(k)).map(|p| p.0);
            let expected = [5, 10, 15].map(|ago| place(k.saturating_sub(ago)).0);
            assert_eq!(seen, expected, "step {k}");
            history.advance();
        }
    }

    #[test]
    fn a_second_look_at_the_same_step_takes_the_place_of_the_first() {
        let mut history = BallHistory::<f64>::new();
        for k in 0..10 {
            history.look(place(100 + k));
            history.look(place(k));
            history.advance();
        }
        assert_eq!(history.look(place(10)).map(|p| p.0), [place(5), place(0), place(0)].map(|p| p.0));
    }

    #[test]
    fn a_lane_that_is_reset_has_seen_nothing() {
        let mut history = BallHistory::<f64>::new();
        for k in 0..20 {
            history.look(place(k));
            history.advance();
        }
        history.reset_lane(0);
        assert_eq!(history.look(place(50)).map(|p| p.0), [place(50).0; 3]);
        history.advance();
        assert_eq!(history.look(place(51)).map(|p| p.0), [place(50).0; 3]);
        assert_eq!(history.fields().count(), 3 * 16 + 1);
    }
}
