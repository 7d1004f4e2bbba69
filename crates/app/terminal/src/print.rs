//! Standard output. The macros take the place of the standard library's, which always panic where it cannot be written.

use core::fmt::{Arguments, Write as _};
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

/// As the standard library's, by [`write_error`](crate::write_error).
#[macro_export]
macro_rules! eprintln {
    () => { $crate::write_error(format_args!("\n")) };
    ($($words:tt)*) => { $crate::write_error(format_args!("{}\n", format_args!($($words)*))) };
}

static PANICS: AtomicBool = AtomicBool::new(false);

/// Makes a failure a panic: the run that catches it damps the robot before the program ends.
pub fn panic_where_it_fails() {
    PANICS.store(true, Ordering::Relaxed);
}

/// Writes to standard output; where that fails, such as on a full disk, the program ends with one error and exit code 2.
///
/// # Panics
/// If it fails while a robot runs.
pub fn write_out(words: Arguments<'_>) {
    if let Err(error) = io::stdout().lock().write_all(plain(words).as_bytes()) {
        assert!(!PANICS.load(Ordering::Relaxed), "failed printing to stdout: {error}");
        // Standard error may be on the same disk.
        let _ = writeln!(io::stderr(), "error: standard output: {error}");
        std::process::exit(2);
    }
}

/// Writes to standard error; where that fails, there is no place left to say so.
pub fn write_error(words: Arguments<'_>) {
    let _ = io::stderr().lock().write_all(plain(words).as_bytes());
}

/// Text in which nothing acts on a terminal: control characters, byte order marks and marks of direction, which names and values of
/// files may hold, are written as `\u{1b}`.
fn plain(words: Arguments<'_>) -> String {
    let text = words.to_string();
    let acts = |c: char| {
        (c.is_control() && c != '\n' && c != '\t')
            || matches!(c, '\u{feff}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
    };
    if !text.contains(acts) {
        return text;
    }
    text.chars().fold(String::new(), |mut out, c| {
        // Writing to a string cannot fail.
        let _ = if acts(c) { write!(out, "{}", c.escape_unicode()) } else { out.write_char(c) };
        out
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_in_a_text_acts_on_a_terminal() {
        let red = format!("bone '{}[31m\u{feff}hip\u{0}'\tat 1\n", '\u{1b}');
        assert_eq!(plain(format_args!("{red}")), "bone '\\u{1b}[31m\\u{feff}hip\\u{0}'\tat 1\n");
        assert_eq!(plain(format_args!("größer: {}", 1)), "größer: 1");
    }
}
