//! What `paid eval` refuses, before it evaluates anything.

use std::fs;

use crate::common::{folder, paid, refuses};
use paid_mujoco::Library;

#[test]
fn bad_arguments_are_named() {
    let folder = folder();
    let eval = |args: &[&str]| refuses(&paid(folder.path(), &[&["eval"], args].concat()));
    let error = eval(&["shooting", "--policy", "run"]);
    assert!(error.contains("scene.ball = false") && error.contains("--task paper_stage2"), "{error}");
    let error = eval(&["tracking", "--policy", "absent"]);
    assert!(error.contains("absent"), "{error}");
    let error = eval(&["tracking", "--policy", "run", "--motions", "nowhere"]);
    assert!(error.contains("nowhere"), "{error}");
    fs::write(folder.path().join("bad.onnx"), b"no model").expect("writes");
    let error = eval(&["tracking", "--policy", "bad.onnx", "--motions", "motions"]);
    assert!(error.contains("bad.onnx"), "{error}");
    fs::write(folder.path().join("scene.toml"), "physics_dt_s = 0.003").expect("writes");
    if paid_testing::mujoco("bad_arguments_are_named", Library::get()).is_some() {
        let error = eval(&["tracking", "--policy", "run", "--engine", "mujoco", "--scene", "scene.toml"]);
        assert!(error.contains("--scene: expected a physics_dt_s") && error.contains("0.003"), "{error}");
    }
    fs::write(folder.path().join("scene.toml"), "\nfloor_frictoin = 0.5").expect("writes");
    let error = eval(&["shooting", "--policy", "run", "--engine", "mujoco", "--scene", "scene.toml"]);
    assert!(error.contains("--scene") && error.contains("scene.toml:2: floor_frictoin"), "{error}");
    assert!(error.contains("did you mean 'floor_friction'"), "{error}");
    let shooting = ["shooting", "--policy", "run", "--task", "paper_stage2", "--ball", "static"];
    let error = eval(&[&shooting[..], &["--speed", "0.1", "0.3"]].concat());
    assert!(error.contains("--speed") && error.contains("--ball static"), "{error}");
    let error = eval(&[&shooting[..], &["--eyes-noise", "2"]].concat());
    assert!(error.contains("--knowledge: expected perceived, for eyes.noise_scale"), "{error}");
    let error = eval(&[&shooting[..], &["--knowledge", "perceived", "--eyes-latency-ms", "900"]].concat());
    assert!(error.contains("'--eyes-latency-ms <MS>': expected 0 to 500 ms, found '900'"), "{error}");
    let error = eval(&[&shooting[..], &["--knowledge", "perceived", "--eyes-latency-ms", "nan"]].concat());
    assert!(error.contains("--eyes-latency-ms") && error.contains("found 'nan'"), "{error}");
    assert!(!folder.path().join("scores").exists());
}

#[test]
fn a_negative_number_is_told_its_range() {
    let folder = folder();
    let shooting = ["eval", "shooting", "--policy", "run", "--task", "paper_stage2"];
    let error = |more: &[&str]| refuses(&paid(folder.path(), &[&shooting[..], more].concat()));
    let trials = error(&["--trials", "-1"]);
    assert!(trials.contains("expected a whole number from 0 to 1000000, found '-1'"), "{trials}");
    let limit = error(&["--limit", "-1"]);
    assert!(limit.contains("--limit: expected more than 0 and at most 60 s, found -1"), "{limit}");
}

#[test]
fn a_robot_replaces_the_policys_own() {
    let folder = folder();
    let args = ["eval", "tracking", "--policy", "run", "--robot", "missing.toml"];
    let error = refuses(&paid(folder.path(), &args));
    assert!(error.contains("missing.toml"), "{error}");
}

