//! From an action to joint targets.

use paid_lanes::{Kernel, Real, load_f32};
use paid_policy::action::{joint_target, limit_action};

use crate::config::TaskConfig;
use crate::group::GroupTask;

/// Decodes the actions of a group, see [`paid_policy::action`].
pub(crate) struct Act<'a, V> {
    pub config: &'a TaskConfig,
    pub group: &'a mut GroupTask<V>,
    pub actions: &'a [f32],
    pub stride: usize,
    pub first: usize,
    /// Joint targets, model order `[rad]`.
    pub targets: &'a mut [V],
    /// The same of the action before `[rad]`; left alone where there are no delays.
    pub before: &'a mut [V],
}

impl<V: Real> Kernel for Act<'_, V> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let control = &self.config.control;
        for j in 0..self.config.joints() {
            let m = self.config.to_model[j];
            let action = limit_action(load_f32::<V>(&self.actions[j * self.stride + self.first..]));
            self.group.previous[j] = self.group.action[j];
            self.group.action[j] = action;
            let rest = self.group.joint_offset[m] + V::c(control.default_pos[m]);
            self.targets[m] = joint_target(action, control.action_scale[m], rest);
            if self.group.delays.is_some() {
                self.before[m] = joint_target(self.group.previous[j], control.action_scale[m], rest);
            }
        }
    }
}
