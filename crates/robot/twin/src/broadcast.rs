//! The virtual robot's camera and LiDAR on the network, alongside its states: topics of ROS 2, and packets of a Mid-360.
//!
//! Images are rendered in a thread of their own, and only while they are read. One that comes while the last is still being rendered
//! is dropped: the robot's 500 Hz do not wait.

use std::net::{IpAddr, SocketAddr, UdpSocket};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::sync::{Arc, OnceLock};
use std::thread::JoinHandle;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use paid_lidar::sim::SceneKind;
use paid_runtime::Player;
use paid_runtime::eyes::{BallEyes, CameraInput};
use paid_runtime::ros::{CAMERA_INFO, IMAGE, RosTopics, RosWriter};
use paid_track::Pose;
use paid_vision::Intrinsics;
use paid_world::ros::{write_camera_info, write_color, write_depth};
use paid_world::{Arrived, Message, PictureMessage, Recorder, SightSetup};

use crate::TwinError;
use crate::camera::{Moment, SimCamera};
use crate::lidar::SimLidar;
use crate::robot::VirtualG1;
use crate::serve::Watcher;

/// Poses that may wait for the LiDAR: over a second.
const POSES: usize = 1024;
/// The LiDAR sends what it has measured once in this many poses: every 10 ms.
const POSES_A_BURST: usize = 5;
/// A robot this far behind the clock gives the lost time up `[s]`, as in [`crate::serve`].
const BEHIND_S: f64 = 0.05;
/// Port of inertial samples less that of points, as the device has them.
const IMU_PORT: u16 = 100;

/// What to send, and where.
#[derive(Clone, Debug)]
pub struct BroadcastOptions {
    /// Images a second; 0: none. Default 15: rendering one takes 10 to 20 ms of a core, and two cores also run the simulation and the
    /// runtime.
    pub rate_hz: f64,
    /// The image's size. Default 424 x 240.
    pub intrinsics: Intrinsics,
    /// Names of the topics.
    pub topics: CameraInput,
    /// Where the LiDAR's points go; its samples go to the port that is 100 higher. `None`: no LiDAR.
    pub lidar: Option<SocketAddr>,
    /// What the LiDAR sees, and where in it the robot begins `[m]`.
    pub surroundings: (SceneKind, [f64; 2]),
    /// Draws place and noise.
    pub seed: u64,
    /// Records every image to this MCAP file, also while they are not read.
    pub record: Option<PathBuf>,
}

impl Default for BroadcastOptions {
    fn default() -> Self {
        Self {
            rate_hz: 15.0,
            intrinsics: Intrinsics::g1_color(),
            topics: CameraInput::default(),
            lidar: None,
            surroundings: (SceneKind::Endless, [0.0, 0.0]),
            seed: 0,
            record: None,
        }
    }
}

/// How it went.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BroadcastReport {
    /// Images that were sent, and those that were due and had to be dropped.
    pub pictures: [u64; 2],
    /// Time in which they were read `[s]`.
    pub read_s: f64,
    /// Packets of the LiDAR.
    pub packets: u64,
}

impl BroadcastReport {
    /// Images a second while they were read.
    pub fn rate_hz(&self) -> f64 {
        self.pictures[0] as f64 / self.read_s.max(1e-9)
    }
}

/// An image to be taken.
struct Shot {
    stamp_ns: u64,
    moment: Moment,
    /// Center (x, y) in the world `[m]` and heading `[rad]`.
    goal: Option<([f64; 2], f64)>,
}

#[derive(Debug, Default)]
struct Counts {
    /// Why the recording has ended early.
    unrecorded: OnceLock<String>,
    sent: AtomicU64,
    dropped: AtomicU64,
    packets: AtomicU64,
    read: AtomicBool,
}

/// Sends images and points of a robot that is served. It ends when it is dropped.
pub struct Broadcast {
    anchor: usize,
    begin: Instant,
    /// Time that the machine could not keep `[s]`.
    slip_s: f64,
    period_s: f64,
    next_s: f64,
    read_s: f64,
    shots: Option<SyncSender<Shot>>,
    goal: Option<([f64; 2], f64)>,
    poses: Option<SyncSender<(f64, Pose)>>,
    counts: Arc<Counts>,
    threads: Vec<JoinHandle<()>>,
}

