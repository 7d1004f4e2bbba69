//! `paid compare`: methods trained with one budget and judged alike, from a plan.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use paid_eval::ablation::{has_run, is_same_run};
use paid_eval::compare::curves::{self, Course};
use paid_eval::compare::{Comparison, Contender, JudgePlan, Plan, Row, Scores, films};
use paid_eval::contacts;
use paid_eval::curves::Curves;
use paid_eval::file::write_whole;
use paid_eval::html::write_report;
use paid_eval::monitor::Monitor;
use paid_eval::results::to_json;
use paid_eval::scene::Engines;
use paid_eval::subject::SubjectSpec;
use paid_train::folder::PRESET_FILE;
use paid_train::meeting::{Introduction, meet};
use paid_train::{Alone, End, Limits, RunPreset, Scene, StageJob, Start, train_stage};

use crate::failure::Failure;
use crate::ranks::{self, Joined};
use crate::stop::{self, STOPPED};
use crate::threads::thread_count;
use crate::train::motions_value;

/// What a judgment leaves in a policy's folder.
const SCORES: &str = "scores.json";

/// Arguments of `paid compare`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The plan: a TOML file, such as configs/compare/paper.toml.
    #[arg(value_name = "PLAN")]
    plan: PathBuf,
    /// Folder of motion files [default: the built-in kicks].
    #[arg(long, value_name = "DIR")]
    motions: Option<PathBuf>,
    /// Output folder. What was trained or judged there before is not trained or judged again.
    #[arg(long, value_name = "DIR", default_value = "runs/compare")]
    out: PathBuf,
    /// Worker threads; they do not change the result [default: all cores].
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// Print the comparison as one line of JSON.
    #[arg(long)]
    json: bool,
}

/// Trains and judges every entry, or takes up what an earlier call left. Of several processes each takes its share of the entries, and
/// the first one writes and prints.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    ranks::together(|joined| compare(args, joined))
}

