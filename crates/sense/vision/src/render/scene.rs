//! What there is to see, and from where.

use super::ground::Ground;
use super::light::Light;
use super::solid::{Form, Solid};
use super::vector::V3;
use crate::{Intrinsics, Pose};

/// A scene: floor, things on it, light, and what is behind them.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// The floor at height 0.
    pub ground: Ground,
    /// Everything on it.
    pub solids: Vec<Solid>,
    /// Lamp and sky.
    pub light: Light,
    /// Colors of what is above the horizon, low and high, linear.
    pub background: [V3; 2],
}

/// A camera at the middle of its exposure.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// Its pixels.
    pub intrinsics: Intrinsics,
    /// World from the camera's optical frame.
    pub pose: Pose,
    /// How long it gathers light `[s]`: moving things are smeared over their way in this time.
    pub exposure_s: f64,
}

impl Scene {
    /// Center `[m]` and radius `[m]` of the ball, if there is one.
    pub fn ball(&self) -> Option<([f64; 3], f64)> {
        self.solids.iter().find(|solid| solid.paint.is_ball()).and_then(|solid| match solid.form {
            Form::Sphere { center, radius } => Some((center.map(f64::from), f64::from(radius))),
            Form::Capsule { .. } | Form::Box { .. } => None,
        })
    }
}
