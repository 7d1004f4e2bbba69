//! Cleans motion files, as `paid motion clean` does: prints the verdicts and, of the thread's own time, what it took.
//!
//! `cargo run --release -p paid-motion --example clean -- DIR FILE...`

use std::path::Path;

use paid_motion::clean::{CleanOptions, clean};
use paid_motion::{ReadOptions, read_motion, write_motion};
use paid_robot::{RobotModel, RobotSpec};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    let mut arguments = std::env::args().skip(1);
    let folder = arguments.next().ok_or("expected a folder and motion files")?;
    for file in arguments {
        let clip = read_motion(Path::new(&file), &model, &spec, &ReadOptions::default())?;
        let cleaned = clean(&clip, &model, &spec, &CleanOptions::default())?;
        let r = &cleaned.report;
        write_motion(&Path::new(&folder).join(format!("{}.npz", clip.name)), &cleaned.clip, &model, &spec)?;
        println!(
            "{}: {} -> {}; cut {:?}, added {:?}, flight {}, feet {:.3?}, hands {:.3?}, kick {:.2?}, torque {:.2} -> {:.2} ({} in frame {}), \
             over {:.4?}, {} steps, {:.1} s",
            r.name,
            r.before.verdict,
            r.after.verdict,
            r.cut,
            r.added,
            r.flight,
            r.feet_m,
            r.hands_m,
            r.kick_speed,
            r.torque[0].value,
            r.torque[1].value,
            r.torque[1].joint,
            r.torque[1].frame,
            r.torque_over,
            r.steps,
            r.seconds
        );
    }
    Ok(())
}
