//! Delays of actions and observations, up to one control step.

use paid_lanes::Real;
use paid_physics::GroupState;

use crate::config::TaskConfig;
use crate::group::GroupTask;
use crate::observe::joint_pos_rel;
use crate::score::projected_gravity;

/// Delays of a group and what they need to remember.
#[derive(Clone, Debug)]
pub(crate) struct Late<V> {
    /// Delay of the action [control steps].
    pub action: V,
    /// Delay of the proprioception [control steps].
    observation: V,
    /// Proprioception of the control step before: gravity, angular velocity, joint angles, joint velocities.
    before: Vec<V>,
}

impl<V: Real> Late<V> {
    /// Where the preset has delays.
    pub(crate) fn new(config: &TaskConfig) -> Option<Self> {
        let numbers = 6 + 2 * config.joints();
        config.preset.randomization.delays().then(|| Self {
            action: V::zero(),
            observation: V::zero(),
            before: vec![V::zero(); numbers],
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

    /// Number `k` of the proprioception, `now` in truth, as late as it is.
    #[inline(always)]
    pub(crate) fn felt(&self, k: usize, now: V) -> V {
        (self.before[k] - now).mul_add(self.observation, now)
    }
}

impl<V: Real> GroupTask<V> {
    /// Remembers the proprioception of the lanes whose bit is set.
    pub(crate) fn remember(&mut self, config: &TaskConfig, state: &GroupState<V>, lanes: u32) {
        let Some(mut late) = self.late.take() else { return };
        let base = &state.bodies[0];
        let (gravity, turning) = (projected_gravity(&base.rot), base.rot.tr_mul_vec(base.ang_vel));
        let joints = config.joints();
        let values = gravity
            .0
            .into_iter()
            .chain(turning.0)
            .chain((0..joints).map(|j| joint_pos_rel(config, state, self, j)))
            .chain((0..joints).map(|j| state.joint_vel[config.to_model[j]]));
        for (slot, value) in late.before.iter_mut().zip(values) {
            for lane in (0..V::LANES).filter(|l| lanes >> l & 1 == 1) {
                slot.set_lane(lane, value.lane(lane));
            }
        }
        self.late = Some(late);
    }
}
