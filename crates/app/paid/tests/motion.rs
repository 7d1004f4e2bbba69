//! `paid motion` from end to end, and commands without motions of the user's.

use std::fs;

use crate::common::{paid, refuses, small, succeeds, swing, write_clip, write_motions};
use paid_motion::{Clip, KickLeg};
use serde_json::Value;

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

#[test]
fn the_built_in_library_is_written_checked_and_described() {
    let folder = tempfile::tempdir().expect("folder");
    let written = json(&succeeds(&paid(folder.path(), &["motion", "generate", "--out", "kicks", "--json"])));
    let written = written.as_array().expect("a list");
    assert_eq!(written.len(), 13);
    assert!(written.iter().all(|w| w["pressure_margin_m"].as_f64() > Some(0.005)), "{written:?}");
    let table = succeeds(&paid(folder.path(), &["motion", "check", "kicks"]));
    assert!(table.ends_with("13 clips: 13 pass, 0 warn, 0 fail\n"), "{table}");
    let checked = json(&succeeds(&paid(folder.path(), &["motion", "check", "--json"])));
    let from_memory: Vec<_> = checked.as_array().expect("a list").iter().map(|c| c["name"].clone()).collect();
    let mut from_files: Vec<_> = written.iter().map(|w| w["file"].clone()).collect();
    assert_eq!(from_memory.len(), from_files.len());
    from_files.retain(|file| file.as_str().is_some_and(|f| f.contains("powerful")));
    assert_eq!(from_files.len(), 3);
    let info = succeeds(&paid(folder.path(), &["motion", "info", "kicks/standard"]));
    assert_eq!(info.lines().count(), 11, "{info}");
}

#[test]
fn one_kick_goes_through_csv_and_back() {
    let folder = tempfile::tempdir().expect("folder");
    let args = ["motion", "generate", "--out", "one", "--ball", "0.9,-0.2", "--style", "powerful"];
    let text = succeeds(&paid(folder.path(), &[&args[..], &["--format", "csv"]].concat()));
    assert!(text.contains("kick_right.csv"), "{text}");
    let text =
        succeeds(&paid(folder.path(), &["motion", "convert", "one/kick_right.csv", "--out", "one/back.npz"]));
    assert!(text.contains("right foot") && text.contains("MIT OR Apache-2.0"), "{text}");
    // A folder holds motions of every format.
    for (file, count) in [("one", 2), ("one/kick_right.csv", 1)] {
        let table = succeeds(&paid(folder.path(), &["motion", "check", file]));
        assert!(table.ends_with(&format!("{count} clips: {count} pass, 0 warn, 0 fail\n")), "{table}");
    }
}

#[test]
fn a_clip_that_fails_the_check_is_bad_input() {
    let folder = tempfile::tempdir().expect("folder");
    write_motions(folder.path());
    // These hang in the air and swing a leg: they are for other tests, not for training.
    let output = paid(folder.path(), &["motion", "check", "motions", "--json"]);
    let reports = json(&crate::common::text(&output));
    let verdicts: Vec<_> = reports.as_array().expect("a list").iter().map(|r| r["verdict"].clone()).collect();
    let fails = verdicts.iter().any(|v| v == "fail");
    assert_eq!(output.status.code(), Some(if fails { 2 } else { 0 }), "{verdicts:?}");
    assert!(reports[0]["findings"][0]["reason"].is_string(), "{reports}");
}

