//! The virtual robot on a real clock, behind any link, with orders from outside.

use std::str::FromStr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use paid_runtime::wire::{DAMPING_KEYS, Key, Remote};
use paid_runtime::{Link, Packet, Player, Status};

use crate::TwinError;
use crate::faults::Fault;
use crate::robot::{Mount, VirtualG1};
use crate::senses::Senses;

/// Keys stay down for this long `[us]`.
const PRESSED_US: u64 = 100_000;
/// A robot this far behind the clock gives the lost time up `[s]`.
const BEHIND_S: f64 = 0.05;
/// Least time between two reports that it is behind.
const SAID_EVERY: Duration = Duration::from_secs(1);

/// What the operator of the virtual robot wants. As text: `keys L2+Up`, `ball 1.2 0.1`, `ball 1.2 0.1 -0.2 0`, `goal 5 0`, `free`, `gantry`,
/// `battery 15`, `fault silence`, `fault none`, `quit`.
#[derive(Clone, Debug, PartialEq)]
pub enum Order {
    /// Presses keys of the remote.
    Keys(Vec<Key>),
    /// Places the ball ahead of the torso and to its left `[m]`, with a velocity in the same axes `[m/s]`.
    Ball([f64; 2], [f64; 2]),
    /// Places the goal in the same way.
    Goal([f64; 2]),
    /// Lets the robot go.
    Free,
    /// Takes it by the gantry.
    Gantry,
    /// Charges the battery to this many percent.
    Battery(f64),
    /// Injects a fault, or ends it.
    Fault(Option<Fault>),
    /// Ends.
    Quit,
}

impl FromStr for Fault {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let name = |fault: &Self| format!("{fault:?}");
        Self::ALL.into_iter().find(|fault| text.eq_ignore_ascii_case(&name(fault))).ok_or_else(|| {
            let names: Vec<String> = Self::ALL.iter().map(name).collect();
            format!("a fault: expected one of {}, found '{text}'", names.join(", "))
        })
    }
}

impl FromStr for Order {
    type Err = String;
    fn from_str(line: &str) -> Result<Self, String> {
        let words: Vec<&str> = line.split_whitespace().collect();
        let number = |word: &str| {
            word.parse::<f64>()
                .ok()
                .filter(|x| x.abs() <= 100.0)
                .ok_or_else(|| format!("expected a number within 100, found '{word}'"))
        };
        match words[..] {
            ["keys", keys] => Ok(Self::Keys(keys.split('+').map(str::parse).collect::<Result<_, _>>()?)),
            ["ball", x, y] => Ok(Self::Ball([number(x)?, number(y)?], [0.0; 2])),
            ["ball", x, y, vx, vy] => Ok(Self::Ball([number(x)?, number(y)?], [number(vx)?, number(vy)?])),
            ["goal", x, y] => Ok(Self::Goal([number(x)?, number(y)?])),
            ["free"] => Ok(Self::Free),
            ["gantry"] => Ok(Self::Gantry),
            ["battery", percent] => {
                let charge = number(percent)?;
                if charge < 0.0 {
                    return Err(format!("battery: expected 0 to 100 percent, found '{percent}'"));
                }
                Ok(Self::Battery(charge))
            }
            ["fault", "none"] => Ok(Self::Fault(None)),
            ["fault", name] => Ok(Self::Fault(Some(of_a_robot(name.parse()?)?))),
            ["quit"] => Ok(Self::Quit),
            _ => Err(format!(
                "expected keys, ball, goal, free, gantry, battery, fault or quit, found '{line}'"
            )),
        }
    }
}

/// A fault that a robot on the network can have.
fn of_a_robot(fault: Fault) -> Result<Fault, String> {
    if fault.is_beside_the_robot() {
        let name = format!("{fault:?}").to_lowercase();
        return Err(format!(
            "fault {name}: expected a fault of the robot; this one happens to the computer that commands it, and `paid robot drill --fault {name}` has it"
        ));
    }
    Ok(fault)
}

/// How a served robot did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Served {
    /// Simulated time `[s]`.
    pub simulated_s: f64,
    /// Time that the machine could not keep up `[s]`.
    pub lost_s: f64,
    /// Commands with a wrong length or checksum.
    pub refused: u64,
}

/// Sees a virtual robot at every step: its camera and its LiDAR, or who looks on.
pub trait Watcher {
    /// 2 ms are over.
    fn step(&mut self, robot: &VirtualG1);
    /// The goal was placed: center (x, y) in the world `[m]`, facing along this heading `[rad]`.
    fn goal(&mut self, center: [f64; 2], heading: f64);
    /// The runtime's status, 50 times a second; only in lockstep, where it runs in the same program.
    fn status(&mut self, _status: &Status) {}
    /// The machine cannot keep real time: total time lost `[s]`. Reported once a second at most.
    fn behind(&mut self, _lost_s: f64) {}
    /// True to press the remote's keys for damping.
    fn stops(&mut self) -> bool {
        false
    }
}

/// None.
impl Watcher for () {
    fn step(&mut self, _robot: &VirtualG1) {}
    fn goal(&mut self, _center: [f64; 2], _heading: f64) {}
}

