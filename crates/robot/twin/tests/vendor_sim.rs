//! The conventions of the vendor's own simulator over DDS: states without a checksum, no remote, no motion switcher.
//!
//! It usually sits on domain 1; here the domain is one that no other test has.

use std::net::{IpAddr, Ipv4Addr};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use crate::common::player;
use paid_runtime::wire::{Key, LowCmd};
use paid_runtime::{
    DdsLink, Inlet, LastWords, Limits, Live, LiveReport, Outlet, Packet, Runtime, Side, State, Told,
    TypedKeys, Writer, run_live,
};
use paid_twin::VirtualG1;

const LOOPBACK: IpAddr = IpAddr::V4(Ipv4Addr::LOCALHOST);
/// Programs on a loopback without multicast find each other after some seconds; a busy machine takes longer.
const PATIENCE: Duration = Duration::from_secs(90);

/// A robot of the vendor's simulator stands, L2 and Up are typed; how the runtime did, and whether its commands held the joints.
fn stands(domain: u16, check_crc: bool) -> (LiveReport, bool) {
    let player = player();
    // The machine may be busy: its clock stops nothing here.
    let limits = Limits {
        check_crc,
        remote_required: false,
        listen_s: 0.0,
        stand_up_s: 0.3,
        state_gap_s: 0.1,
        command_age_s: 0.1,
        writer_age_s: 0.5,
        late_s: 0.1,
        late_steps: 10,
        ..Limits::default()
    };
    let mut robot = VirtualG1::new(Arc::clone(&player)).expect("MuJoCo");
    let mut to = DdsLink::open(domain, LOOPBACK, Side::Robot).expect("DDS");
    let from = DdsLink::open(domain, LOOPBACK, Side::Runtime).expect("DDS");
    let keys = Arc::<TypedKeys>::default();
    let live = Live {
        writer: Writer::new(&limits, player.joints()),
        runtime: Runtime::new(Arc::clone(&player), limits),
        dry_run: false,
        log: None,
        switcher: None,
        keys: Some(Arc::clone(&keys)),
        last_words: LastWords::default(),
        duration: Some(PATIENCE),
    };
    let (stop, refused) = (AtomicBool::new(false), AtomicBool::new(false));
    let told = |told: Told<'_>| {
        if matches!(told, Told::Event(event) if event.reason.contains("checksum")) {
            refused.store(true, Ordering::Relaxed);
        }
    };
    let mut held = false;
    let report = std::thread::scope(|scope| {
        let runtime = scope.spawn(|| run_live(live, from, &stop, told));
        let begin = Instant::now();
        while !runtime.is_finished() {
            std::thread::sleep(Duration::from_millis(2));
            robot.step();
            let mut state = robot.low_state();
            state.crc = 0;
            state.wireless_remote = [0; 40];
            to.send(Packet::LowState(state.to_cdr())).expect("sent");
            while let Some(packet) = to.receive().expect("open") {
                let Packet::LowCmd(bytes) = packet else { continue };
                let command = LowCmd::from_cdr(&bytes).expect("a command");
                assert_eq!(
                    command.crc,
                    command.expected_crc(),
                    "the vendor's simulator does not look; a robot does"
                );
                held |= command.motors[..29].iter().all(|motor| motor.kp > 0.0);
            }
            // A runtime that has no state of the robot refuses, so the keys are pressed again and again.
            if begin.elapsed() > Duration::from_secs(1) {
                keys.press(1 << Key::L2 as u16 | 1 << Key::Up as u16);
            }
            if held || refused.load(Ordering::Relaxed) {
                stop.store(true, Ordering::Relaxed);
            }
        }
        runtime.join().expect("no panic")
    });
    (report.expect("the link is well"), held)
}

#[test]
fn the_vendors_simulator_is_heard_only_where_the_limits_forgive_its_checksums() {
    if !crate::common::mujoco("the_vendors_simulator_is_heard_only_where_the_limits_forgive_its_checksums") {
        return;
    }
    let domain = 20 + ((3 * std::process::id() + 1) % 80) as u16;
    let (report, held) = stands(domain, false);
    let told: Vec<&str> = report.events.iter().map(|event| event.reason.as_str()).collect();
    assert!(held && report.events.iter().any(|event| event.to == State::StandUp), "{told:?}");
    let (report, held) = stands(domain + 1, true);
    let told: Vec<&str> = report.events.iter().map(|event| event.reason.as_str()).collect();
    assert!(!held && told.iter().any(|why| why.contains("checksum")), "{told:?}");
}
