//! What simulates the trials: the built-in engine or MuJoCo.

use paid_mujoco::{Cone, FootShapes, Ground, MujocoSim, PdControl, SceneOptions};
use paid_physics::BallParams;
use paid_plot::number;
use paid_task::{ShardSetup, Task, TaskPreset, TaskSetup, TaskShard, build_shard};
use serde::Serialize;

use crate::EvalError;
use crate::episodes::EvalSetup;
use crate::knowledge::Knowledge;

/// The engine of an evaluation.
#[derive(Clone, Debug, Default)]
pub enum EngineChoice {
    /// The built-in engine, one trial per SIMD lane.
    #[default]
    Builtin,
    /// MuJoCo with this scene, one trial per world. Ball (mass, radius, inertia) and gravity are the task preset's, so that both engines
    /// see the same; whether there is a ball is the preset's decision too.
    Mujoco(Box<SceneOptions>),
}

/// What a report says about the simulator.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EngineFacts {
    /// `built-in` or `MuJoCo` with its version.
    pub name: String,
    /// Physics step `[s]`.
    pub physics_dt_s: f64,
    /// Mass of the ball `[kg]`; `None` without one.
    pub ball_mass_kg: Option<f64>,
    /// Surfaces and shapes in words.
    pub surfaces: String,
    /// What the policy knew of ball and goal; `None` without a ball.
    pub knowledge: Option<Knowledge>,
    /// Time after the strike from which the policy was shown the ball's position before the kick `[s]`; `None` if it was shown the moving ball.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shown_where_it_lay_s: Option<f64>,
}

impl EngineFacts {
    /// The policy's knowledge in words, with a separator before it; nothing without a ball.
    pub fn knowledge_text(&self) -> String {
        let shown = self.shown_where_it_lay_s.map_or_else(String::new, |s| {
            format!(", from {s} s after the strike the ball's position before the kick")
        });
        self.knowledge.as_ref().map_or_else(String::new, |k| format!("; knowledge: {k}{shown}"))
    }

    /// The policy's knowledge in one word, `-` without a ball.
    pub fn knowledge_name(&self) -> &'static str {
        self.knowledge.as_ref().map_or("-", Knowledge::name)
    }
}

impl EngineChoice {
    /// Short name: `builtin` or `mujoco`.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Builtin => "builtin",
            Self::Mujoco(_) => "mujoco",
        }
    }

    /// What a report states about it.
    pub fn facts(&self, preset: &TaskPreset) -> EngineFacts {
        let ball_mass_kg = preset.scene.ball.then_some(preset.ball_params.mass_kg);
        let knowledge = preset.scene.ball.then(|| Knowledge::of(preset));
        let after_strike = preset.ball.after_strike.times().filter(|_| preset.scene.ball);
        let shown_where_it_lay_s = after_strike.map(|times| times.from_s);
        match self {
            Self::Builtin => EngineFacts {
                name: "built-in".to_owned(),
                physics_dt_s: preset.scene.physics_dt_s,
                ball_mass_kg,
                surfaces: materials(preset),
                knowledge,
                shown_where_it_lay_s,
            },
            Self::Mujoco(scene) => EngineFacts {
                name: format!("MuJoCo {}", paid_mujoco::MUJOCO_VERSION),
                physics_dt_s: scene.physics_dt_s,
                ball_mass_kg,
                surfaces: surfaces(scene, preset),
                knowledge,
                shown_where_it_lay_s,
            },
        }
    }
}

/// What decides contacts in the built-in engine.
fn materials(preset: &TaskPreset) -> String {
    let ground = &preset.scene.ground;
    let mut words = format!("ground friction {}/{}", ground.static_friction, ground.dynamic_friction);
    if preset.scene.ball {
        let ball = preset.scene.contact_with_ground(preset.ball_params.material);
        words += &format!(
            ", ball on it {}/{}, restitution {:.2}",
            ball.static_friction, ball.dynamic_friction, ball.restitution
        );
    }
    words
}

