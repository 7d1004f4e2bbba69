//! From a box and a depth image to the ball's place.

mod depths;
mod find;
mod sphere;

pub use find::{BallFinder, LocatedBall, NoSighting};
pub use sphere::{Fix, Floor, Source, locate};

#[cfg(test)]
mod tests;

#[cfg(test)]
mod shape_tests;
