//! The eyes of a robot on the network: a thread that follows the torso, and one that looks for the ball.

mod camera;
mod follow;
mod look;
mod teller;

use std::net::IpAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread::JoinHandle;
use std::time::{SystemTime, UNIX_EPOCH};

use paid_vision::detect::Detector;
use paid_world::{Finder, SightSetup};

use super::{BallEyes, Desk, EyesConfig, Sensed};
use crate::DeployError;
use crate::live::LastWords;
use crate::player::Player;
use crate::ros::RosTopics;
use crate::runtime::Phase;
use camera::Camera;
use follow::{Follow, Torso};
use look::Look;
use teller::Teller;

/// Poses that may wait for the thread that looks for the ball: over a second.
const WAITING: usize = 256;
/// Lines that may queue.
const UNTOLD: usize = 64;
/// A topic without a message for this long is silent `[ns]`.
const SILENT_NS: u64 = 1_000_000_000;

/// Where the topics of ROS 2 are, unless the configuration says otherwise.
#[derive(Clone, Copy, Debug)]
pub struct EyesPlace {
    /// DDS domain.
    pub domain: u16,
    /// Address of this machine's interface.
    pub interface: IpAddr,
}

/// The eyes. They end when this is dropped.
pub struct Eyes {
    desk: Arc<Desk>,
    stop: Arc<AtomicBool>,
    threads: Vec<JoinHandle<()>>,
}

impl Eyes {
    /// Looks whether eyes can be opened, as far as that can be known before there is a robot. Joins no network.
    ///
    /// # Errors
    /// As [`Eyes::open`].
    pub fn check(config: &EyesConfig, player: &Player, place: EyesPlace) -> Result<(), DeployError> {
        BallEyes::new(setup(config, player)?)?;
        crate::interface::check(config.interface.unwrap_or(place.interface))?;
        Torso::check(&config.odometry)
    }

    /// Starts onboard perception. `phase` is the runtime's. The receiver gives its messages: a line for each fault of a sensor, and one
    /// when it works again. A line that is not taken is lost. A thread that panics leaves its message in `last_words`.
    ///
    /// # Errors
    /// If a network, an address or a detector cannot be had.
    pub fn open(
        config: &EyesConfig,
        player: &Arc<Player>,
        place: EyesPlace,
        phase: Arc<Phase>,
        last_words: &LastWords,
    ) -> Result<(Self, Receiver<String>), DeployError> {
        let setup = setup(config, player)?;
        let topics = RosTopics::open(
            config.domain.unwrap_or(place.domain),
            config.interface.unwrap_or(place.interface),
        )?;
        let (desk, joints) = Desk::new(config.goal_m, config.goal_from_senses);
        let stop = Arc::new(AtomicBool::new(false));
        let (to_ball, fixes) = sync_channel(WAITING);
        let (tell, lines) = sync_channel(UNTOLD);
        let teller = || Teller::new(tell.clone());
        if let (Some(_), Finder::Network(detector)) = (&config.detector, &setup.finder) {
            teller().tell(detector.taken_for());
        }
        let torso = Torso::open(&config.odometry, &topics)?;
        let follow = Follow::new(to_ball, Arc::clone(&desk), teller());
        let stopped = Arc::clone(&stop);
        let mut threads = vec![spawn(last_words, "eyes' torso", move || torso.run(follow, &stopped))];
        let look = Look {
            camera: Camera::open(&config.camera, topics)?,
            eyes: BallEyes::new(setup)?,
            joints,
            fixes,
            motors: player.motors.clone(),
            phase,
            desk: Arc::clone(&desk),
            teller: teller(),
        };
        let stopped = Arc::clone(&stop);
        threads.push(spawn(last_words, "eyes' ball", move || look.run(&stopped)));
        Ok((Self { desk, stop, threads }, lines))
    }

    /// What to give the link to the robot.
    pub fn sensed(&self) -> Sensed {
        Sensed::Eyes(Arc::clone(&self.desk))
    }
}

impl Drop for Eyes {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Release);
        for thread in self.threads.drain(..) {
            // The panic of one that panicked was reported.
            let _ = thread.join();
        }
    }
}

/// What looks for the ball, as the configuration says.
fn setup(config: &EyesConfig, player: &Player) -> Result<SightSetup, DeployError> {
    let mut setup = BallEyes::setup(player)?;
    setup.intrinsics = config.camera.intrinsics;
    if let Some(mount) = config.camera.mount {
        setup.torso_from_camera = mount.pose();
    }
    if let Some(path) = &config.detector {
        let detector = Detector::load(path, config.class).map_err(DeployError::eyes)?;
        setup.finder = Finder::Network(Box::new(detector));
    }
    if let Some(least) = config.confidence {
        setup.finder = setup.finder.with_confidence(least);
    }
    Ok(setup)
}

/// A thread whose panic is reported.
fn spawn(last_words: &LastWords, name: &'static str, act: impl FnOnce() + Send + 'static) -> JoinHandle<()> {
    let words = last_words.clone();
    std::thread::spawn(move || {
        words.guard(name, act);
    })
}

/// Local time of a stamp by the machine's clock `[ns]`.
fn of_system(stamp_ns: u64, now_ns: u64) -> u64 {
    let wall = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_nanos() as i128);
    let local = i128::from(now_ns) - (wall - i128::from(stamp_ns));
    u64::try_from(local).unwrap_or(if local < 0 { 0 } else { u64::MAX })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_of_the_eyes_is_heard_under_its_name() {
        let words = LastWords::default();
        spawn(&words, "eyes' torso", || panic!("no ground")).join().expect("caught");
        assert_eq!(words.heard().as_deref(), Some("the eyes' torso thread has panicked: no ground"));
    }
}
