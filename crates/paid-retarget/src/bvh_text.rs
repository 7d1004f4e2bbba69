//! Human motion as the text of a BVH file.

use std::f64::consts::FRAC_PI_2;
use std::fmt::Write as _;

use paid_lanes::{Quat, Vec3};

use crate::HumanMotion;
use crate::skeleton::about;

/// Metres of a unit of length in what is written: the centimetre, as nearly every BVH.
pub const BVH_UNIT_M: f64 = 0.01;
/// An offset that changes by less over the motion is constant [cm].
const CONSTANT_CM: f64 = 1e-5;

/// The text of a BVH file of `motion`: y up, centimetres, rotation channels Z, X, Y.
///
/// A bone whose point keeps its place in its parent's axes has an offset and three channels. One that does not (those of an ASF
/// file, whose points are the bones' ends) has position channels too. So [`crate::parse_bvh`] reads back the same points and
/// orientations, up to the rounding to six decimals. A bone at the end of a limb that never turned is an
/// `End Site`; that loses its name if it is another than `PARENT_end`.
pub fn bvh_text(motion: &HumanMotion) -> String {
    let writer = Writer::new(motion);
    let mut text = String::from("HIERARCHY\n");
    let mut order = Vec::new();
    for root in writer.children(None) {
        writer.bone(&mut text, &mut order, root, 0);
    }
    let _ = writeln!(text, "MOTION\nFrames: {}\nFrame Time: {}", motion.frames, 1.0 / motion.fps);
    for t in 0..motion.frames {
        let mut line = Vec::new();
        for &i in &order {
            let ([x, y, z], turn) = writer.local(i, t);
            let angles = angles_zxy(turn).map(f64::to_degrees);
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
    /// Place in the first frame in the parent's axes [cm].
    offsets: Vec<[f64; 3]>,
    /// True if the bone needs position channels.
    moves: Vec<bool>,
}

impl<'a> Writer<'a> {
    fn new(motion: &'a HumanMotion) -> Self {
        let count = motion.skeleton.bones.len();
        let mut writer = Self { motion, offsets: Vec::new(), moves: vec![true; count] };
        writer.offsets = (0..count).map(|i| writer.local(i, 0).0).collect();
        for (i, bone) in motion.skeleton.bones.iter().enumerate() {
            let first = Vec3(writer.offsets[i]);
            let moved = |t: usize| (Vec3(writer.local(i, t).0) - first).norm() > CONSTANT_CM;
            // A root always moves: readers expect its six channels.
            writer.moves[i] = bone.parent.is_none() || (1..motion.frames).any(moved);
        }
        writer
    }

    fn children(&self, parent: Option<usize>) -> impl Iterator<Item = usize> + '_ {
        let bones = self.motion.skeleton.bones.iter().enumerate();
        bones.filter(move |(_, bone)| bone.parent == parent).map(|(i, _)| i)
    }

    /// Place [cm] and turn of a bone in its parent's axes; a root's in the file's, y up.
    fn local(&self, i: usize, t: usize) -> ([f64; 3], Quat<f64>) {
        let (pos, quat) = (self.motion.pos(t), self.motion.quat(t));
        let (from, axes) = match self.motion.skeleton.bones[i].parent {
            Some(p) => (Vec3(pos[p]), Quat(quat[p])),
            // The file's world in ours, see `HumanMotion::from_channels`.
            None => (Vec3([0.0; 3]), about(0, FRAC_PI_2)),
        };
        let back = axes.conj();
        let place = back.rotate(Vec3(pos[i]) - from).scale(1.0 / BVH_UNIT_M);
        (place.0, back.mul(Quat(quat[i])).normalize())
    }

    /// True if nothing would be lost by an `End Site`.
    fn is_end(&self, i: usize) -> bool {
        let bone = &self.motion.skeleton.bones[i];
        let still = |t: usize| {
            let [w, ..] = self.local(i, t).1.0;
            w.abs() > 1.0 - 1e-14
        };
        let Some(parent) = bone.parent else { return false };
        bone.name == format!("{}_end", self.motion.skeleton.bones[parent].name)
            && !self.moves[i]
            && self.children(Some(i)).next().is_none()
            && (0..self.motion.frames).all(still)
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
            for child in self.children(Some(i)) {
                self.bone(text, order, child, depth + 1);
            }
        }
        let _ = writeln!(text, "{pad}}}");
    }
}

