//! Training runs: presets, stages and phases, logs, checkpoints, export.
//!
//! ```
//! use paid_train::RunPreset;
//!
//! let preset = RunPreset::resolve("stage1", &["run.seed=7".to_owned()])?;
//! assert_eq!((preset.stage.as_str(), preset.run.seed), ("stage1", 7));
//! # Ok::<(), paid_train::TrainError>(())
//! ```

pub mod bench;
mod error;
pub mod events;
pub mod explain;
pub mod folder;
mod inputs;
pub mod judge;
pub mod load;
pub mod meeting;
mod memory;
#[cfg(feature = "mpi")]
pub mod mpi_ranks;
pub mod phases;
pub mod policy_file;
pub mod policy_weights;
pub mod preset;
#[cfg(test)]
mod preset_tests;
pub mod progress;
pub mod published;
#[cfg(test)]
mod ranks_tests;
pub mod record;
#[cfg(test)]
mod run_tests;
pub mod setup;
pub mod stage;
#[cfg(test)]
mod start_tests;
pub mod style;
mod teacher;
#[cfg(test)]
mod toy;
pub mod trainer;
mod written;

pub use bench::{TrainBench, bench_train};
pub use error::TrainError;
pub use events::EventWriter;
pub use explain::Explanation;
pub use folder::RunFolder;
pub use judge::{Judge, JudgeConfig};
pub use load::{Resolved, task_preset};
pub use memory::peak_rss_mib;
pub use paid_learn::{Alone, Ranks};
pub use phases::Phase;
pub use policy_file::TrainedPolicy;
pub use preset::{RunConfig, RunPreset};
pub use progress::Progress;
pub use published::{Comparer, Comparison, PublishedRun, Standing};
pub use record::{LossRecord, Named, Record};
pub use setup::Scene;
pub use stage::{End, Limits, Outcome, StageJob, Start, train_in, train_judged_stage, train_stage};
pub use style::AmpPreset;
pub use teacher::TeacherPreset;
pub use trainer::Trainer;
