//! A virtual robot that begins standing, held by hands until its joints hold it.

use std::sync::Arc;

use crate::common::player;
use paid_runtime::switcher::{Line, SwitcherService};
use paid_runtime::{ChannelLink, LinkError, State};
use paid_twin::{Lockstep, LockstepOptions, Mount, VendorLink, VirtualG1};

/// The motion switcher is not asked.
struct Quiet;

impl Line for Quiet {
    fn send(&mut self, _bytes: Vec<u8>) -> Result<(), LinkError> {
        Ok(())
    }
    fn receive(&mut self) -> Result<Option<Vec<u8>>, LinkError> {
        Ok(None)
    }
}

#[test]
fn hands_hold_a_robot_until_the_runtime_does_and_then_it_stands_alone() {
    if !crate::common::mujoco("hands_hold_a_robot_until_the_runtime_does_and_then_it_stands_alone") {
        return;
    }
    let player = player();
    let mut step = Lockstep::new(&player, &LockstepOptions::default()).expect("MuJoCo");
    step.robot.set_mount(Mount::Hands);
    // Damping holds nothing: hands stay.
    step.run_until(3.0, |_| false).expect("run");
    assert_eq!((step.robot.mount(), step.runtime().state()), (Mount::Hands, State::Passive));
    step.make_ready(false).expect("ready");
    assert_eq!(step.robot.mount(), Mount::Free);
    step.run_until(5.0, |_| false).expect("run");
    assert_eq!(step.runtime().state(), State::Ready, "{:?}", step.runtime().why());
    assert!(step.truth().base.pos.z() > 0.7, "{} m", step.truth().base.pos.z());
}

#[test]
fn hands_let_go_of_a_robot_that_the_vendors_controller_holds_and_of_no_other() {
    if !crate::common::mujoco("hands_let_go_of_a_robot_that_the_vendors_controller_holds_and_of_no_other") {
        return;
    }
    let player = player();
    let stand = |master: &str| {
        let (robot_end, _runtime) = ChannelLink::pair();
        let mut link = VendorLink::new(robot_end, Box::new(Quiet), SwitcherService::new(master), &player);
        let mut robot = VirtualG1::new(Arc::clone(&player)).expect("MuJoCo");
        robot.set_mount(Mount::Hands);
        for _ in 0..1500 {
            robot.receive(&mut link).expect("open");
            robot.step();
        }
        (robot.mount(), robot.truth().bodies[0].pos.z())
    };
    let (mount, height) = stand("ai");
    assert!(mount == Mount::Free && height > 0.7, "{mount:?}, {height} m");
    assert_eq!(stand("").0, Mount::Hands, "nothing holds it but hands");
}
