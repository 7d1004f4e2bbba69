//! What the task remembers of a lane group.

use paid_lanes::{Real, Scalar, Vec3};

use crate::config::TaskConfig;
use crate::kick::KickState;
use crate::perception::Perception;
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
    /// Goal centre, world [m].
    pub goal: Vec3<V>,
    /// Cosine and sine of the motion's initial heading.
    pub heading: [V; 2],
    /// The ball's story.
    pub kick: KickState<V>,
    /// The perceived ball.
    pub perception: Perception<V>,
    /// Undiscounted return so far.
    pub episode_return: V,
    /// Largest speed of the labelled foot so far [m/s].
    pub foot_peak: V,
    /// The same of the reference.
    pub reference_peak: V,
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
            kick: KickState::new(),
            perception: Perception::new(),
            episode_return: V::zero(),
            foot_peak: V::zero(),
            reference_peak: V::zero(),
        }
    }

    /// Every number but the reference (which follows from motion and frame), for saving.
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
        fields
    }
}

/// `V::LANES` numbers of the trainer's `f32`.
#[inline(always)]
pub(crate) fn load_f32<V: Real>(x: &[f32]) -> V {
    let mut lanes = [V::Scalar::default(); MAX_LANES];
    let x = &x[..V::LANES];
    for lane in 0..V::LANES {
        lanes[lane] = V::Scalar::from_f64(f64::from(x[lane]));
    }
    V::load(&lanes[..V::LANES])
}

/// Writes `V::LANES` numbers as the trainer's `f32`.
#[inline(always)]
pub(crate) fn store_f32<V: Real>(value: V, out: &mut [f32]) {
    let mut lanes = [V::Scalar::default(); MAX_LANES];
    value.store(&mut lanes[..V::LANES]);
    let out = &mut out[..V::LANES];
    for lane in 0..V::LANES {
        out[lane] = lanes[lane].to_f64() as f32;
    }
}
