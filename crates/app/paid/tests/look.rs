//! `paid play` with a policy, and with Rerun if the program has it.

use std::fs;
use std::path::Path;

use crate::common::{folder, paid, refuses, succeeds};

/// Plays half a second of `run` with a ball.
fn play(folder: &Path, more: &[&str]) -> std::process::Output {
    let args = ["play", "--policy", "run", "--task", "paper_stage2", "--limit", "0.5", "--size", "96x64"];
    paid(folder, &[&args[..], &["--pictures", "10"], more].concat())
}

#[test]
fn an_episode_of_a_policy_becomes_pictures_with_ghost_and_forces() {
    let folder = folder();
    let text = succeeds(&play(folder.path(), &["--ball", "0.8,-0.1", "--record", "shot.gif"]));
    assert!(
        text.contains("6 images of") && text.contains("0.50 s") && text.contains("episode over"),
        "{text}"
    );
    assert!(fs::read(folder.path().join("shot.gif")).expect("written").starts_with(b"GIF89a"));
    let last = |more: &[&str], out: &str| {
        let clip = [more, &["--clip", "swing_right", "--record", out]].concat();
        assert!(succeeds(&play(folder.path(), &clip)).contains("on swing_right in"), "{more:?}");
        fs::read(folder.path().join(out).join("frame_0005.png")).expect("an image")
    };
    let (all, bare) = (last(&[], "all"), last(&["--no-ghost", "--no-forces"], "bare"));
    let (forces, ghost) = (last(&["--no-ghost"], "forces"), last(&["--no-forces"], "ghost"));
    // The untrained policy has left the reference by then, and hangs or stands somewhere else.
    assert_ne!(ghost, bare, "the reference is seen");
    assert!(
        all != bare && (forces == bare) == (all == ghost),
        "forces are drawn with and without the reference"
    );
    assert_eq!(bare, last(&["--no-ghost", "--no-forces"], "again"), "an episode repeats exactly");
}

#[test]
fn what_does_not_go_together_is_refused() {
    let folder = folder();
    let refused = |args: &[&str]| refuses(&paid(folder.path(), &[&["play"], args].concat()));
    let error = refused(&["--record", "a.gif", "--ball", "1,0"]);
    assert!(error.contains("--policy"), "{error}");
    let error = refused(&["motions", "--policy", "run", "--record", "a.gif"]);
    assert!(error.contains("cannot be used with"), "{error}");
    // A motion's file has no place for what concerns a policy, a set or a human.
    let file = "motions/swing_left.npz";
    for (option, value) in [
        ("--ball", "1,0"),
        ("--knowledge", "truth"),
        ("--engine", "mujoco"),
        ("--seed", "3"),
        ("--isa", "avx2"),
    ] {
        let error = refused(&[file, "--record", "a.gif", option, value]);
        assert!(error.contains("--policy"), "{option}: {error}");
    }
    for (option, value, expected) in [
        ("--from", "3", "--from: expected a human's motion (.bvh, .amc), found the file"),
        ("--to", "1", "--to: expected a human's motion"),
        ("--height", "1.2", "--height: expected a human's motion"),
        ("--speed-limit", "off", "--speed-limit: expected a human's motion"),
        ("--clip", "foo", "--clip: expected a folder of motions, found the file"),
        ("--fps", "30", "key 'fps': expected no --fps other than the file's 50 frames a second"),
        ("--joint-order", "policy", "--joint-order: expected a file that does not state its order"),
    ] {
        let error = refused(&[file, "--record", "a.gif", option, value]);
        assert!(error.contains(expected), "{error}");
    }
    let error = refused(&["motions", "--record", "a.gif", "--from", "1"]);
    assert!(
        error.contains("--from: expected a human's motion") && error.contains("folder motions"),
        "{error}"
    );
    let error = refused(&["--policy", "run", "--record", "a.gif", "--height", "1.2"]);
    assert!(error.contains("--height: expected a human's motion"), "{error}");
    let error = refused(&["--policy", "run", "--live", "--ball", "1,0"]);
    assert!(error.contains("--ball: expected no page in the browser, found --live"), "{error}");
    let error = refused(&[file, "--record", "a.mp4"]);
    assert!(error.contains("--record: expected a name that ends in .gif or .png"), "{error}");
    let error = refused(&["--policy", "run"]);
    assert!(error.contains("--record"), "{error}");
    let error = refused(&["--policy", "run", "--record", "a.gif", "--clip", "none"]);
    assert!(error.contains("swing_left, swing_right") && error.contains("found 'none'"), "{error}");
    let error = refused(&["--policy", "run", "--record", "a.gif", "--engine", "both"]);
    assert!(error.contains("--engine") && error.contains("both"), "{error}");
    // A task without a ball.
    let error = refused(&["--policy", "run", "--record", "a.gif", "--ball", "1,0"]);
    assert!(error.contains("scene.ball = false"), "{error}");
    assert!(!folder.path().join("a.gif").exists());
}