impl Broadcast {
    /// Begins. The topics are on this domain and interface.
    ///
    /// # Errors
    /// If the network cannot be joined, a rate makes no sense, or the recording cannot be written.
    pub fn open(
        player: &Player,
        domain: u16,
        interface: IpAddr,
        options: &BroadcastOptions,
    ) -> Result<Self, TwinError> {
        if options.rate_hz != 0.0 && !(0.1..=60.0).contains(&options.rate_hz) {
            let message = format!("images a second: expected 0, or 0.1 to 60, found {}", options.rate_hz);
            return Err(TwinError::Simulation(message));
        }
        let anchor = player.model.body_index(&player.spec.anchor_body).unwrap_or(0);
        let counts = Arc::<Counts>::default();
        let topics = RosTopics::open(domain, interface)?;
        let names = &options.topics;
        let setup = SightSetup { intrinsics: options.intrinsics, lidar: None, ..BallEyes::setup(player)? };
        let recorder = options.record.as_deref().map(|path| Recorder::create(path, &setup));
        let publisher = Publisher {
            camera: SimCamera::new(options.intrinsics, player.play.ball_params.radius_m, options.seed)?,
            color: topics.writer(&names.color, IMAGE)?,
            depth: topics.writer(&names.depth, IMAGE)?,
            info: topics.writer(&names.info, CAMERA_INFO)?,
            counts: Arc::clone(&counts),
            recorder: recorder.transpose().map_err(TwinError::eyes)?,
            _topics: topics,
        };
        let (shots, waiting) = sync_channel(1);
        let mut threads = vec![std::thread::spawn(move || publisher.run(&waiting))];
        let mut poses = None;
        if let Some(to) = options.lidar {
            let here =
                Pose { pos: paid_lanes::Vec3([0.0, 0.0, player.spec.nominal_height_m]), ..Pose::identity() };
            let (surroundings, start_m) = options.surroundings;
            let lidar = SimLidar::new(surroundings, start_m, 200_000.0, &here, options.seed)?;
            let from = SocketAddr::new(interface, 0);
            let socket =
                UdpSocket::bind(from).map_err(|e| TwinError::Simulation(format!("LiDAR: {from}: {e}")))?;
            let (sender, waiting) = sync_channel(POSES);
            let counts = Arc::clone(&counts);
            threads.push(std::thread::spawn(move || scan(lidar, &socket, to, &waiting, &counts)));
            poses = Some(sender);
        }
        Ok(Self {
            anchor,
            begin: Instant::now(),
            slip_s: 0.0,
            period_s: 1.0 / options.rate_hz,
            next_s: if options.rate_hz > 0.0 { 0.0 } else { f64::INFINITY },
            read_s: 0.0,
            shots: Some(shots),
            goal: None,
            poses,
            counts,
            threads,
        })
    }

    /// The report so far.
    pub fn report(&self) -> BroadcastReport {
        let count = |of: &AtomicU64| of.load(Ordering::Relaxed);
        let Counts { sent, dropped, packets, .. } = &*self.counts;
        BroadcastReport {
            pictures: [count(sent), count(dropped)],
            read_s: self.read_s,
            packets: count(packets),
        }
    }
}

impl Watcher for Broadcast {
    fn step(&mut self, robot: &VirtualG1) {
        let simulated_s = robot.now_us() as f64 * 1e-6;
        let behind = self.begin.elapsed().as_secs_f64() - simulated_s - self.slip_s;
        if behind > BEHIND_S {
            self.slip_s += behind;
        }
        // The devices' clocks continue while the simulation waits.
        let at_s = simulated_s + self.slip_s;
        let body = &robot.truth().bodies[self.anchor];
        if let Some(poses) = &self.poses {
            let _ = poses.try_send((at_s, Pose { rot: body.rot, pos: body.pos }));
        }
        if self.counts.read.load(Ordering::Relaxed) {
            self.read_s += crate::STEP_US as f64 * 1e-6;
        }
        if at_s < self.next_s {
            return;
        }
        self.next_s = (self.next_s + self.period_s).max(at_s);
        if !self.counts.read.load(Ordering::Relaxed) {
            return;
        }
        let stamp_ns =
            SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_nanos() as u64);
        let shot = Shot { stamp_ns, moment: Moment::of(robot, self.anchor), goal: self.goal };
        if let Some(shots) = &self.shots
            && shots.try_send(shot).is_err()
        {
            self.counts.dropped.fetch_add(1, Ordering::Relaxed);
        }
    }

    fn goal(&mut self, center: [f64; 2], heading: f64) {
        self.goal = Some((center, heading));
    }
}

