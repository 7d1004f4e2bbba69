//! Kicks of the left foot as the mirror image of those of the right foot.

use paid_play::MotionFacts;
use paid_policy::{Mirror, Mirrors};

use crate::TaskError;
use crate::config::TaskConfig;
use crate::task::EnvTask;

/// [`paid_play::policy_mirrors`] of a task.
pub(crate) fn mirrors(config: &TaskConfig) -> Result<Mirrors, String> {
    Ok(Mirrors::new(config.sides.as_ref().map_err(Clone::clone)?, &config.preset.observations.policy))
}

/// Between the world and the policy, which does not know of left-footed kicks. The critic does not either: what the policy can do
/// depends on the image alone, and so does its value.
pub(crate) struct Image {
    mirrors: Mirrors,
    /// Of the critic's observation.
    critic: Mirror,
    /// Of the teacher's, which acts for the policy.
    teacher: Mirror,
    /// Whether each environment's motion is mirrored.
    left: Vec<bool>,
    actions: Vec<f32>,
    room: Vec<f32>,
}

impl Image {
    /// `None` if the preset does not need it.
    ///
    /// # Errors
    /// If the robot's sides differ.
    pub fn new(config: &TaskConfig) -> Result<Option<Self>, TaskError> {
        if !config.preset.mirror_left_kicks {
            return Ok(None);
        }
        let sides =
            config.sides.as_ref().map_err(|why| TaskError::Robot(format!("mirror_left_kicks: {why}")))?;
        let terms = &config.preset.observations;
        Ok(Some(Self {
            mirrors: Mirrors::new(sides, &terms.policy),
            critic: Mirror::of_observation(&terms.critic, sides),
            teacher: Mirror::of_observation(&terms.teacher, sides),
            left: Vec::new(),
            actions: Vec::new(),
            room: Vec::new(),
        }))
    }

    fn mark(&mut self, envs: &[EnvTask], facts: &[MotionFacts]) -> bool {
        self.left.clear();
        self.left.extend(envs.iter().map(|env| facts[env.motion].kicks_left()));
        self.left.contains(&true)
    }

    /// What policy, critic and teacher are shown, from what there is to be seen `[features, envs]` each. A discriminator's group stays as
    /// it is. `teacher` is the number of the teacher's group, if there is one.
    pub fn show(
        &mut self,
        groups: &mut [&mut [f32]],
        teacher: Option<usize>,
        envs: &[EnvTask],
        facts: &[MotionFacts],
    ) {
        if self.mark(envs, facts) {
            let mirrors =
                [(Some(0), &self.mirrors.observation), (Some(1), &self.critic), (teacher, &self.teacher)];
            for (number, mirror) in mirrors {
                if let Some(group) = number.and_then(|number| groups.get_mut(number)) {
                    mirror.apply_to_marked(group, &self.left, &mut self.room);
                }
            }
        }
    }

    /// What is to be done in the world, from the policy's actions `[joints, envs]`.
    pub fn act<'a>(&'a mut self, actions: &'a [f32], envs: &[EnvTask], facts: &[MotionFacts]) -> &'a [f32] {
        if !self.mark(envs, facts) {
            return actions;
        }
        self.actions.clear();
        self.actions.extend_from_slice(actions);
        self.mirrors.action.apply_to_marked(&mut self.actions, &self.left, &mut self.room);
        &self.actions
    }
}
