//! What can go wrong in an evaluation.

use core::fmt;
use std::path::PathBuf;

use paid_task::TaskError;
use paid_task::layers::LayerError;
use thiserror::Error;

/// An option of an evaluation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Setting {
    /// What a policy is given of ball and goal.
    Knowledge,
    /// Trials of a place or clip.
    Trials,
    /// Time limit of a trial.
    Limit,
    /// How far robots start from their place.
    StartRadius,
    /// How far balls lie from their place.
    Scatter,
    /// Speeds of rolling balls.
    Rolling,
    /// MuJoCo's scene.
    Scene,
    /// Where a recording goes.
    Recording,
    /// Length of a measurement.
    Seconds,
    /// Any other, by its name.
    Named(&'static str),
}

impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Knowledge => "knowledge",
            Self::Trials => "trials",
            Self::Limit => "limit",
            Self::StartRadius => "start radius",
            Self::Scatter => "scatter",
            Self::Rolling => "rolling",
            Self::Scene => "scene",
            Self::Recording => "recording",
            Self::Seconds => "seconds",
            Self::Named(name) => name,
        })
    }
}

/// An evaluation that cannot be run or written down.
#[derive(Debug, Error)]
pub enum EvalError {
    /// The task refuses.
    #[error(transparent)]
    Task(#[from] TaskError),
    /// The motions do not fit the robot.
    #[error(transparent)]
    Play(#[from] paid_play::PlayError),
    /// A scene file.
    #[error(transparent)]
    Scene(#[from] LayerError),
    /// MuJoCo is missing or refuses the scene.
    #[error(transparent)]
    Mujoco(#[from] paid_mujoco::MujocoError),
    /// The built-in engine refuses robot or scene.
    #[error(transparent)]
    Physics(#[from] paid_physics::PhysicsError),
    /// A motion file.
    #[error(transparent)]
    Motion(#[from] paid_motion::MotionError),
    /// An ONNX file.
    #[error(transparent)]
    Onnx(#[from] paid_onnx::OnnxError),
    /// A checkpoint, a run or a robot file.
    #[error(transparent)]
    Train(#[from] paid_train::TrainError),
    /// A robot's numbers do not fit its model.
    #[error(transparent)]
    Robot(#[from] paid_robot::SpecError),
    /// Two lists of joints differ.
    #[error(transparent)]
    Order(#[from] paid_robot::OrderError),
    /// A checkpoint.
    #[error(transparent)]
    Checkpoint(#[from] paid_policy::CheckpointError),
    /// A file cannot be read or written.
    #[error(transparent)]
    File(#[from] paid_files::FileError),
    /// A drawing cannot be written.
    #[error(transparent)]
    Plot(#[from] paid_plot::PlotError),
    /// The policy does not fit the task.
    #[error("policy: {what}: the task has {task}, the policy {policy}")]
    Contract {
        /// What differs.
        what: &'static str,
        /// The task's value.
        task: usize,
        /// The policy's value.
        policy: usize,
    },
    /// Processes that share out the trials do not agree.
    #[error("several processes: {0}")]
    Ranks(String),
    /// The policy cannot be read or run.
    #[error("policy: {0}")]
    Policy(String),
    /// The policy file names the motions that it was trained on, and they are not here.
    #[error("{}: the policy was trained on the motions '{motions}'; expected their folder, found none", policy.display())]
    Motions {
        /// The policy file.
        policy: PathBuf,
        /// Name of the folder of its motions.
        motions: String,
    },
    /// The policy returned a number that is not finite.
    #[error(
        "policy: action {action} of trial {trial} at control step {step} is {value}, expected a finite number"
    )]
    Action {
        /// Index in the action vector.
        action: usize,
        /// Trial.
        trial: usize,
        /// Control step.
        step: usize,
        /// The value.
        value: f32,
    },
    /// The protocol needs a ball, and the task has none.
    #[error("task '{task}': expected one with a physical ball, found scene.ball = false")]
    NoBall {
        /// Name of the task.
        task: String,
    },
    /// An option makes no sense.
    #[error("{option}: expected {expected}, found {found}")]
    Option {
        /// The option.
        option: Setting,
        /// What is allowed.
        expected: String,
        /// What was given.
        found: String,
    },
    /// Runs in a folder began with another policy or other clips.
    #[error("{}: expected runs of the origin '{expected}', found '{found}'; use another --out", path.display())]
    Origin {
        /// The file that says so.
        path: PathBuf,
        /// Prints of this call's.
        expected: String,
        /// Prints of the runs'.
        found: String,
    },
    /// The robot's eyes: a camera, a detector, odometry or a recording.
    #[error("eyes: {0}")]
    Eyes(String),
    /// The evaluation was stopped where a part of it is of no use.
    #[error("the episode was stopped before its end")]
    Stopped,
    /// A thread ended in the middle of its work.
    #[error("a thread of the {0} panicked")]
    Thread(&'static str),
    /// A file is not what it should be.
    #[error("{path}: expected {expected}: {found}")]
    Format {
        /// The file.
        path: PathBuf,
        /// What the file should be.
        expected: &'static str,
        /// What the reader says.
        found: String,
    },
    /// Numbers that JSON or TOML cannot hold.
    #[error("report: {0}")]
    Serialize(String),
    /// A recording cannot be written.
    #[error("{path}: {message}")]
    Recording {
        /// The file.
        path: PathBuf,
        /// The writer's answer.
        message: String,
    },
    /// A viewer of recordings cannot be started or does not answer.
    #[error("viewer at {address}: {message}")]
    Viewer {
        /// Where it should listen.
        address: String,
        /// What is wrong.
        message: String,
    },
}
