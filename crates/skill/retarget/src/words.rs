//! Parts of a human by the words in the names of bones, whatever program wrote them: "mixamorig:LeftUpLeg", "Bip001 L Thigh", "thigh.L",
//! "l_hip".

use crate::Skeleton;

/// Names of the parts of a limb from the trunk outward, the surest first. The last stand for another part in some skeletons.
const LEG: [&[&str]; 3] = [
    &["upleg", "upperleg", "thigh", "femur", "hip", "leg"],
    &["lowerleg", "lowleg", "shin", "calf", "tibia", "leg", "knee"],
    &["ankle", "foot"],
];
const ARM: [&[&str]; 3] = [
    &["uparm", "upperarm", "uarm", "humerus", "shldr", "arm", "shoulder"],
    &["forearm", "lowerarm", "lowarm", "farm", "radius", "elbow"],
    &["wrist", "hand"],
];
const TOE: &[&str] = &["toebase", "toe", "toes", "toe0", "ball", "foot"];
/// Words that say nothing about the part.
const FILL: [&str; 5] = ["joint", "jnt", "bone", "def", "bind"];

/// Bones of the limbs; sides are 0 left, 1 right.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Limbs {
    /// Thigh, shin and foot.
    pub legs: [[usize; 3]; 2],
    /// Upper arm, forearm and hand.
    pub arms: [[usize; 3]; 2],
    /// What hangs on the feet, if anything does.
    pub toes: [Option<usize>; 2],
    /// Where both legs hang.
    pub hips: usize,
    /// Where both arms hang.
    pub torso: usize,
}

impl Limbs {
    /// The limbs of a skeleton; `None` if one is not recognized or the arms hang on the hips.
    pub fn of(skeleton: &Skeleton) -> Option<Self> {
        let parts: Vec<Option<(usize, String)>> = skeleton.bones.iter().map(|b| part(&b.name)).collect();
        let find = |side: usize, names: &[&str], below: Option<usize>| {
            names.iter().find_map(|name| {
                let is = |part: &Option<(usize, String)>| {
                    part.as_ref().is_some_and(|(s, p)| *s == side && p == name)
                };
                let hangs =
                    |&i: &usize| below.is_none_or(|up| up != i && above(skeleton, i).any(|j| j == up));
                (0..parts.len()).filter(|&i| is(&parts[i])).find(hangs)
            })
        };
        let limb = |side: usize, names: [&[&str]; 3]| {
            let first = find(side, names[0], None)?;
            let second = find(side, names[1], Some(first))?;
            Some([first, second, find(side, names[2], Some(second))?])
        };
        let legs = [limb(0, LEG)?, limb(1, LEG)?];
        let arms = [limb(0, ARM)?, limb(1, ARM)?];
        let child = |i: usize| skeleton.bones.iter().position(|b| b.parent == Some(i));
        let toe = |side: usize| find(side, TOE, Some(legs[side][2])).or_else(|| child(legs[side][2]));
        let (hips, torso) = (meet(skeleton, legs)?, meet(skeleton, arms)?);
        (hips != torso).then(|| Self { legs, arms, toes: [toe(0), toe(1)], hips, torso })
    }
}

/// A bone and all that it hangs on.
fn above(skeleton: &Skeleton, i: usize) -> impl Iterator<Item = usize> + '_ {
    std::iter::successors(Some(i), |&i| skeleton.bones[i].parent)
}

/// The bone on which the first parts of both limbs hang.
fn meet(skeleton: &Skeleton, [left, right]: [[usize; 3]; 2]) -> Option<usize> {
    above(skeleton, left[0]).skip(1).find(|&i| above(skeleton, right[0]).any(|j| j == i))
}

