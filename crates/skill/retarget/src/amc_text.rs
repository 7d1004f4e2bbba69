//! Human motion as the texts of an ASF and an AMC file.

use std::fmt::Write as _;

use paid_lanes::{Quat, Vec3};

use crate::HumanMotion;
use crate::local::{children, constant_cm, local_cm, never_turns, turn_angles};

/// How a bone is written.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Shape {
    /// Its point is constant in its own axes: a bone as Acclaim means it.
    Tail([f64; 3]),
    /// Its point is constant in its parent's axes (BVH's offset): after a stiff bone from there.
    Head([f64; 3]),
    /// Its point moves in both: three more degrees of freedom.
    Moves,
}

/// The texts of an ASF and an AMC file of `motion`: y up, centimeters (`length 2.54`), degrees, angles about x, y, z.
///
/// A bone whose point is constant in its parent's axes, a joint of a BVH file, hangs on a stiff bone of its own, named after it with
/// `_offset`. A root of another name than `root` becomes a bone without length on it. [`crate::parse_asf`] and [`crate::parse_amc`] read the same points and
/// orientations back, up to the rounding to six decimals. An AMC states its frame rate in a comment only.
///
/// # Panics
/// If the skeleton has several roots; neither format that is read can have.
pub fn amc_texts(motion: &HumanMotion) -> [String; 2] {
    let mut writer = Writer { motion, bones: String::new(), hierarchy: String::new(), lines: Vec::new() };
    let roots: Vec<usize> = children(motion, None).collect();
    let [root] = roots[..] else { panic!("a skeleton has one root, this one {}", roots.len()) };
    let name = &motion.skeleton.bones[root].name;
    if name == "root" {
        writer.below(root, name);
    } else {
        let name = bone_name(name);
        writer.data(&name, [0.0; 3], "");
        writer.hierarchy = format!("    root {name}\n");
        writer.below(root, &name);
    }
    let Writer { bones, hierarchy, lines, .. } = writer;
    let skeleton = format!(
        "# Skeleton of {}\n:version 1.10\n:name {}\n:units\n  mass 1.0\n  length 2.54\n  angle deg\n:root\n  \
         order TX TY TZ RX RY RZ\n  axis XYZ\n  position 0 0 0\n  orientation 0 0 0\n:bonedata\n{bones}\
         :hierarchy\n  begin\n{hierarchy}  end\n",
        word(&motion.name),
        word(&motion.name),
    );
    let mut text = format!(
        "# {} frames a second\n# centimeters: {}.asf\n:FULLY-SPECIFIED\n:DEGREES\n",
        motion.fps,
        word(&motion.name)
    );
    for t in 0..motion.frames {
        let (place, turn) = local_cm(motion, root, t);
        let _ = writeln!(text, "{}\nroot {} {}", t + 1, numbers(place), angles(turn));
        for &(i, shape) in &lines {
            let (place, turn) = local_cm(motion, i, t);
            let moves = if shape == Shape::Moves { numbers(place) + " " } else { String::new() };
            let _ = writeln!(text, "{} {moves}{}", bone_name(&motion.skeleton.bones[i].name), angles(turn));
        }
    }
    [skeleton, text]
}

struct Writer<'a> {
    motion: &'a HumanMotion,
    /// The section `:bonedata`.
    bones: String,
    /// The lines of `:hierarchy`.
    hierarchy: String,
    /// The bones that have a line in a frame.
    lines: Vec<(usize, Shape)>,
}

impl Writer<'_> {
    /// Writes all that hangs on bone `i`, which is called `name`.
    fn below(&mut self, i: usize, name: &str) {
        let hanging: Vec<usize> = children(self.motion, Some(i)).collect();
        let mut line = name.to_owned();
        let mut stiff = String::new();
        for &child in &hanging {
            let bone = &bone_name(&self.motion.skeleton.bones[child].name);
            let shape = self.shape(child);
            let free = match shape {
                Shape::Moves => "  dof tx ty tz rx ry rz\n",
                _ if never_turns(self.motion, child) => "",
                _ => "  dof rx ry rz\n",
            };
            if let Shape::Head(offset) = shape {
                let own = format!("{bone}_offset");
                self.data(&own, offset, "");
                self.data(bone, [0.0; 3], free);
                let _ = write!(line, " {own}");
                let _ = writeln!(stiff, "    {own} {bone}");
            } else {
                self.data(bone, if let Shape::Tail(tail) = shape { tail } else { [0.0; 3] }, free);
                let _ = write!(line, " {bone}");
            }
            if !free.is_empty() {
                self.lines.push((child, shape));
            }
        }
        if !hanging.is_empty() {
            self.hierarchy += &format!("    {line}\n{stiff}");
        }
        for child in hanging {
            self.below(child, &bone_name(&self.motion.skeleton.bones[child].name));
        }
    }

    fn data(&mut self, name: &str, tail: [f64; 3], free: &str) {
        let length = Vec3(tail).norm();
        let direction = if length > 0.0 { Vec3(tail).scale(1.0 / length).0 } else { [0.0, 1.0, 0.0] };
        let [x, y, z] = direction;
        let _ = write!(
            self.bones,
            "  begin\n  name {name}\n  direction {x:.9} {y:.9} {z:.9}\n  length {length:.6}\n  axis 0 0 0 XYZ\n{free}  end\n"
        );
    }

    fn shape(&self, i: usize) -> Shape {
        let in_parent = |t: usize| local_cm(self.motion, i, t).0;
        let own = |t: usize| {
            let (place, turn) = local_cm(self.motion, i, t);
            turn.conj().rotate(Vec3(place)).0
        };
        let head = || constant_cm(self.motion.frames, in_parent).map(Shape::Head);
        constant_cm(self.motion.frames, own).map(Shape::Tail).or_else(head).unwrap_or(Shape::Moves)
    }
}

