//! The part of a task's preset that says how its policy is played, under the preset's own keys. The text may come from an earlier or a later
//! program: keys that a player does not need are not read.

use std::collections::BTreeMap;

use paid_policy::PlayContract;
use paid_policy::observation::ObservationId;
use paid_robot::names::nearest;
use paid_track::{EyesPreset, roll_decay};
use serde::{Deserialize, Serialize};
use toml::{Table, Value};

use crate::{AfterStrikePreset, OwnPlace, PlayError};

/// How a policy is played: what a player needs of the task that the policy was trained in.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlayPreset {
    /// Name of the task.
    pub name: String,
    /// True: a kick of the left foot is played as the mirror image of one of the right foot.
    #[serde(default)]
    pub mirror_left_kicks: bool,
    /// Control period, and whether there is a ball.
    pub scene: PlayedScene,
    /// The ball.
    pub ball_params: PlayedBall,
    /// What is observed.
    pub observations: PlayedObservations,
    /// Motions and their balls.
    pub ball: PlayedPlacement,
    /// What it was trained on.
    #[serde(default)]
    pub randomization: PlayedRandomization,
    /// The ball tracker and the noise that it expects; camera and odometry of a simulated robot.
    #[serde(default)]
    pub eyes: EyesPreset,
}

/// Of a task's scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlayedScene {
    /// Physics step `[s]`.
    pub physics_dt_s: f64,
    /// Physics steps of a control step.
    pub substeps: usize,
    /// True if there is a ball to kick.
    pub ball: bool,
}

/// Of a task's nominal ball.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlayedBall {
    /// Radius `[m]`.
    pub radius_m: f64,
    /// Moment of inertia over mass and squared radius.
    pub inertia_factor: f64,
    /// Linear damping `[1/s]`.
    pub linear_damping: f64,
    /// Angular damping `[1/s]`.
    pub angular_damping: f64,
}

/// Of a task's observations.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlayedObservations {
    /// Terms of the policy's observation.
    pub policy: Vec<ObservationId>,
    /// Names of the critic's terms, of which this program need not know all.
    pub critic: Vec<String>,
}

/// Of a task's placement of the ball.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlayedPlacement {
    /// Where a motion's own ball is.
    #[serde(default)]
    pub own_place: OwnPlace,
    /// When the policy's foot meets a ball, by the motion's name, in seconds from its first frame.
    #[serde(default)]
    pub contact_s: BTreeMap<String, f64>,
    /// What is shown of the ball after the strike.
    #[serde(default)]
    pub after_strike: AfterStrikePreset,
}

/// Of a task's randomization.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PlayedRandomization {
    /// The robots that the policy was trained on, by their `mode_machine`. Empty: the one of the robot's files alone.
    #[serde(default)]
    pub mode_machines: Vec<u8>,
}

/// Tables whose keys are anything.
const OPEN: &str = "ball.contact_s";

impl PlayPreset {
    /// Reads the `[task]` of a run preset that a program wrote.
    ///
    /// # Errors
    /// Key, expected and found of what a player needs and cannot read, or of a value out of range.
    pub fn of_task(mut task: Table) -> Result<Self, PlayError> {
        // These tables refuse keys that they do not have.
        let table = |value: Option<Value>| value.unwrap_or_else(|| Table::new().into());
        keep_known(task.get_mut("eyes"), &table(Value::try_from(EyesPreset::default()).ok()));
        let rule = task.get_mut("ball").and_then(|ball| ball.get_mut("after_strike"));
        keep_known(rule, &table(Value::try_from(AfterStrikePreset::default()).ok()));
        let play: Self = task.try_into().map_err(|error| wrong(&error))?;
        play.check()?;
        Ok(play)
    }

    /// This preset with changed values, each `KEY=VALUE`.
    ///
    /// # Errors
    /// If a key is not about how a policy is played, or a value does not fit.
    pub fn with_overrides(&self, sets: &[String]) -> Result<Self, PlayError> {
        let mut table = Table::try_from(self).map_err(|error| PlayError::Preset(error.to_string()))?;
        for set in sets {
            let fail = |message: String| PlayError::Preset(format!("--set {set}: {message}"));
            lay(&mut table, parsed(set).map_err(fail)?, "").map_err(fail)?;
        }
        let play: Self = table.try_into().map_err(|error| wrong(&error))?;
        play.check()?;
        Ok(play)
    }

