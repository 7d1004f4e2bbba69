//! Ranks that are processes of `mpirun`, on one machine or on many.

use std::sync::Arc;

use mpi::collective::{CommunicatorCollectives, SystemOperation};
use mpi::datatype::PartitionMut;
use mpi::environment::Universe;
use mpi::topology::{Communicator, SimpleCommunicator};
use mpi::{Count, Threading};
use paid_learn::Ranks;

/// This process among those of `mpirun`. MPI ends when it is dropped.
pub struct Mpi {
    _universe: Universe,
}

/// Number of this process and of all. Calls go to the world's communicator, which MPI keeps.
#[derive(Clone, Copy, Debug)]
struct MpiRanks {
    rank: usize,
    count: usize,
}

impl Mpi {
    /// Joins the others. `None` if that was done before.
    pub fn join() -> Option<Self> {
        // Collective calls come from the thread that joined.
        let (universe, _) = mpi::initialize_with_threading(Threading::Funneled)?;
        Some(Self { _universe: universe })
    }

    /// For a trainer.
    pub fn ranks(&self) -> Arc<dyn Ranks> {
        let world = SimpleCommunicator::world();
        let number = |x: Count| usize::try_from(x).unwrap_or(0);
        Arc::new(MpiRanks { rank: number(world.rank()), count: number(world.size()).max(1) })
    }

    /// Ends the processes of all ranks: the others wait for this one, which cannot continue.
    pub fn abort(&self, code: u8) -> ! {
        SimpleCommunicator::world().abort(i32::from(code))
    }
}

impl Ranks for MpiRanks {
    fn rank(&self) -> usize {
        self.rank
    }
    fn count(&self) -> usize {
        self.count
    }
    fn host(&self) -> String {
        mpi::environment::processor_name().unwrap_or_else(|_| "a machine without a readable name".to_owned())
    }
    fn sum(&self, values: &mut [f32]) {
        let own = values.to_vec();
        SimpleCommunicator::world().all_reduce_into(&own[..], values, SystemOperation::sum());
    }
    fn gather(&self, bytes: &[u8]) -> Vec<Vec<u8>> {
        let world = SimpleCommunicator::world();
        let mut lengths = vec![0 as Count; self.count];
        world.all_gather_into(&(bytes.len() as Count), &mut lengths[..]);
        let begins: Vec<Count> = lengths
            .iter()
            .scan(0, |next, length| {
                let begin = *next;
                *next += length;
                Some(begin)
            })
            .collect();
        let sizes: Vec<usize> = lengths.iter().map(|&length| length as usize).collect();
        let mut all = vec![0_u8; sizes.iter().sum()];
        if all.is_empty() {
            // No rank sends anything, and MPI refuses empty buffers. All ranks have arrived.
            return vec![Vec::new(); self.count];
        }
        world
            .all_gather_varcount_into(bytes, &mut PartitionMut::new(&mut all[..], &lengths[..], &begins[..]));
        let mut rest = &all[..];
        let part = |size: usize| {
            let (part, others) = rest.split_at(size);
            rest = others;
            part.to_vec()
        };
        sizes.into_iter().map(part).collect()
    }
}
