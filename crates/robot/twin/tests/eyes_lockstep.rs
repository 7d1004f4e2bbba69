//! Onboard perception in lockstep: rendered images and a simulated LiDAR, and nothing else.

use crate::common::player;
use paid_runtime::{Limits, State};
use paid_twin::{Fault, Lockstep, LockstepOptions, OwnEyesOptions, TorsoSource};
use paid_world::{Message, Recorded, Recording};

#[test]
fn a_ball_that_the_robot_has_seen_by_itself_is_kicked_and_lost_odometry_is_noticed() {
    if !crate::common::mujoco(
        "a_ball_that_the_robot_has_seen_by_itself_is_kicked_and_lost_odometry_is_noticed",
    ) {
        return;
    }
    let limits = Limits { stand_up_s: 0.3, listen_s: 0.0, ..Limits::default() };
    let options = LockstepOptions {
        limits,
        seed: 1,
        eyes: Some(OwnEyesOptions::default()),
        ..LockstepOptions::default()
    };
    let mut step = Lockstep::new(&player(), &options).expect("MuJoCo");
    step.make_ready(false).expect("ready");
    step.robot.place_ball([1.2, 0.0], [0.0; 2]);
    let kicks = step.run_until(4.0, |s| s.runtime().state() == State::Kick).expect("run");
    assert!(kicks, "waits for {}", step.runtime().waiting());
    assert!(step.ball_error_m() < 0.05, "{} m", step.ball_error_m());
    // Twenty images at 25 Hz were looked at before.
    assert!(step.robot.now_us() > 1_500_000);
    // Images are 70 ms old when they come; a policy step and a state are the least that is added.
    step.run_until(0.3, |_| false).expect("run");
    let latency = step.runtime().latency().figures().expect("images moved joints");
    assert!(latency.within_ms[0] >= 70.0 && latency.within_ms[6] < 130.0, "{latency:?}");
    step.inject(Fault::NoOdometry);
    let noticed =
        |s: &Lockstep| s.events().iter().any(|e| e.reason.starts_with("finishes without looking: odom"));
    assert!(step.run_until(0.5, noticed).expect("run"), "{:?}", step.events().last());
}

#[test]
fn without_odometry_no_kick_is_allowed_and_no_ball_has_a_place() {
    if !crate::common::mujoco("without_odometry_no_kick_is_allowed_and_no_ball_has_a_place") {
        return;
    }
    let limits = Limits { stand_up_s: 0.3, listen_s: 0.0, ..Limits::default() };
    let options = LockstepOptions {
        limits,
        seed: 1,
        eyes: Some(OwnEyesOptions::default()),
        ..LockstepOptions::default()
    };
    let mut step = Lockstep::new(&player(), &options).expect("MuJoCo");
    step.inject(Fault::NoOdometry);
    let refused = step.make_ready(false);
    let told: String = step.events().iter().map(|event| event.reason.clone()).collect();
    assert!(refused.is_ok() && told.contains("refused to kick: no odometry"), "{told}");
    // Images come, but none gets a place.
    assert!(step.runtime().ball().is_none());
}

#[test]
fn pictures_and_beliefs_of_a_lockstep_are_recorded() {
    if !crate::common::mujoco("pictures_and_beliefs_of_a_lockstep_are_recorded") {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("seen.mcap");
    let eyes = OwnEyesOptions {
        torso: TorsoSource::Modeled,
        record: Some(file.clone()),
        ..OwnEyesOptions::default()
    };
    let mut step =
        Lockstep::new(&player(), &LockstepOptions { eyes: Some(eyes), ..LockstepOptions::default() })
            .expect("MuJoCo");
    step.robot.place_ball([1.2, 0.0], [0.0; 2]);
    step.run_until(1.0, |_| false).expect("run");
    drop(step);
    let (mut pictures, mut beliefs, mut poses) = (0, 0, 0);
    let recording = Recording::open(&file).expect("a file");
    recording
        .read(|recorded| {
            match recorded {
                Recorded::Message(arrived) => match arrived.message {
                    Message::Picture(picture) => {
                        assert_eq!((picture.color.width, picture.color.height), (424, 240));
                        assert!(picture.depth.is_some(), "its depth");
                        assert_eq!(arrived.at_ns - picture.captured_ns, 70_000_000);
                        pictures += 1;
                    }
                    Message::Pose(_) => poses += 1,
                    _ => {}
                },
                Recorded::Believed { .. } => beliefs += 1,
            }
            Ok(())
        })
        .expect("a whole recording");
    // 25 a second, and the last two are still on their way.
    assert_eq!(pictures, 24);
    assert!(poses >= 40 && beliefs >= 50, "{poses} poses, {beliefs} beliefs");
    assert!(recording.setup(None).is_ok(), "the setup of the eyes");
}
