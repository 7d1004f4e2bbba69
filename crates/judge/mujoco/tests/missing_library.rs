//! Without a library. A test binary of its own, since the library is opened once a process.
#![cfg(feature = "mujoco")]

use paid_mujoco::{MujocoError, World};

#[test]
fn a_missing_library_is_an_error_that_names_the_command() {
    // SAFETY: the only test of this process; nothing reads the environment meanwhile.
    unsafe { std::env::set_var("MUJOCO_LIB", "/nonexistent/libmujoco.so") };
    let error = World::from_xml("<mujoco/>").unwrap_err();
    assert!(matches!(error, MujocoError::Library(_)));
    let text = error.to_string();
    assert!(text.contains("cargo mujoco") && text.contains("/nonexistent/libmujoco.so"), "{text}");
}
