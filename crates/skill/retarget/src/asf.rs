//! ASF (a skeleton) and AMC (its motion), as Acclaim defined them and the CMU database uses them.

use std::path::Path;

use paid_lanes::Quat;

use crate::skeleton::about;
use crate::text::{Word, Words};
use crate::{Bone, HumanMotion, RetargetError, Skeleton};

const MOST_BONES: usize = 1024;
/// An inch, in which the CMU files measure after division by their `length`.
const INCH_M: f64 = 0.0254;

/// A skeleton and what its motions need to be read.
#[derive(Clone, Debug, PartialEq)]
pub struct AsfSkeleton {
    pub(crate) skeleton: Skeleton,
    /// Meters of a unit of length.
    pub(crate) unit_m: f64,
    /// Radians of a unit of angle.
    pub(crate) unit_rad: f64,
    /// For each bone the channels of its line in an AMC, in order, and whether each is an angle.
    lines: Vec<Vec<(usize, bool)>>,
}

/// Reads the text of an ASF file; `path` names it in messages.
///
/// A bone's angles turn about its own axes, x first; lengths are in units of an inch over the file's `length`.
///
/// # Errors
/// Line and column of the first thing that is not ASF.
pub fn parse_asf(text: &str, path: &Path) -> Result<AsfSkeleton, RetargetError> {
    let mut words = Words::new(path, text, Some('#'));
    let mut out = AsfSkeleton {
        skeleton: Skeleton { bones: vec![Bone::new("root", None)], channels: 0 },
        unit_m: INCH_M,
        unit_rad: 1f64.to_radians(),
        lines: vec![Vec::new()],
    };
    let mut parents = false;
    while words.peek().is_some() {
        let word = words.word("a section")?;
        match word.text {
            ":units" => units(&mut words, &mut out)?,
            ":root" => root(&mut words, &mut out)?,
            ":bonedata" => bones(&mut words, &mut out)?,
            ":hierarchy" => {
                hierarchy(&mut words, &mut out)?;
                parents = true;
            }
            text if text.starts_with(':') => {
                while words.peek().is_some_and(|w| !w.text.starts_with(':')) {
                    words.word("")?;
                }
            }
            _ => return Err(words.error_at(word, "a section such as ':bonedata'")),
        }
    }
    if !parents {
        return Err(words.error("a section ':hierarchy'"));
    }
    Ok(out)
}

fn in_section(words: &mut Words<'_>) -> bool {
    words.peek().is_some_and(|w| !w.text.starts_with(':'))
}

fn units(words: &mut Words<'_>, out: &mut AsfSkeleton) -> Result<(), RetargetError> {
    while in_section(words) {
        let key = words.word("a unit")?;
        match key.text {
            "length" => {
                let place = words.word("a number")?;
                let length = words.parse_number(place)?;
                if !(1e-6..=1e6).contains(&length) {
                    return Err(words.error_at(place, "a length above 0"));
                }
                out.unit_m = INCH_M / length;
            }
            "angle" => {
                let unit = words.word("'deg' or 'rad'")?;
                out.unit_rad = match unit.text {
                    "deg" => 1f64.to_radians(),
                    "rad" => 1.0,
                    _ => return Err(words.error_at(unit, "'deg' or 'rad'")),
                };
            }
            _ => {
                words.word("a value")?;
            }
        }
    }
    Ok(())
}

/// Names of degrees of freedom up to the next word that is none: axis, and whether it is an angle.
fn freedoms(words: &mut Words<'_>) -> Result<Vec<(usize, bool)>, RetargetError> {
    let mut out = Vec::new();
    while let Some(word) = words.peek() {
        let lower = word.text.to_ascii_lowercase();
        let freedom = match lower.as_str() {
            "tx" => (0, false),
            "ty" => (1, false),
            "tz" => (2, false),
            "rx" => (0, true),
            "ry" => (1, true),
            "rz" => (2, true),
            _ => break,
        };
        if out.contains(&freedom) {
            return Err(words.error_at(word, "each degree of freedom once"));
        }
        out.push(freedom);
        words.word("")?;
    }
    Ok(out)
}

/// Gives the channels of one line to a bone. Angles that come first turn first.
fn connect(out: &mut AsfSkeleton, bone: usize, freedoms: &[(usize, bool)]) {
    for &(axis, angle) in freedoms {
        let channel = out.skeleton.channels;
        out.skeleton.channels += 1;
        out.lines[bone].push((channel, angle));
        let bone = &mut out.skeleton.bones[bone];
        if angle {
            bone.turns.insert(0, (axis, channel));
        } else {
            bone.moves[axis] = Some(channel);
        }
    }
}