#[test]
fn an_option_that_would_change_nothing_is_refused() {
    let folder = folder();
    let eval = |args: &[&str]| refuses(&paid(folder.path(), &[&["eval"], args].concat()));
    let shooting = ["shooting", "--policy", "run", "--task", "paper_stage2", "--trials", "1"];
    fs::write(folder.path().join("scene.toml"), "ball_mass_kg = 0.4\nfloor_friction = 0.5").expect("writes");
    let error = eval(&[&shooting[..], &["--scene", "scene.toml"]].concat());
    assert!(error.contains("--scene: floor_friction: expected --engine mujoco or both"), "{error}");
    let error = eval(&[&shooting[..], &["--strips", "3"]].concat());
    assert!(error.contains("--out"), "{error}");
    let error = eval(&["shooting", "--policy", "run", "--set", "scene.terrain={kind=\"plane\"}"]);
    assert!(error.contains("expected no scene.terrain: --ground is the ground of an evaluation"), "{error}");
    let error = eval(&[&shooting[..], &["--ground", "rough-2cm"]].concat());
    assert!(error.contains("--ground rough-2cm: expected --engine mujoco, which alone has it"), "{error}");
    let error = eval(&[&shooting[..], &["--ground", "turf", "--engine", "both"]].concat());
    assert!(error.contains("--ground turf") && error.contains("found both"), "{error}");
    let error = eval(&[&shooting[..], &["--engine", "mujoco", "--ground", "ice"]].concat());
    assert!(error.contains("expected flat, rough-1cm, ") && error.contains("found 'ice'"), "{error}");
    let error = eval(&["terrain", "--policy", "run", "--ground", "hard"]);
    assert!(error.contains("--ground: expected none") && error.contains("found hard"), "{error}");
    let error = eval(&["panel", "--policy", "run", "--ground", "hard"]);
    assert!(error.contains("expected no ground, as the panel has its own"), "{error}");
    let error = eval(&["panel", "--policy", "run", "--scene", "scene.toml"]);
    assert!(error.contains("--scene: expected no ball_mass_kg, as the panel has its own balls"), "{error}");
    let error = refuses(&paid(folder.path(), &["demo", "--live", "--trials", "3"]));
    assert!(error.contains("'--live' cannot be used with '--trials"), "{error}");
}

#[test]
fn what_is_no_policy_or_no_folder_of_motions_is_named_for_what_it_is() {
    let folder = folder();
    let tracking = |more: &[&str]| refuses(&paid(folder.path(), &[&["eval", "tracking"], more].concat()));
    let error = tracking(&["--policy", "motions/swing_left.npz"]);
    assert!(error.contains("swing_left.npz: expected a checkpoint (.safetensors) or .onnx"), "{error}");
    assert!(error.contains("found a zip archive"), "{error}");
    let error = tracking(&["--policy", "run/preset.toml"]);
    assert!(error.contains("found a text file"), "{error}");
    fs::create_dir(folder.path().join("demo")).expect("a folder");
    fs::copy(folder.path().join("run/policy.onnx"), folder.path().join("demo/kick.onnx")).expect("copies");
    let error = tracking(&["--policy", "demo"]);
    assert!(error.contains("found kick.onnx; name one of them"), "{error}");
    let error = tracking(&["--policy", "run", "--motions", "motions/swing_left.npz"]);
    assert!(error.contains("--motions: expected a folder of motion files, found the file"), "{error}");
    let error = refuses(&paid(folder.path(), &["eval", "match", "--policy", "run", "--film", "a.mp4"]));
    assert!(error.contains("--film: expected a name that ends in .gif or .png"), "{error}");
}

#[test]
fn an_output_that_cannot_be_written_is_refused_before_the_evaluation() {
    let folder = folder();
    fs::write(folder.path().join("taken"), "precious").expect("a file");
    for args in [
        &["tracking", "--policy", "run"][..],
        &["shooting", "--policy", "run", "--task", "paper_stage2"],
        &["match", "--policy", "run", "--task", "paper_stage2"],
        &["clips", "--policy", "run", "--task", "paper_stage2"],
    ] {
        for (out, expected) in [("taken", "found the file taken"), ("taken/below", "taken/below: expected")] {
            let output = paid(folder.path(), &[&["eval"], args, &["--out", out]].concat());
            let error = refuses(&output);
            assert!(error.contains("--out") && error.contains(expected), "{error}");
            assert!(output.stdout.is_empty() && !error.contains("trials/s"), "nothing has run: {error}");
        }
    }
    assert_eq!(fs::read_to_string(folder.path().join("taken")).expect("the file"), "precious");
    let error = refuses(&paid(folder.path(), &["eval", "scene", "--out", "taken/scene.xml"]));
    assert!(error.contains("--out") && !error.contains(".part"), "{error}");
}
