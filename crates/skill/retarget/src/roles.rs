//! Which bone of a file is which part of a human.

use paid_lanes::Quat;

use crate::skeleton::about;
use crate::table::Table;
use crate::{HumanMotion, RetargetError};

/// A part of a human that a table refers to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[allow(missing_docs)]
pub enum Role {
    Hips,
    Torso,
    LeftThigh,
    LeftShin,
    LeftFoot,
    RightThigh,
    RightShin,
    RightFoot,
    LeftUpperArm,
    LeftForearm,
    LeftHand,
    RightUpperArm,
    RightForearm,
    RightHand,
}

/// Where a part's frame comes from.
#[derive(Clone, Debug, PartialEq)]
pub struct RoleSource {
    /// The part.
    pub role: Role,
    /// The bone whose orientation it has.
    pub orientation: &'static str,
    /// The bone whose point is its position.
    pub position: &'static str,
    /// Turns the bone's axes into those that the table was made for: multiplied on the right, w, x, y, z.
    pub turn: [f64; 4],
}

/// A way of naming bones, and the table that goes with its axes.
#[derive(Clone, Debug)]
pub struct Naming {
    /// Its name.
    pub name: &'static str,
    /// All parts.
    pub sources: Vec<RoleSource>,
    /// The table.
    pub table: fn() -> Table,
}

fn sources(list: [(Role, &'static str, &'static str, Quat<f64>); 14]) -> Vec<RoleSource> {
    list.map(|(role, orientation, position, turn)| RoleSource { role, orientation, position, turn: turn.0 })
        .into()
}

impl Naming {
    /// The names and axes of LAFAN1 and files made like it: a bone's x axis points along it.
    pub fn lafan() -> Self {
        use Role::*;
        let same = Quat::identity();
        let own = |role, name| (role, name, name, same);
        Self {
            name: "LAFAN1",
            table: Table::lafan_to_g1,
            sources: sources([
                own(Hips, "Hips"),
                own(Torso, "Spine2"),
                own(LeftThigh, "LeftUpLeg"),
                own(LeftShin, "LeftLeg"),
                (LeftFoot, "LeftToe", "LeftFoot", same),
                own(RightThigh, "RightUpLeg"),
                own(RightShin, "RightLeg"),
                (RightFoot, "RightToe", "RightFoot", same),
                own(LeftUpperArm, "LeftArm"),
                own(LeftForearm, "LeftForeArm"),
                own(LeftHand, "LeftHand"),
                own(RightUpperArm, "RightArm"),
                own(RightForearm, "RightForeArm"),
                own(RightHand, "RightHand"),
            ]),
        }
    }

    /// The names and axes of the CMU database's ASF files. Axes are the world's in the rest pose, whose legs are splayed by 20
    /// degrees.
    pub fn cmu() -> Self {
        use Role::*;
        let same = Quat::identity();
        let (left, right) = (about(2, 20f64.to_radians()), about(2, -20f64.to_radians()));
        Self {
            name: "CMU",
            table: Table::smplx_to_g1,
            sources: sources([
                (Hips, "root", "root", same),
                (Torso, "thorax", "upperback", same),
                (LeftThigh, "lfemur", "lhipjoint", left),
                (LeftShin, "ltibia", "lfemur", left),
                (LeftFoot, "lfoot", "lfoot", left),
                (RightThigh, "rfemur", "rhipjoint", right),
                (RightShin, "rtibia", "rfemur", right),
                (RightFoot, "rfoot", "rfoot", right),
                (LeftUpperArm, "lhumerus", "lclavicle", same),
                (LeftForearm, "lradius", "lhumerus", same),
                (LeftHand, "lhand", "lwrist", same),
                (RightUpperArm, "rhumerus", "rclavicle", same),
                (RightForearm, "rradius", "rhumerus", same),
                (RightHand, "rhand", "rwrist", same),
            ]),
        }
    }

    /// The names and axes of the Bandai-Namco-Research-Motiondataset.
    pub fn bandai() -> Self {
        use Role::*;
        let same = Quat::identity();
        let own = |role, name| (role, name, name, same);
        Self {
            name: "Bandai-Namco-Research-Motiondataset",
            table: Table::bandai_to_g1,
            sources: sources([
                own(Hips, "Hips"),
                own(Torso, "Chest"),
                own(LeftThigh, "UpperLeg_L"),
                own(LeftShin, "LowerLeg_L"),
                own(LeftFoot, "Foot_L"),
                own(RightThigh, "UpperLeg_R"),
                own(RightShin, "LowerLeg_R"),
                own(RightFoot, "Foot_R"),
                own(LeftUpperArm, "UpperArm_L"),
                own(LeftForearm, "LowerArm_L"),
                own(LeftHand, "Hand_L"),
                own(RightUpperArm, "UpperArm_R"),
                own(RightForearm, "LowerArm_R"),
                own(RightHand, "Hand_R"),
            ]),
        }
    }

    /// The names of the segments that points make ([`crate::parse_skeleton`]), in the axes of the robot's bodies.
    pub fn points() -> Self {
        use Role::*;
        let own = |role, name| (role, name, name, Quat::identity());
        Self {
            name: "points",
            table: Table::points_to_g1,
            sources: sources([
                own(Hips, "hips"),
                own(Torso, "torso"),
                own(LeftThigh, "left_thigh"),
                own(LeftShin, "left_shin"),
                own(LeftFoot, "left_foot"),
                own(RightThigh, "right_thigh"),
                own(RightShin, "right_shin"),
                own(RightFoot, "right_foot"),
                own(LeftUpperArm, "left_upper_arm"),
                own(LeftForearm, "left_forearm"),
                own(LeftHand, "left_hand"),
                own(RightUpperArm, "right_upper_arm"),
                own(RightForearm, "right_forearm"),
                own(RightHand, "right_hand"),
            ]),
        }
    }

    /// The naming that fits a motion's bones.
    ///
    /// # Errors
    /// If none fits: the nearest one and the first bone that it lacks.
    pub fn of(motion: &HumanMotion) -> Result<Self, RetargetError> {
        let bones = &motion.skeleton;
        let missing = |naming: &Self| -> Vec<&'static str> {
            let names = naming.sources.iter().flat_map(|s| [s.orientation, s.position]);
            names.filter(|name| bones.find(name).is_none()).collect()
        };
        let mut all = [Self::lafan(), Self::cmu(), Self::bandai(), Self::points()].map(|n| (missing(&n), n));
        all.sort_by_key(|(missing, _)| missing.len());
        let [(missing, nearest), ..] = all;
        match missing.first() {
            None => Ok(nearest),
            Some(missing) => Err(RetargetError::Bones {
                path: motion.path.clone(),
                naming: nearest.name,
                missing,
                found: bones.bones.iter().map(|b| b.name.as_str()).collect::<Vec<_>>().join(", "),
            }),
        }
    }
}
