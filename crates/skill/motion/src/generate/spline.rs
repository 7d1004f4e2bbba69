//! Smooth curves over time, continuous to the second derivative.

/// From 0 at `s = 0` to 1 at `s = 1` with least jerk, at rest and without acceleration at both ends (Flash and Hogan 1985).
pub fn min_jerk(s: f64) -> f64 {
    let s = s.clamp(0.0, 1.0);
    s * s * s * (10.0 + s * (6.0 * s - 15.0))
}

/// A bump from 0 over 1 at `s = 0.5` to 0, with first and second derivative zero at both ends.
pub fn bump(s: f64) -> f64 {
    let s = s.clamp(0.0, 1.0);
    64.0 * (s * (1.0 - s)).powi(3)
}

/// A point of a curve with its derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knot<const N: usize> {
    /// Time `[s]`.
    pub t: f64,
    /// Value.
    pub pos: [f64; N],
    /// First derivative.
    pub vel: [f64; N],
}

/// Quintic pieces between knots without acceleration there; constant before the first and after the last knot.
#[derive(Clone, Debug, PartialEq)]
pub struct Track<const N: usize>(Vec<Knot<N>>);

impl<const N: usize> Track<N> {
    /// Through knots in order of time.
    pub fn new(knots: Vec<Knot<N>>) -> Self {
        Self(knots)
    }

    /// At rest at every knot (time `[s]`, value).
    pub fn resting(knots: &[(f64, [f64; N])]) -> Self {
        Self(knots.iter().map(|&(t, pos)| Knot { t, pos, vel: [0.0; N] }).collect())
    }

    /// The value at time `t` `[s]`.
    pub fn at(&self, t: f64) -> [f64; N] {
        let after = self.0.partition_point(|k| k.t <= t);
        let (Some(a), b) = (self.0.get(after.saturating_sub(1)), self.0.get(after)) else { return [0.0; N] };
        let Some(b) = b.filter(|_| after > 0) else { return a.pos };
        let span = b.t - a.t;
        let s = (t - a.t) / span;
        let (s3, s4, s5) = (s.powi(3), s.powi(4), s.powi(5));
        let rise = 10.0 * s3 - 15.0 * s4 + 6.0 * s5;
        let start = s - 6.0 * s3 + 8.0 * s4 - 3.0 * s5;
        let end = -4.0 * s3 + 7.0 * s4 - 3.0 * s5;
        core::array::from_fn(|i| {
            a.pos[i] + (b.pos[i] - a.pos[i]) * rise + span * (a.vel[i] * start + b.vel[i] * end)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_track_meets_its_knots_with_value_velocity_and_no_acceleration() {
        let knots = vec![
            Knot { t: 0.2, pos: [1.0], vel: [0.0] },
            Knot { t: 0.5, pos: [2.0], vel: [4.0] },
            Knot { t: 0.9, pos: [0.0], vel: [-1.0] },
        ];
        let track = Track::new(knots.clone());
        let h = 1e-4;
        for knot in &knots[1..2] {
            let [a, b, c] = [-h, 0.0, h].map(|d| track.at(knot.t + d)[0]);
            assert!((b - knot.pos[0]).abs() < 1e-12);
            assert!(((c - a) / (2.0 * h) - knot.vel[0]).abs() < 1e-4);
            assert!(
                ((c - 2.0 * b + a) / (h * h)).abs() < 0.5,
                "second derivative {}",
                (c - 2.0 * b + a) / (h * h)
            );
        }
        assert_eq!(track.at(0.0), [1.0]);
        assert_eq!(track.at(2.0), [0.0]);
    }

    #[test]
    fn between_rests_a_track_is_the_curve_of_least_jerk() {
        let track = Track::resting(&[(1.0, [0.0]), (3.0, [2.0])]);
        for t in [1.0, 1.3, 2.0, 2.9] {
            assert!((track.at(t)[0] - 2.0 * min_jerk((t - 1.0) / 2.0)).abs() < 1e-12);
        }
        assert_eq!((bump(0.0), bump(0.5), bump(1.0)), (0.0, 1.0, 0.0));
    }
}
