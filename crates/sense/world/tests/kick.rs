//! The pipeline on messages made by hand, and recordings of it.

use std::path::Path;

use paid_robot::RobotSpec;
use paid_track::{BallState, Pose};
use paid_vision::{ColorImage, Intrinsics, PictureFault};
use paid_world::{
    Arrived, Believed, Finder, JointMessage, Message, OdometryState, PictureMessage, PoseMessage, Recorded,
    Recorder, Recording, ScanMessage, Sight, SightSetup, decode_any, replay, seconds,
};

const STEP_NS: u64 = 20_000_000;
const LATENCY_NS: u64 = 60_000_000;
const TORSO: [f64; 3] = [0.0, 0.0, 0.8];

fn camera() -> Intrinsics {
    Intrinsics::from_angles(106, 60, 69.0, 42.0)
}

/// Eyes without LiDAR and network: poses and boxes come with the messages.
fn setup() -> SightSetup {
    let g1 = SightSetup::g1().expect("the robot");
    SightSetup { intrinsics: camera(), finder: Finder::Boxes, lidar: None, ..g1 }
}

/// An image with noise of its own and a box around a ball that lies at `ball`, odometry frame.
fn picture(captured_ns: u64, ball: Option<[f64; 2]>, floor: f64) -> PictureMessage {
    let mut state = (captured_ns as u32).wrapping_mul(0x9e37_79b9) | 1;
    let data = (0..3 * 106 * 60).map(|_| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        90 + (state >> 27) as u8
    });
    let color = ColorImage::new(106, 60, data.collect()).expect("whole");
    let torso = Pose { pos: paid_lanes::Vec3(TORSO), ..Pose::identity() };
    let seen = torso.compose(&Pose::g1_camera());
    let boxes = ball.and_then(|[x, y]| camera().sphere_box(seen.inverse_point([x, y, floor + 0.11]), 0.11));
    PictureMessage {
        captured_ns,
        color,
        depth: None,
        intrinsics: camera(),
        boxes: Some(boxes.into_iter().collect()),
    }
}

/// Messages of a robot that stands and looks for `steps` control steps; `ball` gives what the image of a time shows.
fn story(steps: u64, ball: impl Fn(f64) -> Option<[f64; 2]>) -> Vec<Arrived> {
    late_story(steps, LATENCY_NS, ball)
}

/// The same with images of another age.
fn late_story(steps: u64, latency_ns: u64, ball: impl Fn(f64) -> Option<[f64; 2]>) -> Vec<Arrived> {
    let robot = paid_robot::RobotModel::g1();
    let standing = RobotSpec::g1().resolve(&robot).expect("complete").default_pos;
    let mut out = Vec::new();
    for step in 0..steps {
        let at_ns = step * STEP_NS;
        let mut add = |message: Message| out.push(Arrived { at_ns, message });
        add(Message::Joints(JointMessage { stamp_ns: at_ns, positions: standing.clone() }));
        add(Message::Pose(PoseMessage { stamp_ns: at_ns, position: TORSO, quat: [1.0, 0.0, 0.0, 0.0] }));
        if step % 2 == 0 && at_ns >= latency_ns {
            let captured_ns = at_ns - latency_ns;
            add(Message::Picture(Box::new(picture(captured_ns, ball(seconds(captured_ns)), -0.0))));
        }
        add(Message::Step { to_strike_s: f64::INFINITY });
    }
    out
}

fn play(sight: &mut Sight, messages: &[Arrived]) -> Vec<Believed> {
    messages.iter().filter_map(|message| sight.take(message).expect("it runs")).collect()
}

#[test]
fn a_ball_before_the_robot_is_seen_then_remembered_and_black_pictures_do_not_lose_it() {
    let mut sight = Sight::new(setup()).expect("a setup");
    let mut messages = story(100, |_| Some([1.2, 0.1]));
    let later = messages.split_off(messages.len() / 2);
    let last = *play(&mut sight, &messages).last().expect("steps");
    let ball = last.ball.expect("seen in 20 images");
    let [x, y] = ball.belief.ball.position;
    assert_eq!(ball.state, BallState::Seen);
    assert!((x - 1.2).hypot(y - 0.1) < 0.06, "{x} {y}");
    // From here on the lens is covered.
    let dark: Vec<Arrived> = later
        .into_iter()
        .map(|mut arrived| {
            if let Message::Picture(picture) = &mut arrived.message {
                picture.color.data.fill(1);
                // Noise in the dark: no image is the one before.
                let number = picture.captured_ns as usize / 7 % picture.color.data.len();
                picture.color.data[number] = 9;
                picture.boxes = Some(Vec::new());
            }
            arrived
        })
        .collect();
    let last = *play(&mut sight, &dark).last().expect("steps");
    assert!(matches!(last.picture, Some(PictureFault::Black { .. })), "{:?}", last.picture);
    let ball = last.ball.expect("remembered");
    assert!(ball.state == BallState::Remembered && ball.belief.age_s > 0.9, "{ball:?}");
}

