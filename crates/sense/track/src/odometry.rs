//! Where the robot believes to be.

use paid_lanes::rng::Rng;
use paid_lanes::{Mat3, Quat, Real, Vec3};
use serde::{Deserialize, Serialize};

use crate::ValueError;
use crate::error::{range_within, within};

/// Errors of odometry. Ranges are drawn from for each episode; equal ends give a constant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OdometryPreset {
    /// Length of the constant error of the position, in a random direction `[m]`. Default 0.01.
    pub offset_m: [f64; 2],
    /// Speed at which the position drifts, in a random direction `[m/s]`. Default 0.01: leg odometry of a walking humanoid.
    pub drift_m_s: [f64; 2],
    /// Speed at which the heading drifts, to a random side `[degrees/s]`. Default 0.23: the bias of a consumer gyroscope.
    pub heading_drift_deg_s: [f64; 2],
    /// Standard deviation of white noise on x and y `[m]`. Default 0.001.
    pub jitter_m: f64,
    /// Standard deviation of white noise on the heading `[degrees]`. Default 0.05.
    pub jitter_deg: f64,
}

impl Default for OdometryPreset {
    fn default() -> Self {
        Self {
            offset_m: [0.01; 2],
            drift_m_s: [0.01; 2],
            heading_drift_deg_s: [0.23; 2],
            jitter_m: 0.001,
            jitter_deg: 0.05,
        }
    }
}

impl OdometryPreset {
    /// Checks every value.
    ///
    /// # Errors
    /// The first value that is out of range.
    pub fn check(&self) -> Result<(), ValueError> {
        range_within("offset_m", self.offset_m, [0.0, 1.0], "0 to 1 m")?;
        range_within("drift_m_s", self.drift_m_s, [0.0, 1.0], "0 to 1 m/s")?;
        range_within("heading_drift_deg_s", self.heading_drift_deg_s, [0.0, 20.0], "0 to 20 degrees/s")?;
        within("jitter_m", self.jitter_m, [0.0, 1.0], "0 to 1 m")?;
        within("jitter_deg", self.jitter_deg, [0.0, 20.0], "0 to 20 degrees")
    }
}

/// Odometry with its errors, one robot a lane. Its frame is the world's, but for the errors: they are those of the base's estimated
/// pose. Height, roll and pitch are right.
#[derive(Clone, Debug)]
pub struct OdometryDrift<V> {
    offset: [V; 2],
    drift: [V; 2],
    heading_drift: V,
    elapsed_s: V,
    /// Error of x, y `[m]` and of the heading `[rad]` now.
    error: [V; 3],
}

impl<V: Real> Default for OdometryDrift<V> {
    fn default() -> Self {
        Self::new()
    }
}

impl<V: Real> OdometryDrift<V> {
    /// Odometry without errors.
    pub fn new() -> Self {
        let zero = V::zero();
        Self { offset: [zero; 2], drift: [zero; 2], heading_drift: zero, elapsed_s: zero, error: [zero; 3] }
    }

    /// Every number, for save and restore.
    pub fn fields(&mut self) -> [&mut V; 9] {
        let ([ox, oy], [dx, dy], [ex, ey, eh]) = (&mut self.offset, &mut self.drift, &mut self.error);
        [ox, oy, dx, dy, &mut self.heading_drift, &mut self.elapsed_s, ex, ey, eh]
    }

    /// Draws the errors of an episode for one lane. Odometry has run for `elapsed_s` `[s]` when the episode begins.
    pub fn begin_lane(&mut self, lane: usize, elapsed_s: f64, preset: &OdometryPreset, rng: &mut Rng) {
        let mut toward = |[lo, hi]: [f64; 2]| {
            let length = rng.uniform(lo, hi);
            let (s, c) = (core::f64::consts::TAU * rng.unit()).sin_cos();
            [length * c, length * s]
        };
        let (offset, drift) = (toward(preset.offset_m), toward(preset.drift_m_s));
        let [lo, hi] = preset.heading_drift_deg_s;
        let turn = rng.uniform(lo, hi).to_radians();
        let turn = if rng.unit() < 0.5 { -turn } else { turn };
        for k in 0..2 {
            self.offset[k].set_lane(lane, offset[k]);
            self.drift[k].set_lane(lane, drift[k]);
            self.error[k].set_lane(lane, elapsed_s.mul_add(drift[k], offset[k]));
        }
        self.heading_drift.set_lane(lane, turn);
        self.elapsed_s.set_lane(lane, elapsed_s);
        self.error[2].set_lane(lane, elapsed_s * turn);
    }

    /// Time passes, `dt_s` `[s]`; `normal` are three standard normal numbers.
    #[inline(always)]
    pub fn advance(&mut self, dt_s: V, normal: [V; 3], preset: &OdometryPreset) {
        self.elapsed_s += dt_s;
        let jitter = V::c(preset.jitter_m);
        for k in 0..2 {
            self.error[k] = self.drift[k].mul_add(self.elapsed_s, normal[k].mul_add(jitter, self.offset[k]));
        }
        let turn = normal[2] * V::c(preset.jitter_deg.to_radians());
        self.error[2] = self.heading_drift.mul_add(self.elapsed_s, turn);
    }

