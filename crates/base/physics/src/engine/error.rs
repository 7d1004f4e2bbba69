//! What can be wrong with a robot or scene for this engine.

use thiserror::Error;

/// A robot or scene that the engine cannot simulate.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum PhysicsError {
    /// A list has another length than the model has joints.
    #[error("{what}: expected {expected} values (one per joint), found {found}")]
    Length {
        /// Which list.
        what: &'static str,
        /// Number of joints.
        expected: usize,
        /// Its length.
        found: usize,
    },
    /// The tree is not in depth-first order with joint `j` moving body `j + 1`.
    #[error(
        "body '{0}' is out of model order: expected depth-first, parent before child, joint j moving body j + 1"
    )]
    Order(String),
    /// The foot solver is made for two feet.
    #[error("feet: expected 2 (a biped), found {0}")]
    Feet(usize),
    /// A foot must end an unbranched chain that starts at the base.
    #[error("foot '{0}': expected the last body of an unbranched chain from the base (a biped)")]
    Foot(String),
    /// Feet need sole points, equally many.
    #[error("soles: expected the same number (at least 1) of `sole` spheres on both feet, found {0} and {1}")]
    Soles(usize, usize),
    /// A contact shape that the engine does not know.
    #[error("geom '{geom}' of body '{body}': {problem}")]
    Geom {
        /// Name of the body.
        body: String,
        /// Name of the shape.
        geom: String,
        /// What is wrong.
        problem: &'static str,
    },
    /// A number of the scene or robot is out of range.
    #[error("{what}: expected {expected}, found {found}")]
    Value {
        /// Which number.
        what: String,
        /// Its range.
        expected: &'static str,
        /// What it is.
        found: String,
    },
}
