//! Windows of rendered images, and what the network should output for them.

use burn::tensor::{Device, Tensor, TensorData};
use paid_lanes::rng::Rng;

use crate::net::{CHANNELS, INPUTS, STRIDE, WIDTH, depth_code};
use crate::render::{DepthSensor, Form, Rendered, render};
use crate::scatter::{Sample, Scatter};
use crate::{ColorImage, DepthImage, Intrinsics, PixelBox};

/// Pixels of a window, across and down: a quarter of the network's input.
pub(super) const WINDOW: [usize; 2] = [160, 96];
/// Cells of a window.
const CELLS: [usize; 2] = [WINDOW[0] / STRIDE, WINDOW[1] / STRIDE];

/// Examples side by side.
pub(super) struct Tensors {
    /// `[n, 4, h, w]`, RGB, 0 to 1, and depth as [`depth_code`].
    pub images: Tensor<4>,
    /// `[n, 1, h / 8, w / 8]`: 1 at a ball's middle, falling around it.
    pub heat: Tensor<4>,
    /// As `heat`: 0 where the answer does not count.
    pub care: Tensor<4>,
    /// `[n, 4, h / 8, w / 8]`: offset right and down, logarithms of width and height, all in cells.
    pub place: Tensor<4>,
    /// As `heat`: 1 where `place` is wanted.
    pub near: Tensor<4>,
}

/// Examples as plain numbers.
#[derive(Default)]
pub(super) struct Batch {
    images: Vec<f32>,
    heat: Vec<f32>,
    care: Vec<f32>,
    place: Vec<f32>,
    near: Vec<f32>,
    count: usize,
}

impl Batch {
    /// The examples with these numbers.
    pub(super) fn draw(scatter: &Scatter, numbers: std::ops::Range<u32>) -> Self {
        let mut batch = Self::default();
        for number in numbers {
            batch.push(scatter, number);
        }
        batch
    }

    pub(super) fn tensors(self, device: &Device) -> Tensors {
        let (n, [w, h]) = (self.count, CELLS);
        let map = |values: Vec<f32>, channels: usize| {
            Tensor::<4>::from_data(TensorData::new(values, [n, channels, h, w]), device)
        };
        let images = TensorData::new(self.images, [n, INPUTS, WINDOW[1], WINDOW[0]]);
        Tensors {
            images: Tensor::from_data(images, device),
            heat: map(self.heat, 1),
            care: map(self.care, 1),
            place: map(self.place, CHANNELS - 1),
            near: map(self.near, 1),
        }
    }

    /// Renders a window and adds it.
    fn push(&mut self, scatter: &Scatter, number: u32) {
        let mut rng = Rng::new(u64::from(number), 0x7769_6e64, 3);
        // The camera's image at the network's scale, and somewhat nearer or farther.
        let scale = rng.uniform(-0.25, 0.25).exp();
        let width = (WIDTH as f64 * scale).round();
        let whole = Intrinsics::g1_color().resized(width as usize, (width * 240.0 / 424.0).round() as usize);
        let with_ball = rng.unit() < 0.65;
        let mut sample = scatter.sample(number, whole, with_ball);
        let [w, h] = WINDOW.map(|v| v as f64);
        let outline = sample.ball.and_then(|ball| ball.outline);
        let around = |at: [f64; 2], rng: &mut Rng| [at[0] - rng.uniform(0.0, w), at[1] - rng.uniform(0.0, h)];
        let corner = match outline {
            Some(outline) if rng.unit() < 0.85 => around(outline.middle(), &mut rng),
            _ => match thing(&sample, &whole, &mut rng) {
                // What is no ball, but might be taken for one.
                Some(at) if rng.unit() < 0.6 => around(at, &mut rng),
                _ => [
                    rng.uniform(0.0, (whole.width as f64 - w).max(1.0)),
                    rng.uniform(0.0, (whole.height as f64 - h).max(1.0)),
                ],
            },
        }
        .map(f64::round);
        sample.view.intrinsics = whole.window(corner[0], corner[1], WINDOW[0], WINDOW[1]);
        let rendered = render(&sample.scene, &sample.view);
        let mut image = rendered.color(&sample.color);
        let mut depth = depth(&rendered, &sample.depth, scale, &mut rng);
        if rng.unit() < 0.15 {
            bar(&mut image, &mut depth, &mut rng);
        }
        self.images
            .extend((0..3).flat_map(|k| image.data.iter().skip(k).step_by(3).map(|&v| f32::from(v) / 255.0)));
        self.images.extend(depth.data.iter().map(|&mm| depth_code(mm, whole.focal[0])));
        let outline = outline.map(|b| PixelBox {
            min: [b.min[0] - corner[0], b.min[1] - corner[1]],
            max: [b.max[0] - corner[0], b.max[1] - corner[1]],
        });
        self.answer(&sample, outline, rendered.ball_pixels());
        self.count += 1;
    }

