//! Runs the eyes again on a recording: `cargo run -p paid-world --example replay -- FILE`.

use std::path::Path;

use paid_lidar::sim::processor_clock;
use paid_world::{Recording, replay};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = std::env::args().nth(1).ok_or("expected a recording")?;
    let recording = Recording::open(Path::new(&file))?;
    let mut sight = recording.sight(None)?;
    let clock = processor_clock();
    let begin = clock();
    let result = replay(&recording, &mut sight, |_| {})?;
    let cpu_s = clock() - begin;
    println!("{result:?}; {cpu_s:.2} s of processor time, {:.1} times real time", result.span_s / cpu_s);
    Ok(())
}
