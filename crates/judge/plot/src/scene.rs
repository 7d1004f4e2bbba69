//! Spheres, capsules and a ground in perspective, with a depth buffer.

use paid_lanes::Vec3;

use crate::{Canvas, Rgb};

type V3 = Vec3<f64>;

/// A pinhole camera, world axes with z up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Where it is `[m]`.
    pub eye: [f64; 3],
    /// What it looks at `[m]`.
    pub target: [f64; 3],
    /// Vertical field of view `[rad]`.
    pub field: f64,
}

/// An image being drawn.
#[derive(Clone, Debug)]
pub struct Scene {
    image: Canvas,
    depth: Vec<f64>,
    eye: V3,
    /// Right, up and forward of the camera.
    axes: [V3; 3],
    /// Pixels at distance one.
    focal: f64,
}

/// Direction to the light.
const LIGHT: [f64; 3] = [0.35, 0.25, 0.9];
/// Nothing nearer to the camera is drawn `[m]`.
const NEAR: f64 = 0.05;

impl Scene {
    /// Sky and a ground with a line every half meter.
    pub fn new(width: usize, height: usize, camera: Camera) -> Self {
        let eye = Vec3(camera.eye);
        let unit = |v: V3| v.scale(1.0 / v.norm().max(1e-9));
        let forward = unit(Vec3(camera.target) - eye);
        let right = unit(forward.cross(Vec3([0.0, 0.0, 1.0])));
        let mut scene = Self {
            image: Canvas::new(width, height, [0; 3]),
            depth: vec![f64::INFINITY; width * height],
            eye,
            axes: [right, right.cross(forward), forward],
            focal: 0.5 * height as f64 / (0.5 * camera.field).tan(),
        };
        for y in 0..height {
            for x in 0..width {
                let color = scene.backdrop(x, y);
                scene.image.set(x as i64, y as i64, color);
            }
        }
        scene
    }

    fn ray(&self, x: usize, y: usize) -> V3 {
        let [right, up, forward] = self.axes;
        let u = x as f64 + 0.5 - 0.5 * self.image.width() as f64;
        let v = 0.5 * self.image.height() as f64 - y as f64 - 0.5;
        forward + right.scale(u / self.focal) + up.scale(v / self.focal)
    }

    fn backdrop(&self, x: usize, y: usize) -> Rgb {
        let ray = self.ray(x, y);
        let sky = [228.0, 236.0, 246.0];
        if ray.z() > -1e-3 {
            return sky.map(|c| c as u8);
        }
        let distance = -self.eye.z() / ray.z();
        let p = self.eye + ray.scale(distance);
        // The width of a pixel on the ground keeps far lines from flickering into a pattern.
        let soft = 0.008 + 1.5 * distance / self.focal;
        let line = |v: f64, spacing: f64| {
            let from_line = (v / spacing - (v / spacing).round()).abs() * spacing;
            (1.0 - from_line / soft).clamp(0.0, 1.0)
        };
        let half = line(p.x(), 0.5).max(line(p.y(), 0.5)) * 0.10;
        let meter = line(p.x(), 1.0).max(line(p.y(), 1.0)) * 0.18;
        let fade = (-distance / 12.0).exp();
        let shade = 1.0 - half.max(meter) * fade;
        let grass = [176.0, 200.0, 170.0];
        [0, 1, 2].map(|k| ((grass[k] * fade + sky[k] * (1.0 - fade)) * shade) as u8)
    }

    /// Position in the image and distance along the view; `None` behind the camera.
    fn project(&self, p: V3) -> Option<([f64; 2], f64)> {
        let [right, up, forward] = self.axes;
        let d = p - self.eye;
        let depth = d.dot(forward);
        (depth > NEAR).then(|| {
            let (u, v) = (d.dot(right) / depth * self.focal, d.dot(up) / depth * self.focal);
            ([0.5 * self.image.width() as f64 + u, 0.5 * self.image.height() as f64 - v], depth)
        })
    }

    /// A shaded sphere with its soft shadow on the ground.
    pub fn sphere(&mut self, center: [f64; 3], radius: f64, color: Rgb) {
        self.splat(Vec3(center), radius, color);
    }

