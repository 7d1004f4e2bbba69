//! The page in a real browser: headless Chromium, driven over its DevTools protocol.
//!
//! `PAID_CHROMIUM` names the program; without it the test is skipped, for it takes minutes where a software renderer draws two frames a
//! second. `PAID_LIVE_SHOTS` names a folder for the screenshots.

mod devtools;

use std::path::PathBuf;
use std::time::{Duration, Instant};

use crate::common::{played, subject};
use devtools::Browser;

/// How long the page may take for anything. A software renderer on a busy machine draws a few frames a second.
const LONGEST: Duration = Duration::from_secs(150);

fn wait(browser: &mut Browser, what: &str, condition: &str) {
    let start = Instant::now();
    while browser.eval(condition) != "true" {
        assert!(start.elapsed() < LONGEST, "{what}: {condition} is {}", browser.eval(condition));
        std::thread::sleep(Duration::from_millis(100));
    }
}

/// The pixel that shows a point of the scene.
fn pixel(browser: &mut Browser, point: &str) -> [f64; 2] {
    let text = browser.eval(&format!("paid.view.project({point}).join(' ')"));
    let mut numbers = text.split(' ').map(|n| n.parse().expect("a number"));
    [numbers.next().expect("x"), numbers.next().expect("y")]
}

fn screenshot(browser: &mut Browser, name: &str) {
    let png = browser.screenshot();
    assert!(png.len() > 20_000, "{name}: {} bytes are an empty image", png.len());
    if let Some(folder) = std::env::var_os("PAID_LIVE_SHOTS") {
        let folder = PathBuf::from(folder);
        std::fs::create_dir_all(&folder).expect("a folder");
        std::fs::write(folder.join(format!("{name}.png")), png).expect("written");
    }
}

#[test]
fn a_visitor_plays_in_a_browser() {
    let Some(program) = devtools::find() else {
        paid_testing::without_program(
            "a_visitor_plays_in_a_browser",
            "PAID_CHROMIUM, the program of a Chromium (minutes with a software renderer)",
        );
        return;
    };
    let subject = subject();
    let mut browser = Browser::start(&program);
    let (address, _) = played(&subject, 0, |address| {
        let begun = Instant::now();
        browser.open(&format!("http://{address}/"));
        wait(&mut browser, "the scene comes", "typeof paid == 'object' && paid.state.moment != null");
        println!("first frame after {:.1} s", begun.elapsed().as_secs_f64());
        plays(&mut browser);
        looks(&mut browser);
        address
    });

    // The program is gone; the page waits, and continues with the next one.
    wait(&mut browser, "the page notices", "!document.getElementById('gone').hidden");
    played(&subject, address.port(), |_| {
        wait(&mut browser, "the page comes back", "document.getElementById('gone').hidden");
        browser.eval("paid.course.frames.length = 0");
        wait(&mut browser, "frames come", "paid.course.frames.length > 1");
    });
    // A connection that is refused while the program restarts is the network's message, not the page's.
    let errors: Vec<&String> =
        browser.errors.iter().filter(|e| !e.contains("ERR_CONNECTION_REFUSED")).collect();
    assert!(errors.is_empty(), "{errors:#?}");
}

