//! A robot's state apart from where it stands: to begin a motion from another one's end, or from a state that an episode left behind.

use paid_lanes::{Quat, Real, Vec3};
use paid_physics::GroupState;
use paid_play::{MotionFacts, ReferenceClip};
use serde::{Deserialize, Serialize};

use crate::config::TaskConfig;

/// End states that a shard keeps: enough that two episodes rarely begin alike, few enough for a snapshot.
const KEPT: usize = 128;

/// A foot on the ground (x, y).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Sole {
    pub place: [f64; 2],
    /// Unit vector of the foot's x axis.
    pub along: [f64; 2],
}

impl Sole {
    /// Of a foot at `pos` whose x axis is `x`.
    pub(crate) fn of(pos: [f64; 3], x: [f64; 3]) -> Self {
        let length = x[0].hypot(x[1]).max(1e-6);
        Self { place: [pos[0], pos[1]], along: [x[0] / length, x[1] / length] }
    }
}

/// A robot's state in some axes: the world's, or a [`Stance`]'s.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct RobotState {
    /// Base origin `[m]`.
    pub base_pos: [f64; 3],
    /// Base orientation w, x, y, z.
    pub base_quat: [f64; 4],
    /// Velocity of the base origin `[m/s]`.
    pub lin_vel: [f64; 3],
    /// Angular velocity of the base `[rad/s]`.
    pub ang_vel: [f64; 3],
    /// Joint angles, model order `[rad]`.
    pub joint_pos: Vec<f64>,
    /// Joint velocities, model order `[rad/s]`.
    pub joint_vel: Vec<f64>,
    /// Left and right foot.
    pub soles: [Sole; 2],
}

/// A robot's state in axes whose origin is on the ground below its anchor and whose x axis is the anchor's heading.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Stance(RobotState);

/// Heading of an orientation w, x, y, z: the direction of its x axis in the horizontal plane `[rad]`.
pub(crate) fn heading_of([w, x, y, z]: [f64; 4]) -> f64 {
    (2.0 * (w * z + x * y)).atan2(1.0 - 2.0 * (y * y + z * z))
}

impl RobotState {
    /// The state turned by `angle` about the vertical through the origin, then moved by `shift`.
    fn moved(&self, angle: f64, shift: [f64; 3]) -> Self {
        let turn = Quat::from_roll_pitch_yaw(0.0, 0.0, angle);
        let turned = |v: [f64; 3]| turn.rotate(Vec3(v)).0;
        let flat = |[x, y]: [f64; 2]| turned([x, y, 0.0]);
        let base = turned(self.base_pos);
        let soles = self.soles.map(|sole| {
            let (place, along) = (flat(sole.place), flat(sole.along));
            Sole { place: [place[0] + shift[0], place[1] + shift[1]], along: [along[0], along[1]] }
        });
        Self {
            base_pos: [0, 1, 2].map(|k| base[k] + shift[k]),
            base_quat: turn.mul(Quat(self.base_quat)).normalize().0,
            lin_vel: turned(self.lin_vel),
            ang_vel: turned(self.ang_vel),
            soles,
            ..self.clone()
        }
    }

    /// The same above the ground below the anchor at `xy`, whose height is `ground`, in the anchor's axes.
    fn seen_from(&self, [x, y]: [f64; 2], ground: f64, heading: f64) -> Stance {
        Stance(self.moved(0.0, [-x, -y, -ground]).moved(-heading, [0.0; 3]))
    }
}

impl Stance {
    /// The last pose of a motion, at rest.
    pub(crate) fn of_last_frame(config: &TaskConfig, clip: &ReferenceClip) -> Self {
        let (t, joints) = (clip.frames - 1, config.joints());
        let row = t * (clip.body_pos.len() / clip.frames);
        let anchor = row + config.followed[config.anchor];
        let state = RobotState {
            base_pos: clip.body_pos[row],
            base_quat: clip.body_quat[row],
            lin_vel: [0.0; 3],
            ang_vel: [0.0; 3],
            joint_pos: clip.joint_pos[t * joints..][..joints].to_vec(),
            joint_vel: vec![0.0; joints],
            soles: config.feet.map(|i| {
                let foot = row + config.followed[i];
                Sole::of(clip.body_pos[foot], Quat(clip.body_quat[foot]).rotate(Vec3([1.0, 0.0, 0.0])).0)
            }),
        };
        let [x, y, _] = clip.body_pos[anchor];
        state.seen_from([x, y], 0.0, heading_of(clip.body_quat[anchor]))
    }

    /// The robot of one lane; `ground` is the height of the ground below its anchor `[m]`.
    pub(crate) fn of_lane<V: Real>(
        config: &TaskConfig,
        state: &GroupState<V>,
        lane: usize,
        base_quat: [f64; 4],
        ground: f64,
    ) -> Self {
        let (base, anchor) = (&state.bodies[0], &state.bodies[config.followed[config.anchor]]);
        let numbers = |values: &[V]| values.iter().map(|v| v.lane(lane)).collect();
        let x_axis = |rot: &paid_lanes::Mat3<V>| rot.0.map(|row| row[0].lane(lane));
        let robot = RobotState {
            base_pos: base.pos.lane(lane),
            base_quat,
            lin_vel: base.lin_vel.lane(lane),
            ang_vel: base.ang_vel.lane(lane),
            joint_pos: numbers(&state.joint_pos),
            joint_vel: numbers(&state.joint_vel),
            soles: [0, 1].map(|side| {
                let foot = config.foot(state, side);
                Sole::of(foot.pos.lane(lane), x_axis(&foot.rot))
            }),
        };
        let ([x, y, _], ahead) = (anchor.pos.lane(lane), x_axis(&anchor.rot));
        robot.seen_from([x, y], ground, ahead[1].atan2(ahead[0]))
    }

