//! The task: what the robot observes, what it is rewarded for, how its episodes begin and end.
//!
//! A [`TaskPreset`] (TOML) holds every constant, a [`paid_play::ReferenceLibrary`] the motions, and a [`TaskShard`] steps a number of
//! environments, one per SIMD lane. Begin reading with `task/step.rs`, a control step from the actions to the ends of episodes; it calls
//! all else:
//!
//! - `preset`: every constant, checked; `layers`: how its files lie over one another. `config`: its names as indices.
//! - `references`: the reference of each lane, and the errors from it. `scene`: ball and goal, the kick, and what is seen of them.
//! - `group`: what is remembered of a lane group, in which those come together.
//! - `terms`: rewards, terminations, their table and sums; [`TermSet`] adds those of other crates.
//! - `episode`: starts, resets, sampling, and what an evaluation rules.
//! - `kernels`: the vector parts of a step. `task`: all of it over an engine; `shard`: how one is built.

mod agent;
mod codec;
mod config;
mod episode;
mod error;
#[cfg(test)]
mod fixture;
mod group;
mod kernels;
pub mod layers;
pub mod preset;
mod references;
mod scene;
mod shard;
mod task;
pub mod terms;

pub use agent::{Agent, AgentReport, TermStatistics, observe_agent, run_agent};
pub use episode::control::{BodySample, EnvSample, EvalControl, InitialState, KickEvent, NextKick};
pub use episode::curriculum::BallCurriculum;
pub use episode::disturb::Disturbance;
pub use episode::rules::{
    AfterEnd, AfterKick, AtMotionEnd, Disturbances, EpisodeRules, OnFailure, RewardTermsInSamples,
    SamplingStatistics, TimeLimit,
};
pub use episode::sampler::SamplerState;
pub use error::TaskError;
pub use paid_policy::observation::TermSetError;
pub use preset::TaskPreset;
pub use references::tracking::TRACKING_NAMES;
pub use scene::eyes::{BelievedBall, first_look};
pub use scene::kick::KickStep;
pub use scene::kick_preset::KickPreset;
pub use scene::rolling::roll_decay;
pub use scene::shown::Shown;
pub use shard::{ShardSetup, TaskSetup, TaskShard, TrainShard, build_engine, build_shard};
pub use task::Task;
pub use terms::metrics::{KickStatistics, TaskMetrics};
pub use terms::parameters::{ParameterInfo, Parameters, Requirement};
pub use terms::rewards::{BodyKernel, ProximityPoint, RewardPreset, RewardTerm, Weighted, reward_names};
pub use terms::table::{TermInfo, terms_table};
pub use terms::terminations::{EndCause, TerminationPreset, TerminationTerm, end_names};
pub use terms::{OwnRewards, OwnTerminations, TermInput, TermSet};
