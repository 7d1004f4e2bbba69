//! How a reward term is added: three steps, shown on `upright`. ARCHITECTURE.md shows the same lines.

use std::f64::consts::FRAC_PI_2;

use paid_lanes::Quat;
use paid_robot::{RobotModel, RobotSpec};
use paid_task::{REWARD_NAMES, RewardPreset, Task, terms_table};

use crate::simulator::{Playback, clip, playback, preset, steps, term};

/// Step 1: the term's file. All of it is compiled with the crate; its test stands below the term.
const FILE: &str = include_str!("../../src/rewards/upright.rs");
/// Step 2: a line in the list, and the file's module.
const LIST: &str = include_str!("../../src/rewards/mod.rs");
const LINES: [&str; 2] = ["mod upright;\n", "    upright: Upright,\n"];
/// Step 3: a value in a preset.
const VALUE: &str = "rewards.upright = { weight = -1.0 }";

const ARCHITECTURE: &str = include_str!("../../../../../ARCHITECTURE.md");

#[test]
fn a_file_a_line_and_a_value_make_a_reward_term() {
    let (term_only, its_test) = FILE.split_once("\n#[cfg(test)]").expect("a test below the term");
    assert!(its_test.contains("#[test]"));
    assert!(LINES.iter().all(|line| LIST.contains(line)));

    // What follows from them: key, name, row of the table, and sum in the log.
    assert!(REWARD_NAMES.contains(&"upright"));
    assert!(terms_table().iter().any(|row| row.name == "upright" && row.frame == "base"));
    let value: toml::Table = VALUE.parse().expect("TOML");
    let kick = toml::Value::try_from(&preset("stage1", &[]).rewards.kick).expect("writes");
    let mut rewards = value["rewards"].clone();
    let table = rewards.as_table_mut().expect("a table");
    table.extend([("kick".to_owned(), kick), ("body_kernel".to_owned(), "exp_of_mean".into())]);
    assert_eq!(rewards.try_into::<RewardPreset>().expect("valid").upright.weight, -1.0);

    let mut lying = lying_robot();
    steps(&mut lying, 1);
    // -1 x 1 x 0.02 s.
    assert!((term(&mut lying, "upright") + 0.02).abs() < 1e-9);

    for part in [term_only, LINES[0].trim(), LINES[1].trim(), VALUE] {
        assert!(ARCHITECTURE.contains(part.trim()), "ARCHITECTURE.md shows another text than:\n{part}");
    }
}

/// A robot that plays back a motion on its side, under the preset `stage1` with the new value.
fn lying_robot() -> Task<f64, Playback> {
    let (robot, spec) = (RobotModel::g1(), RobotSpec::g1());
    let mut lying = clip(&robot, &spec, 1);
    lying.body_quat.fill(Quat::from_roll_pitch_yaw(FRAC_PI_2, 0.0, -FRAC_PI_2).0);
    let preset = preset("stage1", &[&VALUE.replacen(" = ", "=", 1)]);
    playback(lying, &preset, usize::MAX, |_| ())
}
