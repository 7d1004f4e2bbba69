//! Any bytes as a message of a ROS 2 camera or odometry: an error or a message, never a panic.
#![no_main]

use paid_sight::ros::{read_camera_info, read_color, read_depth, read_odometry};

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
    let _ = read_odometry(bytes);
});
