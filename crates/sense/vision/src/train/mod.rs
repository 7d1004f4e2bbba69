//! Training of the project's own detector, with burn. Behind the cargo feature `train-detector`.

mod batch;
mod model;
mod session;

pub use session::{Progress, TrainOptions, train};
