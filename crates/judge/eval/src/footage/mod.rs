//! Recordings of motions, retargeting and episodes. A [`Footage`] knows no viewer: the software renderer draws it ([`picture`]), or
//! Rerun shows it (`Target`; cargo feature `rerun`).

mod draw;
mod film;
mod recorder;
mod recording;
#[cfg(feature = "rerun")]
mod stream;

pub use draw::{Shows, picture};
pub use film::{film_path, pose_of};
pub use recorder::Recorder;
pub use recording::{BESIDE, BodyPoses, Footage, Frame, LEAST_FORCE_N};
#[cfg(feature = "rerun")]
pub use stream::Target;