#[test]
fn bad_requests_end_in_one_error() {
    let folder = tempfile::tempdir().expect("folder");
    let error = refuses(&paid(folder.path(), &["motion", "generate", "--out", "x", "--ball", "9,0"]));
    assert!(error.contains("expected 0.55 to 2 m"), "{error}");
    assert!(!folder.path().join("x").exists());
    fs::write(folder.path().join("bare.csv"), "1,2,3\n").expect("written");
    let error = refuses(&paid(folder.path(), &["motion", "check", "bare.csv"]));
    assert!(error.contains("bare.csv:1:3: expected 36 numbers"), "{error}");
    let error = refuses(&paid(folder.path(), &["motion", "convert", "bare.csv", "--out", "a.bvh"]));
    assert!(error.contains("bare.csv"), "{error}");
    // What would change nothing, or leave a file that is not read.
    let error = refuses(&paid(folder.path(), &["motion", "check", "--fps", "30"]));
    assert!(error.contains("PATH"), "{error}");
    succeeds(&paid(folder.path(), &["motion", "generate", "--out", "one", "--ball", "0.9,-0.2"]));
    succeeds(&paid(
        folder.path(),
        &["motion", "cut", "one/kick_right.npz", "--to", "0.1", "--out", "brief.npz"],
    ));
    for (option, value, expected) in [
        ("--unit", "1", "--unit: expected a human's motion (.bvh, .amc), found brief.npz"),
        ("--skeleton", "a.asf", "--skeleton: expected a human's motion"),
        ("--rate", "5", "--rate: expected a rate that leaves 2 frames or more"),
    ] {
        let args = ["motion", "convert", "brief.npz", "--out", "again.npz", option, value];
        let error = refuses(&paid(folder.path(), &args));
        assert!(error.contains(expected), "{error}");
    }
    assert!(!folder.path().join("again.npz").exists());
}

#[test]
fn training_without_motions_uses_the_built_in_ones() {
    let folder = tempfile::tempdir().expect("folder");
    let train = small(&["train", "stage1", "--iterations", "1", "--out", "run", "--quiet"]);
    assert_eq!(succeeds(&paid(folder.path(), &train)), "");
    let zero = ["agent", "zero", "--preset", "stage2", "--steps", "5", "--envs", "16"];
    assert!(succeeds(&paid(folder.path(), &zero)).contains("reward/body_pos"));
}

#[test]
fn a_human_kick_becomes_a_clip_and_a_moving_picture() {
    let folder = tempfile::tempdir().expect("folder");
    fs::write(folder.path().join("kick.bvh"), crate::human::kick_bvh(130)).expect("written");
    let args = ["motion", "retarget", "kick.bvh", "--robot", "g1", "--label", "auto", "--license", "ours"];
    let text = succeeds(&paid(folder.path(), &[&args[..], &["--out", "kick.npz"]].concat()));
    assert!(text.contains("108 frames at 50 Hz from LAFAN1 bones, right foot"), "{text}");
    let info = json(&succeeds(&paid(folder.path(), &["motion", "info", ".", "--json"])));
    assert_eq!((info[0]["kick_leg"].as_str(), info[0]["license"].as_str()), (Some("right"), Some("ours")));
    let report = json(&succeeds(&paid(
        folder.path(),
        &["motion", "retarget", "kick.bvh", "--slow", "2", "--out", "slow.csv", "--json"],
    )));
    assert_eq!((report["frames"].as_u64(), report["time_scale"].as_f64()), (Some(216), Some(2.0)));
    for (input, out) in [("kick.bvh", "both.gif"), ("slow.csv", "slow.png"), ("kick.npz", "frames")] {
        let args = ["play", input, "--record", out, "--size", "96x64", "--pictures", "4"];
        assert!(succeeds(&paid(folder.path(), &args)).contains("images of"), "{input}");
    }
    assert!(folder.path().join("frames/frame_0008.png").is_file());
    assert!(fs::read(folder.path().join("both.gif")).expect("written").starts_with(b"GIF89a"));
    // The human's motion again, at another rate, as BVH: the robot does the same.
    let text = succeeds(&paid(
        folder.path(),
        &["motion", "convert", "kick.bvh", "--out", "again.bvh", "--rate", "50"],
    ));
    assert!(text.contains("again.bvh: 108 frames at 50 Hz, 20 bones"), "{text}");
    let text = succeeds(&paid(folder.path(), &["motion", "retarget", "again.bvh", "--out", "again.npz"]));
    assert!(text.contains("108 frames at 50 Hz from LAFAN1 bones, right foot"), "{text}");
    // And as AMC, with its skeleton next to it.
    let text = succeeds(&paid(folder.path(), &["motion", "convert", "again.bvh", "--out", "third.amc"]));
    assert!(text.contains("third.amc: 108 frames at 50 Hz, 20 bones"), "{text}");
    let args = ["motion", "retarget", "third.amc", "--fps", "50", "--out", "third.npz"];
    let text = succeeds(&paid(folder.path(), &args));
    assert!(text.contains("108 frames at 50 Hz from LAFAN1 bones, right foot"), "{text}");
    // Refusals.
    let error = refuses(&paid(folder.path(), &["motion", "convert", "kick.npz", "--out", "kick2.bvh"]));
    assert!(error.contains("kick.npz: expected a human's motion"), "{error}");
    let error =
        refuses(&paid(folder.path(), &["motion", "convert", "kick.bvh", "--out", "a.bvh", "--leg", "left"]));
    assert!(error.contains("--leg"), "{error}");
    let error = refuses(&paid(folder.path(), &["play", "kick.npz", "--record", "a.mp4"]));
    assert!(error.contains("expected a name that ends in .gif or .png, or a folder"), "{error}");
    let error = refuses(&paid(folder.path(), &["play", "--clip", "none", "--record", "a.gif"]));
    assert!(error.contains("one of ") && error.contains("found 'none'"), "{error}");
    let error = refuses(&paid(folder.path(), &["motion", "check", "kick.bvh"]));
    assert!(error.contains("paid motion retarget"), "{error}");
    fs::write(folder.path().join("bad.bvh"), "HIERARCHY\nROOT\n{\n").expect("written");
    let error = refuses(&paid(folder.path(), &["motion", "retarget", "bad.bvh", "--out", "a.npz"]));
    assert!(error.contains("bad.bvh:3:1: expected the name of a joint"), "{error}");
}

