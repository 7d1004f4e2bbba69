//! Progress of an evaluation.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use paid_eval::monitor::{Monitor, Timing};

use crate::failure::Failure;
use crate::stage_progress::left;

/// Pause between two lines of progress, at least. Of a long evaluation it is a tenth of the time that it takes already.
const PAUSE: Duration = Duration::from_secs(5);

/// Prints progress to standard error until it is finished.
pub struct Progress {
    monitor: Monitor,
    start: Instant,
    ended: Arc<AtomicBool>,
    printer: Option<JoinHandle<()>>,
}

impl Progress {
    /// A monitor for the next evaluation, which Ctrl-C and SIGTERM stop, and its progress. `quiet` prints nothing.
    ///
    /// # Errors
    /// If the system refuses to watch for signals.
    pub fn start(quiet: bool) -> Result<(Monitor, Self), Failure> {
        let monitor = Monitor::stopped_by(paid_terminal::flag()?);
        let ended = Arc::new(AtomicBool::new(false));
        let start = Instant::now();
        let printer = (!quiet).then(|| {
            let (monitor, ended) = (monitor.clone(), Arc::clone(&ended));
            thread::spawn(move || print(&monitor, &ended, start))
        });
        Ok((monitor.clone(), Self { monitor, start, ended, printer }))
    }

    /// Stops printing and says what it cost.
    pub fn finish(mut self) -> Timing {
        self.ended.store(true, Ordering::Relaxed);
        if let Some(printer) = self.printer.take() {
            printer.thread().unpark();
            // A printer that panicked has nothing more to say.
            let _ = printer.join();
        }
        Timing::of(self.monitor.effort(), self.start.elapsed().as_secs_f64())
    }
}

fn print(monitor: &Monitor, ended: &AtomicBool, start: Instant) {
    loop {
        thread::park_timeout(PAUSE.max(start.elapsed() / 10));
        if ended.load(Ordering::Relaxed) {
            return;
        }
        let (done, total) = monitor.progress();
        let rate = done as f64 / start.elapsed().as_secs_f64();
        let left = if rate > 0.0 {
            left((total - done.min(total)) as f64 / rate)
        } else {
            "no estimate yet".to_owned()
        };
        eprintln!("{done}/{total} trials, {rate:.2} trials/s, {left}");
    }
}
