//! Bad input ends in one clear error and exit code 2, and leaves earlier files whole.

use std::fs;

use crate::common::{paid, refuses, small, succeeds, swing, write_clip, write_motions};
use paid_motion::{Clip, KickLeg, Points, write_points};

#[test]
fn a_missing_or_empty_motion_folder_is_named() {
    let folder = tempfile::tempdir().expect("folder");
    fs::create_dir(folder.path().join("empty")).expect("folder");
    for name in ["absent", "empty"] {
        for args in [
            &["motion", "info", name][..],
            &["train", "stage1", "--motions", name],
            &["agent", "random", "--motions", name],
        ] {
            let error = refuses(&paid(folder.path(), args));
            assert!(error.contains(name), "{error}");
        }
    }
}

#[test]
fn a_motion_with_nan_names_file_and_key() {
    let folder = tempfile::tempdir().expect("folder");
    let mut clip = swing(KickLeg::Left);
    clip.joint_pos[40] = f64::NAN;
    write_clip(folder.path(), &Clip { name: "broken".to_owned(), ..clip });
    for args in [&["motion", "info", "motions"][..], &["train", "stage1", "--motions", "motions"]] {
        let error = refuses(&paid(folder.path(), args));
        assert!(error.contains("broken.npz") && error.contains("joint_pos"), "{error}");
    }
}

#[test]
fn a_motion_file_that_is_none_is_named() {
    let folder = tempfile::tempdir().expect("folder");
    write_motions(folder.path());
    fs::write(folder.path().join("motions/aaa.npz"), b"not a zip").expect("file");
    let error = refuses(&paid(folder.path(), &["motion", "info", "motions"]));
    assert!(error.contains("aaa.npz"), "{error}");
}

#[test]
fn a_run_that_is_not_there_is_not_resumed_by_a_new_one() {
    let folder = tempfile::tempdir().expect("folder");
    let error = refuses(&paid(folder.path(), &["train", "--resume", "--out", "mistyped"]));
    assert!(error.contains("--resume: expected a run in mistyped/stage1 or mistyped/stage2"), "{error}");
    assert!(!folder.path().join("mistyped").exists());
}

#[test]
fn an_unknown_preset_key_comes_with_a_suggestion() {
    let folder = tempfile::tempdir().expect("folder");
    for (command, set, hint) in [
        (&["train", "stage1"][..], "task.rewards.action_rat.weight=-1", "action_rate"),
        (&["train", "stage2"], "learn.ppo.gama=0.9", "gamma"),
        (&["agent", "zero"], "run.sede=1", "seed"),
    ] {
        let args = [command, &["--motions", "motions", "--set", set]].concat();
        let error = refuses(&paid(folder.path(), &args));
        assert!(error.contains(set.split('=').next().expect("key")) && error.contains(hint), "{error}");
    }
    let error = refuses(&paid(folder.path(), &["agent", "zero", "--preset", "stage9"]));
    assert!(error.contains("stage9") && error.contains("stage1"), "{error}");
}

#[test]
fn a_preset_without_a_ball_for_stage_two_or_beside_a_resumed_run_is_refused_before_anything_is_trained() {
    let folder = tempfile::tempdir().expect("folder");
    write_motions(folder.path());
    let base = ["train", "--motions", "motions", "--iterations", "1", "--quiet"];
    let error = refuses(&paid(folder.path(), &small(&[&base[..], &["--stage2-preset", "stage1"]].concat())));
    assert!(error.contains("--stage2-preset stage1: Stage II kicks a ball"), "{error}");
    assert!(!folder.path().join("runs").exists());

    let one = ["train", "stage1", "--motions", "motions", "--iterations", "1", "--quiet"];
    succeeds(&paid(folder.path(), &small(&one)));
    let resumed = ["train", "stage1", "--resume", "--iterations", "2", "--preset", "stage1"];
    let error = refuses(&paid(folder.path(), &resumed));
    assert!(error.contains("runs/stage1 has a preset") && error.contains("--set"), "{error}");
}

#[test]
fn an_output_folder_that_cannot_be_made_is_named() {
    let folder = tempfile::tempdir().expect("folder");
    write_motions(folder.path());
    fs::write(folder.path().join("file"), "precious").expect("file");
    let args = small(&["train", "stage1", "--motions", "motions", "--iterations", "1", "--out", "file/run"]);
    let error = refuses(&paid(folder.path(), &args));
    assert!(error.contains("file/run"), "{error}");
    assert_eq!(fs::read_to_string(folder.path().join("file")).expect("file"), "precious");
}

