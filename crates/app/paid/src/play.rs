//! `paid play`: shows a motion, a human next to the robot that follows, or an episode of a policy.

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use paid_eval::footage::{Footage, Recorder, Shows, picture};
use paid_eval::shooting::Grid;
use paid_eval::shot::Shot;
use paid_eval::subject::Subject;
use paid_lab::dataset::{Dataset, PICTURES};
use paid_live::{Motions, play_motions};
use paid_motion::{Clip, JointOrder, MotionLibrary, ReadOptions, read_motion};
use paid_plot::{Animation, Kind};
use paid_retarget::{HumanMotion, is_human_file};
use paid_robot::{RobotModel, RobotSpec};
use paid_terminal::{STOPPED, flag};

use crate::eval::episode::ShotArgs;
use crate::eval::subject::Setting;
use crate::failure::Failure;
use crate::live::LiveArgs;
use crate::motion::{How, Place, retarget_file};
use crate::viewer::Target;

/// Arguments of `paid play`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Motion file, or a folder of motions [default: the built-in kicks].
    ///
    /// A robot's motion (.npz, .csv, .pkl), or a human's (.bvh, .amc), which is retargeted and shown next to the robot.
    input: Option<PathBuf>,
    /// Clip to show: its name, or its number from 0 [default: 0].
    ///
    /// With --policy the default is the clip nearest to the ball.
    #[arg(long, value_name = "CLIP")]
    clip: Option<String>,
    /// File to write: .gif or .png (animated), or a folder of images.
    ///
    /// A name without an extension is a folder of numbered images.
    #[arg(long, value_name = "OUT", required_unless_present_any = ["rerun", "live"])]
    record: Option<PathBuf>,
    /// Show it in Rerun: FILE.rrd, live, or the address of a viewer.
    ///
    /// live is the viewer on this machine, which is started if none runs. Needs a program built with --features rerun.
    #[arg(long, value_name = "FILE.rrd|live|URL")]
    rerun: Option<String>,
    /// Width and height of the images [pixels].
    #[arg(long, value_name = "WxH", default_value = "480x360", value_parser = size)]
    size: [usize; 2],
    /// Frame rate of the recording [Hz]; motions run at their own speed.
    #[arg(long, hide_short_help = true, value_name = "HZ", default_value_t = 20.0)]
    pictures: f64,
    /// Joint order of a CSV or pickle file that does not state it.
    ///
    /// model is depth-first, policy is breadth-first.
    #[arg(long, hide_short_help = true, value_name = "ORDER")]
    joint_order: Option<JointOrder>,
    #[command(flatten, next_help_heading = "Human motion")]
    how: How,
    #[command(flatten)]
    policy: EpisodeArgs,
    /// Where a kick's own ball lies, for the figures on the page.
    #[arg(long, hide_short_help = true, value_enum, default_value_t = Place::TorsoEnd, requires = "live")]
    place: Place,
    #[command(flatten)]
    live: LiveArgs,
}

/// The policy whose episode is shown.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "An episode of a policy")]
struct EpisodeArgs {
    /// Show an episode of this policy: run folder, checkpoint or ONNX file.
    ///
    /// Of a run folder, the mean of its last checkpoints is taken.
    #[arg(long, value_name = "POLICY")]
    policy: Option<PathBuf>,
    /// Do not draw the reference (the pale blue robot).
    #[arg(long, hide_short_help = true, requires = "policy")]
    no_ghost: bool,
    /// Do not draw contact forces (red arrows, 1 m for 1000 N).
    #[arg(long, hide_short_help = true, requires = "policy")]
    no_forces: bool,
    #[command(flatten)]
    shot: ShotArgs,
    #[command(flatten)]
    setting: Setting,
}

fn size(text: &str) -> Result<[usize; 2], String> {
    let side = |part: &str| part.trim().parse().ok().filter(|n| (64..=2000).contains(n));
    match text.split_once('x').map(|(w, h)| (side(w), side(h))) {
        Some((Some(w), Some(h))) => Ok([w, h]),
        _ => Err(format!("expected two sizes from 64 to 2000 such as 640x480, found '{text}'")),
    }
}

/// The options of a human's motion, by the names of their fields.
const HUMAN: [&str; 10] =
    ["skeleton", "unit", "height", "from", "to", "slow", "speed_limit", "rate", "label", "license"];

/// The options of a recorded shot, by the names of their fields: on the page they are chosen there.
const NOT_LIVE: [&str; 7] = ["ball", "velocity", "limit", "size", "pictures", "no_ghost", "no_forces"];

