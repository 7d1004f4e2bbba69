//! The shape of the ground, and where it lies below a point.

use std::f64::consts::TAU;
use std::fmt::Write;

use paid_lanes::rng::Rng;
use paid_physics::Terrain;

/// Distance of the grid points of rough ground `[m]`, and how many a side has: those of Stage I.
const CELL_M: f64 = 0.1;
const SIZE: usize = 128;
/// Periods of rough ground a side in MuJoCo. The field follows the robot in steps of a period, so 12.8 m lie beyond it on every side.
const PERIODS: usize = 3;
/// Thickness of rough ground below its lowest point `[m]`: a body that is deeper falls through.
const THICKNESS_M: f64 = 0.5;
/// Random stream of a slope's direction.
const STREAM: u32 = 0x510b;
/// Odd, so that every trial has another seed of heights.
const SPREAD: u64 = 0x9e37_79b9_7f4a_7c15;
/// Sample points of a cell's side where a ball is put on rough ground; all grid points are among them.
const SAMPLES: usize = 10;

/// Shape of the ground.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Ground {
    /// z = 0.
    #[default]
    Flat,
    /// A plane through the origin.
    Slope {
        /// Against the horizontal, at least 0 and below a right angle `[rad]`.
        angle_rad: f64,
        /// Direction of steepest descent about z, against x `[rad]`.
        downhill_rad: f64,
    },
    /// Heights as in Stage I: every 0.1 m one of minus `amplitude_m`, 0 and `amplitude_m`, with a period of 12.8 m. Between them are two
    /// triangles a cell, where the built-in engine interpolates bilinearly: both agree at the grid points and along the cells' sides.
    Rough {
        /// Height of a step, and of the highest points above 0 `[m]`.
        amplitude_m: f64,
        /// Seed of the heights.
        seed: u64,
    },
}

impl Ground {
    /// The same kind of ground for one trial: another direction of the slope, other heights.
    #[must_use]
    pub fn of_trial(self, seed: u64, trial: u32) -> Self {
        match self {
            Self::Flat => Self::Flat,
            Self::Slope { angle_rad, .. } => {
                Self::Slope { angle_rad, downhill_rad: Rng::new(seed, trial, STREAM).uniform(0.0, TAU) }
            }
            Self::Rough { amplitude_m, .. } => {
                Self::Rough { amplitude_m, seed: seed ^ (u64::from(trial) + 1).wrapping_mul(SPREAD) }
            }
        }
    }

    /// The same ground in the built-in engine; `None` for a slope, which it does not have.
    pub fn terrain(self) -> Option<Terrain> {
        match self {
            Self::Flat => Some(Terrain::Plane),
            Self::Slope { .. } => None,
            Self::Rough { amplitude_m, seed } => {
                Some(Terrain::Rough { amplitude_m, step_m: amplitude_m, cell_m: CELL_M, size: SIZE, seed })
            }
        }
    }
}

/// The ground, ready to be asked for heights.
#[derive(Clone, Debug)]
pub(crate) enum Surface {
    /// A plane through the origin with this normal.
    Plane([f64; 3]),
    /// Heights of rough ground `[m]`, row-major `[y][x]`.
    Grid(Vec<f64>),
}

impl Surface {
    pub(crate) fn new(ground: Ground) -> Self {
        match ground {
            Ground::Flat => Self::Plane([0.0, 0.0, 1.0]),
            Ground::Slope { angle_rad, downhill_rad } => {
                let ((s, c), (y, x)) = (angle_rad.sin_cos(), downhill_rad.sin_cos());
                Self::Plane([s * x, s * y, c])
            }
            Ground::Rough { .. } => {
                let heights = ground.terrain().and_then(|terrain| terrain.heights().ok());
                Self::Grid(heights.unwrap_or_else(|| vec![0.0; SIZE * SIZE]))
            }
        }
    }

    /// Height `[m]` at grid point (i, j), counted along x and y from the origin.
    fn grid_point(heights: &[f64], [i, j]: [i64; 2]) -> f64 {
        let wrap = |k: i64| k.rem_euclid(SIZE as i64) as usize;
        heights[wrap(j) * SIZE + wrap(i)]
    }

    /// Height `[m]` of the ground at a world point `[m]`; any number where the point is not finite.
    pub(crate) fn height(&self, [x, y]: [f64; 2]) -> f64 {
        match self {
            Self::Plane([0.0, 0.0, _]) => 0.0,
            Self::Plane([nx, ny, nz]) => -(nx * x + ny * y) / nz,
            Self::Grid(heights) => {
                let (u, v) = (x / CELL_M, y / CELL_M);
                let (s, t) = (u - u.floor(), v - v.floor());
                let (i, j) = (u.floor() as i64, v.floor() as i64);
                // A place that is infinite is the largest number.
                let at = |di, dj| Self::grid_point(heights, [i.wrapping_add(di), j.wrapping_add(dj)]);
                // MuJoCo divides a cell from its corner of least x and y to the opposite one.
                let (low, high) = (at(0, 0), at(1, 1));
                if t > s {
                    let side = at(0, 1);
                    low + t * (side - low) + s * (high - side)
                } else {
                    let side = at(1, 0);
                    low + s * (side - low) + t * (high - side)
                }
            }
        }
    }