/// Angles about x, y, z `[degrees]`; x turns first.
fn angles(turn: Quat<f64>) -> String {
    let [z, y, x] = turn_angles(turn, [2, 1, 0]).map(f64::to_degrees);
    numbers([x, y, z])
}

fn numbers([x, y, z]: [f64; 3]) -> String {
    format!("{x:.6} {y:.6} {z:.6}")
}

/// A bone's name that neither format takes for something else: several words, a number, a section, a comment, a key.
fn bone_name(name: &str) -> String {
    let name = &name.replace(char::is_whitespace, "_");
    let odd = name.starts_with(|c: char| c.is_ascii_digit() || c == ':' || c == '#');
    if odd || ["root", "begin", "end"].contains(&name.as_str()) {
        format!("bone_{name}")
    } else {
        name.to_owned()
    }
}

/// A file's name as one word.
fn word(name: &str) -> String {
    let word: String = name.chars().map(|c| if c.is_ascii_graphic() { c } else { '_' }).collect();
    if word.is_empty() { "motion".to_owned() } else { word }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use proptest::prelude::*;

    use super::*;
    use crate::local::TEXT_UNIT_M;
    use crate::testing::{any_motion, differences};
    use crate::{parse_amc, parse_asf, parse_bvh};

    fn read_back(motion: &HumanMotion) -> HumanMotion {
        let [asf, amc] = amc_texts(motion);
        let skeleton = parse_asf(&asf, Path::new("a.asf")).unwrap_or_else(|e| panic!("{e}\n{asf}"));
        parse_amc(&amc, Path::new("a.amc"), &skeleton, motion.fps).unwrap_or_else(|e| panic!("{e}\n{amc}"))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn what_is_written_is_read_back(motion in any_motion()) {
            let back = read_back(&motion);
            let [far, turned] = differences(&motion, &back);
            prop_assert!(far < 1e-6 && turned < 1e-12, "{far} m, {turned}\n{}", amc_texts(&motion)[0]);
            // Bones are added once only.
            let again = read_back(&back);
            prop_assert_eq!(again.skeleton.bones.len(), back.skeleton.bones.len());
            prop_assert!(differences(&back, &again)[0] < 1e-6);
        }
    }

    #[test]
    fn a_joint_of_a_bvh_hangs_on_a_stiff_bone_and_a_sliding_one_gets_six_freedoms() {
        let text = "HIERARCHY\nROOT Hips\n{\n OFFSET 0 0 0\n CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation\n \
            JOINT 1Leg\n {\n  OFFSET 10 0 0\n  CHANNELS 3 Zrotation Xrotation Yrotation\n  JOINT Slide\n  {\n   OFFSET 0 -50 0\n   \
            CHANNELS 4 Yposition Zrotation Xrotation Yrotation\n   End Site\n   {\n    OFFSET 0 0 5\n   }\n  }\n }\n}\nMOTION\n\
            Frames: 2\nFrame Time: 0.02\n1 90 3 0 0 0 0 0 0 -50 0 0 0\n1 90 3 10 20 30 40 90 0 -40 20 30 0\n";
        let motion = parse_bvh(text, Path::new("kick 1.bvh"), TEXT_UNIT_M).expect("BVH");
        let [asf, amc] = amc_texts(&motion);
        for part in [
            "    root Hips\n    Hips bone_1Leg_offset\n    bone_1Leg_offset bone_1Leg\n    bone_1Leg Slide\n    Slide Slide_end\n",
            "name bone_1Leg_offset\n  direction 1.000000000 0.000000000 0.000000000\n  length 10.000000\n  axis 0 0 0 XYZ\n  end",
            "dof tx ty tz rx ry rz",
            ":name kick_1",
        ] {
            assert!(asf.contains(part), "{part}: {asf}");
        }
        assert!(amc.contains("\n2\nroot 1.000000 90.000000 3.000000 "), "{amc}");
        let mut back = read_back(&motion);
        for bone in &mut back.skeleton.bones {
            bone.name = bone.name.replace("bone_1", "1");
        }
        let [far, turned] = differences(&motion, &back);
        assert!(far < 1e-6 && turned < 1e-12, "{far} {turned}");
    }
}
