//! A teacher in a run: a trained policy that the run's policy imitates.

use std::path::Path;
use std::sync::Arc;

use paid_learn::Teacher;
use paid_task::layers::KeyError;
use serde::{Deserialize, Serialize};

use crate::preset::of_config;
use crate::{RunPreset, Scene, TrainError, TrainedPolicy};

/// A policy to imitate, beside the reward or instead of it, and how much that counts ([`Teacher`]). It sees what its own preset lists, without
/// noise, and may thus be given what the student is not: a ball's velocity, say.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TeacherPreset {
    /// Policy file, checkpoint or run folder.
    pub policy: String,
    /// Factor on the imitation loss at the start of the run, against the surrogate loss.
    pub weight: f64,
    /// Share of the run at which the weight has fallen to nothing; linearly.
    pub until: f64,
}

impl RunPreset {
    /// Values that no teacher can have.
    pub(crate) fn check_teacher(&self) -> Result<(), KeyError> {
        let Some(TeacherPreset { policy, weight, until }) = &self.teacher else { return Ok(()) };
        if policy.is_empty() {
            let message = "expected the path of a policy, found an empty one".to_owned();
            return Err(KeyError { key: "teacher.policy".to_owned(), message });
        }
        Teacher::check(*weight, *until).map_err(|error| of_config("", error))
    }
}

impl Scene {
    /// The scene with the teacher of a run, if it has one: its shards show the teacher what it sees.
    ///
    /// # Errors
    /// If the teacher cannot be read or is of another robot.
    pub fn with_teacher(mut self, preset: &RunPreset) -> Result<Self, TrainError> {
        self.teacher = match &preset.teacher {
            None => None,
            Some(teacher) => {
                let trained = TrainedPolicy::load(Path::new(&teacher.policy))?;
                let [own, other] = [&self.spec, &trained.spec].map(|spec| &spec.policy_joint_order);
                if own != other {
                    let (own, other) = (&preset.robot, &trained.preset.robot);
                    let message =
                        format!("teacher.policy: expected one of robot '{own}', found one of '{other}'");
                    return Err(TrainError::Setup(message));
                }
                Some(Arc::new(trained))
            }
        };
        Ok(self)
    }

    /// The learner's side of the teacher.
    pub(crate) fn teacher(&self, preset: &RunPreset) -> Result<Option<Teacher>, TrainError> {
        let (Some(teacher), Some(trained)) = (&preset.teacher, &self.teacher) else { return Ok(None) };
        let policy = Arc::new(trained.policy.clone());
        Teacher::new(policy, teacher.weight, teacher.until)
            .map(Some)
            .map_err(|error| TrainError::Setup(format!("{error} ({})", teacher.policy)))
    }
}