fn compare(args: &Args, joined: &Joined) -> Result<ExitCode, Failure> {
    let threads = thread_count(args.threads)?;
    let plan = Plan::read(&args.plan)?;
    if let Some(folder) = args.motions.as_deref().filter(|folder| !folder.exists()) {
        let found = folder.display();
        return Err(Failure::input(format!("--motions: expected a folder of motion files, found {found}")));
    }
    let motions = args.motions.as_deref().map(motions_value);
    let beside = args.plan.parent().unwrap_or(Path::new(""));
    let contenders = plan.contenders(beside, motions.as_deref())?;
    for (name, file) in plan.left_out(beside) {
        eprintln!("note: '{name}' is left out: no file {}", file.display());
    }
    let mut own = Introduction::default();
    own.tell_options(&plan);
    for contender in &contenders {
        for file in [&contender.from, &contender.policy].into_iter().flatten().filter(|path| path.is_file()) {
            own.tell_file("policy", file)?;
        }
        for preset in &contender.stages {
            refuse_another(&run_folder(args, contender, preset), preset)?;
            own.tell_run(preset, &Scene::load(preset)?)?;
        }
    }
    Engines::Mujoco.check()?;
    check(args, &plan, &contenders)?;
    meet(&*joined.ranks, |all| {
        all.tell_all(&own);
        Ok(())
    })?;
    let (rank, count) = (joined.ranks.rank(), joined.ranks.count());
    let mut stopped = false;
    for (k, contender) in contenders.iter().enumerate().filter(|(k, _)| k % count == rank) {
        let name = format!("{} of {}: {}{}", k + 1, contenders.len(), contender.name, contender.suffix());
        stopped = !work(args, &plan, contender, &name, threads)?;
        if stopped {
            break;
        }
        // After every policy, so that a comparison of days can be read on its way.
        if joined.is_first() {
            write(args, &plan, &contenders)?;
        }
    }
    // The first one waits for all of them.
    let all = joined.ranks.gather(&[u8::from(stopped)]);
    if all.iter().flatten().any(|stopped| *stopped != 0) {
        return Ok(ExitCode::from(STOPPED));
    }
    if joined.is_first() {
        let comparison = write(args, &plan, &contenders)?;
        if args.json {
            println!("{}", to_json(&comparison)?);
        } else {
            print!("{}", comparison.table());
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// Reads what the plan's entries begin with, before the first of them is trained. Those that are judged already are not read again.
fn check(args: &Args, plan: &Plan, contenders: &[Contender]) -> Result<(), Failure> {
    let robot =
        contenders.iter().flat_map(|contender| &contender.stages).map(|preset| preset.robot.as_str()).next();
    for contender in contenders {
        if known(args, plan, contender)?.is_none() {
            let motions = contender.clip.as_deref().or(args.motions.as_deref());
            contender.check(&plan.judge, motions, robot)?;
        }
    }
    Ok(())
}

/// Trains and judges an entry unless that was done before; false after Ctrl-C.
fn work(
    args: &Args,
    plan: &Plan,
    contender: &Contender,
    name: &str,
    threads: usize,
) -> Result<bool, Failure> {
    // Who is trained and judged is not even loaded: an earlier version's checkpoints may not go on in this one.
    let scores = match known(args, plan, contender)? {
        Some(scores) => scores,
        None => {
            let Some((policy, samples)) = train(args, contender, name, threads, &stop::flag()?)? else {
                return Ok(false);
            };
            let motions = contender.clip.clone().or_else(|| args.motions.clone());
            let spec = SubjectSpec { motions, threads, ..SubjectSpec::new(policy) };
            match score(&plan.judge, contender, &spec, &samples, &args.out.join(&contender.folder))? {
                Some(scores) => scores,
                None => return Ok(false),
            }
        }
    };
    for judgment in &scores.judgments {
        let goals = [judgment.fixed, judgment.rolling].map(|shots| shots.goals.text());
        eprintln!("{name}, {:?}: static {}, rolling {}", judgment.knowledge, goals[0], goals[1]);
    }
    for track in &scores.tracks {
        eprintln!("{name}, {}: MPJPE {:.1} mm", track.clip, track.mpjpe_mm);
    }
    Ok(true)
}

/// Writes table, JSON, diagram and page of the entries that are trained and judged.
fn write(args: &Args, plan: &Plan, contenders: &[Contender]) -> Result<Comparison, Failure> {
    let mut courses: Vec<Course> = Vec::new();
    let mut comparison = Comparison { title: plan.title.clone(), rows: Vec::new() };
    for contender in contenders {
        let Some(scores) = known(args, plan, contender)? else { continue };
        let (name, paper) = (contender.name.clone(), contender.paper.clone());
        comparison.rows.push(Row { name, paper, seed: contender.seed, scores });
        // A tracker has no shots in training.
        if !contender.stages.is_empty() && !contender.tracks {
            let stages = contender.stages.iter().map(|preset| run_folder(args, contender, preset)).collect();
            courses.push(Course { name: format!("{}{}", contender.name, contender.suffix()), stages });
        }
    }
    write_whole(&args.out.join("comparison.txt"), comparison.table().as_bytes())?;
    write_whole(&args.out.join("comparison.json"), to_json(&comparison)?.as_bytes())?;
    let judged = contenders.iter().filter(|contender| !contender.tracks);
    let strips = judged.map(|c| (format!("{}{}", c.name, c.suffix()), c.folder.as_path()));
    films::gather(&args.out, strips)?;
    if !courses.is_empty() {
        curves::figure(&courses)?.save(&args.out.join("comparison_curves"))?;
    }
    write_report(&args.out)?;
    Ok(comparison)
}

/// The scores of an entry, if it was trained to its end and judged as the plan says.
fn known(args: &Args, plan: &Plan, contender: &Contender) -> Result<Option<Scores>, Failure> {
    match trained(args, contender) {
        Some(samples) => {
            Ok(Scores::read(&args.out.join(&contender.folder).join(SCORES), &plan.judge, &samples)?)
        }
        None => Ok(None),
    }
}

/// Where a stage of a contender is trained.
fn run_folder(args: &Args, contender: &Contender, preset: &RunPreset) -> PathBuf {
    args.out.join(&contender.folder).join(&preset.stage)
}

/// A run of other values in the folder would be continued with a policy that is not the plan's.
fn refuse_another(folder: &Path, preset: &RunPreset) -> Result<(), Failure> {
    if has_run(folder) && !is_same_run(folder, preset)? {
        return Err(Failure::input(format!(
            "{}: expected a run with the values of this plan, found another; choose another --out",
            folder.join(PRESET_FILE).display()
        )));
    }
    Ok(())
}

/// The samples of each stage, if all of them were trained to their end.
fn trained(args: &Args, contender: &Contender) -> Option<Vec<u64>> {
    let samples = |preset: &RunPreset| {
        let curves = Curves::read(&run_folder(args, contender, preset)).ok()?;
        (curves.iteration() >= preset.run.iterations).then(|| curves.samples() as u64)
    };
    contender.stages.iter().map(samples).collect()
}

/// Trains what is to be trained. The policy and the samples of its stages; `None` after Ctrl-C.
fn train(
    args: &Args,
    contender: &Contender,
    name: &str,
    threads: usize,
    stop: &Arc<AtomicBool>,
) -> Result<Option<(PathBuf, Vec<u64>)>, Failure> {
    if let Some(policy) = &contender.policy {
        return Ok(Some((policy.clone(), Vec::new())));
    }
    let (mut before, mut samples) = (contender.from.clone(), Vec::new());
    for preset in &contender.stages {
        let folder = run_folder(args, contender, preset);
        let start =
            if has_run(&folder) { Start::Resume } else { before.take().map_or(Start::Fresh, Start::From) };
        let (stage, iterations) = (&preset.stage, preset.run.iterations);
        let out = folder.clone();
        let job = StageJob {
            preset: preset.clone(),
            out,
            start,
            limits: Limits::default(),
            threads,
            ranks: Arc::new(Alone),
        };
        let mut said = 0;
        let outcome = train_stage(&job, stop, &mut |record| {
            let tenth = record.iteration * 10 / iterations.max(1);
            if tenth > said {
                said = tenth;
                let minutes = record.eta_s / 60.0;
                eprintln!(
                    "{name}, {stage}: {}% of {iterations} iterations, {minutes:.0} min left",
                    10 * tenth
                );
            }
        })
        .map_err(Failure::input)?;
        if outcome.end == End::Stopped {
            return Ok(None);
        }
        samples.push(outcome.samples);
        contacts::keep_of_run(&folder, threads)?;
        before = Some(folder);
    }
    Ok(before.map(|policy| (policy, samples)))
}

/// Judges a policy and keeps its scores, and film strips of its shots, in `folder`; `None` after Ctrl-C.
fn score(
    judge: &JudgePlan,
    contender: &Contender,
    spec: &SubjectSpec,
    samples: &[u64],
    folder: &Path,
) -> Result<Option<Scores>, Failure> {
    let monitor = Monitor::stopped_by(stop::flag()?);
    let scores = if contender.tracks {
        Scores::track(judge, spec, samples, &monitor)?
    } else {
        Scores::judge(judge, spec, samples, folder, &monitor)?
    };
    if let Some(scores) = &scores {
        let text = serde_json::to_string_pretty(scores).map_err(Failure::input)?;
        write_whole(&folder.join(SCORES), text.as_bytes())?;
    }
    Ok(scores)
}
