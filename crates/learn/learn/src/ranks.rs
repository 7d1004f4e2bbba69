//! Processes that train one policy together, each with shards of its own.
//!
//! Whatever the others do not need to know stays where it is. Statistics are gathered shard by shard and merged in the order of all
//! shards, so that they are those of one process with all of them to the last bit. Gradients are summed: their rounding depends on how
//! many ranks there are, and is the same on every one of them.

use core::fmt::Debug;
use std::sync::{Arc, Barrier, Mutex, PoisonError};

/// One of several processes. Every rank must make the same calls in the same order; a call returns when all have made it.
pub trait Ranks: Debug + Send + Sync {
    /// Number of this rank, from 0.
    fn rank(&self) -> usize;
    /// Number of ranks.
    fn count(&self) -> usize;
    /// Name of the machine that this rank runs on, for messages.
    fn host(&self) -> String {
        "this machine".to_owned()
    }
    /// Sums every element over the ranks; the same bits on each of them.
    fn sum(&self, values: &mut [f32]);
    /// What every rank gives, in their order.
    fn gather(&self, bytes: &[u8]) -> Vec<Vec<u8>>;
}

/// A process by itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Alone;

impl Ranks for Alone {
    fn rank(&self) -> usize {
        0
    }
    fn count(&self) -> usize {
        1
    }
    fn sum(&self, _values: &mut [f32]) {}
    fn gather(&self, bytes: &[u8]) -> Vec<Vec<u8>> {
        vec![bytes.to_vec()]
    }
}

/// Ranks that are threads of one process: what can be tested of several processes without them.
#[derive(Clone, Debug)]
pub struct ThreadRanks {
    rank: usize,
    shared: Arc<Meeting>,
}

#[derive(Debug)]
struct Meeting {
    barrier: Barrier,
    given: Mutex<Vec<Vec<u8>>>,
}

impl ThreadRanks {
    /// This many ranks, one for each thread.
    pub fn of(count: usize) -> Vec<Self> {
        let given = Mutex::new(vec![Vec::new(); count]);
        let shared = Arc::new(Meeting { barrier: Barrier::new(count), given });
        (0..count).map(|rank| Self { rank, shared: Arc::clone(&shared) }).collect()
    }
}

impl Ranks for ThreadRanks {
    fn rank(&self) -> usize {
        self.rank
    }
    fn count(&self) -> usize {
        self.shared.given.lock().unwrap_or_else(PoisonError::into_inner).len()
    }
    fn sum(&self, values: &mut [f32]) {
        let bytes: Vec<u8> = values.iter().flat_map(|x| x.to_le_bytes()).collect();
        values.fill(0.0);
        for part in self.gather(&bytes) {
            let (words, _) = part.as_chunks::<4>();
            for (sum, word) in values.iter_mut().zip(words) {
                *sum += f32::from_le_bytes(*word);
            }
        }
    }
    fn gather(&self, bytes: &[u8]) -> Vec<Vec<u8>> {
        let lock = || self.shared.given.lock().unwrap_or_else(PoisonError::into_inner);
        lock()[self.rank] = bytes.to_vec();
        self.shared.barrier.wait();
        let all = lock().clone();
        // No rank gives again before all have taken.
        self.shared.barrier.wait();
        all
    }
}

/// Everyone's numbers, in the order of the ranks.
pub fn gather_numbers(ranks: &dyn Ranks, numbers: &[f64]) -> Vec<Vec<f64>> {
    let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
    let all = ranks.gather(&bytes);
    all.iter()
        .map(|part| part.as_chunks::<8>().0.iter().map(|word| f64::from_le_bytes(*word)).collect())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn threads_gather_in_the_order_of_the_ranks_and_sum_to_the_same_bits() {
        let results: Vec<_> = std::thread::scope(|scope| {
            let each = |ranks: ThreadRanks| {
                let mut out = Vec::new();
                for round in 0..20 {
                    let given = vec![ranks.rank() as u8; ranks.rank() + round];
                    out.push(ranks.gather(&given));
                }
                let mut values = vec![0.1 * ranks.rank() as f32, 1.0];
                ranks.sum(&mut values);
                (out, values.iter().map(|x| x.to_bits()).collect::<Vec<_>>())
            };
            let threads: Vec<_> =
                ThreadRanks::of(3).into_iter().map(|r| scope.spawn(move || each(r))).collect();
            threads.into_iter().map(|t| t.join().expect("no panic")).collect()
        });
        assert_eq!(results[0].0[2], [vec![0; 2], vec![1; 3], vec![2; 4]]);
        assert!(results.iter().all(|r| *r == results[0]));
        assert_eq!(f32::from_bits(results[0].1[1]), 3.0);
        assert_eq!(gather_numbers(&Alone, &[1.5, -0.1]), [[1.5, -0.1]]);
    }
}