#[test]
fn a_checkpoint_of_another_architecture_is_refused_and_files_stay_whole() {
    let folder = tempfile::tempdir().expect("folder");
    write_motions(folder.path());
    let train =
        small(&["train", "stage1", "--motions", "motions", "--iterations", "1", "--out", "a", "--quiet"]);
    succeeds(&paid(folder.path(), &train));
    let checkpoint = fs::read(folder.path().join("a/model_1.safetensors")).expect("checkpoint");

    let mut other =
        small(&["train", "stage1", "--motions", "motions", "--iterations", "2", "--from", "a", "--out", "b"]);
    other.extend(["--set", "learn.actor.hidden=[24]"]);
    let error = refuses(&paid(folder.path(), &other));
    assert!(error.contains("model_1.safetensors") && error.contains("24") && error.contains("16"), "{error}");

    let resume = [
        "train",
        "stage1",
        "--resume",
        "--out",
        "a",
        "--iterations",
        "2",
        "--set",
        "learn.actor.hidden=[24]",
    ];
    let error = refuses(&paid(folder.path(), &resume));
    assert!(error.contains("model_1.safetensors"), "{error}");
    assert_eq!(fs::read(folder.path().join("a/model_1.safetensors")).expect("checkpoint"), checkpoint);

    // A run folder that is taken is not overwritten by a fresh run.
    let error = refuses(&paid(folder.path(), &train));
    assert!(error.contains("--resume"), "{error}");

    // A damaged checkpoint.
    fs::write(folder.path().join("cut.safetensors"), &checkpoint[..checkpoint.len() / 2]).expect("file");
    let error = refuses(&paid(folder.path(), &["export", "cut.safetensors", "--out", "p.onnx"]));
    assert!(error.contains("cut.safetensors"), "{error}");
    assert!(!folder.path().join("p.onnx").exists());
}

#[test]
fn export_names_what_is_missing_or_cannot_be_written() {
    let folder = tempfile::tempdir().expect("folder");
    write_motions(folder.path());
    let error = refuses(&paid(folder.path(), &["export", "absent"]));
    assert!(error.contains("absent"), "{error}");
    let train =
        small(&["train", "stage1", "--motions", "motions", "--iterations", "1", "--out", "a", "--quiet"]);
    succeeds(&paid(folder.path(), &train));
    let error = refuses(&paid(folder.path(), &["export", "a", "--out", "nowhere/p.onnx"]));
    assert!(error.contains("nowhere/p.onnx"), "{error}");
    let small = ["--checkpoint", "small.safetensors"];
    let absent = [&["export", "a", "--with-reference", "absent.npz"][..], &small].concat();
    let error = refuses(&paid(folder.path(), &absent));
    assert!(error.contains("absent.npz"), "{error}");
    assert!(!folder.path().join("small.safetensors").exists());
    let error = refuses(&paid(folder.path(), &["export", "a", "--out", "p", "--checkpoint", "p"]));
    assert!(error.contains("--checkpoint: expected a file other than --out, found p"), "{error}");
}

#[test]
fn wrong_arguments_are_refused() {
    let folder = tempfile::tempdir().expect("folder");
    for args in [&["trian"][..], &["train", "stage3"], &["agent", "clever"], &["export"]] {
        refuses(&paid(folder.path(), args));
    }
}

#[test]
fn options_of_the_cleaning_ask_for_it() {
    let folder = tempfile::tempdir().expect("folder");
    fs::write(folder.path().join("kick.bvh"), crate::human::kick_bvh(130)).expect("written");
    for option in ["--clean-rate", "--stretch", "--torque", "--lead", "--facing"] {
        let args = ["motion", "retarget", "kick.bvh", "--out", "kick.npz", option, "2"];
        let error = refuses(&paid(folder.path(), &args));
        assert!(error.contains("--clean\n"), "{option}: {error}");
    }
    assert!(!folder.path().join("kick.npz").exists());
    // The defaults change nothing.
    succeeds(&paid(folder.path(), &["motion", "retarget", "kick.bvh", "--out", "kick.npz"]));
}

