//! Which engines score a policy, and the constants of MuJoCo's scene as plain values.

use std::fs;
use std::path::Path;

use paid_files::FileError;
use paid_mujoco::contact::least_time_constant;
use paid_mujoco::{Cone, FootShapes, PdControl, SceneOptions};
use paid_robot::RobotModel;
use paid_task::TaskPreset;
use paid_task::layers::{KeyError, Tree};
use serde::{Deserialize, Serialize};

use crate::engine::EngineChoice;
use crate::ground::Ground;
use crate::{EvalError, Setting};

/// Which engines score.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Engines {
    /// The engine that trains.
    #[default]
    Builtin,
    /// MuJoCo, the reference simulator.
    Mujoco,
    /// Both on the same trials, compared one by one.
    Both,
}

/// A named set of constants for MuJoCo's scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ScenePreset {
    /// A size-5 ball of 0.43 kg.
    Paper,
    /// The same with a ball that bounces as a real one does.
    Real,
    /// The public evaluation: a solid ball of 0.1 kg.
    Public,
    /// The scene that the TWIST2 tracker is published with: floor friction 1, a softer floor, four spheres per foot, no dry friction
    /// in the joints, 1 ms steps.
    Twist2,
}

/// MuJoCo's scene: the content of a scene file. `None` keeps the value of the named set. [`KEYS`] describes the values.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[expect(missing_docs, reason = "KEYS describes them, for `paid eval scene --print` too")]
pub struct SceneSpec {
    pub protocol: Option<ScenePreset>,
    pub ground: Option<Ground>,
    pub ball_mass_kg: Option<f64>,
    pub physics_dt_s: Option<f64>,
    pub floor_friction: Option<f64>,
    pub floor_contact_time_s: Option<f64>,
    pub ball_friction: Option<f64>,
    pub ball_contact_time_s: Option<f64>,
    pub ball_contact_damping: Option<f64>,
    pub ball_damping: Option<bool>,
    pub training_ball: Option<bool>,
    pub training_soles: Option<bool>,
    pub implicit_pd: Option<bool>,
    pub elliptic_cone: Option<bool>,
    pub no_self_collision: Option<bool>,
    pub self_friction: Option<f64>,
    pub self_contact_time_s: Option<f64>,
    pub no_friction_loss: Option<bool>,
}

/// The keys of a scene file.
pub const KEYS: [(&str, &str); 18] = [
    ("protocol", "paper, real, public or twist2: gives the values of all keys that are left out"),
    ("ground", "flat, rough-1cm, rough-2cm, rough-3cm, slope-2deg, slope-4deg, turf or hard"),
    ("ball_mass_kg", "mass of the ball, in both engines"),
    ("physics_dt_s", "physics step; divides the control period"),
    ("floor_friction", "sliding friction between feet and floor"),
    ("floor_contact_time_s", "time constant of contacts with the floor; larger is softer"),
    ("ball_friction", "sliding friction of the ball"),
    ("ball_contact_time_s", "time constant of contacts with the ball; larger is softer"),
    ("ball_contact_damping", "damping ratio of contacts with the ball; 1: no bounce, 0.16: restitution 0.6"),
    ("ball_damping", "the ball's linear and angular damping, as in training"),
    ("training_ball", "friction, bounce and damping of the ball as in training"),
    ("training_soles", "four spheres per foot, as in training, instead of the vendor's seven capsules"),
    (
        "implicit_pd",
        "joint control damped with the next velocity, as in training, instead of explicit torques",
    ),
    ("elliptic_cone", "circular friction cone instead of the pyramid"),
    ("no_self_collision", "the robot's bodies pass through each other"),
    ("self_friction", "sliding friction between the robot's own bodies"),
    ("self_contact_time_s", "time constant of contacts between the robot's own bodies"),
    ("no_friction_loss", "no dry friction in the joints"),
];

impl SceneSpec {
    /// A named set (`paper`, `public`, `twist2`), or a scene file.
    ///
    /// # Errors
    /// If there is no such set, the file cannot be read, or a value does not fit: file, line, key, expected and found.
    pub fn load(name: &str) -> Result<Self, EvalError> {
        let path = Path::new(name);
        if path.extension().is_some_and(|extension| extension == "toml") {
            return Self::parse(name, &fs::read_to_string(path).map_err(FileError::at(path))?);
        }
        Self::parse(name, &format!("protocol = '{name}'")).map_err(|_| EvalError::Option {
            option: Setting::Scene,
            expected: "paper, real, public, twist2 or the path of a .toml file".to_owned(),
            found: format!("'{name}'"),
        })
    }