/// Two of them.
impl<A: Watcher + ?Sized, B: Watcher + ?Sized> Watcher for (&mut A, &mut B) {
    fn step(&mut self, robot: &VirtualG1) {
        self.0.step(robot);
        self.1.step(robot);
    }
    fn goal(&mut self, center: [f64; 2], heading: f64) {
        self.0.goal(center, heading);
        self.1.goal(center, heading);
    }
    fn status(&mut self, status: &Status) {
        self.0.status(status);
        self.1.status(status);
    }
    fn behind(&mut self, lost_s: f64) {
        self.0.behind(lost_s);
        self.1.behind(lost_s);
    }
    fn stops(&mut self) -> bool {
        // Both are asked.
        self.0.stops() | self.1.stops()
    }
}

/// What a served robot begins with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ServeOptions {
    /// Seed of the senses' errors.
    pub seed: u64,
    /// True: hands hold it until its joints do, instead of a gantry that holds it until the order `free`.
    pub standing: bool,
}

/// Serves a virtual robot until `stop` is set or the order `quit` comes. `orders` is asked every 2 ms, and may look at the robot.
///
/// # Errors
/// If MuJoCo is missing, the link fails, or a fault is ordered that is none of the robot's.
pub fn serve(
    player: &Arc<Player>,
    mut link: impl Link,
    options: ServeOptions,
    stop: &AtomicBool,
    watcher: &mut dyn Watcher,
    mut orders: impl FnMut(&VirtualG1) -> Option<Order>,
) -> Result<Served, TwinError> {
    let mut robot = VirtualG1::new(Arc::clone(player))?;
    if options.standing {
        robot.set_mount(Mount::Hands);
    }
    let mut senses = Senses::simulated(&player.play.eyes, player.play.ball_params.radius_m, options.seed);
    let (mut begin, mut released_us, mut lost, mut said) = (Instant::now(), None, 0.0, None);
    while !stop.load(Ordering::Relaxed) {
        let clock = Duration::from_micros(robot.now_us());
        match clock.checked_sub(begin.elapsed()) {
            Some(early) => std::thread::sleep(early),
            None => {
                let behind = begin.elapsed().saturating_sub(clock).as_secs_f64();
                if behind > BEHIND_S {
                    lost += behind;
                    if said.is_none_or(|at: Instant| at.elapsed() >= SAID_EVERY) {
                        said = Some(Instant::now());
                        watcher.behind(lost);
                    }
                    begin += Duration::from_secs_f64(behind);
                }
            }
        }
        robot.receive(&mut link)?;
        robot.step();
        robot.publish(&mut link)?;
        watcher.step(&robot);
        if watcher.stops() {
            robot.set_remote(Remote::pressing(&DAMPING_KEYS));
            released_us = Some(robot.now_us() + PRESSED_US);
        }
        let truth = robot.true_state();
        let mut sent = Ok(());
        senses.step(robot.now_us(), &truth, |packet| sent = sent.clone().and(link.send(packet)));
        sent?;
        if released_us.is_some_and(|at| robot.now_us() >= at) {
            robot.set_remote(Remote::pressing(&[]));
            released_us = None;
        }
        let Some(order) = orders(&robot) else { continue };
        let (s, c) = truth.torso.rot.yaw().sin_cos();
        let turned = |[a, l]: [f64; 2]| [c * a - s * l, s * a + c * l];
        let placed = |at: [f64; 2]| {
            let [dx, dy] = turned(at);
            [truth.torso.pos.x() + dx, truth.torso.pos.y() + dy]
        };
        match order {
            Order::Keys(keys) => {
                robot.set_remote(Remote::pressing(&keys));
                released_us = Some(robot.now_us() + PRESSED_US);
            }
            Order::Ball(at, velocity) => robot.place_ball(placed(at), turned(velocity)),
            Order::Goal(at) => {
                // For a runtime with virtual senses, and for one with eyes of its own.
                link.send(Packet::Goal(senses.placed(placed(at), &truth)))?;
                link.send(Packet::GoalAhead(at))?;
                watcher.goal(placed(at), truth.torso.rot.yaw());
            }
            Order::Free => robot.set_mount(Mount::Free),
            Order::Gantry => robot.set_mount(Mount::Gantry { pitch_rad_s: 0.0 }),
            Order::Battery(percent) => robot.set_battery(percent),
            Order::Fault(fault) => {
                if let Some(fault) = fault {
                    of_a_robot(fault).map_err(TwinError::Simulation)?;
                }
                robot.set_fault(fault);
                senses.odometry = fault != Some(Fault::NoOdometry);
                senses.ball_visible = fault != Some(Fault::NoBall);
            }
            Order::Quit => break,
        }
    }
    Ok(Served { simulated_s: robot.now_us() as f64 * 1e-6, lost_s: lost, refused: robot.refused() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_are_read_and_others_are_refused_with_what_was_expected() {
        assert_eq!("keys L2+up".parse(), Ok(Order::Keys(vec![Key::L2, Key::Up])));
        assert_eq!("ball 1.2 -0.1".parse(), Ok(Order::Ball([1.2, -0.1], [0.0; 2])));
        assert_eq!("battery 15".parse(), Ok(Order::Battery(15.0)));
        assert_eq!("fault silence".parse(), Ok(Order::Fault(Some(Fault::Silence))));
        for (line, expected) in [
            ("ball 1.2 x", "'x'"),
            ("fault fire", "Silence"),
            ("fault kill", "drill --fault kill"),
            ("fault OthersCommand", "expected a fault of the robot"),
            ("keys L3", "'L3'"),
            ("battery -1", "'-1'"),
            ("jump", "'jump'"),
        ] {
            let error = line.parse::<Order>().expect_err(line);
            assert!(error.contains(expected), "{error}");
        }
    }
}
