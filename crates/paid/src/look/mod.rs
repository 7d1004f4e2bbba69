//! Looking at motions, retargeting and episodes: what happens is first recorded as [`Footage`], which knows no viewer, and then shown
//! by the software renderer ([`picture`]) or sent to Rerun ([`Target`]; needs the cargo feature `rerun`).

mod draw;
mod episode;
mod footage;
#[cfg(feature = "rerun")]
mod stream;
#[cfg(not(feature = "rerun"))]
mod without_rerun;

pub use draw::{Shows, picture};
pub use episode::Recorder;
pub use footage::Footage;
#[cfg(feature = "rerun")]
pub use stream::Target;
#[cfg(not(feature = "rerun"))]
pub use without_rerun::Target;
