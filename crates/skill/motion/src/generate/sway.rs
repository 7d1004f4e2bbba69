//! The path of the center of mass that puts the center of pressure where the plan has it.

/// One axis of the cart-table problem (Kajita et al. 2003), all frames at once.
///
/// Minimizes the squared distance of `x - c x''` to `wanted` plus a small weight on jerk, with `x''` the second difference
/// as [`crate::balance`] takes it. `c` is height over vertical acceleration with gravity `[s^2]`, a value a frame; `ends` is the
/// rest position of the first and last three frames `[m]`. Without the jerk's weight, short peaks of `wanted` (a leg that is
/// thrown forward) would need accelerations that legs cannot give.
pub fn sway(wanted: &[f64], c: &[f64], ends: [f64; 2], dt: f64) -> Vec<f64> {
    /// Jerk that costs as much as a meter of pressure `[m/s^3]`.
    const JERK: f64 = 8e3;
    let frames = wanted.len();
    let free = frames.saturating_sub(6);
    let fixed = |k: usize| if k < 3 { ends[0] } else { ends[1] };
    let mut band = Band { rows: vec![[0.0; 4]; free], right: vec![0.0; free] };
    let mut add = |entries: &[(usize, f64)], value: f64, weight: f64| {
        let known: f64 =
            entries.iter().filter(|(k, _)| *k < 3 || *k >= frames - 3).map(|&(k, e)| e * fixed(k)).sum();
        for &(i, ei) in entries.iter().filter(|(k, _)| (3..frames - 3).contains(k)) {
            band.right[i - 3] += weight * ei * (value - known);
            for &(j, ej) in entries.iter().filter(|(k, _)| (3..=i).contains(k)) {
                band.rows[i - 3][i - j] += weight * ei * ej;
            }
        }
    };
    for k in 1..frames.saturating_sub(1) {
        let pull = c[k] / (dt * dt);
        add(&[(k - 1, -pull), (k, 1.0 + 2.0 * pull), (k + 1, -pull)], wanted[k], 1.0);
    }
    let smooth = (1.0 / (JERK * dt * dt * dt)).powi(2);
    for k in 0..frames.saturating_sub(3) {
        add(&[(k, -1.0), (k + 1, 3.0), (k + 2, -3.0), (k + 3, 1.0)], 0.0, smooth);
    }
    let middle = band.solve();
    (0..frames).map(|k| if k < 3 || k >= frames - 3 { fixed(k) } else { middle[k - 3] }).collect()
}

/// A symmetric positive definite system of half bandwidth 3; `rows[i][d]` is element `(i, i - d)`.
struct Band {
    rows: Vec<[f64; 4]>,
    right: Vec<f64>,
}

impl Band {
    /// Cholesky factorization within the band.
    fn solve(mut self) -> Vec<f64> {
        let n = self.rows.len();
        for i in 0..n {
            for d in (0..=3.min(i)).rev() {
                let j = i - d;
                let mut sum = self.rows[i][d];
                for k in i.saturating_sub(3).max(j.saturating_sub(3))..j {
                    sum -= self.rows[i][i - k] * self.rows[j][j - k];
                }
                self.rows[i][d] = if d == 0 { sum.max(1e-300).sqrt() } else { sum / self.rows[j][0] };
            }
        }
        for i in 0..n {
            for k in i.saturating_sub(3)..i {
                self.right[i] -= self.rows[i][i - k] * self.right[k];
            }
            self.right[i] /= self.rows[i][0];
        }
        for i in (0..n).rev() {
            for k in i + 1..(i + 4).min(n) {
                self.right[i] -= self.rows[k][k - i] * self.right[k];
            }
            self.right[i] /= self.rows[i][0];
        }
        self.right
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::min_jerk;

    #[test]
    fn the_center_of_mass_leads_so_that_the_pressure_follows_the_plan() {
        let (dt, frames) = (0.02, 300);
        let wanted: Vec<f64> = (0..frames).map(|k| 0.2 * min_jerk((k as f64 * dt - 2.0) / 0.3)).collect();
        let c = vec![0.7 / 9.81; frames];
        let x = sway(&wanted, &c, [0.0, 0.2], dt);
        for k in 1..frames - 1 {
            let p = x[k] - c[k] * (x[k - 1] - 2.0 * x[k] + x[k + 1]) / (dt * dt);
            assert!((p - wanted[k]).abs() < 0.012, "frame {k}: {p} for {}", wanted[k]);
        }
        assert!(x[105] > wanted[105] + 0.02, "it moves before the pressure does");
        assert_eq!((x[0], x[2], x[299]), (0.0, 0.0, 0.2));
    }

    #[test]
    fn a_constant_plan_is_kept() {
        for x in sway(&[0.3; 40], &[0.07; 40], [0.3, 0.3], 0.02) {
            assert!((x - 0.3).abs() < 1e-12);
        }
    }
}
