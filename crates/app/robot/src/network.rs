//! What talks to a robot on the network.

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use paid_runtime::eyes::{Sensed, SensedLink};
use paid_runtime::log::{LogHeader, LogWriter};
use paid_runtime::switcher::{Patience, Reply, SwitcherClient, await_release};
use paid_runtime::view::Screen;
use paid_runtime::wire::LowState;
use paid_runtime::{
    BareTimer, Checker, DdsLink, DeployError, Inlet, LATENESS_EDGES_MS, LastWords, Live, Packet, Player,
    Runtime, Side, Told, Usage, Writer, lateness_table, run_live,
};
use paid_terminal::{
    Failure, STOPPED, end_with_the_reader, flag, outlive_the_terminal, panic_where_it_fails,
};

use crate::args::{NetworkArgs, PlayerArgs, duration, print_event, print_latency, print_usage, read_limits};
use crate::eyes;
use crate::screen::Viewer;

/// Receives the events and states of a run, in addition to the terminal.
pub type Teller = Box<dyn FnMut(Told<'_>) + Send>;

/// Arguments of `paid robot run`.
#[derive(Debug, clap::Args)]
pub struct RunArgs {
    /// Policy and motions.
    #[command(flatten)]
    pub player: PlayerArgs,
    #[command(flatten)]
    network: NetworkArgs,
    /// Use the robot's camera and LiDAR for ball and odometry, as this TOML file sets.
    #[arg(long, value_name = "FILE", conflicts_with = "virtual_senses")]
    #[arg(hide = cfg!(not(feature = "perception")))]
    eyes: Option<PathBuf>,
    /// Use the virtual senses of `paid robot sim` for ball and odometry.
    ///
    /// They start from the true values and add random errors.
    #[arg(long)]
    virtual_senses: bool,
    /// Release the vendor's controller if it is in command. THE ROBOT GOES LIMP: it must hang on the gantry.
    #[arg(long, conflicts_with = "no_switcher")]
    release: bool,
    /// Run everything, but send no joint commands. With --release the vendor's controller is still released: THE ROBOT GOES LIMP.
    #[arg(long)]
    dry_run: bool,
    /// Write each step to this log, a new file.
    #[arg(long, help_heading = "Output", value_name = "FILE")]
    log: Option<PathBuf>,
    /// Print events, status and figures as JSON, one per line.
    #[arg(long, help_heading = "Output")]
    json: bool,
    /// Print nothing before the end.
    #[arg(long, help_heading = "Output", conflicts_with = "json")]
    quiet: bool,
    /// Show states, rates, joints and ball in the terminal; keys act as the remote.
    #[arg(long, help_heading = "Output", conflicts_with_all = ["json", "quiet"])]
    view: bool,
    /// Stop after this time [s] [default: run until Ctrl-C].
    #[arg(long, value_name = "S")]
    seconds: Option<f64>,
}

/// Runs a policy on the robot. `watch` is given the player and the flag that ends the run, and may return a receiver of its events.
///
/// # Errors
/// If something is missing, does not fit or is refused.
pub fn run(
    args: &RunArgs,
    watch: impl FnOnce(&Arc<Player>, &Arc<AtomicBool>) -> Result<Option<Teller>, Failure>,
) -> Result<ExitCode, Failure> {
    // A robot is damped before its program ends, whatever cannot be printed.
    panic_where_it_fails();
    outlive_the_terminal();
    // What can be refused is refused here: later the robot may be limp.
    let seconds = args.seconds.map(duration).transpose()?;
    let (player, limits) = args.player.load()?;
    let NetworkArgs { domain, interface, no_switcher } = args.network;
    let eyes = args.eyes.as_deref().map(|file| eyes::plan(file, &player, &args.network)).transpose()?;
    if args.view {
        Screen::check().map_err(no_terminal)?;
    }
    let stop = flag()?;
    let mut teller = watch(&player, &stop)?;
    // A log in which nothing was written is gone again if the start is refused.
    let log = match &args.log {
        Some(file) => {
            let header = LogHeader { player: args.player.spec(), limits: limits.clone() };
            Some(LogWriter::create(file, &header)?)
        }
        None => None,
    };
    let link = DdsLink::open(domain, interface, Side::Runtime).map_err(Failure::input)?;
    let switcher = if no_switcher {
        None
    } else {
        let mut client = SwitcherClient::new(link.switcher().map_err(Failure::input)?);
        let patience = Patience::default();
        match await_release(&mut client, args.release, patience, &stop, |line| eprintln!("{line}")) {
            Ok(()) => {}
            Err(stopped @ DeployError::Stopped) => {
                eprintln!("{stopped}");
                return Ok(ExitCode::from(STOPPED));
            }
            Err(error) => return Err(error.into()),
        }
        Some(client.into_line())
    };
    if !args.json && !args.quiet {
        let dry = if args.dry_run { ", dry run: no commands" } else { "" };
        println!("domain {domain}, interface {interface}{dry}");
        println!("L2+Up: stand up; R1+X: allow kicks; L2+B: damping. Ctrl-C: damping, then exit.");
    }
    let writer = Writer::new(&limits, player.joints());
    let runtime = Runtime::new(Arc::clone(&player), limits);
    let last_words = LastWords::default();
    let opened = eyes.map(|open| open(runtime.phase(), &last_words)).transpose()?;
    let (eyes, sensed, lines) = match opened {
        Some((eyes, sensed, lines)) => (Some(eyes), sensed, Some(lines)),
        None if args.virtual_senses => (None, Sensed::Virtual, None),
        None => (None, Sensed::Nothing, None),
    };
    if matches!(sensed, Sensed::Nothing) && !args.json && !args.quiet {
        println!("without --eyes or --virtual-senses the robot sees no ball and does not kick");
    }
    let mut states = link.state_topic();
    let link = SensedLink::new(link, sensed);
    let keys = args.view.then(Arc::default);
    let live = Live {
        writer,
        runtime,
        dry_run: args.dry_run,
        log,
        switcher,
        keys: keys.clone(),
        last_words: last_words.clone(),
        duration: seconds,
    };
    let mut screen = match &keys {
        Some(keys) => Some(Viewer::begin(keys, &stop, &last_words)?),
        None => None,
    };
    let shown = &mut screen;
    let timer = BareTimer::start();
    let (begin, before) = (Instant::now(), Usage::now());
    let report = run_live(live, link, &stop, move |told| {
        let from_eyes = lines.iter().flat_map(|lines| lines.try_iter()).map(|line| ("eyes", line));
        let overdue = match told {
            Told::Status(status) => states.overdue(status.runtime.states),
            Told::Event(_) => None,
        };
        for (from, line) in from_eyes.chain(overdue.map(|line| ("robot", line))) {
            match shown.as_mut() {
                Some(screen) => screen.note(&format!("{from}: {line}")),
                None if args.json => json_line(from, &line),
                None if args.quiet => {}
                None => println!("{from}: {line}"),
            }
        }
        if let Some(tell) = &mut teller {
            tell(told);
        }
        match (shown.as_mut(), told) {
            (Some(screen), told) => screen.tell(told),
            (None, Told::Event(event)) if args.json => json_line("event", event),
            (None, Told::Status(status)) if args.json => json_line("status", status),
            (None, Told::Event(event)) if !args.quiet => print_event(event),
            (None, Told::Event(_) | Told::Status(_)) => {}
        }
    });
    // The robot is damped; what is left is the report.
    end_with_the_reader();
    let usage = Usage::since(begin, &before);
    let timer = timer.end().figures();
    if let Some(screen) = screen {
        screen.end();
    }
    drop(eyes);
    let report = report?;
    if args.view {
        report.events.iter().for_each(print_event);
    }
    let (commands, policy) = (report.lateness.figures(), report.policy_steps.figures());
    if args.json {
        json_line(
            "end",
            &serde_json::json!({
                "kicks": report.kicks,
                "steps": report.steps,
                "longest_step_us": report.longest_step_us,
                "edges_ms": LATENESS_EDGES_MS,
                "commands_late": commands,
                "bare_timer_late": timer,
                "policy_steps_took": policy,
                "capture_to_targets": report.latency.figures(),
                "capture_to_targets_ms": report.latency.histogram(),
                "usage": usage,
                "real_time": report.real_time,
                "dropped_frames": report.dropped_frames,
                "log_failed": report.log_failed,
                "died": report.died,
            }),
        );
        return Ok(if report.died.is_none() { ExitCode::SUCCESS } else { ExitCode::from(1) });
    }
    println!(
        "{} kicks; {} steps, the longest {:.2} ms",
        report.kicks,
        report.steps,
        report.longest_step_us as f64 * 1e-3
    );
    let [half, most, nearly_all, all] = policy.within_ms;
    if policy.periods > 0 {
        println!(
            "{} policy steps within {half:.2} / {most:.2} / {nearly_all:.2} / {all:.2} ms (50 / 99 / 99.9 / 100%)",
            policy.periods
        );
    }
    print_latency(&report.latency);
    print_usage(&usage);
    print!("{}", lateness_table(&commands, &timer));
    if !report.real_time {
        println!("the system grants no real-time priority (that needs CAP_SYS_NICE): commands may be late");
    }
    if report.dropped_frames > 0 {
        println!("the log lacks {} steps: the disk was too slow", report.dropped_frames);
    }
    if let Some(why) = &report.log_failed {
        println!("the log is not complete: {why}");
    }
    match report.died {
        None => Ok(ExitCode::SUCCESS),
        Some(panic) => {
            println!("the runtime panicked: {panic}");
            Ok(ExitCode::from(1))
        }
    }
}

/// `--view` without a terminal.
pub(crate) fn no_terminal(error: std::io::Error) -> Failure {
    Failure::input(format!("--view needs a terminal: {error}"))
}

/// Prints a line of JSON: its kind and its content. Infinite ages are null.
fn json_line(kind: &str, content: &impl serde::Serialize) {
    println!("{}", serde_json::json!({ kind: content }));
}

/// Arguments of `paid robot check`.
#[derive(Debug, clap::Args)]
pub struct CheckArgs {
    #[command(flatten)]
    network: NetworkArgs,
    /// TOML file of limits.
    ///
    /// Temperatures, and `check_crc = false` for the vendor's simulator, which sets no checksum.
    #[arg(long, value_name = "FILE")]
    limits: Option<PathBuf>,
    /// Time to listen [s]; move one joint after another by hand meanwhile.
    ///
    /// Move them in the order of the table, each in its positive direction first. The table shows which joint moved, how far, and in
    /// which direction first.
    #[arg(long, value_name = "S", default_value_t = 60.0)]
    seconds: f64,
}

/// Listens. Exit code 1 if a runtime should not start by what was seen.
///
/// # Errors
/// If the network cannot be opened, or a file does not fit.
pub fn check(args: &CheckArgs) -> Result<ExitCode, Failure> {
    let seconds = duration(args.seconds)?;
    let limits = read_limits(args.limits.as_deref())?;
    let stop = flag()?;
    let NetworkArgs { domain, interface, no_switcher } = args.network;
    let mut link = DdsLink::open(domain, interface, Side::Runtime).map_err(Failure::input)?;
    let mut switcher = SwitcherClient::new(link.switcher().map_err(Failure::input)?);
    let checker = if no_switcher { Checker::without_switcher() } else { Checker::default() };
    let mut checker = checker.with_limits(limits);
    let states = link.state_topic();
    let begin = Instant::now();
    let (mut asked_s, mut came) = (0, false);
    while begin.elapsed() < seconds && !stop.load(Ordering::Relaxed) {
        while let Some(packet) = link.receive().map_err(Failure::input)? {
            came |= matches!(&packet, Packet::LowState(bytes) if LowState::from_cdr(bytes).is_ok());
            checker.take(begin.elapsed().as_micros() as u64, &packet);
        }
        if !no_switcher && begin.elapsed().as_secs() > asked_s {
            asked_s = begin.elapsed().as_secs();
            switcher.check().map_err(Failure::input)?;
        }
        while let Some(reply) = switcher.reply().map_err(Failure::input)? {
            if let Reply::Master(master) = reply {
                checker.take(begin.elapsed().as_micros() as u64, &Packet::Master(master.name));
            }
        }
        std::thread::sleep(Duration::from_micros(200));
    }
    let report = checker.report();
    println!("{}", report.text);
    if !came {
        println!("{}", states.why());
    }
    println!("{}", report.verdict());
    Ok(if report.good { ExitCode::SUCCESS } else { ExitCode::from(1) })
}
