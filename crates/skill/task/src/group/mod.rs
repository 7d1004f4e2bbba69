//! What the task remembers of a lane group.

mod delays;

use paid_lanes::{Real, Vec3};
use paid_play::SceneMemory;
use paid_track::Eyes;

use crate::config::TaskConfig;
use crate::references::anchoring::LaneAnchoring;
use crate::references::frame::Reference;
use crate::scene::kick::KickState;
use crate::scene::shown::ShownScene;

pub(crate) use delays::Delays;

/// Task state of `V::LANES` environments.
#[derive(Clone, Debug)]
pub(crate) struct GroupTask<V> {
    /// The reference that the next state is scored against and that the policy sees now.
    pub reference: Reference<V>,
    /// Where the references begin, once a robot has continued without a reset; follows from the environments.
    pub anchoring: Option<LaneAnchoring<V>>,
    /// Last action, policy joint order.
    pub action: Vec<V>,
    /// The action before.
    pub previous: Vec<V>,
    /// Error of the default joint angles, model order `[rad]`.
    pub joint_offset: Vec<V>,
    /// Goal center, world `[m]`.
    pub goal: Vec3<V>,
    /// Cosine and sine of the motion's initial heading.
    pub heading: [V; 2],
    /// Time from the reference's frame to its strike, negative after it, infinite without a reference `[s]`; follows from motion and frame.
    pub to_strike_s: V,
    /// The same until the policy's foot meets the ball `[s]`.
    pub to_contact_s: V,
    /// What a rolling ball's velocity is multiplied by for its displacement until the foot meets it `[s]`, see
    /// [`paid_track::effective_time`]; follows from motion and frame.
    pub prediction_s: V,
    /// Contacts and outcome of the kick.
    pub kick: KickState<V>,
    /// What is remembered of the scenes that were shown: the true one (to the critic) and the estimated one (to the policy).
    pub scene_memory: [SceneMemory<V>; 2],
    /// Ball and goal through onboard perception, where the preset's knowledge is perceived.
    pub eyes: Option<Eyes<V>>,
    /// Ball and goal as an evaluation shows them.
    pub shown: Option<ShownScene<V>>,
    /// Delays of actions and observations, where the preset has them.
    pub delays: Option<Delays<V>>,
    /// Undiscounted return so far.
    pub episode_return: V,
    /// Largest speed of the labeled foot so far `[m/s]`.
    pub foot_peak: V,
    /// The same of the reference.
    pub reference_peak: V,
    /// Reward terms of the last step, order of [`crate::reward_names`]; kept only where an evaluation needs them.
    pub terms: Option<Vec<V>>,
}

impl<V: Real> GroupTask<V> {
    pub(crate) fn new(config: &TaskConfig, layout: paid_play::FrameLayout) -> Self {
        let zeros = vec![V::zero(); config.joints()];
        let memory = SceneMemory::new(config.preset.ball.after_strike.times());
        Self {
            reference: Reference::new(layout),
            anchoring: None,
            action: zeros.clone(),
            previous: zeros.clone(),
            joint_offset: zeros,
            goal: Vec3::zero(),
            heading: [V::one(), V::zero()],
            to_strike_s: V::zero(),
            to_contact_s: V::zero(),
            prediction_s: V::zero(),
            kick: KickState::new(),
            scene_memory: [memory.clone(), memory],
            eyes: config.preset.perceives().then(|| Eyes::new(&config.preset.eyes, config.dt_s)),
            shown: None,
            delays: Delays::new(config),
            episode_return: V::zero(),
            foot_peak: V::zero(),
            reference_peak: V::zero(),
            terms: None,
        }
    }

    /// Every number but the reference, where it begins and the times to its strike (which follow from the environments), the reward terms
    /// (which nothing depends on) and what an evaluation shows (which it shows again), for saving.
    pub(crate) fn fields(&mut self) -> Vec<&mut V> {
        let mut fields: Vec<&mut V> = Vec::new();
        fields.extend(self.action.iter_mut());
        fields.extend(self.previous.iter_mut());
        fields.extend(self.joint_offset.iter_mut());
        fields.extend(self.goal.0.iter_mut());
        fields.extend(self.heading.iter_mut());
        fields.extend(self.kick.fields());
        fields.extend([&mut self.episode_return, &mut self.foot_peak, &mut self.reference_peak]);
        fields.extend(self.delays.iter_mut().flat_map(Delays::fields));
        fields.extend(self.scene_memory.iter_mut().flat_map(SceneMemory::fields));
        fields.extend(self.eyes.iter_mut().flat_map(Eyes::fields));
        fields
    }
}