    fn check(&self) -> Result<(), PlayError> {
        let (PlayedBall { radius_m, inertia_factor, linear_damping, angular_damping }, scene) =
            (&self.ball_params, &self.scene);
        for (key, value, [least, most]) in [
            ("scene.physics_dt_s", scene.physics_dt_s, [f64::MIN_POSITIVE, 0.05]),
            ("scene.substeps", scene.substeps as f64, [1.0, 1000.0]),
            ("ball_params.radius_m", *radius_m, [f64::MIN_POSITIVE, 1.0]),
            ("ball_params.inertia_factor", *inertia_factor, [f64::MIN_POSITIVE, 1.0]),
            ("ball_params.linear_damping", *linear_damping, [0.0, 100.0]),
            ("ball_params.angular_damping", *angular_damping, [0.0, 100.0]),
        ] {
            if !(least..=most).contains(&value) {
                let least = if least == f64::MIN_POSITIVE { "above 0".to_owned() } else { least.to_string() };
                return Err(PlayError::value(key, &format!("{least} to {most}"), value));
            }
        }
        if let Some((name, time_s)) = self.contract().wrong_time() {
            return Err(PlayError::value(&format!("ball.contact_s.{name}"), "a time from 0 to 60 s", time_s));
        }
        self.ball.after_strike.check()?;
        self.eyes.check().map_err(|error| PlayError::Value {
            key: format!("eyes.{}", error.key),
            expected: error.expected,
            found: error.found,
        })
    }

    /// How the policy is played, as far as its network does not say.
    pub fn contract(&self) -> PlayContract {
        PlayContract {
            contact_s: self.ball.contact_s.clone(),
            mirror_left_kicks: self.mirror_left_kicks,
            where_it_lay: self.ball.after_strike.contract(),
        }
    }

    /// True if the policy sees a rolling ball where it will be when the reference strikes; motions are chosen by that place then.
    pub fn predicts_ball(&self) -> bool {
        self.observations.policy.contains(&ObservationId::BallAtStrike)
    }

    /// True if policy or critic is shown the ball where it will be. What is shown after the strike is that place then.
    pub fn predicts(&self) -> bool {
        let name = ObservationId::BallAtStrike.name();
        self.predicts_ball() || self.observations.critic.iter().any(|term| term == name)
    }

    /// Duration of a control step `[s]`.
    pub fn control_dt_s(&self) -> f64 {
        self.scene.physics_dt_s * self.scene.substeps as f64
    }

    /// Rate at which the ball slows down while it rolls `[1/s]`, see [`roll_decay`].
    pub fn ball_decay(&self) -> f64 {
        let PlayedBall { inertia_factor, linear_damping, angular_damping, .. } = self.ball_params;
        roll_decay(inertia_factor, linear_damping, angular_damping)
    }
}

/// Removes what `known` does not have.
fn keep_known(value: Option<&mut Value>, known: &Value) {
    let (Some(Value::Table(table)), Value::Table(known)) = (value, known) else { return };
    table.retain(|key, _| known.contains_key(key));
    for (key, value) in table {
        keep_known(Some(value), &known[key]);
    }
}

/// `KEY=VALUE` as a table: TOML if it parses, else a string.
fn parsed(set: &str) -> Result<Table, String> {
    let (key, value) =
        set.split_once('=').ok_or("expected KEY=VALUE, such as ball.after_strike.from_s=0.3")?;
    let text = format!("{} = {}", key.trim(), value.trim());
    let word = || format!("{} = {}", key.trim(), Value::String(value.trim().to_owned()));
    text.parse::<Table>().or_else(|_| word().parse()).map_err(|error| error.message().to_owned())
}

/// Puts values over those of the same keys.
fn lay(under: &mut Table, over: Table, above: &str) -> Result<(), String> {
    for (name, value) in over {
        let key = if above.is_empty() { name.clone() } else { format!("{above}.{name}") };
        match (under.get_mut(&name), value) {
            (None, value) if above == OPEN => drop(under.insert(name, value)),
            (None, _) => {
                let names: Vec<&String> = under.keys().collect();
                let hint = nearest(&name, &names)
                    .map_or_else(String::new, |near| format!("; did you mean '{near}'?"));
                return Err(format!("'{key}' is not about how a policy is played{hint}"));
            }
            (Some(Value::Table(under)), Value::Table(over)) => lay(under, over, &key)?,
            (Some(under @ Value::Float(_)), Value::Integer(number)) => *under = Value::Float(number as f64),
            (Some(under), value) if under.same_type(&value) => *under = value,
            (Some(under), value) => {
                return Err(format!("'{key}': expected {}, found {value}", under.type_str()));
            }
        }
    }
    Ok(())
}

