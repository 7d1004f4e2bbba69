//! Progress of an evaluation, and Ctrl-C.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use paid_eval::monitor::{Effort, Monitor};
use serde::Serialize;

use crate::failure::Failure;

/// Pause between two lines of progress.
const PAUSE: Duration = Duration::from_secs(5);

/// What the running evaluation costs.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Timing {
    /// Wall clock [s].
    pub wall_s: f64,
    /// Trials a second of wall clock.
    pub trials_per_s: f64,
    /// Simulation and policy, summed over threads.
    #[serde(flatten)]
    pub effort: Effort,
}

impl Timing {
    /// One line.
    pub fn text(&self) -> String {
        let e = &self.effort;
        let total = (e.physics_s + e.policy_s).max(1e-9);
        format!(
            "{} trials in {:.1} s, {:.2} trials/s; physics and task {:.0}%, policy {:.0}% of {:.1} core seconds",
            e.trials,
            self.wall_s,
            self.trials_per_s,
            100.0 * e.physics_s / total,
            100.0 * e.policy_s / total,
            total
        )
    }
}

/// Prints progress to standard error until it is finished; Ctrl-C stops the evaluation, which then reports what it has.
pub struct Progress {
    monitor: Monitor,
    start: Instant,
    ended: Arc<AtomicBool>,
    printer: Option<JoinHandle<()>>,
}

/// The monitors that Ctrl-C stops. The handler can be set once a process, evaluations may follow each other.
fn running() -> &'static Mutex<Vec<Monitor>> {
    static RUNNING: OnceLock<Mutex<Vec<Monitor>>> = OnceLock::new();
    RUNNING.get_or_init(Mutex::default)
}

impl Progress {
    /// Begins to watch. `quiet` prints nothing.
    pub fn start(monitor: &Monitor, quiet: bool) -> Result<Self, Failure> {
        let mut monitors = running().lock().unwrap_or_else(PoisonError::into_inner);
        monitors.push(monitor.clone());
        drop(monitors);
        // A handler that `paid train` has set before stays: it ends the whole command.
        let _ = ctrlc::try_set_handler(|| {
            let monitors = running().lock().unwrap_or_else(PoisonError::into_inner);
            if monitors.iter().all(Monitor::stopped) {
                std::process::exit(130);
            }
            eprintln!("stopping: what is done will be reported; Ctrl-C again ends at once");
            monitors.iter().for_each(Monitor::stop);
        });
        let ended = Arc::new(AtomicBool::new(false));
        let start = Instant::now();
        let printer = (!quiet).then(|| {
            let (monitor, ended) = (monitor.clone(), Arc::clone(&ended));
            thread::spawn(move || print(&monitor, &ended, start))
        });
        Ok(Self { monitor: monitor.clone(), start, ended, printer })
    }

    /// Stops printing and says what it cost.
    pub fn finish(mut self) -> Timing {
        self.ended.store(true, Ordering::Relaxed);
        if let Some(printer) = self.printer.take() {
            printer.thread().unpark();
            // A printer that panicked has nothing more to say.
            let _ = printer.join();
        }
        let wall_s = self.start.elapsed().as_secs_f64();
        let effort = self.monitor.effort();
        Timing { wall_s, trials_per_s: effort.trials as f64 / wall_s.max(1e-9), effort }
    }
}

fn print(monitor: &Monitor, ended: &AtomicBool, start: Instant) {
    loop {
        thread::park_timeout(PAUSE);
        if ended.load(Ordering::Relaxed) {
            return;
        }
        let (done, total) = monitor.progress();
        let rate = done as f64 / start.elapsed().as_secs_f64();
        let left = if rate > 0.0 {
            format!("{:.0} s left", (total - done.min(total)) as f64 / rate)
        } else {
            "no estimate yet".to_owned()
        };
        eprintln!("{done}/{total} trials, {rate:.2} trials/s, {left}");
    }
}