    fn splat(&mut self, center: V3, radius: f64, color: Rgb) {
        let Some(([cx, cy], depth)) = self.project(center) else { return };
        let pixels = radius * self.focal / depth;
        let range = |c: f64, end: usize| {
            let lo = (c - pixels).floor().max(0.0) as usize;
            let hi = ((c + pixels).ceil() + 1.0).clamp(0.0, end as f64) as usize;
            lo..hi
        };
        let light = Vec3(LIGHT).scale(1.0 / Vec3(LIGHT).norm());
        let [right, up, forward] = self.axes;
        for y in range(cy, self.image.height()) {
            for x in range(cx, self.image.width()) {
                let u = (x as f64 + 0.5 - cx) / pixels;
                let v = (cy - y as f64 - 0.5) / pixels;
                let w2 = 1.0 - u * u - v * v;
                if w2 <= 0.0 {
                    continue;
                }
                let w = w2.sqrt();
                let at = depth - radius * w;
                let index = y * self.image.width() + x;
                if at >= self.depth[index] {
                    continue;
                }
                let normal = right.scale(u) + up.scale(v) - forward.scale(w);
                let shade = 0.45 + 0.55 * normal.dot(light).max(0.0);
                self.depth[index] = at;
                self.image.set(x as i64, y as i64, color.map(|c| (f64::from(c) * shade) as u8));
            }
        }
    }

    /// A shaded capsule: all points within `radius` of the segment.
    pub fn capsule(&mut self, ends: [[f64; 3]; 2], radius: f64, color: Rgb) {
        let (a, along) = (Vec3(ends[0]), Vec3(ends[1]) - Vec3(ends[0]));
        // Spheres so dense that the surface between them is within 1% of the radius.
        let steps = (along.norm() / (0.25 * radius).max(1e-3)).ceil().clamp(1.0, 2000.0);
        for i in 0..=steps as usize {
            self.splat(a + along.scale(i as f64 / steps), radius, color);
        }
    }

    /// An arrow: a thin shaft and a tip, in all as long as `vector`.
    pub fn arrow(&mut self, from: [f64; 3], vector: [f64; 3], radius: f64, color: Rgb) {
        let (a, along) = (Vec3(from), Vec3(vector));
        let length = along.norm();
        if length < 1e-9 {
            return;
        }
        // The tip is four radii long unless the whole arrow is shorter.
        let tip = (4.0 * radius / length).min(1.0);
        let neck = a + along.scale(1.0 - tip);
        if tip < 1.0 {
            self.capsule([from, neck.0], 0.5 * radius, color);
        }
        for i in 0..=12 {
            let share = f64::from(i) / 12.0;
            let thick = (1.5 * radius * (1.0 - share)).max(0.1 * radius);
            self.splat(neck + along.scale(tip * share), thick, color);
        }
    }

    /// An empty layer in front of the same camera: for things that [`Scene::blend`] shows as if through glass.
    pub fn layer(&self) -> Self {
        let mut layer = self.clone();
        layer.depth.fill(f64::INFINITY);
        layer
    }

    /// Mixes in a layer, `share` of it, where it is nearer than what is here by more than `margin` `[m]`. The margin keeps two
    /// bodies in almost the same place from showing through each other in patches. Shadows of the layer are not taken over.
    pub fn blend(&mut self, layer: &Self, share: f64, margin: f64) {
        let width = self.image.width();
        for (i, depth) in layer.depth.iter().enumerate() {
            if !depth.is_finite() || depth + margin >= self.depth[i] {
                continue;
            }
            let (x, y) = (i % width, i / width);
            let (below, above) = (self.image.get(x, y), layer.image.get(x, y));
            let mix = |k: usize| f64::from(below[k]) * (1.0 - share) + f64::from(above[k]) * share;
            self.image.set(x as i64, y as i64, [0, 1, 2].map(|k| mix(k) as u8));
        }
    }

    /// A dark disc on the ground under a point: shows its place and height.
    pub fn shadow(&mut self, center: [f64; 3], radius: f64) {
        let Some(([cx, cy], depth)) = self.project(Vec3([center[0], center[1], 0.0])) else { return };
        let reach = radius * self.focal / depth;
        let bounds = |c: f64, end: usize| {
            (c - reach).floor().max(0.0) as usize..((c + reach).ceil() + 1.0).clamp(0.0, end as f64) as usize
        };
        for y in bounds(cy, self.image.height()) {
            for x in bounds(cx, self.image.width()) {
                let ray = self.ray(x, y);
                if ray.z() > -1e-3 || self.depth[y * self.image.width() + x].is_finite() {
                    continue;
                }
                let p = self.eye + ray.scale(-self.eye.z() / ray.z());
                if (p.x() - center[0]).hypot(p.y() - center[1]) <= radius {
                    self.image.set(x as i64, y as i64, SHADOW);
                }
            }
        }
    }

