//! `paid compare`: methods trained with equal budgets and scored the same way, from a plan.

mod stages;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use paid_eval::html::write_report;
use paid_eval::results::to_json;
use paid_eval::scene::Engines;
use paid_eval::subject::SubjectSpec;
use paid_files::write_whole;
use paid_lab::compare::curves::{self, Course};
use paid_lab::compare::{Comparison, Contender, Plan, Row, Scores, films};
use paid_terminal::{STOPPED, flag};
use paid_train::Scene;
use paid_train::meeting::{Introduction, meet};

use crate::eval::progress::Progress;
use crate::failure::Failure;
use crate::ranks::{self, Joined};
use crate::threads::thread_count;
use crate::train::motions_value;

/// What a judgment leaves in a policy's folder.
const SCORES: &str = "scores.json";

/// Arguments of `paid compare`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Plan, a TOML file such as configs/compare/paper.toml.
    #[arg(value_name = "PLAN")]
    plan: PathBuf,
    /// Folder of motion files [default: the built-in kicks].
    #[arg(long, value_name = "DIR")]
    motions: Option<PathBuf>,
    /// Output folder; what it already contains is not trained or scored again.
    #[arg(long, value_name = "DIR", default_value = "runs/compare")]
    out: PathBuf,
    /// Train and score only this entry (repeatable) [default: all].
    ///
    /// The table has all entries that are finished.
    #[arg(long, value_name = "NAME")]
    only: Vec<String>,
    /// Worker threads; the result does not depend on them [default: all cores].
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// Print the comparison as one line of JSON.
    #[arg(long)]
    json: bool,
    /// Print no progress, only the comparison.
    #[arg(long)]
    quiet: bool,
}

/// Trains and scores every entry, or continues what an earlier call left. Of several processes each takes its share of the entries, and
/// the first one writes and prints.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    ranks::together(|joined| compare(args, joined))
}

/// A policy of the comparison.
struct Part {
    contender: Contender,
    /// What its scores must be of.
    of: String,
    /// False: its scores are taken if they are there.
    asked: bool,
}

/// The policies of the plan; those to be trained and scored are marked.
fn parts(args: &Args, plan: &Plan, beside: &Path) -> Result<Vec<Part>, Failure> {
    check_only(&args.only, plan)?;
    let motions = args.motions.as_deref().map(motions_value);
    let part = |contender: Contender| {
        for preset in &contender.stages {
            stages::refuse_another(&stages::run_folder(&args.out, &contender, preset), preset)?;
        }
        stages::refuse_another_origin(&args.out, &contender)?;
        let of = contender.print(args.motions.as_deref())?;
        let asked = args.only.is_empty() || args.only.contains(&contender.name);
        Ok(Part { contender, of, asked })
    };
    plan.contenders(beside, motions.as_deref())?.into_iter().map(part).collect()
}

/// Refuses names that no entry of the plan has.
fn check_only(only: &[String], plan: &Plan) -> Result<(), Failure> {
    let Some(name) = only.iter().find(|name| !plan.entries.iter().any(|entry| entry.name == **name)) else {
        return Ok(());
    };
    let names = plan.entries.iter().map(|entry| format!("'{}'", entry.name)).collect::<Vec<_>>().join(", ");
    Err(Failure::input(format!("--only: expected an entry of the plan ({names}), found '{name}'")))
}