/// The angles [rad] about z, x and y whose turns, multiplied in this order, are `q`.
fn angles_zxy(q: Quat<f64>) -> [f64; 3] {
    let m = q.to_mat().0;
    let cos_x = m[2][0].hypot(m[2][2]);
    let x = m[2][1].atan2(cos_x);
    if cos_x < 1e-9 {
        // Only the sum or difference of the other two is determined.
        return [m[1][0].atan2(m[0][0]), x, 0.0];
    }
    [(-m[0][1]).atan2(m[1][1]), x, (-m[2][0]).atan2(m[2][2])]
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use proptest::prelude::*;

    use super::*;
    use crate::{Bone, Skeleton, parse_amc, parse_asf, parse_bvh};

    /// Largest differences of points [m] and orientations (1 - |cosine of half the angle|), bones matched by name.
    fn differences(a: &HumanMotion, b: &HumanMotion) -> [f64; 2] {
        assert_eq!((a.frames, a.skeleton.bones.len()), (b.frames, b.skeleton.bones.len()));
        let mut worst = [0.0_f64; 2];
        for (i, bone) in a.skeleton.bones.iter().enumerate() {
            let j = b.skeleton.find(&bone.name).expect("the same bones");
            let parent = |m: &HumanMotion, k: usize| {
                m.skeleton.bones[k].parent.map(|p| m.skeleton.bones[p].name.clone())
            };
            assert_eq!(parent(a, i), parent(b, j));
            for t in 0..a.frames {
                worst[0] = worst[0].max((Vec3(a.pos(t)[i]) - Vec3(b.pos(t)[j])).norm());
                let cosine: f64 = a.quat(t)[i].iter().zip(b.quat(t)[j]).map(|(x, y)| x * y).sum();
                worst[1] = worst[1].max(1.0 - cosine.abs());
            }
        }
        worst
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn what_is_written_is_read_back(
            parents in prop::collection::vec(0usize..100, 1..8),
            // For every bone: offset [cm], and whether it ends elsewhere (ASF).
            shapes in prop::collection::vec((prop::array::uniform3(-50.0..50.0), any::<bool>()), 9),
            values in prop::collection::vec(-3.1..3.1f64, 3 * (3 + 9 * 3)),
            fps in 20.0..240.0f64,
        ) {
            let mut skeleton = Skeleton { bones: vec![Bone::new("root", None)], channels: 3 };
            skeleton.bones[0].moves = [Some(0), Some(1), Some(2)];
            for (i, p) in parents.iter().enumerate() {
                skeleton.bones.push(Bone::new(format!("bone{i}"), Some(p % (i + 1))));
            }
            for (i, bone) in skeleton.bones.iter_mut().enumerate() {
                let (offset, asf) = shapes[i];
                if asf { bone.tail = offset } else if i > 0 { bone.head = offset }
                bone.turns = (0..3).map(|k| ((k + i) % 3, skeleton.channels + k)).collect();
                skeleton.channels += 3;
            }
            let channels = skeleton.channels;
            let motion =
                HumanMotion::from_channels(Path::new("a.bvh"), skeleton, fps, 0.01, &values[..2 * channels]);
            let text = bvh_text(&motion);
            let back = parse_bvh(&text, Path::new("a.bvh"), BVH_UNIT_M).expect("BVH");
            prop_assert!((back.fps - fps).abs() < 1e-9 * fps);
            let [far, turned] = differences(&motion, &back);
            prop_assert!(far < 1e-6 && turned < 1e-12, "{far} m, {turned}\n{text}");
            // Once more changes nothing but the last digit.
            let again = parse_bvh(&bvh_text(&back), Path::new("a.bvh"), BVH_UNIT_M).expect("BVH");
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
        let back = parse_bvh(&bvh_text(&motion), Path::new("a.bvh"), BVH_UNIT_M).expect("BVH");
        let [far, turned] = differences(&motion, &back);
        assert!(far < 1e-7 && turned < 1e-12, "{far} {turned}");
    }
}