    /// The finished image.
    pub fn finish(self) -> Canvas {
        self.image
    }
}

/// Color of shadows on the ground.
const SHADOW: Rgb = [140, 160, 138];

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> Camera {
        Camera { eye: [-4.0, 0.0, 1.0], target: [0.0, 0.0, 1.0], field: 0.8 }
    }

    #[test]
    fn the_nearer_sphere_hides_the_farther_whatever_the_order() {
        for flip in [false, true] {
            let mut scene = Scene::new(100, 80, camera());
            let spheres = [([0.0, 0.0, 1.0], [255, 0, 0]), ([-1.0, 0.0, 1.0], [0, 0, 255])];
            for k in if flip { [1, 0] } else { [0, 1] } {
                scene.sphere(spheres[k].0, 0.3, spheres[k].1);
            }
            let [r, _, b] = scene.finish().get(50, 40);
            assert!(r == 0 && b > 60, "blue is nearer");
        }
    }

    #[test]
    fn a_sphere_has_the_size_of_perspective() {
        let mut scene = Scene::new(200, 100, camera());
        let empty = scene.image.clone();
        scene.sphere([0.0, 0.0, 1.0], 0.5, [0, 0, 0]);
        let image = scene.finish();
        let changed = (0..200).filter(|&x| image.get(x, 50) != empty.get(x, 50)).count() as f64;
        // 2 r f / d with f = 50 / tan(0.4).
        let expected = 2.0 * 0.5 * (50.0 / 0.4_f64.tan()) / 4.0;
        assert!((changed - expected).abs() <= 2.0, "{changed} of {expected}");
    }

    #[test]
    fn what_is_left_of_the_view_is_left_in_the_picture() {
        let mut scene = Scene::new(100, 80, camera());
        scene.sphere([0.0, 0.8, 1.0], 0.1, [255, 0, 255]);
        let image = scene.finish();
        let purple: Vec<usize> = (0..100).filter(|&x| image.get(x, 40)[1] == 0).collect();
        assert!(
            !purple.is_empty() && purple.iter().all(|&x| x < 50),
            "looking along +x, +y is left: {purple:?}"
        );
    }

    #[test]
    fn a_layer_is_glass_in_front_and_hidden_behind() {
        let mut scene = Scene::new(100, 80, camera());
        scene.sphere([0.0, 0.0, 1.0], 0.3, [255, 0, 0]);
        let plain = scene.image.clone();
        let mut behind = scene.layer();
        behind.sphere([1.0, 0.0, 1.0], 0.2, [0, 0, 255]);
        scene.blend(&behind, 0.5, 0.02);
        assert_eq!(scene.image, plain, "the red sphere hides all of it");
        let mut front = scene.layer();
        front.sphere([-1.0, 0.0, 1.0], 0.2, [0, 0, 255]);
        scene.blend(&front, 0.5, 0.02);
        let ([r, _, b], [before, ..]) = (scene.image.get(50, 40), plain.get(50, 40));
        assert!(r.abs_diff(before / 2) < 3 && b.abs_diff(r) < 3, "half red, half blue: {r} of {before}, {b}");
    }

    #[test]
    fn an_arrow_points_where_it_should_and_ends_there() {
        let mut scene = Scene::new(100, 80, camera());
        let empty = scene.image.clone();
        scene.arrow([0.0, 0.0, 1.0], [0.0, 0.0, 0.5], 0.08, [255, 0, 0]);
        let rows: Vec<usize> = (0..80).filter(|&y| scene.image.get(50, y) != empty.get(50, y)).collect();
        // Half a meter at 4 m, focal length 40 / tan(0.4).
        let length = 0.5 * (40.0 / 0.4_f64.tan()) / 4.0;
        let (top, bottom) = (rows[0] as f64, rows[rows.len() - 1] as f64);
        assert!((40.0 - top - length).abs() < 2.0 && (bottom - 40.0).abs() < 2.0, "{rows:?}");
        scene.arrow([0.0, 0.0, 1.0], [0.0; 3], 0.03, [255, 0, 0]);
    }

    #[test]
    fn things_behind_the_camera_are_not_drawn() {
        let empty = Scene::new(60, 40, camera()).finish();
        let mut scene = Scene::new(60, 40, camera());
        scene.capsule([[-6.0, 0.0, 1.0], [-4.0, 0.0, 1.0]], 0.2, [0; 3]);
        scene.shadow([-6.0, 0.0, 1.0], 0.5);
        assert_eq!(scene.finish(), empty);
    }
}
