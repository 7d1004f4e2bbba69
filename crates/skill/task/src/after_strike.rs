//! What is shown of the ball after the strike: the preset's rule, applied to ball and goal just before they are shown.

use paid_lanes::Real;
use paid_policy::{Pose, SceneView};
use paid_track::AfterStrike;

use crate::config::TaskConfig;
use crate::group::GroupTask;

/// Where the ball lay at the strike: in truth, for the critic, and as the policy believed it.
#[derive(Clone, Debug)]
pub(crate) struct ShownBall<V> {
    truth: AfterStrike<V>,
    believed: AfterStrike<V>,
}

impl<V: Real> ShownBall<V> {
    /// Where the preset has the rule.
    pub(crate) fn new(config: &TaskConfig) -> Option<Self> {
        let rule = config.preset.ball.after_strike.times();
        rule.map(|_| Self { truth: AfterStrike::new(), believed: AfterStrike::new() })
    }

    pub(crate) fn fields(&mut self) -> impl Iterator<Item = &mut V> {
        self.truth.fields().iter_mut().chain(self.believed.fields())
    }

    /// Begins an episode in one lane, whose ball lies or lay at `place`, world `[m]`.
    pub(crate) fn reset_lane(&mut self, lane: usize, place: [f64; 3]) {
        self.truth.reset_lane(lane, place);
        self.believed.reset_lane(lane, place);
    }
}

impl<V: Real> GroupTask<V> {
    /// Applies the rule to what critic (`truth`) and policy (`believed`) are about to be shown, in the base frame. `bases` are
    /// the base's poses in the frames in which either's place of the ball is kept: the world, and odometry's where the robot sees.
    #[inline(always)]
    pub(crate) fn show_after_strike(
        &mut self,
        config: &TaskConfig,
        bases: [&Pose<V>; 2],
        truth: &mut SceneView<V>,
        believed: &mut SceneView<V>,
    ) {
        let (Some(kept), Some(times)) = (&mut self.shown_ball, config.preset.ball.after_strike.times())
        else {
            return;
        };
        // The state is a frame before the one that it will be scored against.
        let to_strike_s = self.to_strike_s + V::c(config.dt_s);
        for (kept, scene, base) in
            [(&mut kept.truth, truth, bases[0]), (&mut kept.believed, believed, bases[1])]
        {
            kept.advance(base.point_in_world(scene.ball_at_strike), to_strike_s, times);
            for ball in [&mut scene.ball, &mut scene.ball_at_strike] {
                *ball = base.point_in_body(kept.shown(base.point_in_world(*ball), to_strike_s, times));
            }
        }
    }
}