#[test]
fn an_empty_floor_where_the_ball_should_be_loses_it() {
    let mut sight = Sight::new(setup()).expect("a setup");
    let messages = story(120, |time_s| (time_s < 1.0).then_some([1.2, 0.1]));
    let believed = play(&mut sight, &messages);
    assert_eq!(believed[49].ball.map(|ball| ball.state), Some(BallState::Seen));
    assert_eq!(believed[119].ball.map(|ball| ball.state), Some(BallState::Lost));
}

#[test]
fn a_rolling_ball_is_followed_by_pictures_of_any_age_that_is_allowed() {
    for latency_ns in [LATENCY_NS, 200_000_000, 400_000_000] {
        let mut sight = Sight::new(setup()).expect("a setup");
        let messages = late_story(100, latency_ns, |time_s| Some([1.2 - 0.2 * time_s, 0.1]));
        let last = *play(&mut sight, &messages).last().expect("steps");
        assert_eq!(last.picture, None);
        let belief = last.ball.expect("seen").belief;
        let ([x, y], age_s) = (belief.ball.position, belief.age_s);
        let true_x = 1.2 - 0.2 * seconds(last.at_ns);
        assert!((x - true_x).hypot(y - 0.1) < 0.1, "{latency_ns}: {x} {y}, {true_x}");
        // By the newest image, or the one before.
        assert!(age_s < seconds(latency_ns) + 0.05, "{latency_ns}: {age_s}");
    }
}

/// A recording of a story, with its estimates.
fn recorded(path: &Path) -> usize {
    let mut sight = Sight::new(setup()).expect("a setup");
    let mut recorder = Recorder::create(path, &setup()).expect("a file");
    let mut steps = 0;
    for message in story(60, |time_s| Some([1.2 - 0.2 * time_s, 0.1])) {
        let believed = sight.take(&message).expect("it runs");
        recorder.message(&message).expect("written");
        if let Some(believed) = believed {
            recorder.believed(&believed).expect("written");
            steps += 1;
        }
    }
    recorder.finish().expect("written");
    steps
}

#[test]
fn a_recording_gives_the_same_messages_and_the_same_beliefs_to_the_last_bit() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("kick.mcap");
    let steps = recorded(&path);
    let recording = Recording::open(&path).expect("a file");
    let mut sight = Sight::new(recording.setup(None).expect("a setup")).expect("a setup");
    let (mut messages, mut equal, mut last) = (Vec::new(), 0, None);
    let read = recording.read(|entry| {
        match &entry {
            Recorded::Message(arrived) => {
                last = sight.take(arrived)?.or(last);
                messages.push(arrived.clone());
            }
            Recorded::Believed { .. } => equal += usize::from(last.as_ref().is_some_and(|b| entry.is(b))),
        }
        Ok(())
    });
    read.expect("whole");
    assert_eq!(messages, story(60, |time_s| Some([1.2 - 0.2 * time_s, 0.1])));
    assert_eq!((equal, steps), (60, 60));
    let mut sight = Sight::new(recording.setup(None).expect("a setup")).expect("a setup");
    let again = replay(&recording, &mut sight, |_| {}).expect("whole");
    assert_eq!((again.steps, again.equal, again.first_different_s), (60, 60, None));
    assert_eq!((again.pictures, again.messages), (28, 3 * 60 + 28));
    // An estimate that differs in one bit is reported.
    let mut other = last.expect("steps");
    if let Some(floor) = &mut other.floor_m {
        *floor = f64::from_bits(floor.to_bits() ^ 1);
    }
    let mut differs = false;
    let read = recording.read(|entry| {
        differs |=
            matches!(&entry, Recorded::Believed { at_ns, .. } if *at_ns == other.at_ns) && !entry.is(&other);
        Ok(())
    });
    read.expect("whole");
    assert!(differs);
}

