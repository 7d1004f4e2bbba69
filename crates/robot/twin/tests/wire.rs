//! The release of the vendor's controller over DDS on the loopback.

use std::net::{IpAddr, Ipv4Addr};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use crate::common::player;
use paid_runtime::switcher::{Patience, SwitcherClient, SwitcherService, await_release};
use paid_runtime::wire::LowCmd;
use paid_runtime::{DdsLink, Inlet, Packet, Side};
use paid_twin::VendorLink;

const LOOPBACK: IpAddr = IpAddr::V4(Ipv4Addr::LOCALHOST);
/// Programs on a loopback without multicast find each other after some seconds; a busy machine takes longer.
const PATIENCE: Duration = Duration::from_secs(90);
const PAUSE: Duration = Duration::from_millis(5);

/// A domain that no other test has. Ports of domains from 101 on are among those that the system hands to others.
fn domain() -> u16 {
    20 + (std::process::id() % 80) as u16
}

#[test]
fn the_vendors_controller_is_found_in_command_and_released_over_the_wire() {
    let player = player();
    let robot = DdsLink::open(domain(), LOOPBACK, Side::Robot).expect("the loopback");
    let line = robot.switcher().expect("topics");
    let mut robot = VendorLink::new(robot, line, SwitcherService::new("ai"), &player);
    let runtime = DdsLink::open(domain(), LOOPBACK, Side::Runtime).expect("the loopback");
    let mut client = SwitcherClient::new(runtime.switcher().expect("topics"));
    let patience = Patience { answer: PATIENCE, release: PATIENCE, every: Duration::from_millis(100) };
    let stop = AtomicBool::new(false);
    let (kept, told) = std::thread::scope(|scope| {
        let robot = scope.spawn(|| {
            // What holds the robot: the vendor's command as long as it is in command, then once the one that lets go.
            let mut held = None;
            loop {
                // A release that comes within a round is seen in the next one: once asked to stop, one whole round is left.
                let last = stop.load(Ordering::Relaxed);
                while let Ok(Some(packet)) = robot.receive() {
                    if let Packet::LowCmd(bytes) = packet {
                        held = LowCmd::from_cdr(&bytes).ok().map(|command| command.motors[0].mode);
                    }
                }
                if last {
                    return held;
                }
                std::thread::sleep(PAUSE);
            }
        });
        let on = AtomicBool::new(false);
        let refused = await_release(&mut client, false, patience, &on, |_| {});
        let mut told = Vec::new();
        let released = await_release(&mut client, true, patience, &on, |line| told.push(line.to_owned()));
        stop.store(true, Ordering::Relaxed);
        released.expect("released");
        let error = refused.expect_err("in command").to_string();
        assert!(error.starts_with("refused to start: the vendor's controller 'ai' is in command"), "{error}");
        (robot.join().expect("robot"), told)
    });
    assert_eq!(told, ["releasing the vendor's controller 'ai'", "the vendor's controller is released"]);
    assert_eq!(kept, Some(0), "the motors are off");
}
