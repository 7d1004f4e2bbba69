//! Any bytes as a recording of the eyes: an error or messages, never a panic.
#![no_main]

use std::path::Path;

use paid_world::Recording;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let recording = Recording::from_bytes(Path::new("fuzz.mcap"), bytes.to_vec());
    let _ = recording.read(|_| Ok(()));
    // Messages of the known topics, without the file around them.
    let _ = paid_world::decode_any(bytes);
});
