//! The self-description of a policy file: everything that an executor must agree with.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// Version of the contract format written by this program. Of the second one on, a policy that is played in the mirror has it in its
/// graph, as an input.
pub const FORMAT: u32 = 2;

/// Relative difference of two numbers that counts as none (they pass through decimal text).
const TOLERANCE: f64 = 1e-9;

/// What a policy expects to see and what its outputs mean. Units are SI.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Contract {
    /// [`FORMAT`].
    pub format: u32,
    /// Name of the robot.
    pub robot: String,
    /// The variants of it that the policy was trained on, by their `mode_machine`. Empty: the one of the robot's files alone.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub mode_machines: Vec<u8>,
    /// Terms under which the file may be used, with their reason (the motions that it was trained on).
    // Files of earlier versions spell it the British way.
    #[serde(alias = "licence")]
    pub license: String,
    /// Time between two actions `[s]`.
    pub control_period_s: f64,
    /// What an action means: target angle = default + scale * action.
    pub action: String,
    /// Joints in the order of actions and of every observation term over joints.
    pub joints: Vec<JointContract>,
    /// The body that anchors tracking.
    pub anchor_body: String,
    /// Tracked bodies, in the order of the reference's body arrays.
    pub bodies: Vec<String>,
    /// Observation terms in the order of the input.
    pub observation: Vec<ObservationTerm>,
    /// Commands that the policy follows (released metadata `command_names`).
    pub commands: Vec<String>,
    /// Recurrent state; `None` for a feed-forward policy.
    pub recurrent: Option<RecurrentContract>,
    /// Name of the embedded reference motion, if the file carries one.
    pub reference: Option<String>,
    /// How the policy is played, as far as its network does not say. A file without it is played as its task says.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub play: Option<PlayContract>,
}

/// How a policy is played.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlayContract {
    /// When its foot meets the ball, by the motion's name, in seconds from its first frame; others count with their strike.
    #[serde(default)]
    pub contact_s: BTreeMap<String, f64>,
    /// Whether kicks of the left foot are played as the mirror image of kicks of the right foot: the observation is mirrored before the
    /// network, the action after it, in the file's graph where its input `mirror` is 1.
    #[serde(default)]
    pub mirror_left_kicks: bool,
    /// The ball is shown where it lay once it is struck; without it, wherever it flies.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub where_it_lay: Option<WhereItLay>,
}

/// Times of the reference at which a struck ball is replaced by the place where it lay.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WhereItLay {
    /// Time before the strike at which its place is captured `[s]`, 0 to 5.
    pub captured_s: f64,
    /// Time after the strike from which that place is shown `[s]`, 0 to 5.
    pub from_s: f64,
}

impl PlayContract {
    /// The first motion whose time of contact is not from 0 to 60 s, and that time `[s]`.
    pub fn wrong_time(&self) -> Option<(&str, f64)> {
        let mut times = self.contact_s.iter().map(|(name, time_s)| (name.as_str(), *time_s));
        times.find(|(_, time_s)| !(0.0..=60.0).contains(time_s))
    }

    fn check(&self) -> Result<(), String> {
        if let Some((name, time_s)) = self.wrong_time() {
            return Err(format!("play.contact_s of '{name}' is {time_s}, expected 0 to 60 s"));
        }
        let times = self.where_it_lay.map(|lay| [("captured_s", lay.captured_s), ("from_s", lay.from_s)]);
        match times.into_iter().flatten().find(|(_, time_s)| !(0.0..=5.0).contains(time_s)) {
            Some((key, time_s)) => Err(format!("play.where_it_lay.{key} is {time_s}, expected 0 to 5 s")),
            None => Ok(()),
        }
    }
}

/// A joint's control numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JointContract {
    /// Name.
    pub name: String,
    /// Default angle `[rad]`.
    pub default_pos: f64,
    /// Stiffness `[N m/rad]`.
    pub stiffness: f64,
    /// Damping `[N m s/rad]`.
    pub damping: f64,
    /// Radians of target per unit of action.
    pub action_scale: f64,
}

/// A run of consecutive numbers of the observation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObservationTerm {
    /// Name.
    pub name: String,
    /// How many numbers.
    pub size: usize,
    /// What the numbers run over: `joints` (the contract's), `x,y,z`, ...
    pub order: String,
    /// Frame in which they are expressed; `joint` for joint coordinates.
    pub frame: String,
    /// Unit before scaling.
    pub unit: String,
    /// Factor on the physical quantity before the file's own normalization.
    pub scale: f64,
}

/// Size of the recurrent state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RecurrentContract {
    /// LSTM layers.
    pub layers: usize,
    /// State size of each.
    pub hidden: usize,
}

impl Contract {
    /// Numbers in an observation.
    pub fn observation_size(&self) -> usize {
        self.observation.iter().map(|t| t.size).sum()
    }

