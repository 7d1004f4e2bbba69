//! Random numbers with names.

use paid_lanes::rng::Rng;

use crate::render::V3;

/// Draws for a scene.
pub(super) struct Draw(pub Rng);

impl Draw {
    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0.uniform(low, high)
    }

    pub(super) fn between_f32(&mut self, low: f32, high: f32) -> f32 {
        self.0.uniform(f64::from(low), f64::from(high)) as f32
    }

    pub(super) fn normal(&mut self, deviation: f64) -> f64 {
        self.0.normal() * deviation
    }

    pub(super) fn chance(&mut self, share: f64) -> bool {
        self.0.unit() < share
    }

    pub(super) fn one_of<T: Copy>(&mut self, items: &[T]) -> T {
        items[self.0.below(items.len())]
    }

    /// A direction in the plane: cosine and sine.
    pub(super) fn heading(&mut self) -> [f32; 2] {
        let angle = self.between(0.0, std::f64::consts::TAU);
        [angle.cos() as f32, angle.sin() as f32]
    }

    /// A linear color: hue around the circle, saturation and brightness within the given ranges.
    pub(super) fn color(&mut self, saturation: [f32; 2], brightness: [f32; 2]) -> V3 {
        let hue = self.between_f32(0.0, 6.0);
        let saturation = self.between_f32(saturation[0], saturation[1]);
        let value = self.between_f32(brightness[0], brightness[1]);
        [5.0, 3.0, 1.0].map(|offset| {
            let k = (offset + hue) % 6.0;
            let wave = k.min(4.0 - k).clamp(0.0, 1.0);
            value * (1.0 - saturation * wave)
        })
    }

    /// A color near another one, each part scaled by up to `share`.
    pub(super) fn near(&mut self, color: V3, share: f32) -> V3 {
        color.map(|v| (v * self.between_f32(1.0 - share, 1.0 + share)).clamp(0.0, 1.0))
    }

    /// A rotation, uniform over all: rows.
    pub(super) fn rotation(&mut self) -> [V3; 3] {
        let quat = [0; 4].map(|_| self.0.normal());
        let matrix = paid_lanes::Quat(quat).normalize().to_mat();
        matrix.0.map(|row| row.map(|v| v as f32))
    }
}
