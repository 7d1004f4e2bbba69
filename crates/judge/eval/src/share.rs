//! Trials that several processes share out.
//!
//! A trial's outcome depends on the seed and its own number only, so that the outcomes of all ranks together are those of one process.

use paid_task::{EpisodeRules, InitialState};
use paid_train::Ranks;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::EvalError;
use crate::episodes::{EvalSetup, Observer, run_batches};
use crate::monitor::{Effort, Monitor};
use crate::policy::DriverMaker;

/// What a rank sends to the others.
#[derive(Serialize, serde::Deserialize)]
struct Told<T> {
    /// All trials that it knows.
    trials: usize,
    effort: Effort,
    outcomes: Vec<(usize, T)>,
}

/// As [`crate::episodes::run_episodes`], with the outcome of every trial instead of its observer. Of several ranks ([`EvalSetup::ranks`]) each runs a
/// part of the trials, and every one returns all outcomes; all of them must call it.
///
/// # Errors
/// As [`crate::episodes::run_episodes`], or if the ranks do not agree on how many trials there are.
pub fn run_shared<O: Observer, T: Serialize + DeserializeOwned>(
    setup: &EvalSetup,
    policy: &DriverMaker,
    starts: &[InitialState],
    rules: EpisodeRules,
    max_steps: usize,
    observer: impl Fn(usize) -> O + Sync,
    outcome: impl Fn(usize, O) -> T,
) -> Result<Vec<(usize, T)>, EvalError> {
    let ranks = &*setup.ranks;
    let own = |batch: usize| batch % ranks.count() == ranks.rank();
    let before = setup.monitor.effort();
    let observers = run_batches(setup, policy, starts, rules, max_steps, own, observer)?;
    let outcomes: Vec<(usize, T)> = observers.into_iter().map(|(i, o)| (i, outcome(i, o))).collect();
    if ranks.count() == 1 {
        return Ok(outcomes);
    }
    let told = Told { trials: starts.len(), effort: setup.monitor.effort().since(&before), outcomes };
    let mut bytes = Vec::new();
    ciborium::into_writer(&told, &mut bytes).map_err(|error| EvalError::Ranks(error.to_string()))?;
    let mut all = Vec::with_capacity(starts.len());
    for (rank, bytes) in ranks.gather(&bytes).iter().enumerate() {
        let told: Told<T> = ciborium::from_reader(&bytes[..])
            .map_err(|error| EvalError::Ranks(format!("rank {rank}: {error}")))?;
        if told.trials != starts.len() {
            let (expected, found) = (starts.len(), told.trials);
            return Err(EvalError::Ranks(format!(
                "expected {expected} trials on every rank, found {found} on rank {rank}"
            )));
        }
        if rank != ranks.rank() {
            setup.monitor.add(&told.effort);
        }
        all.extend(told.outcomes);
    }
    all.sort_by_key(|(trial, _)| *trial);
    Ok(all)
}

/// True if one of the ranks was asked to stop: then all of them stop. A rank that continues alone would wait for the others forever, so all of
/// them must call this between two evaluations.
pub fn stopped(ranks: &dyn Ranks, monitor: &Monitor) -> bool {
    let own = [u8::from(monitor.stopped())];
    let stopped = ranks.gather(&own).iter().flatten().any(|told| *told != 0);
    if stopped {
        monitor.stop();
    }
    stopped
}

#[cfg(test)]
mod tests {
    use paid_learn::ranks::ThreadRanks;

    use super::*;

    #[test]
    fn a_rank_that_is_asked_to_stop_stops_all() {
        let outcome = |asked: [bool; 2]| -> Vec<[bool; 2]> {
            std::thread::scope(|scope| {
                let start = |(ranks, asked): (ThreadRanks, bool)| {
                    scope.spawn(move || {
                        let monitor = Monitor::default();
                        if asked {
                            monitor.stop();
                        }
                        [stopped(&ranks, &monitor), monitor.stopped()]
                    })
                };
                let threads: Vec<_> = ThreadRanks::of(2).into_iter().zip(asked).map(start).collect();
                threads.into_iter().map(|thread| thread.join().expect("no panic")).collect()
            })
        };
        assert_eq!(outcome([false, false]), [[false; 2]; 2]);
        assert_eq!(outcome([false, true]), [[true; 2]; 2]);
    }
}
