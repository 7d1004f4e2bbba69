//! Scores a policy: how well it follows the motions, how well it shoots, and what it does then, as films and reports.
//!
//! - [`metrics`]: pure functions.
//! - [`episodes`]: trials in batches on the task's own environments, which the built-in engine or MuJoCo moves ([`engine`]).
//! - [`tracking`], [`shooting`]: the paper's protocols; [`mod@matches`]: kick after kick without a reset.
//! - [`panel`], [`robustness`]: whether a kick holds with other balls, on other [`mod@ground`]s and when something goes wrong; [`eyes`]: shots with what the robot sees.
//! - [`results`], [`html`]: what an evaluation leaves in its folder. `paid_plot` draws.
//!
//! Begin reading with `protocol/shooting.rs`. What measures the project and not a policy is in `paid_lab`.

pub mod clips;
pub mod contacts;
pub mod curves;
pub mod engine;
pub mod episodes;
mod error;
#[cfg(feature = "eyes")]
pub mod eyes;
pub mod footage;
pub mod ground;
pub mod html;
pub mod judge;
pub mod knowledge;
pub mod lag;
pub mod likeness;
pub mod metrics;
pub mod monitor;
pub mod panel;
pub mod policy;
mod protocol;
pub mod results;
pub mod robustness;
pub mod scene;
pub mod share;
pub mod shot;
pub mod subject;
pub mod trace;
pub mod worst;

pub use error::{EvalError, Setting};
pub use protocol::{matches, shooting, tracking};