    /// Height `[m]` of the center of a ball of radius `radius` `[m]` that touches the ground and has its center above a world point.
    fn ball_height(&self, xy: [f64; 2], radius: f64) -> f64 {
        match self {
            Self::Plane([.., nz]) => self.height(xy) + radius / nz,
            Self::Grid(_) => {
                let step = CELL_M / SAMPLES as f64;
                let within =
                    |x: f64| ((x - radius) / step).ceil() as i64..=((x + radius) / step).floor() as i64;
                let mut highest = self.height(xy) + radius;
                for j in within(xy[1]) {
                    for i in within(xy[0]) {
                        let point = [i as f64 * step, j as f64 * step];
                        let off = (point[0] - xy[0]).hypot(point[1] - xy[1]);
                        if off < radius {
                            highest = highest.max(self.height(point) + (radius * radius - off * off).sqrt());
                        }
                    }
                }
                highest
            }
        }
    }

    /// Center of a ball that touches the ground at a world point; one that is to lie `still` is put into the dip below that point.
    pub(crate) fn ball(&self, xy: [f64; 2], radius: f64, still: bool) -> [f64; 3] {
        let mut at = (xy, self.ball_height(xy, radius));
        if still && matches!(self, Self::Grid(_)) {
            for step in [0.01, 0.002] {
                loop {
                    let next = (0..8)
                        .map(|k| {
                            let (y, x) = (f64::from(k) * TAU / 8.0).sin_cos();
                            let xy = [at.0[0] + step * x, at.0[1] + step * y];
                            (xy, self.ball_height(xy, radius))
                        })
                        .min_by(|a, b| a.1.total_cmp(&b.1));
                    match next.filter(|next| next.1 < at.1) {
                        Some(next) => at = next,
                        None => break,
                    }
                }
            }
        }
        [at.0[0], at.0[1], at.1]
    }

    /// Where the middle of rough ground is to lie for a robot at `xy` `[m]`; `None` for ground without an end.
    pub(crate) fn middle(&self, xy: [f64; 2]) -> Option<[f64; 2]> {
        let period = CELL_M * SIZE as f64;
        let finite = xy.iter().all(|x| x.is_finite());
        (matches!(self, Self::Grid(_)) && finite).then(|| xy.map(|x| (x / period).round() * period))
    }

