//! Rows of numbers under names of columns in any order, or under none and with a quaternion in either order: an error or a clip that is
//! whole, never a panic.
#![no_main]

use std::fmt::Write as _;
use std::path::Path;

use paid_motion::{JointOrder, QuatOrder, ReadOptions};
use paid_robot::{RobotModel, RobotSpec};

/// The base's columns by some of the names that they have.
const BASE: [&str; 7] = ["pos_x", "root_translateY", "z", "quat_x", "qy", "base_rot_z", "quat_w"];

libfuzzer_sys::fuzz_target!(|input: &[u8]| {
    let Some(([flags, seed], numbers)) = input.split_first_chunk::<2>() else { return };
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    let mut names: Vec<String> = BASE.map(str::to_owned).into_iter().chain(model.joint_names()).collect();
    let (columns, named) = (names.len(), flags & 1 == 1);
    let mut text = String::from("# fps: 50\n");
    if named {
        names.rotate_left(usize::from(*seed) % columns);
        if flags & 2 == 2 {
            let other = usize::from(*seed) / 2 % columns;
            names.swap(0, other);
        }
        let _ = writeln!(text, "{}", names.join(","));
    }
    let place = |name: &str| names.iter().position(|other| other == name);
    let quat = BASE[3..].iter().filter_map(|name| place(name)).collect::<Vec<_>>();
    // Two bytes a number, up to 4; each quaternion is made a unit one, where it is not zero.
    let numbers: Vec<f64> =
        numbers.chunks_exact(2).map(|b| f64::from(i16::from_le_bytes([b[0], b[1]])) / 8192.0).collect();
    for row in numbers.chunks_exact(columns) {
        let mut row = row.to_vec();
        let norm = quat.iter().map(|&k| row[k] * row[k]).sum::<f64>().sqrt();
        quat.iter().for_each(|&k| row[k] /= norm.max(1e-9));
        let words: Vec<String> = row.iter().map(f64::to_string).collect();
        let _ = writeln!(text, "{}", words.join(","));
    }
    let options = ReadOptions {
        quat: [None, Some(QuatOrder::Xyzw), Some(QuatOrder::Wxyz), None][usize::from(flags >> 2 & 3)],
        joint_order: [None, Some(JointOrder::Policy)][usize::from(flags >> 4 & 1)],
        ..ReadOptions::default()
    };
    if let Ok(clip) = paid_motion::parse_csv(&text, Path::new("fuzz.csv"), &model, &spec, &options) {
        assert_eq!(clip.joint_pos.len(), clip.frames * model.joints.len());
        assert!(clip.body_quat.as_flattened().iter().all(|x| x.is_finite()));
    }
});
