//! Every constant of a task, as typed TOML. Unknown keys are refused. Reward and termination terms, their parameters and the noise of
//! observation terms may be left out; every other key must be there.

pub(crate) mod ball;
pub(crate) mod episode;
pub(crate) mod numbers;
pub(crate) mod observation;
pub(crate) mod randomization;

use std::path::Path;

use paid_physics::{BallParams, ContactKind, Material, SceneConfig};
use paid_play::{
    PlayPreset, PlayedBall, PlayedObservations, PlayedPlacement, PlayedRandomization, PlayedScene,
};
use paid_policy::PlayContract;
use paid_policy::observation::ObservationId;
use serde::{Deserialize, Serialize};

use crate::layers::{LayerError, Tree};
use crate::scene::contact_kind;
pub use crate::scene::eyes::KnowledgeMode;
use crate::{Requirement, RewardPreset, TaskError, TerminationPreset};
use ball::check_after_strike;
pub use ball::{BallPlacement, BallRule, GoalPreset};
pub use episode::{PushPreset, ResetPreset, SamplingPreset, VelocityNoise};
use numbers::{POSITIVE_TIME, check, check_ball, check_material, check_scene};
pub use observation::ObservationPreset;
pub use paid_track::{CameraPreset, EyesPreset, OdometryPreset, TrackerPreset};
use randomization::delay_range;
pub use randomization::{RandomizationPreset, SurfacePreset};

/// A closed interval `[lo, hi]`; equal ends give a constant.
pub type Range = [f64; 2];

/// A task: what the robot observes, what it is rewarded for, and how its episodes begin and end.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TaskPreset {
    /// Name for logs.
    pub name: String,
    /// What the robot follows.
    pub reference: ReferenceSource,
    /// Time limit of an episode `[s]`; reaching it is a truncation.
    pub episode_length_s: f64,
    /// How long the robot is to stand in the motion's last pose before an episode ends, drawn for each one `[s]`.
    #[serde(default)]
    pub hold_s: Range,
    /// True: a kick of the left foot is played as the mirror image of one of the right foot. The policy sees it, and acts, as if in a
    /// mirror, so it has to learn the right foot's kicks only. Not for recurrent policies.
    #[serde(default)]
    pub mirror_left_kicks: bool,
    /// Ground, solver and control period.
    pub scene: SceneConfig,
    /// Nominal surface of the robot.
    pub robot_material: Material,
    /// Nominal ball.
    pub ball_params: BallParams,
    /// Nominal kind of contacts and joint control; the randomization of kinds replaces it.
    #[serde(default)]
    pub contact_kind: ContactKind,
    /// Delay between policy and joint targets `[s]`, up to a control period: until then the last ones hold. In evaluations too.
    #[serde(default)]
    pub action_delay_s: f64,
    /// What is observed, and its noise.
    pub observations: ObservationPreset,
    /// What the policy knows of ball and goal.
    #[serde(default)]
    pub knowledge: KnowledgeMode,
    /// Camera, odometry and ball tracker of `knowledge = "perceived"`.
    #[serde(default)]
    pub eyes: EyesPreset,
    /// Reward terms.
    pub rewards: RewardPreset,
    /// What ends an episode as a failure.
    pub terminations: TerminationPreset,
    /// How episodes begin.
    pub resets: ResetPreset,
    /// Which motion and phase they begin with.
    pub sampling: SamplingPreset,
    /// Where the ball is placed.
    pub ball: BallPlacement,
    /// Where the goal is placed.
    pub goal: GoalPreset,
    /// Disturbances.
    pub pushes: PushPreset,
    /// Physical parameters that are drawn at every reset.
    pub randomization: RandomizationPreset,
}

/// What the robot follows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ReferenceSource {
    /// The motions of the library. Episodes begin in one of their frames.
    #[default]
    Motions,
    /// Nothing: episodes begin in the robot's default standing pose, either foot may kick, and terms that need a reference are
    /// refused.
    None,
}

