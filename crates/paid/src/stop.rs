//! Signals, once for the whole program: Ctrl-C and SIGTERM ask it to stop, a closed output pipe ends it.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

use crate::failure::Failure;

/// Exit code of a command that was stopped before its end.
pub const STOPPED: u8 = 130;

/// The flag that the first Ctrl-C (or SIGTERM) sets; whoever works in steps looks at it and ends with what there is. A second
/// signal ends the program at once.
///
/// # Errors
/// If the system refuses the handler.
pub fn flag() -> Result<Arc<AtomicBool>, Failure> {
    static FLAG: OnceLock<Arc<AtomicBool>> = OnceLock::new();
    if let Some(flag) = FLAG.get() {
        return Ok(Arc::clone(flag));
    }
    let flag = Arc::new(AtomicBool::new(false));
    let set = Arc::clone(&flag);
    ctrlc::set_handler(move || {
        if set.swap(true, Ordering::SeqCst) {
            std::process::exit(i32::from(STOPPED));
        }
        eprintln!("stopping: what is done so far will be saved and reported; Ctrl-C again ends at once");
    })
    .map_err(|error| Failure::input(format!("cannot watch for Ctrl-C: {error}")))?;
    Ok(Arc::clone(FLAG.get_or_init(|| flag)))
}

/// A reader that has seen enough (`paid ... | head`) ends the program in silence, as it does any other program. Rust ignores the
/// signal by default, so that every `println!` after it would panic.
#[cfg(unix)]
pub fn end_with_the_reader() {
    // SAFETY: called once at the start of `main`, before other threads; the default action is no Rust code.
    unsafe {
        libc::signal(libc::SIGPIPE, libc::SIG_DFL);
    }
}

/// Other systems have no such signal.
#[cfg(not(unix))]
pub fn end_with_the_reader() {}
