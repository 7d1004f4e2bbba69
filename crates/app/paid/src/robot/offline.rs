//! A virtual robot, and its matches in lockstep, which need no network.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use paid_robot_program::{PlayerArgs, at_least_one, domain, print_latency};
use paid_runtime::Player;
use paid_runtime::log::{LogHeader, LogWriter};
use paid_twin::{
    KickResult, LockstepOptions, MatchOptions, MatchResult, OwnEyesOptions, TorsoSource, Watcher, play_match,
};

use super::VariantArgs;
use super::serve::serve_network;
use super::watch::Watching;
use crate::failure::Failure;
use crate::live::LiveArgs;
use paid_terminal::{STOPPED, flag};

/// Arguments of `paid robot sim`.
#[derive(Debug, clap::Args)]
pub struct SimArgs {
    #[command(flatten)]
    pub(super) player: PlayerArgs,
    #[command(flatten)]
    variant: VariantArgs,
    /// Run the runtime in this program, and let simulated time wait for it.
    ///
    /// The results of a match are then the same on each machine.
    #[arg(long, conflicts_with_all = ["domain", "interface", "script"])]
    lockstep: bool,
    /// Kicks per match [default: 11 in lockstep].
    ///
    /// On the network, this program then runs the match: it presses the remote's keys, places goal and balls, counts, and ends after the
    /// match.
    #[arg(long, value_name = "N")]
    pub(super) kicks: Option<usize>,
    /// Number of matches, each with the next seed.
    #[arg(
        long,
        help_heading = "In lockstep",
        value_name = "N",
        default_value_t = 1,
        requires = "lockstep",
        conflicts_with = "record"
    )]
    matches: u64,
    /// Write each step to this log, a new file.
    ///
    /// Each of several matches has its own, with the seed in its name: match.mcap becomes match_0.mcap, match_1.mcap and so on.
    #[arg(long, help_heading = "In lockstep", value_name = "FILE", requires = "lockstep")]
    log: Option<PathBuf>,
    /// Record the camera's color and depth images as MCAP.
    ///
    /// The messages are those of ROS 2, half a megabyte each. In lockstep with --eyes, the estimates are recorded too.
    #[arg(long, value_name = "FILE")]
    pub(super) record: Option<PathBuf>,
    /// With --kicks: print kicks and the end as JSON, one per line.
    #[arg(long, help_heading = "On the network", requires = "kicks", conflicts_with = "lockstep")]
    pub(super) json: bool,
    /// Seed of the balls and of the sensor errors.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(super) seed: u64,
    /// DDS domain; 1 is usual for simulators.
    #[arg(
        long,
        help_heading = "On the network",
        value_name = "N",
        required_unless_present = "lockstep",
        value_parser = domain
    )]
    domain: Option<u16>,
    /// Address of this machine's interface, such as 127.0.0.1.
    #[arg(
        long,
        help_heading = "On the network",
        value_name = "ADDRESS",
        required_unless_present = "lockstep"
    )]
    interface: Option<std::net::IpAddr>,
    /// Vendor's controller in command at the start, such as ai [default: released].
    ///
    /// It holds the robot, and commands have no effect until it is released.
    #[arg(
        long,
        value_name = "NAME",
        default_value = "",
        hide_default_value = true,
        help_heading = "On the network",
        conflicts_with = "lockstep"
    )]
    pub(super) master: String,
    /// Start standing, held until the joints hold the pose [default: on a gantry].
    ///
    /// The support ends once the joints have held the pose for half a second. On a gantry, it ends with the command `free`.
    #[arg(long, help_heading = "On the network", conflicts_with = "lockstep")]
    pub(super) standing: bool,
    /// Ball and odometry from rendered images and a simulated LiDAR.
    ///
    /// Otherwise virtual senses start from the true values and add random errors.
    #[arg(long, help_heading = "In lockstep", requires = "lockstep")]
    eyes: bool,
    /// Delay each command to the robot, as a network does, 0 to 20 [ms].
    #[arg(long, hide_short_help = true, help_heading = "In lockstep", value_name = "MS", default_value_t = 0.0, value_parser = delay, requires = "lockstep")]
    delay_ms: f64,
    /// Stop runtime and writer for this long every 1.3 s, 0 to 200 [ms].
    ///
    /// This is what happens on a computer that stalls.
    #[arg(long, hide_short_help = true, help_heading = "In lockstep", value_name = "MS", default_value_t = 0.0, value_parser = pause, requires = "lockstep")]
    pause_ms: f64,
    /// With --eyes: source of the torso's pose.
    #[arg(long, hide_short_help = true, help_heading = "In lockstep", value_name = "WHICH", value_enum, default_value_t = TorsoChoice::Lidar, requires = "eyes")]
    odometry: TorsoChoice,
    /// With --eyes: lowest score of a detection that counts, 0 to 1 [default: the detector's].
    #[arg(long, hide_short_help = true, help_heading = "In lockstep", value_name = "P", requires = "eyes")]
    confidence: Option<f64>,
    /// Images per second [default: 25 in lockstep with --eyes].
    ///
    /// On the network they are rendered while another program reads them; 0 renders none.
    #[arg(long, value_name = "HZ")]
    pub(super) camera_hz: Option<f64>,
    /// Send a Mid-360's packets to this address.
    ///
    /// IMU samples go to the port that is 100 higher. Example: 127.0.0.1:56301.
    #[arg(long, help_heading = "On the network", value_name = "ADDRESS:PORT", conflicts_with = "lockstep")]
    pub(super) lidar: Option<std::net::SocketAddr>,
    /// Read commands from a file, one per line: simulated time [s], then the command.
    ///
    /// Commands are also read from the keyboard: keys L2+Up, ball 1.2 0.1, goal 5 0, free, gantry, battery 15, fault silence, fault none,
    /// quit.
    #[arg(long, help_heading = "On the network", value_name = "FILE")]
    pub(super) script: Option<PathBuf>,
    #[command(flatten)]
    pub(super) live: LiveArgs,
}

