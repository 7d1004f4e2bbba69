//! What is shown of the ball after the strike: one rule for training, evaluation and robot.

use paid_lanes::{Mask, Real, Vec3};
use paid_policy::WhereItLay;
use serde::{Deserialize, Serialize};

use crate::PlayError;

/// What is shown of the ball after the strike.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ShownAfterStrike {
    /// The ball, wherever it flies.
    Ball,
    /// Where it lay at the strike, at rest in the world. With the last frame of a motion held, a policy that had never seen a
    /// ball meters away fell in 83% of the shots within 8 s, and in 5% with this.
    WhereItLay,
}

/// What is shown of the ball after the strike, and from when. Times are the reference's: a robot knows the phase of its motion.
/// May be left out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct AfterStrikePreset {
    /// What is shown.
    pub show: ShownAfterStrike,
    /// `where_it_lay`: time after the strike from which it is shown `[s]`.
    pub from_s: f64,
    /// `where_it_lay`: time before the strike at which the ball's place at the strike is captured `[s]`. Feet have met the ball
    /// up to about 0.15 s early.
    pub captured_s: f64,
}

impl Default for AfterStrikePreset {
    fn default() -> Self {
        Self { show: ShownAfterStrike::Ball, from_s: 0.3, captured_s: 0.2 }
    }
}

impl AfterStrikePreset {
    /// The rule's times; `None` where the ball is shown as it is.
    pub fn times(&self) -> Option<AfterStrikeTimes> {
        (self.show == ShownAfterStrike::WhereItLay)
            .then_some(AfterStrikeTimes { captured_s: self.captured_s, from_s: self.from_s })
    }

    /// Refuses times out of range.
    ///
    /// # Errors
    /// The first time that is not from 0 to 5 s.
    pub fn check(&self) -> Result<(), PlayError> {
        let times = [("from_s", self.from_s), ("captured_s", self.captured_s)];
        match times.into_iter().find(|(_, time_s)| !(0.0..=5.0).contains(time_s)) {
            Some((key, time_s)) => {
                Err(PlayError::value(&format!("ball.after_strike.{key}"), "0 to 5 s", time_s))
            }
            None => Ok(()),
        }
    }

    /// The rule as a policy file's contract states it.
    pub fn contract(&self) -> Option<WhereItLay> {
        self.times().map(|AfterStrikeTimes { captured_s, from_s }| WhereItLay { captured_s, from_s })
    }

    /// Adopts what a policy file's contract states.
    pub fn set_contract(&mut self, lay: Option<WhereItLay>) {
        match lay {
            Some(WhereItLay { captured_s, from_s }) => {
                *self = Self { show: ShownAfterStrike::WhereItLay, from_s, captured_s };
            }
            None => self.show = ShownAfterStrike::Ball,
        }
    }
}

/// Two times that count as one `[s]`: frames are at least ten times as far apart.
const SAME_S: f64 = 1e-3;

/// When the ball's place is captured, and from when it is shown. Times are the reference's, since a robot knows the phase of its
/// motion and not when the foot met the ball.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AfterStrikeTimes {
    /// Time before the strike at which the place is last captured `[s]`: a foot that comes early has not moved the ball by then.
    pub captured_s: f64,
    /// Time after the strike from which the captured place is shown `[s]`.
    pub from_s: f64,
}

/// Where the ball lay at the strike, as estimated shortly before, in a fixed frame: the world's or odometry's.
///
/// ```
/// use paid_lanes::Vec3;
/// use paid_play::{AfterStrike, AfterStrikeTimes};
///
/// let times = AfterStrikeTimes { captured_s: 0.2, from_s: 0.3 };
/// let mut kept = AfterStrike::<f64>::new();
/// // A second before the strike the ball is expected at (1, 0); 0.1 s before, a foot may have touched it already.
/// kept.advance(Vec3([1.0, 0.0, 0.1]), 1.0, times);
/// kept.advance(Vec3([1.5, 0.2, 0.1]), 0.1, times);
/// // Then it flies; it is seen for 0.3 s.
/// assert_eq!(kept.shown(Vec3([2.0, 0.3, 0.1]), -0.2, times).0, [2.0, 0.3, 0.1]);
/// assert_eq!(kept.shown(Vec3([5.0, 0.9, 0.1]), -0.3, times).0, [1.0, 0.0, 0.1]);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct AfterStrike<V> {
    place: Vec3<V>,
}

