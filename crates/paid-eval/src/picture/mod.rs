//! Pictures without dependencies beyond the PNG encoder: heat maps, path plots, and the robot itself.

mod bars;
mod canvas;
mod figure;
mod font;
mod heatmap;
mod paths;
mod robot;
mod scene;

pub use bars::Bars;
pub use canvas::{Canvas, Rgb};
pub use figure::{Anchor, Figure, escape};
pub use heatmap::{HeatMap, color_of};
pub use paths::{Path, plot_paths};
pub use robot::{Film, Pose, film_strip, frame};
pub use scene::{Camera, Scene};
