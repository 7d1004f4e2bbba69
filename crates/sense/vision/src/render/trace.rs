//! Rays into a scene.

use super::light::ShadowMap;
use super::noise::Tile;
use super::scene::{Scene, View};
use super::solid::{Form, Solid};
use super::vector::{V3, add, dot, mix, rotate, rotate_back, scale, unit};

/// Side of the squares of pixels that share a list of things `[px]`.
pub(super) const TILE: usize = 16;

/// The number of what a ray met: a thing's index, or one of these.
pub(super) const GROUND: u16 = u16::MAX - 1;
pub(super) const BACKGROUND: u16 = u16::MAX;

/// Where a ray ended.
#[derive(Clone, Copy)]
pub(super) struct Hit {
    /// Depth along the optical axis `[m]`; infinity for the background.
    pub depth: f32,
    /// A thing's index, [`GROUND`] or [`BACKGROUND`].
    pub what: u16,
}

/// A thing in the camera's frame.
struct Seen {
    form: Form,
    index: u16,
    /// Way during the exposure, camera frame `[m]`.
    way: V3,
}

/// A scene as one camera sees it.
pub(super) struct Tracer<'a> {
    scene: &'a Scene,
    seen: Vec<Seen>,
    /// Things of every tile, as indices into `seen`.
    tiles: Vec<Vec<u16>>,
    columns: usize,
    shadows: ShadowMap,
    eye: V3,
    /// Rows: the camera's axes in the world.
    axes: [V3; 3],
    focal: [f32; 2],
    center: [f32; 2],
    size: [usize; 2],
}

impl<'a> Tracer<'a> {
    pub(super) fn new(scene: &'a Scene, view: &View) -> Self {
        let intrinsics = &view.intrinsics;
        let eye = view.pose.pos.0.map(|v| v as f32);
        let axes = [0, 1, 2].map(|k| view.pose.rot.col(k).0.map(|v| v as f32));
        let size = [intrinsics.width, intrinsics.height];
        let columns = size[0].div_ceil(TILE);
        let mut tracer = Self {
            scene,
            seen: Vec::new(),
            tiles: vec![Vec::new(); columns * size[1].div_ceil(TILE)],
            columns,
            shadows: ShadowMap::new([0.0; 2], 1.0),
            eye,
            axes,
            focal: intrinsics.focal.map(|v| v as f32),
            center: intrinsics.center.map(|v| v as f32),
            size,
        };
        tracer.shadows = tracer.shadow_map();
        for (index, solid) in scene.solids.iter().enumerate() {
            tracer.add(index, solid, view.exposure_s as f32);
        }
        tracer
    }

    /// Shadows on the part of the floor that is in the image, 8 m of it at most.
    fn shadow_map(&self) -> ShadowMap {
        let [w, h] = self.size.map(|v| v as f32);
        let (mut low, mut high) = ([f32::INFINITY; 2], [f32::NEG_INFINITY; 2]);
        for corner in [[0.0, 0.0], [w, 0.0], [0.0, h], [w, h], [0.5 * w, 0.5 * h]] {
            let ray = rotate_back(&self.axes, self.ray(corner));
            let reach = if ray[2] < -1e-3 { (self.eye[2] / -ray[2]).clamp(0.0, 6.0) } else { 6.0 };
            for k in 0..2 {
                let place = self.eye[k] + ray[k] * reach;
                (low[k], high[k]) = (low[k].min(place), high[k].max(place));
            }
        }
        let middle = [0, 1].map(|k| 0.5 * (low[k] + high[k]));
        let side = (high[0] - low[0]).max(high[1] - low[1]).clamp(0.5, 8.0) + 0.2;
        let mut map = ShadowMap::new(middle, side);
        for solid in &self.scene.solids {
            map.cast(solid, &self.scene.light);
        }
        map
    }