    /// Sine and cosine of the heading's error.
    #[inline(always)]
    fn turn(&self) -> (V, V) {
        self.error[2].sin_cos()
    }

    /// The estimated pose of a base whose true origin is `pos` `[m]` and whose true axes are `rot`.
    #[inline(always)]
    pub fn pose(&self, pos: Vec3<V>, rot: &Mat3<V>) -> (Vec3<V>, Mat3<V>) {
        let zero = V::zero();
        let turn = Quat::from_roll_pitch_yaw(zero, zero, self.error[2]).to_mat();
        (pos + Vec3([self.error[0], self.error[1], zero]), turn.mul_mat(rot))
    }

    /// Where odometry puts what truly is at `point` (x, y) `[m]`, and was measured from a base whose true origin is `base` `[m]`.
    #[inline(always)]
    pub fn placed(&self, point: [V; 2], base: [V; 2]) -> [V; 2] {
        let (s, c) = self.turn();
        let (x, y) = (point[0] - base[0], point[1] - base[1]);
        [
            s.neg_mul_add(y, c.mul_add(x, base[0] + self.error[0])),
            s.mul_add(x, c.mul_add(y, base[1] + self.error[1])),
        ]
    }

    /// Error of x, y `[m]` and of the heading `[rad]` in one lane.
    pub fn error(&self, lane: usize) -> [f64; 3] {
        self.error.map(|e| e.lane(lane))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn begun(preset: &OdometryPreset, elapsed_s: f64) -> OdometryDrift<f64> {
        let mut odometry = OdometryDrift::new();
        odometry.begin_lane(0, elapsed_s, preset, &mut Rng::new(3, 0, 0));
        odometry
    }

    #[test]
    fn position_and_heading_drift_at_their_speeds_from_the_offset() {
        let preset = OdometryPreset { jitter_m: 0.0, jitter_deg: 0.0, ..OdometryPreset::default() };
        let mut odometry = begun(&preset, 0.0);
        let level = Mat3::identity();
        let start = odometry.pose(Vec3([2.0, 1.0, 0.8]), &level).0 - Vec3([2.0, 1.0, 0.8]);
        assert!((start.norm() - 0.01).abs() < 1e-12 && start.z() == 0.0, "{start:?}");
        for _ in 0..100 {
            odometry.advance(0.02, [0.0; 3], &preset);
        }
        let (pos, rot) = odometry.pose(Vec3([2.0, 1.0, 0.8]), &level);
        let moved = pos - Vec3([2.0, 1.0, 0.8]) - start;
        assert!((moved.norm() - 0.02).abs() < 1e-12, "{moved:?}");
        assert!((rot.yaw().abs().to_degrees() - 0.46).abs() < 1e-9, "{}", rot.yaw());
        // An episode that begins after two seconds has drifted as far.
        let later = begun(&preset, 2.0).pose(Vec3([2.0, 1.0, 0.8]), &level);
        assert!((later.0 - pos).norm() < 1e-12 && (later.1.yaw() - rot.yaw()).abs() < 1e-12);
    }

    #[test]
    fn what_a_base_measures_is_placed_by_its_estimated_pose() {
        let mut odometry = begun(&OdometryPreset::default(), 5.0);
        odometry.advance(0.02, [1.0, -2.0, 0.5], &OdometryPreset::default());
        let rot = Quat::from_roll_pitch_yaw(0.1, 0.2, 0.7).to_mat();
        let (base, ball) = (Vec3([1.0, 2.0, 0.7]), Vec3([1.8, 1.5, 0.1]));
        let (pos, turned) = odometry.pose(base, &rot);
        let expected = pos + turned.mul_vec(rot.tr_mul_vec(ball - base));
        let placed = odometry.placed([ball.x(), ball.y()], [base.x(), base.y()]);
        assert!((placed[0] - expected.x()).abs() < 1e-12 && (placed[1] - expected.y()).abs() < 1e-12);
        assert!((expected.z() - ball.z()).abs() < 1e-12);
    }

    #[test]
    fn jitter_is_white_noise_of_its_size() {
        let still = [0.0; 2];
        let preset = OdometryPreset {
            offset_m: still,
            drift_m_s: still,
            heading_drift_deg_s: still,
            jitter_m: 0.02,
            jitter_deg: 1.0,
        };
        let mut odometry = begun(&preset, 0.0);
        odometry.advance(0.02, [1.0, -0.5, 2.0], &preset);
        let (pos, rot) = odometry.pose(Vec3::zero(), &Mat3::identity());
        assert!((pos.x() - 0.02).abs() < 1e-12 && (pos.y() + 0.01).abs() < 1e-12);
        assert!((rot.yaw().to_degrees() - 2.0).abs() < 1e-9);
        odometry.advance(0.02, [0.0; 3], &preset);
        assert_eq!(odometry.pose(Vec3::zero(), &Mat3::identity()).0.0, [0.0; 3]);
    }
}