/// Three angles and the order in which they turn, such as `XYZ`: x first.
fn axis(words: &mut Words<'_>, unit_rad: f64) -> Result<[f64; 4], RetargetError> {
    let angles = words.numbers::<3>()?;
    let order = words.word("an order such as XYZ")?;
    let mut quat = Quat::identity();
    let mut seen = [false; 3];
    for c in order.text.chars() {
        match "XYZ".find(c.to_ascii_uppercase()) {
            Some(k) if !seen[k] => {
                seen[k] = true;
                quat = about(k, angles[k] * unit_rad).mul(quat);
            }
            _ => return Err(words.error_at(order, "an order such as XYZ")),
        }
    }
    if seen == [true; 3] { Ok(quat.0) } else { Err(words.error_at(order, "an order such as XYZ")) }
}

fn root(words: &mut Words<'_>, out: &mut AsfSkeleton) -> Result<(), RetargetError> {
    while in_section(words) {
        let key = words.word("a key of the root")?;
        match key.text {
            "order" if out.lines[0].is_empty() => {
                let freedoms = freedoms(words)?;
                connect(out, 0, &freedoms);
            }
            "axis" => {
                let order = words.word("an order such as XYZ")?;
                if !order.text.eq_ignore_ascii_case("XYZ") {
                    return Err(words.error_at(order, "XYZ"));
                }
            }
            "position" | "orientation" => {
                for _ in 0..3 {
                    let word = words.word("0")?;
                    if words.parse_number(word)? != 0.0 {
                        return Err(words.error_at(word, "a root that starts at 0"));
                    }
                }
            }
            _ => return Err(words.error_at(key, "'order', 'axis', 'position' or 'orientation'")),
        }
    }
    Ok(())
}

fn bones(words: &mut Words<'_>, out: &mut AsfSkeleton) -> Result<(), RetargetError> {
    while in_section(words) {
        words.keyword("begin")?;
        let mut bone = Bone::new("", None);
        let (mut direction, mut length, mut free) = ([0.0; 3], 0.0, Vec::new());
        loop {
            let key = words.word("'end' or a key of a bone")?;
            match key.text {
                "end" => break,
                "name" => {
                    let name = words.word("a name")?;
                    if name.text.starts_with(':') || out.skeleton.find(name.text).is_some() {
                        return Err(words.error_at(name, "a name that no other bone has"));
                    }
                    bone.name = name.text.to_owned();
                }
                "direction" => direction = words.numbers::<3>()?,
                "length" => length = words.number()?,
                "axis" => bone.axes = axis(words, out.unit_rad)?,
                "dof" => free = freedoms(words)?,
                text if text.starts_with(':') || text == "begin" => {
                    return Err(words.error_at(key, "'end' or a key of a bone"));
                }
                // Numbers and limits of no use here: "id", "limits (a b) (c d)".
                _ => {}
            }
        }
        if bone.name.is_empty() {
            return Err(words.error("the bone before to have a name"));
        }
        if out.skeleton.bones.len() == MOST_BONES {
            return Err(words.error(format!("at most {MOST_BONES} bones")));
        }
        bone.tail = direction.map(|d| d * length);
        out.skeleton.bones.push(bone);
        out.lines.push(Vec::new());
        connect(out, out.lines.len() - 1, &free);
    }
    Ok(())
}

fn named(words: &Words<'_>, out: &AsfSkeleton, word: Word<'_>) -> Result<usize, RetargetError> {
    out.skeleton.find(word.text).ok_or_else(|| words.error_at(word, "the name of a bone"))
}

/// Reads who hangs on whom, and puts the bones into an order of parents before children.
fn hierarchy(words: &mut Words<'_>, out: &mut AsfSkeleton) -> Result<(), RetargetError> {
    words.keyword("begin")?;
    let mut order = vec![0];
    loop {
        let parent = words.word("'end' or the name of a bone")?;
        if parent.text == "end" {
            break;
        }
        let from = named(words, out, parent)?;
        if !order.contains(&from) {
            return Err(words.error_at(parent, "a bone that hangs on the root already"));
        }
        while words.peek().is_some_and(|w| w.line == parent.line) {
            let child = words.word("a bone")?;
            let to = named(words, out, child)?;
            if order.contains(&to) {
                return Err(words.error_at(child, "a bone that hangs on no other yet"));
            }
            out.skeleton.bones[to].parent = Some(from);
            order.push(to);
        }
    }
    let place = |old: usize| order.iter().position(|&o| o == old);
    let bones = order.iter().map(|&old| {
        let bone = out.skeleton.bones[old].clone();
        Bone { parent: bone.parent.and_then(place), ..bone }
    });
    out.skeleton.bones = bones.collect();
    out.lines = order.iter().map(|&old| out.lines[old].clone()).collect();
    Ok(())
}

