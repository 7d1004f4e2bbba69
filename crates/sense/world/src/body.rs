//! The own body: what it hides, and how high the torso is above the ground.

use std::collections::VecDeque;

use paid_lanes::{Quat, Vec3};
use paid_robot::{BodyPose, RobotModel, Shape, kinematics};
use paid_track::Pose;

use crate::{JointMessage, SightError};

/// A leg is this thick around its bones `[m]`.
const LEG_M: f64 = 0.07;
/// No ball's center is closer to the middle of a foot `[m]`: ball and foot would touch at 0.13.
const FOOT_M: f64 = 0.10;
/// From the ankle to the toes `[m]`.
const TOES_M: f64 = 0.12;
/// Joint angles are kept for this long `[ns]`.
const KEPT_NS: u64 = 500_000_000;

/// Legs as bones in the torso's frame at one time.
#[derive(Clone, Debug)]
struct Posture {
    stamp_ns: u64,
    /// Hip, knee, ankle and toes of either leg `[m]`.
    legs: Vec<[[f64; 3]; 4]>,
    /// The base in the torso's frame.
    torso_from_base: Pose,
    /// The lowest point, for the torso's orientation, is found from these points `[m]` and radii `[m]`.
    lowest: Vec<([f64; 3], f64)>,
}

/// The own body over the last half second.
#[derive(Clone, Debug)]
pub struct OwnBody {
    robot: RobotModel,
    torso: usize,
    /// Bodies at hip, knee and ankle of either leg.
    joints: Vec<[usize; 3]>,
    past: VecDeque<Posture>,
}

impl OwnBody {
    /// Of a robot whose eyes sit on the body `torso`. A robot without the G1's legs hides nothing.
    ///
    /// # Errors
    /// If there is no such body.
    pub fn new(robot: RobotModel, torso: &str) -> Result<Self, SightError> {
        let body = robot.body_index(torso);
        let torso =
            body.ok_or_else(|| SightError::Body { robot: robot.name.clone(), body: torso.to_owned() })?;
        let joints = ["left", "right"].iter().filter_map(|side| {
            let find = |part: &str| robot.body_index(&format!("{side}_{part}_link"));
            Some([find("hip_pitch")?, find("knee")?, find("ankle_roll")?])
        });
        let joints = joints.collect();
        Ok(Self { robot, torso, joints, past: VecDeque::new() })
    }

    /// Takes in joint angles.
    ///
    /// # Errors
    /// If there are more or fewer than the robot has, or one is not finite.
    pub fn take(&mut self, message: &JointMessage) -> Result<(), SightError> {
        let expected = self.robot.joints.len();
        let broken = message.positions.iter().any(|angle| !angle.is_finite());
        if message.positions.len() != expected || broken {
            let found = if broken {
                "one that is not finite".to_owned()
            } else {
                message.positions.len().to_string()
            };
            return Err(SightError::Message {
                what: "joints",
                expected: format!("{expected} finite angles"),
                found,
            });
        }
        let bodies = kinematics::forward(&self.robot, Vec3::zero(), Quat::identity(), &message.positions);
        let torso = pose_of(&bodies[self.torso]);
        let legs = self.joints.iter().map(|joints| {
            let [hip, knee, ankle] = joints.map(|body| torso.inverse_point(bodies[body].pos.0));
            let toes = torso.inverse_point(bodies[joints[2]].point(Vec3([TOES_M, 0.0, 0.0])).0);
            [hip, knee, ankle, toes]
        });
        let mut lowest = Vec::new();
        for (body, pose) in self.robot.bodies.iter().zip(&bodies) {
            let mut add = |point: [f64; 3], radius: f64| {
                lowest.push((torso.inverse_point(pose.point(Vec3(point)).0), radius));
            };
            for geom in body.geoms.iter().filter(|geom| geom.class != "referee") {
                match geom.shape {
                    Shape::Sphere { center, radius } => add(center, radius),
                    Shape::Capsule { ends, radius } => ends.into_iter().for_each(|end| add(end, radius)),
                    Shape::Box { .. } => {}
                }
            }
        }
        let posture = Posture {
            stamp_ns: message.stamp_ns,
            legs: legs.collect(),
            torso_from_base: torso.inverse().compose(&pose_of(&bodies[0])),
            lowest,
        };
        while self.past.front().is_some_and(|old| old.stamp_ns + KEPT_NS < message.stamp_ns) {
            self.past.pop_front();
        }
        self.past.push_back(posture);
        Ok(())
    }

    /// The last posture up to a time.
    fn at(&self, stamp_ns: u64) -> Option<&Posture> {
        self.past.iter().rev().find(|posture| posture.stamp_ns <= stamp_ns).or_else(|| self.past.front())
    }