    /// Adds what the network should output.
    fn answer(&mut self, sample: &Sample, outline: Option<PixelBox>, shown: usize) {
        let cells = CELLS[0] * CELLS[1];
        let (mut heat, mut care, mut near) =
            (vec![0.0_f32; cells], vec![1.0_f32; cells], vec![0.0_f32; cells]);
        let mut place = vec![0.0_f32; (CHANNELS - 1) * cells];
        if let (Some(outline), true) = (outline, sample.ball.is_some()) {
            let size = outline.size();
            let whole = std::f64::consts::FRAC_PI_4 * size[0] * size[1];
            let share = shown as f64 / whole.max(1.0);
            let middle = outline.middle();
            let inside = middle[0] >= 0.0
                && middle[1] >= 0.0
                && middle[0] < WINDOW[0] as f64
                && middle[1] < WINDOW[1] as f64;
            // Less than a quarter in view: finding it is neither required nor wrong.
            let wanted = inside && share > 0.25;
            let sigma = (0.12 * (size[0] + size[1]) * 0.5 / STRIDE as f64).max(0.5);
            for y in 0..CELLS[1] {
                for x in 0..CELLS[0] {
                    let i = y * CELLS[0] + x;
                    let d = [
                        middle[0] / STRIDE as f64 - (x as f64 + 0.5),
                        middle[1] / STRIDE as f64 - (y as f64 + 0.5),
                    ];
                    let hot = (-0.5 * (d[0] * d[0] + d[1] * d[1]) / (sigma * sigma)).exp();
                    if !wanted {
                        if shown > 0
                            && d[0].abs() * 16.0 < size[0] + 16.0
                            && d[1].abs() * 16.0 < size[1] + 16.0
                        {
                            care[i] = 0.0;
                        }
                        continue;
                    }
                    heat[i] = hot.min(0.95) as f32;
                    if d[0].abs() <= 0.5 && d[1].abs() <= 0.5 {
                        heat[i] = 1.0;
                    }
                    if d[0].abs() <= 1.0 && d[1].abs() <= 1.0 {
                        near[i] = 1.0;
                        let numbers =
                            [d[0], d[1], (size[0] / STRIDE as f64).ln(), (size[1] / STRIDE as f64).ln()];
                        for (k, v) in numbers.into_iter().enumerate() {
                            place[k * cells + i] = v as f32;
                        }
                    }
                }
            }
        }
        self.heat.extend(heat);
        self.care.extend(care);
        self.near.extend(near);
        self.place.extend(place);
    }
}

/// Where one of the scene's things is in the image, if the one that was drawn is in it.
fn thing(sample: &Sample, whole: &Intrinsics, rng: &mut Rng) -> Option<[f64; 2]> {
    let solids = &sample.scene.solids;
    let center = match solids.get(rng.below(solids.len().max(1)))?.form {
        Form::Sphere { center, .. } | Form::Box { center, .. } => center,
        Form::Capsule { ends: [a, b], .. } => {
            let share = rng.unit() as f32;
            [0, 1, 2].map(|k| a[k] + share * (b[k] - a[k]))
        }
    };
    let at = whole.project(sample.view.pose.inverse_point(center.map(f64::from)))?;
    ((0.0..whole.width as f64).contains(&at[0]) && (0.0..whole.height as f64).contains(&at[1])).then_some(at)
}

/// The depth image of a window whose pixels are `scale` times as fine as the network's. One window in eight has none, and one in ten
/// none of the ball: the camera matches nothing on dark or shining leather.
fn depth(rendered: &Rendered, sensor: &DepthSensor, scale: f64, rng: &mut Rng) -> DepthImage {
    // The camera matches patches of 4 pixels of 424.
    let patch_px = sensor.patch_px * (WIDTH as f64 / 424.0 * scale) as f32;
    let holes = if rng.unit() < 0.1 { rng.uniform(0.05, 0.4) as f32 } else { sensor.holes };
    let mut depth = rendered.depth(&DepthSensor { patch_px, holes, ..*sensor });
    let (none, without_ball) = (rng.unit() < 0.125, rng.unit() < 0.1);
    if none {
        depth.data.fill(0);
    } else if without_ball {
        for (mm, ball) in depth.data.iter_mut().zip(rendered.ball_mask()) {
            if *ball {
                *mm = 0;
            }
        }
    }
    depth
}

/// A gray bar without depth along a side, as around an image of another shape.
fn bar(image: &mut ColorImage, depth: &mut DepthImage, rng: &mut Rng) {
    let (w, h) = (image.width as i64, image.height as i64);
    let side = rng.below(4);
    let width = rng.uniform(2.0, 12.0) as i64;
    let [xs, ys] = match side {
        0 => [0..width, 0..h],
        1 => [w - width..w, 0..h],
        2 => [0..w, 0..width],
        _ => [0..w, h - width..h],
    };
    for y in ys {
        for x in xs.clone() {
            image.set(x, y, [114; 3]);
            depth.data[(y * w + x) as usize] = 0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scatter::Use;

    #[test]
    fn the_answer_is_hot_where_the_ball_is() {
        let scatter = Scatter::new(Use::Training, 1).expect("the robot");
        let batch = Batch::draw(&scatter, 0..24);
        let cells = CELLS[0] * CELLS[1];
        assert_eq!(
            (batch.count, batch.images.len(), batch.heat.len()),
            (24, 24 * INPUTS * 160 * 96, 24 * cells)
        );
        assert!(batch.images.iter().all(|v| (0.0..=2.0).contains(v)));
        let balls = batch.heat.chunks(cells).filter(|heat| heat.contains(&1.0)).count();
        assert!((5..=20).contains(&balls), "{balls} balls in 24 windows");
        for (k, heat) in batch.heat.chunks(cells).enumerate() {
            assert!(heat.iter().filter(|v| **v == 1.0).count() <= 1);
            for (i, v) in heat.iter().enumerate().filter(|(_, v)| **v == 1.0) {
                // The middle is in this cell, and a ball of 9 cm or more at 4.5 m is 9 px wide.
                let place = |c: usize| batch.place[(4 * k + c) * cells + i];
                assert!(place(0).abs() <= 0.5 && place(1).abs() <= 0.5 && place(2) > 0.0, "{v} {}", place(2));
                assert_eq!(batch.near[k * cells + i], 1.0);
            }
        }
    }
}
