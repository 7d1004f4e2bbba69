//! Any text as BVH: an error or a motion, never a panic.
#![no_main]

use std::path::Path;

libfuzzer_sys::fuzz_target!(|text: &str| {
    if let Ok(motion) = paid_retarget::parse_bvh(text, Path::new("fuzz.bvh"), 0.01) {
        let _ = paid_retarget::Naming::of(&motion);
    }
});