    /// The base, for a torso that is there now.
    pub fn base(&self, torso: &Pose) -> Option<Pose> {
        Some(torso.compose(&self.past.back()?.torso_from_base))
    }

    /// Height of the lowest point of the body, for a torso that is there now `[m]`: that of the ground, while the robot stands.
    pub fn ground(&self, torso: &Pose) -> Option<f64> {
        let posture = self.past.back()?;
        posture.lowest.iter().map(|(point, radius)| torso.point(*point)[2] - radius).reduce(f64::min)
    }

    /// Whether a leg is between a camera and a ball; both in the frame of the torso at that time `[m]`.
    pub fn hides(&self, stamp_ns: u64, camera: [f64; 3], ball: [f64; 3]) -> bool {
        self.bones(stamp_ns).any(|bone| segments_apart([camera, ball], bone) < LEG_M)
    }

    /// Whether a place is inside an own foot, frame of the torso at that time `[m]`: a foot that was taken for a ball.
    pub fn is_foot(&self, stamp_ns: u64, ball: [f64; 3]) -> bool {
        let Some(posture) = self.at(stamp_ns) else { return false };
        posture.legs.iter().any(|leg| segments_apart([ball, ball], [leg[2], leg[3]]) < FOOT_M)
    }

    fn bones(&self, stamp_ns: u64) -> impl Iterator<Item = [[f64; 3]; 2]> + '_ {
        let legs = self.at(stamp_ns).map(|posture| posture.legs.as_slice()).unwrap_or_default();
        legs.iter().flat_map(|leg| [[leg[0], leg[1]], [leg[1], leg[2]], [leg[2], leg[3]]])
    }
}

fn pose_of(body: &BodyPose<f64>) -> Pose {
    Pose { rot: body.rot(), pos: body.pos }
}

/// The least distance between two segments (Ericson, Real-Time Collision Detection, 5.1.9).
fn segments_apart([a, b]: [[f64; 3]; 2], [c, d]: [[f64; 3]; 2]) -> f64 {
    let (a, b, c, d) = (Vec3(a), Vec3(b), Vec3(c), Vec3(d));
    let (u, v, w) = (b - a, d - c, a - c);
    let (uu, vv, uv, uw, vw) = (u.dot(u), v.dot(v), u.dot(v), u.dot(w), v.dot(w));
    let determinant = uu * vv - uv * uv;
    let mut s = if determinant > 1e-12 { ((uv * vw - vv * uw) / determinant).clamp(0.0, 1.0) } else { 0.0 };
    let t = if vv > 1e-12 { ((uv * s + vw) / vv).clamp(0.0, 1.0) } else { 0.0 };
    if uu > 1e-12 {
        s = ((uv * t - uw) / uu).clamp(0.0, 1.0);
    }
    (w + u.scale(s) - v.scale(t)).norm()
}

#[cfg(test)]
mod tests {
    use super::*;
    use paid_robot::RobotSpec;

    fn standing() -> OwnBody {
        let robot = RobotModel::g1();
        let control = RobotSpec::g1().resolve(&robot).expect("complete");
        let mut body = OwnBody::new(robot, "torso_link").expect("a torso");
        body.take(&JointMessage { stamp_ns: 0, positions: control.default_pos }).expect("29 angles");
        body
    }

    #[test]
    fn distances_of_segments_by_hand() {
        let x = [[0.0; 3], [1.0, 0.0, 0.0]];
        assert!((segments_apart(x, [[0.5, -1.0, 0.3], [0.5, 1.0, 0.3]]) - 0.3).abs() < 1e-12);
        assert!((segments_apart(x, [[2.0, 0.0, 0.0], [3.0, 0.0, 0.0]]) - 1.0).abs() < 1e-12);
        assert!((segments_apart([[0.5, 2.0, 0.0]; 2], x) - 2.0).abs() < 1e-12);
    }

    #[test]
    fn a_ball_behind_a_leg_is_hidden_and_one_before_it_is_not() {
        let body = standing();
        let torso = Pose::identity();
        let ground = body.ground(&torso).expect("a posture");
        assert!((-0.95..-0.7).contains(&ground), "{ground}");
        let camera = Pose::g1_camera().pos.0;
        let ball = |x: f64, y: f64| [x, y, ground + 0.11];
        assert!(!body.hides(0, camera, ball(1.0, 0.0)));
        assert!(body.hides(0, camera, ball(-0.08, 0.13)));
        assert!(body.is_foot(0, [0.08, 0.12, ground + 0.05]) && !body.is_foot(0, ball(0.5, 0.12)));
    }

    #[test]
    fn too_few_angles_are_refused() {
        let error =
            standing().take(&JointMessage { stamp_ns: 1, positions: vec![0.0; 3] }).expect_err("3 of 29");
        assert_eq!(error.to_string(), "joints: expected 29 finite angles, found 3");
    }
}