    /// Enters a thing into the tiles that it may touch.
    fn add(&mut self, index: usize, solid: &Solid, exposure: f32) {
        // The shell of the robot's head is no obstacle for the camera inside.
        if solid.form.holds(self.eye, 0.01) {
            return;
        }
        let form = solid.form.seen_from(self.eye, &self.axes);
        let way = scale(rotate(&self.axes, solid.velocity), exposure);
        let half = scale(way, 0.5);
        let Some(a) = self.bounds(&form.moved(half)) else { return };
        let Some(b) = self.bounds(&form.moved(scale(half, -1.0))) else { return };
        let number = self.seen.len() as u16;
        let range = |k: usize| {
            // A pixel more on every side: samples lie off the middle of their pixel.
            let low = (a[k][0].min(b[k][0]) - 1.0).clamp(0.0, self.size[k] as f32);
            let high = (a[k][1].max(b[k][1]) + 1.0).clamp(0.0, self.size[k] as f32);
            (low < high).then(|| low as usize / TILE..(high as usize).div_ceil(TILE))
        };
        let (Some(xs), Some(ys)) = (range(0), range(1)) else { return };
        let rows = self.size[1].div_ceil(TILE);
        for y in ys.start..ys.end.min(rows) {
            for x in xs.start..xs.end.min(self.columns) {
                self.tiles[y * self.columns + x].push(number);
            }
        }
        self.seen.push(Seen { form, index: index as u16, way });
    }

    /// A rectangle of the image outside which the form is not: across and down, from and to. `None` if it is behind the camera.
    fn bounds(&self, form: &Form) -> Option<[[f32; 2]; 2]> {
        let everything = [[f32::NEG_INFINITY, f32::INFINITY]; 2];
        let ball = |c: V3, r: f32| -> Option<[[f32; 2]; 2]> {
            if c[2] + r <= 0.0 {
                return None;
            }
            if c[2] <= r * 1.05 {
                return Some(everything);
            }
            Some([0, 1].map(|k| {
                let (x, z) = (c[k], c[2]);
                let root = r * (x * x + z * z - r * r).sqrt();
                [-1.0, 1.0]
                    .map(|sign| (x * z + sign * root) / (z * z - r * r) * self.focal[k] + self.center[k])
            }))
        };
        match *form {
            Form::Sphere { center, radius } => ball(center, radius),
            Form::Capsule { ends: [a, b], radius } => match (ball(a, radius), ball(b, radius)) {
                (None, None) => None,
                (Some(a), Some(b)) => Some([0, 1].map(|k| [a[k][0].min(b[k][0]), a[k][1].max(b[k][1])])),
                _ => Some(everything),
            },
            Form::Box { center, half_size, axes } => {
                let mut bounds = [[f32::INFINITY, f32::NEG_INFINITY]; 2];
                let (mut before, mut behind) = (false, false);
                for corner in 0..8 {
                    let mut p = center;
                    for k in 0..3 {
                        let sign = if corner >> k & 1 == 1 { 1.0 } else { -1.0 };
                        p = add(p, scale(axes[k], sign * half_size[k]));
                    }
                    if p[2] <= 0.01 {
                        behind = true;
                        continue;
                    }
                    before = true;
                    for k in 0..2 {
                        let v = p[k] / p[2] * self.focal[k] + self.center[k];
                        bounds[k] = [bounds[k][0].min(v), bounds[k][1].max(v)];
                    }
                }
                match (before, behind) {
                    (true, false) => Some(bounds),
                    (true, true) => Some(everything),
                    (false, _) => None,
                }
            }
        }
    }

    /// The ray through a point of the image, camera frame, of depth 1.
    #[inline(always)]
    pub(super) fn ray(&self, pixel: [f32; 2]) -> V3 {
        [(pixel[0] - self.center[0]) / self.focal[0], (pixel[1] - self.center[1]) / self.focal[1], 1.0]
    }

    /// Tiles in a row.
    pub(super) fn columns(&self) -> usize {
        self.columns
    }

    /// Whether something in a tile moves by more than half a pixel during the exposure.
    pub(super) fn moves(&self, tile: usize) -> bool {
        self.tiles[tile].iter().any(|&number| self.smear(number) > 0.5)
    }

    /// Way of a thing during the exposure `[px]`, about.
    fn smear(&self, number: u16) -> f32 {
        let Seen { form, way, .. } = &self.seen[usize::from(number)];
        let depth = match *form {
            Form::Sphere { center, .. } | Form::Box { center, .. } => center[2],
            Form::Capsule { ends, .. } => ends[0][2].min(ends[1][2]),
        };
        dot(*way, *way).sqrt() * self.focal[0] / depth.max(0.1)
    }

