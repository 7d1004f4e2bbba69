//! Signals, once for the whole program: Ctrl-C, SIGTERM and SIGHUP ask it to stop, a closed output pipe ends it, unless a robot must be
//! damped first.

use std::io::Write;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use crate::Failure;

/// Exit code of a command that was stopped before its end.
pub const STOPPED: u8 = 130;

/// A terminal that is closed often sends two signals. Where the program must end in order, those within this time of the first are the
/// same wish.
const SAME_WISH: Duration = Duration::from_secs(2);
/// Set by [`outlive_the_terminal`].
static MUST_END_IN_ORDER: AtomicBool = AtomicBool::new(false);

/// The flag that the first Ctrl-C (or SIGTERM) sets; work that is done in steps checks it, and ends with what there is. A second
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
    let first = OnceLock::new();
    ctrlc::set_handler(move || {
        let first = *first.get_or_init(Instant::now);
        if set.swap(true, Ordering::SeqCst) {
            if !MUST_END_IN_ORDER.load(Ordering::SeqCst) || first.elapsed() > SAME_WISH {
                std::process::exit(i32::from(STOPPED));
            }
            return;
        }
        // The terminal may be gone.
        let _ = writeln!(
            std::io::stderr(),
            "stopping: finished work will be saved and reported; Ctrl-C again exits at once"
        );
    })
    .map_err(|error| Failure::input(format!("cannot watch for Ctrl-C: {error}")))?;
    Ok(Arc::clone(FLAG.get_or_init(|| flag)))
}

/// A reader that has seen enough (`paid ... | head`) ends the program in silence, as it does any other program. Rust ignores the
/// signal by default, so that every `println!` after it would panic.
#[cfg(unix)]
pub fn end_with_the_reader() {
    // SAFETY: the default action is no Rust code, and setting it is allowed from any thread.
    unsafe {
        libc::signal(libc::SIGPIPE, libc::SIG_DFL);
    }
}

/// Other systems have no such signal.
#[cfg(not(unix))]
pub fn end_with_the_reader() {}

/// For a program that must damp a robot before it ends: a reader that is gone, Ctrl-Z and a second signal right after the first neither
/// end nor halt it. [`end_with_the_reader`] undoes the part that concerns the reader.
pub fn outlive_the_terminal() {
    MUST_END_IN_ORDER.store(true, Ordering::SeqCst);
    #[cfg(unix)]
    for signal in [libc::SIGPIPE, libc::SIGTSTP, libc::SIGTTIN, libc::SIGTTOU] {
        // SAFETY: to ignore a signal runs no Rust code, and it is allowed from any thread.
        unsafe {
            libc::signal(signal, libc::SIG_IGN);
        }
    }
}
