//! The page of a training, from run folders with what a training leaves in them.

use std::fs;
use std::io::Write;
use std::net::SocketAddr;
use std::path::Path;

use crate::common::{News, Page, address};
use paid_live::{Command, Seen, ServeOptions, TrainingPage};
use serde_json::Value;

fn start() -> (TrainingPage, SocketAddr) {
    let page = TrainingPage::start(&ServeOptions { port: Some(0), listen: None }, |error| panic!("{error}"))
        .expect("a free port");
    let at = address(page.url());
    (page, at)
}

/// A run folder in which an iteration of `stage` is logged and its policy saved.
fn after(run: &Path, stage: &str, iteration: u64) {
    fs::create_dir_all(run).expect("a folder");
    let samples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../skill/train/tests/samples");
    let policy = if stage == "stage1" { "stage1.safetensors" } else { "policy.safetensors" };
    fs::copy(samples.join(policy), run.join(format!("model_{iteration}.safetensors"))).expect("a checkpoint");
    let path = run.join("metrics.jsonl");
    let mut log = fs::File::options().append(true).create(true).open(path).expect("a log");
    let reach = if stage == "stage2" { r#","kick/reach":1.0"# } else { "" };
    writeln!(
        log,
        r#"{{"stage":"{stage}","iteration":{iteration},"iterations":9,"samples":{},"metrics":{{"kick/on_target":0.5{reach}}}}}"#,
        iteration * 1_000_000
    )
    .expect("written");
}

/// The next curves that are `wanted`.
fn curves(page: &mut Page, wanted: impl Fn(&Value) -> bool) -> Value {
    loop {
        match page.next() {
            News::Curves(told) if wanted(&told) => return told,
            News::Closed(code) => panic!("closed: {code:?}"),
            _ => {}
        }
    }
}

/// The next scene.
fn scene(page: &mut Page) -> Value {
    loop {
        match page.next() {
            News::Scene(scene) => return scene,
            News::Closed(code) => panic!("closed: {code:?}"),
            _ => {}
        }
    }
}

#[test]
fn nothing_is_read_and_nothing_moves_while_nobody_looks() {
    let folder = tempfile::tempdir().expect("a folder");
    after(folder.path(), "stage2", 1);
    let (page, _) = start();
    page.follow(folder.path());
    // Longer than the thread waits before it looks.
    std::thread::sleep(std::time::Duration::from_millis(400));
    assert_eq!(page.seen(), Seen::default());
}

#[test]
fn the_policy_of_each_checkpoint_plays_beside_the_curves() {
    let folder = tempfile::tempdir().expect("a folder");
    let (page, address) = start();
    let mut viewer = Page::open(address, "", None).expect("comes in");
    // The run has not begun: there are curves without a point and no policy.
    page.follow(folder.path());
    let told = curves(&mut viewer, |_| true);
    assert_eq!((&told["playing"], &told["iteration"]), (&Value::Null, &Value::from(0)));
    after(folder.path(), "stage2", 1);
    assert_eq!(scene(&mut viewer)["ball"], true);
    let told = curves(&mut viewer, |told| told["playing"] == 1);
    assert_eq!(told["curves"][0]["title"], "shots on target");
    assert_eq!(told["curves"][0]["points"], serde_json::json!([[1.0, 0.5]]));
    let frame = viewer.frame(|frame| frame.step > 5);
    assert!(frame.bodies.len() > 20 && page.seen().steps > 5);
    // A visitor may play; the engine stays.
    viewer.send(Command::Engine(1));
    viewer.send(Command::Hold([1.2, 0.1]));
    assert_eq!(viewer.frame(|frame| frame.flags.held).engine, 0);
    viewer.send(Command::Pause(true));
    let still = viewer.frame(|frame| frame.flags.paused);
    viewer.send(Command::Step);
    assert_eq!(viewer.frame(|frame| frame.step != still.step).step, still.step + 1);
    viewer.send(Command::Pause(false));
    // The next checkpoint: the scene continues.
    after(folder.path(), "stage2", 2);
    let told = curves(&mut viewer, |told| told["playing"] == 2);
    assert_eq!(told["curves"][0]["points"], serde_json::json!([[1.0, 0.5], [2.0, 0.5]]));
    let goes_on = viewer.frame(|frame| frame.step > still.step + 3);
    assert!(goes_on.step > still.step && page.seen().policies == 2, "{:?}", page.seen());
}

#[test]
fn a_policy_without_a_ball_follows_clips_until_the_next_stage_has_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let [first, second] = ["stage1", "stage2"].map(|stage| folder.path().join(stage));
    after(&first, "stage1", 3);
    let (page, address) = start();
    page.follow(&first);
    let mut viewer = Page::open(address, "", None).expect("comes in");
    assert_eq!(curves(&mut viewer, |_| true)["curves"][0]["title"], "error of the bodies");
    let told = scene(&mut viewer);
    assert_eq!(told["ball"], false);
    let frame = viewer.frame(|frame| frame.step > 3);
    assert!(!frame.ghost.is_empty() && !frame.flags.kicking);
    viewer.send(Command::Push([10.0, 0.0]));
    viewer.send(Command::Hold([1.0, 0.0]));
    viewer.send(Command::Clip(Some(1)));
    assert!(!viewer.frame(|frame| frame.clip == Some(1)).flags.held);
    // Stage II begins, and has no policy of its own yet.
    page.follow(&second);
    assert_eq!(curves(&mut viewer, |told| told["iteration"] == 0)["playing"], Value::Null);
    let step = viewer.frame(|_| true).step;
    viewer.frame(|frame| frame.step > step);
    after(&second, "stage2", 1);
    assert_eq!(scene(&mut viewer)["ball"], true);
    viewer.frame(|frame| frame.flags.kicking);
}
