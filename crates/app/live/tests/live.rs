//! The scene as a visitor plays with it: by single steps, so that nothing depends on the machine's speed.

use crate::common::{News, Page, demo, played, subject};
use paid_eval::subject::{Subject, SubjectSpec};
use paid_live::Command;
use paid_task::preset::KnowledgeMode;
use serde_json::Value;

/// Steps of a shot from the ball's fall to its verdict, at most.
const LONGEST: usize = 420;

fn distance(a: [f64; 3], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

#[test]
fn a_robot_that_sees_says_where_it_believes_the_ball() {
    let subject = subject();
    played(&subject, 0, |address| {
        let mut page = Page::open(address, "", None).expect("comes in");
        let News::Scene(scene) = page.next() else { panic!("the scene comes first") };
        assert_eq!(scene["camera"]["body"], scene["anchor"]);
        assert_eq!(scene["camera"]["corners"].as_array().map(Vec::len), Some(4));
        page.pause();
        page.send(Command::Drop { at: [1.1, 0.1], velocity: [0.0; 2] });
        let mut frame = page.frame(|f| f.flags.kicking);
        let mut seen = false;
        for _ in 0..60 {
            frame = page.step(&frame);
            let belief = frame.belief.expect("it is not given the true position");
            let off = distance(belief.pos.map(f64::from), [frame.ball.pos[0], frame.ball.pos[1]]);
            assert!(off < 0.15 && belief.deviation_m > 0.0, "{belief:?} {:?}", frame.ball);
            seen |= frame.flags.in_view && belief.age_s < 0.2;
        }
        assert!(seen, "the ball lies 1.1 m ahead");
    });
    let spec = SubjectSpec { knowledge: Some(KnowledgeMode::Truth), ..demo() };
    let told = Subject::load(&spec).expect("the demo's policy");
    played(&told, 0, |address| {
        let mut page = Page::open(address, "", None).expect("comes in");
        let News::Scene(scene) = page.next() else { panic!("the scene comes first") };
        assert_eq!(scene["camera"], Value::Null);
        assert_eq!(page.pause().belief, None);
    });
}

#[test]
fn a_dragged_ball_is_kicked_counted_and_scored() {
    let subject = subject();
    let (board, summary) = played(&subject, 0, |address| {
        let mut page = Page::open(address, "", None).expect("comes in");
        let News::Scene(scene) = page.next() else { panic!("the scene comes first") };
        assert_eq!((&scene["version"], scene["parts"].as_array().map(Vec::len)), (&Value::from(2), Some(55)));
        page.pause();
        let mut board = Value::Null;
        for y in [0.1_f32, -0.2, 0.3] {
            page.send(Command::Hold([1.1, y]));
            let mut frame = page.frame(|f| f.flags.held);
            assert!(distance(frame.ball.pos, [1.1, f64::from(y)]) < 1e-6, "{:?}", frame.ball);
            frame = page.steps(&frame, 3);
            assert!(distance(frame.ball.pos, [1.1, f64::from(y)]) < 1e-6, "the hand holds it");
            page.send(Command::Drop { at: [1.1, y], velocity: [0.0; 2] });
            frame = page.frame(|f| f.flags.kicking && !f.flags.held);
            assert!(distance(frame.ball.pos, [1.1, f64::from(y)]) < 1e-3, "it lies where it was let go");
            let mut touched = false;
            for _ in 0..LONGEST {
                frame = page.step(&frame);
                touched |= frame.flags.touched;
                if !frame.flags.kicking {
                    break;
                }
            }
            assert!(touched && !frame.flags.kicking, "kicked and over: {:?}", frame.flags);
            // The board of this shot, requested again by another page.
            let mut other = Page::open(address, "", None).expect("comes in");
            board = other.board(|_| true);
            if board["goals"].as_u64() >= Some(1) {
                break;
            }
        }
        board
    });
    assert_eq!(board["shots"].as_u64().map(|n| n as usize), Some(summary.shots));
    assert!(summary.goals >= 1, "the demo's policy scores 99 of 100 such balls: {board}");
    let last = &board["last"][0];
    assert!(last["outcome"] == "goal" && last["miss_m"] == 0.0, "{last}");
    assert!(last["speed_m_s"].as_f64() > Some(1.0) && last["lateral_m"].as_f64().is_some(), "{last}");
    let cells = board["cells"].as_array().expect("cells");
    let sum: u64 = cells.iter().filter_map(|c| c["shots"].as_u64()).sum();
    assert_eq!(sum as usize, summary.shots, "every shot is on the heat map");
}

#[test]
fn a_flicked_ball_rolls_a_push_moves_the_robot_and_the_goal_goes_where_it_is_put() {
    let subject = subject();
    let mass = subject.setup.robot.mass();
    let ((), summary) = played(&subject, 0, |address| {
        let mut page = Page::open(address, "", None).expect("comes in");
        let frame = page.pause();
        // Nothing passes while time stands still.
        page.send(Command::Clear);
        assert_eq!(page.frame(|_| true).step, frame.step);

        // Away from the robot: it rolls, turns, and is not kicked.
        page.send(Command::Drop { at: [3.0, 0.0], velocity: [0.0, 2.0] });
        let before = page.frame(|f| distance(f.ball.pos, [3.0, 0.0]) < 1e-3 && f.ball_speed > 1.0);
        let after = page.steps(&before, 10);
        // 0.4 m in 0.2 s but for the damping of the spin.
        assert!((0.3..0.41).contains(&after.ball.pos[1]), "{:?}", after.ball.pos);
        assert!(!after.flags.kicking && !after.flags.auto);
        // It turns about x by its way over its radius of 0.11 m: half of that in the quaternion.
        let [w, x, ..] = after.ball.quat;
        let [w0, x0, ..] = before.ball.quat;
        let turn = 2.0 * (x.atan2(w) - x0.atan2(w0));
        let wrapped = |angle: f64| angle.sin().atan2(angle.cos()).abs();
        let expected = after.ball.pos[1] / 0.11;
        assert!((wrapped(turn) - wrapped(expected)).abs() < 0.4, "{turn} of {expected}");

        // When the ball has come to rest, the robot waits where it is.
        let still = page.steps(&after, 300);
        let later = page.steps(&still, 100);
        assert_eq!(later.bodies, still.bodies);
        assert!(later.ball_speed < 0.06 && !later.flags.fallen && later.bodies[0].pos[2] > 0.6);
        let still = later;

        // 60 N s on a standing robot, to its left.
        let drift = page.step(&still);
        page.send(Command::Push([0.0, 60.0]));
        let pushed = page.step(&drift);
        let speed = (pushed.bodies[0].pos[1] - drift.bodies[0].pos[1]) / 0.02;
        let was = (drift.bodies[0].pos[1] - still.bodies[0].pos[1]) / 0.02;
        let expected = 60.0 / mass;
        assert!(
            (speed - was - expected).abs() < 0.35 * expected,
            "{speed} from {was}, expected {expected} more"
        );

        page.send(Command::Goal([4.0, 4.0]));
        let moved = page.frame(|f| f.goal[1] > 3.0);
        assert_eq!(moved.goal[..2], [4.0, 4.0]);
        assert!((f64::from(moved.goal[2]) - std::f64::consts::FRAC_PI_4).abs() < 1e-6, "it faces the middle");

        // A ball behind the robot, far from the goal: the robot is carried there and looks at the goal.
        page.send(Command::Drop { at: [-2.0, 1.0], velocity: [0.0; 2] });
        let carried = page.frame(|f| f.flags.kicking);
        let to_ball = distance(carried.bodies[0].pos, [-2.0, 1.0]);
        assert!((to_ball - 1.1).abs() < 0.15, "{to_ball}");
    });
    assert_eq!((summary.dropped, summary.refused), (0, 0));
}

#[test]
fn it_plays_by_itself_goes_on_after_a_fall_and_takes_any_clip() {
    let subject = subject();
    let clips = subject.setup.library.len();
    played(&subject, 0, |address| {
        let mut page = Page::open(address, "", None).expect("comes in");
        let frame = page.pause();
        // Down it goes, and after a while it stands again.
        page.send(Command::Push([-120.0, 0.0]));
        let mut fallen = page.frame(|f| f.step >= frame.step);
        for _ in 0..LONGEST {
            fallen = page.step(&fallen);
            if fallen.flags.fallen {
                break;
            }
        }
        assert!(fallen.flags.fallen, "120 N s are too much for anyone");
        // It may struggle: the time on the ground counts from the last fall.
        let mut up = fallen;
        for _ in 0..LONGEST {
            up = page.step(&up);
            if !up.flags.fallen && up.bodies[0].pos[2] > 0.6 {
                break;
            }
        }
        assert!(!up.flags.fallen && up.bodies[0].pos[2] > 0.6, "{:?}", up.bodies[0]);

        page.send(Command::Clip(Some(2)));
        assert_eq!(page.frame(|f| f.clip.is_some()).clip, Some(2));
        page.send(Command::Clip(Some(u16::try_from(clips).expect("few"))));
        let words = page.board(|b| b["notice"][1].as_str().is_some_and(|w| w.contains("no number")));
        assert!(words["notice"][1].as_str().is_some_and(|w| w.contains(&clips.to_string())));
        page.send(Command::Clip(None));
        page.send(Command::Auto(true));
        let mut frame = page.frame(|f| f.flags.auto && f.clip.is_none());
        for _ in 0..LONGEST {
            frame = page.step(&frame);
            if frame.flags.kicking {
                break;
            }
        }
        assert!(frame.flags.kicking, "a ball has come by itself");
    });
}

#[test]
fn the_engine_is_changed_or_stays_and_says_why() {
    let subject = subject();
    let built = subject.in_mujoco().build(1, 0);
    let there = paid_testing::mujoco("the_engine_is_changed_or_stays_and_says_why", built).is_some();
    let ((), summary) = played(&subject, 0, |address| {
        let mut page = Page::open(address, "", None).expect("comes in");
        let frame = page.pause();
        page.send(Command::Engine(1));
        let words = page
            .board(|b| b["notice"][1].as_str().is_some_and(|w| w.contains("ngine") || w.contains("MuJoCo")));
        let words = words["notice"][1].as_str().expect("words").to_owned();
        if !there {
            assert!(words.starts_with("The engine was not changed"), "{words}");
            return;
        }
        assert_eq!(words, "MuJoCo simulates.");
        page.send(Command::Drop { at: [1.0, 0.0], velocity: [0.0; 2] });
        let kicking = page.frame(|f| f.engine == 1 && f.flags.kicking);
        let later = page.steps(&kicking, 40);
        assert!(later.step >= frame.step + 40 && later.bodies[0].pos[2] > 0.5);
        page.send(Command::Engine(0));
        page.frame(|f| f.engine == 0);

        // A ball of the panel is MuJoCo's; the built-in engine has the scene's own.
        page.send(Command::Surface(9));
        let board = page.board(|b| b["surface"] == 9);
        let words = board["notice"][1].as_str().expect("words");
        assert!(words.starts_with("MuJoCo simulates. Ball and ground: turf, grass"), "{words}");
        page.frame(|f| f.engine == 1);
        page.send(Command::Surface(200));
        let words = page.board(|b| b["notice"][1].as_str().is_some_and(|w| w.contains("200")));
        assert_eq!(words["surface"], 9);
        page.send(Command::Engine(0));
        assert_eq!(page.board(|b| b["notice"][1] == "built-in simulates.")["surface"], 0);
    });
    assert!(summary.steps > 0 || !there);
}