    /// The scene in the text of a scene file.
    ///
    /// # Errors
    /// As [`SceneSpec::load`].
    pub fn parse(file: &str, text: &str) -> Result<Self, EvalError> {
        let tree = Tree::parse(file, text)?;
        let refuse = |error| tree.locate(error, file);
        let spec = tree.typed().map_err(refuse)?;
        for (key, value, _) in tree.leaves() {
            let Some(found) = value.as_float().or_else(|| value.as_integer().map(|x| x as f64)) else {
                continue;
            };
            let zero = key == "self_friction" && found == 0.0;
            if !(found.is_finite() && found > 0.0 || zero) {
                let message = format!("expected a positive number, found {value}");
                return Err(refuse(KeyError { key, message }).into());
            }
        }
        Ok(spec)
    }

    /// The names of the values that are given.
    pub fn given(&self) -> impl Iterator<Item = &'static str> {
        let tree = Tree::of(self).unwrap_or_default();
        KEYS.into_iter().map(|(key, _)| key).filter(move |key| tree.contains(key))
    }

    /// The text of a scene file, with what each key means.
    pub fn to_toml(&self) -> String {
        let tree = Tree::of(self).unwrap_or_default();
        let lines = KEYS.into_iter().filter_map(|(key, what)| {
            let line = format!("{key} = {}", tree.value(key)?);
            Some(format!("{line:<32} # {what}\n"))
        });
        lines.collect()
    }

    /// The file whose values are all those of `scene`, which this specification resolved to with the ball of `task`.
    #[must_use]
    pub fn filled(&self, scene: &SceneOptions, task: &TaskPreset, usual: ScenePreset) -> Self {
        let ball = scene.ball.unwrap_or_default();
        Self {
            protocol: self.protocol.or(Some(usual)),
            ground: Some(self.ground.unwrap_or_default()),
            ball_mass_kg: Some(task.ball_params.mass_kg),
            physics_dt_s: Some(scene.physics_dt_s),
            floor_friction: Some(scene.floor.friction[0]),
            floor_contact_time_s: Some(scene.floor.solref[0]),
            ball_friction: Some(ball.friction[0]),
            ball_contact_time_s: Some(ball.solref[0]),
            ball_contact_damping: Some(ball.solref[1]),
            ball_damping: Some(ball.damped),
            training_ball: Some(self.training_ball == Some(true)),
            training_soles: Some(scene.feet == FootShapes::Sole),
            implicit_pd: Some(scene.pd == PdControl::Implicit),
            elliptic_cone: Some(scene.cone == Cone::Elliptic),
            no_self_collision: Some(!scene.self_collision),
            self_friction: Some(scene.self_friction),
            self_contact_time_s: Some(scene.self_contact_time_s),
            no_friction_loss: Some(!scene.friction_loss),
        }
    }

    /// MuJoCo's scene, from the `usual` set unless another was asked for. The ball of `task` becomes the one that was asked for, in
    /// both engines.
    ///
    /// # Errors
    /// If the physics step is no whole fraction of the control period.
    pub fn resolve(&self, task: &mut TaskPreset, usual: ScenePreset) -> Result<SceneOptions, EvalError> {
        let mut scene = match self.protocol.unwrap_or(usual) {
            ScenePreset::Paper => SceneOptions::default(),
            ScenePreset::Real => SceneOptions::real_ball(),
            ScenePreset::Public => {
                let scene = SceneOptions::public_protocol();
                if let Some(ball) = &scene.ball {
                    task.ball_params.mass_kg = ball.params.mass_kg;
                    task.ball_params.inertia_factor = ball.params.inertia_factor;
                }
                scene
            }
            ScenePreset::Twist2 => SceneOptions::twist2(),
        };
        self.ground.unwrap_or_default().apply(&mut scene, task);
        if let Some(mass) = self.ball_mass_kg {
            task.ball_params.mass_kg = mass;
        }
        if let Some(ball) = &mut scene.ball {
            ball.params = task.ball_params;
            if self.training_ball == Some(true) {
                *ball = ball.like_builtin(task.ball_params, &task.scene);
            }
            ball.friction[0] = self.ball_friction.unwrap_or(ball.friction[0]);
            ball.solref[0] = self.ball_contact_time_s.unwrap_or(ball.solref[0]);
            ball.solref[1] = self.ball_contact_damping.unwrap_or(ball.solref[1]);
            ball.damped = self.ball_damping.unwrap_or(ball.damped);
        }
        scene.floor.friction[0] = self.floor_friction.unwrap_or(scene.floor.friction[0]);
        scene.floor.solref[0] = self.floor_contact_time_s.unwrap_or(scene.floor.solref[0]);
        if self.training_soles == Some(true) {
            scene.feet = FootShapes::Sole;
        }
        if self.implicit_pd == Some(true) {
            scene.pd = PdControl::Implicit;
        }
        if self.elliptic_cone == Some(true) {
            scene.cone = Cone::Elliptic;
        }
        scene.self_collision = self.no_self_collision != Some(true);
        scene.self_friction = self.self_friction.unwrap_or(scene.self_friction);
        scene.self_contact_time_s = self.self_contact_time_s.unwrap_or(scene.self_contact_time_s);
        scene.friction_loss = self.no_friction_loss.map_or(scene.friction_loss, |none| !none);
        let (dt, control_dt) = (self.physics_dt_s.unwrap_or(scene.physics_dt_s), task.control_dt_s());
        scene.substeps = (control_dt / dt).round() as usize;
        scene.physics_dt_s = dt;
        if self.training_ball == Some(true) && self.ball_contact_time_s.is_none() {
            scene.resolve_contacts();
        }
        if scene.substeps == 0 || (scene.substeps as f64 * dt - control_dt).abs() > 1e-9 {
            return Err(EvalError::Option {
                option: Setting::Scene,
                expected: format!("a physics_dt_s that divides the control period of {control_dt} s"),
                found: dt.to_string(),
            });
        }
        check_resolved(&scene)?;
        Ok(scene)
    }
}

