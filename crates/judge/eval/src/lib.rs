//! Scores a policy: how well it follows the motions, how well it shoots, and pictures of what it does.
//!
//! [`metrics`] are pure functions; [`episodes`] runs trials in batches on the task's own environments, which the built-in engine
//! or MuJoCo moves ([`engine`]); [`tracking`] and [`shooting`] are the paper's protocols, [`mod@matches`] go on
//! without a reset; [`eyes`] renders what the robot sees; [`agreement`] and [`tracking_agreement`] compare the engines
//! trial by trial, [`gap`] finds out which of their differences matter, [`panel`] whether a kick
//! holds on other balls and grounds, [`impacts`] compares single impacts of ball and leg. `paid_plot` draws.

pub mod agreement;
pub mod bench;
pub mod clips;
pub mod compare;
pub mod contacts;
pub mod curves;
pub mod dataset;
pub mod divergence;
pub mod engine;
pub mod episodes;
mod error;
pub mod eyes;
pub mod footage;
pub mod gap;
pub mod html;
pub mod impacts;
pub mod judge;
pub mod knowledge;
pub mod like_mujoco;
pub mod likeness;
pub mod metrics;
pub mod monitor;
pub mod panel;
pub mod policy;
mod protocol;
pub mod results;
pub mod scene;
pub mod share;
pub mod shot;
pub mod subject;
pub mod tracking_agreement;
pub mod worst;

pub use error::EvalError;
pub use protocol::{matches, shooting, tracking};