    /// How `found` differs from `self` in anything that changes what the policy sees or does: one sentence per difference, empty if
    /// the two agree. License, variants, embedded reference and play do not count.
    pub fn differences(&self, found: &Self) -> Vec<String> {
        let mut out = Vec::new();
        let d = &mut out;
        text(d, "robot", &self.robot, &found.robot);
        number(d, "control_period_s", self.control_period_s, found.control_period_s);
        text(d, "action", &self.action, &found.action);
        let names = |c: &Self| c.joints.iter().map(|j| j.name.clone()).collect::<Vec<_>>();
        list(d, "joints", &names(self), &names(found));
        for (a, b) in self.joints.iter().zip(&found.joints).filter(|(a, b)| a.name == b.name) {
            number(d, &format!("joint {} default_pos", a.name), a.default_pos, b.default_pos);
            number(d, &format!("joint {} stiffness", a.name), a.stiffness, b.stiffness);
            number(d, &format!("joint {} damping", a.name), a.damping, b.damping);
            number(d, &format!("joint {} action_scale", a.name), a.action_scale, b.action_scale);
        }
        text(d, "anchor_body", &self.anchor_body, &found.anchor_body);
        list(d, "bodies", &self.bodies, &found.bodies);
        let names = |c: &Self| c.observation.iter().map(|t| t.name.clone()).collect::<Vec<_>>();
        list(d, "observation terms", &names(self), &names(found));
        for (a, b) in self.observation.iter().zip(&found.observation).filter(|(a, b)| a.name == b.name) {
            let of = |key: &str| format!("observation {} {key}", a.name);
            text(d, &of("size"), &a.size.to_string(), &b.size.to_string());
            text(d, &of("order"), &a.order, &b.order);
            text(d, &of("frame"), &a.frame, &b.frame);
            text(d, &of("unit"), &a.unit, &b.unit);
            number(d, &of("scale"), a.scale, b.scale);
        }
        list(d, "commands", &self.commands, &found.commands);
        let state = |r: Option<RecurrentContract>| match r {
            Some(r) => format!("{} x {}", r.layers, r.hidden),
            None => "none".to_owned(),
        };
        text(d, "recurrent state", &state(self.recurrent), &state(found.recurrent));
        out
    }

    /// Checks the contract against itself: unique names without commas, finite positive numbers.
    ///
    /// # Errors
    /// A sentence that names the entry.
    pub fn check(&self) -> Result<(), String> {
        let joints: Vec<&str> = self.joints.iter().map(|j| j.name.as_str()).collect();
        let bodies: Vec<&str> = self.bodies.iter().map(String::as_str).collect();
        let terms: Vec<&str> = self.observation.iter().map(|t| t.name.as_str()).collect();
        for (what, names) in [("joint", &joints), ("body", &bodies), ("observation", &terms)] {
            for (i, name) in names.iter().enumerate() {
                if name.is_empty() || name.contains(',') {
                    return Err(format!("{what} name '{name}' is empty or has a comma"));
                }
                if names[..i].contains(name) {
                    return Err(format!("{what} name '{name}' occurs twice"));
                }
            }
        }
        if joints.is_empty() || terms.is_empty() {
            return Err("no joints or no observation terms".to_owned());
        }
        for j in &self.joints {
            let numbers = [j.default_pos, j.stiffness, j.damping, j.action_scale];
            if numbers.iter().any(|v| !v.is_finite()) || j.stiffness < 0.0 || j.damping < 0.0 {
                return Err(format!("joint '{}' has a gain that is negative or not finite", j.name));
            }
        }
        self.play.iter().try_for_each(PlayContract::check)?;
        match self.observation.iter().find(|t| t.size == 0 || !t.scale.is_finite()) {
            Some(t) => Err(format!("observation '{}' is empty or its scale is not finite", t.name)),
            None if !(self.control_period_s.is_finite() && self.control_period_s > 0.0) => {
                Err(format!("control_period_s is {}, expected a positive number", self.control_period_s))
            }
            None => Ok(()),
        }
    }
}

fn text(out: &mut Vec<String>, what: &str, expected: &str, found: &str) {
    if expected != found {
        out.push(format!("{what}: expected '{expected}', found '{found}'"));
    }
}

fn number(out: &mut Vec<String>, what: &str, expected: f64, found: f64) {
    let near = (expected - found).abs() <= TOLERANCE * expected.abs().max(found.abs());
    if !near {
        out.push(format!("{what}: expected {expected}, found {found}"));
    }
}

fn list(out: &mut Vec<String>, what: &str, expected: &[String], found: &[String]) {
    if expected.len() != found.len() {
        out.push(format!("{what}: expected {} of them, found {}", expected.len(), found.len()));
    }
    for i in 0..expected.len().max(found.len()) {
        let (a, b) = (expected.get(i), found.get(i));
        if a != b {
            let show = |n: Option<&String>| n.map_or_else(|| "nothing".to_owned(), |n| format!("'{n}'"));
            out.push(format!("{what}[{i}]: expected {}, found {}", show(a), show(b)));
        }
    }
}
