//! The eyes of a robot on the network: a thread that follows the torso, and one that looks for the ball.

use std::net::IpAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use paid_lidar::packet::{Counts, Data, UdpSource};
use paid_sight::ros::{read_camera_info, read_color, read_depth, read_odometry};
use paid_sight::{Finder, SightError};
use paid_vision::detect::Detector;

use super::link::{Desk, Joints};
use super::{
    BallEyes, CameraInput, DeviceClock, EyesConfig, OdometryInput, PictureJoiner, Sensed, StampClock,
    TorsoEyes, TorsoFix,
};
use crate::DeployError;
use crate::player::Player;
use crate::ros::{CAMERA_INFO, IMAGE, ODOMETRY, RosReader, RosTopics};
use crate::runtime::Phase;

/// Poses that may wait for the thread that looks for the ball: over a second.
const WAITING: usize = 256;
/// Lines that may wait to be told.
const UNTOLD: usize = 64;
/// Time between two reports without a picture `[ns]`.
const REPORT_NS: u64 = 20_000_000;
/// A topic is silent that has said nothing for so long `[ns]`.
const SILENT_NS: u64 = 1_000_000_000;
/// Wrong packets of the LiDAR are told so often `[ns]`.
const COUNT_NS: u64 = 5_000_000_000;

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

/// Says a line once until another one comes.
struct Teller {
    to: SyncSender<String>,
    last: String,
}

impl Teller {
    fn tell(&mut self, line: String) {
        if line != self.last {
            // Nobody listens, or too slowly: that must not stop the eyes.
            let _ = self.to.try_send(line.clone());
            self.last = line;
        }
    }
}

impl Eyes {
    /// Opens the eyes. `phase` is the runtime's. The other end gives what they have to say: a line for each fault of a sensor, and one
    /// when it is well again. A line that nobody takes is lost.
    ///
    /// # Errors
    /// If a network, an address or a detector cannot be had.
    pub fn open(
        config: &EyesConfig,
        player: &Arc<Player>,
        place: EyesPlace,
        phase: Arc<Phase>,
    ) -> Result<(Self, Receiver<String>), DeployError> {
        let mut setup = BallEyes::setup(player)?;
        setup.intrinsics = config.camera.intrinsics;
        if let Some(mount) = config.camera.mount {
            setup.torso_from_camera = mount.pose();
        }
        if let Some(path) = &config.detector {
            let detector = Detector::load(path, None).map_err(DeployError::eyes)?;
            setup.finder = Finder::Network(Box::new(detector));
        }
        if let Some(least) = config.confidence {
            setup.finder = setup.finder.with_confidence(least);
        }
        let topics = RosTopics::open(
            config.domain.unwrap_or(place.domain),
            config.interface.unwrap_or(place.interface),
        )?;
        let (desk, joints) = Desk::new(config.goal_m);
        let stop = Arc::new(AtomicBool::new(false));
        let (to_ball, fixes) = sync_channel(WAITING);
        let (tell, lines) = sync_channel(UNTOLD);
        let teller = || Teller { to: tell.clone(), last: String::new() };
        let torso = Torso::open(&config.odometry, &topics)?;
        let follow = Follow { to_ball, desk: Arc::clone(&desk), teller: teller(), state: String::new() };
        let stopped = Arc::clone(&stop);
        let mut threads = vec![std::thread::spawn(move || torso.run(follow, &stopped))];
        let look = Look {
            camera: Camera::open(&config.camera, &topics)?,
            eyes: BallEyes::new(setup)?,
            joints,
            fixes,
            motors: player.motors.clone(),
            phase,
            desk: Arc::clone(&desk),
            teller: teller(),
            _topics: topics,
        };
        let stopped = Arc::clone(&stop);
        threads.push(std::thread::spawn(move || look.run(&stopped)));
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
            // A thread that panicked has fallen silent, which the runtime has noticed.
            let _ = thread.join();
        }
    }
}

/// Local time of a stamp by the machine's clock `[ns]`.
fn of_system(stamp_ns: u64, now_ns: u64) -> u64 {
    let wall = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_nanos() as i128);
    let local = i128::from(now_ns) - (wall - i128::from(stamp_ns));
    u64::try_from(local).unwrap_or(if local < 0 { 0 } else { u64::MAX })
}

/// Where a thread that follows the torso puts what it knows.
struct Follow {
    to_ball: SyncSender<TorsoFix>,
    desk: Arc<Desk>,
    teller: Teller,
    state: String,
}

impl Follow {
    fn fix(&mut self, fix: TorsoFix) {
        self.desk.torso.put(fix);
        // A ball thread that is a second behind has lost more than this pose.
        let _ = self.to_ball.try_send(fix);
    }