    /// What a ray meets; `time` is -0.5 at the begin of the exposure and 0.5 at its end.
    #[inline(always)]
    pub(super) fn hit(&self, ray: V3, tile: usize, time: f32) -> Hit {
        // Height above the floor along the ray: eye + t down.
        let down = self.axes[0][2] * ray[0] + self.axes[1][2] * ray[1] + self.axes[2][2] * ray[2];
        let mut hit = if down < -1e-6 {
            Hit { depth: -self.eye[2] / down, what: GROUND }
        } else {
            Hit { depth: f32::INFINITY, what: BACKGROUND }
        };
        for &number in &self.tiles[tile] {
            let Seen { form, index, way } = &self.seen[usize::from(number)];
            let depth = if time == 0.0 || *way == [0.0; 3] {
                form.hit(ray)
            } else {
                form.moved(scale(*way, time)).hit(ray)
            };
            if depth < hit.depth {
                hit = Hit { depth, what: *index };
            }
        }
        hit
    }

    /// The light that comes back along a ray, linear.
    #[inline(always)]
    pub(super) fn light(&self, ray: V3, hit: Hit, time: f32, exposure: f32) -> V3 {
        let light = &self.scene.light;
        let world_ray = rotate_back(&self.axes, ray);
        if hit.what == BACKGROUND {
            let up = unit(world_ray);
            let heading = up[1].atan2(up[0]);
            let blot = Tile::shared().at([heading * 12.0 + 100.0, up[2] * 30.0 + 100.0], 1.0);
            let color = mix(
                self.scene.background[0],
                self.scene.background[1],
                (up[2] * 2.0 + 0.25 * blot).clamp(0.0, 1.0),
            );
            return [0, 1, 2].map(|k| color[k] * (light.ambient[k] + 0.4 * light.lamp[k]));
        }
        let point = add(self.eye, scale(world_ray, hit.depth));
        let to_eye = || unit(scale(world_ray, -1.0));
        if hit.what == GROUND {
            let place = [point[0], point[1]];
            let length = dot(ray, ray).sqrt();
            let distance = hit.depth * length;
            // A pixel's size on the floor: mean of the long and the short side.
            let slant = (self.eye[2] / distance).max(0.05);
            let footprint = hit.depth / self.focal[0] * (0.5 + 0.5 / slant);
            let (lamp, sky) = self.shadows.at(place);
            let gloss = self.scene.ground.gloss;
            let color = self.scene.ground.at(place, footprint);
            let eye = if gloss > 0.0 { to_eye() } else { [0.0, 0.0, 1.0] };
            return light.shade(color, [0.0, 0.0, 1.0], eye, gloss, lamp, sky);
        }
        let solid = &self.scene.solids[usize::from(hit.what)];
        let form =
            if time == 0.0 { solid.form } else { solid.form.moved(scale(solid.velocity, time * exposure)) };
        let normal = form.normal(point);
        let (color, gloss) = solid.paint.at(point, normal);
        // Shadow of other things: where the lamp's ray through this point meets the floor, unless that is the thing's own shadow.
        let lift = point[2] / light.toward[2].max(0.15);
        let foot = [point[0] - light.toward[0] * lift, point[1] - light.toward[1] * lift];
        let lamp = if point[2] > 0.35 || dot(normal, light.toward) <= 0.0 {
            1.0
        } else {
            self.others_shadow(hit.what, point, foot)
        };
        let sky = if point[2] < 0.1 { 0.6 + 4.0 * point[2].max(0.0) } else { 1.0 };
        light.shade(color, normal, to_eye(), gloss, lamp, sky)
    }

    /// Share of the lamp at a point of a low thing: shadowed where the floor behind it is, and something else is in the lamp's way.
    #[inline(always)]
    fn others_shadow(&self, own: u16, point: V3, foot: [f32; 2]) -> f32 {
        let (lamp, _) = self.shadows.at(foot);
        if lamp > 0.98 {
            return 1.0;
        }
        let toward = self.scene.light.toward;
        let axis_hit = |form: &Form| form.moved(scale(point, -1.0)).hit(toward).is_finite();
        let blocked = (self.scene.solids.iter().enumerate())
            .any(|(k, solid)| k != usize::from(own) && axis_hit(&solid.form));
        if blocked { 0.0 } else { 1.0 }
    }
}