fn delay(text: &str) -> Result<f64, String> {
    milliseconds(text, 20.0)
}

fn pause(text: &str) -> Result<f64, String> {
    milliseconds(text, 200.0)
}

fn milliseconds(text: &str, most: f64) -> Result<f64, String> {
    let found = text.parse().ok().filter(|x| (0.0..=most).contains(x));
    found.ok_or_else(|| format!("expected a number of milliseconds from 0 to {most}, found '{text}'"))
}

/// What follows the torso.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum TorsoChoice {
    /// LiDAR-inertial odometry.
    Lidar,
    /// The true pose with training's drift.
    Modeled,
}

/// Onboard perception in lockstep.
fn own_eyes(args: &SimArgs) -> OwnEyesOptions {
    let usual = OwnEyesOptions::default();
    OwnEyesOptions {
        rate_hz: args.camera_hz.unwrap_or(usual.rate_hz),
        torso: match args.odometry {
            TorsoChoice::Lidar => usual.torso,
            TorsoChoice::Modeled => TorsoSource::Modeled,
        },
        confidence: args.confidence,
        record: args.record.clone(),
        ..usual
    }
}

/// The seed of the last match.
fn last_seed(args: &SimArgs) -> Result<u64, Failure> {
    let (seed, matches) = (args.seed, args.matches);
    let more =
        matches.checked_sub(1).ok_or_else(|| Failure::input("--matches: expected at least 1, found 0"))?;
    seed.checked_add(more).ok_or_else(|| {
        let most = u64::MAX;
        Failure::input(format!(
            "--seed: expected a last seed up to {most}, found {matches} matches from {seed} on"
        ))
    })
}

/// The log of a match: the file itself if there is one match only.
fn log_of(args: &SimArgs, file: &Path, seed: u64) -> PathBuf {
    if args.matches == 1 {
        return file.to_owned();
    }
    let mut name = file.file_stem().unwrap_or_default().to_owned();
    name.push(format!("_{seed}"));
    if let Some(extension) = file.extension() {
        name.push(".");
        name.push(extension);
    }
    file.with_file_name(name)
}

