//! Rollout workers, stages, logging, resume.

mod error;
pub mod events;
pub mod folder;
pub mod record;
pub mod tree;

pub use error::TrainError;
pub use events::EventWriter;
pub use folder::RunFolder;
pub use record::{LossRecord, Named, Record};
