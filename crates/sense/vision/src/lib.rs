//! From image to ball: a renderer for simulated cameras, detectors by ONNX, and the ball's place from color and depth.
//!
//! A camera's images go to a [`detect::Detector`], its detections with the depth image to a [`locate::BallFinder`], which knows where
//! the torso was when the image was taken; out come sightings in the odometry frame for `paid-track`'s ball tracker. The same calls
//! take rendered images ([`render`], [`scatter`]) and real ones.
//!
//! ```
//! use paid_vision::detect::{Depth, Detector};
//! use paid_vision::render::render;
//! use paid_vision::scatter::{Scatter, Use};
//! use paid_vision::Intrinsics;
//!
//! // A random scene with a ball in it, and its image.
//! let scatter = Scatter::new(Use::HeldOut, 1)?;
//! let sample = scatter.sample(0, Intrinsics::g1_color(), true);
//! let rendered = render(&sample.scene, &sample.view);
//! let (color, depth) = (rendered.color(&sample.color), rendered.depth(&sample.depth));
//! let depth = Depth { image: &depth, intrinsics: &sample.view.intrinsics };
//! for ball in Detector::own()?.detect(&color, Some(depth))? {
//!     println!("{:?} with score {:.2}", ball.outline.middle(), ball.score);
//! }
//! # Ok::<(), paid_vision::VisionError>(())
//! ```

mod calibrate;
pub mod detect;
mod error;
mod image;
mod intrinsics;
pub mod judge;
pub mod locate;
pub mod net;
mod picture_fault;
pub mod render;
pub mod scatter;
#[cfg(feature = "train-detector")]
pub mod train;
mod watch;

pub use calibrate::{BallView, Calibration, calibrate};
pub use error::VisionError;
pub use image::{ColorImage, DepthImage};
pub use intrinsics::{Intrinsics, PixelBox};
pub use paid_track::{Pose, PoseBuffer, PoseGap, StampedPose};
pub use picture_fault::PictureFault;
pub use watch::PictureWatch;
