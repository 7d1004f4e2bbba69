//! Human motion as the text of a BVH file.

use std::fmt::Write as _;

use crate::HumanMotion;
use crate::local::{children, constant_cm, local_cm, never_turns, turn_angles};

/// The text of a BVH file of `motion`: y up, centimeters, rotation channels Z, X, Y.
///
/// A bone whose point keeps its place in its parent's axes has an offset and three channels. One that does not (those of an ASF
/// file, whose points are the bones' ends) has position channels too. So [`crate::parse_bvh`] reads back the same points and
/// orientations, up to the rounding to six decimals. A bone at the end of a limb that never turned is an
/// `End Site`; that loses its name if it is another than `PARENT_end`.
pub fn bvh_text(motion: &HumanMotion) -> String {
    let writer = Writer::new(motion);
    let mut text = String::from("HIERARCHY\n");
    let mut order = Vec::new();
    for root in children(motion, None) {
        writer.bone(&mut text, &mut order, root, 0);
    }
    let _ = writeln!(text, "MOTION\nFrames: {}\nFrame Time: {}", motion.frames, 1.0 / motion.fps);
    for t in 0..motion.frames {
        let mut line = Vec::new();
        for &i in &order {
            let ([x, y, z], turn) = local_cm(motion, i, t);
            let angles = turn_angles(turn, [2, 0, 1]).map(f64::to_degrees);
            let moves = if writer.moves[i] { &[x, y, z][..] } else { &[] };
            line.extend(moves.iter().chain(&angles).map(|value| format!("{value:.6}")));
        }
        text += &line.join(" ");
        text.push('\n');
    }
    text
}

struct Writer<'a> {
    motion: &'a HumanMotion,
    /// Place in the first frame in the parent's axes `[cm]`.
    offsets: Vec<[f64; 3]>,
    /// True if the bone needs position channels.
    moves: Vec<bool>,
}

impl<'a> Writer<'a> {
    fn new(motion: &'a HumanMotion) -> Self {
        let bones = motion.skeleton.bones.iter().enumerate();
        // A root always moves: readers expect its six channels.
        let moves = bones.map(|(i, bone)| {
            bone.parent.is_none() || constant_cm(motion.frames, |t| local_cm(motion, i, t).0).is_none()
        });
        let moves = moves.collect();
        let offsets = (0..motion.skeleton.bones.len()).map(|i| local_cm(motion, i, 0).0).collect();
        Self { motion, offsets, moves }
    }

    /// True if nothing would be lost by an `End Site`.
    fn is_end(&self, i: usize) -> bool {
        let bone = &self.motion.skeleton.bones[i];
        let Some(parent) = bone.parent else { return false };
        bone.name == format!("{}_end", self.motion.skeleton.bones[parent].name)
            && !self.moves[i]
            && children(self.motion, Some(i)).next().is_none()
            && never_turns(self.motion, i)
    }

    /// Writes a bone and those that hang on it; `order` gets the bones that have channels.
    fn bone(&self, text: &mut String, order: &mut Vec<usize>, i: usize, depth: usize) {
        let bone = &self.motion.skeleton.bones[i];
        let pad = "  ".repeat(depth);
        let end = self.is_end(i);
        let head = match (end, bone.parent) {
            (true, _) => "End Site".to_owned(),
            (false, None) => format!("ROOT {}", bone.name),
            (false, Some(_)) => format!("JOINT {}", bone.name),
        };
        let [x, y, z] = if bone.parent.is_none() { [0.0; 3] } else { self.offsets[i] };
        let _ = writeln!(text, "{pad}{head}\n{pad}{{\n{pad}  OFFSET {x:.6} {y:.6} {z:.6}");
        if !end {
            let moves = if self.moves[i] { "6 Xposition Yposition Zposition" } else { "3" };
            let _ = writeln!(text, "{pad}  CHANNELS {moves} Zrotation Xrotation Yrotation");
            order.push(i);
            for child in children(self.motion, Some(i)) {
                self.bone(text, order, child, depth + 1);
            }
        }
        let _ = writeln!(text, "{pad}}}");
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use proptest::prelude::*;

    use super::*;
    use crate::local::TEXT_UNIT_M;
    use crate::testing::{any_motion, differences};
    use crate::{parse_amc, parse_asf, parse_bvh};

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn what_is_written_is_read_back(motion in any_motion()) {
            let text = bvh_text(&motion);
            let back = parse_bvh(&text, Path::new("a.bvh"), TEXT_UNIT_M).expect("BVH");
            prop_assert!((back.fps - motion.fps).abs() < 1e-9 * motion.fps);
            let [far, turned] = differences(&motion, &back);
            prop_assert!(far < 1e-6 && turned < 1e-12, "{far} m, {turned}\n{text}");
            // Once more changes nothing but the last digit.
            let again = parse_bvh(&bvh_text(&back), Path::new("a.bvh"), TEXT_UNIT_M).expect("BVH");
            prop_assert!(differences(&back, &again)[0] < 1e-6);
        }
    }

    #[test]
    fn an_end_site_stays_one_and_offsets_stay_offsets() {
        let text = "HIERARCHY\nROOT Hips\n{\n OFFSET 0 0 0\n CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation\n \
            JOINT Leg\n {\n  OFFSET 10 0 0\n  CHANNELS 3 Zrotation Xrotation Yrotation\n  End Site\n  {\n   OFFSET 0 -50 0\n  }\n }\n}\n\
            MOTION\nFrames: 2\nFrame Time: 0.02\n1 90 3 0 0 0 0 0 0\n1 90 3 10 20 30 40 90 0\n";
        let motion = parse_bvh(text, Path::new("a.bvh"), 0.01).expect("BVH");
        let written = bvh_text(&motion);
        for part in [
            "ROOT Hips",
            "JOINT Leg",
            "CHANNELS 3 Z",
            "End Site",
            "OFFSET 10.000000 ",
            " -50.000000 ",
            "Frame Time: 0.02\n",
        ] {
            assert!(written.contains(part), "{part}: {written}");
        }
        // A turn of 90 degrees about x locks the other two.
        let [far, turned] =
            differences(&motion, &parse_bvh(&written, Path::new("a.bvh"), 0.01).expect("BVH"));
        assert!(far < 1e-7 && turned < 1e-12, "{far} {turned}");
    }

    #[test]
    fn acclaims_points_survive_although_they_are_the_bones_ends() {
        let asf = ":units\n length 0.254\n angle deg\n:root\n order TX TY TZ RX RY RZ\n axis XYZ\n position 0 0 0\n orientation 0 0 0\n\
            :bonedata\n begin\n id 1\n name thigh\n direction 0 -1 0\n length 4\n axis 0 0 90 XYZ\n dof rx rz\n end\n\
            :hierarchy\n begin\n root thigh\n end\n";
        let skeleton = parse_asf(asf, Path::new("a.asf")).expect("ASF");
        let amc = ":DEGREES\n1\nroot 1 2 3 0 90 0\nthigh 90 0\n2\nroot 1 2 3 0 0 0\nthigh 20 40\n";
        let motion = parse_amc(amc, Path::new("a.amc"), &skeleton, 120.0).expect("AMC");
        let back = parse_bvh(&bvh_text(&motion), Path::new("a.bvh"), TEXT_UNIT_M).expect("BVH");
        let [far, turned] = differences(&motion, &back);
        assert!(far < 1e-7 && turned < 1e-12, "{far} {turned}");
    }
}
