//! Delays of actions and observations, up to one control step.

use paid_lanes::{Kernel, Mask, Real};
use paid_physics::GroupState;
use paid_policy::Views;
use paid_policy::observation::Sink;

use crate::config::TaskConfig;
use crate::kernels::group::GroupTask;
use crate::kernels::observe::RobotBuffer;

/// Delays of a group and what they need to remember.
#[derive(Clone, Debug)]
pub(crate) struct Delays<V> {
    /// Delay of the action `[control steps]`.
    pub action: V,
    /// Delay of the sensed terms `[control steps]`.
    observation: V,
    /// The policy's sensed terms one control step ago, in the order of its list.
    before: Vec<V>,
}

impl<V: Real> Delays<V> {
    /// Where the preset has delays.
    pub(crate) fn new(config: &TaskConfig) -> Option<Self> {
        config.preset.randomization.delays().then(|| Self {
            action: V::zero(),
            observation: V::zero(),
            before: vec![V::zero(); config.observations.sensed],
        })
    }

    pub(crate) fn fields(&mut self) -> Vec<&mut V> {
        let mut fields = vec![&mut self.action, &mut self.observation];
        fields.extend(self.before.iter_mut());
        fields
    }

    pub(crate) fn reset_lane(&mut self, lane: usize, delays: [f64; 2]) {
        self.action.set_lane(lane, delays[0]);
        self.observation.set_lane(lane, delays[1]);
    }

    /// Number `k` of the sensed terms, `now` at this moment, as the policy gets it: between two control steps.
    #[inline(always)]
    pub(crate) fn delayed(&self, k: usize, now: V) -> V {
        (self.before[k] - now).mul_add(self.observation, now)
    }
}

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
