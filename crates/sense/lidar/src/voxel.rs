//! Cubes of space: their keys, a fast hash, and a filter that leaves one point a cube.

use core::hash::{BuildHasherDefault, Hasher};
use std::collections::HashMap;

use nalgebra::Vector3;

/// A cube, as three signed numbers of 21 bits in one word.
pub(crate) type Key = u64;

const BITS: u32 = 21;
const BIAS: i64 = 1 << (BITS - 1);
const MASK: u64 = (1 << BITS) - 1;

/// Numbers of the cube that holds `p`, with edges of 1/`inverse_size` `[m]`.
#[inline]
pub(crate) fn cell(p: &Vector3<f64>, inverse_size: f64) -> [i64; 3] {
    // Far beyond any map, but neighbors can still be counted from there.
    [p.x, p.y, p.z].map(|x| (x * inverse_size).floor().clamp(-1e15, 1e15) as i64)
}

/// The key of a cube. Numbers beyond 2^20 wrap: half a million meters at 0.5 m, while the map is some 100 m wide.
#[inline]
pub(crate) fn key(cell: [i64; 3]) -> Key {
    let part = |x: i64| (x + BIAS) as u64 & MASK;
    part(cell[0]) | part(cell[1]) << BITS | part(cell[2]) << (2 * BITS)
}

/// One multiplication: keys are already spread, and no outsider chooses them.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct KeyHasher(u64);

impl Hasher for KeyHasher {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.write_u64(self.0 ^ u64::from(byte));
        }
    }

    #[inline]
    fn write_u64(&mut self, key: u64) {
        // 2^64 divided by the golden ratio; the table takes both ends of the word, so the ends are mixed.
        let x = key.wrapping_mul(0x9E37_79B9_7F4A_7C15);
        self.0 = x ^ (x >> 29);
    }
}

/// A table from cubes to `T`.
pub(crate) type KeyMap<T> = HashMap<Key, T, BuildHasherDefault<KeyHasher>>;

/// Leaves the mean of the points in each cube. Keeps its memory from scan to scan.
#[derive(Clone, Debug, Default)]
pub struct VoxelFilter {
    index: KeyMap<u32>,
    sums: Vec<(Vector3<f64>, u32)>,
}

impl VoxelFilter {
    /// Writes the mean of each cube of edge `size_m` `[m]` to `out`, in the order in which the cubes were first met.
    pub fn filter(
        &mut self,
        points: impl Iterator<Item = Vector3<f64>>,
        size_m: f64,
        out: &mut Vec<Vector3<f64>>,
    ) {
        self.index.clear();
        self.sums.clear();
        let inverse = 1.0 / size_m;
        for point in points {
            let next = self.sums.len() as u32;
            let at = *self.index.entry(key(cell(&point, inverse))).or_insert(next);
            if at == next {
                self.sums.push((point, 1));
            } else if let Some((sum, count)) = self.sums.get_mut(at as usize) {
                *sum += point;
                *count += 1;
            }
        }
        out.clear();
        out.extend(self.sums.iter().map(|(sum, count)| sum / f64::from(*count)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_of_neighbors_differ_also_across_zero() {
        let keys: std::collections::BTreeSet<Key> =
            (-2..2).flat_map(|x| (-2..2).flat_map(move |y| (-2..2).map(move |z| key([x, y, z])))).collect();
        assert_eq!(keys.len(), 64);
        assert_eq!(cell(&Vector3::new(-0.1, 0.0, 0.6), 2.0), [-1, 0, 1]);
    }

    #[test]
    fn the_filter_leaves_the_mean_of_each_cube() {
        let points = [[0.1, 0.1, 0.1], [0.7, 0.1, 0.1], [0.3, 0.1, 0.3]].map(Vector3::from);
        let mut out = Vec::new();
        VoxelFilter::default().filter(points.into_iter(), 0.5, &mut out);
        assert_eq!(out.len(), 2);
        assert!((out[0] - Vector3::new(0.2, 0.1, 0.2)).norm() < 1e-12);
        assert_eq!(out[1], Vector3::new(0.7, 0.1, 0.1));
    }
}