/// True for the number of a frame, or what stands in its place.
fn begins_frame(word: Word<'_>) -> bool {
    word.text.starts_with(|c: char| c.is_ascii_digit())
}

/// Reads the text of an AMC file, a motion of `skeleton` at `fps` frames a second; `path` names it in messages.
///
/// # Errors
/// Line and column of the first thing that is not AMC of this skeleton.
pub fn parse_amc(
    text: &str,
    path: &Path,
    skeleton: &AsfSkeleton,
    fps: f64,
) -> Result<HumanMotion, RetargetError> {
    let mut words = Words::new(path, text, Some('#'));
    let (mut unit_rad, mut full) = (skeleton.unit_rad, false);
    while words.peek().is_some_and(|w| w.text.starts_with(':')) {
        let flag = words.word("")?;
        match flag.text.to_ascii_uppercase().as_str() {
            ":DEGREES" => unit_rad = 1f64.to_radians(),
            ":RADIANS" => unit_rad = 1.0,
            ":FULLY-SPECIFIED" => full = true,
            _ => {}
        }
    }
    let (channels, most) = (skeleton.skeleton.channels, skeleton.skeleton.most_frames());
    let (mut values, mut frames): (Vec<f64>, usize) = (Vec::new(), 0);
    let mut seen = vec![0; skeleton.lines.len()];
    while let Some(number) = words.peek() {
        if frames == most {
            let bones = skeleton.skeleton.bones.len();
            return Err(words.error_at(number, format!("at most {most} frames of {bones} bones")));
        }
        words.count(usize::MAX, "the number of a frame")?;
        frames += 1;
        if words.peek().is_none_or(begins_frame) {
            return Err(words.error("the line of a bone after the number of a frame"));
        }
        // A bone that has no line keeps its angles.
        let start = values.len();
        if frames == 1 {
            values.resize(channels, 0.0);
        } else {
            values.extend_from_within(start - channels..);
        }
        while words.peek().is_some_and(|w| !begins_frame(w)) {
            let name = words.word("")?;
            let bone = skeleton.skeleton.find(name.text);
            let Some(bone) = bone.filter(|&b| seen[b] < frames) else {
                return Err(words.error_at(name, "a bone of the skeleton, once a frame"));
            };
            seen[bone] = frames;
            for &(channel, angle) in &skeleton.lines[bone] {
                if words.peek().is_none_or(|w| w.line != name.line) {
                    let count = skeleton.lines[bone].len();
                    return Err(words.error(format!("{count} numbers after '{}'", name.text)));
                }
                let value = words.number()?;
                values[start + channel] = if angle { value * unit_rad } else { value };
            }
            if let Some(more) = words.peek().filter(|w| w.line == name.line) {
                let count = skeleton.lines[bone].len();
                return Err(words.error_at(more, format!("{count} numbers after '{}'", name.text)));
            }
        }
        let left_out = |&b: &usize| full && seen[b] < frames && !skeleton.lines[b].is_empty();
        if let Some(bone) = (0..seen.len()).find(left_out) {
            let name = &skeleton.skeleton.bones[bone].name;
            return Err(
                words.error(format!("a line of '{name}' in frame {frames}, as ':FULLY-SPECIFIED' says"))
            );
        }
    }
    if frames == 0 || channels == 0 {
        return Err(words.error("at least one frame"));
    }
    Ok(HumanMotion::from_channels(path, skeleton.skeleton.clone(), fps, skeleton.unit_m, &values))
}

#[cfg(test)]
mod tests {
    use super::*;

    const ASF: &str = "# a comment\n:version 1.10\n:units\n  mass 1.0\n  length 0.254\n  angle deg\n:documentation\n anything\n\
        :root\n order TX TY TZ RX RY RZ\n axis XYZ\n position 0 0 0\n orientation 0 0 0\n:bonedata\n begin\n id 1\n name thigh\n\
        direction 0 -1 0\n length 4\n axis 0 0 90 XYZ\n dof rx rz\n limits (-160.0 20.0)\n (-70 70)\n end\n begin\n name hip\n\
        direction 1 0 0\n length 2\n axis 0 0 0 XYZ\n end\n:hierarchy\n begin\n root hip\n hip thigh\n end\n";
    const AMC: &str = ":DEGREES\n1\nroot 1 2 3 0 90 0\nthigh 90 0\n2\nroot 1 2 3 0 0 0\n";