#[test]
fn what_cannot_be_replayed_is_named_with_file_and_place() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("odd.mcap");
    let recording = |setup: &SightSetup, angles: usize| {
        let mut recorder = Recorder::create(&path, setup).expect("a file");
        let joints = JointMessage { stamp_ns: 5, positions: vec![0.0; angles] };
        recorder.message(&Arrived { at_ns: 5, message: Message::Joints(joints) }).expect("written");
        recorder.finish().expect("written");
        Recording::open(&path).expect("a file")
    };
    let refused = |recording: &Recording| {
        let mut sight = recording.sight(None).expect("a setup");
        replay(recording, &mut sight, |_| {}).expect_err("no replay").to_string()
    };
    let error = refused(&recording(&setup(), 3));
    let expected = "odd.mcap: /joint_states, message 1: joints: expected 29 finite angles, found 3";
    assert!(error.ends_with(expected), "{error}");
    let error = refused(&recording(&setup(), 29));
    let expected = "odd.mcap: /paid/believed: expected beliefs to compare with, found none";
    assert!(error.ends_with(expected), "{error}");
    let neck = SightSetup { torso: "neck".to_owned(), ..setup() };
    let error = recording(&neck, 29).sight(None).expect_err("no neck").to_string();
    let named = error.contains("odd.mcap: /paid/setup: robot ");
    assert!(named && error.ends_with("expected a body 'neck', found none"), "{error}");
}

#[test]
fn a_replay_tells_the_faults_of_the_lidars_data_once() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("mute.mcap");
    let setup = || SightSetup { lidar: Some(paid_lidar::Config::g1()), ..setup() };
    let mut recorder = Recorder::create(&path, &setup()).expect("a file");
    let mut sight = Sight::new(setup()).expect("a setup");
    // Ten scans in the first second, without a sample of the IMU.
    for k in 1..=10_u64 {
        let end_ns = k * 100_000_000;
        let points = (0..200).map(|i| [3.0, 0.01 * f64::from(i), 0.0, 0.0005 * f64::from(i)]).collect();
        let scan = Message::Scan(ScanMessage { start_ns: end_ns - 100_000_000, end_ns, points });
        for message in [scan, Message::Step { to_strike_s: f64::INFINITY }] {
            let arrived = Arrived { at_ns: end_ns + 20_000_000, message };
            recorder.message(&arrived).expect("written");
            if let Some(believed) = sight.take(&arrived).expect("well") {
                recorder.believed(&believed).expect("written");
            }
        }
    }
    recorder.finish().expect("written");
    let recording = Recording::open(&path).expect("a file");
    let result = replay(&recording, &mut recording.sight(None).expect("a setup"), |_| {}).expect("whole");
    assert_eq!((result.equal, result.first_different_s), (10, None));
    let said = "LiDAR: scans come, but no samples of the IMU: without them there is no odometry";
    let [(at_s, fault)] = &result.faults[..] else { panic!("one fault: {:?}", result.faults) };
    // With the fifth scan.
    assert!((at_s - 0.52).abs() < 1e-9 && fault == said, "{at_s} {fault}");
}

#[test]
fn any_bytes_are_a_message_or_an_error() {
    let mut rng = paid_lanes::rng::Rng::new(1, 0, 0);
    let mut good = 0;
    for k in 0..40_000_u32 {
        // Numbers that lengths may have, besides any others.
        let mut bytes: Vec<u8> =
            (0..k % 97).map(|_| if rng.unit() < 0.6 { 0 } else { rng.next_u32() as u8 }).collect();
        if bytes.len() > 4 {
            bytes[1..5].copy_from_slice(&[0, 1, 0, 0]);
        }
        good += u32::from(decode_any(&bytes));
    }
    assert!(good > 100 && good < 39_000, "{good}");
}

