//! What a panicking thread does first: it is reported, before anything is printed.
//!
//! The usual panic hook prints, and with `RUST_BACKTRACE` it looks up symbols for a second before the thread unwinds. A thread that waits
//! for the end of the unwinding damps a second late.

use std::any::Any;
use std::backtrace::Backtrace;
use std::cell::{Cell, RefCell};
use std::panic::{AssertUnwindSafe, PanicHookInfo, catch_unwind};
use std::sync::{Mutex, Once, PoisonError};

/// What is done with a panic of a watched thread.
struct Watch {
    tell: Box<dyn Fn(String)>,
    told: Cell<bool>,
    prints: Prints,
}

/// When a watched thread's panic is printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Prints {
    /// By the usual hook, once it is reported.
    AtOnce,
    /// By [`print_the_rest`]: a control thread has no time to print.
    Later,
}

thread_local! {
    static WATCH: RefCell<Option<Watch>> = const { RefCell::new(None) };
}
/// Panics that were not printed yet.
static UNPRINTED: Mutex<Vec<(String, Backtrace)>> = Mutex::new(Vec::new());

/// What a thread died of.
pub(super) fn said(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(ToString::to_string);
    text.or_else(|| panic.downcast_ref::<String>().cloned())
        .unwrap_or_else(|| "a panic without a message".to_owned())
}

/// Watches the calling thread until dropped. `tell` gets a panic as `the ... thread has panicked: ...`, before anything is printed.
pub(super) struct Watching(Option<Watch>);

impl Watching {
    pub fn begin(name: &str, prints: Prints, tell: impl Fn(String) + 'static) -> Self {
        static HOOK: Once = Once::new();
        HOOK.call_once(|| {
            let usual = std::panic::take_hook();
            std::panic::set_hook(Box::new(move |info| {
                if hear(info) == Prints::AtOnce {
                    usual(info);
                }
            }));
        });
        let name = name.to_owned();
        let tell = Box::new(move |why: String| tell(format!("the {name} thread has panicked: {why}")));
        Self(WATCH.replace(Some(Watch { tell, told: Cell::new(false), prints })))
    }
}

impl Drop for Watching {
    fn drop(&mut self) {
        WATCH.set(self.0.take());
    }
}

fn hear(info: &PanicHookInfo<'_>) -> Prints {
    WATCH.with(|watch| {
        let Ok(watch) = watch.try_borrow() else { return Prints::AtOnce };
        let Some(watch) = &*watch else { return Prints::AtOnce };
        (watch.tell)(info.payload_as_str().unwrap_or("a panic without a message").to_owned());
        watch.told.set(true);
        if watch.prints == Prints::Later {
            let mut unprinted = UNPRINTED.lock().unwrap_or_else(PoisonError::into_inner);
            unprinted.push((info.to_string(), Backtrace::capture()));
        }
        watch.prints
    })
}

/// Prints the panics that had to wait, to the standard error.
pub(super) fn print_the_rest() {
    let unprinted = std::mem::take(&mut *UNPRINTED.lock().unwrap_or_else(PoisonError::into_inner));
    for (words, trace) in unprinted {
        eprintln!("{words}\n{trace}");
    }
}

/// Runs a thread's work. `None`: it has panicked, and `tell` was called.
pub(super) fn guarded<R>(name: &str, tell: impl Fn(String) + 'static, act: impl FnOnce() -> R) -> Option<R> {
    let _watching = Watching::begin(name, Prints::AtOnce, tell);
    match catch_unwind(AssertUnwindSafe(act)) {
        Ok(result) => Some(result),
        Err(panic) => {
            // A panic that is passed on from another thread calls no hook.
            WATCH.with_borrow(|watch| {
                if let Some(watch) = watch.as_ref().filter(|watch| !watch.told.get()) {
                    (watch.tell)(said(&*panic));
                }
            });
            None
        }
    }
}
