//! Drawing, without dependencies beyond the PNG and GIF encoders. It knows robots and balls, no task and no policy.
//!
//! - [`Figure`]: shapes, as pixels and as vectors; [`Chart`], [`Bars`], [`HeatMap`], [`Floor`] and [`plot_paths`] make figures of numbers.
//! - [`Canvas`]: pixels; [`Scene`]: spheres, capsules and a ground in perspective; [`frame`], [`film_strip`]: a robot, its ball and its goal.
//! - [`Animation`]: GIF, animated PNG or a folder of frames.
//! - [`html`]: a page that needs no network; [`Table`]: text with aligned columns.
//!
//! Begin reading with `figure.rs`.

mod animation;
mod bars;
mod canvas;
mod chart;
mod error;
mod figure;
mod floor;
mod font;
mod heatmap;
pub mod html;
mod paths;
mod robot;
mod scene;
mod table;

pub use animation::{Animation, Kind};
pub use bars::Bars;
pub use canvas::{Canvas, Rgb};
pub use chart::{Chart, SIZE, Series};
pub use error::PlotError;
pub use figure::{Anchor, Figure, escape};
pub use floor::Floor;
pub use heatmap::{HeatMap, color_of};
pub use paths::{Path, plot_paths};
pub use robot::{
    Bodies, FORCE_SCALE_M_PER_N, Film, Pose, Shown, draw_robot, draw_shown, episode_frame, film_frame,
    film_strip, frame,
};
pub use scene::{Camera, Scene};
pub use table::{Table, number};
