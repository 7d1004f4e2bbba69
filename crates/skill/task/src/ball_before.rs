//! Where the ball was shown before, for the observation term of that name.

use paid_lanes::Real;
use paid_policy::observation::ObservationId;
use paid_policy::{Pose, SceneView};
use paid_track::BallHistory;

use crate::config::TaskConfig;
use crate::group::GroupTask;

/// What critic and policy were shown: in truth, and as the policy believed it.
#[derive(Clone, Debug)]
pub(crate) struct BallsBefore<V> {
    truth: BallHistory<V>,
    believed: BallHistory<V>,
}

impl<V: Real> BallsBefore<V> {
    /// Where an observation has the term.
    pub(crate) fn new(config: &TaskConfig) -> Option<Self> {
        let lists = &config.preset.observations;
        let remembers = lists.policy.iter().chain(&lists.critic).any(|id| *id == ObservationId::BallBefore);
        remembers.then(|| Self { truth: BallHistory::new(), believed: BallHistory::new() })
    }

    pub(crate) fn fields(&mut self) -> impl Iterator<Item = &mut V> {
        self.truth.fields().chain(self.believed.fields())
    }

    /// Another ball, or another episode in one lane.
    pub(crate) fn reset_lane(&mut self, lane: usize) {
        self.truth.reset_lane(lane);
        self.believed.reset_lane(lane);
    }

    /// A control step is over.
    #[inline(always)]
    pub(crate) fn advance(&mut self) {
        self.truth.advance();
        self.believed.advance();
    }
}

impl<V: Real> GroupTask<V> {
    /// Adds to what critic (`truth`) and policy (`believed`) are about to be shown where the ball was shown before. `bases` are the
    /// base's poses in the frames in which either's places are kept: the world, and odometry's where the robot sees.
    #[inline(always)]
    pub(crate) fn show_before(
        &mut self,
        bases: [&Pose<V>; 2],
        truth: &mut SceneView<V>,
        believed: &mut SceneView<V>,
    ) {
        let Some(kept) = &mut self.balls_before else { return };
        for (kept, scene, base) in
            [(&mut kept.truth, truth, bases[0]), (&mut kept.believed, believed, bases[1])]
        {
            let before = kept.look(base.point_in_world(scene.ball));
            scene.ball_before = before.map(|place| base.point_in_body(place));
        }
    }
}
