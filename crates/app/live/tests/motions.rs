//! A set of motions on the page, with its figures.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::channel;
use std::thread;

use crate::common::{News, Page, address};
use paid_eval::shooting::Grid;
use paid_lab::dataset::{Dataset, PICTURES};
use paid_live::{Command, Motions, ServeOptions, play_motions};
use paid_motion::MotionLibrary;
use paid_play::OwnPlace;
use paid_robot::{RobotModel, RobotSpec};

fn ask(address: SocketAddr, path: &str) -> String {
    let mut stream = TcpStream::connect(address).expect("the server listens");
    write!(stream, "GET {path} HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n").expect("sent");
    let mut answer = String::new();
    stream.read_to_string(&mut answer).expect("an answer");
    answer
}

#[test]
fn a_folder_of_motions_shows_its_kicks_its_figures_and_the_one_to_record() {
    let (robot, spec) = (RobotModel::g1(), RobotSpec::g1());
    let clips = MotionLibrary::builtin(&robot, &spec, 50.0).expect("built in").clips;
    let set = Dataset::new(&clips, &robot, &spec, Grid::EFFECTIVE, OwnPlace::TorsoEnd).expect("kicks");
    let (advice, first) = (set.coverage.advice(), clips[0].name.clone());
    let motions = Motions {
        name: "clips".into(),
        clips,
        pictures: PICTURES,
        share: set.coverage.share(),
        advice: advice.clone(),
        draw: Arc::new(move |name| set.picture(name).map(|figure| figure.svg())),
        robot,
        spec,
    };
    let (stop, (say, hear)) = (AtomicBool::new(false), channel());
    let serve = ServeOptions { port: Some(0), listen: None };
    thread::scope(|scope| {
        let playing = scope.spawn(|| {
            play_motions(&motions, &serve, None, &stop, |url| say.send(address(url)).expect("heard"))
        });
        let address = hear.recv().expect("the page is served");
        let seen = thread::spawn(move || visit(address, &advice, &first)).join();
        stop.store(true, Ordering::Relaxed);
        let summary = playing.join().expect("no panic").expect("it continues");
        seen.expect("everything is there");
        assert_eq!((summary.shots, summary.dropped, summary.refused), (0, 0, 0));
    });
}

fn visit(address: SocketAddr, advice: &str, first: &str) {
    let mut page = Page::open(address, "", None).expect("comes in");
    let News::Scene(scene) = page.next() else { panic!("the scene comes first") };
    assert_eq!((&scene["ball"], &scene["watched"]), (&false.into(), &false.into()));
    assert_eq!(scene["kicks"]["advice"], advice);
    assert!(
        scene["kicks"]["share"].as_str().is_some_and(|share| share.contains("of the balls 0.5 to 2 m ahead"))
    );
    let names: Vec<&str> = scene["kicks"]["pictures"]
        .as_array()
        .expect("four")
        .iter()
        .filter_map(|name| name.as_str())
        .collect();
    assert_eq!(names, PICTURES);
    for name in names {
        let answer = ask(address, &format!("/kicks/{name}.svg"));
        assert!(
            answer.starts_with("HTTP/1.1 200") && answer.contains("content-type: image/svg+xml"),
            "{name}"
        );
        assert!(answer.contains("<svg") && answer.contains(first), "{name}: with the list of the kicks");
    }
    for path in ["/kicks/none.svg", "/kicks/coverage", "/kicks/../Cargo.toml"] {
        assert!(ask(address, path).starts_with("HTTP/1.1 404"), "{path}");
    }
    // The clip begins at the origin; a step later it is a step further, and the third clip can be chosen.
    let frame = page.pause();
    assert_eq!((frame.bodies.len(), frame.ghost.len(), frame.clip), (30, 0, None));
    let frame = page.step(&frame);
    assert!(frame.bodies[0].pos[0].abs() < 0.5 && frame.bodies[0].pos[2] > 0.5, "{:?}", frame.bodies[0]);
    page.send(Command::Clip(Some(2)));
    let frame = page.frame(|frame| frame.clip == Some(2));
    assert!(frame.bodies[0].pos[0].hypot(frame.bodies[0].pos[1]) < 0.1, "{:?}", frame.bodies[0]);
    page.send(Command::Another);
    let named = page.board(|board| board["notice"][0] == 3);
    assert_eq!(named["notice"][1], scene["clips"][3]);
}

#[test]
fn a_page_without_a_set_of_motions_has_no_such_pictures() {
    let options = ServeOptions { port: Some(0), listen: None };
    let (server, _commands) = paid_live::Server::start(&options, "{}".to_owned()).expect("a free port");
    assert!(ask(server.address(), "/kicks/coverage.svg").starts_with("HTTP/1.1 404"));
}
