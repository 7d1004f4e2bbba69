//! Any text as ASF: an error or a skeleton, never a panic.
#![no_main]

use std::path::Path;

libfuzzer_sys::fuzz_target!(|text: &str| {
    let _ = paid_retarget::parse_asf(text, Path::new("fuzz.asf"));
});
