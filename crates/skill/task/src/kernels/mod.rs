//! The vector parts of a control step, each entered with the lane type's instruction set.

pub(crate) mod act;
pub(crate) mod delay;
pub(crate) mod observe;
pub(crate) mod score;

use paid_lanes::{Kernel, MAX_LANES, Real, store_f32};
use paid_physics::GroupState;
use paid_play::ReferenceLibrary;

use crate::config::TaskConfig;
use crate::group::GroupTask;
use crate::kernels::score::{OwnScore, Score, Sums, score};
use crate::references::tracking::TrackingErrors;

/// Loads every lane's reference frame.
pub(crate) struct Gather<'a, V> {
    pub library: &'a ReferenceLibrary,
    pub group: &'a mut GroupTask<V>,
    /// Followed index of the anchor.
    pub anchor: usize,
    pub motions: [usize; MAX_LANES],
    pub frames: [usize; MAX_LANES],
}

impl<V: Real> Kernel for Gather<'_, V> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        self.group.reference.gather(self.library, &self.motions, &self.frames);
        if let Some(anchoring) = &self.group.anchoring {
            self.group.reference.move_by(anchoring, self.anchor);
        }
    }
}

/// Scores a group's new state.
pub(crate) struct ScoreGroup<'a, V> {
    pub config: &'a TaskConfig,
    pub state: &'a GroupState<V>,
    pub group: &'a mut GroupTask<V>,
    pub tracking: &'a mut TrackingErrors<V>,
    pub sums: &'a mut Sums<V>,
    pub own: &'a mut OwnScore<V>,
    pub reward: &'a mut [f32],
}

impl<V: Real> Kernel for ScoreGroup<'_, V> {
    type Output = Score<V>;
    #[inline(always)]
    fn run(self) -> Score<V> {
        let result = score(self.config, self.state, self.group, self.tracking, self.sums, self.own);
        store_f32(result.reward, self.reward);
        result
    }
}