    fn state(&mut self, eyes: &TorsoEyes) {
        let state = eyes.state().to_string();
        if state != self.state {
            self.teller.tell(format!("odometry: {state}"));
            self.state = state;
        }
    }
}

/// What the torso is followed by.
enum Torso {
    Lidar(Box<(UdpSource, TorsoEyes)>),
    Topic { reader: Box<RosReader>, child: String, clock: StampClock },
}

impl Torso {
    fn open(input: &OdometryInput, topics: &RosTopics) -> Result<Self, DeployError> {
        Ok(match input {
            OdometryInput::Lidar { points, imu, latency_s } => {
                let source = UdpSource::bind(*points, *imu).map_err(DeployError::eyes)?;
                Self::Lidar(Box::new((source, TorsoEyes::lidar(paid_lidar::Config::g1(), *latency_s)?)))
            }
            OdometryInput::Topic { topic, child, clock } => {
                let reader = Box::new(topics.reader(topic, ODOMETRY, false)?);
                Self::Topic { reader, child: child.clone(), clock: *clock }
            }
        })
    }

    fn run(self, mut follow: Follow, stop: &AtomicBool) {
        match self {
            Self::Lidar(parts) => {
                let (mut source, mut eyes) = *parts;
                let (mut counts, mut counted_ns) = (Counts::default(), 0);
                while !stop.load(Ordering::Acquire) {
                    let data = source.next(Duration::from_millis(5));
                    let now_ns = follow.desk.now_ns();
                    match data {
                        Ok(Some((Data::Imu(sample), _))) => {
                            if let Some(fix) = eyes.imu(sample, now_ns) {
                                follow.fix(fix);
                            }
                        }
                        Ok(Some((Data::Scan(scan), _))) => eyes.scan(scan, now_ns),
                        Ok(None) => eyes.poll(now_ns),
                        Err(error) => {
                            follow.teller.tell(format!("LiDAR: {error}"));
                            std::thread::sleep(Duration::from_millis(100));
                        }
                    }
                    follow.state(&eyes);
                    if now_ns > counted_ns + COUNT_NS {
                        counted_ns = now_ns;
                        let bad = |c: &Counts| [c.damaged, c.foreign, c.lost, c.doubled, c.wrong_time];
                        let new = source.counts();
                        if bad(&new) != bad(&counts) {
                            let [damaged, foreign, lost, doubled, late] = bad(&new);
                            follow.teller.tell(format!(
                                "LiDAR: packets so far: {} taken, {damaged} damaged, {foreign} of another device, {lost} lost, {doubled} doubled, {late} with a wrong time",
                                new.taken
                            ));
                            counts = new;
                        }
                    }
                }
            }
            Self::Topic { mut reader, child, clock } => {
                let (mut eyes, mut own, mut came_ns) = (TorsoEyes::other(), DeviceClock::default(), 0);
                while !stop.load(Ordering::Acquire) {
                    let now_ns = follow.desk.now_ns();
                    match reader.take().map(|bytes| bytes.map(|bytes| read_odometry(&bytes))) {
                        Ok(Some(Ok((stamped, found)))) if found == child => {
                            let stamp_ns = match clock {
                                StampClock::System => of_system(stamped.stamp_ns, now_ns),
                                StampClock::Own => own.local_ns(stamped.stamp_ns, now_ns),
                            };
                            let mut pose = stamped.value;
                            pose.stamp_ns = stamp_ns.min(now_ns);
                            came_ns = now_ns;
                            let age_ns = now_ns - pose.stamp_ns;
                            if age_ns > SILENT_NS {
                                follow.teller.tell(format!(
                                    "odometry: expected a pose at most 1 s old, found one of {:.1} s: a clock that is not this machine's? (clock = \"own\")",
                                    age_ns as f64 * 1e-9
                                ));
                                continue;
                            }
                            let fix = eyes.pose(pose);
                            follow.fix(fix);
                            follow.state(&eyes);
                        }
                        Ok(Some(Ok((_, found)))) => {
                            follow
                                .teller
                                .tell(format!("odometry: expected the child frame {child}, found '{found}'"));
                        }
                        Ok(Some(Err(error))) => follow.teller.tell(error.to_string()),
                        Ok(None) => {
                            if now_ns > came_ns + SILENT_NS {
                                follow.teller.tell("odometry: no pose for a second".to_owned());
                                follow.state.clear();
                            }
                            std::thread::sleep(Duration::from_millis(1));
                        }
                        Err(error) => {
                            follow.teller.tell(format!("odometry: {error}"));
                            std::thread::sleep(Duration::from_millis(10));
                        }
                    }
                }
            }
        }
    }
}

/// A camera's topics.
struct Camera {
    info: RosReader,
    depth: RosReader,
    color: RosReader,
    joiner: PictureJoiner,
    clock: StampClock,
    latency_ns: u64,
    own: DeviceClock,
}

