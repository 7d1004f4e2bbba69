//! `paid perceive replay`: runs the eyes again on a recording.

use std::path::PathBuf;

use cpu_time::ThreadTime;
use paid_world::{Believed, Recording, replay, seconds};

use super::load;
use crate::failure::Failure;

/// Arguments of `paid perceive replay`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Recording (MCAP) of `paid eval shooting --eyes --record FILE`.
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// ONNX file of the detector, if it was not the network in this program.
    #[arg(long, value_name = "ONNX")]
    detector: Option<PathBuf>,
    /// Number of the ball's class in its file [default: the class that the file names].
    #[arg(long, value_name = "K", requires = "detector")]
    class: Option<usize>,
    /// Print the estimates at each step.
    #[arg(long)]
    steps: bool,
}

/// Runs the eyes again; an unequal belief is a failure, and so is a recording without any.
pub fn run(args: &Args) -> Result<(), Failure> {
    let recording = Recording::open(&args.file).map_err(Failure::input)?;
    let detector = args.detector.as_deref().map(|path| load(path, args.class)).transpose()?;
    let mut sight = recording.sight(detector).map_err(Failure::input)?;
    let begin = ThreadTime::now();
    let result = replay(&recording, &mut sight, |believed| {
        if args.steps {
            print_step(believed);
        }
    });
    let result = result.map_err(Failure::input)?;
    let cpu_s = begin.elapsed().as_secs_f64();
    println!(
        "{} messages, {} images, {} steps in {:.2} s of recording; {cpu_s:.2} s of processor time, {:.1} times real time",
        result.messages,
        result.pictures,
        result.steps,
        result.span_s,
        result.span_s / cpu_s.max(1e-9)
    );
    if let Some(end) = recording.cut_at() {
        eprintln!(
            "note: {}: the file is cut off: its last whole record ends at byte {end}, {:.2} s after the first message; what comes before was used",
            args.file.display(),
            result.span_s
        );
    }
    for (at_s, fault) in &result.faults {
        eprintln!("note: {at_s:.2} s: {fault}");
    }
    match result.first_different_s {
        None => {
            println!("{} estimates, all equal to the recorded ones bit for bit", result.equal);
            Ok(())
        }
        Some(at_s) => Err(Failure::input(format!(
            "{}: estimates: expected those of the recording, found others from {at_s:.2} s on ({} were equal)",
            args.file.display(),
            result.equal
        ))),
    }
}

fn print_step(believed: &Believed) {
    let ball = believed.ball.map_or_else(
        || "no ball".to_owned(),
        |ball| {
            let b = &ball.belief;
            let ([x, y], [vx, vy]) = (b.ball.position, b.ball.velocity);
            format!(
                "ball {} {} ({x:.3}, {y:.3}) m ({vx:.2}, {vy:.2}) m/s, {:.3} m, {:.2} s",
                ball.id,
                ball.state.name(),
                b.ball.covariance[0].max(0.0).sqrt(),
                b.age_s
            )
        },
    );
    let picture = believed.picture.map_or_else(String::new, |fault| format!("; {fault}"));
    println!("{:7.2} s  odometry {}; {ball}{picture}", seconds(believed.at_ns), believed.odometry);
}
