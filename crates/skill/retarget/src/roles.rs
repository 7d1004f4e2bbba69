//! Which bone of a file is which part of a human.

use paid_lanes::Quat;

use crate::skeleton::about;
use crate::table::Table;
use crate::words::Limbs;
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
    pub orientation: String,
    /// The bone whose point is its position.
    pub position: String,
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
    /// Left, right: the bones whose points are ankle and toe.
    pub feet: [[String; 2]; 2],
    /// True if a foot has the axes of its toe's bone.
    pub toes_turn: bool,
    /// Whose axes the bones have if these are not those that go with the names.
    pub axes: Option<&'static str>,
    /// The table.
    pub table: fn() -> Table,
}

fn sources(list: [(Role, &'static str, &'static str, Quat<f64>); 14]) -> Vec<RoleSource> {
    let source = |(role, orientation, position, turn): (Role, &str, &str, Quat<f64>)| RoleSource {
        role,
        orientation: orientation.to_owned(),
        position: position.to_owned(),
        turn: turn.0,
    };
    list.map(source).into()
}

fn feet(names: [[&str; 2]; 2]) -> [[String; 2]; 2] {
    names.map(|side| side.map(str::to_owned))
}

/// Left, right: thigh, shin, foot, upper arm, forearm, hand.
pub(crate) const SIDES: [[Role; 6]; 2] = {
    use Role::*;
    [
        [LeftThigh, LeftShin, LeftFoot, LeftUpperArm, LeftForearm, LeftHand],
        [RightThigh, RightShin, RightFoot, RightUpperArm, RightForearm, RightHand],
    ]
};

impl Naming {
    /// The names and axes of LAFAN1 and files made like it: a bone's x axis points along it.
    pub fn lafan() -> Self {
        use Role::*;
        let same = Quat::identity();
        let own = |role, name| (role, name, name, same);
        Self {
            name: "LAFAN1",
            table: Table::lafan_to_g1,
            toes_turn: true,
            axes: None,
            feet: feet([["LeftFoot", "LeftToe"], ["RightFoot", "RightToe"]]),
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
            toes_turn: false,
            axes: None,
            feet: feet([["ltibia", "lfoot"], ["rtibia", "rfoot"]]),
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
            toes_turn: false,
            axes: None,
            feet: feet([["Foot_L", "Toes_L"], ["Foot_R", "Toes_R"]]),
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
            toes_turn: false,
            axes: None,
            feet: feet([["left_foot", "left_toe"], ["right_foot", "right_toe"]]),
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

    /// The name of those that [`Limbs`] recognizes.
    pub(crate) const WORDS: &str = "recognized";

    /// The names of any skeleton whose limbs are recognized by their words; axes as in `points`.
    fn words(motion: &HumanMotion) -> Option<Self> {
        let (skeleton, limbs) = (&motion.skeleton, Limbs::of(&motion.skeleton)?);
        // The point of an ASF file's bone is its end: what turns with it is at its parent's.
        let ends = skeleton.bones[limbs.legs[0][0]].tail != [0.0; 3];
        let name = |i: usize| skeleton.bones[i].name.clone();
        let joint = |i: usize| name(if ends { skeleton.bones[i].parent.unwrap_or(i) } else { i });
        let own =
            |role, i| RoleSource { role, orientation: name(i), position: joint(i), turn: Quat::identity().0 };
        let mut sources = vec![own(Role::Hips, limbs.hips), own(Role::Torso, limbs.torso)];
        for (roles, (leg, arm)) in SIDES.into_iter().zip(limbs.legs.into_iter().zip(limbs.arms)) {
            sources.extend(roles.into_iter().zip(leg.into_iter().chain(arm)).map(|(role, i)| own(role, i)));
        }
        let toe =
            |side: usize| limbs.toes[side].map(joint).or_else(|| ends.then(|| name(limbs.legs[side][2])));
        let foot = |side: usize| Some([joint(limbs.legs[side][2]), toe(side)?]);
        let feet = [foot(0)?, foot(1)?];
        Some(Self {
            name: Self::WORDS,
            sources,
            feet,
            table: Table::points_to_g1,
            toes_turn: false,
            axes: None,
        })
    }

    /// The bone whose orientation a part has in `axes`.
    pub(crate) fn bone(&self, axes: &Self, role: Role) -> Option<&str> {
        let source = self.source(role)?;
        let side = match role {
            Role::LeftFoot => 0,
            Role::RightFoot => 1,
            _ => return Some(&source.orientation),
        };
        Some(match (self.toes_turn, axes.toes_turn) {
            (_, true) => &self.feet[side][1],
            (true, false) => &self.feet[side][0],
            (false, false) => &source.orientation,
        })
    }

    /// The part's bones.
    pub(crate) fn source(&self, role: Role) -> Option<&RoleSource> {
        self.sources.iter().find(|source| source.role == role)
    }

    /// The naming that fits a motion's bones, whatever their axes are.
    ///
    /// # Errors
    /// If none fits: the nearest one and the first bone that it lacks.
    pub(crate) fn named(motion: &HumanMotion) -> Result<Self, RetargetError> {
        let bones = &motion.skeleton;
        let missing = |naming: &Self| -> Vec<String> {
            let names = naming.sources.iter().flat_map(|s| [&s.orientation, &s.position]);
            names.filter(|name| bones.find(name).is_none()).cloned().collect()
        };
        let mut all = [Self::lafan(), Self::cmu(), Self::bandai(), Self::points()].map(|n| (missing(&n), n));
        all.sort_by_key(|(missing, _)| missing.len());
        let [(missing, nearest), ..] = all;
        match (missing.first(), Self::words(motion)) {
            (None, _) => Ok(nearest),
            (_, Some(words)) => Ok(words),
            (Some(missing), None) => Err(RetargetError::Bones {
                path: motion.path.clone(),
                naming: nearest.name,
                missing: missing.clone(),
                found: bones
                    .bones
                    .iter()
                    .map(|b| b.name.escape_debug().to_string())
                    .collect::<Vec<_>>()
                    .join(", "),
            }),
        }
    }
}
