//! Processor time of the calling thread: a busy machine does not lengthen it.

/// Seconds that this thread has run, from any begin. Linux counts them per thread; elsewhere it is the time of the wall clock.
pub(super) fn cpu_s() -> f64 {
    let ran = std::fs::read_to_string("/proc/thread-self/schedstat");
    let nanoseconds = ran.ok().and_then(|text| text.split_whitespace().next()?.parse::<f64>().ok());
    nanoseconds.map_or_else(wall_s, |ns| 1e-9 * ns)
}

fn wall_s() -> f64 {
    static START: std::sync::OnceLock<std::time::Instant> = std::sync::OnceLock::new();
    START.get_or_init(std::time::Instant::now).elapsed().as_secs_f64()
}
