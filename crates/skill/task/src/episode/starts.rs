//! Episodes that begin elsewhere than in a frame of the approach: in another pose, in a state that a held episode ended in, after the
//! strike.

use paid_lanes::rng::Rng;
use paid_lanes::{Quat, Vec3};

use crate::episode::reset::{StartContext, draw};
use crate::episode::stance::{RobotState, Sole, Stance};

/// How far off the heading of a start from another pose is, half-width `[rad]`: a robot that turns on the spot before its next kick
/// does it no better.
const TURN: f64 = 0.15;
/// Episodes from after the strike have their ball this much farther on its way than the strike's time says `[m]`: out of reach.
const GONE_M: f64 = 0.5;
/// Speed of that ball `[m/s]`, a usual kick's.
const GONE_SPEED: f64 = 3.0;

/// A kick that lies before the episode's start.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Struck {
    /// Where the ball lay `[m]`.
    pub lay: [f64; 3],
    /// Squared horizontal distance of that place from anchor and base in the reference's strike `[m^2]`.
    pub distance2: [f64; 2],
}

impl StartContext<'_> {
    /// For how long the last frame will be held [control steps].
    pub(crate) fn hold(&self, extra: &mut Rng) -> usize {
        let range = self.config.preset.hold_s;
        if range[1] > 0.0 { (draw(range, extra) / self.config.dt_s).round() as usize } else { 0 }
    }

    /// A state other than the first frame's to begin `motion` in: another motion's last pose, or one that an episode ended in.
    pub(crate) fn other_start(&self, motion: usize, extra: &mut Rng) -> Option<RobotState> {
        let preset = &self.config.preset.sampling;
        let [pose, end] = [preset.from_last_pose_share, preset.from_end_state_share];
        if pose + end <= 0.0 {
            return None;
        }
        let (unit, pick, turn) = (extra.unit(), extra.unit(), extra.uniform(-TURN, TURN));
        let facts = &self.library.facts()[motion];
        let one_of = |n: usize| ((pick * n as f64) as usize).min(n.saturating_sub(1));
        if unit < pose {
            let others = (self.library.len() - 1).max(1);
            let other = (motion + 1 + one_of(others)) % self.library.len();
            let stance = Stance::of_last_frame(self.config, &self.library.clips()[other]);
            Some(stance.at_start(facts, turn))
        } else if unit < pose + end {
            let states = self.end_states.all();
            states.get(one_of(states.len())).map(|stance| stance.at_start(facts, turn))
        } else {
            None
        }
    }

    /// What a ball that lay at `lay` would have been to the reference, displaced by `shift`, in its strike.
    pub(crate) fn struck(&self, motion: usize, shift: [f64; 2], lay: [f64; 3]) -> Struck {
        let clip = &self.library.clips()[motion];
        let row = self.library.facts()[motion].strike_frame * (clip.body_pos.len() / clip.frames);
        let distance2 = [self.config.followed[self.config.anchor], 0].map(|body| {
            let [x, y, _] = clip.body_pos[row + body];
            (lay[0] - x - shift[0]).powi(2) + (lay[1] - y - shift[1]).powi(2)
        });
        Struck { lay, distance2 }
    }

    /// The reference's state at a frame; beyond the last one its pose at rest.
    pub(crate) fn reference_state(&self, motion: usize, frame: usize) -> RobotState {
        let config = self.config;
        let clip = &self.library.clips()[motion];
        let joints = config.joints();
        let held = frame >= clip.frames;
        let frame = frame.min(clip.frames - 1);
        let row = frame * (clip.body_pos.len() / clip.frames);
        // The file's velocity is the center of mass's: v_origin = v_com - omega x (R com).
        let omega = Vec3(clip.body_ang_vel[row]);
        let arm = Quat(clip.body_quat[row]).rotate(Vec3(config.base_com));
        let origin = Vec3(clip.body_com_vel[row]) - omega.cross(arm);
        let joint_vel = clip.joint_vel[frame * joints..][..joints].to_vec();
        RobotState {
            base_pos: clip.body_pos[row],
            base_quat: clip.body_quat[row],
            lin_vel: if held { [0.0; 3] } else { origin.0 },
            ang_vel: if held { [0.0; 3] } else { omega.0 },
            joint_pos: clip.joint_pos[frame * joints..][..joints].to_vec(),
            joint_vel: if held { vec![0.0; joints] } else { joint_vel },
            soles: config.feet.map(|i| {
                let foot = row + config.followed[i];
                let x = Quat(clip.body_quat[foot]).rotate(Vec3([1.0, 0.0, 0.0])).0;
                Sole::of(clip.body_pos[foot], x)
            }),
        }
    }
}

/// True with the probability `share`; draws nothing if that is 0.
pub(crate) fn happens(share: f64, rng: &mut Rng) -> bool {
    share > 0.0 && rng.unit() < share
}

/// Place and velocity (x, y) of a ball that was kicked at `lay` toward `goal` `since_s` ago `[s]`.
pub(crate) fn gone(lay: [f64; 2], goal: [f64; 2], since_s: f64) -> ([f64; 2], [f64; 2]) {
    let way = [goal[0] - lay[0], goal[1] - lay[1]];
    let length = way[0].hypot(way[1]).max(1e-6);
    let far = GONE_M + GONE_SPEED * since_s;
    ([0, 1].map(|k| lay[k] + far * way[k] / length), way.map(|w| GONE_SPEED * w / length))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ball_that_is_gone_is_on_its_way_to_the_goal() {
        // 3-4-5: half a second at 3 m/s and 0.5 m are 2 m.
        let (ball, velocity) = gone([1.0, 1.0], [7.0, 9.0], 0.5);
        assert!((ball[0] - 2.2).abs() < 1e-12 && (ball[1] - 2.6).abs() < 1e-12, "{ball:?}");
        assert!((velocity[0] - 1.8).abs() < 1e-12 && (velocity[1] - 2.4).abs() < 1e-12, "{velocity:?}");
    }
}
