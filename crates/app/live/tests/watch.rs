//! A page that watches.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use crate::common::{News, Page, address};
use paid_live::{Command, Frame, Outcome, ServeOptions, Shot, WatchPage, Watched};
use paid_robot::RobotModel;
use paid_task::TaskPreset;

fn watched<'a>(robot: &'a RobotModel, task: &'a TaskPreset) -> Watched<'a> {
    Watched {
        policy: "mine".into(),
        robot,
        anchor: 0,
        task,
        clips: vec!["kick".into()],
        engine: "MuJoCo",
        stop: "It ends",
    }
}

#[test]
fn who_looks_on_sees_what_happens_and_can_only_stop_it() {
    let task = paid_train::task_preset("stage2", &[]).expect("a preset");
    let robot = RobotModel::g1();
    let options = ServeOptions { port: Some(0), listen: None };
    let mut page = WatchPage::start(watched(&robot, &task), "its senses".into(), &options).expect("served");
    let mut viewer = Page::open(address(&page.url()), "", None).expect("a viewer");
    let News::Scene(scene) = viewer.next() else { panic!("the scene comes first") };
    assert_eq!((&scene["watched"], &scene["policy"]), (&true.into(), &"mine".into()));
    assert_eq!(scene["bodies"].as_array().map(Vec::len), Some(robot.bodies.len()));

    page.show(Frame { step: 7, ..Frame::default() });
    let frame = viewer.frame(|frame| frame.step == 7);
    assert_eq!((frame.viewers, page.viewers()), (1, 1));
    let shot = Shot {
        number: 0,
        outcome: Outcome::Goal,
        speed_m_s: 5.0,
        lateral_m: Some(0.1),
        miss_m: Some(0.0),
        ball: [1.0, 0.0],
        rolling: false,
        clip: "kick".into(),
        engine: "MuJoCo",
        surface: "",
    };
    page.count(shot).expect("told");
    let board = loop {
        if let News::Board(board) = viewer.next()
            && board["shots"] == 1
        {
            break board;
        }
    };
    assert_eq!(board["goals"], 1);

    // Commands come in order: once the stop is there, the reset has had no effect.
    assert!(!page.stop_asked());
    viewer.send(Command::Reset);
    viewer.send(Command::Stop);
    let begin = Instant::now();
    while !page.stop_asked() {
        assert!(begin.elapsed() < Duration::from_secs(60), "the stop is lost");
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(!page.stop_asked(), "once");
}

#[test]
fn the_stop_comes_through_a_flood_while_whoever_shows_is_busy() {
    let task = paid_train::task_preset("stage2", &[]).expect("a preset");
    let robot = RobotModel::g1();
    let options = ServeOptions { port: Some(0), listen: None };
    let stop = Arc::<AtomicBool>::default();
    let page = WatchPage::start_with_stop(watched(&robot, &task), String::new(), &options, &stop);
    let page = page.expect("served");
    let mut viewer = Page::open(address(&page.url()), "", None).expect("a viewer");
    assert!(matches!(viewer.next(), News::Scene(_)));
    // More than may queue for the program, and more than a page may send in a second.
    for _ in 0..4000 {
        viewer.send(Command::Reset);
    }
    assert!(!stop.load(Ordering::Relaxed));
    viewer.send(Command::Stop);
    let begin = Instant::now();
    while !stop.load(Ordering::Relaxed) {
        assert!(begin.elapsed() < Duration::from_secs(60), "the stop is lost");
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(page.stop_asked() && !page.stop_asked(), "once");
    assert!(stop.load(Ordering::Relaxed), "the run's own stays");
}
