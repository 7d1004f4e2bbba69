//! BVH: a skeleton and its motion in one text.

use std::path::Path;

use crate::text::{Word, Words};
use crate::{Bone, HumanMotion, RetargetError, Skeleton};

/// More bones than this are no human.
const MOST_BONES: usize = 1024;

/// Reads the text of a BVH file; `path` names it in messages. Y is up; a unit of length is `unit_m` meters.
///
/// The channels of a joint multiply in the order in which they are listed; position channels take the place of its offset. An `End
/// Site` becomes a bone without channels, named after its parent with `_end`. One frame more than promised, which Rokoko writes, is read and noted.
///
/// # Errors
/// Line and column of the first thing that is not BVH.
pub fn parse_bvh(text: &str, path: &Path, unit_m: f64) -> Result<HumanMotion, RetargetError> {
    parse_bvh_at(text, path, unit_m, None)
}

/// As [`parse_bvh`], at `fps` frames a second if given, whatever the file's frame time is.
pub(crate) fn parse_bvh_at(
    text: &str,
    path: &Path,
    unit_m: f64,
    fps: Option<f64>,
) -> Result<HumanMotion, RetargetError> {
    let mut words = Words::new(path, text, None);
    words.keyword("HIERARCHY")?;
    words.keyword("ROOT")?;
    let skeleton = hierarchy(&mut words)?;
    words.keyword("MOTION")?;
    words.keyword("Frames:")?;
    let frames = words.count(skeleton.most_frames().min(10_000_000), "the number of frames")?;
    if frames == 0 {
        return Err(words.error("at least one frame"));
    }
    words.keyword("Frame")?;
    words.keyword("Time:")?;
    let stated = words.word("the time of a frame")?;
    let (fps, note) = rate(&words, stated, fps)?;
    let (values, extra) = rows(&mut words, &angles(&skeleton), frames)?;
    let mut motion = HumanMotion::from_channels(path, skeleton, fps, unit_m, &values);
    motion.notes.extend(note.into_iter().chain(extra));
    Ok(motion)
}

/// How much a rate may be off because its frame time is rounded: 0.0083 s stands for 120 Hz.
const ROUNDED: f64 = 0.01;

/// The frame rate `[Hz]`: the `given` one, with a note if the `stated` frame time is another.
fn rate(
    words: &Words<'_>,
    stated: Word<'_>,
    given: Option<f64>,
) -> Result<(f64, Option<String>), RetargetError> {
    let Some(fps) = given else {
        let period = words.parse_number(stated)?;
        let plausible = (5e-4..=1.0).contains(&period);
        return if plausible {
            Ok((1.0 / period, None))
        } else {
            Err(words.error_at(stated, "a time from 0.0005 to 1 s; --fps states the frame rate instead"))
        };
    };
    match stated.text.parse::<f64>() {
        Ok(period) if (fps - 1.0 / period).abs() <= ROUNDED * fps => Ok((1.0 / period, None)),
        _ => {
            let period: String = stated.text.chars().take(40).collect();
            let note = format!("the file's frame time, {period:?} s, is not used: --fps {fps} is");
            Ok((fps, Some(note)))
        }
    }
}

/// The numbers of all frames, angles in rad, and a note if there is one frame more than promised.
fn rows(
    words: &mut Words<'_>,
    angle: &[bool],
    promised: usize,
) -> Result<(Vec<f64>, Option<String>), RetargetError> {
    let channels = angle.len();
    let mut values = Vec::new();
    while words.peek().is_some() && values.len() < promised * channels {
        let value = words.number()?;
        values.push(if angle[values.len() % channels] { value.to_radians() } else { value });
    }
    let frames = |n: usize| if n == 1 { "1 frame".to_owned() } else { format!("{n} frames") };
    let all = format!("{} of {channels} numbers", frames(promised));
    let count = |n: usize| match n % channels {
        0 => frames(n / channels),
        rest => format!("{} and {rest} numbers", frames(n / channels)),
    };
    let Some(more) = words.peek() else {
        return if values.len() == promised * channels {
            Ok((values, None))
        } else {
            Err(words.error_found(all, count(values.len())))
        };
    };
    let mut ahead = words.clone();
    let left = std::iter::from_fn(|| ahead.word("").ok()).count();
    if left != channels {
        return Err(words.error_found_at(more, all, count(values.len() + left)));
    }
    for &angle in angle {
        let value = words.number()?;
        values.push(if angle { value.to_radians() } else { value });
    }
    let note =
        format!("the file promises {} and has {}: all are used", frames(promised), frames(promised + 1));
    Ok((values, Some(note)))
}

/// For each channel whether it holds an angle.
fn angles(skeleton: &Skeleton) -> Vec<bool> {
    let mut angle = vec![false; skeleton.channels];
    for (_, channel) in skeleton.bones.iter().flat_map(|b| &b.turns) {
        angle[*channel] = true;
    }
    angle
}

