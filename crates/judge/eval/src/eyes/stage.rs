//! What a worker plays trials on: task, policy, robot and place.

use paid_lanes::{Quat, Vec3};
use paid_mujoco::MujocoSim;
use paid_play::MotionFacts;
use paid_policy::VecEnv;
use paid_robot::{BodyPose, kinematics};
use paid_task::preset::KnowledgeMode;
use paid_task::{EnvSample, Task, roll_decay};
use paid_track::{EyesPreset, Pose};
use paid_vision::detect::Detector;
use paid_vision::scatter::{Robot, Scatter, Use};
use paid_world::{Finder, JointMessage, OwnBody, SightSetup};

use super::senses::{Moment, Senses, SensesSetup, eyes_error, quat_of};
use super::{DetectorChoice, EyesOptions, OdometryChoice};
use crate::episodes::EvalSetup;
use crate::policy::{Driver, DriverMaker};
use crate::shooting::{ShootingOptions, Trial};
use crate::{EvalError, Setting};

/// A control step `[ns]`.
pub(super) const STEP_NS: u64 = 20_000_000;

/// Images per second: the middle of the preset's range.
pub(super) fn rate(eyes: &EyesPreset) -> f64 {
    0.5 * (eyes.rate_hz[0] + eyes.rate_hz[1])
}

/// Age of an image when it arrives `[s]`: the middle of the preset's range.
pub(super) fn latency(eyes: &EyesPreset) -> f64 {
    0.5 * (eyes.latency_s[0] + eyes.latency_s[1])
}

/// What a worker keeps from trial to trial.
pub(super) struct Stage<'a> {
    pub setup: EvalSetup,
    pub policy: Box<dyn Driver>,
    pub options: &'a ShootingOptions,
    pub eyes: &'a EyesOptions,
    pub robot: Robot,
    pub scatter: Scatter,
    /// Index of the body that carries camera and LiDAR.
    pub torso: usize,
    /// Joint angles of the robot that stands and waits, model order `[rad]`.
    pub standing: Vec<f64>,
    /// Place of its base, anchor above the origin `[m]`.
    pub base: [f64; 3],
}

impl<'a> Stage<'a> {
    pub fn new(
        setup: &EvalSetup,
        policy: &DriverMaker,
        options: &'a ShootingOptions,
        eyes: &'a EyesOptions,
    ) -> Result<Self, EvalError> {
        let refuse = |option, expected: &str, found: String| {
            Err(EvalError::Option { option, expected: expected.to_owned(), found })
        };
        if setup.engine.name() != "mujoco" {
            return refuse(Setting::Named("engine"), "mujoco with --eyes", setup.engine.name().to_owned());
        }
        if (setup.preset.control_dt_s() - 0.02).abs() > 1e-9 {
            return refuse(
                Setting::Named("control period"),
                "0.02 s with --eyes",
                format!("{} s", setup.preset.control_dt_s()),
            );
        }
        let Some(torso) = setup.robot.body_index(&setup.spec.anchor_body) else {
            return refuse(Setting::Named("robot"), "one with its anchor body", setup.robot.name.clone());
        };
        let robot = Robot::g1().map_err(eyes_error)?;
        if setup.robot.name != robot.model().name {
            return refuse(
                Setting::Named("robot"),
                "the G1 with --eyes: its camera and LiDAR are simulated",
                setup.robot.name.clone(),
            );
        }
        let control =
            setup.spec.resolve(&setup.robot).map_err(|e| paid_task::TaskError::Robot(e.to_string()))?;
        let standing = control.default_pos;
        let bodies = kinematics::forward(&setup.robot, Vec3::zero(), Quat::identity(), &standing);
        let mut body = OwnBody::new(setup.robot.clone(), &setup.spec.anchor_body).map_err(eyes_error)?;
        body.take(&JointMessage { stamp_ns: 0, positions: standing.clone() }).map_err(eyes_error)?;
        let ground = body.ground(&pose_of(&bodies[torso])).unwrap_or(-setup.spec.nominal_height_m);
        let anchor = bodies[torso].pos;
        // The policy is shown what the eyes believe; the task's own knowledge is not used.
        let preset = setup.preset.with_knowledge(KnowledgeMode::Truth);
        Ok(Self {
            setup: EvalSetup { preset, ..setup.clone() },
            policy: policy()?,
            options,
            eyes,
            robot,
            scatter: Scatter::new(Use::HeldOut, setup.seed).map_err(eyes_error)?,
            torso,
            standing,
            base: [-anchor.x(), -anchor.y(), -ground],
        })
    }

    /// The task in MuJoCo, for one trial.
    pub fn task(&self, number: usize) -> Result<Task<f64, MujocoSim>, EvalError> {
        self.setup.mujoco(1, number, Some(self.torso))
    }