/// Drag, flick, push, pause, engine.
fn plays(browser: &mut Browser) {
    let pictures = browser.eval(
        "new Promise(done => { let n = 0; const t = performance.now(); \
         (function next() { n++; performance.now() - t > 2000 ? done(n / 2) : requestAnimationFrame(next); })(); })",
    );
    println!("{pictures} frames a second, {}", browser.eval("document.getElementById('status').textContent"));

    // Drag the ball to (1.2, 0.2) before the robot.
    let from = pixel(browser, "paid.state.moment.ball.pos");
    let to = pixel(browser, "[1.2, 0.2, 0.11]");
    browser.press(from);
    assert_eq!(browser.eval("paid.hand.holds.what"), "ball");
    for k in 1..=8 {
        let t = f64::from(k) / 8.0;
        browser.move_to([from[0] + t * (to[0] - from[0]), from[1] + t * (to[1] - from[1])]);
    }
    let ball = "paid.course.newest.ball.pos";
    let there = format!("Math.hypot({ball}[0] - 1.2, {ball}[1] - 0.2) < 0.05");
    wait(browser, "it is held there", &format!("paid.course.newest.held && {there}"));
    browser.settle();
    screenshot(browser, "drag");
    browser.release(to);
    wait(browser, "the robot kicks", "paid.course.newest.kicking || paid.panel.shots >= 1");
    wait(browser, "the shot is over", "paid.panel.shots >= 1");
    screenshot(browser, "shot");
    assert_eq!(browser.eval("document.querySelectorAll('#list li').length"), "1");

    // Again, from the other side.
    browser.eval("document.getElementById('replay').click()");
    assert_eq!(browser.eval("paid.course.replay !== null"), "true");
    std::thread::sleep(Duration::from_millis(3000));
    screenshot(browser, "replay");
    browser.eval("paid.state.stopReplay()");

    // Flick it away: it rolls, and the robot does not follow it.
    browser.eval("paid.link.send(paid.command.drop([-3, -2], [0, -1.5])); 0");
    wait(browser, "it rolls", "paid.course.newest.ball.pos[1] < -2.3 && !paid.course.newest.kicking");

    // Time stands still: push the robot with an arrow, look, advance by one step.
    browser.key(" ", "Space");
    wait(browser, "it stands still", "paid.course.newest.paused");
    browser.settle();
    let anchor = "paid.state.moment.bodies[paid.view.scene.anchor].pos";
    let chest = pixel(browser, &format!("{anchor}.map((x, i) => x + (i == 2 ? 0.13 : 0))"));
    browser.press(chest);
    assert_eq!(browser.eval("paid.hand.holds.what"), "robot");
    browser.move_to([chest[0] + 60.0, chest[1]]);
    browser.settle();
    screenshot(browser, "push");
    let impulse: f64 = browser.eval("Math.hypot(...paid.hand.impulse())").parse().expect("a number");
    assert!(impulse > 3.0, "{impulse} N s");
    browser.release([chest[0] + 60.0, chest[1]]);
    let step: u32 = browser.eval("paid.course.newest.step").parse().expect("a number");
    browser.key(".", "Period");
    wait(browser, "one step", &format!("paid.course.newest.step == {}", step + 1));
    browser.key(" ", "Space");
    wait(browser, "it continues", &format!("paid.course.newest.step > {}", step + 5));

    // MuJoCo, or a word why not.
    browser.eval("paid.panel.notice = -1; paid.link.send(paid.command.engine(1)); 0");
    wait(
        browser,
        "the engine",
        "paid.course.newest.engine == 1 || /engine stays/.test(document.getElementById('toast').textContent)",
    );
    browser.eval("paid.link.send(paid.command.engine(0)); 0");
    wait(browser, "and back", "paid.course.newest.engine == 0");
    // Every layer, and a heat map.
    browser.eval("for (const l of ['ghost', 'forces', 'rewards', 'heat', 'belief']) document.getElementById('layer-' + l).click(); 0");
    browser.eval("paid.hand.follow = true; paid.link.send(paid.command.auto(true)); 0");
    wait(browser, "it plays by itself", "paid.panel.shots >= 3");
    wait(browser, "what it believes comes, too", "paid.state.moment.belief.deviation > 0");
    wait(browser, "and touches the ball", "paid.course.newest.touched && paid.course.newest.kicking");
    screenshot(browser, "layers");
    browser.eval("for (const l of ['ghost', 'forces', 'rewards', 'heat', 'belief']) document.getElementById('layer-' + l).click(); 0");
}

/// Dark, small, reloaded.
fn looks(browser: &mut Browser) {
    browser.eval("document.getElementById('more').click(); 0");
    browser.scheme("dark");
    wait(browser, "it is dark", "paid.view.dark");
    wait(browser, "a kick", "paid.course.newest.kicking && paid.course.newest.touched");
    screenshot(browser, "dark");
    browser.scheme("light");
    browser.eval("document.getElementById('more').click(); 0");
    browser.size(390, 844, true);
    wait(browser, "it is small", "paid.view.aspect < 1");
    std::thread::sleep(Duration::from_millis(1500));
    screenshot(browser, "phone");
    browser.size(1280, 800, false);
    let shots: u32 = browser.eval("paid.panel.shots").parse().expect("a number");
    // The page that is left is marked: a busy browser continues with it for a while.
    browser.eval("paid.left = true; location.reload(); 0");
    wait(
        browser,
        "it comes back",
        &format!("typeof paid == 'object' && !paid.left && paid.panel && paid.panel.shots >= {shots}"),
    );
}
