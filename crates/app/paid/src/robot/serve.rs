//! The virtual robot on the network: served in real time, with commands from keyboard and script, or in a match.

use std::io::BufRead;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};
use std::time::Instant;

use paid_robot_program::print_usage;
use paid_runtime::switcher::SwitcherService;
use paid_runtime::{DdsLink, Player, Side, Usage};
use paid_twin::{
    Broadcast, BroadcastOptions, MatchOptions, Order, Referee, RefereeOptions, ServeOptions, Served,
    VendorLink, VirtualG1, Watcher, serve,
};

use super::offline::{SimArgs, print_head, print_kick};
use super::watch::Watching;
use crate::failure::Failure;

/// Lines of the keyboard.
fn keyboard() -> Receiver<String> {
    let (to, from) = channel();
    std::thread::spawn(move || {
        for line in std::io::stdin().lock().lines().map_while(Result::ok) {
            if to.send(line).is_err() {
                break;
            }
        }
    });
    from
}

/// A script's lines: when, and what.
fn script(file: &std::path::Path) -> Result<Vec<(f64, Order)>, Failure> {
    let name = file.display();
    let text = std::fs::read_to_string(file).map_err(|e| Failure::input(format!("{name}: {e}")))?;
    let lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    lines
        .map(|(k, line)| {
            let fail = |message: String| Failure::input(format!("{name}, line {}: {message}", k + 1));
            let (when, order) = line
                .trim()
                .split_once(' ')
                .ok_or_else(|| fail("expected a time and a command".to_owned()))?;
            let when =
                when.parse().map_err(|_| fail(format!("expected a time in seconds, found '{when}'")))?;
            Ok((when, order.parse().map_err(fail)?))
        })
        .collect()
}

/// Says when the machine falls behind real time.
struct Clock;

impl Watcher for Clock {
    fn step(&mut self, _robot: &VirtualG1) {}
    fn goal(&mut self, _center: [f64; 2], _heading: f64) {}
    fn behind(&mut self, lost_s: f64) {
        eprintln!("behind real time: {lost_s:.2} s lost so far");
    }
}

/// Runs the match, if one was asked for.
fn referee(args: &SimArgs, player: &Arc<Player>) -> Option<Referee> {
    args.kicks.map(|kicks| {
        let mut field = MatchOptions::default().field;
        field.kicks = kicks;
        let own_eyes = args.camera_hz != Some(0.0);
        Referee::new(player, RefereeOptions { field, seed: args.seed, own_eyes })
    })
}

/// Prints the kicks that are over.
fn tell(referee: &mut Referee, json: bool, page: Option<&Watching>) {
    while let Some((number, kick)) = referee.news() {
        if let Some(page) = page {
            page.count(kick);
        }
        if json {
            println!("{}", serde_json::json!({ "kick": { "number": number, "result": kick } }));
        } else {
            print_kick(number, kick);
        }
    }
}

