//! The depth image of a stereo camera.

use super::noise::{hash, normals};
use crate::{DepthImage, Intrinsics};

/// A stereo depth camera: noise that grows with the square of the distance, holes, steps.
///
/// Depth comes from the disparity `d = f b / z`. A disparity error of deviation `s` is a depth error of `s z^2 / (f b)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthSensor {
    /// Distance between the two imagers `[m]`.
    pub baseline_m: f32,
    /// Focal length at which disparities are matched `[px]`.
    pub focal_px: f32,
    /// Deviation of the disparity `[px]`. Neighbors err alike: the error is smooth over [`Self::patch_px`].
    pub disparity_noise_px: f32,
    /// Size of the patches that are matched, in pixels of the image.
    pub patch_px: f32,
    /// Steps per pixel of disparity.
    pub steps: f32,
    /// Nearest and farthest depth that is given `[m]`.
    pub range_m: [f32; 2],
    /// Share of patches without a match.
    pub holes: f32,
    /// Numbers the noise.
    pub seed: u32,
}

impl Default for DepthSensor {
    /// Intel RealSense D435i: baseline 50 mm, 848 pixels over 87 degrees, so f = 447 px, nearest depth 0.28 m at this size. RMS error of
    /// the disparity 0.08 px (the maker's figure for a textured wall: below 0.1 px); 32 steps a pixel.
    fn default() -> Self {
        Self {
            baseline_m: 0.05,
            focal_px: 447.0,
            disparity_noise_px: 0.08,
            patch_px: 4.0,
            steps: 32.0,
            range_m: [0.28, 10.0],
            holes: 0.02,
            seed: 0,
        }
    }
}

impl DepthSensor {
    /// Standard deviation of the depth of a single pixel `[m]` at a depth `[m]`.
    pub fn deviation(&self, depth: f64) -> f64 {
        f64::from(self.disparity_noise_px) * depth * depth / f64::from(self.focal_px * self.baseline_m)
    }

    /// What the camera gives for true depths `[m]` (infinity where there is nothing).
    pub(super) fn develop(&self, depths: &[f32], intrinsics: &Intrinsics) -> DepthImage {
        let (width, height) = (intrinsics.width, intrinsics.height);
        let scale = self.focal_px * self.baseline_m;
        // Shadow of the left imager in the right one: of near things to the left side, in pixels of this image.
        let shadow = self.baseline_m * intrinsics.focal[0] as f32;
        let normals = normals();
        let cells = (width as f32 / self.patch_px) as usize + 2;
        let rows = (height as f32 / self.patch_px) as usize + 2;
        let patch = |x: usize, y: usize| hash((y * cells + x) as u32 ^ self.seed.wrapping_mul(0x85eb_ca6b));
        let noise: Vec<f32> =
            (0..cells * rows).map(|i| normals[patch(i % cells, i / cells) as usize & 4095]).collect();
        let hole: Vec<bool> = (0..cells * rows)
            .map(|i| {
                (hash(patch(i % cells, i / cells) ^ 0x5bd1) >> 8) as f32 * (1.0 / 16_777_216.0) < self.holes
            })
            .collect();
        let mut data = vec![0_u16; width * height];
        for y in 0..height {
            let row = &depths[y * width..(y + 1) * width];
            let v = y as f32 / self.patch_px;
            let (v0, fv) = (v as usize, v.fract());
            // From the right: the nearest thing so far hides what is just left of it from the other imager.
            let mut hidden_from = f32::INFINITY;
            for x in (0..width).rev() {
                let depth = row[x];
                let inverse = 1.0 / depth;
                let place = x as f32 - shadow * inverse;
                if place >= hidden_from {
                    continue;
                }
                hidden_from = place;
                let u = x as f32 / self.patch_px;
                let (u0, fu) = (u as usize, u.fract());
                let i = v0 * cells + u0;
                if hole[i] || !(depth >= self.range_m[0] && depth <= self.range_m[1]) {
                    continue;
                }
                let top = noise[i] + fu * (noise[i + 1] - noise[i]);
                let low = noise[i + cells] + fu * (noise[i + cells + 1] - noise[i + cells]);
                // Bilinear interpolation shrinks the deviation to 2/3 on the average; 1.5 gives it back.
                let error = 1.5 * (top + fv * (low - top)) * self.disparity_noise_px;
                let disparity = ((scale * inverse + error) * self.steps).round() / self.steps;
                let seen = scale / disparity.max(1e-3);
                if seen >= self.range_m[0] && seen <= self.range_m[1] {
                    data[y * width + x] = (seen * 1000.0).round() as u16;
                }
            }
        }
        DepthImage { width, height, data }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wall(depth: f32, sensor: &DepthSensor) -> Vec<f64> {
        let intrinsics = Intrinsics::g1_color();
        let image = sensor.develop(&vec![depth; 424 * 240], &intrinsics);
        image.data.iter().filter(|mm| **mm > 0).map(|&mm| f64::from(mm) * 1e-3).collect()
    }

    #[test]
    fn the_error_of_a_wall_grows_with_the_square_of_its_distance() {
        let sensor = DepthSensor::default();
        for depth in [1.0_f32, 2.0, 3.0] {
            let seen = wall(depth, &sensor);
            let mean = seen.iter().sum::<f64>() / seen.len() as f64;
            let sigma = (seen.iter().map(|z| (z - mean).powi(2)).sum::<f64>() / seen.len() as f64).sqrt();
            // 0.08 px * z^2 / 22.35 px m = 3.6 mm z^2, plus the steps.
            let expected = sensor.deviation(f64::from(depth));
            assert!((0.85..1.25).contains(&(sigma / expected)), "{depth}: {sigma} {expected}");
            assert!((mean - f64::from(depth)).abs() < 0.2 * expected, "{mean}");
            let holes = 1.0 - seen.len() as f64 / (424.0 * 240.0);
            assert!((0.01..0.05).contains(&holes), "{holes}");
        }
        assert!(wall(0.2, &sensor).is_empty() && wall(f32::INFINITY, &sensor).is_empty());
    }

    #[test]
    fn a_near_thing_throws_a_hole_to_its_left() {
        let intrinsics = Intrinsics::g1_color();
        let sensor = DepthSensor { holes: 0.0, ..DepthSensor::default() };
        let mut depths = vec![3.0; 424 * 240];
        for row in depths.chunks_exact_mut(424) {
            row[200..240].fill(1.0);
        }
        let image = sensor.develop(&depths, &intrinsics);
        let row = &image.data[120 * 424..121 * 424];
        // 0.05 m * 308.5 px * (1 / 1 - 1 / 3) = 10.3 px.
        let hole: Vec<usize> = (150..300).filter(|&x| row[x] == 0).collect();
        assert_eq!((hole.first(), hole.last()), (Some(&190), Some(&199)), "{hole:?}");
    }
}
