//! What the task remembers of a lane group.

use core::any::Any;

use paid_lanes::{Real, Scalar, Vec3};

use crate::REWARD_TERMS;
use crate::config::TaskConfig;
use crate::kick::KickState;
use crate::late::Late;
use crate::perception::Perception;
use crate::picture::Pictures;
use crate::reference::{MAX_LANES, Reference};

/// Task state of `V::LANES` environments.
#[derive(Clone, Debug)]
pub(crate) struct GroupTask<V> {
    /// The reference that the next state is scored against and that the policy sees now.
    pub reference: Reference<V>,
    /// Last action, policy joint order.
    pub action: Vec<V>,
    /// The action before.
    pub previous: Vec<V>,
    /// Error of the default joint angles, model order [rad].
    pub joint_offset: Vec<V>,
    /// Goal center, world [m].
    pub goal: Vec3<V>,
    /// Cosine and sine of the motion's initial heading.
    pub heading: [V; 2],
    /// Time from the reference's frame to its strike, negative after it [s]; follows from motion and frame.
    pub to_strike_s: V,
    /// What a rolling ball's velocity is multiplied by for its way until the reference strikes [s]; follows from motion and frame.
    pub lead_s: V,
    /// The ball's story.
    pub kick: KickState<V>,
    /// The perceived ball.
    pub perception: Perception<V>,
    /// Ball and goal from pictures, where the preset says so.
    pub pictures: Option<Pictures<V>>,
    /// Delays of actions and observations, where the preset has them.
    pub late: Option<Late<V>>,
    /// Undiscounted return so far.
    pub episode_return: V,
    /// Largest speed of the labeled foot so far [m/s].
    pub foot_peak: V,
    /// The same of the reference.
    pub reference_peak: V,
    /// Reward terms of the last step, order of [`crate::REWARD_NAMES`]; kept only where an evaluation asks for them.
    pub terms: Option<Box<[V; REWARD_TERMS]>>,
}

impl<V: Real> GroupTask<V> {
    pub(crate) fn new(config: &TaskConfig, layout: crate::FrameLayout) -> Self {
        let zeros = vec![V::zero(); config.joints()];
        Self {
            reference: Reference::new(layout),
            action: zeros.clone(),
            previous: zeros.clone(),
            joint_offset: zeros,
            goal: Vec3::zero(),
            heading: [V::one(), V::zero()],
            to_strike_s: V::zero(),
            lead_s: V::zero(),
            kick: KickState::new(),
            perception: Perception::new(),
            pictures: Pictures::new(config),
            late: Late::new(config),
            episode_return: V::zero(),
            foot_peak: V::zero(),
            reference_peak: V::zero(),
            terms: None,
        }
    }

    /// Every number but the reference and the times to its strike (which follow from motion and frame) and the reward terms
    /// (which nothing depends on), for saving.
    pub(crate) fn fields(&mut self) -> Vec<&mut V> {
        let mut fields: Vec<&mut V> = Vec::new();
        fields.extend(self.action.iter_mut());
        fields.extend(self.previous.iter_mut());
        fields.extend(self.joint_offset.iter_mut());
        fields.extend(self.goal.0.iter_mut());
        fields.extend(self.heading.iter_mut());
        fields.extend(self.kick.fields());
        fields.extend(self.perception.fields());
        fields.extend([&mut self.episode_return, &mut self.foot_peak, &mut self.reference_peak]);
        fields.extend(self.pictures.iter_mut().flat_map(Pictures::fields));
        fields.extend(self.late.iter_mut().flat_map(Late::fields));
        fields
    }
}

/// `V::LANES` numbers of the trainer's `f32`.
#[inline(always)]
pub(crate) fn load_f32<V: Real>(x: &[f32]) -> V {
    let x = &x[..V::LANES];
    // Where the lanes are f32 this is one load; the compiler does not see that through element-wise conversion.
    if let Ok(eight) = <&[f32; 8]>::try_from(x)
        && let Some(same) = (eight as &dyn Any).downcast_ref::<[V::Scalar; 8]>()
    {
        return V::load(same);
    }
    if let Ok(sixteen) = <&[f32; 16]>::try_from(x)
        && let Some(same) = (sixteen as &dyn Any).downcast_ref::<[V::Scalar; 16]>()
    {
        return V::load(same);
    }
    let mut lanes = [V::Scalar::default(); MAX_LANES];
    for lane in 0..V::LANES {
        lanes[lane] = V::Scalar::from_f64(f64::from(x[lane]));
    }
    V::load(&lanes[..V::LANES])
}

/// Writes `V::LANES` numbers as the trainer's `f32`.
#[inline(always)]
pub(crate) fn store_f32<V: Real>(value: V, out: &mut [f32]) {
    let out = &mut out[..V::LANES];
    if let Ok(eight) = <&mut [f32; 8]>::try_from(&mut *out)
        && let Some(same) = (eight as &mut dyn Any).downcast_mut::<[V::Scalar; 8]>()
    {
        value.store(same);
        return;
    }
    if let Ok(sixteen) = <&mut [f32; 16]>::try_from(&mut *out)
        && let Some(same) = (sixteen as &mut dyn Any).downcast_mut::<[V::Scalar; 16]>()
    {
        value.store(same);
        return;
    }
    let mut lanes = [V::Scalar::default(); MAX_LANES];
    value.store(&mut lanes[..V::LANES]);
    for lane in 0..V::LANES {
        out[lane] = lanes[lane].to_f64() as f32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use paid_lanes::F32Array;

    #[test]
    fn trainer_numbers_enter_and_leave_every_lane_type() {
        let numbers: Vec<f32> = (0..20).map(|k| 0.1 * k as f32).collect();
        let mut out = [0.0; 20];
        store_f32(load_f32::<F32Array<8>>(&numbers[2..]), &mut out[2..]);
        assert_eq!(out[..10], [&[0.0, 0.0], &numbers[2..10]].concat());
        store_f32(load_f32::<F32Array<16>>(&numbers[3..]), &mut out[3..]);
        assert_eq!(out[3..19], numbers[3..19]);
        store_f32(load_f32::<f64>(&numbers[19..]), &mut out[19..]);
        assert_eq!(out[19], numbers[19]);
    }
}