/// Refuses a ball that would leave before two physics steps are over: MuJoCo makes another contact of it, in silence.
fn check_resolved(scene: &SceneOptions) -> Result<(), EvalError> {
    let Some([time_s, damping]) = scene.ball.map(|ball| ball.solref) else { return Ok(()) };
    let dt_s = scene.physics_dt_s;
    let least = least_time_constant(damping, dt_s);
    if time_s >= least {
        return Ok(());
    }
    Err(EvalError::Option {
        option: Setting::Scene,
        expected: format!(
            "a ball whose contact lasts two physics steps of {dt_s} s: a ball_contact_time_s of at least {least:.4} with a \
             ball_contact_damping of {damping}, or a smaller physics_dt_s"
        ),
        found: format!("a ball_contact_time_s of {time_s}"),
    })
}

/// Refuses feet that belong to another robot.
///
/// # Errors
/// If the scene has the spheres of the G1's feet and `robot` is another one.
pub fn check_feet(scene: &SceneOptions, robot: &RobotModel) -> Result<(), EvalError> {
    let g1 = RobotModel::g1().name;
    if scene.feet == FootShapes::Spheres && robot.name != g1 {
        return Err(EvalError::Option {
            option: Setting::Scene,
            expected: format!("the robot '{g1}' for twist2"),
            found: format!("'{}'", robot.name),
        });
    }
    Ok(())
}

impl Engines {
    /// The engine that runs with `scene`; of both the built-in one, which runs first.
    pub fn first(self, scene: &SceneOptions) -> EngineChoice {
        match self {
            Self::Builtin | Self::Both => EngineChoice::Builtin,
            Self::Mujoco => EngineChoice::Mujoco(Box::new(scene.clone())),
        }
    }

