//! The camera and the odometry on the wire: images and poses over DDS on the loopback become the runtime's estimates.

use std::sync::Arc;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use crate::common::player;
use paid_runtime::eyes::{CameraInput, Eyes, EyesConfig, EyesPlace, OdometryInput, SensedLink, StampClock};
use paid_runtime::ros::{CAMERA_INFO, IMAGE, ODOMETRY, RosTopics};
use paid_runtime::{ChannelLink, LastWords, Limits, Link, Runtime};
use paid_twin::{Moment, SimCamera, VirtualG1};
use paid_vision::Intrinsics;
use paid_world::PoseMessage;
use paid_world::ros::{write_camera_info, write_color, write_depth, write_odometry};

/// Programs on a loopback without multicast find each other after some seconds; a busy machine takes longer.
const PATIENCE: Duration = Duration::from_secs(90);

/// A domain that no other test has.
fn domain() -> u16 {
    20 + (std::process::id() % 80) as u16
}

#[test]
fn a_rendered_ball_becomes_a_belief_near_its_place() {
    if !crate::common::mujoco("a_rendered_ball_becomes_a_belief_near_its_place") {
        return;
    }
    let player = player();
    let mut robot = VirtualG1::new(Arc::clone(&player)).expect("MuJoCo");
    robot.place_ball([1.2, 0.15], [0.0; 2]);
    robot.step();
    let anchor = player.model.body_index(&player.spec.anchor_body).expect("a torso");
    let moment = Moment::of(&robot, anchor);
    let mut camera = SimCamera::new(Intrinsics::g1_color(), 0.11, 1).expect("a camera");

    let domain = domain();
    let interface = "127.0.0.1".parse().expect("an address");
    let device = RosTopics::open(domain, interface).expect("the loopback");
    let names = CameraInput::default();
    let color = device.writer(&names.color, IMAGE).expect("a topic");
    let depth = device.writer(&names.depth, IMAGE).expect("a topic");
    let info = device.writer(&names.info, CAMERA_INFO).expect("a topic");
    let odometry = device.writer("/odometry", ODOMETRY).expect("a topic");

    let config = EyesConfig {
        domain: None,
        interface: None,
        goal_m: Some([5.0, 0.0]),
        goal_from_senses: false,
        detector: None,
        class: None,
        confidence: None,
        camera: names,
        odometry: OdometryInput::Topic {
            topic: "/odometry".to_owned(),
            child: "torso_link".to_owned(),
            clock: StampClock::System,
        },
    };
    let mut runtime = Runtime::new(Arc::clone(&player), Limits::default());
    let place = EyesPlace { domain, interface };
    let (eyes, lines) =
        Eyes::open(&config, &player, place, runtime.phase(), &LastWords::default()).expect("eyes");
    let (mut to_runtime, link) = ChannelLink::pair();
    let (_, mut inlet) = SensedLink::new(link, eyes.sensed()).split();

    let wall_ns = || SystemTime::now().duration_since(UNIX_EPOCH).expect("after 1970").as_nanos() as u64;
    let torso = moment.torso;
    let pose = |stamp_ns| PoseMessage { stamp_ns, position: torso.pos.0, quat: [1.0, 0.0, 0.0, 0.0] };
    let (begin, mut said, mut packets) = (Instant::now(), Vec::new(), Vec::new());
    let mut believed = None;
    while begin.elapsed() < PATIENCE && believed.is_none() {
        // What the robot sends: its state, where it is, and what it sees. At first in an encoding that is not read here.
        robot.publish(&mut to_runtime).expect("open");
        let stamp_ns = wall_ns();
        odometry.send(write_odometry(&pose(stamp_ns), "odom", "torso_link")).expect("sent");
        info.send(write_camera_info(stamp_ns, camera.intrinsics())).expect("sent");
        let (picture, depths) = camera.picture(&moment);
        depth.send(write_depth(stamp_ns, &depths)).expect("sent");
        let mut bytes = write_color(stamp_ns, &picture);
        if !said.iter().any(|line: &String| line.contains("encoding")) {
            let at = bytes.windows(4).position(|word| word == b"rgb8").expect("an encoding");
            bytes[at..at + 4].copy_from_slice(b"rgba");
        }
        color.send(bytes).expect("sent");
        // What the runtime makes of it.
        for _ in 0..20 {
            std::thread::sleep(Duration::from_millis(2));
            packets.clear();
            packets.extend(std::iter::from_fn(|| inlet.receive().expect("open")));
            runtime.step(begin.elapsed().as_micros() as u64, &packets, false);
        }
        said.extend(lines.try_iter());
        let status = runtime.status(begin.elapsed().as_micros() as u64);
        believed = status.ball_m.filter(|_| status.goal_rad.is_some());
    }
    let [ahead, left] = believed.unwrap_or_else(|| panic!("no belief: {said:?}"));
    let ball = robot.truth().ball.pos.0;
    let (dx, dy) = (ball[0] - torso.pos.x(), ball[1] - torso.pos.y());
    assert!((ahead - dx).hypot(left - dy) < 0.04, "{ahead} {left}, truly {dx} {dy}");
    let expected = "camera: color image: expected encoding rgb8 or bgr8, found rgba";
    assert!(said.iter().any(|line| line == expected), "{said:?}");
    assert!(said.iter().any(|line| line == "odometry: tracking"), "{said:?}");
}