#[test]
fn a_cut_recording_is_read_up_to_there_and_a_changed_one_is_never_a_panic() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("kick.mcap");
    recorded(&path);
    let whole = std::fs::read(&path).expect("a file");
    let read = |recording: &Recording| {
        let mut messages = 0;
        let result = recording.read(|_| {
            messages += 1;
            Ok(())
        });
        (result, messages)
    };
    let mut last = 0;
    for share in 0..12 {
        let length = whole.len() * share / 12;
        let recording = Recording::from_bytes(&path, whole[..length].to_vec());
        let (result, messages) = read(&recording);
        if share == 0 {
            let error = result.expect_err("empty").to_string();
            assert!(error.contains("kick.mcap") && error.contains("expected"), "{error}");
            continue;
        }
        // What is whole is read.
        result.expect("whole up to there");
        let end = recording.cut_at().expect("cut off");
        assert!(end <= length && messages >= last, "{share}: {end} of {length}, {messages} messages");
        last = messages;
    }
    let recording = Recording::from_bytes(&path, whole.clone());
    assert_eq!(recording.cut_at(), None);
    let (result, messages) = read(&recording);
    result.expect("whole");
    assert!(0 < last && last < messages, "{last} of {messages}");
    let pointer = b"version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12\n".to_vec();
    let error = Recording::from_bytes(&path, pointer).read(|_| Ok(())).expect_err("a pointer").to_string();
    assert!(
        error.contains("expected an MCAP file, found a Git LFS pointer") && error.contains("git lfs pull"),
        "{error}"
    );
    for k in 0..60_usize {
        let mut changed = whole.clone();
        let at = (k * 7919 * 31) % changed.len();
        changed[at] ^= 0x55;
        // Most changes are in pixels or caught by the file's checksums; none may panic.
        let recording = Recording::from_bytes(&path, changed);
        let _ = recording.setup(None);
        let _ = recording.read(|_| Ok(()));
    }
    let error = Recording::open(Path::new("no.mcap")).expect_err("no file").to_string();
    assert!(error.starts_with("no.mcap:"), "{error}");
}

/// The story with its poses changed: `Some(x)` moves one to another place, `None` leaves it out.
fn with_poses(change: impl Fn(f64) -> Option<f64>) -> Vec<Arrived> {
    let changed = story(150, |_| Some([1.2, 0.1])).into_iter().filter_map(|mut arrived| {
        if let Message::Pose(pose) = &mut arrived.message {
            pose.position[0] += change(seconds(arrived.at_ns))?;
        }
        Some(arrived)
    });
    changed.collect()
}

#[test]
fn another_odometry_that_jumps_or_falls_silent_is_reported_and_moves_no_ball_silently() {
    // A single pose 2 m away, at 1.5 s.
    let mut sight = Sight::new(setup()).expect("a setup");
    let believed = play(&mut sight, &with_poses(|t| Some(if (t - 1.5).abs() < 1e-6 { 2.0 } else { 0.0 })));
    let told = believed[75].odometry.to_string();
    assert!(told.starts_with("lost: pose jumps by 2.00 m") && believed[75].torso.is_none(), "{told}");
    assert_eq!(believed[76].odometry.to_string(), "tracking");
    let ball = believed[149].ball.expect("kept").belief.ball.position;
    assert!((ball[0] - 1.2).hypot(ball[1] - 0.1) < 0.06, "{ball:?}");
    // For good: it is reported, the old ball is forgotten, and found again in the new frame.
    let mut sight = Sight::new(setup()).expect("a setup");
    let believed = play(&mut sight, &with_poses(|t| Some(if t > 1.49 { 2.0 } else { 0.0 })));
    assert!(believed[75..79].iter().all(|b| b.odometry.to_string().starts_with("lost: pose jumps")));
    assert!(believed[79].ball.is_none() && believed[79].odometry == OdometryState::Tracking);
    let ball = believed[149].ball.expect("found again").belief.ball.position;
    assert!((ball[0] - 3.2).hypot(ball[1] - 0.1) < 0.06, "{ball:?}");
    // No pose from 1.5 s on: no place at once, reported within 0.3 s.
    let mut sight = Sight::new(setup()).expect("a setup");
    let believed = play(&mut sight, &with_poses(|t| (t < 1.49).then_some(0.0)));
    assert!(believed[79].torso.is_none());
    let told = believed[88].odometry.to_string();
    assert!(told.starts_with("lost: last pose 0.2"), "{told}");
}

#[test]
fn a_hole_in_the_poses_is_not_bridged_and_poses_at_10_hz_are_joined() {
    let mut sight = Sight::new(setup()).expect("a setup");
    let believed = play(&mut sight, &with_poses(|t| (!(2.305..2.495).contains(&t)).then_some(0.0)));
    assert_eq!(believed[149].odometry, OdometryState::Tracking);
    assert_eq!([2.2, 2.4, 2.55].map(|time_s| sight.torso(time_s).is_some()), [true, false, true]);
    let mut sight = Sight::new(setup()).expect("a setup");
    let tenths = |t: f64| (10.0 * t - (10.0 * t).round()).abs() < 1e-6;
    let believed = play(&mut sight, &with_poses(|t| tenths(t).then_some(0.0)));
    assert_eq!(believed[149].odometry, OdometryState::Tracking);
    assert_eq!([2.15, 2.45, 2.85].map(|time_s| sight.torso(time_s).is_some()), [true; 3]);
}