/// A virtual robot.
pub fn sim(args: &SimArgs) -> Result<ExitCode, Failure> {
    if let Some(kicks) = args.kicks {
        at_least_one("--kicks", kicks)?;
    }
    let last_seed = last_seed(args)?;
    if let Some(file) = &args.log {
        (args.seed..=last_seed).try_for_each(|seed| LogWriter::check_new(&log_of(args, file, seed)))?;
    }
    let (player, limits) = args.variant.load(&args.player)?;
    if let (Some(domain), Some(interface), false) = (args.domain, args.interface, args.lockstep) {
        return serve_network(args, &player, domain, interface);
    }
    if args.record.is_some() && !args.eyes {
        return Err(Failure::input(
            "--record: expected --eyes in lockstep, which renders the images, found none",
        ));
    }
    let page = Watching::open(&args.live, &args.player, &player)?;
    let stop = flag()?;
    print_head();
    let mut results = Vec::new();
    for seed in args.seed..=last_seed {
        let log = match &args.log {
            Some(file) => {
                let header = LogHeader { player: args.player.spec(), limits: limits.clone() };
                Some(LogWriter::create(&log_of(args, file, seed), &header)?)
            }
            None => None,
        };
        let eyes = args.eyes.then(|| own_eyes(args));
        let [command_delay_us, pause_us] = [args.delay_ms, args.pause_ms].map(|ms| (ms * 1e3) as u64);
        let lockstep = LockstepOptions {
            limits: limits.clone(),
            seed,
            command_delay_us,
            pause_us,
            eyes,
            stop: Arc::clone(&stop),
        };
        let mut options = MatchOptions { lockstep, ..MatchOptions::default() };
        options.field.kicks = args.kicks.unwrap_or(11);
        results.push(one_match(&player, &options, log, page.as_ref())?);
        if stop.load(Ordering::Relaxed) {
            break;
        }
    }
    if results.len() > 1 {
        let sum = |of: &dyn Fn(&MatchResult) -> usize| results.iter().map(of).sum::<usize>();
        let (goals, balls) = (sum(&MatchResult::goals), sum(&|r| r.kicks.len()));
        println!(
            "\n{} matches: {goals} goals of {balls} balls ({:.1}%), {} matches stopped",
            results.len(),
            100.0 * goals as f64 / balls.max(1) as f64,
            sum(&|r| usize::from(r.stopped.is_some()))
        );
    }
    Ok(if stop.load(Ordering::Relaxed) { ExitCode::from(STOPPED) } else { ExitCode::SUCCESS })
}

/// Heads of the table's columns.
pub(super) fn print_head() {
    println!(
        "{:>4} {:>14} {:<28} {:>10} {:>7} {:>5} {:>7}",
        "kick", "ball", "motion", "believed", "struck", "goal", "seconds"
    );
}

/// A row of it.
pub(super) fn print_kick(number: usize, kick: &KickResult) {
    let [x, y] = kick.ball;
    let yes = |b: bool| if b { "yes" } else { "no" };
    let believed =
        if kick.ball_error_m.is_nan() { "-".to_owned() } else { format!("{:.3} m", kick.ball_error_m) };
    println!(
        "{number:>4} {:>14} {:<28} {believed:>10} {:>7} {:>5} {:>7.1}",
        format!("{x:.2}, {y:.2} m"),
        kick.motion,
        yes(kick.struck),
        yes(kick.goal),
        kick.seconds
    );
}

/// Plays a match and prints it.
fn one_match(
    player: &Arc<Player>,
    options: &MatchOptions,
    log: Option<LogWriter>,
    page: Option<&Watching>,
) -> Result<MatchResult, Failure> {
    let mut number = 0;
    let watcher = page.map(|page| -> Box<dyn Watcher> { Box::new(page.look_on(true)) });
    let result = play_match(player, options, log, watcher, |kick| {
        number += 1;
        if let Some(page) = page {
            page.count(kick);
        }
        print_kick(number, kick);
    })?;
    let [tilt, gyro, speed, torque] = result.peak;
    let out_of_view: usize = result.kicks.iter().map(|kick| kick.out_of_view).sum();
    println!(
        "{} goals of {} balls in {:.0} s of simulated time, seed {}; {out_of_view} ball positions outside the image were drawn again",
        result.goals(),
        result.kicks.len(),
        result.seconds,
        options.lockstep.seed
    );
    println!(
        "under the policy at most: tilt {tilt:.2} rad, pelvis {gyro:.1} rad/s, joints {:.0}% of their speed and {:.0}% of their torque",
        100.0 * speed,
        100.0 * torque
    );
    print_latency(&result.latency);
    if let (Some(page), Some(why)) = (page, &result.stopped) {
        page.say(&format!("The runtime damped the robot: {why}."));
    }
    if let Some(why) = &result.stopped {
        println!("the runtime damped the robot: {why}");
    }
    Ok(result)
}