#[test]
fn a_kick_is_cut_mirrored_joined_and_cleaned() {
    let folder = tempfile::tempdir().expect("folder");
    let run = |args: &[&str]| succeeds(&paid(folder.path(), args));
    run(&["motion", "generate", "--out", "one", "--ball", "0.9,-0.2"]);
    let text = run(&["motion", "mirror", "one/kick_right.npz", "--out", "left.npz"]);
    assert!(text.contains("left foot"), "{text}");
    let text = run(&["motion", "cut", "left.npz", "--from", "0.2", "--relabel", "--out", "part.npz"]);
    assert!(text.contains("left foot, kick in frame"), "{text}");
    let text = run(&["motion", "cut", "part.npz", "--shift-kick", "-2", "--out", "shifted.npz"]);
    assert!(text.contains("left foot, kick in frame"), "{text}");
    let error = refuses(&paid(
        folder.path(),
        &["motion", "cut", "part.npz", "--shift-kick", "9999", "--out", "x.npz"],
    ));
    assert!(error.contains("--shift-kick: expected a frame of the clip"), "{error}");
    let args = ["motion", "cut", "part.npz", "--to", "0.5", "--shift-kick", "-1", "--out", "x.npz"];
    let error = refuses(&paid(folder.path(), &args));
    assert!(error.contains("--shift-kick: expected a part with the stated kick frame"), "{error}");
    // A file that states another leg than the faster one and no frame: only --relabel changes the leg.
    run(&["motion", "convert", "left.npz", "--leg", "right", "--out", "right.csv"]);
    let stated = fs::read_to_string(folder.path().join("right.csv")).expect("written");
    let lines: Vec<&str> = stated.lines().filter(|line| !line.starts_with("# kick_frame")).collect();
    fs::write(folder.path().join("right.csv"), lines.join("\n")).expect("written");
    let args = ["motion", "cut", "right.csv", "--shift-kick", "-1", "--out", "x.npz"];
    let text = run(&args);
    assert!(text.contains("right foot, kick in frame"), "{text}");
    let text = run(&[&args[..], &["--relabel"]].concat());
    assert!(text.contains("left foot, kick in frame"), "{text}");
    let error =
        refuses(&paid(folder.path(), &["motion", "cut", "part.npz", "--to", "0.02", "--out", "x.npz"]));
    assert!(error.contains("expected a part of at least 3 frames"), "{error}");
    run(&["motion", "join", "one/kick_right.npz", "left.npz", "--out", "both.npz"]);
    let reports = json(&run(&["motion", "clean", "one/kick_right.npz", "--out", "clean", "--json"]));
    let after = reports[0]["after"]["measures"]["penetration_m"]["value"].as_f64().expect("a number");
    assert!(after < 0.010, "{after}");
    assert!(folder.path().join("clean/kick_right.npz").is_file());
    run(&["motion", "cut", "left.npz", "--to", "0.1", "--out", "brief.npz"]);
    let error = refuses(&paid(folder.path(), &["motion", "clean", "brief.npz", "--out", "clean"]));
    assert!(error.contains("brief.npz: expected a motion of 0.5 to 120 s"), "{error}");
}

