//! How much memory there is, and how much this process took.

use std::fs;

/// Bytes of a number of the rollouts.
const NUMBER: u64 = 4;
/// Numbers of a sample beside observations, actions and their means: reward, value, advantage and such.
const OTHERS: usize = 8;
/// Bytes of a GiB.
const GIB: f64 = (1_u64 << 30) as f64;

/// Largest resident memory of this process so far `[MiB]` (`VmHWM` of Linux's `/proc/self/status`).
pub fn peak_rss_mib() -> f64 {
    kib("/proc/self/status", "VmHWM:").map_or(0.0, |kib| kib / 1024.0)
}

/// A line of a file of Linux's that says a size in kB.
fn kib(file: &str, name: &str) -> Option<f64> {
    let text = fs::read_to_string(file).ok()?;
    text.lines().find_map(|line| line.strip_prefix(name)?.trim().strip_suffix("kB")?.trim().parse().ok())
}

/// Checks that the rollouts fit in the memory that is free now; where that is not known (not Linux), everything does. `dims`: numbers of the
/// policy's observation, the critic's, and the actions.
///
/// # Errors
/// What is needed, what is there, and what to lower.
pub fn check_rollouts(envs: usize, horizon: usize, dims: [usize; 3]) -> Result<(), String> {
    match kib("/proc/meminfo", "MemAvailable:") {
        Some(free) => check_within(envs, horizon, dims, 1024.0 * free),
        None => Ok(()),
    }
}

fn check_within(envs: usize, horizon: usize, dims: [usize; 3], free: f64) -> Result<(), String> {
    let numbers = dims[0] + dims[1] + 2 * dims[2] + OTHERS;
    let needed = (envs as f64) * (horizon as f64) * (numbers as f64) * NUMBER as f64;
    if needed <= free {
        return Ok(());
    }
    Err(format!(
        "learn.ppo.horizon: {envs} environments of {horizon} steps need {:.1} GiB of memory, found {:.1} GiB free; lower it or run.envs",
        needed / GIB,
        free / GIB
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rollouts_that_do_not_fit_are_refused() {
        // 10 environments, 100 steps, 16 + 20 + 2 * 10 + 8 numbers of 4 bytes.
        let bytes = 10.0 * 100.0 * 64.0 * 4.0;
        assert_eq!(check_within(10, 100, [16, 20, 10], bytes), Ok(()));
        let error = check_within(1 << 20, 1 << 10, [16, 20, 10], bytes).expect_err("256 GiB");
        assert!(
            error.contains("learn.ppo.horizon")
                && error.contains("need 256.0 GiB")
                && error.contains("0.0 GiB free"),
            "{error}"
        );
    }

    #[test]
    fn this_process_has_memory() {
        if cfg!(target_os = "linux") {
            assert!(peak_rss_mib() > 1.0);
        }
    }
}
