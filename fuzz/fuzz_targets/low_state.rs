//! Any bytes as the robot's state or command: an error or a message that comes back as it was, never a panic.
#![no_main]

use paid_runtime::wire::{LowCmd, LowState, Remote};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(state) = LowState::from_cdr(bytes) {
        assert_eq!(LowState::from_c(&state.to_c()).map(|s| s.to_c()), Ok(state.to_c()));
        let _ = (state.expected_crc(), Remote::new(&state.wireless_remote));
    }
    if let Ok(command) = LowCmd::from_cdr(bytes) {
        assert_eq!(LowCmd::from_c(&command.to_c()).map(|c| c.to_c()), Ok(command.to_c()));
    }
});
