//! Work shared among threads: which thread takes an item never changes a result.

use std::sync::Mutex;

/// Calls `work` for every item; each thread has one of `workers` as scratch. Items must be independent of each other.
/// With one worker everything runs on the calling thread.
pub fn for_each<W: Send, T: Send>(workers: &mut [W], items: Vec<T>, work: impl Fn(&mut W, T) + Sync) {
    let queue = Mutex::new(items.into_iter());
    let drain = |worker: &mut W| {
        loop {
            // A poisoned queue means that another thread panicked: stop here, its panic reaches the caller.
            let item = queue.lock().ok().and_then(|mut items| items.next());
            let Some(item) = item else { break };
            work(worker, item);
        }
    };
    let Some((own, others)) = workers.split_first_mut() else { return };
    std::thread::scope(|scope| {
        for worker in others {
            scope.spawn(|| drain(worker));
        }
        drain(own);
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_item_is_worked_on_once() {
        for threads in [1, 3] {
            let mut counts = vec![0; 20];
            let mut workers = vec![0usize; threads];
            for_each(&mut workers, counts.iter_mut().collect(), |worker, count| {
                *count += 1;
                *worker += 1;
            });
            assert_eq!(counts, vec![1; 20]);
            assert_eq!(workers.iter().sum::<usize>(), 20);
        }
    }
}