/// Refuses what was given and would change nothing. Clap's own `requires` and `conflicts_with` are not enough: if an argument
/// conflicts with another, clap ignores that others require it.
fn refuse_ignored(args: &Args, given: &[String]) -> Result<(), Failure> {
    const A_HUMANS: &str = "a human's motion (.bvh, .amc)";
    const A_FILE: &str = "the file of one motion";
    const A_SET: &str = "a folder of motions";
    let human = HUMAN.map(|id| (id, A_HUMANS));
    let file = [("fps", A_FILE), ("joint_order", A_FILE)];
    let clip = [("clip", A_SET)];
    let (found, ignored): (String, Vec<(&str, &str)>) = match (&args.policy.policy, &args.input) {
        (Some(_), Some(path)) => {
            let found = path.display();
            return Err(Failure::input(format!(
                "motion {found}: cannot be used with --policy; name its motions with --motions"
            )));
        }
        (Some(_), None) => {
            let place = [("place", A_SET)];
            ("--policy".to_owned(), [&human[..], &file, &place].concat())
        }
        (None, None) => ("the built-in kicks".to_owned(), [&human[..], &file].concat()),
        (None, Some(path)) if path.is_dir() => {
            (format!("the folder {}", path.display()), [&human[..], &file].concat())
        }
        (None, Some(path)) if is_human_file(path) => {
            let order = [("joint_order", "a robot's motion (.csv, .pkl)")];
            (format!("the file {}", path.display()), [clip, order].concat())
        }
        (None, Some(path)) => (format!("the file {}", path.display()), [&human[..], &clip].concat()),
    };
    Failure::if_ignored(ignored, given, &found)?;
    if args.live.live {
        return Failure::if_ignored(NOT_LIVE.map(|id| (id, "no page in the browser")), given, "--live");
    }
    Ok(())
}

