//! Which body of the robot follows which part of the human, and how strictly. The numbers are GMR's (arXiv 2510.02252).

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2};

use crate::Role;
use crate::skeleton::about;

/// What one body of the robot shall do.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyTask {
    /// The body.
    pub body: &'static str,
    /// The point of the body that is placed `[m, body frame]`.
    pub point: [f64; 3],
    /// The part of the human that it follows.
    pub role: Role,
    /// Length of the robot there over that of a human of 1.8 m.
    pub scale: f64,
    /// Weights of position `[1/m]` and orientation `[1/rad]` in the first and the second stage.
    pub weights: [[f64; 2]; 2],
    /// Multiplied on the right of the part's orientation: the robot's axes, w, x, y, z.
    pub turn: [f64; 4],
    /// Moves the position in the first stage `[m, robot's axes]`.
    pub shift: [f64; 3],
}

/// All tasks, and the ranges that joints are kept to.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// The tasks. The one of [`Role::Hips`] gives the scale of the place on the floor.
    pub tasks: Vec<BodyTask>,
    /// Joint name and range `[rad]`, narrower than the robot's where a human's is.
    pub ranges: Vec<(&'static str, [f64; 2])>,
}

/// A point of the sole in front of the ankle: what stands in for toes [m, frame of the ankle's last body].
const TOE: [f64; 3] = [0.1, 0.0, -0.02];

/// How far a foot's bone points down while the sole is flat, in the Bandai skeleton `[rad]`.
const FOOT_SLOPE: f64 = 0.694;

fn task(body: &'static str, role: Role, scale: f64, weights: [[f64; 2]; 2], turn: [f64; 4]) -> BodyTask {
    // Table values have few digits.
    let norm = turn.iter().map(|x| x * x).sum::<f64>().sqrt();
    BodyTask { body, point: [0.0; 3], role, scale, weights, turn: turn.map(|x| x / norm), shift: [0.0; 3] }
}

impl Table {
    /// LAFAN1-like axes (x along the bone) to the Unitree G1.
    pub fn lafan_to_g1() -> Self {
        use Role::*;
        const TRUNK: [f64; 4] = [0.5, 0.5, 0.5, 0.5];
        const LEG: [f64; 4] = [-0.5, 0.5, 0.5, -0.5];
        const FOOT: [f64; 4] = [-1.0, 1.0, 0.0, 0.0];
        const UPPER_ARM: [f64; 4] = [0.5, 0.5, -0.5, -0.5];
        const ARM: [f64; 4] = [1.0, 1.0, 0.0, 0.0];
        const LIMB: [[f64; 2]; 2] = [[0.0, 10.0], [10.0, 5.0]];
        const SOLE: [[f64; 2]; 2] = [[50.0, 10.0], [50.0, 10.0]];
        let (leg, arm) = (0.9, 0.75);
        Self {
            tasks: vec![
                task("pelvis", Hips, leg, [[0.0, 10.0], [100.0, 5.0]], TRUNK),
                task("left_hip_yaw_link", LeftThigh, leg, LIMB, LEG),
                task("left_knee_link", LeftShin, leg, LIMB, LEG),
                task("left_ankle_roll_link", LeftFoot, leg, SOLE, FOOT),
                task("right_hip_yaw_link", RightThigh, leg, LIMB, LEG),
                task("right_knee_link", RightShin, leg, LIMB, LEG),
                task("right_ankle_roll_link", RightFoot, leg, SOLE, FOOT),
                task("torso_link", Torso, leg, [[0.0, 100.0], [0.0, 10.0]], TRUNK),
                task("left_shoulder_yaw_link", LeftUpperArm, arm, [[0.0, 100.0], [5.0, 100.0]], UPPER_ARM),
                task("left_elbow_link", LeftForearm, arm, LIMB, ARM),
                task("left_wrist_yaw_link", LeftHand, arm, LIMB, ARM),
                task("right_shoulder_yaw_link", RightUpperArm, arm, [[0.0, 100.0], [5.0, 100.0]], UPPER_ARM),
                task("right_elbow_link", RightForearm, arm, LIMB, ARM),
                task("right_wrist_yaw_link", RightHand, arm, LIMB, ARM),
            ],
            ranges: g1_ranges(),
        }
    }

