//! Lamps, shadows on the floor, and how light a surface is.

use super::solid::{Form, Solid};
use super::vector::{V3, add, dot, scale, smooth, sub, unit};

/// The light of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Where the lamp or the sun is: a unit vector that points to it, world.
    pub toward: V3,
    /// Light of the lamp, linear.
    pub lamp: V3,
    /// Light from all around, linear.
    pub ambient: V3,
    /// Half width of the shadow's edge per meter of height: small for the sun, large for a lamp behind a screen.
    pub softness: f32,
}

const CELLS: usize = 160;

/// How much of lamp and sky reach the floor, in cells of a square.
pub(super) struct ShadowMap {
    origin: [f32; 2],
    /// Cells per meter.
    per_m: f32,
    lamp: Vec<f32>,
    sky: Vec<f32>,
}

impl ShadowMap {
    /// A map of a square of `side` `[m]` about `middle`, without shadows.
    pub(super) fn new(middle: [f32; 2], side: f32) -> Self {
        let origin = [middle[0] - 0.5 * side, middle[1] - 0.5 * side];
        let open = vec![1.0; CELLS * CELLS];
        Self { origin, per_m: CELLS as f32 / side, lamp: open.clone(), sky: open }
    }

    /// Cells between two places, cut to the map.
    fn cells(&self, low: [f32; 2], high: [f32; 2]) -> [std::ops::Range<usize>; 2] {
        [0, 1].map(|k| {
            let at = |v: f32| ((v - self.origin[k]) * self.per_m).clamp(0.0, CELLS as f32) as usize;
            at(low[k])..(at(high[k]) + 1).min(CELLS)
        })
    }

    fn place(&self, x: usize, y: usize) -> [f32; 2] {
        [self.origin[0] + (x as f32 + 0.5) / self.per_m, self.origin[1] + (y as f32 + 0.5) / self.per_m]
    }

    /// Adds the shadow of a thing.
    pub(super) fn cast(&mut self, solid: &Solid, light: &Light) {
        let (a, b, radius) = match solid.form {
            Form::Sphere { center, radius } => (center, center, radius),
            Form::Capsule { ends: [a, b], radius } => (a, b, radius),
            Form::Box { center, half_size, axes } => {
                // As a capsule along its longest axis.
                let k = (0..3).fold(0, |best, k| if half_size[k] > half_size[best] { k } else { best });
                let across = half_size.iter().sum::<f32>() - half_size[k];
                let radius = 0.5 * across;
                let half = scale(axes[k], (half_size[k] - radius).max(0.0));
                (sub(center, half), add(center, half), radius)
            }
        };
        let slope = 1.0 / light.toward[2].max(0.15);
        let foot = |p: V3| {
            let t = p[2] * slope;
            [p[0] - light.toward[0] * t, p[1] - light.toward[1] * t]
        };
        let soft = 0.01 + light.softness * 0.5 * (a[2] + b[2]).max(0.0);
        let reach = radius * slope + soft;
        let (fa, fb) = (foot(a), foot(b));
        let low = [0, 1].map(|k| fa[k].min(fb[k]) - reach);
        let high = [0, 1].map(|k| fa[k].max(fb[k]) + reach);
        let [xs, ys] = self.cells(low, high);
        // Distance of the lamp's ray through a place of the floor from the segment.
        let ab = sub(b, a);
        let across = |v: V3| sub(v, scale(light.toward, dot(v, light.toward)));
        let ab_across = across(ab);
        let ab2 = dot(ab_across, ab_across);
        for y in ys.clone() {
            for x in xs.clone() {
                let [px, py] = self.place(x, y);
                let ap = across(sub([px, py, 0.0], a));
                let along = if ab2 > 1e-9 { (dot(ap, ab_across) / ab2).clamp(0.0, 1.0) } else { 0.0 };
                let d = sub(ap, scale(ab_across, along));
                let dark = 1.0 - smooth(radius - soft, radius + soft, dot(d, d).sqrt());
                let cell = &mut self.lamp[y * CELLS + x];
                *cell = cell.min(1.0 - dark);
            }
        }
        // Sky: a sphere of radius r whose center is at height h and distance l hides r^2 h / l^3 of it.
        let near = 4.0 * radius;
        let [xs, ys] =
            self.cells([0, 1].map(|k| a[k].min(b[k]) - near), [0, 1].map(|k| a[k].max(b[k]) + near));
        let ab2 = dot(ab, ab);
        for y in ys {
            for x in xs.clone() {
                let [px, py] = self.place(x, y);
                let ap = sub([px, py, 0.0], a);
                let along = if ab2 > 1e-9 { (dot(ap, ab) / ab2).clamp(0.0, 1.0) } else { 0.0 };
                let d = sub(ap, scale(ab, along));
                let l2 = dot(d, d).max(radius * radius);
                let hidden = radius * radius * (-d[2]).max(0.0) / (l2 * l2.sqrt());
                self.sky[y * CELLS + x] *= 1.0 - hidden.min(0.9);
            }
        }
    }

