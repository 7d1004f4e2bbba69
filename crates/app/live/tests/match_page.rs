//! A page that watches matches.

use std::thread;

use crate::common::{News, Page, address, subject};
use paid_eval::matches::{Audience, MatchOptions, evaluate};
use paid_live::{Command, MatchPage, ServeOptions};

#[test]
fn a_match_is_shown_step_by_step_and_the_stop_ends_it() {
    let subject = subject();
    let options = ServeOptions { port: Some(0), listen: None };
    let page = MatchPage::start(&subject, &options).expect("served");
    let mut viewer = Page::open(address(page.url()), "", None).expect("a viewer");
    let News::Scene(scene) = viewer.next() else { panic!("the scene comes first") };
    assert_eq!((&scene["watched"], &scene["bare"]), (&true.into(), &false.into()));

    let of = MatchOptions { kicks: 50, matches: 1, ..MatchOptions::default() };
    let audience = Audience { filmed: 0, spectator: Some(&page) };
    thread::scope(|scope| {
        let playing = scope.spawn(|| evaluate(&subject.setup, &*subject.maker, &of, audience));
        let first = viewer.frame(|frame| frame.bodies.len() > 1);
        let anchor = scene["anchor"].as_u64().expect("a number") as usize;
        let [x, y, _] = first.bodies[anchor].pos;
        assert!(x.hypot(y) < 0.5, "a match begins at the pitch's origin: {x}, {y}");
        assert_eq!((first.ghost.len(), first.flags.kicking), (first.bodies.len(), true));
        let [gx, gy, _] = first.goal;
        assert!((gx.hypot(gy) - 5.0).abs() < 0.01, "the goal is five meters away: {gx}, {gy}");
        assert!(
            first.ball.pos[0] > 0.3 && first.ball.pos[0] < 2.2,
            "the ball lies before it: {:?}",
            first.ball
        );
        // A kick is over when the page receives it.
        viewer.board(|board| board["shots"] == 1);
        viewer.frame(|frame| frame.step > first.step);
        viewer.send(Command::Stop);
        let (report, _) = playing.join().expect("no panic").expect("it runs");
        assert!(report.matches.is_empty(), "a match that was stopped is not reported");
    });
}
