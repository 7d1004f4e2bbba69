//! Scenes of a few shapes, and rays through them.

use core::str::FromStr;

use nalgebra::{Vector2, Vector3};
use paid_lanes::rng::Rng;

use super::boxes::Boxes;
use crate::error::LidarError;

/// Which scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum SceneKind {
    /// A hall of 20 x 14 x 6 m with columns, benches and mats.
    Hall,
    /// A pitch of 14 x 9 m with two goals on endless flat ground, and nothing else.
    Pitch,
    /// A bare corridor, 2.4 m wide, whose ends are out of range.
    Corridor,
    /// The hall with eight people who walk through it.
    People,
    /// A hall without walls, with a box in every square of 8 m, as `seed` draws them: for a robot that walks on and on. No box is in the
    /// robot's way.
    Endless,
}

impl SceneKind {
    /// All scenes.
    pub const ALL: [Self; 5] = [Self::Hall, Self::Pitch, Self::Corridor, Self::People, Self::Endless];

    /// Its name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Hall => "hall",
            Self::Pitch => "pitch",
            Self::Corridor => "corridor",
            Self::People => "people",
            Self::Endless => "endless",
        }
    }
}

impl FromStr for SceneKind {
    type Err = LidarError;

    fn from_str(name: &str) -> Result<Self, LidarError> {
        Self::ALL.into_iter().find(|k| k.name() == name).ok_or_else(|| LidarError::Name {
            name: "scene",
            expected: "hall, pitch, corridor, people, endless",
            found: name.to_owned(),
        })
    }
}

/// A surface that a ray can hit.
#[derive(Clone, Debug)]
pub(super) enum Shape {
    /// The inside of a box with these corners.
    Room { low: Vector3<f64>, high: Vector3<f64> },
    /// The ground `z = 0`.
    Ground,
    /// Boxes on endless ground.
    Boxes(Boxes),
    /// The outside of a box: center, half of its edges, and its turn about z as cosine and sine.
    Block { center: Vector3<f64>, half: Vector3<f64>, turn: (f64, f64) },
    /// An upright cylinder without lids, from `low` to `high` `[m]`, whose axis goes by `velocity` `[m/s]` to and fro.
    Column { center: Vector2<f64>, radius: f64, low: f64, high: f64, walk: Vector2<f64> },
}

/// A surface and the share of rays that it sends back (nets let most through).
#[derive(Clone, Debug)]
struct Thing {
    shape: Shape,
    share: f64,
}

/// A scene, z up, ground at `z = 0`.
#[derive(Clone, Debug)]
pub struct Scene {
    things: Vec<Thing>,
    /// Added to every ray's origin.
    shift: Vector3<f64>,
}

/// Half of the period in which people walk to and fro `[s]`.
const STROLL_S: f64 = 8.0;
/// Rays flatter than this against a surface (cosine) do not come back: 1.3 m above ground that is 26 m away.
const GRAZING: f64 = 0.05;

impl Scene {
    /// The scene of that kind. People walk as `seed` draws.
    #[must_use]
    pub fn new(kind: SceneKind, seed: u64) -> Self {
        let things = match kind {
            SceneKind::Hall => hall(),
            SceneKind::Pitch => pitch(),
            SceneKind::Corridor => vec![solid(Shape::Room {
                low: Vector3::new(-150.0, -1.2, 0.0),
                high: Vector3::new(150.0, 1.2, 2.8),
            })],
            SceneKind::People => hall().into_iter().chain(people(seed)).collect(),
            SceneKind::Endless => [Shape::Ground, Shape::Boxes(Boxes { seed })].map(solid).into(),
        };
        Self { things, shift: Vector3::zeros() }
    }

    /// The scene with everything in it moved by `by` `[m]`.
    #[must_use]
    pub fn moved(mut self, by: &Vector3<f64>) -> Self {
        self.shift -= by;
        self
    }

    /// Distance `[m]` along the unit vector `ray` from `origin` to the first surface at `time_s`. `luck` in [0, 1) decides whether a
    /// net sends the ray back.
    #[must_use]
    pub fn range(&self, origin: &Vector3<f64>, ray: &Vector3<f64>, time_s: f64, luck: f64) -> Option<f64> {
        let origin = &(origin + self.shift);
        let mut nearest = f64::INFINITY;
        for thing in &self.things {
            if luck < thing.share
                && let Some(range) = thing.shape.hit(origin, ray, time_s)
                && range < nearest
            {
                nearest = range;
            }
        }
        nearest.is_finite().then_some(nearest)
    }
}