    /// Shares of lamp and sky at a place of the floor.
    #[inline(always)]
    pub(super) fn at(&self, place: [f32; 2]) -> (f32, f32) {
        let x = (place[0] - self.origin[0]) * self.per_m - 0.5;
        let y = (place[1] - self.origin[1]) * self.per_m - 0.5;
        let last = (CELLS - 1) as f32;
        if !(x >= 0.0 && y >= 0.0 && x < last && y < last) {
            return (1.0, 1.0);
        }
        let (x0, y0) = (x as usize, y as usize);
        let (fx, fy) = (x - x0 as f32, y - y0 as f32);
        let i = y0 * CELLS + x0;
        let read = |cells: &[f32]| {
            let (top, low) = (
                cells[i] + fx * (cells[i + 1] - cells[i]),
                cells[i + CELLS] + fx * (cells[i + CELLS + 1] - cells[i + CELLS]),
            );
            top + fy * (low - top)
        };
        (read(&self.lamp), read(&self.sky))
    }
}

impl Light {
    /// Light that a surface sends back: its color, normal, the direction to the eye, and the shares of lamp and sky that reach it.
    #[inline(always)]
    pub(super) fn shade(&self, color: V3, normal: V3, to_eye: V3, gloss: f32, lamp: f32, sky: f32) -> V3 {
        let facing = dot(normal, self.toward).max(0.0) * lamp;
        // What looks down sees the floor instead of the sky: about half as bright.
        let open = sky * (0.75 + 0.25 * normal[2]);
        let mut out = [0, 1, 2].map(|k| color[k] * (self.ambient[k] * open + self.lamp[k] * facing));
        if gloss > 0.0 && facing > 0.0 {
            let half = unit(add(self.toward, to_eye));
            let shine = dot(half, normal).max(0.0);
            let shine2 = shine * shine;
            let shine4 = shine2 * shine2;
            let shine16 = shine4 * shine4 * shine4 * shine4;
            let highlight = gloss * 0.5 * shine16 * shine16 * lamp;
            for k in 0..3 {
                out[k] += highlight * self.lamp[k];
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::super::paint::Paint;
    use super::*;

    #[test]
    fn a_balls_shadow_lies_on_the_far_side_of_the_lamp() {
        let paint = Paint::Plain { color: [1.0; 3], gloss: 0.0 };
        let ball =
            Solid { form: Form::Sphere { center: [0.0, 0.0, 1.0], radius: 0.2 }, paint, velocity: [0.0; 3] };
        let light =
            Light { toward: unit([1.0, 0.0, 1.0]), lamp: [1.0; 3], ambient: [0.3; 3], softness: 0.02 };
        let mut map = ShadowMap::new([0.0, 0.0], 4.0);
        map.cast(&ball, &light);
        // 45 degrees: one meter of height is one meter of way.
        assert!(map.at([-1.0, 0.0]).0 < 0.05 && map.at([1.0, 0.0]).0 > 0.95 && map.at([-1.0, 0.5]).0 > 0.95);
        // Below the ball the sky is hidden a little: 0.2^2 of it.
        let sky = map.at([0.0, 0.0]).1;
        assert!((sky - 0.96).abs() < 0.01, "{sky}");
        assert_eq!(map.at([100.0, 0.0]), (1.0, 1.0));
    }
}