    /// As [`Table::lafan_to_g1`], for the axes of the Bandai-Namco-Research-Motiondataset: x along the bone, away from the body on the
    /// left and toward it on the right.
    pub fn bandai_to_g1() -> Self {
        use Role::*;
        const QUARTER: f64 = FRAC_PI_2;
        let mut table = Self::lafan_to_g1();
        for task in &mut table.tasks {
            task.turn = match task.role {
                Hips => [0.0, FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2],
                Torso => task.turn,
                LeftThigh | LeftShin | LeftUpperArm => about(1, -QUARTER).0,
                RightThigh | RightShin | RightUpperArm => about(1, QUARTER).0,
                LeftFoot => about(1, -FOOT_SLOPE).0,
                RightFoot => about(1, 2.0 * QUARTER - FOOT_SLOPE).0,
                LeftForearm | LeftHand => [1.0, 0.0, 0.0, 0.0],
                RightForearm | RightHand => about(1, 2.0 * QUARTER).0,
            };
        }
        table
    }

    /// As [`Table::lafan_to_g1`], for segments that have the axes of the robot's bodies.
    pub fn points_to_g1() -> Self {
        let mut table = Self::lafan_to_g1();
        table.tasks.iter_mut().for_each(|task| task.turn = [1.0, 0.0, 0.0, 0.0]);
        table
    }

    /// SMPL-X-like axes (those of the world in a T-pose: x left, y up, z forward) to the Unitree G1.
    pub fn smplx_to_g1() -> Self {
        use Role::*;
        const TRUNK: [f64; 4] = [0.5, -0.5, -0.5, -0.5];
        const HIP: [f64; 4] = [0.42678, -0.56379, -0.56379, -0.42678];
        const LIMB: [[f64; 2]; 2] = [[0.0, 10.0], [10.0, 5.0]];
        const SOLE: [[f64; 2]; 2] = [[100.0, 10.0], [100.0, 50.0]];
        const LEFT_ARM: [f64; 4] = [1.0, 0.0, 0.0, 0.0];
        const RIGHT_ARM: [f64; 4] = [0.0, 0.0, 0.0, -1.0];
        let (leg, arm) = (0.9, 0.8);
        let toe = |body, role, inward| BodyTask {
            point: TOE,
            shift: [0.0, inward, 0.0],
            ..task(body, role, leg, SOLE, TRUNK)
        };
        Self {
            tasks: vec![
                task("pelvis", Hips, leg, [[100.0, 10.0], [100.0, 5.0]], TRUNK),
                task("left_hip_roll_link", LeftThigh, leg, LIMB, HIP),
                task("left_knee_link", LeftShin, leg, LIMB, TRUNK),
                toe("left_ankle_roll_link", LeftFoot, 0.02),
                task("right_hip_roll_link", RightThigh, leg, LIMB, HIP),
                task("right_knee_link", RightShin, leg, LIMB, TRUNK),
                toe("right_ankle_roll_link", RightFoot, -0.02),
                task("torso_link", Torso, leg, [[0.0, 10.0], [0.0, 10.0]], TRUNK),
                task("left_shoulder_yaw_link", LeftUpperArm, arm, LIMB, [1.0, 0.0, -1.0, 0.0]),
                task("left_elbow_link", LeftForearm, arm, LIMB, LEFT_ARM),
                task("left_wrist_yaw_link", LeftHand, arm, LIMB, LEFT_ARM),
                task("right_shoulder_yaw_link", RightUpperArm, arm, LIMB, [0.0, 1.0, 0.0, 1.0]),
                task("right_elbow_link", RightForearm, arm, LIMB, RIGHT_ARM),
                task("right_wrist_yaw_link", RightHand, arm, LIMB, RIGHT_ARM),
            ],
            ranges: g1_ranges(),
        }
    }
}

fn g1_ranges() -> Vec<(&'static str, [f64; 2])> {
    let mut out = vec![
        ("left_hip_roll_joint", [-0.52, 1.57]),
        ("right_hip_roll_joint", [-1.57, 0.52]),
        ("left_shoulder_roll_joint", [-0.6, 2.25]),
        ("right_shoulder_roll_joint", [-2.25, 0.6]),
        ("left_shoulder_yaw_joint", [-1.4, 2.0]),
        ("right_shoulder_yaw_joint", [-2.0, 1.4]),
    ];
    for (names, range) in [
        (["left_hip_pitch_joint", "right_hip_pitch_joint"], [-1.57, 1.57]),
        (["left_hip_yaw_joint", "right_hip_yaw_joint"], [-1.57, 1.57]),
        (["left_shoulder_pitch_joint", "right_shoulder_pitch_joint"], [-3.09, 1.15]),
        (["left_elbow_joint", "right_elbow_joint"], [-1.05, 1.7]),
    ] {
        out.extend(names.map(|name| (name, range)));
    }
    out
}
