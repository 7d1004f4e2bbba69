//! Watching and stopping an evaluation from outside.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::time::Duration;

use serde::{Deserialize, Serialize};

/// Shared by the code that runs trials and the code that waits for them. Clones watch the same run.
#[derive(Clone, Debug, Default)]
pub struct Monitor(Arc<Counters>);

#[derive(Debug, Default)]
struct Counters {
    stop: Arc<AtomicBool>,
    done: AtomicUsize,
    total: AtomicUsize,
    steps: AtomicU64,
    physics_ns: AtomicU64,
    policy_ns: AtomicU64,
}

/// Where the time went, summed over threads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Effort {
    /// Trials that ended.
    pub trials: usize,
    /// Control steps of all environments, the filling of lanes included.
    pub control_steps: u64,
    /// Simulating, with the task's bookkeeping `[s]`.
    pub physics_s: f64,
    /// The policy `[s]`.
    pub policy_s: f64,
}

impl Effort {
    /// What was added to an earlier effort.
    #[must_use]
    pub fn since(&self, earlier: &Self) -> Self {
        Self {
            trials: self.trials - earlier.trials,
            control_steps: self.control_steps - earlier.control_steps,
            physics_s: self.physics_s - earlier.physics_s,
            policy_s: self.policy_s - earlier.policy_s,
        }
    }
}

/// What an evaluation cost.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Timing {
    /// Wall clock `[s]`.
    pub wall_s: f64,
    /// Trials per second of wall clock.
    pub trials_per_s: f64,
    /// Simulation and policy, summed over threads.
    #[serde(flatten)]
    pub effort: Effort,
}

impl Timing {
    /// `effort` in `wall_s` seconds.
    pub fn of(effort: Effort, wall_s: f64) -> Self {
        Self { wall_s, trials_per_s: effort.trials as f64 / wall_s.max(1e-9), effort }
    }

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

impl Monitor {
    /// A monitor of runs that end when `stop` is set, by whomever.
    pub fn stopped_by(stop: Arc<AtomicBool>) -> Self {
        Self(Arc::new(Counters { stop, ..Counters::default() }))
    }

    /// Asks the runs to end: trials that ended by then are kept, the others dropped.
    pub fn stop(&self) {
        self.0.stop.store(true, Ordering::Relaxed);
    }

    /// True once a stop was requested.
    pub fn stopped(&self) -> bool {
        self.0.stop.load(Ordering::Relaxed)
    }

    /// Trials that ended and trials that were planned.
    pub fn progress(&self) -> (usize, usize) {
        (self.0.done.load(Ordering::Relaxed), self.0.total.load(Ordering::Relaxed))
    }

    /// Where the time went so far.
    pub fn effort(&self) -> Effort {
        let seconds = |ns: &AtomicU64| ns.load(Ordering::Relaxed) as f64 * 1e-9;
        Effort {
            trials: self.progress().0,
            control_steps: self.0.steps.load(Ordering::Relaxed),
            physics_s: seconds(&self.0.physics_ns),
            policy_s: seconds(&self.0.policy_ns),
        }
    }

    pub(crate) fn plan(&self, trials: usize) {
        self.0.total.fetch_add(trials, Ordering::Relaxed);
    }

    pub(crate) fn finish(&self, trials: usize) {
        self.0.done.fetch_add(trials, Ordering::Relaxed);
    }

    /// Counts what another process did.
    pub(crate) fn add(&self, effort: &Effort) {
        self.plan(effort.trials);
        self.finish(effort.trials);
        self.0.steps.fetch_add(effort.control_steps, Ordering::Relaxed);
        for (ns, seconds) in [(&self.0.physics_ns, effort.physics_s), (&self.0.policy_ns, effort.policy_s)] {
            ns.fetch_add((seconds * 1e9) as u64, Ordering::Relaxed);
        }
    }

    pub(crate) fn spend(&self, envs: usize, physics: Duration, policy: Duration) {
        let ns = |d: Duration| u64::try_from(d.as_nanos()).unwrap_or(u64::MAX);
        self.0.steps.fetch_add(envs as u64, Ordering::Relaxed);
        self.0.physics_ns.fetch_add(ns(physics), Ordering::Relaxed);
        self.0.policy_ns.fetch_add(ns(policy), Ordering::Relaxed);
    }
}