impl Shape {
    /// Distance `[m]` along the unit vector `ray` from `origin` at `time_s`.
    pub(super) fn hit(&self, origin: &Vector3<f64>, ray: &Vector3<f64>, time_s: f64) -> Option<f64> {
        match self {
            Self::Ground => (ray.z < -GRAZING && origin.z > 0.0).then(|| -origin.z / ray.z),
            Self::Boxes(boxes) => boxes.hit(origin, ray),
            Self::Room { low, high } => {
                // From inside, the first wall on the way is the nearest of the three ahead.
                let mut nearest = f64::INFINITY;
                let mut cosine = 0.0;
                for i in (0..3).filter(|&i| ray[i].abs() > 1e-12) {
                    let wall = if ray[i] > 0.0 { high[i] } else { low[i] };
                    let range = (wall - origin[i]) / ray[i];
                    if range < nearest {
                        nearest = range;
                        cosine = ray[i].abs();
                    }
                }
                (nearest > 0.0 && cosine > GRAZING).then_some(nearest)
            }
            Self::Block { center, half, turn } => {
                let local = |v: Vector3<f64>| {
                    Vector3::new(turn.0 * v.x + turn.1 * v.y, turn.0 * v.y - turn.1 * v.x, v.z)
                };
                let (from, ray) = (local(origin - center), local(*ray));
                let (mut enter, mut leave, mut cosine) = (f64::NEG_INFINITY, f64::INFINITY, 0.0);
                for i in 0..3 {
                    let inverse = 1.0 / ray[i];
                    let (a, b) = ((-half[i] - from[i]) * inverse, (half[i] - from[i]) * inverse);
                    let (near, far) = if a < b { (a, b) } else { (b, a) };
                    if near > enter {
                        enter = near;
                        cosine = ray[i].abs();
                    }
                    leave = leave.min(far);
                }
                (enter > 0.0 && enter <= leave && cosine > GRAZING).then_some(enter)
            }
            Self::Column { center, radius, low, high, walk } => {
                let moved = (time_s % (2.0 * STROLL_S) - STROLL_S).abs();
                let from = origin.xy() - center - walk * moved;
                let a = ray.xy().norm_squared();
                let b = from.dot(&ray.xy());
                let root = b * b - a * (from.norm_squared() - radius * radius);
                if root <= 0.0 || a < 1e-12 {
                    return None;
                }
                let range = (-b - root.sqrt()) / a;
                let z = origin.z + ray.z * range;
                (range > 0.0 && (*low..=*high).contains(&z)).then_some(range)
            }
        }
    }
}

fn solid(shape: Shape) -> Thing {
    Thing { shape, share: 1.0 }
}

fn block(center: [f64; 3], edges: [f64; 3], turn_rad: f64) -> Shape {
    Shape::Block {
        center: Vector3::from(center),
        half: Vector3::from(edges) * 0.5,
        turn: (turn_rad.cos(), turn_rad.sin()),
    }
}

fn column(x: f64, y: f64, radius: f64, high: f64) -> Shape {
    Shape::Column { center: Vector2::new(x, y), radius, low: 0.0, high, walk: Vector2::zeros() }
}

fn hall() -> Vec<Thing> {
    let room = Shape::Room { low: Vector3::new(-10.0, -7.0, 0.0), high: Vector3::new(10.0, 7.0, 6.0) };
    let mut things = vec![solid(room)];
    for (x, y) in [(-9.5, -6.5), (-3.0, -6.6), (3.5, 6.6), (9.4, 6.4)] {
        things.push(solid(column(x, y, 0.25, 6.0)));
    }
    for (center, edges, turn) in [
        ([-6.0, 6.6, 0.25], [3.0, 0.4, 0.5], 0.0),
        ([4.0, -6.5, 0.25], [2.5, 0.4, 0.5], 0.1),
        ([8.8, -2.0, 0.6], [1.2, 0.8, 1.2], 0.5),
        ([-9.0, 2.0, 0.9], [0.8, 2.0, 1.8], 0.0),
        ([9.2, 4.0, 0.15], [1.2, 2.0, 0.3], 0.2),
    ] {
        things.push(solid(block(center, edges, turn)));
    }
    things
}

