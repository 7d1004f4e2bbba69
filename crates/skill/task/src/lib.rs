//! The task: what the robot observes, what it is paid for, how its episodes begin and end.
//!
//! A [`TaskPreset`] (TOML) holds every constant, a [`paid_play::ReferenceLibrary`] the motions, and a [`TaskShard`] steps a number of
//! environments, one per SIMD lane.

mod act;
mod agent;
mod anchoring;
mod ball_preset;
mod codec;
mod config;
mod contact_kind;
mod curriculum;
mod delay;
mod disturb;
mod draw_params;
mod episode_preset;
mod episode_rules;
mod error;
mod eval_control;
mod eyes;
#[cfg(test)]
mod fixture;
mod group;
mod image;
mod kernels;
mod kick;
pub mod layers;
mod metrics;
mod next_kick;
mod observation_preset;
mod observe;
pub mod parameters;
mod placement;
pub mod preset;
mod randomization_preset;
mod reference;
mod reset;
mod rewards;
mod rolling;
mod sampler;
mod score;
mod shard;
mod shard_impl;
mod shown;
mod snapshot;
mod stance;
mod starts;
mod task;
mod terminations;
mod terms;
mod terms_table;
mod tracking;

pub use agent::{Agent, AgentReport, TermStatistics, observe_agent, run_agent};
pub use curriculum::BallCurriculum;
pub use disturb::Disturbance;
pub use episode_rules::{
    AfterEnd, AfterKick, AtMotionEnd, Disturbances, EpisodeRules, OnFailure, RewardTermsInSamples,
    SamplingStatistics, TimeLimit,
};
pub use error::TaskError;
pub use eval_control::{
    BelievedBall, BodySample, EnvSample, EvalControl, InitialState, KickEvent, NextKick, Shown,
};
pub use eyes::first_look;
pub use kick::KickStep;
pub use metrics::{KickStatistics, TRACKING_NAMES, TaskMetrics};
pub use paid_policy::observation::TermSetError;
pub use parameters::{ParameterInfo, Parameters, Requirement};
pub use preset::TaskPreset;
pub use rewards::{BodyKernel, KickPreset, ProximityPoint, RewardPreset, RewardTerm, Weighted, reward_names};
pub use rolling::roll_decay;
pub use sampler::SamplerState;
pub use shard::{ShardSetup, TaskSetup, TaskShard, TrainShard, build_engine, build_shard};
pub use task::Task;
pub use terminations::{EndCause, TerminationPreset, TerminationTerm, end_names};
pub use terms::{OwnRewards, OwnTerminations, TermInput, TermSet};
pub use terms_table::{TermInfo, terms_table};
