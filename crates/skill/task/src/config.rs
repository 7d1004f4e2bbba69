//! Names resolved to indices, once.

use paid_physics::{BodyState, GroupState};
use paid_play::{MotionFacts, ReferenceLibrary, body_index, followed_bodies, sides};
use paid_policy::{Dimensions, ObservationLayout, Sides};
use paid_robot::{ControlSpec, Permutation, RobotModel, RobotSpec};

use crate::episode::variant::Variant;
use crate::preset::ReferenceSource;
use crate::preset::observation::ObservationConfig;
use crate::{TaskError, TaskPreset};

/// What every environment of a task shares. "Followed" indices are positions in [`ReferenceLibrary::followed`].
#[derive(Clone, Debug)]
pub(crate) struct TaskConfig {
    pub preset: TaskPreset,
    pub layout: ObservationLayout,
    pub observations: ObservationConfig,
    pub control: ControlSpec,
    /// Model joint of each policy joint.
    pub to_model: Vec<usize>,
    /// Which joints and tracked bodies are each other's image, or why there is none.
    pub sides: Result<Sides, String>,
    /// Model body of each followed body.
    pub followed: Vec<usize>,
    /// Number of tracked bodies: the first of the followed ones.
    pub tracked: usize,
    /// Followed index of the anchor.
    pub anchor: usize,
    /// Followed indices of the left and right foot.
    pub feet: [usize; 2],
    /// Followed indices of the end effectors.
    pub end_effectors: Vec<usize>,
    /// Model bodies whose contact is undesired.
    pub undesired: Vec<usize>,
    /// Number of bodies.
    pub bodies: usize,
    /// Policy joints of the waist.
    pub waist: Vec<usize>,
    /// Height of the base in the default pose `[m]`.
    pub nominal_height_m: f64,
    /// The robots that episodes are drawn from; none: the robot as its files have it.
    pub variants: Vec<Variant>,
    /// Center of mass of the base in its frame `[m]`.
    pub base_com: [f64; 3],
    /// True if episodes follow a reference motion.
    pub has_reference: bool,
    /// Control period `[s]`.
    pub dt_s: f64,
    /// Time limit [control steps].
    pub max_steps: u32,
}

impl TaskConfig {
    pub(crate) fn new(
        robot: &RobotModel,
        spec: &RobotSpec,
        control: ControlSpec,
        library: &ReferenceLibrary,
        preset: &TaskPreset,
    ) -> Result<Self, TaskError> {
        preset.validate()?;
        let followed = followed_bodies(robot, spec)?;
        if library.is_standing() != (preset.reference == ReferenceSource::None) {
            return Err(TaskError::Library(match preset.reference {
                ReferenceSource::Motions => {
                    "the preset follows reference motions, the library only stands".into()
                }
                ReferenceSource::None => {
                    "the preset has no reference: expected the standing library, found motions".into()
                }
            }));
        }
        if followed != library.followed() || library.layout().joints != robot.joints.len() {
            return Err(TaskError::Library("it was packed for another robot".into()));
        }
        let dt_s = preset.control_dt_s();
        if let Some(clip) = library.clips().iter().find(|c| (c.fps * dt_s - 1.0).abs() > 1e-6) {
            return Err(TaskError::Library(format!(
                "motion '{}' has {} frames a second, the control rate is {}",
                clip.name,
                clip.fps,
                1.0 / dt_s
            )));
        }
        let place = |role, name: &str| -> Result<usize, TaskError> {
            let body = body_index(robot, role, name)?;
            followed.iter().position(|b| *b == body).ok_or(TaskError::Name { role, name: name.to_owned() })
        };
        let to_model = Permutation::between(&robot.joint_names(), &spec.policy_joint_order)
            .map_err(|e| TaskError::Robot(format!("policy_joint_order: {e}")))?
            .indices()
            .to_vec();
        let mut end_effectors = Vec::new();
        for name in &spec.end_effectors {
            end_effectors.push(place("end effector", name)?);
        }
        let mut allowed = Vec::new();
        for name in &spec.allowed_contacts {
            allowed.push(body_index(robot, "allowed contact", name)?);
        }
        let mut waist = Vec::new();
        for name in &spec.waist_joints {
            let joint = spec.policy_joint_order.iter().position(|n| n == name);
            waist.push(joint.ok_or_else(|| TaskError::Name { role: "waist joint", name: name.clone() })?);
        }
        if waist.is_empty() && preset.rewards.waist_rate.weight != 0.0 {
            let message =
                "waist_joints: expected at least one, as rewards.waist_rate has a weight, found none";
            return Err(TaskError::Robot(message.into()));
        }
        let feet = [place("foot", &spec.feet[0])?, place("foot", &spec.feet[1])?];
        let config = Self {
            layout: preset.observations.layout(spec)?,
            observations: ObservationConfig::new(&preset.observations, Dimensions::of(spec)),
            sides: sides(robot, spec, &control, &to_model),
            to_model,
            tracked: spec.tracked_bodies.len(),
            anchor: place("anchor body", &spec.anchor_body)?,
            feet,
            end_effectors,
            undesired: (0..robot.bodies.len()).filter(|b| !allowed.contains(b)).collect(),
            waist,
            bodies: robot.bodies.len(),
            nominal_height_m: spec.nominal_height_m,
            variants: Variant::all(robot, spec, &control, &preset.randomization.mode_machines)?,
            base_com: robot.bodies[0].com,
            has_reference: preset.reference == ReferenceSource::Motions,
            dt_s,
            max_steps: (preset.episode_length_s / dt_s).round() as u32,
            followed,
            control,
            preset: preset.clone(),
        };
        if config.tracked == 0 {
            return Err(TaskError::Robot("tracked_bodies: expected at least one body".into()));
        }
        Ok(config)
    }

    /// The left (0) or right (1) foot.
    #[inline(always)]
    pub(crate) fn foot<'a, V>(&self, state: &'a GroupState<V>, side: usize) -> &'a BodyState<V> {
        &state.bodies[self.foot_body(side)]
    }

    /// The engine's body of the left (0) or right (1) foot.
    #[inline(always)]
    pub(crate) fn foot_body(&self, side: usize) -> usize {
        self.followed[self.feet[side]]
    }

    /// Control steps for which no contact counts as a kick, in an episode from frame `start` of a motion.
    pub(crate) fn no_kick_before(&self, facts: &MotionFacts, start: usize) -> usize {
        let early_s = self.preset.rewards.kick.early_s;
        if early_s <= 0.0 {
            return 0;
        }
        let early = (early_s / self.dt_s).round() as usize;
        // The episode's first step is scored against the frame after the start.
        facts.strike_frame.saturating_sub(early + start + 1)
    }

    /// Number of joints.
    #[inline(always)]
    pub(crate) fn joints(&self) -> usize {
        self.to_model.len()
    }
}
