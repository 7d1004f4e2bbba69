//! Which leg kicks, and when, from the motion alone.

use paid_lanes::Vec3;
use paid_robot::{RobotModel, RobotSpec};

use crate::{Clip, KickLeg};

/// A kick found in a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KickLabel {
    /// The leg with the faster foot.
    pub leg: KickLeg,
    /// The frame in which that foot's center of mass is fastest.
    pub frame: usize,
    /// Its speed there `[m/s]`.
    pub speed: f64,
}

/// The fastest moment of either foot; `None` if the robot lacks a foot that its TOML names.
pub fn fastest_kick(clip: &Clip, model: &RobotModel, spec: &RobotSpec) -> Option<KickLabel> {
    let mut best = KickLabel { leg: KickLeg::Right, frame: 0, speed: -1.0 };
    for leg in [KickLeg::Left, KickLeg::Right] {
        let foot = model.body_index(&spec.feet[leg.index()])?;
        for frame in 0..clip.frames {
            let speed = Vec3(clip.body_lin_vel(frame)[foot]).norm();
            if speed > best.speed {
                best = KickLabel { leg, frame, speed };
            }
        }
    }
    Some(best)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{model, spec, steady_clip};

    #[test]
    fn the_faster_foot_kicks() {
        let mut clip = steady_clip(20, 50.0, 0.0);
        clip.body_lin_vel[7 * clip.bodies + 1] = [3.0, 0.0, 4.0];
        clip.body_lin_vel[9 * clip.bodies + 2] = [2.0, 0.0, 4.0];
        let found = fastest_kick(&clip, &model(), &spec());
        assert_eq!(found, Some(KickLabel { leg: KickLeg::Left, frame: 7, speed: 5.0 }));
    }
}
