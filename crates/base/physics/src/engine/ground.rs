//! The ground: a plane or a periodic grid of heights.

use paid_lanes::rng::Rng;
use paid_lanes::{MAX_LANES, Real, Scalar, Vec3};

use super::error::PhysicsError;
use super::params::GroupParams;
use crate::Terrain;

impl Terrain {
    /// Heights of the grid points `[m]`, row-major `[y][x]`, the first one at x = y = 0; none for the plane.
    ///
    /// # Errors
    /// If a number is out of its range.
    pub fn heights(&self) -> Result<Vec<f64>, PhysicsError> {
        let Self::Rough { amplitude_m, step_m, cell_m, size, seed } = *self else { return Ok(Vec::new()) };
        let bad = |what: &str, expected, found: String| PhysicsError::Value {
            what: format!("terrain.{what}"),
            expected,
            found,
        };
        if !(amplitude_m >= 0.0 && amplitude_m.is_finite()) {
            return Err(bad("amplitude_m", "a number of at least 0", amplitude_m.to_string()));
        }
        if !(step_m >= 0.0 && step_m.is_finite()) {
            return Err(bad("step_m", "a number of at least 0", step_m.to_string()));
        }
        if !(cell_m > 0.0 && cell_m.is_finite()) {
            return Err(bad("cell_m", "a positive number", cell_m.to_string()));
        }
        if !(2..=4096).contains(&size) {
            return Err(bad("size", "2 to 4096 grid points", size.to_string()));
        }
        let mut rng = Rng::new(seed, 0, 0);
        let mut draw = || {
            let height = rng.uniform(-amplitude_m, amplitude_m);
            if step_m > 0.0 { (height / step_m).round() * step_m } else { height }
        };
        Ok((0..size * size).map(|_| draw()).collect())
    }
}

/// Heights and how to look them up.
#[derive(Clone, Debug)]
pub(crate) struct Ground<S> {
    /// Row-major `[y][x]`, empty for the plane.
    heights: Vec<S>,
    size: usize,
    cell: f64,
    highest: f64,
}

impl<S: Scalar> Ground<S> {
    /// The heights of a terrain.
    pub fn new(terrain: &Terrain) -> Result<Self, PhysicsError> {
        match *terrain {
            Terrain::Plane => Ok(Self { heights: Vec::new(), size: 0, cell: 1.0, highest: 0.0 }),
            Terrain::Rough { cell_m, size, .. } => Ok(Self::from_heights(&terrain.heights()?, size, cell_m)),
        }
    }

    /// A grid of given heights `[m]`, row-major `[y][x]`.
    pub fn from_heights(heights: &[f64], size: usize, cell: f64) -> Self {
        let highest = heights.iter().copied().fold(f64::MIN, f64::max);
        Self { heights: heights.iter().map(|&h| S::from_f64(h)).collect(), size, cell, highest }
    }

    /// No point is higher than this `[m]`.
    pub fn highest(&self) -> f64 {
        self.highest
    }

    /// True for z = 0.
    pub fn is_plane(&self) -> bool {
        self.heights.is_empty()
    }

    /// Height `[m]` and unit normal below a world point of each lane.
    #[inline(always)]
    pub fn at<V: Real<Scalar = S>>(&self, x: V, y: V, params: &GroupParams<V>) -> (V, Vec3<V>) {
        if self.is_plane() {
            return (V::zero(), Vec3::new(V::zero(), V::zero(), V::one()));
        }
        let inv_cell = V::c(1.0 / self.cell);
        let (u, v) = ((x + params.terrain_offset[0]) * inv_cell, (y + params.terrain_offset[1]) * inv_cell);
        let size = V::c(self.size as f64);
        let inv_size = V::c(1.0 / self.size as f64);
        // Periodic: into [0, size), where rounding may still give size itself.
        let (u, v) = (u - (u * inv_size).floor() * size, v - (v * inv_size).floor() * size);
        let (i, j) = (u.floor(), v.floor());
        let (s, t) = (u - i, v - j);
        let [h00, h10, h01, h11] = self.corners(i, j);
        let (low, high) = (s.mul_add(h10 - h00, h00), s.mul_add(h11 - h01, h01));
        let height = t.mul_add(high - low, low);
        let slope_x = t.mul_add((h11 - h01) - (h10 - h00), h10 - h00) * inv_cell;
        let slope_y = (high - low) * inv_cell;
        let inv = slope_x.mul_add(slope_x, slope_y.mul_add(slope_y, V::one())).rsqrt();
        (height, Vec3::new(-slope_x * inv, -slope_y * inv, inv))
    }

    /// Heights at the four corners of the cell (i, j), lane by lane.
    #[inline(always)]
    fn corners<V: Real<Scalar = S>>(&self, i: V, j: V) -> [V; 4] {
        let mut columns = [S::default(); MAX_LANES];
        let mut rows = [S::default(); MAX_LANES];
        i.store(&mut columns);
        j.store(&mut rows);
        let mut out = [[S::default(); MAX_LANES]; 4];
        for lane in 0..V::LANES {
            // A NaN and a rounded-up `size` become 0: always inside. (A division would cost more than all the rest.)
            let x0 = columns[lane].to_f64() as usize;
            let x0 = if x0 < self.size { x0 } else { 0 };
            let y0 = rows[lane].to_f64() as usize;
            let y0 = if y0 < self.size { y0 } else { 0 };
            let x1 = if x0 + 1 == self.size { 0 } else { x0 + 1 };
            let y1 = if y0 + 1 == self.size { 0 } else { y0 + 1 };
            out[0][lane] = self.heights[y0 * self.size + x0];
            out[1][lane] = self.heights[y0 * self.size + x1];
            out[2][lane] = self.heights[y1 * self.size + x0];
            out[3][lane] = self.heights[y1 * self.size + x1];
        }
        [V::load(&out[0]), V::load(&out[1]), V::load(&out[2]), V::load(&out[3])]
    }
}
