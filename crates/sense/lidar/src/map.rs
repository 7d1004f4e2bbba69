//! The map: one point a cube, the one nearest the cube's center, in a box that moves with the sensor.
//!
//! A hash table instead of a tree: nothing to balance, and no trouble with points of equal coordinates on walls.

use nalgebra::Vector3;

use crate::voxel::{KeyMap, cell, key};

/// Points that a plane is fitted to.
pub const NEIGHBORS: usize = 5;

/// Points around the sensor, by cubes.
#[derive(Clone, Debug)]
pub struct VoxelMap {
    size: f64,
    inverse_size: f64,
    half_width: f64,
    capacity: usize,
    voxels: KeyMap<Vector3<f64>>,
    /// Where the sensor was when the box was moved last.
    center: Option<Vector3<f64>>,
}

impl VoxelMap {
    /// An empty map with cubes of `size_m`, a box of `2 half_width_m` `[m]` and room for `capacity` points.
    #[must_use]
    pub fn new(size_m: f64, half_width_m: f64, capacity: usize) -> Self {
        Self {
            size: size_m,
            inverse_size: 1.0 / size_m,
            half_width: half_width_m,
            capacity,
            voxels: KeyMap::default(),
            center: None,
        }
    }

    /// Number of points, at most the capacity.
    #[must_use]
    pub fn len(&self) -> usize {
        self.voxels.len()
    }

    /// Whether there is no point.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.voxels.is_empty()
    }

    /// Memory of the table `[bytes]`.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.voxels.capacity() * (size_of::<(u64, Vector3<f64>)>() + 1)
    }

    /// Puts `point` into its cube, if the cube is empty or the point is nearer to the cube's center than the one there.
    pub fn insert(&mut self, point: Vector3<f64>) {
        let cell = cell(&point, self.inverse_size);
        let full = self.voxels.len() >= self.capacity;
        let center = Vector3::from(cell.map(|x| (x as f64 + 0.5) * self.size));
        if let Some(held) = self.voxels.get_mut(&key(cell)) {
            if (point - center).norm_squared() < (*held - center).norm_squared() {
                *held = point;
            }
        } else if !full {
            self.voxels.insert(key(cell), point);
        }
    }

    /// Moves the box to the sensor, once it is a tenth of its width away, and drops what is outside. A full map drops what is
    /// farther than half of the box.
    pub fn follow(&mut self, sensor: &Vector3<f64>) {
        let full = self.voxels.len() >= self.capacity;
        let step = 0.2 * self.half_width;
        if !full && self.center.is_some_and(|c| (c - sensor).amax() < step) {
            return;
        }
        self.center = Some(*sensor);
        let reach = if full { 0.5 * self.half_width } else { self.half_width };
        self.voxels.retain(|_, p| (*p - sensor).amax() <= reach);
    }

    /// The five points nearest to `point` among the cubes around it, nearest first, and the distance `[m]` of the fifth.
    ///
    /// Looks into the 27 cubes around the point, then, if they hold fewer than five, into the 125.
    #[must_use]
    pub fn nearest(&self, point: &Vector3<f64>) -> Option<([Vector3<f64>; NEIGHBORS], f64)> {
        let at = cell(point, self.inverse_size);
        let mut found = Nearest::default();
        self.look(point, at, 0, 1, &mut found);
        if found.count < NEIGHBORS {
            self.look(point, at, 2, 2, &mut found);
        }
        (found.count >= NEIGHBORS).then(|| (found.points, found.squares[NEIGHBORS - 1].sqrt()))
    }

    /// Looks into the cubes whose distance from `at`, in cubes, is from `from` to `to`.
    fn look(&self, point: &Vector3<f64>, at: [i64; 3], from: i64, to: i64, found: &mut Nearest) {
        for x in -to..=to {
            for y in -to..=to {
                for z in -to..=to {
                    if x.abs().max(y.abs()).max(z.abs()) < from {
                        continue;
                    }
                    if let Some(held) = self.voxels.get(&key([at[0] + x, at[1] + y, at[2] + z])) {
                        found.add(*held, (held - point).norm_squared());
                    }
                }
            }
        }
    }
}

