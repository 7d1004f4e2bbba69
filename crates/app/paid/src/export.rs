//! `paid export`: a trained policy as ONNX.

use std::path::PathBuf;
use std::process::ExitCode;

use paid_motion::{read_clip, resample};
use paid_onnx::OnnxFile;
use paid_play::{POLICY_FILE, is_onnx};
use paid_train::TrainedPolicy;
use paid_train::policy_file::LICENSE;
use paid_train::policy_weights::{load_mean, load_weights, write_weights};
use serde::Serialize;

use crate::eval::out::writable_file;
use crate::failure::Failure;

/// Arguments of `paid export`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Policy to export: a run folder, a checkpoint or a policy file.
    ///
    /// Of a run folder, the mean of its last checkpoints is taken.
    run: PathBuf,
    /// File to write.
    #[arg(long, value_name = "FILE", default_value = POLICY_FILE)]
    out: PathBuf,
    /// Also write a small checkpoint, which can be scored and started from.
    ///
    /// It holds weights, normalizers and preset, and nothing that comes from the motion files. It cannot be resumed.
    #[arg(long, value_name = "FILE")]
    checkpoint: Option<PathBuf>,
    /// Average the weights of the run folder's newest N checkpoints.
    #[arg(long, value_name = "N")]
    average: Option<usize>,
    /// Embed this motion file (.npz), for programs that need the reference.
    ///
    /// The policy file then also returns the reference at `time_step`, and inherits the motion's license.
    #[arg(long, value_name = "CLIP")]
    with_reference: Option<PathBuf>,
    /// License of the policy, written into the file.
    #[arg(
        long,
        value_name = "TEXT",
        default_value = LICENSE
    )]
    license: String,
    /// Print one line of JSON.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Written<'a> {
    file: String,
    checkpoint: String,
    bytes: u64,
    contract: &'a paid_onnx::Contract,
}

/// Writes the file and reads it back.
pub fn run(args: Args) -> Result<ExitCode, Failure> {
    if args.checkpoint.as_deref() == Some(args.out.as_path()) {
        let found = args.out.display();
        return Err(Failure::input(format!("--checkpoint: expected a file other than --out, found {found}")));
    }
    let weights = match args.average {
        Some(count) => Some(load_mean(&args.run, count)),
        None if is_onnx(&args.run) && args.checkpoint.is_none() => None,
        None => Some(load_weights(&args.run)),
    };
    let weights = weights.transpose().map_err(Failure::input)?;
    let trained = match &weights {
        Some(weights) => TrainedPolicy::of(weights),
        None => TrainedPolicy::load(&args.run),
    }
    .map_err(Failure::input)?;
    writable_file("--out", &args.out)?;
    if let Some(path) = &args.checkpoint {
        writable_file("--checkpoint", path)?;
    }
    let clip = match &args.with_reference {
        None => None,
        Some(path) => {
            let clip = read_clip(path, &trained.model, &trained.spec).map_err(Failure::input)?;
            let rate = 1.0 / trained.preset.task.control_dt_s();
            let same = (clip.fps - rate).abs() < 1e-9 * rate;
            Some(if same { clip } else { resample(&clip, &trained.model, rate) })
        }
    };
    // Nothing is written before all of the input is read.
    if let (Some(path), Some(weights)) = (&args.checkpoint, &weights) {
        write_weights(weights, path).map_err(Failure::input)?;
    }
    trained.write_onnx(&args.out, &args.license, clip.as_ref()).map_err(Failure::input)?;
    let contract = &OnnxFile::read(&args.out).and_then(|file| file.contract()).map_err(Failure::input)?;
    let bytes = std::fs::metadata(&args.out)
        .map_err(|e| Failure::input(format!("{}: {e}", args.out.display())))?
        .len();
    let (file, checkpoint) = (args.out.display().to_string(), trained.checkpoint.display().to_string());
    if args.json {
        let line = serde_json::to_string(&Written { file, checkpoint, bytes, contract });
        println!("{}", line.map_err(Failure::input)?);
        return Ok(ExitCode::SUCCESS);
    }
    println!("{file}: {bytes} bytes, from {checkpoint}");
    let memory =
        contract.recurrent.map_or("none".to_owned(), |r| format!("LSTM {} x {}", r.layers, r.hidden));
    println!(
        "robot {}, {} observations in {} terms, {} actions at {:.0} Hz, memory {memory}, reference {}",
        contract.robot,
        contract.observation_size(),
        contract.observation.len(),
        contract.joints.len(),
        1.0 / contract.control_period_s,
        contract.reference.as_deref().unwrap_or("none"),
    );
    println!("license: {}", contract.license);
    Ok(ExitCode::SUCCESS)
}