/// From the name of the root to the brace that closes it.
fn hierarchy(words: &mut Words<'_>) -> Result<Skeleton, RetargetError> {
    let mut skeleton = Skeleton::default();
    // Bones whose brace is open.
    let mut open: Vec<usize> = Vec::new();
    let mut name = name_of(words, &skeleton)?;
    loop {
        if skeleton.bones.len() == MOST_BONES {
            return Err(words.error(format!("at most {MOST_BONES} bones")));
        }
        skeleton.bones.push(Bone::new(name, open.last().copied()));
        open.push(skeleton.bones.len() - 1);
        words.keyword("{")?;
        words.keyword("OFFSET")?;
        let offset = words.numbers::<3>()?;
        if let Some(bone) = skeleton.bones.last_mut() {
            bone.head = offset;
        }
        if words.peek().is_some_and(|w| w.text.eq_ignore_ascii_case("CHANNELS")) {
            channels(words, &mut skeleton)?;
        }
        // Braces that close, then the next bone, or the end.
        loop {
            let expected = "'JOINT', 'End Site' or '}'";
            let word = words.word(expected)?;
            match word.text {
                "}" => {
                    open.pop();
                    if open.is_empty() {
                        return if skeleton.channels > 0 {
                            Ok(skeleton)
                        } else {
                            Err(words.error_at(word, "at least one channel before it"))
                        };
                    }
                }
                "JOINT" => {
                    name = name_of(words, &skeleton)?;
                    break;
                }
                "End" => {
                    words.keyword("Site")?;
                    let parent = open.last().map_or(String::new(), |&i| skeleton.bones[i].name.clone());
                    name = format!("{parent}_end");
                    while skeleton.find(&name).is_some() {
                        name.push('_');
                    }
                    break;
                }
                _ => return Err(words.error_at(word, expected)),
            }
        }
    }
}

fn name_of(words: &mut Words<'_>, skeleton: &Skeleton) -> Result<String, RetargetError> {
    let word = words.word("the name of a joint")?;
    let mut name = word.text.to_owned();
    while let Some(more) = words.peek().filter(|w| w.line == word.line && w.text != "{") {
        name = format!("{name} {}", more.text);
        words.word("")?;
    }
    // Exporters put the character before the name: "mixamorig:Hips".
    let name = name.rsplit(':').next().unwrap_or(&name).trim();
    if name.is_empty() || name == "{" || skeleton.find(name).is_some() {
        return Err(words.error_at(word, "the name of a joint that no other has"));
    }
    Ok(name.to_owned())
}

