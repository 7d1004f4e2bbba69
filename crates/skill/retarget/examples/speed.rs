//! Frames a second of the retargeting, on one core: `cargo run --release -p paid-retarget --example speed -- FILE...`
//! (BVH, or AMC with its ASF beside it). Time is that of the solver alone: seconds of the processor where the system tells them (Linux), so
//! that what else runs on the core does not count.

use std::path::Path;
use std::time::Instant;

use paid_retarget::{HumanOptions, RetargetOptions, read_human, retarget};
use paid_robot::{RobotModel, RobotSpec};

/// Share of the time that this thread was on the processor while `work` ran, and its result.
fn on_processor<T>(work: impl FnOnce() -> T) -> (f64, T) {
    let ran = || -> Option<f64> {
        let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
        text.split(' ').next()?.parse::<f64>().ok().map(|ns| 1e-9 * ns)
    };
    let (begun, before) = (Instant::now(), ran());
    let result = work();
    let share = match (before, ran()) {
        (Some(before), Some(after)) => (after - before) / begun.elapsed().as_secs_f64(),
        _ => 1.0,
    };
    (share.clamp(0.0, 1.0), result)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    let (mut frames, mut seconds) = (0, 0.0);
    for file in std::env::args().skip(1) {
        let motion = read_human(Path::new(&file), &HumanOptions::default())?;
        // The least of five: what else the machine does is not ours.
        let mut best: Option<paid_retarget::Report> = None;
        for _ in 0..5 {
            let (share, out) = on_processor(|| retarget(&motion, &model, &spec, &RetargetOptions::default()));
            let mut report = out?.report;
            report.solve_s *= share;
            if best.as_ref().is_none_or(|b| report.solve_s < b.solve_s) {
                best = Some(report);
            }
        }
        let Some(r) = best else { continue };
        println!(
            "{file}: {} frames, {:.0} frames/s, {:.2} + {:.2} solves a frame, position {:.1} mm (worst {:.1}), rotation {:.3} rad, \
             at range {:.2}%, at speed {:.2}%, ground {:.1} mm, penetration {:.1} mm, sliding {:.1} mm, foot {:.1} m/s at {}",
            r.frames,
            r.frames as f64 / r.solve_s,
            r.steps[0],
            r.steps[1],
            1e3 * r.position_error_m,
            1e3 * r.position_worst_m,
            r.rotation_error,
            100.0 * r.at_range,
            100.0 * r.at_speed,
            1e3 * r.ground_shift_m,
            1e3 * r.penetration_m,
            1e3 * r.sliding_m,
            r.kick_speed,
            r.kick_frame
        );
        frames += r.frames;
        seconds += r.solve_s;
    }
    println!("all: {frames} frames, {:.0} frames/s", frames as f64 / seconds);
    Ok(())
}
