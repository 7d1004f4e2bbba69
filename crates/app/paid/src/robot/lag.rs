//! `paid robot lag`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use paid_eval::lag::{LagReport, Moves};
use paid_runtime::log::LogReader;
use paid_runtime::wire::{LowCmd, LowState};
use paid_runtime::{G1_MOTORS, Packet};

use crate::failure::Failure;

/// Control steps of the policies `[s]`.
const CONTROL_S: f64 = 0.02;

/// Arguments of `paid robot lag`.
#[derive(Debug, clap::Args)]
pub struct LagArgs {
    /// Logs of runs, of a robot or a simulated one.
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// Print a line of JSON instead of a table.
    #[arg(long)]
    json: bool,
}

/// Measures how late the joints follow their targets while a policy acts.
pub fn lag(args: &LagArgs) -> Result<ExitCode, Failure> {
    let runs = args.logs.iter().map(|log| moves(log)).collect::<Result<Vec<_>, _>>()?;
    let source = match &args.logs[..] {
        [log] => log.display().to_string(),
        logs => format!("{} logs", logs.len()),
    };
    let report = LagReport::new(source, &G1_MOTORS, &runs, CONTROL_S);
    if args.json {
        println!("{}", serde_json::to_string(&report).map_err(|e| Failure::input(e.to_string()))?);
    } else {
        println!("{}", report.table());
    }
    Ok(ExitCode::SUCCESS)
}

/// What the motors were to do and did at the policy's steps.
fn moves(file: &Path) -> Result<Moves, Failure> {
    let mut log = LogReader::open(file)?;
    let (mut moves, mut state) = (Moves::default(), None);
    while let Some(frame) = log.next_frame()? {
        for packet in &frame.packets {
            if let Packet::LowState(cdr) = packet {
                state = LowState::from_cdr(cdr).ok().or(state);
            }
        }
        let (Some(state), Some(_)) = (&state, &frame.trace) else { continue };
        let Ok(command) = LowCmd::from_cdr(&frame.command) else { continue };
        let of = |q: &dyn Fn(usize) -> f32| (0..G1_MOTORS.len()).map(|j| f64::from(q(j))).collect();
        moves.push(of(&|j| command.motors[j].q), of(&|j| state.motors[j].q));
    }
    if let Some(cut) = log.cut_off() {
        eprintln!("note: {cut}; what comes before was used");
    }
    if moves.targets.is_empty() {
        return Err(Failure::input(format!(
            "{}: expected steps of a policy with joint targets, found none: the robot never got beyond standing up, or another program gave \
             the commands; log a run in which it kicks",
            file.display()
        )));
    }
    Ok(moves)
}