/// Goals of 2.6 x 1.8 m with nets 0.6 m deep: the size of an adult-size humanoid league.
fn pitch() -> Vec<Thing> {
    let mut things = vec![solid(Shape::Ground)];
    for side in [-1.0, 1.0] {
        let line = side * 7.0;
        for y in [-1.3, 1.3] {
            things.push(solid(column(line, y, 0.06, 1.8)));
        }
        things.push(solid(block([line, 0.0, 1.8], [0.12, 2.6, 0.12], 0.0)));
        let net = |center, edges| Thing { shape: block(center, edges, 0.0), share: 0.4 };
        things.push(net([line + side * 0.6, 0.0, 0.9], [0.01, 2.6, 1.8]));
        for y in [-1.3, 1.3] {
            things.push(net([line + side * 0.3, y, 0.9], [0.6, 0.01, 1.8]));
        }
    }
    things
}

fn people(seed: u64) -> Vec<Thing> {
    let mut rng = Rng::new(seed, 0, 40);
    (0..8)
        .map(|_| {
            let from = Vector2::new(rng.uniform(-8.0, 8.0), rng.uniform(-6.0, 6.0));
            let to = Vector2::new(rng.uniform(-8.0, 8.0), rng.uniform(-6.0, 6.0));
            let walk = (to - from) / STROLL_S;
            solid(Shape::Column { center: from, radius: 0.22, low: 0.0, high: 1.75, walk })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn range(kind: SceneKind, origin: [f64; 3], ray: [f64; 3]) -> Option<f64> {
        Scene::new(kind, 1).range(&Vector3::from(origin), &Vector3::from(ray).normalize(), 0.0, 0.0)
    }

    #[test]
    fn rays_in_the_hall_end_at_walls_floor_and_columns() {
        assert_eq!(range(SceneKind::Hall, [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]), Some(1.0));
        assert_eq!(range(SceneKind::Hall, [0.0, 0.0, 3.0], [1.0, 0.0, 0.0]), Some(10.0));
        // Column of radius 0.25 m at (-3, -6.6).
        let found = range(SceneKind::Hall, [-3.0, 0.0, 3.0], [0.0, -1.0, 0.0]).expect("a column");
        assert!((found - 6.35).abs() < 1e-9, "{found}");
        // Cupboard from x = -9.4 to -8.6.
        let found = range(SceneKind::Hall, [0.0, 2.0, 1.0], [-1.0, 0.0, 0.0]).expect("a block");
        assert!((found - 8.6).abs() < 1e-9, "{found}");
    }

    #[test]
    fn the_pitch_ends_nowhere_and_nets_let_some_rays_through() {
        assert_eq!(range(SceneKind::Pitch, [0.0, 4.0, 1.3], [0.0, 1.0, 0.01]), None);
        let scene = Scene::new(SceneKind::Pitch, 1);
        let (origin, ray) = (Vector3::new(0.0, 0.5, 1.0), Vector3::x());
        assert!((scene.range(&origin, &ray, 0.0, 0.3).expect("net") - 7.595).abs() < 1e-9);
        assert_eq!(scene.range(&origin, &ray, 0.0, 0.7), None);
    }

    #[test]
    fn the_endless_hall_is_the_same_kind_of_place_everywhere() {
        for at in [0.0, 1000.0] {
            assert_eq!(range(SceneKind::Endless, [at, 0.0, 1.0], [0.0, 0.0, -1.0]), Some(1.0));
            let boxes = (0..360)
                .map(f64::from)
                .filter(|a| {
                    let (y, x) = a.to_radians().sin_cos();
                    range(SceneKind::Endless, [at, 0.0, 0.9], [x, y, 0.0]).is_some()
                })
                .count();
            assert!((90..=360).contains(&boxes), "{boxes} of 360 rays at {at} m");
        }
    }

    #[test]
    fn an_unknown_scene_is_named_with_those_there_are() {
        let error = "moon".parse::<SceneKind>().expect_err("no moon");
        assert_eq!(
            error.to_string(),
            "scene: expected one of hall, pitch, corridor, people, endless, found 'moon'"
        );
    }
}
