//! Shots with the robot's own eyes: `cargo run -p paid-eval --example eyes -- POLICY MOTIONS OUT [key=value ...]`.
//!
//! Keys: detector (own, exact-box), odometry (lidar, modeled), rolling (yes), step (distance of the places `[m]`), plot (a trial),
//! record (yes: that trial's sensors, to `OUT/kick.mcap`).

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use paid_eval::eyes::{DetectorChoice, EyesOptions, OdometryChoice, evaluate};
use paid_eval::monitor::Timing;
use paid_eval::results::{to_json, write_eyes};
use paid_eval::scene::Engines;
use paid_eval::shooting::{Grid, ROLLING_SPEED, ShootingOptions};
use paid_eval::subject::{Subject, SubjectSpec};

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [policy, motions, out, rest @ ..] = arguments.as_slice() else {
        return Err("expected POLICY MOTIONS OUT [key=value ...]".into());
    };
    let keys: HashMap<&str, &str> = rest.iter().filter_map(|pair| pair.split_once('=')).collect();
    let step = keys.get("step").map_or(Ok(Grid::EFFECTIVE.step), |text| text.parse())?;
    let options = ShootingOptions {
        grid: Grid { step, ..Grid::EFFECTIVE },
        trials: 1,
        rolling: keys.contains_key("rolling").then_some(ROLLING_SPEED),
        ..ShootingOptions::default()
    };
    let plot = keys.get("plot").map(|text| text.parse()).transpose()?;
    let eyes = EyesOptions {
        detector: match keys.get("detector") {
            Some(&"exact-box") => DetectorChoice::ExactBox,
            _ => DetectorChoice::Own,
        },
        odometry: match keys.get("odometry") {
            Some(&"modeled") => OdometryChoice::Modeled,
            _ => OdometryChoice::Lidar,
        },
        record: keys
            .contains_key("record")
            .then(|| (plot.unwrap_or(0), PathBuf::from(out).join("kick.mcap"))),
        log: plot,
        ..EyesOptions::default()
    };
    let spec = SubjectSpec {
        motions: Some(PathBuf::from(motions)),
        engines: Engines::Mujoco,
        threads: 1,
        ..SubjectSpec::new(policy)
    };
    std::fs::create_dir_all(out)?;
    let subject = Subject::load(&spec)?;
    let start = Instant::now();
    let (report, kick) = evaluate(&subject.setup, &*subject.maker, &options, &eyes)?;
    let timing = Timing::of(subject.setup.monitor.effort(), start.elapsed().as_secs_f64());
    println!("{}\n{}", report.table(), timing.text());
    write_eyes(Path::new(out), &report, kick.as_ref(), &to_json(&report)?)?;
    Ok(())
}