impl<V: Real> Default for AfterStrike<V> {
    fn default() -> Self {
        Self::new()
    }
}

impl<V: Real> AfterStrike<V> {
    /// At the origin, until a place is captured or set.
    pub fn new() -> Self {
        Self { place: Vec3::zero() }
    }

    /// Sets one lane's place `[m]`: an episode begins there, perhaps after the strike.
    pub fn reset_lane(&mut self, lane: usize, place: [f64; 3]) {
        self.place.set_lane(lane, place);
    }

    /// The numbers to save.
    pub fn fields(&mut self) -> &mut [V; 3] {
        &mut self.place.0
    }

    /// Updates with the ball's estimated place at the strike `[m]`, `to_strike_s` before the reference's strike `[s]`
    /// (negative after it).
    #[inline(always)]
    pub fn advance(&mut self, at_strike: Vec3<V>, to_strike_s: V, times: AfterStrikeTimes) {
        let captured = to_strike_s.ge(V::c(times.captured_s - SAME_S));
        self.place = Vec3::select(captured, at_strike, self.place);
    }

    /// What is shown for a ball that is estimated at `ball` `[m]`: that, or from `from_s` after the strike on the captured place.
    #[inline(always)]
    pub fn shown(&self, ball: Vec3<V>, to_strike_s: V, times: AfterStrikeTimes) -> Vec3<V> {
        let before = to_strike_s.le(V::c(SAME_S - times.from_s)).not();
        Vec3::select(before, ball, self.place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TIMES: AfterStrikeTimes = AfterStrikeTimes { captured_s: 0.2, from_s: 0.3 };

    /// The strike is at frame 50 of 0.02 s; a ball that moves 1 cm a frame, and its place is known exactly.
    #[test]
    fn the_place_of_ten_frames_before_the_strike_is_shown_from_fifteen_frames_after_it() {
        let mut kept = AfterStrike::<f64>::new();
        for frame in 0..100_u32 {
            let to_strike_s = (50.0 - f64::from(frame)) * 0.02;
            let ball = Vec3([f64::from(frame) * 0.01, -1.0, 0.1]);
            kept.advance(ball, to_strike_s, TIMES);
            let shown = kept.shown(ball, to_strike_s, TIMES).0;
            let expected = if frame < 65 { ball.0 } else { [0.4, -1.0, 0.1] };
            assert!((0..3).all(|k| (shown[k] - expected[k]).abs() < 1e-12), "frame {frame}: {shown:?}");
        }
    }

    #[test]
    fn an_episode_from_after_the_strike_keeps_the_place_that_it_began_with() {
        let mut kept = AfterStrike::<f64>::new();
        kept.reset_lane(0, [0.7, 0.2, 0.11]);
        kept.advance(Vec3([4.0, 0.0, 0.1]), -0.1, TIMES);
        assert_eq!(kept.shown(Vec3([4.0, 0.0, 0.1]), -0.1, TIMES).0, [4.0, 0.0, 0.1]);
        assert_eq!(kept.shown(Vec3([6.0, 0.0, 0.1]), -0.4, TIMES).0, [0.7, 0.2, 0.11]);
        assert_eq!(*kept.fields(), [0.7, 0.2, 0.11]);
    }

    #[test]
    fn a_contract_sets_the_rule_that_it_was_made_of() {
        let mut rule = AfterStrikePreset::default();
        assert_eq!(rule.contract(), None);
        rule.set_contract(Some(WhereItLay { captured_s: 0.1, from_s: 0.4 }));
        assert_eq!(
            rule,
            AfterStrikePreset { show: ShownAfterStrike::WhereItLay, from_s: 0.4, captured_s: 0.1 }
        );
        assert_eq!(rule.contract(), Some(WhereItLay { captured_s: 0.1, from_s: 0.4 }));
        rule.set_contract(None);
        assert_eq!(rule, AfterStrikePreset { show: ShownAfterStrike::Ball, from_s: 0.4, captured_s: 0.1 });
    }

    #[test]
    fn what_a_preset_leaves_out_is_the_ball_as_it_is() {
        let rule: AfterStrikePreset = toml::from_str("").expect("empty");
        assert_eq!((rule.times(), rule.from_s), (None, 0.3));
        let rule: AfterStrikePreset = toml::from_str("show = 'where_it_lay'\nfrom_s = 0.5").expect("valid");
        assert_eq!(rule.times(), Some(AfterStrikeTimes { captured_s: 0.2, from_s: 0.5 }));
    }
}