/// The nearest points so far, in order.
#[derive(Debug)]
struct Nearest {
    points: [Vector3<f64>; NEIGHBORS],
    squares: [f64; NEIGHBORS],
    count: usize,
}

impl Default for Nearest {
    fn default() -> Self {
        Self { points: [Vector3::zeros(); NEIGHBORS], squares: [f64::INFINITY; NEIGHBORS], count: 0 }
    }
}

impl Nearest {
    #[inline]
    fn add(&mut self, point: Vector3<f64>, square: f64) {
        if square >= self.squares[NEIGHBORS - 1] {
            return;
        }
        let mut at = NEIGHBORS - 1;
        while at > 0 && self.squares[at - 1] > square {
            self.squares[at] = self.squares[at - 1];
            self.points[at] = self.points[at - 1];
            at -= 1;
        }
        self.squares[at] = square;
        self.points[at] = point;
        self.count = (self.count + 1).min(NEIGHBORS);
    }
}

#[cfg(test)]
mod tests {
    use paid_lanes::rng::Rng;

    use super::*;

    #[test]
    fn the_point_nearest_the_center_of_its_cube_stays() {
        let mut map = VoxelMap::new(0.5, 50.0, 1000);
        for x in [0.05, 0.3, 0.45] {
            map.insert(Vector3::new(x, 0.25, 0.25));
        }
        assert_eq!(map.len(), 1);
        assert_eq!(map.voxels.values().next(), Some(&Vector3::new(0.3, 0.25, 0.25)));
    }

    #[test]
    fn the_nearest_five_are_those_of_a_search_through_all() {
        let mut rng = Rng::new(3, 0, 0);
        let mut map = VoxelMap::new(0.5, 50.0, 100_000);
        for _ in 0..4000 {
            map.insert(Vector3::new(rng.uniform(-2.0, 2.0), rng.uniform(-2.0, 2.0), rng.uniform(-2.0, 2.0)));
        }
        for _ in 0..50 {
            let q = Vector3::new(rng.uniform(-1.0, 1.0), rng.uniform(-1.0, 1.0), rng.uniform(-1.0, 1.0));
            let mut all: Vec<f64> = map.voxels.values().map(|p| (p - q).norm()).collect();
            all.sort_by(f64::total_cmp);
            let (points, fifth) = map.nearest(&q).expect("a full map");
            // A cube beyond the 27 is at least 0.5 m away; nearer ones are found exactly.
            for (i, p) in points.iter().enumerate() {
                if all[i] < 0.5 {
                    assert!(((p - q).norm() - all[i]).abs() < 1e-12);
                }
            }
            assert!(fifth >= (points[3] - q).norm());
        }
    }

    #[test]
    fn four_points_around_are_not_enough() {
        let mut map = VoxelMap::new(0.5, 50.0, 1000);
        for x in 0..4 {
            map.insert(Vector3::new(f64::from(x) * 0.5 - 0.7, 0.0, 0.0));
        }
        assert!(map.nearest(&Vector3::zeros()).is_none());
        map.insert(Vector3::new(0.0, 1.0, 0.0));
        assert!(map.nearest(&Vector3::zeros()).is_some());
    }

    #[test]
    fn the_map_forgets_what_is_outside_its_box_and_never_holds_more_than_its_capacity() {
        let mut map = VoxelMap::new(0.5, 10.0, 500);
        let mut most = 0;
        for step in 0..400 {
            let x = f64::from(step) * 0.5;
            map.follow(&Vector3::new(x, 0.0, 0.0));
            for y in -20..20 {
                map.insert(Vector3::new(x, f64::from(y) * 0.5, 0.1));
            }
            most = most.max(map.len());
        }
        assert!(most <= 500, "{most}");
        assert!(map.voxels.values().all(|p| p.x > 180.0));
    }
}
