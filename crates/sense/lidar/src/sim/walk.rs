//! How the torso of a walking, kicking robot moves.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use paid_lanes::rng::Rng;

use crate::sim::scene::SceneKind;

/// A motion of the torso.
pub trait Trajectory {
    /// Pose of the torso in the scene at `time_s` `[s]`: z up, x ahead.
    fn pose(&self, time_s: f64) -> Isometry3<f64>;

    /// How far arms and legs swing, from -1 to 1.
    fn swing(&self, time_s: f64) -> f64 {
        let _ = time_s;
        0.0
    }
}

/// Standing at the begin `[s]`.
const STAND_S: f64 = 2.0;
/// Time from kick to kick `[s]`.
const KICK_S: f64 = 7.5;
/// Time from step to step `[s]`.
const STEP_S: f64 = 0.5;
/// Duration of an impact `[s]`.
const IMPACT_S: f64 = 0.015;
/// Width of a kick's swing `[s]`.
const SWING_S: f64 = 0.15;
/// Height of a G1's torso frame `[m]`.
const HEIGHT_M: f64 = 0.82;

/// A walk with steps of 0.5 s, a kick every 7.5 s, sway, bob, a torso that turns, and impacts, of which an IMU of 200 Hz
/// sees 30 to 60 m/s^2. The robot stands
/// for 2 s, then its speed swings between zero (at the kicks) and twice the mean.
#[derive(Clone, Debug)]
pub struct Walk {
    path: Path,
    seed: u64,
}

#[derive(Clone, Copy, Debug)]
enum Path {
    /// `(a sin p, b sin 2p)`, p growing by `rate` `[rad/s]` in the mean.
    Eight { a: f64, b: f64, rate: f64 },
    /// Along x with this mean speed `[m/s]`.
    Straight { speed: f64 },
}

impl Walk {
    /// A walk that suits the scene.
    #[must_use]
    pub fn new(kind: SceneKind, seed: u64) -> Self {
        let path = match kind {
            // An eight of 28 m, so 0.7 m/s in the mean.
            SceneKind::Hall | SceneKind::People | SceneKind::Endless => {
                Path::Eight { a: 6.0, b: 3.5, rate: 0.155 }
            }
            SceneKind::Pitch => Path::Eight { a: 4.5, b: 2.5, rate: 0.2 },
            SceneKind::Corridor => Path::Straight { speed: 0.6 },
        };
        Self { path, seed }
    }

    /// Time since the start of the walk `[s]`, and how much the robot walks, from 0 to 1.
    fn phase(time_s: f64) -> (f64, f64) {
        let t = (time_s - STAND_S).max(0.0);
        (t, 0.5 - 0.5 * (core::f64::consts::TAU * t / KICK_S).cos())
    }

    fn draw(&self, event: u32, stream: u32) -> Rng {
        Rng::new(self.seed, event, stream)
    }
}

/// A jolt: 0 before, then `s^2 e^-s`; its second derivative begins with 2 at s = 0.
fn jolt(s: f64) -> f64 {
    if s > 0.0 { s * s * (-s).exp() } else { 0.0 }
}

