//! Pictures without dependencies beyond the PNG and GIF encoders: heat maps, path plots, the robot itself, and animations.

mod animation;
mod bars;
mod canvas;
mod chart;
mod figure;
mod floor;
mod font;
mod heatmap;
pub mod identification;
mod paths;
mod robot;
mod scene;

pub use animation::{Animation, Kind};
pub use bars::Bars;
pub use canvas::{Canvas, Rgb};
pub use chart::{Chart, Series};
pub use figure::{Anchor, Figure, escape};
pub use floor::Floor;
pub use heatmap::{HeatMap, color_of};
pub use paths::{Path, plot_paths};
pub use robot::{
    Bodies, FORCE_SCALE_M_PER_N, Film, Pose, Shown, draw_robot, draw_shown, episode_frame, film_frame,
    film_strip, frame,
};
pub use scene::{Camera, Scene};