#[test]
fn two_files_are_not_cleaned_to_one() {
    let folder = tempfile::tempdir().expect("folder");
    for name in ["a", "b"] {
        fs::create_dir_all(folder.path().join("raw").join(name)).expect("folder");
        fs::write(folder.path().join("raw").join(name).join("kick.csv"), "0").expect("file");
    }
    let error = refuses(&paid(folder.path(), &["motion", "clean", "raw", "--out", "clips"]));
    for name in ["clips/kick.npz", "raw/a/kick.csv", "raw/b/kick.csv"] {
        assert!(error.contains(name), "{error}");
    }
    assert!(!folder.path().join("clips").exists());
}

#[test]
fn files_that_belong_together_are_written_together_or_not_at_all() {
    let folder = tempfile::tempdir().expect("folder");
    let files = |name: &str| fs::read_dir(folder.path().join(name)).expect("lists").count();
    fs::write(folder.path().join("kick.bvh"), crate::human::kick_bvh(40)).expect("written");
    fs::create_dir_all(folder.path().join("human/k.amc")).expect("in the way");
    let error = refuses(&paid(folder.path(), &["motion", "convert", "kick.bvh", "--out", "human/k.amc"]));
    assert!(error.contains("human/k.amc"), "{error}");
    assert_eq!(files("human"), 1, "no skeleton without its motion");
    fs::create_dir_all(folder.path().join("plots/foot_speed.svg")).expect("in the way");
    let error = refuses(&paid(folder.path(), &["motion", "plot", "--out", "plots"]));
    assert!(error.contains("plots/foot_speed.svg"), "{error}");
    assert_eq!(files("plots"), 1, "no image without the others");
}

#[test]
fn what_is_wrong_with_a_motion_is_told_with_its_file_and_what_it_is() {
    let folder = tempfile::tempdir().expect("folder");
    let refused = |args: &[&str]| refuses(&paid(folder.path(), args));
    fs::write(folder.path().join("empty.npz"), "").expect("written");
    let error = refused(&["motion", "retarget", "empty.npz", "--out", "a.npz"]);
    assert!(error.contains("empty.npz: expected an NPZ archive"), "{error}");

    fs::create_dir(folder.path().join("points")).expect("folder");
    let points = Points { names: vec!["hip".to_owned()], fps: None, frames: 2, pos: vec![[0.0; 3]; 2] };
    write_points(&folder.path().join("points/human.npz"), &points).expect("written");
    for args in [
        &["motion", "check", "points"][..],
        &["motion", "check", "points/human.npz"],
        &["motion", "info", "points"],
        &["motion", "clean", "points", "--out", "clips"],
        &["motion", "mirror", "points/human.npz", "--out", "a.npz"],
        &["motion", "convert", "points/human.npz", "--out", "a.csv"],
    ] {
        let error = refused(args);
        assert!(error.contains("human.npz: key 'positions': expected a motion of the robot"), "{error}");
        assert!(error.contains("`paid motion retarget`"), "{error}");
    }

    let error = refused(&["motion", "generate", "--out", "x", "--ball", "9,9"]);
    assert!(error.contains("--ball: expected") && error.contains("found (9.00, 9.00) m"), "{error}");

    write_motions(folder.path());
    fs::write(folder.path().join("file"), "precious").expect("written");
    let clip = "motions/swing_left.npz";
    for args in [
        &["motion", "plot", "motions", "--out", "file"][..],
        &["motion", "clean", clip, "--out", "file"],
        &["motion", "generate", "--out", "file"],
    ] {
        let error = refused(args);
        assert!(error.contains("--out file: expected a folder, found a file"), "{error}");
    }
    assert_eq!(fs::read_to_string(folder.path().join("file")).expect("there"), "precious");

    let error = refused(&["motion", "cut", clip, "--from", "50", "--out", "a.npz"]);
    assert!(error.contains("--from, --to: expected a part of at least 3 frames"), "{error}");
    assert!(error.contains("found 50 s to the end of the ") && error.contains(clip), "{error}");
    fs::write(folder.path().join("kick.bvh"), crate::human::kick_bvh(40)).expect("written");
    let error = refused(&["motion", "retarget", "kick.bvh", "--from", "50", "--to", "60", "--out", "a.npz"]);
    assert!(error.contains("found 50 s to 60 s of the ") && error.contains(" s of kick.bvh"), "{error}");
}
