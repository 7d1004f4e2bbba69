//! Any bytes as a message of a ROS 2 camera, LiDAR, inertial sensor or odometry: an error or a message, never a panic.
#![no_main]

use paid_world::ros::{read_camera_info, read_color, read_depth, read_imu, read_odometry, read_points};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(picture) = read_color(bytes) {
        assert_eq!(picture.value.data.len(), 3 * picture.value.width * picture.value.height);
    }
    if let Ok(picture) = read_depth(bytes) {
        assert_eq!(picture.value.data.len(), picture.value.width * picture.value.height);
    }
    if let Ok(camera) = read_camera_info(bytes) {
        assert!(camera.value.check().is_ok());
    }
    if let Ok(scan) = read_points(bytes) {
        let scan = scan.value;
        assert!(scan.end_ns > scan.start_ns && scan.end_ns - scan.start_ns < 2_100_000_000);
        assert!(scan.points.iter().flatten().all(|x| x.is_finite()));
    }
    if let Ok(sample) = read_imu(bytes) {
        assert!(sample.value.gyro.iter().chain(&sample.value.accel).all(|x| x.is_finite()));
    }
    let _ = read_odometry(bytes);
});
