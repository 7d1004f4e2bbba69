//! The readers of ROS 2's messages and of recordings on thousands of damaged ones: an error with what was expected and found, or a message
//! that is whole; never a panic. `fuzz/` does the same without end, and `PAID_MUTATIONS=10000000` makes this as long as you like.

use std::path::Path;

use paid_testing::damaged;
use paid_vision::{ColorImage, DepthImage, Intrinsics};
use paid_world::ros::{
    Stamped, read_camera_info, read_color, read_depth, read_imu, read_odometry, read_points,
    write_camera_info, write_color, write_depth, write_imu, write_odometry, write_points,
};
use paid_world::{
    Arrived, ImuMessage, Message, PictureMessage, PoseMessage, Recorder, Recording, ScanMessage, SightError,
    SightSetup, decode_any,
};

const NOW_NS: u64 = 1_700_000_000_123_456_789;

/// How many damaged messages a reader gets: this many, or the variable's value.
fn times(usual: u32) -> u32 {
    std::env::var("PAID_MUTATIONS").ok().and_then(|text| text.parse().ok()).unwrap_or(usual)
}

/// Reads `seed` as it is, then damaged; `sound` checks what holds for all that is read.
fn run<T>(
    name: &str,
    seed: &[u8],
    read: impl Fn(&[u8]) -> Result<Stamped<T>, SightError>,
    sound: impl Fn(&T) -> bool,
) {
    assert!(read(seed).is_ok_and(|read| sound(&read.value)), "{name}: the undamaged message is read");
    let mut counts = [0_u32; 2];
    let times = times(4000);
    for number in 0..times {
        match read(&damaged(seed, number)) {
            Ok(read) => {
                counts[0] += 1;
                assert!(sound(&read.value) && read.stamp_ns >= 1_000_000_000, "{name} {number}");
            }
            Err(error) => {
                counts[1] += 1;
                assert!(error.to_string().len() < 20_000, "{name} {number}: {error}");
            }
        }
    }
    assert!(counts.iter().all(|count| *count > times / 100), "{name}: {counts:?}");
    println!("{name}: {} read, {} refused", counts[0], counts[1]);
}

fn color() -> ColorImage {
    ColorImage::new(4, 3, (0..36).collect()).expect("whole")
}

fn scan() -> ScanMessage {
    let point = |k: u32| {
        let x = f64::from(k);
        [x + 0.5, -x, 0.25, 0.02 * x]
    };
    ScanMessage { start_ns: NOW_NS, end_ns: NOW_NS + 100_000_000, points: (0..6).map(point).collect() }
}

fn imu() -> ImuMessage {
    ImuMessage { stamp_ns: NOW_NS, gyro: [0.01, -0.02, 0.03], accel: [0.1, 0.2, -9.81] }
}

fn pose() -> PoseMessage {
    PoseMessage { stamp_ns: NOW_NS, position: [1.0, 2.0, 0.8], quat: [1.0, 0.0, 0.0, 0.0] }
}

#[test]
fn damaged_pictures_are_refused_or_whole() {
    run("color", &write_color(NOW_NS, &color()), read_color, |p| p.data.len() == 3 * p.width * p.height);
    let depth = DepthImage::new(4, 3, (0..12).collect()).expect("whole");
    run("depth", &write_depth(NOW_NS, &depth), read_depth, |p| p.data.len() == p.width * p.height);
    let camera = write_camera_info(NOW_NS, &Intrinsics::g1_color());
    run("camera", &camera, read_camera_info, |camera| camera.check().is_ok());
}

#[test]
fn damaged_points_and_samples_are_refused_or_whole() {
    run("points", &write_points(&scan(), "livox_frame"), read_points, |scan| {
        let span = scan.end_ns.saturating_sub(scan.start_ns);
        let within = |p: &[f64; 4]| p.iter().all(|x| x.is_finite()) && (0.0..2.1).contains(&p[3]);
        (1..2_100_000_000).contains(&span) && scan.points.iter().all(within)
    });
    run("imu", &write_imu(&imu(), "livox_frame"), read_imu, |imu| {
        imu.gyro.iter().chain(&imu.accel).all(|x| x.is_finite())
    });
    let odometry = |bytes: &[u8]| read_odometry(bytes).map(|(stamped, _)| stamped);
    run("odometry", &write_odometry(&pose(), "odom", "torso_link"), odometry, |pose| {
        pose.position.iter().all(|x| x.is_finite()) && pose.quat.iter().all(|x| x.abs() < 1.1)
    });
}

/// A recording of each kind of message.
fn recording() -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("eyes.mcap");
    let mut recorder = Recorder::create(&path, &SightSetup::g1().expect("the robot")).expect("created");
    let picture = PictureMessage {
        captured_ns: NOW_NS,
        color: color(),
        depth: None,
        intrinsics: Intrinsics::g1_color(),
        boxes: None,
    };
    let messages = [
        Message::Imu(imu()),
        Message::Scan(scan()),
        Message::Pose(pose()),
        Message::Picture(Box::new(picture)),
        Message::Step { to_strike_s: 1.0 },
    ];
    for message in messages {
        recorder.message(&Arrived { at_ns: NOW_NS, message }).expect("written");
    }
    recorder.finish().expect("finished");
    std::fs::read(&path).expect("a file")
}

#[test]
fn damaged_recordings_are_refused_or_read() {
    let whole = recording();
    let read = |bytes: Vec<u8>| {
        let mut count = 0;
        let result = Recording::from_bytes(Path::new("a.mcap"), bytes).read(|_| {
            count += 1;
            Ok(())
        });
        (result, count)
    };
    let (result, count) = read(whole.clone());
    assert!(result.is_ok() && count == 5, "{result:?} {count}");
    let mut refused = 0_u32;
    let times = times(2000) / 10;
    for number in 0..times {
        if let (Err(error), _) = read(damaged(&whole, number)) {
            refused += 1;
            assert!(error.to_string().starts_with("a.mcap: "), "{number}: {error}");
        }
    }
    assert!(refused > times / 10, "{refused} of {times}");
    println!("recordings: {} read, {refused} refused", times - refused);
}

#[test]
fn damaged_messages_of_a_recording_are_refused_or_read() {
    // Without the file around them, whose check sums keep most damage from them; the first byte numbers the topic.
    let seeds = [
        write_color(NOW_NS, &color()),
        write_imu(&imu(), "l"),
        write_points(&scan(), "l"),
        write_odometry(&pose(), "odom", "torso_link"),
    ];
    let (mut read, times) = (0_u32, times(8000));
    for number in 0..times {
        let mut bytes = damaged(&seeds[number as usize % seeds.len()], number);
        bytes.insert(0, (number / 4) as u8);
        read += u32::from(decode_any(&bytes));
    }
    assert!(read > times / 1000, "{read} of {times}");
    println!("messages: {read} read of {times}");
}
