//! The vector parts of a control step, each entered with the lane type's instruction set.

use paid_lanes::{Kernel, MAX_LANES, Real, load_f32, store_f32};
use paid_physics::GroupState;

use crate::ReferenceLibrary;
use crate::config::TaskConfig;
use crate::group::GroupTask;
use crate::observe::{Draw, Rows, Seen, expected_ball, in_base, observe_critic, observe_policy};
use crate::score::{Score, Sums, score};
use crate::tracking::TrackingErrors;

/// Actions are limited to this; a NaN becomes the lower limit, so that it cannot reach the physics.
const ACTION_LIMIT: f64 = 100.0;

/// Loads every lane's reference frame.
pub(crate) struct Gather<'a, V> {
    pub library: &'a ReferenceLibrary,
    pub group: &'a mut GroupTask<V>,
    pub motions: [usize; MAX_LANES],
    pub frames: [usize; MAX_LANES],
}

impl<V: Real> Kernel for Gather<'_, V> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        self.group.reference.gather(self.library, &self.motions, &self.frames);
    }
}

/// Writes both observations of a group.
pub(crate) struct Observe<'a, V> {
    pub config: &'a TaskConfig,
    pub state: &'a GroupState<V>,
    pub group: &'a GroupTask<V>,
    pub seen: Option<Seen<V>>,
    pub draw: Draw<'a, V>,
    pub policy: &'a mut [f32],
    pub critic: &'a mut [f32],
    pub stride: usize,
    pub first: usize,
}

impl<V: Real> Kernel for Observe<'_, V> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let seen = match self.seen {
            Some(seen) => seen,
            None => Seen {
                ball: in_base(self.state, expected_ball(self.state, self.group)),
                goal: in_base(self.state, self.group.goal),
            },
        };
        let rows = Rows::new(self.policy, self.stride, self.first);
        observe_policy(self.config, self.state, self.group, seen, self.draw, rows);
        let rows = Rows::new(self.critic, self.stride, self.first);
        observe_critic(self.config, self.state, self.group, rows);
    }
}

/// Takes in an action and gives joint targets: default + offset + scale x action.
pub(crate) struct Act<'a, V> {
    pub config: &'a TaskConfig,
    pub group: &'a mut GroupTask<V>,
    pub actions: &'a [f32],
    pub stride: usize,
    pub first: usize,
    pub targets: &'a mut [V],
}

impl<V: Real> Kernel for Act<'_, V> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let control = &self.config.control;
        for j in 0..self.config.joints() {
            let m = self.config.to_model[j];
            let action = load_f32::<V>(&self.actions[j * self.stride + self.first..]);
            let action = action.clamp(V::c(-ACTION_LIMIT), V::c(ACTION_LIMIT));
            self.group.previous[j] = self.group.action[j];
            self.group.action[j] = action;
            let rest = self.group.joint_offset[m] + V::c(control.default_pos[m]);
            self.targets[m] = action.mul_add(V::c(control.action_scale[m]), rest);
        }
        if let Some(late) = &self.group.late {
            for j in 0..self.config.joints() {
                let m = self.config.to_model[j];
                let back = (self.group.previous[j] - self.group.action[j]) * late.action;
                self.targets[m] = back.mul_add(V::c(control.action_scale[m]), self.targets[m]);
            }
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
    pub reward: &'a mut [f32],
}

impl<V: Real> Kernel for ScoreGroup<'_, V> {
    type Output = Score<V>;
    #[inline(always)]
    fn run(self) -> Score<V> {
        let result = score(self.config, self.state, self.group, self.tracking, self.sums);
        store_f32(result.reward, self.reward);
        result
    }
}
