//! What an observation term declares.

use core::fmt;

use paid_lanes::Real;

use super::Sink;
use crate::{Dimensions, Views};

/// A term of an observation: a few numbers that are computed from the views, one environment per lane.
pub trait Observation {
    /// What it is, in one sentence.
    const SUMMARY: &'static str;
    /// SI unit; empty for pure numbers.
    const UNIT: &'static str;
    /// Frame in which it is expressed; `joint` for joint coordinates.
    const FRAME: &'static str;
    /// How many numbers, and what they run over.
    const SHAPE: Shape;
    /// What it needs in addition to the robot's sensors.
    const NEEDS: &'static [Need] = &[];
    /// True for vectors that turn the other way in a mirror, as angular velocities do, and for a scalar that changes its sign.
    const AXIAL: bool = false;
    /// True for a sensor's reading, which comes late where a preset has a delay of observations.
    const SENSED: bool = false;
    /// Noise of the policy's copy, unless a preset says otherwise.
    const NOISE: Noise = Noise::NONE;

    /// Writes its numbers.
    ///
    /// # Panics
    /// If the views lack what it needs.
    fn write<V: Real>(views: &Views<'_, V>, out: &mut impl Sink<V>);
}

/// What a term needs in addition to the robot's sensors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Need {
    /// State that only a simulator knows.
    Privileged,
    /// A reference motion.
    Reference,
    /// Ball and goal.
    Scene,
}

impl fmt::Display for Need {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Privileged => "the simulator's state",
            Self::Reference => "a reference motion",
            Self::Scene => "ball and goal",
        })
    }
}

/// How many numbers a term has, and their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// One per joint, in the policy's joint order.
    Joints,
    /// One number.
    Scalar,
    /// x, y, z.
    Vector,
    /// The first two columns of a rotation, row by row.
    Rotation,
    /// x, y, z per tracked body.
    BodyVectors,
    /// The first two columns of a rotation, row by row, per tracked body.
    BodyRotations,
}

impl Shape {
    /// Number of values.
    pub fn size(self, dimensions: Dimensions) -> usize {
        match self {
            Self::Joints => dimensions.joints,
            Self::Scalar => 1,
            Self::Vector => 3,
            Self::Rotation => 6,
            Self::BodyVectors => 3 * dimensions.bodies,
            Self::BodyRotations => 6 * dimensions.bodies,
        }
    }

    /// What the values run over, as a policy file states it.
    pub fn order(self) -> &'static str {
        match self {
            Self::Joints => "joints",
            Self::Scalar => "one number",
            Self::Vector => "x,y,z",
            Self::Rotation => "first two columns of the rotation, row by row",
            Self::BodyVectors => "tracked bodies; x,y,z",
            Self::BodyRotations => "tracked bodies; first two columns of the rotation, row by row",
        }
    }
}

/// Uniform noise on each number of a term.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Half-width, in the term's unit.
    pub half_width: f64,
    /// Why it is as large.
    pub reason: &'static str,
}

impl Noise {
    /// No noise.
    pub const NONE: Self = Self { half_width: 0.0, reason: "" };

    /// Noise with its reason.
    pub const fn uniform(half_width: f64, reason: &'static str) -> Self {
        Self { half_width, reason }
    }
}

/// A term as a row of a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObservationInfo {
    /// Name in presets and policy files.
    pub name: &'static str,
    /// What it is.
    pub summary: &'static str,
    /// SI unit; empty for pure numbers.
    pub unit: &'static str,
    /// Frame in which it is expressed.
    pub frame: &'static str,
    /// How many numbers, and what they run over.
    pub shape: Shape,
    /// What it needs in addition to the robot's sensors.
    pub needs: &'static [Need],
    /// True for vectors that turn the other way in a mirror.
    pub axial: bool,
    /// True for a sensor's reading.
    pub sensed: bool,
    /// Noise of the policy's copy, unless a preset says otherwise.
    pub noise: Noise,
}

impl ObservationInfo {
    pub(super) fn of<T: Observation>(name: &'static str) -> Self {
        Self {
            name,
            summary: T::SUMMARY,
            unit: T::UNIT,
            frame: T::FRAME,
            shape: T::SHAPE,
            needs: T::NEEDS,
            axial: T::AXIAL,
            sensed: T::SENSED,
            noise: T::NOISE,
        }
    }
}
