//! The sensed terms of a control step, kept for the next one where observations are delayed.

use paid_lanes::{Kernel, Mask, Real};
use paid_physics::GroupState;
use paid_policy::Views;
use paid_policy::observation::Sink;

use crate::config::TaskConfig;
use crate::group::GroupTask;
use crate::kernels::observe::RobotBuffer;

/// Remembers the sensed terms of the lanes whose bit is set.
pub(crate) struct Remember<'a, V> {
    pub config: &'a TaskConfig,
    pub state: &'a GroupState<V>,
    pub group: &'a mut GroupTask<V>,
    pub robot: &'a mut RobotBuffer<V>,
    pub lanes: u32,
}

impl<V: Real> Kernel for Remember<'_, V> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let GroupTask { delays: Some(delays), joint_offset, action, .. } = self.group else { return };
        self.robot.fill_joints(self.config, self.state, joint_offset);
        let views = Views::of_robot(self.robot.view(self.state, action));
        let mut memory = Memory { slots: &mut delays.before, next: 0, lanes: V::Mask::from_bits(self.lanes) };
        for term in self.config.observations.policy.iter().filter(|term| term.sensed) {
            term.id.write(&views, &mut memory);
        }
    }
}

/// Writes some lanes and keeps the others.
struct Memory<'a, V: Real> {
    slots: &'a mut [V],
    next: usize,
    lanes: V::Mask,
}

impl<V: Real> Sink<V> for Memory<'_, V> {
    #[inline(always)]
    fn push(&mut self, value: V) {
        let slot = &mut self.slots[self.next];
        *slot = V::select(self.lanes, value, *slot);
        self.next += 1;
    }
}
