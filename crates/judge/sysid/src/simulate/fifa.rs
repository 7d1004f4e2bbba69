//! Closed-form motion with the figures of FIFA's quality tests of balls and turf.

use paid_lanes::rng::Rng;

use crate::SysidError;

const GRAVITY: f64 = 9.81;
/// Height of the test's release, lowest point of the ball `[m]`.
pub const TEST_HEIGHT_M: f64 = 2.0;
/// Drop of the test's ramp: 1 m high, 45 degrees.
const RAMP_M: f64 = 1.0;
/// Moment of inertia of a football over m r^2.
const INERTIA: f64 = 2.0 / 3.0;
/// Repeats differ by this share (standard deviation).
const SPREAD: f64 = 0.02;
/// Bounces lower than this are over `[m]`.
const LOWEST_BOUNCE_M: f64 = 5e-4;
const STREAM: u32 = 2;

/// Speed of a ball that rolled down the test's ramp `[m/s]`.
pub fn ramp_speed() -> f64 {
    (2.0 * GRAVITY * RAMP_M / (1.0 + INERTIA)).sqrt()
}

/// Curves `[run][time]` `[m]` of drops and of rolls.
pub(crate) type Curves = (Vec<Vec<f64>>, Vec<Vec<f64>>);

/// A ground by the figures of its tests.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FifaFigures {
    /// Height that the ball rises to after a drop from 2 m `[m]`.
    pub rebound_m: f64,
    /// Distance that it rolls after the ramp `[m]`; `None` leaves rolls out.
    pub roll_m: Option<f64>,
}

impl FifaFigures {
    /// Turf: 0.60 to 0.85 m and 4 to 8 m are allowed; the middle.
    pub const TURF: Self = Self { rebound_m: 0.725, roll_m: Some(6.0) };
    /// A steel plate: 1.35 to 1.55 m; there is no figure for rolling on it.
    pub const STEEL: Self = Self { rebound_m: 1.45, roll_m: None };

    /// Heights and distances [run][time] [m]: a bouncing ball without air, and one that slows evenly.
    pub(crate) fn measure(
        &self,
        heights: &[f64],
        speeds: &[f64],
        times: &[f64],
        seed: u64,
    ) -> Result<Curves, SysidError> {
        if !(self.rebound_m > 0.0 && self.rebound_m < TEST_HEIGHT_M) {
            return Err(SysidError::option("rebound", "above 0, below 2 m", self.rebound_m));
        }
        if self.roll_m.is_some_and(|r| !(0.2..=100.0).contains(&r)) {
            return Err(SysidError::option("roll", "0.2 to 100 m", self.roll_m.unwrap_or_default()));
        }
        let mut rng = Rng::new(seed, 0, STREAM);
        let mut varied = |x: f64| x * (1.0 + SPREAD * rng.normal());
        let drops = heights
            .iter()
            .map(|h| {
                let share = (varied(self.rebound_m) / TEST_HEIGHT_M).clamp(0.0, 1.0);
                times.iter().map(|t| bouncing(*h, share.sqrt(), *t)).collect()
            })
            .collect();
        let rolls = self.roll_m.map_or_else(Vec::new, |length| {
            let one = |v: &f64| {
                let slowing = ramp_speed().powi(2) / (2.0 * varied(length));
                times.iter().map(|t| slowing_down(*v, slowing, *t)).collect()
            };
            speeds.iter().map(one).collect()
        });
        Ok((drops, rolls))
    }
}

/// Height at `t` of a ball released at `height`, restitution `e`.
fn bouncing(height: f64, e: f64, t: f64) -> f64 {
    let fall = (2.0 * height / GRAVITY).sqrt();
    if t < fall {
        return height - 0.5 * GRAVITY * t * t;
    }
    let (mut speed, mut since) = (e * GRAVITY * fall, t - fall);
    while speed * speed / (2.0 * GRAVITY) > LOWEST_BOUNCE_M {
        let flight = 2.0 * speed / GRAVITY;
        if since < flight {
            return (speed - 0.5 * GRAVITY * since) * since;
        }
        since -= flight;
        speed *= e;
    }
    0.0
}

/// Distance at `t` under the constant deceleration `slowing`.
fn slowing_down(speed: f64, slowing: f64, t: f64) -> f64 {
    let t = t.min(speed / slowing);
    speed.mul_add(t, -0.5 * slowing * t * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ball_rises_and_rolls_as_far_as_the_figures_say() {
        let e = (0.725_f64 / 2.0).sqrt();
        let highest = (0..2000)
            .map(|i| f64::from(i) * 0.001)
            .filter(|t| *t > (4.0 / GRAVITY).sqrt())
            .map(|t| bouncing(2.0, e, t))
            .fold(0.0, f64::max);
        assert!((highest - 0.725).abs() < 1e-4, "{highest}");
        assert!(bouncing(2.0, e, 30.0) == 0.0);
        let speed = ramp_speed();
        let slowing = speed * speed / 12.0;
        assert!((slowing_down(speed, slowing, 100.0) - 6.0).abs() < 1e-9);
        assert!((speed - 3.431).abs() < 1e-3, "{speed}");
    }

    #[test]
    fn steel_has_no_figure_for_rolling() {
        let (drops, rolls) = FifaFigures::STEEL.measure(&[2.0], &[2.0], &[0.0, 0.1], 0).expect("figures");
        assert_eq!((drops.len(), rolls.len()), (1, 0));
    }
}
