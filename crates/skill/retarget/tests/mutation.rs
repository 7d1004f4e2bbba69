//! The readers of human motion on thousands of damaged files: an error that names file, line and column, or a motion that is whole;
//! never a panic. `fuzz/` does the same without end.

use std::path::Path;

use paid_motion::Points;
use paid_retarget::{
    HumanMotion, HumanOptions, Naming, RetargetError, motion_of_points, parse_amc, parse_asf, parse_bvh,
    parse_skeleton,
};
use paid_testing::damaged;

const ASF: &str = ":units\n length 0.45\n angle deg\n:root\n order TX TY TZ RX RY RZ\n axis XYZ\n position 0 0 0\n \
    orientation 0 0 0\n:bonedata\n begin\n name hip\n direction 1 0 0\n length 2\n axis 0 0 0 XYZ\n end\n begin\n name thigh\n \
    direction 0 -1 0\n length 4\n axis 0 0 20 XYZ\n dof rx rz\n limits (-160.0 20.0)\n (-70 70)\n end\n:hierarchy\n begin\n root hip\n \
    hip thigh\n end\n";
const AMC: &str =
    ":FULLY-SPECIFIED\n:DEGREES\n1\nroot 1 2 3 0 90 0\nthigh 90 0\n2\nroot 1 2 3 0 0 0\nthigh 0 1\n";

fn judge(name: &str, number: u32, result: Result<HumanMotion, RetargetError>, counts: &mut [usize; 2]) {
    match result {
        Ok(motion) => {
            counts[0] += 1;
            let n = motion.frames * motion.skeleton.bones.len();
            assert!(motion.frames > 0 && motion.fps > 0.0, "{name} {number}");
            assert_eq!((motion.pos.len(), motion.quat.len()), (n, n), "{name} {number}");
            let numbers = motion.pos.as_flattened().iter().chain(motion.quat.as_flattened());
            assert!(numbers.into_iter().all(|x| x.is_finite()), "{name} {number}");
        }
        Err(error) => {
            counts[1] += 1;
            let text = error.to_string();
            let mut place = text.split(':');
            let file = place.next().unwrap_or_default();
            assert!(["a.bvh", "a.asf", "a.amc"].contains(&file), "{name} {number}: {text}");
            let numbers: Vec<usize> = place.take(2).filter_map(|n| n.parse().ok()).collect();
            assert!(numbers.len() == 2 && numbers.iter().all(|n| *n > 0), "line and column: {text}");
            assert!(text.len() < 500, "{name} {number}: {text}");
        }
    }
}

fn run(name: &str, seed: &str, times: u32, read: impl Fn(&str) -> Result<HumanMotion, RetargetError>) {
    let mut counts = [0; 2];
    judge(name, 0, read(seed), &mut counts);
    assert_eq!(counts, [1, 0], "{name}: the undamaged file is read");
    for number in 0..times {
        let bytes = damaged(seed.as_bytes(), number);
        judge(name, number, read(&String::from_utf8_lossy(&bytes)), &mut counts);
    }
    assert!(counts[0] > times as usize / 200 && counts[1] > times as usize / 20, "{name}: {counts:?}");
}

#[test]
fn damaged_bvh_is_refused_or_whole() {
    run("bvh", &crate::common::kick_bvh(3), 6000, |text| {
        let motion = parse_bvh(text, Path::new("a.bvh"), 0.01)?;
        // Names and axes of any kind are judged without a panic.
        let turns = Naming::of(&motion).map(|n| n.sources).unwrap_or_default();
        assert!(turns.iter().flat_map(|source| source.turn).all(f64::is_finite), "{turns:?}");
        Ok(motion)
    });
}

#[test]
fn damaged_skeletons_are_refused_or_whole() {
    run("asf", ASF, 6000, |text| {
        let skeleton = parse_asf(text, Path::new("a.asf"))?;
        parse_amc(AMC, Path::new("a.amc"), &skeleton, 120.0)
    });
}

#[test]
fn damaged_angles_are_refused_or_whole() {
    let skeleton = parse_asf(ASF, Path::new("a.asf")).expect("a good skeleton");
    run("amc", AMC, 6000, |text| parse_amc(text, Path::new("a.amc"), &skeleton, 120.0));
}

const SHEET: &str = "up = 'y'\nunit_m = 0.01\nfps = 30\n[joints]\nleft_hip='a'\nleft_knee='b'\nleft_ankle='c'\nleft_toe='d'\nleft_shoulder='e'\n\
    left_elbow='f'\nleft_wrist='g'\nright_hip='h'\nright_knee='i'\nright_ankle='j'\nright_toe=['k', 'l']\nright_shoulder='l'\nright_elbow='m'\n\
    right_wrist='n'\n";

/// Numbers of a person in a stand with y up, in centimeters: 20 frames of 14 points.
fn person() -> Vec<f32> {
    let side = |s: f32| {
        [
            [0.0, 90.0, 10.0 * s],
            [0.0, 50.0, 10.0 * s],
            [0.0, 10.0, 10.0 * s],
            [15.0, 3.0, 10.0 * s],
            [0.0, 140.0, 20.0 * s],
            [0.0, 110.0, 20.0 * s],
            [25.0, 110.0, 20.0 * s],
        ]
    };
    let one: Vec<f32> = [side(-1.0), side(1.0)].as_flattened().as_flattened().to_vec();
    one.iter().copied().cycle().take(20 * one.len()).collect()
}

#[test]
fn damaged_descriptions_and_points_are_refused_or_whole() {
    let path = Path::new("a.toml");
    let points = |pos: &[u8]| {
        let numbers = pos.chunks_exact(4).map(|b| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])));
        let numbers: Vec<f64> = numbers.filter(|x| x.is_finite()).collect();
        let pos = numbers.as_chunks::<3>().0;
        let frames = pos.len() / 14;
        let names = ('a'..='n').map(String::from).collect();
        Points { names, fps: None, frames, pos: pos[..14 * frames].to_vec() }
    };
    let whole: Vec<u8> = person().iter().flat_map(|x| x.to_le_bytes()).collect();
    let read = |sheet: &str, bytes: &[u8]| {
        let skeleton = parse_skeleton(sheet, path)?;
        let points = points(bytes);
        if points.frames < 2 {
            return Ok(None);
        }
        motion_of_points(Path::new("a.npz"), &points, &skeleton, &HumanOptions::default()).map(Some)
    };
    assert!(matches!(read(SHEET, &whole), Ok(Some(_))), "the undamaged person is read");
    let (mut good, mut bad) = (0, 0);
    for number in 0..4000 {
        // The sheet in every other, the numbers in the rest.
        let result = if number % 2 == 0 {
            read(&String::from_utf8_lossy(&damaged(SHEET.as_bytes(), number)), &whole)
        } else {
            read(SHEET, &damaged(&whole, number))
        };
        match result {
            Ok(Some(motion)) => {
                good += 1;
                let numbers = motion.pos.as_flattened().iter().chain(motion.quat.as_flattened());
                assert!(numbers.into_iter().all(|x| x.is_finite()), "{number}");
            }
            Ok(None) => {}
            Err(error) => {
                bad += 1;
                let text = error.to_string();
                assert!(text.starts_with("a.toml: ") || text.starts_with("a.npz: "), "{number}: {text}");
            }
        }
    }
    assert!(good > 400 && bad > 400, "{good} {bad}");
}
