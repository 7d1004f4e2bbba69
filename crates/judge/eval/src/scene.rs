//! Which engines score a policy, and the constants of MuJoCo's scene as plain values.

use paid_mujoco::{Cone, FootShapes, PdControl, SceneOptions};
use paid_robot::RobotModel;
use paid_task::TaskPreset;

use crate::engine::EngineChoice;
use crate::{EvalError, Setting};

/// Which engines score.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Engines {
    /// The engine that trains.
    #[default]
    Builtin,
    /// MuJoCo, the referee.
    Mujoco,
    /// Both on the same trials, compared one by one.
    Both,
}

/// A named set of constants for MuJoCo's scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScenePreset {
    /// A size-5 ball of 0.43 kg.
    Paper,
    /// The public evaluation: a solid ball of 0.1 kg.
    Public,
    /// The scene that the TWIST2 tracker is published with: floor friction 1, a softer floor, four spheres per foot, no dry friction
    /// in the joints, 1 ms steps.
    Twist2,
}

/// MuJoCo's scene: a named set of constants and changes to it. `None` keeps the named set's value.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SceneSpec {
    /// The named set; `None`: the one that goes with the policy ([`crate::subject::PolicySource::usual_scene`]).
    pub preset: Option<ScenePreset>,
    /// Mass of the ball in both engines `[kg]`.
    pub ball_mass_kg: Option<f64>,
    /// Physics step `[s]`, a whole fraction of the control period.
    pub physics_dt_s: Option<f64>,
    /// Sliding friction between feet and floor.
    pub floor_friction: Option<f64>,
    /// Sliding friction of the ball.
    pub ball_friction: Option<f64>,
    /// Time constant of contacts with the ball `[s]`.
    pub ball_contact_time_s: Option<f64>,
    /// Time constant of contacts with the floor `[s]`.
    pub floor_contact_time_s: Option<f64>,
    /// Damping ratio of contacts with the ball; 1 does not bounce.
    pub ball_contact_damping: Option<f64>,
    /// The ball's linear and angular damping act in MuJoCo too.
    pub ball_damping: bool,
    /// Friction, bounce and damping of the ball as in training, as far as MuJoCo's contact can follow.
    pub training_ball: bool,
    /// The training's four spheres per foot instead of the vendor's seven capsules.
    pub training_soles: bool,
    /// Joint control with the next velocity's damping, as in training, instead of explicit torques.
    pub implicit_pd: bool,
    /// The circular friction cone instead of the pyramid.
    pub elliptic_cone: bool,
    /// Bodies of the robot pass through each other.
    pub no_self_collision: bool,
    /// Sliding friction between the robot's own bodies.
    pub self_friction: Option<f64>,
    /// Time constant of contacts between the robot's own bodies `[s]`.
    pub self_contact_time_s: Option<f64>,
    /// Joints have no dry friction.
    pub no_friction_loss: bool,
}

impl SceneSpec {
    /// MuJoCo's scene, from the `usual` set unless another was asked for. The ball of `task` becomes the one that was asked for, in
    /// both engines.
    ///
    /// # Errors
    /// If the physics step is no whole fraction of the control period.
    pub fn resolve(&self, task: &mut TaskPreset, usual: ScenePreset) -> Result<SceneOptions, EvalError> {
        let mut scene = match self.preset.unwrap_or(usual) {
            ScenePreset::Paper => SceneOptions::default(),
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
        if let Some(mass) = self.ball_mass_kg {
            task.ball_params.mass_kg = mass;
        }
        if let Some(ball) = &mut scene.ball {
            ball.params = task.ball_params;
            if self.training_ball {
                *ball = ball.like_builtin(task.ball_params, &task.scene);
            }
            ball.friction[0] = self.ball_friction.unwrap_or(ball.friction[0]);
            ball.solref[0] = self.ball_contact_time_s.unwrap_or(ball.solref[0]);
            ball.solref[1] = self.ball_contact_damping.unwrap_or(ball.solref[1]);
            ball.damped |= self.ball_damping;
        }
        scene.floor.friction[0] = self.floor_friction.unwrap_or(scene.floor.friction[0]);
        scene.floor.solref[0] = self.floor_contact_time_s.unwrap_or(scene.floor.solref[0]);
        if self.training_soles {
            scene.feet = FootShapes::Sole;
        }
        if self.implicit_pd {
            scene.pd = PdControl::Implicit;
        }
        if self.elliptic_cone {
            scene.cone = Cone::Elliptic;
        }
        scene.self_collision = !self.no_self_collision;
        scene.self_friction = self.self_friction.unwrap_or(scene.self_friction);
        scene.self_contact_time_s = self.self_contact_time_s.unwrap_or(scene.self_contact_time_s);
        scene.friction_loss &= !self.no_friction_loss;
        let (dt, control_dt) = (self.physics_dt_s.unwrap_or(scene.physics_dt_s), task.control_dt_s());
        scene.substeps = (control_dt / dt).round() as usize;
        scene.physics_dt_s = dt;
        if self.training_ball && self.ball_contact_time_s.is_none() {
            scene.resolve_contacts();
        }
        if scene.substeps == 0 || (scene.substeps as f64 * dt - control_dt).abs() > 1e-9 {
            return Err(EvalError::Option {
                option: Setting::PhysicsStep,
                expected: format!("a whole part of the control period of {control_dt} s"),
                found: dt.to_string(),
            });
        }
        Ok(scene)
    }
}

/// Refuses feet that belong to another robot.
///
/// # Errors
/// If the scene has the spheres of the G1's feet and `robot` is another one.
pub fn check_feet(scene: &SceneOptions, robot: &RobotModel) -> Result<(), EvalError> {
    let g1 = RobotModel::g1().name;
    if scene.feet == FootShapes::Spheres && robot.name != g1 {
        return Err(EvalError::Option {
            option: Setting::Twist2Scene,
            expected: format!("the robot '{g1}'"),
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

    /// Says that MuJoCo is missing, where it is needed, before anything else has run in vain.
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
        let spec = SceneSpec {
            preset: Some(ScenePreset::Public),
            floor_friction: Some(0.55),
            no_friction_loss: true,
            ..SceneSpec::default()
        };
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
        assert_eq!(error, "physics step: expected a whole part of the control period of 0.02 s, found 0.003");
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