/// What decides contacts and joint control in MuJoCo.
fn surfaces(scene: &SceneOptions, preset: &TaskPreset) -> String {
    let (floor, ball) = (&scene.floor, scene.ball.unwrap_or_default());
    let mut words =
        vec![format!("floor friction {} and contact time {} s", floor.friction[0], floor.solref[0])];
    match scene.ground {
        Ground::Flat => {}
        Ground::Slope { angle_rad, .. } => {
            words.push(format!("slope of {} degrees", number(angle_rad.to_degrees(), 1)));
        }
        Ground::Rough { amplitude_m, .. } => words.push(format!("rough by {amplitude_m} m")),
    }
    if preset.scene.ball {
        let [time, damping] = ball.solref;
        let bounce = if damping < 1.0 { format!(" at damping {damping}") } else { String::new() };
        words.push(format!("ball {} and {time} s{bounce}", ball.friction[0]));
    }
    words.push(format!(
        "feet: {}",
        match scene.feet {
            FootShapes::Referee => "the vendor's capsules",
            FootShapes::Sole => "the training soles",
            FootShapes::Spheres => "four small spheres",
        }
    ));
    words.push(format!(
        "PD: {}",
        match scene.pd {
            PdControl::Explicit => "explicit",
            PdControl::Implicit => "implicit",
        }
    ));
    let usual = SceneOptions::default();
    let own = |s: &SceneOptions| [s.self_friction, s.self_contact_time_s];
    if own(scene) != own(&usual) {
        let [friction, time] = own(scene);
        words.push(format!("own bodies: friction {friction} and contact time {time} s"));
    }
    let flags = [
        (scene.cone == Cone::Elliptic, "elliptic cone"),
        (preset.scene.ball && ball.damped, "ball damped"),
        (!scene.friction_loss, "no dry friction in joints"),
        (!(scene.self_collision && preset.scene.self_collision), "no self-collision"),
    ];
    words.extend(flags.iter().filter(|(set, _)| *set).map(|(_, word)| (*word).to_owned()));
    words.join(", ")
}

impl EvalSetup {
    /// Environments that step together: batches are a multiple of it.
    pub fn lanes(&self) -> usize {
        match self.engine {
            EngineChoice::Builtin => self.isa.lanes(),
            EngineChoice::Mujoco(_) => 1,
        }
    }

    /// The ball as the engine moves it: MuJoCo's rolls undamped unless its scene says otherwise.
    pub fn ball(&self) -> BallParams {
        let params = self.preset.ball_params;
        match &self.engine {
            EngineChoice::Mujoco(scene) if !scene.ball.unwrap_or_default().damped => {
                BallParams { linear_damping: 0.0, angular_damping: 0.0, ..params }
            }
            _ => params,
        }
    }

    /// Environments `first_env..first_env + num_envs` of the task on the setup's engine; `num_envs` is a multiple of
    /// [`EvalSetup::lanes`].
    ///
    /// # Errors
    /// If preset, robot and library do not fit together, or the engine cannot be had.
    pub fn build(&self, num_envs: usize, first_env: usize) -> Result<Box<dyn TaskShard>, EvalError> {
        let task = TaskSetup {
            robot: &self.robot,
            spec: &self.spec,
            library: &self.library,
            preset: &self.preset,
            first_env,
            seed: self.seed,
        };
        match &self.engine {
            EngineChoice::Builtin => Ok(build_shard(&ShardSetup { task, isa: self.isa, num_envs })?),
            EngineChoice::Mujoco(_) => Ok(Box::new(self.mujoco(num_envs, first_env, None)?)),
        }
    }

    /// The same in MuJoCo, whatever else the setup's engine is; the pose of the body `traced` is kept at every physics step.
    pub(crate) fn mujoco(
        &self,
        num_envs: usize,
        first_env: usize,
        traced: Option<usize>,
    ) -> Result<Task<f64, MujocoSim>, EvalError> {
        let mut scene = match &self.engine {
            EngineChoice::Builtin => SceneOptions::default(),
            EngineChoice::Mujoco(scene) => (**scene).clone(),
        };
        // Every trial has its own ground of the kind that was asked for.
        scene.ground = scene.ground.of_trial(self.seed, u32::try_from(first_env).unwrap_or(u32::MAX));
        let mut preset = TaskPreset { ball_params: self.ball(), ..self.preset.clone() };
        preset.resets.lift_to_ground |= scene.ground != Ground::Flat;
        preset.validate()?;
        scene.gravity = self.preset.scene.gravity;
        scene.self_collision &= self.preset.scene.self_collision;
        scene.ball = if self.preset.scene.ball {
            let surface = scene.ball.unwrap_or_default();
            Some(paid_mujoco::BallOptions { params: preset.ball_params, ..surface })
        } else {
            None
        };
        let control =
            self.spec.resolve(&self.robot).map_err(|e| paid_task::TaskError::Robot(e.to_string()))?;
        let mut sim = MujocoSim::new(&self.robot, &control, &scene, num_envs)?;
        sim.trace_body(traced);
        let task = TaskSetup {
            robot: &self.robot,
            spec: &self.spec,
            library: &self.library,
            preset: &preset,
            first_env,
            seed: self.seed,
        };
        Ok(Task::new(sim, &task)?)
    }
}