    /// Reports that MuJoCo is missing, if it is needed, before anything else runs.
    ///
    /// # Errors
    /// If MuJoCo is needed and its library is missing.
    pub fn check(self) -> Result<(), EvalError> {
        if self != Self::Builtin {
            paid_mujoco::Library::get().map_err(paid_mujoco::MujocoError::from)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_apply_on_top_of_the_named_set_and_the_ball_is_the_same_in_both_engines() {
        let mut task = TaskPreset::builtin("paper_stage2").expect("built in");
        let text = "protocol = 'public'\nfloor_friction = 0.55\nno_friction_loss = true";
        let spec = SceneSpec::parse("mine.toml", text).expect("a scene file");
        let scene = spec.resolve(&mut task, ScenePreset::Paper).expect("a scene");
        assert_eq!((scene.floor.friction[0], scene.friction_loss), (0.55, false));
        assert_eq!((task.ball_params.mass_kg, task.ball_params.inertia_factor), (0.1, 0.4));
        assert_eq!(scene.ball.map(|ball| ball.params), Some(task.ball_params));
    }

    #[test]
    fn a_step_that_does_not_divide_the_control_period_is_refused() {
        let mut task = TaskPreset::builtin("paper_stage2").expect("built in");
        let spec = SceneSpec { physics_dt_s: Some(0.003), ..SceneSpec::default() };
        let error = spec.resolve(&mut task, ScenePreset::Paper).expect_err("0.02 / 0.003").to_string();
        assert_eq!(
            error,
            "scene: expected a physics_dt_s that divides the control period of 0.02 s, found 0.003"
        );
    }

    #[test]
    fn a_contact_that_no_step_resolves_is_refused() {
        let mut task = TaskPreset::builtin("paper_stage2").expect("built in");
        // The ball is back after a half period of 2 ms, in steps of 2 ms.
        let text = "ball_contact_time_s = 0.012\nball_contact_damping = 0.0536";
        let spec = SceneSpec::parse("a.toml", text).expect("a scene file");
        let error = spec.resolve(&mut task, ScenePreset::Paper).expect_err("too short").to_string();
        assert_eq!(
            error,
            "scene: expected a ball whose contact lasts two physics steps of 0.002 s: a ball_contact_time_s of at least 0.0237 with a \
             ball_contact_damping of 0.0536, or a smaller physics_dt_s, found a ball_contact_time_s of 0.012"
        );
        let finer = SceneSpec { physics_dt_s: Some(0.001), ..spec };
        assert!(finer.resolve(&mut task, ScenePreset::Paper).is_ok());
    }

    #[test]
    fn a_printed_file_resolves_to_the_scene_that_it_was_printed_from() {
        let usual = ScenePreset::Paper;
        for text in [
            "protocol = 'twist2'",
            "training_ball = true\nelliptic_cone = true",
            "ball_mass_kg = 1\nground = 'turf'",
        ] {
            let spec = SceneSpec::parse("a.toml", text).expect(text);
            let mut task = TaskPreset::builtin("paper_stage2").expect("built in");
            let scene = spec.resolve(&mut task, usual).expect(text);
            let printed = spec.filled(&scene, &task, usual).to_toml();
            assert_eq!(printed.lines().count(), KEYS.len(), "{printed}");
            let again = SceneSpec::parse("b.toml", &printed).expect("reads");
            assert!(again.given().eq(KEYS.map(|(key, _)| key)));
            let mut task = TaskPreset::builtin("paper_stage2").expect("built in");
            assert_eq!(again.resolve(&mut task, usual).expect(text), scene, "{printed}");
        }
    }

    #[test]
    fn a_wrong_file_is_refused_with_line_and_key() {
        for (text, expected) in [
            ("floor_frictoin = 1", "a.toml:1: floor_frictoin: unknown key; did you mean 'floor_friction'?"),
            ("\nball_mass_kg = 0", "a.toml:2: ball_mass_kg: expected a positive number, found 0"),
            ("self_friction = -0.1", "a.toml:1: self_friction: expected a positive number, found -0.1"),
            ("ball_friction = nan", "a.toml:1: ball_friction: expected a positive number, found nan"),
            ("protocol = 'mine'", "a.toml:1: protocol: unknown variant `mine`, expected one of `paper`"),
            ("ground = 'ice'", "a.toml:1: ground: unknown variant `ice`, expected one of `flat`"),
            ("training_ball = 1", "a.toml:1: training_ball: invalid type: integer `1`, expected a boolean"),
        ] {
            let error = SceneSpec::parse("a.toml", text).expect_err(text).to_string();
            assert!(error.starts_with(expected), "{error}");
        }
        assert!(SceneSpec::parse("a.toml", "self_friction = 0").is_ok());
        let error = SceneSpec::load("papre").expect_err("no such set").to_string();
        assert_eq!(
            error,
            "scene: expected paper, real, public, twist2 or the path of a .toml file, found 'papre'"
        );
    }

    #[test]
    fn small_spheres_are_the_g1s() {
        let mut robot = RobotModel::g1();
        check_feet(&SceneOptions::twist2(), &robot).expect("the G1");
        robot.name = "other".to_owned();
        check_feet(&SceneOptions::default(), &robot).expect("any robot has its own feet");
        assert!(check_feet(&SceneOptions::twist2(), &robot).is_err());
    }
}
