//! A renderer for simulated eyes: color and depth of balls, robots, floor and clutter from a camera's pose.
//!
//! Rays meet spheres, capsules, boxes and a floor analytically. The image is cut into tiles, and every tile knows the few things that it
//! may show. One ray goes through the middle of every pixel; where neighbors show different things, or something moves, several rays do,
//! each at its own moment of the exposure.

mod depth;
mod ground;
mod light;
mod noise;
mod paint;
mod scene;
mod sensor;
mod solid;
mod trace;
mod vector;

pub use depth::DepthSensor;
pub use ground::{Ground, GroundKind, Mark};
pub use light::Light;
pub use paint::{BallPaint, BallPattern, Paint};
pub use scene::{Scene, View};
pub use sensor::ColorSensor;
pub use solid::{Form, Solid};
pub use vector::V3;

use crate::{ColorImage, DepthImage, PixelBox};
use trace::{BACKGROUND, TILE, Tracer};

/// What a camera sees of a scene, before its sensors spoil it.
#[derive(Clone, Debug)]
pub struct Rendered {
    view: View,
    /// Linear light of every pixel.
    light: Vec<V3>,
    /// True depth along the optical axis `[m]`; infinity above the horizon.
    depth: Vec<f32>,
    /// Whether the middle of a pixel shows the ball.
    ball: Vec<bool>,
}

/// Places of the four rays of a pixel that needs more than one: a turned grid, so that upright and level edges gain most.
const SAMPLES: [[f32; 2]; 4] = [[0.125, 0.625], [0.375, 0.125], [0.625, 0.875], [0.875, 0.375]];
/// Moments of the same rays in the exposure.
const MOMENTS: [f32; 4] = [-0.375, 0.125, -0.125, 0.375];

/// Renders a scene.
pub fn render(scene: &Scene, view: &View) -> Rendered {
    let (width, height) = (view.intrinsics.width, view.intrinsics.height);
    let tracer = Tracer::new(scene, view);
    let exposure = view.exposure_s as f32;
    let is_ball: Vec<bool> = scene.solids.iter().map(|solid| solid.paint.is_ball()).collect();
    let shows_ball = |what: u16| is_ball.get(usize::from(what)).is_some_and(|ball| *ball);
    let pixels = width * height;
    let mut rendered = Rendered {
        view: *view,
        light: vec![[0.0; 3]; pixels],
        depth: vec![f32::INFINITY; pixels],
        ball: vec![false; pixels],
    };
    let mut what = vec![BACKGROUND; pixels];
    for y in 0..height {
        for x in 0..width {
            let ray = tracer.ray([x as f32 + 0.5, y as f32 + 0.5]);
            let hit = tracer.hit(ray, (y / TILE) * tracer.columns() + x / TILE, 0.0);
            let i = y * width + x;
            rendered.depth[i] = hit.depth;
            rendered.ball[i] = shows_ball(hit.what);
            what[i] = hit.what;
        }
    }
    // A small ball's pattern is finer than pixels.
    let ball_pixels = rendered.ball.iter().filter(|ball| **ball).count();
    let fine_ball = ball_pixels < 2500;
    for y in 0..height {
        for x in 0..width {
            let i = y * width + x;
            let tile = (y / TILE) * tracer.columns() + x / TILE;
            let other = |j: usize| what[j] != what[i];
            let edge = (x > 0 && other(i - 1))
                || (x + 1 < width && other(i + 1))
                || (y > 0 && other(i - width))
                || (y + 1 < height && other(i + width))
                || (fine_ball && rendered.ball[i]);
            let moving = exposure > 0.0 && tracer.moves(tile);
            if !edge && !moving {
                let ray = tracer.ray([x as f32 + 0.5, y as f32 + 0.5]);
                let hit = trace::Hit { depth: rendered.depth[i], what: what[i] };
                rendered.light[i] = tracer.light(ray, hit, 0.0, exposure);
                continue;
            }
            let mut sum = [0.0; 3];
            let rounds = if moving { 2 } else { 1 };
            for round in 0..rounds {
                for (place, moment) in SAMPLES.iter().zip(MOMENTS) {
                    let time = if moving { moment + 0.125 * (round as f32 - 0.5) } else { 0.0 };
                    let [u, v] = if round == 0 { *place } else { [place[1], place[0]] };
                    let ray = tracer.ray([x as f32 + u, y as f32 + v]);
                    let hit = tracer.hit(ray, tile, time);
                    sum = vector::add(sum, tracer.light(ray, hit, time, exposure));
                }
            }
            rendered.light[i] = vector::scale(sum, 0.25 / rounds as f32);
        }
    }
    rendered
}

impl Rendered {
    /// The color image.
    pub fn color(&self, sensor: &ColorSensor) -> ColorImage {
        sensor.develop(&mut self.light.clone(), self.view.intrinsics.width, self.view.intrinsics.height)
    }

    /// The depth image, aligned to the color image.
    pub fn depth(&self, sensor: &DepthSensor) -> DepthImage {
        sensor.develop(&self.depth, &self.view.intrinsics)
    }

    /// Number of pixels whose middle shows the ball.
    pub fn ball_pixels(&self) -> usize {
        self.ball.iter().filter(|ball| **ball).count()
    }

    /// The box around the pixels that show the ball, and their number; `None` if none does.
    pub fn ball_box(&self) -> Option<(PixelBox, usize)> {
        let width = self.view.intrinsics.width;
        let mut found: Option<(PixelBox, usize)> = None;
        for i in self.ball.iter().enumerate().filter_map(|(i, ball)| ball.then_some(i)) {
            let at = [(i % width) as f64, (i / width) as f64];
            let (part, count) = found.get_or_insert((PixelBox { min: at, max: at.map(|v| v + 1.0) }, 0));
            for k in 0..2 {
                part.min[k] = part.min[k].min(at[k]);
                part.max[k] = part.max[k].max(at[k] + 1.0);
            }
            *count += 1;
        }
        found
    }

    /// Whether the middle of a pixel shows the ball, row by row from the top.
    pub fn ball_mask(&self) -> &[bool] {
        &self.ball
    }
}