impl Trajectory for Walk {
    fn pose(&self, time_s: f64) -> Isometry3<f64> {
        let tau = core::f64::consts::TAU;
        let (t, walks) = Self::phase(time_s);
        // The mean speed times (1 - cos) is zero with each kick.
        let progress = t - KICK_S / tau * (tau * t / KICK_S).sin();
        let (mut position, heading) = match self.path {
            Path::Eight { a, b, rate } => {
                let p = rate * progress;
                let place = Vector3::new(a * p.sin(), b * (2.0 * p).sin(), HEIGHT_M);
                (place, (2.0 * b * (2.0 * p).cos()).atan2(a * p.cos()))
            }
            Path::Straight { speed } => (Vector3::new(speed * progress, 0.0, HEIGHT_M), 0.0),
        };
        let step = tau * t / (2.0 * STEP_S);
        let mut yaw =
            heading + 0.09 * walks * step.sin() + 0.35 * (1.0 - (-t).exp()) * (tau * t / 11.0).sin();
        let mut pitch = 0.05 * walks + 0.035 * walks * (2.0 * step).cos();
        let mut roll = 0.05 * walks * step.sin();
        let mut shift = Vector3::new(
            0.01 * walks * (2.0 * step).sin(),
            0.025 * walks * step.sin(),
            0.02 * walks * (2.0 * step).cos(),
        );

        // Kicks: the torso turns back and through, leans, and stops.
        let kick = (t / KICK_S).round();
        if kick >= 1.0 {
            let since = t - kick * KICK_S;
            let u = since / SWING_S;
            let bell = (-0.5 * u * u).exp();
            yaw += 0.5 * u * bell;
            pitch += 0.15 * bell;
            roll += 0.1 * bell;
            shift.x += 0.05 * bell;
            let mut rng = self.draw(kick as u32, 51);
            let hit = Vector3::new(-130.0, rng.uniform(-60.0, 60.0), rng.uniform(-80.0, 80.0));
            shift += hit * (0.5 * IMPACT_S * IMPACT_S * jolt(since / IMPACT_S));
        }
        // Steps: the last two still ring.
        let newest = (t / STEP_S).floor();
        for number in [newest, newest - 1.0] {
            if number < 1.0 {
                continue;
            }
            let (_, walked) = Self::phase(STAND_S + number * STEP_S);
            let since = (t - number * STEP_S) / IMPACT_S;
            let mut rng = self.draw(number as u32, 50);
            let hit =
                Vector3::new(rng.uniform(-30.0, 30.0), rng.uniform(-20.0, 20.0), rng.uniform(70.0, 120.0));
            shift += hit * (walked.sqrt() * 0.5 * IMPACT_S * IMPACT_S * jolt(since));
            pitch += 0.01 * walked * jolt(since * 0.6);
        }
        // Standing is not rigid either.
        roll += 0.002 * (tau * 0.3 * time_s).sin();
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw);
        position += turn * shift;
        let rotation = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
        Isometry3::from_parts(Translation3::from(position), rotation)
    }

    fn swing(&self, time_s: f64) -> f64 {
        let (t, walks) = Self::phase(time_s);
        walks * (core::f64::consts::TAU * t / (2.0 * STEP_S)).sin()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_robot_stands_first_and_then_walks_and_kicks_with_impacts_beyond_4_g() {
        let walk = Walk::new(SceneKind::Hall, 7);
        let accel = |t: f64| {
            let h = 0.0005;
            let p = |t| walk.pose(t).translation.vector;
            ((p(t + h) - p(t) * 2.0 + p(t - h)) / (h * h)).norm()
        };
        assert!((0..180).all(|i| accel(0.1 + f64::from(i) * 0.01) < 0.1), "it stands");
        let most = (2000..20_000).map(|i| accel(f64::from(i) * 0.001)).fold(0.0, f64::max);
        assert!((90.0..220.0).contains(&most), "{most} m/s^2");
        let path: f64 = (0..600)
            .map(|i| {
                let p = |k: i32| walk.pose(f64::from(k) * 0.1).translation.vector.xy();
                (p(i + 1) - p(i)).norm()
            })
            .sum();
        assert!((35.0..70.0).contains(&path), "{path} m in 60 s");
    }

    #[test]
    fn the_pose_has_no_jumps() {
        for kind in SceneKind::ALL {
            let walk = Walk::new(kind, 3);
            for i in 0..20_000 {
                let (a, b) = (walk.pose(f64::from(i) * 0.001), walk.pose(f64::from(i + 1) * 0.001));
                assert!((a.translation.vector - b.translation.vector).norm() < 0.005, "{kind:?} at {i} ms");
                assert!(a.rotation.angle_to(&b.rotation) < 0.01, "{kind:?} at {i} ms");
            }
        }
    }
}
