//! A thread's panic is reported before it is printed: printing takes a second where `RUST_BACKTRACE` is set. A program of its own, since
//! the panic hook is one for the whole program.

use std::sync::{Arc, Mutex};

use paid_runtime::LastWords;

#[test]
fn last_words_are_heard_before_the_panic_is_printed() {
    let words = LastWords::default();
    let heard = Arc::new(Mutex::new(None));
    let (listener, kept) = (words.clone(), Arc::clone(&heard));
    // In place of the hook that prints: what was reported by then?
    std::panic::set_hook(Box::new(move |_| *kept.lock().expect("whole") = Some(listener.heard())));
    let done = words.guard("eyes' ball", || panic!("a mote"));
    assert_eq!(done, None::<()>);
    let told = "the eyes' ball thread has panicked: a mote".to_owned();
    assert_eq!(heard.lock().expect("whole").take(), Some(Some(told)), "printed first");
    assert_eq!(words.heard(), None, "reported twice");

    // A panic that is passed on calls no hook, and is reported all the same.
    let done = words.guard("keyboard", || std::panic::resume_unwind(Box::new("a key")));
    assert_eq!(done, None::<()>);
    assert_eq!(words.heard().as_deref(), Some("the keyboard thread has panicked: a key"));

    // Beyond the guard panics are printed as usual, and not reported.
    let _ = std::thread::spawn(|| panic!("unguarded")).join();
    assert_eq!(heard.lock().expect("whole").take(), Some(None));
}
