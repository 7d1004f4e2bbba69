//! What the engine needs in addition to the robot's model.

use paid_robot::{RobotModel, RobotSpec, SpecError};

/// Feet and controller gains, in the order of the model.
#[derive(Clone, Debug, PartialEq)]
pub struct EngineSpec {
    /// Body indices of the feet, left before right. The foot solver needs exactly two.
    pub feet: Vec<usize>,
    /// Stiffness of each joint's controller `[N m/rad]`.
    pub stiffness: Vec<f64>,
    /// Damping of each joint's controller `[N m s/rad]`.
    pub damping: Vec<f64>,
}

impl EngineSpec {
    /// Feet and gains that the robot's TOML states.
    ///
    /// # Errors
    /// If `spec` does not fit `model`.
    pub fn for_robot(model: &RobotModel, spec: &RobotSpec) -> Result<Self, SpecError> {
        let control = spec.resolve(model)?;
        let feet = spec.indices(model)?.feet.to_vec();
        Ok(Self { feet, stiffness: control.stiffness, damping: control.damping })
    }
}