/// Ctrl-C while the images are drawn.
#[cfg(unix)]
#[test]
fn a_recording_that_is_stopped_leaves_nothing_behind() {
    use std::process::{Command, Stdio};
    use std::thread::sleep;
    use std::time::Duration;

    let folder = tempfile::tempdir().expect("folder");
    crate::common::write_motions(folder.path());
    // The largest images at the highest rate: they take long enough.
    let args = ["play", "motions", "--record", "a.gif", "--size", "2000x2000", "--pictures", "50"];
    let mut command = Command::new(env!("CARGO_BIN_EXE_paid"));
    let mut child = command
        .args(args)
        .current_dir(folder.path())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("starts");
    while !folder.path().join("a.gif.part").exists() {
        assert!(child.try_wait().expect("waits").is_none(), "it ended before it was stopped");
        sleep(Duration::from_millis(5));
    }
    crate::common::kill("-INT", child.id());
    assert_eq!(child.wait().expect("ends").code(), Some(130));
    let names: Vec<_> =
        fs::read_dir(folder.path()).expect("folder").map(|e| e.expect("entry").file_name()).collect();
    assert_eq!(names, ["motions"]);
}

#[cfg(not(feature = "rerun"))]
#[test]
fn without_the_feature_rerun_is_refused_with_the_way_to_get_it() {
    let folder = tempfile::tempdir().expect("folder");
    let error = refuses(&paid(folder.path(), &["play", "--rerun", "kick.rrd"]));
    assert!(
        error.contains("cargo build --release --features rerun") && error.contains("kick.rrd"),
        "{error}"
    );
    assert!(!folder.path().join("kick.rrd").exists());
}

#[cfg(feature = "rerun")]
mod rerun_file {
    use std::collections::BTreeMap;
    use std::io::BufReader;

    use re_sdk::external::re_log_encoding::DecoderApp;
    use re_sdk::log::{Chunk, LogMsg};

    use super::*;

    /// Rows of every entity in a recording; blueprints are left out.
    fn rows(path: &Path) -> BTreeMap<String, usize> {
        let bytes = fs::read(path).expect("written");
        assert!(bytes.starts_with(b"RRF2"), "the format's magic");
        let mut rows = BTreeMap::new();
        for message in DecoderApp::decode_lazy(BufReader::new(&bytes[..])) {
            let LogMsg::ArrowMsg(store, message) = message.expect("decodes") else { continue };
            if store.is_recording() {
                let chunk = Chunk::from_arrow_msg(&message).expect("a chunk");
                *rows.entry(chunk.entity_path().to_string()).or_insert(0) += chunk.num_rows();
            }
        }
        rows
    }

    #[test]
    fn an_episode_is_recorded_with_everything_there_is_to_see() {
        let folder = folder();
        let text = succeeds(&play(folder.path(), &["--rerun", "new/shot.rrd"]));
        assert!(text.contains("new/shot.rrd: 26 frames of"), "{text}");
        let rows = rows(&folder.path().join("new/shot.rrd"));
        for (entity, count) in [
            ("/world/robot/pelvis", 26),
            ("/world/reference/pelvis", 26),
            ("/world/robot/pelvis/capsules", 1),
            ("/world/ground", 1),
            ("/world/goal", 1),
            // A static row for the shape.
            ("/world/ball", 27),
            ("/world/trail", 27),
            ("/world/forces", 27),
            ("/plots/angle/left_knee_joint/robot", 26),
            ("/plots/angle/left_knee_joint/reference", 26),
            ("/plots/speed/left_knee_joint", 26),
            ("/plots/torque/left_knee_joint", 26),
            ("/plots/mark", 26),
            ("/rewards/body_pos", 26),
        ] {
            assert_eq!(rows.get(entity), Some(&count), "{entity} in {rows:?}");
        }
        assert!(rows["/events"] >= 1, "the end, perhaps a kick");
        assert!(!rows.contains_key("/world/human"));
        assert_eq!(fs::read_dir(folder.path().join("new")).expect("there").count(), 1, "no part is left");
    }

    #[test]
    fn a_motion_is_recorded_and_wrong_targets_are_refused() {
        // Motions of our own: making the built-in ones takes long without optimization.
        let folder = tempfile::tempdir().expect("folder");
        crate::common::write_motions(folder.path());
        succeeds(&paid(folder.path(), &["play", "motions", "--rerun", "kick.rrd"]));
        let rows = rows(&folder.path().join("kick.rrd"));
        assert!(rows["/world/trail"] > 50 && rows["/plots/angle/left_knee_joint/robot"] > 50, "{rows:?}");
        assert!(!rows.keys().any(|k| k.contains("reference") || k.contains("rewards") || k.contains("ball")));
        let error = refuses(&paid(folder.path(), &["play", "--rerun", "kick.gif"]));
        assert!(error.contains("expected FILE.rrd, live or") && error.contains("kick.gif"), "{error}");
        // No program listens on port 1.
        let error =
            refuses(&paid(folder.path(), &["play", "motions", "--rerun", "rerun+http://127.0.0.1:1/proxy"]));
        assert!(error.contains("expected a viewer that listens") && error.contains(":1/proxy"), "{error}");
        fs::create_dir(folder.path().join("taken.rrd")).expect("a folder");
        let error = refuses(&paid(folder.path(), &["play", "motions", "--rerun", "taken.rrd"]));
        assert!(error.contains("taken.rrd"), "{error}");
        assert!(!folder.path().join("taken.rrd.part").exists());
    }
}
