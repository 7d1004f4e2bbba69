//! Samples over ROS 2's topics on the loopback.

use std::time::{Duration, Instant};

use paid_runtime::ros::{IMAGE, IMU, ODOMETRY, RosReader, RosTopics};

/// Programs on a loopback without multicast find each other after some seconds; a busy machine takes longer.
const PATIENCE: Duration = Duration::from_secs(90);

/// A domain that no other test has.
fn domain() -> u16 {
    20 + (std::process::id() % 80) as u16
}

#[test]
fn samples_wait_for_a_reader_that_is_busy_with_a_scan() {
    let topics =
        || RosTopics::open(domain(), "127.0.0.1".parse().expect("an address")).expect("the loopback");
    let (device, computer) = (topics(), topics());
    let writer = device.writer("/livox/imu", IMU).expect("a topic");
    let mut reader = computer.reader("/livox/imu", IMU, false).expect("a topic");
    // The header, then fields that are not read.
    let sample = || writer.send(vec![0, 1, 0, 0, 1, 2, 3, 4]).expect("sent");
    let begin = Instant::now();
    while reader.take().expect("well").is_none() {
        assert!(begin.elapsed() < PATIENCE, "nothing came");
        sample();
        std::thread::sleep(Duration::from_millis(5));
    }
    std::thread::sleep(Duration::from_millis(200));
    while reader.take().expect("well").is_some() {}
    // A fifth of a second's samples, without a reader.
    for _ in 0..40 {
        sample();
        std::thread::sleep(Duration::from_millis(5));
    }
    std::thread::sleep(Duration::from_millis(200));
    let kept = std::iter::from_fn(|| reader.take().expect("well")).count();
    // A busy machine may lose some.
    assert!(kept >= 30, "{kept} of 40 samples");
}

/// Waits until this is said of a silent topic.
fn until_said(reader: &mut RosReader, expected: &str) {
    let begin = Instant::now();
    let mut said = None;
    while said.as_deref() != Some(expected) {
        assert!(begin.elapsed() < PATIENCE, "{said:?}");
        assert_eq!(reader.take().expect("well"), None);
        std::thread::sleep(Duration::from_millis(20));
        said = reader.silent();
    }
}

#[test]
fn a_silent_topic_is_reported_with_its_publishers_and_their_type() {
    // Not the domain of the other test.
    let open = || {
        let domain = 20 + ((std::process::id() + 40) % 80) as u16;
        RosTopics::open(domain, "127.0.0.1".parse().expect("an address")).expect("the loopback")
    };
    let (driver, computer) = (open(), open());
    let mut color = computer.reader("/camera/color", IMAGE, false).expect("a topic");
    let mut imu = computer.reader("/imu", IMU, false).expect("a topic");
    assert_eq!(color.silent(), None, "not for a second yet");
    until_said(&mut color, "found no publisher of /camera/color");
    let _other = driver.writer("/camera/camera/color", IMAGE).expect("a topic");
    until_said(
        &mut color,
        "found no publisher of /camera/color; sensor_msgs/msg/Image is published on /camera/camera/color",
    );
    let silent = driver.writer("/camera/color", IMAGE).expect("a topic");
    until_said(&mut color, "/camera/color is published (sensor_msgs/msg/Image), but nothing arrives");
    let _poses = driver.writer("/imu", ODOMETRY).expect("a topic");
    until_said(&mut imu, "/imu is published as nav_msgs/msg/Odometry, expected sensor_msgs/msg/Imu");
    drop(silent);
    until_said(
        &mut color,
        "found no publisher of /camera/color; sensor_msgs/msg/Image is published on /camera/camera/color",
    );
}
