//! Any text as AMC of a small skeleton: an error or a motion, never a panic.
#![no_main]

use std::path::Path;

const ASF: &str = ":root\n order TX TY TZ RX RY RZ\n axis XYZ\n:bonedata\n begin\n name hip\n direction 1 0 0\n length 2\n dof rx rz\n end\n\
    :hierarchy\n begin\n root hip\n end\n";

libfuzzer_sys::fuzz_target!(|text: &str| {
    if let Ok(skeleton) = paid_retarget::parse_asf(ASF, Path::new("fuzz.asf")) {
        let _ = paid_retarget::parse_amc(text, Path::new("fuzz.amc"), &skeleton, 120.0);
    }
});