    #[test]
    fn a_small_pair_gives_hand_computed_points() {
        let skeleton = parse_asf(ASF, Path::new("a.asf")).expect("a good skeleton");
        let names: Vec<&str> = skeleton.skeleton.bones.iter().map(|b| b.name.as_str()).collect();
        assert_eq!(names, ["root", "hip", "thigh"], "parents first");
        let motion = parse_amc(AMC, Path::new("a.amc"), &skeleton, 120.0).expect("a good motion");
        assert_eq!(motion.frames, 2);
        // A unit is 0.1 m. Frame 0: root at (1, 2, 3) turned by 90 degrees about y: the hip ends at (1, 2, 1). The thigh's first axis
        // is the root's y: its direction -y stays. End (1, -2, 1). World x, -z, y.
        // Frame 1: nothing is turned but the thigh, which has no line and keeps its angles: end (3, -2, 3).
        let expected = [
            [[0.1, -0.3, 0.2], [0.1, -0.1, 0.2], [0.1, -0.1, -0.2]],
            [[0.1, -0.3, 0.2], [0.3, -0.3, 0.2], [0.3, -0.3, -0.2]],
        ];
        for (t, points) in expected.iter().enumerate() {
            for (found, expected) in motion.pos(t).iter().flatten().zip(points.iter().flatten()) {
                assert!((found - expected).abs() < 1e-12, "frame {t}: {:?}", motion.pos(t));
            }
        }
    }

    #[test]
    fn faults_are_named_with_line_and_column() {
        let asf = |from: &str, to: &str| {
            parse_asf(&ASF.replace(from, to), Path::new("a.asf")).expect_err("a fault").to_string()
        };
        assert!(asf("length 4", "length four").starts_with("a.asf:19:9: expected a finite number"));
        assert!(
            asf("hip thigh", "hip shin").starts_with("a.asf:34:6: expected the name of a bone, found 'shin'")
        );
        assert!(asf("root hip", "thigh hip").contains("hangs on the root already"));
        assert!(asf("0 0 90 XYZ", "0 0 90 XXZ").starts_with("a.asf:20:14: expected an order such as XYZ"));
        assert!(
            asf(":hierarchy", ":other")
                .contains("expected a section ':hierarchy', found the end of the file")
        );
        let skeleton = parse_asf(ASF, Path::new("a.asf")).expect("a good skeleton");
        let amc = |from: &str, to: &str| {
            parse_amc(&AMC.replace(from, to), Path::new("a.amc"), &skeleton, 120.0)
                .expect_err("a fault")
                .to_string()
        };
        assert!(
            amc("thigh 90 0", "thigh 90")
                .starts_with("a.amc:5:1: expected 2 numbers after 'thigh', found '2'")
        );
        assert!(amc("thigh", "shin").starts_with("a.amc:4:1: expected a bone of the skeleton"));
        assert!(amc("thigh 90 0", "root 1 2 3 0 0 0").contains("once a frame"));
        assert!(amc(AMC, ":DEGREES").contains("at least one frame"));
        assert_eq!(
            amc("root 1 2 3 0 90 0\nthigh 90 0\n", ""),
            "a.amc:3:1: expected the line of a bone after the number of a frame, found '2'"
        );
        assert_eq!(
            amc("2\nroot 1 2 3 0 0 0\n", "2"),
            "a.amc:5:2: expected the line of a bone after the number of a frame, found the end of the file"
        );
    }

    #[test]
    fn a_fully_specified_file_has_a_line_of_every_bone_in_every_frame() {
        let skeleton = parse_asf(ASF, Path::new("a.asf")).expect("a good skeleton");
        let read = |text: &str| {
            parse_amc(text, Path::new("a.amc"), &skeleton, 120.0).map(|m| m.frames).map_err(|e| e.to_string())
        };
        let full = format!(":FULLY-SPECIFIED\n{AMC}");
        let missing = "expected a line of 'thigh' in frame 2, as ':FULLY-SPECIFIED' says, found";
        assert_eq!(read(&full), Err(format!("a.amc:7:17: {missing} the end of the file")));
        assert_eq!(read(&format!("{full}3\n")), Err(format!("a.amc:8:1: {missing} '3'")));
        // The hip has no degree of freedom and needs no line.
        assert_eq!(read(&format!("{full}thigh 1 2\n")), Ok(2));
        let error = read(&AMC.replace("thigh 90 0", "thigh 90 0 7")).expect_err("one number more");
        assert_eq!(error, "a.amc:4:12: expected 2 numbers after 'thigh', found '7'");
    }

    #[test]
    fn more_frames_than_memory_holds_are_refused() {
        let mut skeleton = parse_asf(ASF, Path::new("a.asf")).expect("a good skeleton");
        skeleton.skeleton.bones.resize(1024, Bone::new("idle", None));
        skeleton.lines.resize(1024, Vec::new());
        let error = parse_amc(&"1 hip\n".repeat(32_769), Path::new("a.amc"), &skeleton, 120.0)
            .expect_err("a bone without channels");
        assert_eq!(
            error.to_string(),
            "a.amc:32769:1: expected at most 32768 frames of 1024 bones, found '1'"
        );
    }
}