/// The TOML reader's error, in one line, with the key.
pub(crate) fn wrong(error: &toml::de::Error) -> PlayError {
    let text = error.to_string();
    let place = text.lines().find_map(|line| line.strip_prefix("in `")?.strip_suffix('`'));
    let place = place.map_or_else(String::new, |key| format!("{key}: "));
    PlayError::Preset(format!("{place}{}", error.message()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TASK: &str = r#"
        name = "kick"
        wind = { speed = 3.0 }
        scene = { physics_dt_s = 0.005, substeps = 4, ball = true, gravity = -9.81 }
        ball_params = { radius_m = 0.11, inertia_factor = 0.667, linear_damping = 0.0, angular_damping = 2.5, mass_kg = 0.4 }
        observations = { policy = ["ball_pos"], critic = ["ball_at_strike", "a_term_of_tomorrow"] }
        ball = { own_place = "strike", contact_s = { a = 1.5 }, rule = "arc", after_strike = { show = "where_it_lay", color = "red" } }
        eyes = { c_min = 0.02, ears = 2, tracker = { gate = 5.0, smell = 1.0 } }
    "#;

    fn read(text: &str) -> Result<PlayPreset, PlayError> {
        PlayPreset::of_task(text.parse().expect("TOML"))
    }

    #[test]
    fn what_a_player_does_not_need_is_not_read() {
        let play = read(TASK).expect("reads");
        assert!((play.control_dt_s() - 0.02).abs() < 1e-12 && play.scene.ball);
        assert!((play.ball_decay() - 0.667 * 2.5 / 1.667).abs() < 1e-12);
        assert_eq!((play.eyes.c_min, play.eyes.tracker.gate, play.eyes.c_vel), (0.02, 5.0, 16.7));
        assert!(play.predicts() && !play.predicts_ball());
        let rule = play.contract().where_it_lay.expect("a rule");
        assert_eq!((rule.captured_s, rule.from_s), (0.2, 0.3));
    }

    #[test]
    fn what_a_player_needs_and_cannot_read_is_refused_by_key() {
        let refused = |from: &str, to: &str| read(&TASK.replace(from, to)).expect_err(to).to_string();
        let text = refused("radius_m = 0.11,", "");
        assert_eq!(text, "preset: ball_params: missing field `radius_m`");
        let text = refused("\"ball_pos\"", "\"scent\"");
        assert!(text.starts_with("preset: observations.policy") && text.contains("scent"), "{text}");
        let text = refused("radius_m = 0.11", "radius_m = -1.0");
        assert_eq!(text, "preset: ball_params.radius_m is -1, expected above 0 to 1");
        let text = refused("a = 1.5", "a = 90.0");
        assert_eq!(text, "preset: ball.contact_s.a is 90, expected a time from 0 to 60 s");
    }

    #[test]
    fn only_keys_of_playing_can_be_changed() {
        let play = read(TASK).expect("reads");
        let set = |text: &str| play.with_overrides(&[text.to_owned()]);
        assert_eq!(set("ball.contact_s.b=2").expect("another motion").ball.contact_s["b"], 2.0);
        assert_eq!(set("ball.contact_s={a=0.5}").expect("a table").ball.contact_s["a"], 0.5);
        assert_eq!(set("ball.after_strike.show=ball").expect("a word").contract().where_it_lay, None);
        assert_eq!(set("eyes.tracker.gate = 3").expect("a whole number").eyes.tracker.gate, 3.0);
        let refused = |text: &str| set(text).expect_err(text).to_string();
        assert_eq!(
            refused("rewards.kick=1"),
            "preset: --set rewards.kick=1: 'rewards' is not about how a policy is played"
        );
        assert_eq!(
            refused("eyes.tracker.gat=1"),
            "preset: --set eyes.tracker.gat=1: 'eyes.tracker.gat' is not about how a policy is played; did you mean 'gate'?"
        );
        assert_eq!(
            refused("scene.ball=3"),
            "preset: --set scene.ball=3: 'scene.ball': expected boolean, found 3"
        );
        assert_eq!(
            refused("ball.after_strike.from_s=9"),
            "preset: ball.after_strike.from_s is 9, expected 0 to 5 s"
        );
        assert!(refused("gate").contains("expected KEY=VALUE"));
    }
}