/// A run preset in the binary: name, file and TOML text.
pub type BuiltinPreset = (&'static str, &'static str, &'static str);

/// Built-in run presets by name, from the files of these names in `configs/presets`.
#[macro_export]
macro_rules! builtin_presets {
    ($($name:literal),+ $(,)?) => {
        [$((
            $name,
            concat!($name, ".toml"),
            include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../configs/presets/", $name, ".toml")),
        )),+]
    };
}

/// The paper's run presets, which have every key of the task.
pub const PAPER: [BuiltinPreset; 2] = builtin_presets!["paper_stage1", "paper_stage2"];

impl TaskPreset {
    /// The task of the paper's run preset (`paper_stage1`, `paper_stage2`).
    ///
    /// # Errors
    /// If there is none of this name.
    pub fn builtin(name: &str) -> Result<Self, TaskError> {
        Self::builtin_with(name, &[])
    }

    /// [`TaskPreset::builtin`] with `--set` overrides, whose keys are those of the task: `rewards.action_rate.weight=-0.05`.
    ///
    /// # Errors
    /// If there is none of this name, an override does not apply, or a value is out of range.
    pub fn builtin_with(name: &str, overrides: &[String]) -> Result<Self, TaskError> {
        let fail = |message: String| TaskError::Preset { name: name.to_owned(), message };
        let (_, file, text) = PAPER.iter().find(|(builtin, ..)| *builtin == name).ok_or_else(|| {
            fail(format!("not a built-in task; there are {}", PAPER.map(|(name, ..)| name).join(", ")))
        })?;
        let task = Tree::parse(file, text).map_err(|error| fail(error.to_string()))?.take("task");
        Self::of_tree(name, task.unwrap_or_default(), overrides)
    }

    /// Reads a task from TOML and applies `--set` overrides. `name` (a file name, say) is for the error.
    ///
    /// # Errors
    /// If the text is not TOML, a key is unknown or missing, an override does not apply, or a value is out of range.
    pub fn parse(name: &str, text: &str, overrides: &[String]) -> Result<Self, TaskError> {
        let fail =
            |error: LayerError| TaskError::Preset { name: name.to_owned(), message: error.to_string() };
        Self::of_tree(name, Tree::parse(name, text).map_err(fail)?, overrides)
    }

    /// This task with `--set` overrides.
    ///
    /// # Errors
    /// If an override does not apply, or a value is out of range.
    pub fn with_overrides(&self, overrides: &[String]) -> Result<Self, TaskError> {
        let fail = |message: String| TaskError::Preset { name: self.name.clone(), message };
        let tree = Tree::of(self).map_err(|error| fail(error.to_string()))?;
        Self::of_tree(&self.name, tree, overrides)
    }

    fn of_tree(name: &str, mut tree: Tree, overrides: &[String]) -> Result<Self, TaskError> {
        let fail =
            |error: LayerError| TaskError::Preset { name: name.to_owned(), message: error.to_string() };
        tree.expand_surfaces(Path::new("")).map_err(fail)?;
        let preset: Self = tree.typed().map_err(|error| fail(tree.locate(error, name)))?;
        // Through the type and back, so that values that are left to their defaults can be overridden too.
        let text =
            |error: toml::ser::Error| TaskError::Preset { name: name.to_owned(), message: error.to_string() };
        tree.fill(&preset).map_err(text)?;
        for text in overrides {
            tree.set(text, "").map_err(fail)?;
        }
        let preset: Self = tree.typed().map_err(|error| fail(tree.locate(error, name)))?;
        preset.validate()?;
        Ok(preset)
    }

    /// How a policy of this task is played, as far as its network does not say.
    pub fn play(&self) -> PlayContract {
        self.play_preset().contract()
    }

    /// Sets how a policy is played.
    pub fn set_play(&mut self, play: PlayContract) {
        self.ball.contact_s = play.contact_s;
        self.mirror_left_kicks = play.mirror_left_kicks;
        self.ball.after_strike.set_contract(play.where_it_lay);
    }

    /// How a policy of this task is played.
    pub fn play_preset(&self) -> PlayPreset {
        let (scene, ball, seen) = (&self.scene, &self.ball_params, &self.observations);
        PlayPreset {
            name: self.name.clone(),
            mirror_left_kicks: self.mirror_left_kicks,
            scene: PlayedScene {
                physics_dt_s: scene.physics_dt_s,
                substeps: scene.substeps,
                ball: scene.ball,
            },
            ball_params: PlayedBall {
                radius_m: ball.radius_m,
                inertia_factor: ball.inertia_factor,
                linear_damping: ball.linear_damping,
                angular_damping: ball.angular_damping,
            },
            observations: PlayedObservations {
                policy: seen.policy.clone(),
                critic: seen.critic.iter().map(|id| id.name().to_owned()).collect(),
            },
            ball: PlayedPlacement {
                own_place: self.ball.own_place,
                contact_s: self.ball.contact_s.clone(),
                after_strike: self.ball.after_strike.clone(),
            },
            randomization: PlayedRandomization { mode_machines: self.randomization.mode_machines.clone() },
            eyes: self.eyes.clone(),
        }
    }

    /// Checks that every value is in its range.
    ///
    /// # Errors
    /// The first value that is not.
    pub fn validate(&self) -> Result<(), TaskError> {
        let hold = ([0.0, 60.0], "times from 0 to 60 s");
        let episode = ("episode_length_s", self.episode_length_s.into(), POSITIVE_TIME);
        check("", &[("hold_s", self.hold_s.into(), hold), episode])?;
        check_scene(&self.scene)?;
        check_material("robot_material", &self.robot_material)?;
        check_ball(&self.ball_params)?;
        self.resets.check()?;
        self.pushes.check()?;
        self.ball.check()?;
        self.goal.check()?;
        self.rewards.kick.check()?;
        if self.mirror_left_kicks && self.reference == ReferenceSource::None {
            let expected = "false without a reference, which says which foot kicks";
            return Err(value_error("mirror_left_kicks", expected, "true".into()));
        }
        self.observations.check(self.reference)?;
        check_after_strike(&self.ball.after_strike, self.reference)?;
        self.eyes.check().map_err(|error| TaskError::below("eyes", error))?;
        let control_dt_s = self.control_dt_s();
        check("", &[("action_delay_s", self.action_delay_s.into(), delay_range(control_dt_s))])?;
        self.randomization.check(control_dt_s)?;
        contact_kind::check(&self.contact_kind)?;
        self.sampling.check(self.reference, self.hold_s)?;
        if let Some((name, time_s)) = self.play().wrong_time() {
            return Err(value_error(
                &format!("ball.contact_s.{name}"),
                "a time from 0 to 60 s",
                time_s.to_string(),
            ));
        }
        self.rewards.validate()?;
        self.terminations.validate()?;
        if self.reference == ReferenceSource::None {
            self.check_without_reference()?;
        }
        Ok(())
    }

    /// Refuses terms that need a reference, in a task without one.
    fn check_without_reference(&self) -> Result<(), TaskError> {
        let rewards = self.rewards.active().map(|(name, needs)| ("reward", name, needs));
        let terminations = self.terminations.active().map(|(name, needs)| ("termination", name, needs));
        match rewards.chain(terminations).find(|(.., needs)| needs.contains(&Requirement::Reference)) {
            Some((kind, name, _)) => Err(TaskError::NeedsReference { kind, name }),
            None => Ok(()),
        }
    }

    /// True if the policy sees a rolling ball where it will be when the reference strikes; motions are chosen by that place then.
    pub fn predicts_ball(&self) -> bool {
        self.observations.policy.contains(&ObservationId::BallAtStrike)
    }

    /// True if policy or critic is shown the ball where it will be. What is shown after the strike is that place then.
    pub fn predicts(&self) -> bool {
        self.observations.predicts()
    }

    /// True if actions or observations are delayed.
    pub(crate) fn delays(&self) -> bool {
        self.action_delay_s > 0.0 || self.randomization.delays()
    }

    /// True if ball and goal are known from onboard perception.
    pub fn perceives(&self) -> bool {
        self.knowledge == KnowledgeMode::Perceived
    }

    /// This task with another knowledge of ball and goal.
    #[must_use]
    pub fn with_knowledge(&self, knowledge: KnowledgeMode) -> Self {
        Self { knowledge, ..self.clone() }
    }

    /// Duration of a control step `[s]`.
    pub fn control_dt_s(&self) -> f64 {
        self.scene.physics_dt_s * self.scene.substeps as f64
    }
}

pub(crate) fn value_error(key: &str, expected: &str, found: String) -> TaskError {
    TaskError::Value { key: key.to_owned(), expected: expected.to_owned(), found }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn builtin_presets_parse_and_survive_a_round_trip() {
        for (name, ..) in PAPER {
            let preset = TaskPreset::builtin(name).expect("valid");
            let text = toml::to_string(&preset).expect("writes");
            assert_eq!(TaskPreset::parse(name, &text, &[]).expect("reads"), preset);
            assert!((preset.control_dt_s() - 0.02).abs() < 1e-12);
        }
    }

    #[test]
    fn an_unknown_key_and_a_bad_range_are_refused() {
        let task = TaskPreset::builtin("paper_stage1").expect("valid");
        let text = format!("surprise = 1\n{}", toml::to_string(&task).expect("writes"));
        let error = TaskPreset::parse("x", &text, &[]).expect_err("unknown key").to_string();
        assert!(error.contains("x:1: surprise: unknown key"), "{error}");
        let error = task.with_overrides(&["pushes.interval_s=[3, 1]".into()]).expect_err("bad");
        assert_eq!(
            error.to_string(),
            "preset: pushes.interval_s is [3.0, 1.0], expected [lo, hi] with lo <= hi"
        );
    }

    #[test]
    fn a_key_that_the_file_leaves_out_can_be_overridden() {
        let task = TaskPreset::builtin("paper_stage2").expect("valid");
        let mut table = toml::Table::try_from(&task).expect("writes");
        assert!(table["rewards"].as_table_mut().expect("a table").remove("hand_pos").is_some());
        let text = table.to_string();
        let hand_pos =
            |overrides: &[String]| TaskPreset::parse("x", &text, overrides).expect("valid").rewards.hand_pos;
        assert_eq!((hand_pos(&[]).weight, hand_pos(&[]).sigma), (0.0, 0.1));
        assert_eq!(hand_pos(&["rewards.hand_pos.sigma=0.2".into()]).sigma, 0.2);
    }

    #[test]
    fn the_papers_ball_is_the_engines_default_one() {
        let ball = TaskPreset::builtin("paper_stage2").expect("valid").ball_params;
        assert_eq!(ball, BallParams::default());
    }

    #[test]
    fn the_default_noise_is_two_centimeters_near_and_ten_far_and_fast() {
        let noise = TaskPreset::builtin("paper_stage2").expect("valid").eyes.noise();
        let sigma = |v: f64, d| noise.deviation(v, d);
        assert!((sigma(0.0, 1.0) - 0.02).abs() < 0.001, "{}", sigma(0.0, 1.0));
        assert!((sigma(1.0, 3.0) - 0.10).abs() < 0.002, "{}", sigma(1.0, 3.0));
    }

    #[test]
    fn stage_weights_are_the_papers() {
        let one = TaskPreset::builtin("paper_stage1").expect("valid").rewards;
        let two = TaskPreset::builtin("paper_stage2").expect("valid").rewards;
        assert_eq!([one.anchor_pos.weight, one.body_pos.weight, one.foot_pos.weight], [1.0, 1.0, 0.0]);
        assert_eq!([two.anchor_pos.weight, two.anchor_ori.weight, two.body_pos.weight], [0.0, 0.5, 0.8]);
        assert_eq!([two.contact.weight, two.side_kick.weight, two.vel_align.weight], [50.0, 50.0, 30.0]);
        assert_eq!([two.speed.weight, two.z_speed.weight, two.upright.weight], [10.0, -0.2, -1.0]);
    }
}