impl Broadcast {
    /// Ends; how it went, and why the recording is not complete, if it is not.
    pub fn end(mut self) -> (BroadcastReport, Option<String>) {
        self.join();
        (self.report(), self.counts.unrecorded.get().cloned())
    }

    fn join(&mut self) {
        (self.shots, self.poses) = (None, None);
        for thread in self.threads.drain(..) {
            let _ = thread.join();
        }
    }
}

impl Drop for Broadcast {
    fn drop(&mut self) {
        self.join();
    }
}

/// The thread that renders.
struct Publisher {
    camera: SimCamera,
    color: RosWriter,
    depth: RosWriter,
    info: RosWriter,
    counts: Arc<Counts>,
    recorder: Option<Recorder>,
    _topics: RosTopics,
}

impl Publisher {
    fn run(mut self, shots: &Receiver<Shot>) {
        loop {
            let wanted = self.recorder.is_some() || self.color.is_heard();
            self.counts.read.store(wanted, Ordering::Relaxed);
            let Shot { stamp_ns, moment, goal } = match shots.recv_timeout(Duration::from_millis(200)) {
                Ok(shot) => shot,
                Err(RecvTimeoutError::Timeout) => continue,
                Err(RecvTimeoutError::Disconnected) => {
                    let ended = self.recorder.take().map_or(Ok(()), Recorder::finish);
                    self.recorded(ended);
                    return;
                }
            };
            if let Some((center, heading)) = goal {
                self.camera.place_goal(center, heading);
            }
            let (color, depth) = self.camera.picture(&moment);
            let info = write_camera_info(stamp_ns, self.camera.intrinsics());
            // The color image last: a reader has the others by then.
            let sent = self
                .info
                .send(info)
                .and_then(|()| self.depth.send(write_depth(stamp_ns, &depth)))
                .and_then(|()| self.color.send(write_color(stamp_ns, &color)));
            let count = if sent.is_ok() { &self.counts.sent } else { &self.counts.dropped };
            count.fetch_add(1, Ordering::Relaxed);
            if let Some(recorder) = &mut self.recorder {
                let intrinsics = *self.camera.intrinsics();
                let picture = PictureMessage {
                    captured_ns: stamp_ns,
                    color,
                    depth: Some(depth),
                    intrinsics,
                    boxes: None,
                };
                let message = Message::Picture(Box::new(picture));
                let written = recorder.message(&Arrived { at_ns: stamp_ns, message });
                self.recorded(written);
            }
        }
    }

    /// A full disk ends the recording, not the robot.
    fn recorded(&mut self, written: Result<(), paid_world::SightError>) {
        if let Err(why) = written {
            let _ = self.counts.unrecorded.set(why.to_string());
            self.recorder = None;
        }
    }
}

/// The thread of the LiDAR.
fn scan(
    mut lidar: SimLidar,
    socket: &UdpSocket,
    to: SocketAddr,
    poses: &Receiver<(f64, Pose)>,
    counts: &Counts,
) {
    let samples = SocketAddr::new(to.ip(), to.port().saturating_add(IMU_PORT));
    let mut waiting = 0;
    while let Ok((at_s, pose)) = poses.recv() {
        lidar.torso(at_s, &pose);
        waiting += 1;
        if waiting < POSES_A_BURST {
            continue;
        }
        waiting = 0;
        for packet in lidar.packets(at_s) {
            // The eleventh byte is the kind: 0 for samples. A device does not care whether anybody listens.
            let address = if packet.get(10) == Some(&0) { samples } else { to };
            let sent = socket.send_to(&packet, address).is_ok();
            counts.packets.fetch_add(u64::from(sent), Ordering::Relaxed);
        }
    }
}