    /// The sensors of a trial.
    pub fn senses(&self, number: usize, trial: &Trial, torso: &Pose) -> Result<Senses, EvalError> {
        let number = u32::try_from(number).unwrap_or(u32::MAX);
        let eyes = &self.setup.preset.eyes;
        let setup = SensesSetup {
            options: self.eyes,
            preset: eyes,
            robot: self.robot.clone(),
            place: self.scatter.place(number),
            radius: self.setup.preset.ball_params.radius_m,
            goal: trial.goal,
            goal_half_width: self.options.goal_half_width_m,
            rate_hz: rate(eyes),
            latency_s: latency(eyes),
            seed: self.setup.seed,
            trial: number,
        };
        Senses::new(setup, torso)
    }

    /// The pipeline.
    pub fn sight(&self) -> Result<SightSetup, EvalError> {
        let detector = match &self.eyes.detector {
            DetectorChoice::Own => Some(Detector::own().map_err(eyes_error)?),
            DetectorChoice::File(path) => Some(Detector::load(path, self.eyes.class).map_err(eyes_error)?),
            DetectorChoice::ExactBox => None,
        };
        let detector = match (detector, self.eyes.confidence) {
            (Some(detector), Some(least)) => Some(detector.with_confidence(least)),
            (detector, _) => detector,
        };
        let preset = &self.setup.preset;
        let base = SightSetup::g1().map_err(eyes_error)?;
        Ok(SightSetup {
            robot: self.setup.robot.clone(),
            torso: self.setup.spec.anchor_body.clone(),
            radius_m: preset.ball_params.radius_m,
            decay: roll_decay(&self.setup.ball()),
            finder: detector.map_or(Finder::Boxes, |detector| Finder::Network(Box::new(detector))),
            noise: preset.eyes.noise(),
            tracker: preset.eyes.tracker.clone(),
            lidar: base.lidar.filter(|_| self.eyes.odometry == OdometryChoice::Lidar),
            ..base
        })
    }

    /// Robot and ball at a time, from the pose of the base and the joints.
    pub fn moment(
        &self,
        at_ns: u64,
        base: &Pose,
        joints: &[f64],
        rate: Vec3<f64>,
        ball: [[f64; 3]; 2],
    ) -> Moment {
        let bodies = kinematics::forward(&self.setup.robot, base.pos, quat_of(&base.rot), joints);
        let torso = pose_of(&bodies[self.torso]);
        Moment {
            at_ns,
            bodies,
            joints: joints.to_vec(),
            torso,
            torso_rate: rate,
            ball: ball[0],
            ball_vel: ball[1],
        }
    }

    /// The state of the simulation in the frame of the trial's start.
    pub fn moment_of(&self, at_ns: u64, sample: &EnvSample, start: &StartFrame) -> Moment {
        let base = &sample.bodies[0];
        let base = start.local(&Pose { rot: paid_lanes::Mat3(base.rot), pos: Vec3(base.pos) });
        let rate = start.turned(sample.bodies[self.torso].ang_vel);
        let ball = [start.point(sample.ball_pos), start.turned(sample.ball_vel).0];
        self.moment(at_ns, &base, &sample.joint_pos, rate, ball)
    }

    /// What the motions are.
    pub fn facts(&self) -> &[MotionFacts] {
        self.setup.library.facts()
    }

    /// Numbers of an observation and an action of one environment.
    pub fn sizes(task: &Task<f64, MujocoSim>) -> [usize; 3] {
        let groups = task.observation_groups();
        let of = |k: usize| groups.get(k).map_or(0, |group| group.size);
        [of(0), of(1), task.action_dim()]
    }
}

/// A pose of the kinematics as the eyes use it.
pub(super) fn pose_of(body: &BodyPose<f64>) -> Pose {
    Pose { rot: body.rot(), pos: body.pos }
}

/// The frame of a motion's start in the world: origin at the anchor, x along its heading.
#[derive(Clone, Copy, Debug)]
pub(super) struct StartFrame {
    world_from_start: Pose,
}

impl StartFrame {
    pub fn of(facts: &MotionFacts) -> Self {
        let rot = Quat::from_axis_angle(Vec3([0.0, 0.0, 1.0]), facts.heading).to_mat();
        let [x, y] = facts.start_xy;
        Self { world_from_start: Pose { rot, pos: Vec3([x, y, 0.0]) } }
    }

    pub fn local(&self, pose: &Pose) -> Pose {
        self.world_from_start.inverse().compose(pose)
    }

    pub fn point(&self, world: [f64; 3]) -> [f64; 3] {
        self.world_from_start.inverse_point(world)
    }

    pub fn turned(&self, world: [f64; 3]) -> Vec3<f64> {
        self.world_from_start.rot.tr_mul_vec(Vec3(world))
    }
}