fn channels(words: &mut Words<'_>, skeleton: &mut Skeleton) -> Result<(), RetargetError> {
    words.keyword("CHANNELS")?;
    let count = words.count(6, "the number of channels")?;
    let Some(bone) = skeleton.bones.last_mut() else { return Ok(()) };
    for _ in 0..count {
        let expected = "a channel such as Xposition or Zrotation that the joint does not have yet";
        let word = words.word(expected)?;
        let axis = "XYZ".find(word.text.chars().next().unwrap_or('?').to_ascii_uppercase());
        let kind = word.text.get(1..).unwrap_or_default();
        match axis {
            Some(k) if kind.eq_ignore_ascii_case("position") && bone.moves[k].is_none() => {
                bone.moves[k] = Some(skeleton.channels);
            }
            Some(k) if kind.eq_ignore_ascii_case("rotation") && bone.turns.len() < 3 => {
                bone.turns.push((k, skeleton.channels));
            }
            _ => return Err(words.error_at(word, expected)),
        }
        skeleton.channels += 1;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "HIERARCHY\nROOT Hips\n{\n OFFSET 0 0 0\n CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation\n \
        JOINT Leg\n {\n  OFFSET 10 0 0\n  CHANNELS 3 Zrotation Xrotation Yrotation\n  End Site\n  {\n   OFFSET 0 -50 0\n  }\n }\n}\n\
        MOTION\nFrames: 2\nFrame Time: 0.02\n1 90 3 0 0 0 0 0 0\n1 90 3 0 0 90 90 0 0\n";

    fn parse(text: &str) -> Result<HumanMotion, RetargetError> {
        parse_bvh(text, Path::new("a.bvh"), 0.01)
    }

    #[test]
    fn a_small_file_gives_hand_computed_points() {
        let motion = parse(TEXT).expect("a good file");
        assert_eq!((motion.frames, motion.fps), (2, 50.0));
        let names: Vec<&str> = motion.skeleton.bones.iter().map(|b| b.name.as_str()).collect();
        assert_eq!(names, ["Hips", "Leg", "Leg_end"]);
        // Frame 0, y up, cm: hips (1, 90, 3), leg (11, 90, 3), end (11, 40, 3); z up, m: x, -z, y.
        // Frame 1: hips turned by 90 degrees about y, so the leg is at (1, 90, 3 - 10); about its z again: the end, -y, turns to +x,
        // which is -z of the world: (1, 90, -7 - 50).
        let expected = [
            [[0.01, -0.03, 0.9], [0.11, -0.03, 0.9], [0.11, -0.03, 0.4]],
            [[0.01, -0.03, 0.9], [0.01, 0.07, 0.9], [0.01, 0.57, 0.9]],
        ];
        for (t, points) in expected.iter().enumerate() {
            for (found, expected) in motion.pos(t).iter().flatten().zip(points.iter().flatten()) {
                assert!((found - expected).abs() < 1e-12, "frame {t}: {:?}", motion.pos(t));
            }
        }
    }

    #[test]
    fn lines_may_end_as_on_any_system() {
        let motion = parse(TEXT).expect("a good file");
        for end in ["\r\n", "\r"] {
            assert_eq!(parse(&TEXT.replace('\n', end)).expect("a good file"), motion, "{end:?}");
        }
    }

    #[test]
    fn one_frame_more_than_promised_is_used_and_said() {
        let expected = parse(TEXT).expect("a good file");
        let mut motion = parse(&TEXT.replace("Frames: 2", "Frames: 1")).expect("as Rokoko writes it");
        assert_eq!(motion.notes, ["the file promises 1 frame and has 2 frames: all are used"]);
        motion.notes.clear();
        assert_eq!(motion, expected);
    }

    #[test]
    fn names_may_have_spaces_and_a_namespace() {
        for (name, expected) in [("Left Up  Leg", "Left Up Leg"), ("mixamorig:Left Leg", "Left Leg")] {
            let motion = parse(&TEXT.replace("JOINT Leg\n {", &format!("JOINT {name} {{"))).expect(name);
            assert_eq!(motion.skeleton.bones[1].name, expected);
        }
    }

    #[test]
    fn a_frame_rate_that_is_given_takes_the_place_of_the_frame_time() {
        let at = |time: &str, fps| {
            let text = TEXT.replace("0.02", time);
            parse_bvh_at(&text, Path::new("a.bvh"), 0.01, Some(fps)).expect("a good file")
        };
        assert_eq!((at("0.02", 50.3).fps, at("0.02", 50.3).notes.len()), (50.0, 0), "a rounded frame time");
        for time in ["0.02", "33.3", "0", "nan", "0,0333"] {
            let motion = at(time, 30.0);
            let note = format!("the file's frame time, \"{time}\" s, is not used: --fps 30 is");
            assert_eq!((motion.fps, motion.notes), (30.0, vec![note]));
        }
    }

    #[test]
    fn faults_are_named_with_line_and_column() {
        let cases = [
            (
                TEXT.replace("OFFSET 10 0 0", "OFFSET 10 x 0"),
                "a.bvh:8:13: expected a finite number, found 'x'",
            ),
            (
                TEXT.replace("Frames: 2", "Frames: 3"),
                "a.bvh:20:21: expected 3 frames of 9 numbers, found 2 frames",
            ),
            (
                TEXT.trim_end().trim_end_matches(" 0 0").to_owned(),
                "a.bvh:20:17: expected 2 frames of 9 numbers, found 1 frame and 7 numbers",
            ),
            (
                TEXT.replace("Frames: 2", "Frames: 10000001"),
                "a.bvh:17:9: expected the number of frames: a whole number from 0 to 10000000, found '10000001'",
            ),
            (
                TEXT.replace(" JOINT Leg", " JOINT Arm\n {\n  OFFSET 1 0 0\n  CHANNELS 0\n }\n JOINT Leg")
                    .replace("Frames: 2", "Frames: 8388609"),
                "a.bvh:22:9: expected the number of frames: a whole number from 0 to 8388608, found '8388609'",
            ),
            (
                TEXT.to_owned() + "1 2 3",
                "a.bvh:21:1: expected 2 frames of 9 numbers, found 2 frames and 3 numbers",
            ),
            (
                TEXT.to_owned() + &"1 2 3 4 5 6 7 8 9\n".repeat(2),
                "a.bvh:21:1: expected 2 frames of 9 numbers, found 4 frames",
            ),
            (
                TEXT.replace("0.02", "33.3"),
                "a.bvh:18:13: expected a time from 0.0005 to 1 s; --fps states the frame rate instead, found '33.3'",
            ),
            (
                TEXT.replace("JOINT Leg", "JOINT Hips"),
                "a.bvh:6:8: expected the name of a joint that no other has, found 'Hips'",
            ),
            (TEXT.replace("0.02", "nan"), "a.bvh:18:13: expected a finite number, found 'nan'"),
            (TEXT.replace("Xposition", "Wposition"), "a.bvh:5:13: expected a channel such as Xposition"),
            (TEXT.replace("HIERARCHY", "JERARCHY"), "a.bvh:1:1: expected 'HIERARCHY', found 'JERARCHY'"),
        ];
        for (text, expected) in cases {
            let error = parse(&text).expect_err("a fault").to_string();
            assert!(error.starts_with(expected), "{error}\n{expected}");
        }
    }
}
