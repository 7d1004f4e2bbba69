//! What a crate may know of the others: the layout in ARCHITECTURE.md, held against `cargo metadata` and `cargo tree`.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::process::Command;

use serde_json::Value;

/// The folders of `crates`. A crate knows those of its own folder and of the folders before it.
const WINGS: [&str; 7] = ["base", "learn", "sense", "skill", "judge", "robot", "app"];

/// Trainers, tasks, evaluations, simulators and drawing.
const ROBOT_NEVER: [&str; 12] =
    ["amp", "eval", "lab", "learn", "live", "mujoco", "physics", "plot", "sysid", "task", "train", "twin"];

/// What a crate never links, directly or through others.
const NEVER: [(&str, &[&str]); 6] = [
    // The robot's computer runs a policy and nothing else.
    ("paid-runtime", &ROBOT_NEVER),
    ("paid-robot-program", &ROBOT_NEVER),
    // What a policy is shown, the same in training, evaluation and on the robot.
    ("paid-play", &["amp", "eval", "learn", "mujoco", "physics", "task", "train"]),
    ("paid-task", &["amp", "learn", "train"]),
    ("paid-plot", &["policy", "motion", "physics", "play", "task"]),
    ("paid-live", &["lab", "runtime", "twin"]),
];

/// What only the program links.
const PROGRAM_ONLY: [&str; 4] = ["paid-lab", "paid-live", "paid-sysid", "paid-twin"];

/// Onboard perception, and what only it links: linear algebra and the general ONNX runtime.
const PERCEPTION: [&str; 5] = ["nalgebra", "paid-lidar", "paid-vision", "paid-world", "rten"];

const MANIFEST: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../Cargo.toml");

/// What cargo answers.
fn cargo(args: &[&str]) -> Vec<u8> {
    let output = Command::new(env!("CARGO"))
        .args(args)
        .args(["--offline", "--manifest-path", MANIFEST])
        .output()
        .expect("cargo runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    output.stdout
}

/// A crate of the workspace: its folder in `crates`, and the crates of ours that it links; not those of its tests.
struct Crate {
    wing: String,
    links: Vec<String>,
}

fn crates() -> BTreeMap<String, Crate> {
    let metadata = cargo(&["metadata", "--format-version", "1", "--no-deps"]);
    let metadata: Value = serde_json::from_slice(&metadata).expect("JSON");
    let text = |value: &Value| value.as_str().expect("a text").to_owned();
    let list = |value: &Value| value.as_array().expect("a list").clone();
    let mut found = BTreeMap::new();
    for package in list(&metadata["packages"]) {
        let folder = text(&package["manifest_path"]).replace('\\', "/");
        let Some((_, place)) = folder.rsplit_once("/crates/") else { continue };
        let wing = place.split('/').next().unwrap_or_default().to_owned();
        let ours = |link: &Value| link["kind"] != "dev" && text(&link["name"]).starts_with("paid-");
        let links =
            list(&package["dependencies"]).iter().filter(|l| ours(l)).map(|l| text(&l["name"])).collect();
        found.insert(text(&package["name"]), Crate { wing, links });
    }
    assert!(found.len() > 20, "{} crates", found.len());
    found
}

/// The shortest way from a crate to another one; `None` if it does not link it.
fn way(crates: &BTreeMap<String, Crate>, from: &str, to: &str) -> Option<String> {
    let mut seen: BTreeMap<&str, &str> = BTreeMap::new();
    let mut waiting = VecDeque::from([from]);
    while let Some(at) = waiting.pop_front() {
        if at == to {
            let steps = std::iter::successors(Some(at), |step| seen.get(step).copied());
            let mut names: Vec<&str> = steps.collect();
            names.reverse();
            return Some(names.join(" -> "));
        }
        for link in crates.get(at).into_iter().flat_map(|of| &of.links) {
            if link != from && !seen.contains_key(link.as_str()) {
                seen.insert(link, at);
                waiting.push_back(link);
            }
        }
    }
    None
}

#[test]
fn a_crate_knows_its_own_folder_and_those_before_it() {
    let crates = crates();
    let rank = |wing: &str| {
        WINGS.iter().position(|w| *w == wing).unwrap_or_else(|| panic!("crates/{wing}: expected {WINGS:?}"))
    };
    for (name, Crate { wing, links }) in &crates {
        for link in links {
            let to =
                &crates.get(link).unwrap_or_else(|| panic!("{name} -> {link}, which is not in crates")).wing;
            assert!(rank(to) <= rank(wing), "{name} in {wing} links {link} in {to}");
        }
    }
}

#[test]
fn nothing_reaches_what_it_must_not_know() {
    let crates = crates();
    for (name, never) in NEVER {
        assert!(crates.contains_key(name), "no crate {name}");
        for other in never {
            let other = format!("paid-{other}");
            assert!(crates.contains_key(&other), "no crate {other}");
            assert_eq!(way(&crates, name, &other), None, "{name} must not link {other}");
        }
    }
}

#[test]
fn only_the_program_links_what_is_made_for_it() {
    let crates = crates();
    for only in PROGRAM_ONLY {
        let by: Vec<&str> = crates
            .iter()
            .filter(|(_, of)| of.links.iter().any(|l| l == only))
            .map(|(n, _)| n.as_str())
            .collect();
        assert_eq!(by, ["paid"], "{only}");
    }
}

#[test]
fn the_robot_program_can_do_without_perception() {
    let linked = |features: &[&str]| -> BTreeSet<String> {
        let tree = ["tree", "--package", "paid-robot-program", "--edges", "normal", "--prefix", "none"];
        let packages = cargo(&[&tree, features].concat());
        let packages = String::from_utf8(packages).expect("a text");
        packages.lines().filter_map(|line| line.split(' ').next()).map(str::to_owned).collect()
    };
    let (all, slim) = (linked(&[]), linked(&["--no-default-features"]));
    for package in PERCEPTION {
        assert!(all.contains(package), "{package} is not in the robot's program");
        assert!(!slim.contains(package), "{package} is in the robot's program without perception");
    }
    assert!(slim.contains("paid-runtime"), "{slim:?}");
}
