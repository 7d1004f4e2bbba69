//! `paid eval contacts`.

use std::process::ExitCode;

use paid_eval::contacts;
use paid_eval::results::to_json;
use paid_eval::subject::Subject;
use paid_train::policy_weights::write_play;

use super::ended;
use super::progress::Progress;
use super::subject::Common;
use crate::failure::Failure;

/// Arguments of `paid eval contacts`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    common: Common,
    /// Write the times into the policy's file, for the prediction of rolling balls.
    ///
    /// Whether left-footed kicks are played mirrored (--set mirror_left_kicks=true) is written too. Everything else in the file stays: a
    /// run's checkpoint can be resumed as before.
    #[arg(long)]
    keep: bool,
    /// Print one line of JSON.
    #[arg(long)]
    json: bool,
}

/// Kicks with every clip, prints when the foot meets the ball, and keeps it if asked.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    args.common.setting.one_engine()?;
    if args.keep && !args.common.policy.is_file() {
        let found = args.common.policy.display();
        return Err(Failure::input(format!(
            "--keep: expected --policy to be a file, such as a run's policy.onnx, found {found}"
        )));
    }
    let spec = args.common.spec("paper_stage2")?;
    let mut subject = Subject::load(&spec)?;
    subject.require_ball()?;
    let (monitor, progress) = Progress::start(args.json)?;
    subject.setup.monitor = monitor;
    let report = contacts::measure(&subject.setup, &*subject.maker)?;
    progress.finish();
    let code = ended(&subject.setup.monitor);
    if args.keep && code == ExitCode::SUCCESS {
        let mut play = subject.setup.preset.play();
        play.contact_s = report.times();
        write_play(&spec.policy, play).map_err(Failure::input)?;
        eprintln!("written into {}", spec.policy.display());
    }
    if args.json {
        println!("{}", to_json(&report)?);
    } else {
        print!("{}", report.table());
    }
    Ok(code)
}
