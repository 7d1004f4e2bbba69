//! Standard output. The macros take the place of the standard library's, which always panic where it cannot be written.

use core::fmt::Arguments;
use std::io::{self, Write};
use std::sync::atomic::{AtomicBool, Ordering};

/// As the standard library's, by [`write_out`](crate::write_out).
#[macro_export]
macro_rules! print {
    ($($words:tt)*) => { $crate::write_out(format_args!($($words)*)) };
}

/// As the standard library's, by [`write_out`](crate::write_out).
#[macro_export]
macro_rules! println {
    () => { $crate::write_out(format_args!("\n")) };
    ($($words:tt)*) => { $crate::write_out(format_args!("{}\n", format_args!($($words)*))) };
}

static PANICS: AtomicBool = AtomicBool::new(false);

/// From now on a failure is a panic: the run that catches it damps the robot before the program ends.
pub fn panic_where_it_fails() {
    PANICS.store(true, Ordering::Relaxed);
}

/// Writes to standard output; where that fails, such as on a full disk, the program ends with one error and exit code 2.
///
/// # Panics
/// If it fails while a robot runs.
pub fn write_out(words: Arguments<'_>) {
    if let Err(error) = io::stdout().lock().write_fmt(words) {
        assert!(!PANICS.load(Ordering::Relaxed), "failed printing to stdout: {error}");
        // Standard error may be on the same disk.
        let _ = writeln!(io::stderr(), "error: standard output: {error}");
        std::process::exit(2);
    }
}
