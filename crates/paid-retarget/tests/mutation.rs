//! The readers of human motion on thousands of damaged files: an error that names file, line and column, or a motion that is whole;
//! never a panic. `fuzz/` does the same without end.

mod common;
#[path = "../../paid-motion/src/mutate.rs"]
mod mutate;

use std::path::Path;

use mutate::damaged;
use paid_retarget::{HumanMotion, RetargetError, parse_amc, parse_asf, parse_bvh};

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
    run("bvh", &common::kick_bvh(3), 6000, |text| parse_bvh(text, Path::new("a.bvh"), 0.01));
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