/// Side and part that a name says.
fn part(name: &str) -> Option<(usize, String)> {
    let mut words = split(name);
    words.retain(|word| !FILL.contains(&word.as_str()));
    let side = |word: &str| match word {
        "left" | "l" => Some(0),
        "right" | "r" => Some(1),
        _ => None,
    };
    let known = |part: &str| LEG.iter().chain(&ARM).chain([&TOE]).any(|names| names.contains(&part));
    if let Some((at, side)) = words.iter().enumerate().rev().find_map(|(i, word)| Some((i, side(word)?))) {
        let after = words[at + 1..].concat();
        // "Armature_thigh_l" has the character's name in front.
        let before = || (0..at).map(|from| words[from..at].concat()).find(|part| known(part));
        return if after.is_empty() { Some((side, before()?)) } else { Some((side, after)) };
    }
    // "lfemur", "LUArm", "rightforearm".
    let whole = words.concat();
    let of = |(prefix, side)| {
        whole.strip_prefix(prefix).filter(|part| known(part)).map(|part| (side, part.to_owned()))
    };
    [("left", 0), ("right", 1), ("l", 0), ("r", 1)].into_iter().find_map(of)
}

/// The words of a name in lower case: parted by anything that is no letter or digit, and where a capital begins a word.
fn split(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let chars: Vec<char> = name.chars().collect();
    for (i, &c) in chars.iter().enumerate() {
        let before = i.checked_sub(1).map_or(' ', |i| chars[i]);
        let after = chars.get(i + 1).copied().unwrap_or(' ');
        let begins = c.is_uppercase() && (!before.is_uppercase() || after.is_lowercase());
        if begins || !c.is_alphanumeric() {
            words.push(String::new());
        }
        if let Some(word) = words.last_mut().filter(|_| c.is_alphanumeric()) {
            word.extend(c.to_lowercase());
        }
    }
    words.retain(|word| !word.is_empty());
    words
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Bone;

    #[test]
    fn names_of_many_programs_say_side_and_part() {
        for (name, side, expected) in [
            ("LeftUpLeg", 0, "upleg"),
            ("mixamorig_RightForeArm", 1, "forearm"),
            ("Bip001 L Thigh", 0, "thigh"),
            ("CC_Base_R_Upperarm", 1, "upperarm"),
            ("UpperLeg_L", 0, "upperleg"),
            ("upper_arm.R", 1, "upperarm"),
            ("DEF-thigh.L", 0, "thigh"),
            ("Armature_calf_l", 0, "calf"),
            ("Armature_ball_r", 1, "ball"),
            ("lfemur", 0, "femur"),
            ("RUArm", 1, "uarm"),
            ("rightforearm", 1, "forearm"),
            ("l_hip", 0, "hip"),
            ("HipLeft", 0, "hip"),
            ("left_knee_joint", 0, "knee"),
            ("rShldr", 1, "shldr"),
        ] {
            assert_eq!(part(name), Some((side, expected.to_owned())), "{name}");
        }
        for name in ["Hips", "Spine2", "root", "lowerback", "Head", "ribs"] {
            assert_eq!(part(name), None, "{name}");
        }
    }

    /// A skeleton of names, each with its parent's place in the list.
    fn skeleton(bones: &[(&str, usize)]) -> Skeleton {
        let bone = |(i, &(name, parent)): (usize, &(&str, usize))| Bone::new(name, (i > 0).then_some(parent));
        Skeleton { bones: bones.iter().enumerate().map(bone).collect(), channels: 0 }
    }

    #[test]
    fn a_name_means_what_hangs_where_it_must() {
        // Biovision's shoulder is the upper arm, SMPL's foot are the toes, and "leg" is the thigh where a knee follows.
        let found = Limbs::of(&skeleton(&[
            ("Pelvis", 0),
            ("L_Hip", 0),
            ("L_Knee", 1),
            ("L_Ankle", 2),
            ("L_Foot", 3),
            ("RightLeg", 0),
            ("RightKnee", 5),
            ("RightFoot", 6),
            ("Spine1", 0),
            ("Chest", 8),
            ("LeftCollar", 9),
            ("LeftShoulder", 10),
            ("LeftElbow", 11),
            ("LeftWrist", 12),
            ("RightShoulder", 9),
            ("RightArm", 14),
            ("RightForeArm", 15),
            ("RightHand", 16),
        ]));
        let expected = Limbs {
            legs: [[1, 2, 3], [5, 6, 7]],
            arms: [[11, 12, 13], [15, 16, 17]],
            toes: [Some(4), None],
            hips: 0,
            torso: 9,
        };
        assert_eq!(found, Some(expected));
    }
}
