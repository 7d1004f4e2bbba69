//! Kicks of the left foot as the mirror image of those of the right foot.

use paid_play::MotionFacts;
use paid_policy::{Mirror, Mirrors};

use crate::TaskError;
use crate::config::TaskConfig;
use crate::preset::TaskPreset;
use crate::task::EnvTask;

impl TaskPreset {
    /// Refuses the mirror for a policy with memory: it was not trained so, and its state has no image.
    ///
    /// # Errors
    /// If the task plays left-footed kicks in the mirror and the policy has memory.
    pub fn check_memory(&self, memory: bool) -> Result<(), TaskError> {
        if !(self.mirror_left_kicks && memory) {
            return Ok(());
        }
        Err(TaskError::Value {
            key: "mirror_left_kicks".to_owned(),
            expected: "false for a policy with memory".to_owned(),
            found: "true".to_owned(),
        })
    }
}

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
    /// Whether each environment's motion is mirrored.
    left: Vec<bool>,
    actions: Vec<f32>,
    room: Vec<f32>,
}

impl Image {
    /// `None` if the preset does not ask for it.
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

    /// What policy and critic are shown, from what there is to be seen `[features, envs]` each. Further groups stay as they are.
    pub fn show(&mut self, groups: &mut [&mut [f32]], envs: &[EnvTask], facts: &[MotionFacts]) {
        if self.mark(envs, facts) {
            for (group, mirror) in groups.iter_mut().zip([&self.mirrors.observation, &self.critic]) {
                mirror.apply_to_marked(group, &self.left, &mut self.room);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_policy_with_memory_is_not_played_in_the_mirror() {
        let plain = TaskPreset::builtin("paper_stage2").expect("built in");
        plain.check_memory(true).expect("no mirror");
        let mirrored = TaskPreset { mirror_left_kicks: true, ..plain };
        mirrored.check_memory(false).expect("no memory");
        let error = mirrored.check_memory(true).expect_err("both").to_string();
        assert_eq!(error, "preset: mirror_left_kicks is true, expected false for a policy with memory");
    }
}