#[test]
fn a_cleaned_clip_that_fails_ends_in_two_and_each_reason_has_its_own_verdict() {
    let folder = tempfile::tempdir().expect("folder");
    fs::write(folder.path().join("kick.bvh"), crate::human::kick_bvh(130)).expect("written");
    // The right foot kicks.
    let args = ["motion", "retarget", "kick.bvh", "--label", "left", "--clean", "--out", "kick.npz"];
    let output = paid(folder.path(), &args);
    let text = crate::common::text(&output);
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(text.contains("fail: labeled left") && text.contains("warn: states no license"), "{text}");
    assert!(!text.contains("fail: states no license"), "{text}");
    assert!(folder.path().join("kick.npz").is_file());
    // The same without cleaning, as text and as JSON; a clip that only warns is none that fails.
    for (options, code) in
        [(&["--label", "left"][..], 2), (&["--label", "left", "--json"], 2), (&["--json"], 0)]
    {
        let args = [&["motion", "retarget", "kick.bvh", "--out", "raw.npz"], options].concat();
        assert_eq!(paid(folder.path(), &args).status.code(), Some(code), "{options:?}");
    }
    assert!(folder.path().join("raw.npz").is_file());
}

#[test]
fn a_folder_is_checked_and_cleaned_with_options_and_past_a_bad_file() {
    let folder = tempfile::tempdir().expect("folder");
    let at = |name: &str| folder.path().join(name);
    let run = |args: &[&str]| paid(folder.path(), args);
    succeeds(&run(&["motion", "generate", "--out", "one", "--ball", "0.9,-0.2", "--format", "csv"]));
    let stated = fs::read_to_string(at("one/kick_right.csv")).expect("written");
    let bare: Vec<&str> = stated.lines().filter(|line| !line.starts_with('#')).collect();
    fs::create_dir(at("raw")).expect("folder");
    fs::write(at("raw/kick.csv"), bare.join("\n")).expect("written");
    let error = refuses(&run(&["motion", "check", "raw"]));
    assert!(error.contains("raw/kick.csv: the frame rate is not stated"), "{error}");
    let table = succeeds(&run(&["motion", "check", "raw", "--fps", "50"]));
    assert!(table.contains("states no license") && table.contains("1 clips: 0 pass, 1 warn"), "{table}");

    fs::write(at("raw/a_bad.npz"), "not a zip").expect("written");
    let error = refuses(&run(&["motion", "clean", "raw", "--fps", "50", "--leg", "right", "--out", "clips"]));
    assert!(error.contains("1 of 2 files were not cleaned") && error.contains("raw/a_bad.npz: "), "{error}");
    assert!(at("clips/kick.npz").is_file() && !at("clips/a_bad.npz").exists());
    // What is wrong for every file is said once.
    let error = refuses(&run(&["motion", "clean", "raw", "--fps", "50", "--lead", "99", "--out", "none"]));
    assert!(error.contains("--lead: expected 0.5 to 60 s, found 99"), "{error}");
    assert!(!at("none").exists());
}

#[test]
fn clips_that_fail_the_check_are_drawn_with_a_note_that_names_them() {
    let folder = tempfile::tempdir().expect("folder");
    let mut clip = swing(KickLeg::Right);
    clip.body_pos.iter_mut().for_each(|position| position[2] += 0.3);
    write_clip(folder.path(), &Clip { name: "floating".to_owned(), ..clip });
    let output = paid(folder.path(), &["motion", "plot", "motions", "--out", "plots"]);
    succeeds(&output);
    let note = String::from_utf8(output.stderr).expect("UTF-8");
    assert!(note.contains("note: 1 of 1 clips fail `paid motion check`"), "{note}");
    assert!(note.contains("motions/floating.npz (no kick: the foot reaches 0.60 m/s"), "{note}");
    assert!(folder.path().join("plots/coverage.svg").is_file());
    let output = paid(folder.path(), &["motion", "plot", "--out", "plots"]);
    succeeds(&output);
    assert!(output.stderr.is_empty(), "the built-in kicks pass");
}