fn compare(args: &Args, joined: &Joined) -> Result<ExitCode, Failure> {
    let threads = thread_count(args.threads)?;
    let plan = Plan::read(&args.plan)?;
    if let Some(folder) = args.motions.as_deref().filter(|folder| !folder.exists()) {
        let found = folder.display();
        return Err(Failure::input(format!("--motions: expected a folder of motion files, found {found}")));
    }
    let beside = args.plan.parent().unwrap_or(Path::new(""));
    let parts = parts(args, &plan, beside)?;
    for (name, file) in plan.left_out(beside) {
        eprintln!("note: '{name}' is left out: no file {}", file.display());
    }
    let mut own = Introduction::default();
    own.tell_options(&plan);
    own.tell_options(&args.only);
    for part in parts.iter().filter(|part| part.asked) {
        own.tell("scores of", &part.of);
        for preset in &part.contender.stages {
            own.tell_run(preset, &Scene::load(preset)?)?;
        }
    }
    Engines::Mujoco.check()?;
    check(args, &plan, &parts)?;
    meet(&*joined.ranks, |all| {
        all.tell_all(&own);
        Ok(())
    })?;
    let (rank, count) = (joined.ranks.rank(), joined.ranks.count());
    let mut stopped = false;
    let asked: Vec<&Part> = parts.iter().filter(|part| part.asked).collect();
    for (k, part) in asked.iter().enumerate().filter(|(k, _)| k % count == rank) {
        let contender = &part.contender;
        let name = format!("{} of {}: {}{}", k + 1, asked.len(), contender.name, contender.suffix());
        stopped = !work(args, &plan, part, &name, threads)?;
        if stopped {
            break;
        }
        // After every policy, so that a comparison of days can be read on its way.
        if joined.is_first() {
            write(args, &plan, &parts)?;
        }
    }
    // The first one waits for all of them.
    let all = joined.ranks.gather(&[u8::from(stopped)]);
    if all.iter().flatten().any(|stopped| *stopped != 0) {
        return Ok(ExitCode::from(STOPPED));
    }
    if joined.is_first() {
        let comparison = write(args, &plan, &parts)?;
        if args.json {
            println!("{}", to_json(&comparison)?);
        } else {
            print!("{}", comparison.table());
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// Reads what the plan's entries begin with, before the first of them is trained. Those that already have scores are not read again.
fn check(args: &Args, plan: &Plan, parts: &[Part]) -> Result<(), Failure> {
    let robot =
        parts.iter().flat_map(|part| &part.contender.stages).map(|preset| preset.robot.as_str()).next();
    for part in parts.iter().filter(|part| part.asked) {
        if known(args, plan, part)?.is_none() {
            let motions = part.contender.motions(args.motions.as_deref());
            part.contender.check(&plan.judge, motions.as_deref(), robot)?;
        }
    }
    Ok(())
}

/// Trains and scores an entry unless that was done before; false after Ctrl-C.
fn work(args: &Args, plan: &Plan, part: &Part, name: &str, threads: usize) -> Result<bool, Failure> {
    // An entry that is trained and scored is not even loaded: this version may not be able to continue checkpoints of an earlier one.
    let scores = match known(args, plan, part)? {
        Some(scores) => scores,
        None => {
            let contender = &part.contender;
            let trained = stages::train(&args.out, contender, name, threads, args.quiet, &flag()?)?;
            let Some((policy, samples)) = trained else { return Ok(false) };
            let motions = contender.motions(args.motions.as_deref());
            let spec = SubjectSpec { motions, threads, ..SubjectSpec::new(policy) };
            match score(args, plan, part, &spec, &samples)? {
                Some(scores) => scores,
                None => return Ok(false),
            }
        }
    };
    if args.quiet {
        return Ok(true);
    }
    for judgment in &scores.judgments {
        let goals = [judgment.fixed, judgment.rolling].map(|shots| shots.goals.text());
        eprintln!("{name}, {:?}: static {}, rolling {}", judgment.knowledge, goals[0], goals[1]);
    }
    for track in &scores.tracks {
        eprintln!("{name}, {}: MPJPE {:.1} mm", track.clip, track.mpjpe_mm);
    }
    Ok(true)
}

/// Writes table, JSON, diagram and page of the entries that are trained and scored.
fn write(args: &Args, plan: &Plan, parts: &[Part]) -> Result<Comparison, Failure> {
    let (mut courses, mut filmed) = (Vec::new(), Vec::new());
    let mut comparison = Comparison { title: plan.title.clone(), rows: Vec::new() };
    for part in parts {
        let contender = &part.contender;
        let Some(scores) = known(args, plan, part)? else { continue };
        let (name, paper) = (contender.name.clone(), contender.paper.clone());
        comparison.rows.push(Row { name, paper, seed: contender.seed, scores });
        // A tracker has no shots.
        if contender.tracks {
            continue;
        }
        let name = format!("{}{}", contender.name, contender.suffix());
        filmed.push((name.clone(), contender.folder.as_path()));
        if !contender.stages.is_empty() {
            let folder = |preset| stages::run_folder(&args.out, contender, preset);
            courses.push(Course { name, stages: contender.stages.iter().map(folder).collect() });
        }
    }
    write_whole(&args.out.join("comparison.txt"), comparison.table().as_bytes())?;
    write_whole(&args.out.join("comparison.json"), to_json(&comparison)?.as_bytes())?;
    films::gather(&args.out, filmed.into_iter())?;
    if !courses.is_empty() {
        curves::figure(&courses)?.save(&args.out.join("comparison_curves"))?;
    }
    write_report(&args.out)?;
    Ok(comparison)
}

/// The scores of an entry, if it was trained to its end and scored as the plan says.
fn known(args: &Args, plan: &Plan, part: &Part) -> Result<Option<Scores>, Failure> {
    match stages::trained(&args.out, &part.contender) {
        Some(samples) => {
            let file = args.out.join(&part.contender.folder).join(SCORES);
            Ok(Scores::read(&file, &plan.judge, &samples, &part.of)?)
        }
        None => Ok(None),
    }
}

/// Scores a policy and keeps its scores, and film strips of its shots, in its folder; `None` after Ctrl-C.
fn score(
    args: &Args,
    plan: &Plan,
    part: &Part,
    spec: &SubjectSpec,
    samples: &[u64],
) -> Result<Option<Scores>, Failure> {
    let (monitor, progress) = Progress::start(args.quiet)?;
    let (judge, folder) = (&plan.judge, args.out.join(&part.contender.folder));
    let scores = if part.contender.tracks {
        Scores::track(judge, spec, samples, &monitor)
    } else {
        Scores::judge(judge, spec, samples, &folder, &monitor)
    };
    progress.finish();
    let Some(scores) = scores? else { return Ok(None) };
    let scores = Scores { of: part.of.clone(), ..scores };
    let text = serde_json::to_string_pretty(&scores).map_err(Failure::input)?;
    write_whole(&folder.join(SCORES), text.as_bytes())?;
    Ok(Some(scores))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_entries_of_the_plan_can_be_asked_for() {
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("plan.toml");
        let entries = "[[entry]]\nname = \"AMP\"\n[[entry]]\nname = \"Ours, fast\"\n";
        std::fs::write(&path, format!("title = \"two\"\nsamples = 1\n{entries}")).expect("writes");
        let plan = Plan::read(&path).expect("reads");
        let names = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
        assert!(check_only(&[], &plan).is_ok());
        assert!(check_only(&names(&["Ours, fast", "AMP"]), &plan).is_ok());
        let error = check_only(&names(&["AMP", "Ours"]), &plan).expect_err("unknown").to_string();
        assert_eq!(error, "--only: expected an entry of the plan ('AMP', 'Ours, fast'), found 'Ours'");
    }
}
