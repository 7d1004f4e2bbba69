//! Interpolation and differences of unit quaternions (w, x, y, z).

use paid_lanes::Quat;

/// The rotation a share `s` of the way from `a` to `b` along the shorter arc, at constant angular velocity.
pub fn slerp(a: [f64; 4], b: [f64; 4], s: f64) -> [f64; 4] {
    let log = rotation_log(a, b);
    let turn = exp([log[0] * s, log[1] * s, log[2] * s]);
    Quat(turn).mul(Quat(a)).normalize().0
}

/// The rotation vector `[rad]`, world axes, that turns `from` into `to`: `to = exp(v) from`, |v| at most pi.
pub fn rotation_log(from: [f64; 4], to: [f64; 4]) -> [f64; 3] {
    let Quat([mut w, mut x, mut y, mut z]) = Quat(to).mul(Quat(from).conj());
    if w < 0.0 {
        [w, x, y, z] = [-w, -x, -y, -z];
    }
    let sin = (x * x + y * y + z * z).sqrt();
    // angle / sin(angle/2) tends to 2 for small angles.
    let scale = if sin < 1e-9 { 2.0 } else { 2.0 * sin.atan2(w) / sin };
    [x * scale, y * scale, z * scale]
}

/// The unit quaternion of a rotation vector `[rad]`.
fn exp(v: [f64; 3]) -> [f64; 4] {
    let angle = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    let scale = if angle < 1e-9 { 0.5 } else { (0.5 * angle).sin() / angle };
    [(0.5 * angle).cos(), v[0] * scale, v[1] * scale, v[2] * scale]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn about_z(angle: f64) -> [f64; 4] {
        [(angle / 2.0).cos(), 0.0, 0.0, (angle / 2.0).sin()]
    }

    #[test]
    fn halfway_between_two_headings_is_their_mean() {
        let mid = slerp(about_z(0.2), about_z(1.0), 0.5);
        for (found, expected) in mid.iter().zip(about_z(0.6)) {
            assert!((found - expected).abs() < 1e-12);
        }
    }

    #[test]
    fn a_quaternion_and_its_negative_are_the_same_orientation() {
        let minus = about_z(0.4).map(|c| -c);
        let log = rotation_log(about_z(0.1), minus);
        assert!((log[2] - 0.3).abs() < 1e-12, "{log:?}");
        assert_eq!([log[0], log[1]], [0.0, 0.0]);
    }

    #[test]
    fn equal_orientations_differ_by_nothing() {
        assert!(rotation_log(about_z(0.7), about_z(0.7))[2].abs() < 1e-15);
        assert_eq!(slerp(about_z(0.0), about_z(0.0), 0.3), [1.0, 0.0, 0.0, 0.0]);
    }
}
