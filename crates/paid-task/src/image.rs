//! Kicks of the left foot as the mirror image of those of the right foot.

use paid_policy::observation::ObservationId;
use paid_policy::{Mirror, Mirrors, Sides};
use paid_robot::{Permutation, RobotModel, RobotSpec};

use crate::TaskError;
use crate::config::{TaskConfig, sides};
use crate::library::MotionFacts;
use crate::task::EnvTask;

/// How a policy's observation of these terms and its actions read in a mirrored world.
///
/// # Errors
/// Why the robot has no mirror image.
pub fn policy_mirrors(
    robot: &RobotModel,
    spec: &RobotSpec,
    terms: &[ObservationId],
) -> Result<Mirrors, String> {
    let control = spec.resolve(robot).map_err(|e| e.to_string())?;
    let to_model = Permutation::between(&robot.joint_names(), &spec.policy_joint_order)
        .map_err(|e| format!("policy_joint_order: {e}"))?;
    Ok(of_sides(&sides(robot, spec, &control, to_model.indices())?, terms))
}

/// [`policy_mirrors`] of a task.
pub(crate) fn mirrors(config: &TaskConfig) -> Result<Mirrors, String> {
    Ok(of_sides(config.sides.as_ref().map_err(Clone::clone)?, &config.preset.observations.policy))
}

fn of_sides(sides: &Sides, terms: &[ObservationId]) -> Mirrors {
    Mirrors { observation: Mirror::of_observation(terms, sides), action: Mirror::of_joints(sides) }
}

/// Between the world and the policy, which does not know of left-footed kicks.
pub(crate) struct Image {
    mirrors: Mirrors,
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
        let mirrors = mirrors(config).map_err(|why| TaskError::Robot(format!("mirror_left_kicks: {why}")))?;
        Ok(Some(Self { mirrors, left: Vec::new(), actions: Vec::new(), room: Vec::new() }))
    }

    fn mark(&mut self, envs: &[EnvTask], facts: &[MotionFacts]) -> bool {
        self.left.clear();
        self.left.extend(envs.iter().map(|env| facts[env.motion].kicks_left()));
        self.left.contains(&true)
    }

    /// What the policy is shown, from what there is to be seen `[features, envs]`.
    pub fn show(&mut self, observations: &mut [f32], envs: &[EnvTask], facts: &[MotionFacts]) {
        if self.mark(envs, facts) {
            self.mirrors.observation.apply_to_marked(observations, &self.left, &mut self.room);
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
