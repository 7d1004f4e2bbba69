//! Adversarial motion priors (AMP; Peng et al. 2021, arXiv 2104.02180): no motion is followed, but a discriminator learns to distinguish
//! two consecutive frames of the policy from two of the clips, and the policy is rewarded for frames that it takes for a clip's.
//!
//! [`StyleReward`] is a [`paid_learn::LearnedReward`]; the environments show what the discriminator sees as the observation group
//! [`GROUP`], and [`Clips`] holds the same features of the clips.
//!
//! ```
//! use std::sync::Arc;
//!
//! use paid_amp::{AmpConfig, Clips, StyleReward};
//! use paid_learn::LearnedReward;
//!
//! // Two clips of one feature: it rises by 0.1 a frame.
//! let clips: Vec<Vec<f32>> = (0..2).map(|k| (0..50).map(|t| k as f32 + 0.1 * t as f32).collect()).collect();
//! let clips = Arc::new(Clips::new(1, &clips).expect("frames of one feature"));
//! let style = StyleReward::new(clips, &AmpConfig::default(), 1).expect("the configuration is in range");
//! assert_eq!(style.name(), "style");
//! ```

mod clips;
mod config;
mod error;
mod horizon;
mod network;
mod objective;
mod replay;
mod style;

pub use clips::Clips;
pub use config::{AmpConfig, Formulation};
pub use error::AmpError;
pub use network::{Perceptron, Tape};
pub use objective::{Batch, Sums, Workspace, evaluate};
pub use replay::Replay;
pub use style::StyleReward;

/// Name of the observation group that the discriminator sees.
pub use paid_policy::env::STYLE_GROUP as GROUP;