/// Records what there is to see and shows it.
pub fn run(args: &Args, given: &[String]) -> Result<ExitCode, Failure> {
    refuse_ignored(args, given)?;
    if !(2.0..=50.0).contains(&args.pictures) {
        return Err(Failure::input(format!("--pictures: expected 2 to 50 Hz, found {}", args.pictures)));
    }
    if args.live.live {
        return live(args);
    }
    // Refusals come before work.
    args.record.as_deref().map(Kind::of).transpose()?;
    let target = args.rerun.as_deref().map(Target::new).transpose()?;
    let footage = match &args.policy.policy {
        Some(policy) => episode(args, policy)?,
        None => {
            let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
            let (clip, human) = open(args, &model, &spec)?;
            Footage::of_motion(&model, &spec, &clip, human)
        }
    };
    let shows = Shows { ghost: !args.policy.no_ghost, forces: !args.policy.no_forces };
    if let Some(path) = &args.record {
        let count = (footage.duration_s() * args.pictures + 1e-9).floor() as usize + 1;
        let stop = flag()?;
        let mut animation = Animation::create(path, args.size, args.pictures, count)?;
        for k in 0..count {
            if stop.load(Ordering::SeqCst) {
                // An animation that is given up takes its part of a file with it.
                return Ok(ExitCode::from(STOPPED));
            }
            let t = (k as f64 / (args.pictures * footage.dt_s)).round() as usize;
            let image = picture(&footage, t.min(footage.frames.len() - 1), args.size, shows);
            animation.add(&image)?;
        }
        animation.finish()?;
        let (file, name) = (path.display(), &footage.name);
        println!("{file}: {count} images of {name}, {:.2} s", footage.duration_s());
    }
    if let Some(target) = &target {
        let place = target.send(&footage, shows)?;
        println!(
            "{place}: {} frames of {}, {:.2} s",
            footage.frames.len(),
            footage.name,
            footage.duration_s()
        );
    }
    if footage.episode {
        for (t, event) in &footage.events {
            println!("{:6.2} s  {event}", footage.time_s(*t));
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// The policy, or a set of motions, in the browser.
fn live(args: &Args) -> Result<ExitCode, Failure> {
    if args.record.is_some() || args.rerun.is_some() {
        return Err(Failure::input("--live: expected no --record and no --rerun, found one"));
    }
    let EpisodeArgs { policy, setting, .. } = &args.policy;
    let Some(policy) = policy else { return live_motions(args) };
    setting.one_engine()?;
    let subject = Subject::load(&setting.spec(policy, "paper_stage2")?)?;
    subject.require_ball()?;
    let names: Vec<&str> = subject.setup.library.facts().iter().map(|f| f.name.as_str()).collect();
    let clip = args.clip.as_deref().map(|wanted| index_of(&names, wanted)).transpose()?;
    args.live.serve(&subject, clip.and_then(|clip| u16::try_from(clip).ok()))
}

/// A set of motions in the browser, with what it covers.
fn live_motions(args: &Args) -> Result<ExitCode, Failure> {
    let (robot, spec) = (RobotModel::g1(), RobotSpec::g1());
    let (name, clips) = match &args.input {
        Some(path) if path.is_dir() => {
            (path.display().to_string(), MotionLibrary::load_unchanged(path, &robot, &spec))
        }
        None => {
            ("built-in kicks".to_owned(), MotionLibrary::builtin(&robot, &spec, paid_motion::generate::FPS))
        }
        Some(path) => {
            let found = path.display();
            return Err(Failure::input(format!(
                "--live: expected --policy or a folder of motions, found {found}"
            )));
        }
    };
    let clips = clips.map_err(Failure::input)?.clips;
    let names: Vec<&str> = clips.iter().map(|clip| clip.name.as_str()).collect();
    let clip = args.clip.as_deref().map(|wanted| index_of(&names, wanted)).transpose()?;
    let set = Dataset::new(&clips, &robot, &spec, Grid::EFFECTIVE, args.place.into())?;
    let (share, advice) = (set.coverage.share(), set.coverage.advice());
    let draw = Arc::new(move |name: &str| set.picture(name).map(|figure| figure.svg()));
    let motions = Motions { name, clips, pictures: PICTURES, share, advice, draw, robot, spec };
    let ready = |url: &str| {
        println!("{url}  <- open this in a browser");
        println!("{} kicks of {}; Ctrl-C ends it", motions.clips.len(), motions.name);
        println!("{}", motions.advice);
    };
    let clip = clip.and_then(|clip| u16::try_from(clip).ok());
    let stop = flag()?;
    play_motions(&motions, &args.live.options(), clip, &stop, ready).map_err(Failure::input)?;
    Ok(ExitCode::SUCCESS)
}

/// An episode of the policy.
fn episode(args: &Args, policy: &std::path::Path) -> Result<Footage, Failure> {
    let EpisodeArgs { shot, setting, .. } = &args.policy;
    setting.one_engine()?;
    let subject = Subject::load(&setting.spec(policy, "paper_stage2")?)?;
    let setup = &subject.setup;
    let names: Vec<&str> = setup.library.facts().iter().map(|f| f.name.as_str()).collect();
    let motion = args.clip.as_deref().map(|wanted| index_of(&names, wanted)).transpose()?;
    // Reward terms are only shown by Rerun.
    let shot = Shot { reward_terms: args.rerun.is_some(), ..shot.shot(motion) };
    let watched = shot.watch(&subject, |_| Recorder::new(setup))?;
    let name = format!("{} on {} in {}", subject.name, names[watched.motion], setup.engine.name());
    Ok(watched.kept.footage(setup, name, watched.goal_half_width_m))
}

fn open(args: &Args, model: &RobotModel, spec: &RobotSpec) -> Result<(Clip, Option<HumanMotion>), Failure> {
    let wanted = args.clip.as_deref().unwrap_or("0");
    match &args.input {
        Some(path) if path.is_dir() => pick(MotionLibrary::load_unchanged(path, model, spec), wanted),
        None => pick(MotionLibrary::builtin(model, spec, paid_motion::generate::FPS), wanted),
        Some(path) if is_human_file(path) => {
            let out = retarget_file(path, &args.how, model, spec)?;
            Ok((out.clip, Some(out.human)))
        }
        Some(path) => {
            let options =
                ReadOptions { fps: args.how.fps(), joint_order: args.joint_order, ..ReadOptions::default() };
            Ok((read_motion(path, model, spec, &options).map_err(Failure::input)?, None))
        }
    }
}

fn pick(
    library: Result<MotionLibrary, paid_motion::MotionError>,
    wanted: &str,
) -> Result<(Clip, Option<HumanMotion>), Failure> {
    let mut clips = library.map_err(Failure::input)?.clips;
    let names: Vec<&str> = clips.iter().map(|c| c.name.as_str()).collect();
    let index = index_of(&names, wanted)?;
    Ok((clips.swap_remove(index), None))
}

/// The clip of a name, or of a number from 0.
fn index_of(names: &[&str], wanted: &str) -> Result<usize, Failure> {
    let index = names.iter().position(|name| *name == wanted).or_else(|| wanted.parse().ok());
    index.filter(|i| *i < names.len()).ok_or_else(|| {
        let expected = format!("0 to {} or one of {}", names.len() - 1, names.join(", "));
        Failure::input(format!("--clip: expected {expected}, found '{wanted}'"))
    })
}
