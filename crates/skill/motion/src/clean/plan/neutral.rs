//! The stands at the two ends of a motion.

use paid_lanes::{Quat, Vec3};

use super::super::figure::{Figure, Frame};
use super::foothold::Foothold;
use crate::generate::Pose;

/// Feet further than this from where a stand has them are brought there by a step `[m, rad]`.
const AWKWARD: [f64; 2] = [0.12, 0.35];

/// Where a stand shall face `[rad]`.
#[derive(Clone, Copy)]
pub(super) struct Facing {
    /// The desired heading.
    pub first: f64,
    /// A stand is turned until it is this near to it,
    pub within: f64,
    /// if it is off by less than this.
    pub below: f64,
}

/// A stand at an end of the motion.
pub(super) struct Neutral {
    pub feet: [Foothold; 2],
    /// Heading of the base `[rad]`.
    pub yaw: f64,
    /// One foot is brought to its place by a step.
    pub step: bool,
    /// How long that step is, with a turn of one radian as bad as half a meter `[m]`.
    pub effort: f64,
}

impl Neutral {
    /// A stand for feet that are at `feet`: as they are, or with `mover` next to the other.
    pub fn new(figure: &Figure<'_>, feet: [Foothold; 2], mover: usize, facing: Facing) -> Self {
        let Facing { first, within, below } = facing;
        let wrap = |angle: f64| angle.sin().atan2(angle.cos());
        let near = |yaw: f64| {
            let off = wrap(yaw - first);
            if off.abs() > below { yaw } else { first + off.clamp(-within, within) }
        };
        let rest = figure.frame(&Pose {
            base_pos: [0.0; 3],
            base_quat: [1.0, 0.0, 0.0, 0.0],
            joints: figure.default_pos.clone(),
        });
        let anchor = feet[1 - mover];
        let yaw = near(anchor.yaw);
        let apart = rest.pos[figure.feet[mover]] - rest.pos[figure.feet[1 - mover]];
        let turn = Quat::from_axis_angle(Vec3([0.0, 0.0, 1.0]), yaw);
        let mut beside = feet;
        beside[mover].pos = anchor.pos + turn.rotate(Vec3([apart.x(), apart.y(), 0.0]));
        beside[mover].yaw = yaw;
        let off = (beside[mover].pos - feet[mover].pos).norm();
        let turned = wrap(feet[mover].yaw - anchor.yaw).abs();
        let middle = anchor.yaw + 0.5 * wrap(feet[mover].yaw - anchor.yaw);
        let far = (within..below).contains(&wrap(middle - first).abs());
        if off > AWKWARD[0] || turned > AWKWARD[1] || far {
            let turned = wrap(anchor.yaw - yaw).abs() + wrap(feet[mover].yaw - yaw).abs();
            Self { feet: beside, yaw, step: true, effort: off + 0.5 * turned }
        } else {
            Self { feet, yaw: middle, step: false, effort: 0.0 }
        }
    }
}

/// Heading in which a foot moves `[rad]`.
pub(super) fn shot(frames: &[Frame], foot: usize, kick: usize) -> f64 {
    let (a, b) = (kick.saturating_sub(1), (kick + 1).min(frames.len() - 1));
    let way = frames[b].com[foot] - frames[a].com[foot];
    way.y().atan2(way.x())
}

/// The upright pose of a stand.
pub(super) fn stand(figure: &Figure<'_>, at: &Neutral) -> Pose {
    let middle = (at.feet[0].pos + at.feet[1].pos).scale(0.5);
    let spread = (at.feet[0].pos - at.feet[1].pos).norm();
    let frame = figure.frame(&Pose {
        base_pos: [0.0; 3],
        base_quat: [1.0, 0.0, 0.0, 0.0],
        joints: figure.default_pos.clone(),
    });
    let leg = -frame.pos[figure.feet[0]].z();
    let wide = 0.5 * (spread - (frame.pos[figure.feet[0]] - frame.pos[figure.feet[1]]).norm()).max(0.0);
    let height = (leg * leg - wide * wide).max(0.25 * leg * leg).sqrt() + figure.sole_height(0);
    Pose {
        base_pos: [middle.x(), middle.y(), height],
        base_quat: Quat::from_axis_angle(Vec3([0.0, 0.0, 1.0]), at.yaw).0,
        joints: figure.default_pos.clone(),
    }
}