impl Camera {
    fn open(input: &CameraInput, topics: &RosTopics) -> Result<Self, DeployError> {
        Ok(Self {
            info: topics.reader(&input.info, CAMERA_INFO, input.reliable)?,
            depth: topics.reader(&input.depth, IMAGE, input.reliable)?,
            color: topics.reader(&input.color, IMAGE, input.reliable)?,
            joiner: PictureJoiner::new(&input.frame),
            clock: input.clock,
            latency_ns: (input.latency_s * 1e9) as u64,
            own: DeviceClock::default(),
        })
    }

    /// Everything that has come.
    fn read(&mut self, desk: &Desk) -> Result<(), String> {
        let words = |error: SightError| error.to_string();
        let mut first = Ok(());
        let mut note = |result: Result<(), String>| {
            if first.is_ok() {
                first = result;
            }
        };
        while let Some(bytes) = self.info.take().map_err(|e| e.to_string())? {
            note(read_camera_info(&bytes).map_err(words).and_then(|info| self.joiner.info(&info)));
        }
        while let Some(bytes) = self.depth.take().map_err(|e| e.to_string())? {
            note(read_depth(&bytes).map_err(words).and_then(|depth| self.joiner.depth(depth)));
        }
        while let Some(bytes) = self.color.take().map_err(|e| e.to_string())? {
            let now_ns = desk.now_ns();
            note(read_color(&bytes).map_err(words).and_then(|color| self.joiner.color(color, now_ns)));
        }
        first
    }

    /// Local time of a picture's stamp.
    fn captured_ns(&mut self, stamp_ns: u64, now_ns: u64) -> u64 {
        match self.clock {
            StampClock::System => of_system(stamp_ns, now_ns),
            StampClock::Own => self.own.local_ns(stamp_ns, now_ns).saturating_sub(self.latency_ns),
        }
    }
}

/// The thread that looks for the ball.
struct Look {
    camera: Camera,
    eyes: BallEyes,
    joints: Receiver<Joints>,
    fixes: Receiver<TorsoFix>,
    motors: Vec<usize>,
    phase: Arc<Phase>,
    desk: Arc<Desk>,
    teller: Teller,
    _topics: RosTopics,
}

impl Look {
    fn run(mut self, stop: &AtomicBool) {
        let (mut reported_ns, mut looked_ns) = (0, 0);
        while !stop.load(Ordering::Acquire) {
            match self.fixes.recv_timeout(Duration::from_millis(2)) {
                Ok(fix) => {
                    self.torso(&fix);
                    while let Ok(fix) = self.fixes.try_recv() {
                        self.torso(&fix);
                    }
                }
                Err(RecvTimeoutError::Timeout) => {}
                // The thread that follows the torso has ended: without it there is nothing to believe.
                Err(RecvTimeoutError::Disconnected) => return,
            }
            while let Ok(joints) = self.joints.try_recv() {
                let angles = self.motors.iter().map(|&m| f64::from(joints.angles[m])).collect();
                if let Err(error) = self.eyes.joints(joints.at_ns, angles) {
                    self.teller.tell(error.to_string());
                }
            }
            if let Err(line) = self.camera.read(&self.desk) {
                self.teller.tell(format!("camera: {line}"));
            }
            let now_ns = self.desk.now_ns();
            let looked = self.look(now_ns);
            if looked {
                looked_ns = now_ns;
            } else if now_ns > looked_ns + SILENT_NS {
                self.teller.tell("camera: no picture for a second".to_owned());
                looked_ns = now_ns;
            }
            if looked || now_ns > reported_ns + REPORT_NS {
                reported_ns = now_ns;
                let held_ns = self.desk.now_ns();
                match self.eyes.report(held_ns, &self.phase) {
                    Ok(report) => {
                        self.desk.report.put((held_ns, report));
                    }
                    Err(error) => self.teller.tell(error.to_string()),
                }
            }
        }
    }

    fn torso(&mut self, fix: &TorsoFix) {
        if let Err(error) = self.eyes.torso(fix) {
            self.teller.tell(error.to_string());
        }
    }

    /// Looks at the newest picture, if there is one.
    fn look(&mut self, now_ns: u64) -> bool {
        let Some(mut picture) = self.camera.joiner.take(now_ns) else { return false };
        picture.captured_ns = self.camera.captured_ns(picture.captured_ns, now_ns);
        match self.eyes.picture(picture, now_ns, &self.phase) {
            Ok(None) => self.teller.tell("camera: pictures are well".to_owned()),
            Ok(Some(fault)) => self.teller.tell(format!("camera: {fault}")),
            Err(error) => self.teller.tell(error.to_string()),
        }
        true
    }
}
