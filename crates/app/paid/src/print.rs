//! Standard output. The macros take the place of the standard library's, which always panic where it cannot be written.

use core::fmt::Arguments;
use std::io::{self, Write};
use std::sync::atomic::{AtomicBool, Ordering};

macro_rules! print {
    ($($words:tt)*) => { $crate::print::write(format_args!($($words)*)) };
}

macro_rules! println {
    () => { print!("\n") };
    ($($words:tt)*) => { print!("{}\n", format_args!($($words)*)) };
}

static PANICS: AtomicBool = AtomicBool::new(false);

/// From now on a failure is a panic, for whoever catches it and has more to do before the program ends.
pub fn panic_where_it_fails() {
    PANICS.store(true, Ordering::Relaxed);
}

/// Writes to standard output; where that fails, such as on a full disk, the program ends with one error and exit code 2.
///
/// # Panics
/// If it fails after [`panic_where_it_fails`].
pub fn write(words: Arguments<'_>) {
    if let Err(error) = io::stdout().lock().write_fmt(words) {
        assert!(!PANICS.load(Ordering::Relaxed), "failed printing to stdout: {error}");
        // Standard error may be on the same disk.
        let _ = writeln!(io::stderr(), "error: standard output: {error}");
        std::process::exit(2);
    }
}
