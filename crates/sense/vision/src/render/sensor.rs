//! From light to bytes: lens, exposure, noise.

use super::noise::{hash, normals};
use super::vector::V3;
use crate::ColorImage;

/// What a color camera makes of the light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColorSensor {
    /// Factor of the light.
    pub gain: f32,
    /// Factors of red, green and blue: white balance.
    pub balance: V3,
    /// Deviation of the lens's blur `[px]`.
    pub blur_px: f32,
    /// Motion of the whole image during the exposure, to the right and down `[px]`: the camera turns.
    pub shake_px: [f32; 2],
    /// Deviation of the noise in the dark, of 1.
    pub dark_noise: f32,
    /// Deviation of the noise at full light, of 1; it grows with the root of the light.
    pub shot_noise: f32,
    /// Share of the light that is lost in the corners.
    pub vignette: f32,
    /// Numbers the noise.
    pub seed: u32,
}

impl Default for ColorSensor {
    /// A good camera in good light: some noise, a sharp lens.
    fn default() -> Self {
        Self {
            gain: 1.0,
            balance: [1.0; 3],
            blur_px: 0.4,
            shake_px: [0.0; 2],
            dark_noise: 0.004,
            shot_noise: 0.012,
            vignette: 0.1,
            seed: 0,
        }
    }
}

impl ColorSensor {
    /// The image of `width` by `height` pixels of light.
    pub(super) fn develop(&self, light: &mut Vec<V3>, width: usize, height: usize) -> ColorImage {
        if self.shake_px[0].hypot(self.shake_px[1]) > 0.5 {
            self.shake(light, width, height);
        }
        if self.blur_px > 0.15 {
            blur(light, width, height, self.blur_px);
        }
        let gains = self.balance.map(|b| b * self.gain);
        let normals = normals();
        let gamma = gamma();
        let mut data = Vec::with_capacity(3 * width * height);
        let (cx, cy) = (0.5 * width as f32, 0.5 * height as f32);
        let corner = 1.0 / (cx * cx + cy * cy);
        for (y, row) in light.chunks_exact(width).enumerate() {
            let dy2 = (y as f32 - cy).powi(2);
            for (x, pixel) in row.iter().enumerate() {
                let fall = 1.0 - self.vignette * corner * ((x as f32 - cx).powi(2) + dy2);
                let bits = hash((y * width + x) as u32 ^ self.seed.wrapping_mul(0x9e37_79b9));
                for k in 0..3 {
                    let signal = (pixel[k] * gains[k] * fall).clamp(0.0, 1.0);
                    let sigma = self.dark_noise + self.shot_noise * signal.sqrt();
                    let noise = normals[(bits >> (10 * k)) as usize & 4095];
                    let index = ((signal * 4095.0) as usize).min(4095);
                    let value = gamma[index] + noise * sigma;
                    data.push((value * 255.0 + 0.5).clamp(0.0, 255.0) as u8);
                }
            }
        }
        ColorImage { width, height, data }
    }

    /// The mean along the image's motion.
    fn shake(&self, light: &mut Vec<V3>, width: usize, height: usize) {
        let [dx, dy] = self.shake_px;
        let taps = (dx.hypot(dy).ceil() as usize + 1).min(24);
        let offsets: Vec<(i64, i64)> = (0..taps)
            .map(|i| {
                let t = i as f32 / (taps - 1) as f32 - 0.5;
                ((t * dx).round() as i64, (t * dy).round() as i64)
            })
            .collect();
        let mut out = Vec::with_capacity(light.len());
        let share = 1.0 / taps as f32;
        for y in 0..height as i64 {
            for x in 0..width as i64 {
                let mut sum = [0.0; 3];
                for (ox, oy) in &offsets {
                    let (sx, sy) =
                        ((x + ox).clamp(0, width as i64 - 1), (y + oy).clamp(0, height as i64 - 1));
                    let p = light[sy as usize * width + sx as usize];
                    for k in 0..3 {
                        sum[k] += p[k];
                    }
                }
                out.push(sum.map(|v| v * share));
            }
        }
        *light = out;
    }
}

/// Gaussian blur by five taps in each direction.
fn blur(light: &mut [V3], width: usize, height: usize, sigma: f32) {
    let weight = |d: f32| (-0.5 * (d / sigma).powi(2)).exp();
    let total = 1.0 + 2.0 * (weight(1.0) + weight(2.0));
    let [w0, w1, w2] = [1.0 / total, weight(1.0) / total, weight(2.0) / total];
    let mut across = Vec::with_capacity(light.len());
    for row in light.chunks_exact(width) {
        for x in 0..width {
            let at = |d: isize| row[x.saturating_add_signed(d).min(width - 1)];
            let (a, b, c, d, e) = (at(-2), at(-1), row[x], at(1), at(2));
            across.push([0, 1, 2].map(|k| w0 * c[k] + w1 * (b[k] + d[k]) + w2 * (a[k] + e[k])));
        }
    }
    for y in 0..height {
        let row = |d: isize| {
            let at = y.saturating_add_signed(d).min(height - 1) * width;
            &across[at..at + width]
        };
        let (a, b, c, d, e) = (row(-2), row(-1), row(0), row(1), row(2));
        let out = &mut light[y * width..(y + 1) * width];
        for x in 0..width {
            out[x] = [0, 1, 2].map(|k| w0 * c[x][k] + w1 * (b[x][k] + d[x][k]) + w2 * (a[x][k] + e[x][k]));
        }
    }
}

/// Light to the sRGB scale, 0 to 1, in 4096 steps (IEC 61966-2-1).
fn gamma() -> &'static [f32] {
    static GAMMA: std::sync::OnceLock<Vec<f32>> = std::sync::OnceLock::new();
    GAMMA.get_or_init(|| {
        (0..4096)
            .map(|i| {
                let light = i as f32 / 4095.0;
                if light <= 0.003_130_8 { 12.92 * light } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 }
            })
            .collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_becomes_srgb_with_the_noise_that_was_asked_for() {
        let sensor = ColorSensor {
            blur_px: 0.0,
            vignette: 0.0,
            dark_noise: 0.02,
            shot_noise: 0.0,
            ..ColorSensor::default()
        };
        let image = sensor.develop(&mut vec![[0.214; 3]; 10_000], 100, 100);
        let values: Vec<f64> = image.data.iter().map(|&v| f64::from(v)).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let deviation = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt();
        // Linear 0.214 is half of full scale.
        assert!((mean - 127.5).abs() < 1.0, "{mean}");
        assert!((deviation / 255.0 - 0.02).abs() < 0.002, "{deviation}");
    }

    #[test]
    fn blur_and_shake_keep_the_light_and_spread_it() {
        let point = || {
            let mut light = vec![[0.0; 3]; 21 * 21];
            light[10 * 21 + 10] = [1.0; 3];
            light
        };
        let mut light = point();
        blur(&mut light, 21, 21, 1.0);
        let sum: f32 = light.iter().map(|p| p[0]).sum();
        assert!((sum - 1.0).abs() < 1e-5 && light[220][0] < 0.2 && light[10 * 21 + 11][0] > 0.05);
        let mut light = point();
        ColorSensor { shake_px: [6.0, 0.0], ..ColorSensor::default() }.shake(&mut light, 21, 21);
        let row: Vec<usize> = (0..21).filter(|&x| light[10 * 21 + x][0] > 0.0).collect();
        assert_eq!((row.first(), row.last()), (Some(&7), Some(&13)));
    }
}