    /// The orientation of the floor's plane in MJCF; nothing for flat ground.
    pub(crate) fn mjcf_plane(&self) -> String {
        match self {
            Self::Plane([nx, ny, nz]) if *nz < 1.0 => format!(r#" zaxis="{nx} {ny} {nz}""#),
            _ => String::new(),
        }
    }

    /// Rough ground as an asset of MJCF with the name `name`, and the height of its body `[m]`; `None` for a plane.
    pub(crate) fn mjcf_field(&self, name: &str) -> Option<(String, f64)> {
        let Self::Grid(heights) = self else { return None };
        let (low, high) =
            heights.iter().fold((f64::MAX, f64::MIN), |(low, high), &h| (low.min(h), high.max(h)));
        let range = (high - low).max(f64::MIN_POSITIVE);
        let points = PERIODS * SIZE + 1;
        let half = CELL_M * (PERIODS * SIZE) as f64 / 2.0;
        let mut out = format!(
            r#"  <asset><hfield name="{name}" nrow="{points}" ncol="{points}" size="{half} {half} {range} {THICKNESS_M}" elevation=""#
        );
        let first = -((PERIODS * SIZE / 2) as i64);
        // The text has the row of the greatest y first.
        for j in (0..points as i64).rev() {
            for i in 0..points as i64 {
                let share = (Self::grid_point(heights, [first + i, first + j]) - low) / range;
                let _ = write!(out, "{share} ");
            }
        }
        out.truncate(out.trim_end().len());
        out += "\"/></asset>\n";
        Some((out, low))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Heights by grid point, row-major from the origin.
    fn grid(height: impl Fn(i64, i64) -> f64) -> Surface {
        // Points of the second half lie to the other side of the origin.
        let from_origin = |k: usize| if k < SIZE / 2 { k as i64 } else { k as i64 - SIZE as i64 };
        let points = (0..SIZE * SIZE).map(|n| height(from_origin(n % SIZE), from_origin(n / SIZE)));
        Surface::Grid(points.collect())
    }

    #[track_caller]
    fn close(found: f64, expected: f64) {
        assert!((found - expected).abs() < 1e-9, "{found}, expected {expected}");
    }

    #[test]
    fn a_slope_falls_by_its_tangent() {
        let slope = Surface::new(Ground::Slope { angle_rad: 4_f64.to_radians(), downhill_rad: TAU / 4.0 });
        // Downhill is along y: tan 4 degrees is 0.0699268.
        assert!((slope.height([3.0, 1.0]) + 0.069_926_8).abs() < 1e-6);
        assert!((slope.height([3.0, -2.0]) - 0.139_853_6).abs() < 1e-6);
        // A ball of 0.11 m above the origin is 0.11 / cos 4 degrees high.
        assert!((slope.ball([0.0; 2], 0.11, true)[2] - 0.110_268_6).abs() < 1e-6);
        assert_eq!(slope.middle([50.0; 2]), None);
        let flat = Surface::new(Ground::Flat);
        assert_eq!((flat.height([3.0, 1.0]), flat.ball([3.0, 1.0], 0.11, true)), (0.0, [3.0, 1.0, 0.11]));
    }

    #[test]
    fn a_cell_is_two_triangles() {
        let ground = grid(|i, j| match (i, j) {
            (1, 0) => 0.01,
            (0, 1) => 0.02,
            (1, 1) => 0.04,
            _ => 0.0,
        });
        for (at, height) in [
            ([0.0, 0.0], 0.0),
            ([0.1, 0.0], 0.01),
            ([0.0, 0.1], 0.02),
            ([0.1, 0.1], 0.04),
            // The diagonal from the least to the greatest corner.
            ([0.05, 0.05], 0.02),
            // Below it 0.5 of the way to (1, 0) and 0.25 from there to (1, 1); above it the same by (0, 1).
            ([0.05, 0.025], 0.5 * 0.01 + 0.25 * 0.03),
            ([0.025, 0.05], 0.5 * 0.02 + 0.25 * 0.02),
            // A period of 12.8 m further.
            ([12.85, -12.75], 0.02),
        ] {
            assert!((ground.height(at) - height).abs() < 1e-9, "{at:?}: {}", ground.height(at));
        }
        // The place of a robot whose state is not finite: no panic.
        assert!(ground.height([f64::NAN, f64::INFINITY]).is_nan());
    }

    #[test]
    fn a_ball_that_is_to_lie_still_lies_in_a_dip() {
        // A valley along y with sides of slope 0.2: the ball touches both when its center is sqrt(1.04) radii above the bottom.
        let valley = grid(|i, _| 0.02 * i.abs().min(5) as f64);
        let [x, y, z] = valley.ball([0.13, 0.4], 0.11, true);
        assert!(x.abs() < 0.002 && (y - 0.4).abs() < 0.02, "{x} {y}");
        assert!((z - 0.11 * 1.04_f64.sqrt()).abs() < 5e-4, "{z}");
        // One that rolls begins where it was put: 0.13 * 0.2 up the side.
        let [x, y, z] = valley.ball([0.23, 0.4], 0.11, false);
        assert_eq!([x, y], [0.23, 0.4]);
        assert!((z - (0.046 + 0.11 * 1.04_f64.sqrt())).abs() < 5e-4, "{z}");
    }

    #[test]
    fn every_trial_has_its_own_ground() {
        let rough = Ground::Rough { amplitude_m: 0.02, seed: 0 };
        let slope = Ground::Slope { angle_rad: 0.07, downhill_rad: 0.0 };
        for ground in [rough, slope] {
            assert_eq!(ground.of_trial(3, 7), ground.of_trial(3, 7));
            assert_ne!(ground.of_trial(3, 7), ground.of_trial(3, 8));
            assert_ne!(ground.of_trial(3, 7), ground.of_trial(4, 7));
        }
        assert_eq!(Ground::Flat.of_trial(3, 7), Ground::Flat);
        assert_eq!((Ground::Flat.terrain(), slope.terrain()), (Some(Terrain::Plane), None));
    }

    #[test]
    fn rough_ground_has_three_heights_and_follows_by_periods() {
        let ground = Surface::new(Ground::Rough { amplitude_m: 0.03, seed: 9 });
        let Surface::Grid(heights) = &ground else { panic!("no grid") };
        let share = |height: f64| {
            let count = heights.iter().filter(|h| (**h - height).abs() < 1e-12).count();
            count as f64 / heights.len() as f64
        };
        // Uniform within 3 cm and rounded to 3 cm: a quarter, a half, a quarter.
        for (height, expected) in [(-0.03, 0.25), (0.0, 0.5), (0.03, 0.25)] {
            assert!((share(height) - expected).abs() < 0.02, "{height}: {}", share(height));
        }
        let middle = ground.middle([6.5, -20.0]).expect("rough");
        close(middle[0], 12.8);
        close(middle[1], -25.6);
        assert_eq!(ground.middle([f64::NAN, 0.0]), None);
    }
}
