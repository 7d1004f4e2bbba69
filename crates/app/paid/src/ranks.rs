//! One of several processes that train together, started by `mpirun`.

use std::io::Write;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Duration;

use paid_train::{Alone, Ranks};

use crate::failure::Failure;

/// Where `mpirun` says how many processes there are: Open MPI, then others.
const SIZES: [&str; 2] = ["OMPI_COMM_WORLD_SIZE", "PMI_SIZE"];

/// How long a rank waits for the first one to end it, before it ends all by itself.
const PATIENCE: Duration = Duration::from_secs(60);

/// Processes that `mpirun` has started; 1 without it.
fn started() -> usize {
    let size = |name: &&str| std::env::var(name).ok()?.parse().ok();
    SIZES.iter().find_map(size).unwrap_or(1)
}

/// This process among the others, for as long as it lives.
pub struct Joined {
    /// For a trainer.
    pub ranks: Arc<dyn Ranks>,
    #[cfg(feature = "mpi")]
    mpi: Option<paid_train::mpi_ranks::Mpi>,
}

impl Joined {
    /// True for the one that writes, prints and scores.
    pub fn is_first(&self) -> bool {
        self.ranks.rank() == 0
    }

    /// Ends all processes if this one cannot continue: the others wait for it. An error of all of them is printed by the first one.
    fn end_all(&self, failure: &Failure) {
        let (rank, count) = (self.ranks.rank(), self.ranks.count());
        if count > 1 {
            if !failure.is_everyones() {
                tell(&format!("error: rank {rank} of {count} on {}: {failure}\n", self.ranks.host()));
            } else if self.is_first() {
                tell(&format!("error: {failure}\n"));
            } else {
                std::thread::sleep(PATIENCE);
            }
            #[cfg(feature = "mpi")]
            if let Some(mpi) = &self.mpi {
                mpi.abort(failure.code());
            }
        }
    }
}

/// Writes a message in one piece: Open MPI and the other ranks write to the same place.
fn tell(message: &str) {
    // If it cannot be written, there is no place left to report that.
    let _ = std::io::stderr().write_all(message.as_bytes());
}

/// Does `work` as one of the processes of `mpirun`, or alone without it. If it fails on one, all of them end.
pub fn together(work: impl FnOnce(&Joined) -> Result<ExitCode, Failure>) -> Result<ExitCode, Failure> {
    let joined = join()?;
    let result = work(&joined);
    if let Err(failure) = &result {
        joined.end_all(failure);
    }
    result
}

/// Refuses to do `what` in one of several processes: each would do the same.
///
/// # Errors
/// If `mpirun` has started several.
pub fn alone(what: &str) -> Result<(), Failure> {
    match started() {
        1 => Ok(()),
        count => Err(Failure::input(format!("mpirun: expected one process for {what}, found {count}"))),
    }
}

/// Joins the processes of `mpirun`; alone without it.
#[cfg(feature = "mpi")]
fn join() -> Result<Joined, Failure> {
    if started() == 1 {
        return Ok(Joined { ranks: Arc::new(Alone), mpi: None });
    }
    let mpi = paid_train::mpi_ranks::Mpi::join().ok_or_else(|| {
        Failure::input("mpirun: expected processes that are not connected yet, found them connected")
    })?;
    Ok(Joined { ranks: mpi.ranks(), mpi: Some(mpi) })
}

/// Alone; processes of `mpirun` would all train the same.
#[cfg(not(feature = "mpi"))]
fn join() -> Result<Joined, Failure> {
    match started() {
        1 => Ok(Joined { ranks: Arc::new(Alone) }),
        count => Err(Failure::input(format!(
            "mpirun: expected a program with the feature mpi (cargo build --release --features mpi), found one without it: each of \
             the {count} processes would train the same"
        ))),
    }
}
