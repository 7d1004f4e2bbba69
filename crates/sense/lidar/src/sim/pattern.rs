//! Where the simulated LiDAR looks: a rosette that never closes.

use nalgebra::Vector3;

/// Lowest and highest elevation of a Mid-360 `[deg]`.
const ELEVATION_DEG: (f64, f64) = (-7.0, 52.0);
/// Revolutions of the mirror `[1/s]`, and swings of elevation for one revolution: irrational, so no ray repeats.
const REVOLUTIONS: f64 = 10.0;
const SWINGS: f64 = 20.0 * 1.618_033_988_749_895;

/// Directions over time. Our own design with the field of view and the rate of a Mid-360, not its optics.
#[derive(Clone, Copy, Debug)]
pub struct Pattern {
    /// Points a second.
    pub points_per_s: f64,
}

impl Pattern {
    /// Unit vector of ray number `index` in the LiDAR frame.
    #[must_use]
    pub fn ray(&self, index: u64) -> Vector3<f64> {
        let turns = index as f64 / self.points_per_s * REVOLUTIONS;
        // Four beams, a quarter of the elevation apart, take turns.
        let beam = (index % 4) as f64 * 0.25;
        let swing = (turns * SWINGS + beam).fract();
        let triangle = 1.0 - (2.0 * swing - 1.0).abs();
        let (low, high) = ELEVATION_DEG;
        let elevation = (low + (high - low) * triangle).to_radians();
        let azimuth = core::f64::consts::TAU * turns.fract();
        Vector3::new(elevation.cos() * azimuth.cos(), elevation.cos() * azimuth.sin(), elevation.sin())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_scan_covers_the_field_of_view_and_the_next_takes_other_rays() {
        let pattern = Pattern { points_per_s: 200_000.0 };
        let mut cells = std::collections::BTreeSet::new();
        for i in 0..20_000 {
            let ray = pattern.ray(i);
            let elevation = ray.z.asin().to_degrees();
            assert!((-7.01..=52.01).contains(&elevation), "{elevation}");
            let azimuth = ray.y.atan2(ray.x).to_degrees();
            cells.insert(((azimuth / 10.0).floor() as i32, (elevation / 10.0).floor() as i32));
        }
        // 36 x 7 cells of 10 degrees, the first and last row in part.
        assert!(cells.len() >= 36 * 6, "{}", cells.len());
        let same =
            (0..20_000_u64).filter(|&i| pattern.ray(i).dot(&pattern.ray(i + 20_000)) > 0.999_99).count();
        assert!(same < 2000, "{same}");
    }
}
