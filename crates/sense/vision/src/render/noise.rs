//! Noise for textures: a tile of smooth random numbers with its coarser levels.

use std::sync::OnceLock;

use paid_lanes::rng::Rng;

const SIDE: usize = 256;
const LEVELS: usize = 8;

/// A tile that repeats, mean 0 and deviation about 1 at the finest level; every further level is the mean over four.
pub(super) struct Tile {
    levels: Vec<Vec<f32>>,
}

impl Tile {
    /// The one tile of the program.
    pub(super) fn shared() -> &'static Self {
        static TILE: OnceLock<Tile> = OnceLock::new();
        TILE.get_or_init(Self::new)
    }

    fn new() -> Self {
        let mut rng = Rng::new(0x7469_6c65, 0, 0);
        // White noise at three sizes: single cells, and smoother patches of 4 and 16 of them.
        let mut finest = vec![0.0_f32; SIDE * SIDE];
        for (step, weight) in [(1_usize, 0.7_f32), (4, 0.6), (16, 0.5)] {
            let cells = SIDE / step;
            let coarse: Vec<f32> = (0..cells * cells).map(|_| rng.normal() as f32).collect();
            for y in 0..SIDE {
                for x in 0..SIDE {
                    let at = [x as f32 / step as f32, y as f32 / step as f32];
                    finest[y * SIDE + x] += weight * bilinear(&coarse, cells, at);
                }
            }
        }
        let mut levels = vec![finest];
        for level in 1..LEVELS {
            let (side, below) = (SIDE >> level, &levels[level - 1]);
            let above = 2 * side;
            let mean = |x: usize, y: usize| {
                let at = |dx: usize, dy: usize| below[(2 * y + dy) * above + 2 * x + dx];
                0.25 * (at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1))
            };
            levels.push((0..side * side).map(|i| mean(i % side, i / side)).collect());
        }
        Self { levels }
    }

    /// The noise at a place, both given in cells of the finest level; `footprint` is the size of what is averaged.
    #[inline(always)]
    pub(super) fn at(&self, place: [f32; 2], footprint: f32) -> f32 {
        // The exponent of the footprint is the level.
        let level = ((footprint.max(1.0).to_bits() >> 23) as usize).saturating_sub(127);
        if level >= LEVELS {
            return 0.0;
        }
        let k = 1.0 / (1_u32 << level) as f32;
        bilinear(&self.levels[level], SIDE >> level, [place[0] * k, place[1] * k])
    }
}

/// Between four cells of a tile of `side` by `side` (a power of two) that repeats.
#[inline(always)]
fn bilinear(cells: &[f32], side: usize, [x, y]: [f32; 2]) -> f32 {
    let (x0, y0) = (x.floor(), y.floor());
    let (fx, fy) = (x - x0, y - y0);
    let mask = side - 1;
    let (x0, y0) = (x0 as i64 as usize & mask, y0 as i64 as usize & mask);
    let (x1, y1) = ((x0 + 1) & mask, (y0 + 1) & mask);
    let at = |x: usize, y: usize| cells[y * side + x];
    let (top, low) =
        (at(x0, y0) + fx * (at(x1, y0) - at(x0, y0)), at(x0, y1) + fx * (at(x1, y1) - at(x0, y1)));
    top + fy * (low - top)
}

/// Scrambles an integer: cheap numbers for noise that is not stored.
#[inline(always)]
pub(super) fn hash(mut x: u32) -> u32 {
    x ^= x >> 16;
    x = x.wrapping_mul(0x7feb_352d);
    x ^= x >> 15;
    x = x.wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

/// 4096 standard normal numbers, to be picked by hashed index.
pub(super) fn normals() -> &'static [f32] {
    static NORMALS: OnceLock<Vec<f32>> = OnceLock::new();
    NORMALS.get_or_init(|| {
        let mut rng = Rng::new(0x6e6f_726d, 0, 0);
        (0..4096).map(|_| rng.normal() as f32).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn far_noise_is_the_mean_of_near_noise() {
        let tile = Tile::shared();
        let spread = |footprint: f32| {
            let values: Vec<f32> =
                (0..4000).map(|i| tile.at([i as f32 * 7.31, i as f32 * 3.17], footprint)).collect();
            (values.iter().map(|v| v * v).sum::<f32>() / 4000.0).sqrt()
        };
        let (near, far) = (spread(1.0), spread(64.0));
        assert!((0.4..1.3).contains(&near) && far < 0.4 * near, "{near} {far}");
        assert_eq!(tile.at([3.0, 5.0], 1.0), tile.at([3.0 + SIDE as f32, 5.0], 1.0));
        assert_eq!(tile.at([3.0, 5.0], 1e9), 0.0);
    }
}
