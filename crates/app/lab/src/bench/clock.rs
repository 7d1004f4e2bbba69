//! Timing that holds on a busy machine.

use std::sync::Barrier;
use std::time::Instant;

use cpu_time::ThreadTime;
use paid_eval::EvalError;

/// Work done per second.
#[derive(Clone, Copy, Debug)]
pub struct Rate {
    /// By the clock on the wall: what the user waits for.
    pub wall: f64,
    /// By processor time, averaged over the threads: what a core does, also while other programs use it.
    pub per_core: f64,
}

/// Runs `work` on `threads` threads, each with its own contender from `make`, until `seconds` have passed; `work` returns how much
/// it did. The first piece of work of each thread is not counted.
///
/// # Errors
/// If a contender cannot be made or a thread panics.
pub fn timed<S>(
    threads: usize,
    seconds: f64,
    make: impl Fn() -> Result<S, EvalError> + Sync,
    work: impl Fn(&mut S) -> u64 + Sync,
) -> Result<Rate, EvalError> {
    let barrier = Barrier::new(threads);
    let one = || -> Result<Rate, EvalError> {
        let contender = make();
        // Even after a failure, or the others would wait for ever.
        barrier.wait();
        let mut contender = contender?;
        work(&mut contender);
        let (mut done, start, processor) = (0, Instant::now(), ThreadTime::now());
        loop {
            done += work(&mut contender);
            let passed = start.elapsed().as_secs_f64();
            if passed >= seconds {
                let used = processor.elapsed().as_secs_f64();
                let per_core = if used > 0.0 { done as f64 / used } else { done as f64 / passed };
                return Ok(Rate { wall: done as f64 / passed, per_core });
            }
        }
    };
    let rates: Vec<Rate> = std::thread::scope(|scope| {
        let handles: Vec<_> = (0..threads).map(|_| scope.spawn(one)).collect();
        let failed = || Err(EvalError::Thread("benchmark"));
        handles.into_iter().map(|h| h.join().unwrap_or_else(|_| failed())).collect::<Result<_, _>>()
    })?;
    let wall = rates.iter().map(|r| r.wall).sum();
    Ok(Rate { wall, per_core: rates.iter().map(|r| r.per_core).sum::<f64>() / threads as f64 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_count_the_work_of_all_threads() {
        let spin = |x: &mut u64| {
            for i in 0..100_000_u64 {
                *x = std::hint::black_box(*x ^ i);
            }
            1000
        };
        let rate = timed(2, 0.05, || Ok(0_u64), spin).unwrap();
        assert!(rate.wall.is_finite() && rate.wall > 0.0, "{rate:?}");
        assert!(rate.per_core.is_finite() && rate.per_core > 0.0, "{rate:?}");
    }

    #[test]
    fn a_contender_that_cannot_be_made_is_an_error() {
        let make = || Err::<(), _>(EvalError::Policy("no contender".to_owned()));
        let error = timed(2, 0.01, make, |()| 1).unwrap_err();
        assert_eq!(error.to_string(), "policy: no contender");
    }
}
