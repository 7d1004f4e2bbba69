//! Samples over ROS 2's topics on the loopback.

use std::time::{Duration, Instant};

use paid_runtime::ros::{IMU, RosTopics};

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