/// Serves a virtual robot on the network.
pub(super) fn serve_network(
    args: &SimArgs,
    player: &Arc<Player>,
    domain: u16,
    interface: std::net::IpAddr,
) -> Result<ExitCode, Failure> {
    if args.record.is_some() && args.camera_hz == Some(0.0) {
        return Err(Failure::input("--record: expected images, found --camera-hz 0"));
    }
    let mut script = match &args.script {
        Some(file) => script(file)?,
        None => Vec::new(),
    };
    script.sort_by(|a, b| b.0.total_cmp(&a.0));
    let keyboard = keyboard();
    let stop = paid_terminal::flag()?;
    let link = DdsLink::open(domain, interface, Side::Robot).map_err(Failure::input)?;
    let line = link.switcher().map_err(Failure::input)?;
    let link = VendorLink::new(link, line, SwitcherService::new(&args.master), player);
    let mut referee = referee(args, player);
    let standing = args.standing || referee.is_some();
    if !args.json {
        let held = if standing { "a support until its joints hold it" } else { "a gantry" };
        println!("a virtual G1 on domain {domain}, interface {interface}, held by {held}");
        if !args.master.is_empty() {
            println!("the vendor's controller '{}' is in command", args.master);
        }
        if referee.is_some() {
            print_head();
        }
    }
    let page = Watching::open(&args.live, &args.player, player)?;
    let mut looks: Box<dyn Watcher> = match &page {
        Some(page) => Box::new(page.look_on(false)),
        None => Box::new(()),
    };
    let judging = &mut referee;
    let orders = |robot: &VirtualG1| {
        if let Some(referee) = judging.as_mut() {
            let order = referee.step(robot);
            tell(referee, args.json, page.as_ref());
            if order.is_some() {
                return order;
            }
        }
        let now_s = robot.now_us() as f64 * 1e-6;
        if script.last().is_some_and(|(when, _)| *when <= now_s) {
            return script.pop().map(|(_, order)| order);
        }
        match keyboard.try_recv().ok()?.parse() {
            Ok(order) => Some(order),
            Err(error) => {
                eprintln!("{error}");
                None
            }
        }
    };
    let begins = ServeOptions { seed: args.seed, standing };
    let (begin, before) = (Instant::now(), Usage::now());
    let mut looks = (&mut Clock, &mut *looks);
    let (served, pictures) = if args.camera_hz == Some(0.0) && args.lidar.is_none() {
        (serve(player, link, begins, &stop, &mut looks, orders)?, None)
    } else {
        let usual = BroadcastOptions::default();
        let rate_hz = args.camera_hz.unwrap_or(usual.rate_hz);
        let record = args.record.clone();
        let options = BroadcastOptions { rate_hz, lidar: args.lidar, seed: args.seed, record, ..usual };
        let mut broadcast = Broadcast::open(player, domain, interface, &options)?;
        let served = serve(player, link, begins, &stop, &mut (&mut broadcast, &mut looks), orders)?;
        let (report, unrecorded) = broadcast.end();
        if let Some(why) = unrecorded {
            eprintln!("the recording is not complete: {why}");
        }
        (served, Some((report, rate_hz)))
    };
    let usage = Usage::since(begin, &before);
    if args.json {
        let verdict = referee.as_ref().map(Referee::verdict);
        let end = serde_json::json!({
            "seed": args.seed,
            "goals": verdict.map(|verdict| verdict.goals()),
            "balls": verdict.map(|verdict| verdict.kicks.len()),
            "fell": verdict.map(|verdict| verdict.fell),
            "stopped": verdict.map(|verdict| verdict.stopped),
            "simulated_s": served.simulated_s,
            "lost_s": served.lost_s,
            "refused": served.refused,
            "pictures_hz": pictures.map(|(report, _)| report.rate_hz()),
            "pictures": pictures.map(|(report, _)| report.pictures),
            "lidar_packets": pictures.map(|(report, _)| report.packets),
            "usage": usage,
        });
        println!("{}", serde_json::json!({ "end": end }));
        return Ok(ExitCode::SUCCESS);
    }
    if let Some((report, rate_hz)) = pictures {
        let [sent, dropped] = report.pictures;
        println!(
            "{sent} images sent, {dropped} dropped: {:.1} per second of {rate_hz:.1} while a program read them; {} LiDAR packets",
            report.rate_hz(),
            report.packets
        );
    }
    print_end(args.seed, referee.as_ref(), &served, &usage);
    Ok(ExitCode::SUCCESS)
}

/// The end in words.
fn print_end(seed: u64, referee: Option<&Referee>, served: &Served, usage: &Usage) {
    if let Some(verdict) = referee.map(Referee::verdict) {
        println!(
            "{} goals of {} balls in real time, seed {seed}; {}, {}",
            verdict.goals(),
            verdict.kicks.len(),
            if verdict.fell { "the robot fell" } else { "no fall" },
            if verdict.stopped { "damped before the end" } else { "nothing stopped it" }
        );
    }
    print_usage(usage);
    println!("{:.1} s of simulated time; {} commands refused", served.simulated_s, served.refused);
    if served.lost_s > 0.0 {
        println!("this machine could not keep up with real time: {:.2} s lost", served.lost_s);
    }
}