    /// The state where a motion begins, its heading off by `turn` `[rad]`.
    pub(crate) fn at_start(&self, facts: &MotionFacts, turn: f64) -> RobotState {
        let [x, y] = facts.start_xy;
        self.0.moved(facts.heading + turn, [x, y, 0.0])
    }

    /// True if every number is finite.
    fn is_finite(&self) -> bool {
        let state = &self.0;
        let fixed = state.base_pos.iter().chain(&state.base_quat).chain(&state.lin_vel).chain(&state.ang_vel);
        fixed.chain(&state.joint_pos).chain(&state.joint_vel).all(|x| x.is_finite())
    }
}

/// The states that the last held episodes of a shard ended in.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct EndStates {
    states: Vec<Stance>,
    /// The place that the next one takes.
    next: usize,
}

impl EndStates {
    /// Adds a state; from [`KEPT`] on it replaces the oldest one.
    pub(crate) fn push(&mut self, state: Stance) {
        if !state.is_finite() {
            return;
        }
        if self.states.len() < KEPT {
            self.states.push(state);
        } else {
            self.states[self.next] = state;
        }
        self.next = (self.next + 1) % KEPT;
    }

    /// The states, in no particular order.
    pub(crate) fn all(&self) -> &[Stance] {
        &self.states
    }

    /// True if every state is one of a robot with this many joints.
    pub(crate) fn fit(&self, joints: usize) -> bool {
        self.next < KEPT && self.states.iter().all(|s| s.0.joint_pos.len() == joints)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use super::*;

    fn robot() -> RobotState {
        RobotState {
            base_pos: [2.0, 1.0, 0.7],
            base_quat: Quat::<f64>::from_roll_pitch_yaw(0.0, 0.1, FRAC_PI_2).0,
            lin_vel: [0.0, 0.5, 0.1],
            ang_vel: [0.2, 0.0, 0.0],
            joint_pos: vec![0.3],
            joint_vel: vec![-1.0],
            soles: [Sole::of([1.9, 1.2, 0.0], [0.0, 2.0, 0.0]), Sole::of([2.1, 1.0, 0.0], [0.0, 1.0, 1.0])],
        }
    }

    fn near(found: &[f64], expected: &[f64]) {
        assert!(
            found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9),
            "{found:?}, expected {expected:?}"
        );
    }

    /// The anchor is above (2, 0.9) on ground of 0.1 m and looks along +y.
    #[test]
    fn a_stance_is_seen_along_the_anchors_heading_and_stands_where_a_motion_begins() {
        let stance = robot().seen_from([2.0, 0.9], 0.1, FRAC_PI_2);
        let RobotState { base_pos, base_quat, lin_vel, ang_vel, soles, .. } = &stance.0;
        near(base_pos, &[0.1, 0.0, 0.6]);
        near(base_quat, &Quat::<f64>::from_roll_pitch_yaw(0.0, 0.1, 0.0).0);
        near(lin_vel, &[0.5, 0.0, 0.1]);
        near(ang_vel, &[0.0, -0.2, 0.0]);
        near(&soles[0].place, &[0.3, 0.1]);
        near(&soles[1].along, &[1.0, 0.0]);

        let facts = MotionFacts {
            name: "m".into(),
            frames: 10,
            kick_foot: 1,
            strike_frame: 5,
            contact_frame: 5,
            strike_speed: 1.0,
            start_xy: [-1.0, 4.0],
            base_xy: [-1.0, 4.0],
            heading: PI - 0.1,
            displacement: [0.0; 2],
        };
        // Heading off by 0.1: along -x.
        let there = stance.at_start(&facts, 0.1);
        near(&there.base_pos, &[-1.1, 4.0, 0.6]);
        near(&there.lin_vel, &[-0.5, 0.0, 0.1]);
        near(&there.soles[0].place, &[-1.3, 3.9]);
        assert!((heading_of(there.base_quat).abs() - PI).abs() < 1e-9);
        assert_eq!((there.joint_pos, there.joint_vel), (vec![0.3], vec![-1.0]));
    }

    #[test]
    fn the_newest_end_states_are_kept_and_none_that_is_not_finite() {
        let of = |x: f64| Stance(RobotState { joint_pos: vec![x], ..robot() });
        let mut states = EndStates::default();
        states.push(of(f64::NAN));
        assert!(states.all().is_empty());
        for k in 0..KEPT + 2 {
            states.push(of(k as f64));
        }
        let angles: Vec<f64> = states.all().iter().map(|s| s.0.joint_pos[0]).collect();
        assert_eq!((angles.len(), angles[0], angles[1], angles[2]), (KEPT, 128.0, 129.0, 2.0));
        assert!(states.fit(1) && !states.fit(2));
    }
}
