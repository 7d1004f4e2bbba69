//! The thread that follows the torso.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::SyncSender;
use std::time::Duration;

use paid_lidar::packet::{Counts, Data, UdpSource};
use paid_world::fault_kind;
use paid_world::ros::read_odometry;

use super::teller::Teller;
use super::{SILENT_NS, of_system};
use crate::DeployError;
use crate::eyes::{Desk, DeviceClock, OdometryInput, StampClock, TorsoEyes, TorsoFix};
use crate::ros::{LidarTopics, ODOMETRY, RosReader, RosTopics};

/// Wrong packets of the LiDAR are reported at this interval `[ns]`.
const COUNT_NS: u64 = 5_000_000_000;

/// Where a thread that follows the torso puts what it knows.
pub(super) struct Follow {
    to_ball: SyncSender<TorsoFix>,
    desk: Arc<Desk>,
    teller: Teller,
    state: String,
}

impl Follow {
    pub fn new(to_ball: SyncSender<TorsoFix>, desk: Arc<Desk>, teller: Teller) -> Self {
        Self { to_ball, desk, teller, state: String::new() }
    }

    fn fix(&mut self, fix: TorsoFix) {
        self.desk.torso.put((fix.at_ns, fix.handed_over(fix.at_ns)));
        // A ball thread that is a second behind has lost more than this pose.
        let _ = self.to_ball.try_send(fix);
    }

    fn state(&mut self, eyes: &TorsoEyes) {
        let state = eyes.words();
        // The same fault with other figures is reported once.
        if fault_kind(&state) != fault_kind(&self.state) {
            self.teller.tell(format!("odometry: {state}"));
        }
        self.state = state;
    }

    /// What a LiDAR has measured, or that it is silent.
    fn measured(&mut self, data: Option<Data>, eyes: &mut TorsoEyes, now_ns: u64) {
        match data {
            Some(Data::Imu(sample)) => {
                if let Some(fix) = eyes.imu(sample, now_ns) {
                    self.fix(fix);
                }
            }
            Some(Data::Scan(scan)) => eyes.scan(scan, now_ns),
            None => eyes.poll(now_ns),
        }
        if let Some(fault) = eyes.data_fault() {
            self.teller.tell(format!("LiDAR: {fault}"));
        }
    }

    /// By a LiDAR's topics.
    fn lidar_topics(&mut self, mut source: LidarTopics, mut eyes: TorsoEyes, stop: &AtomicBool) {
        while !stop.load(Ordering::Acquire) {
            let data = source.next(Duration::from_millis(5));
            let now_ns = self.desk.now_ns();
            match data {
                Ok(data) => self.measured(data, &mut eyes, now_ns),
                Err(line) => {
                    self.teller.tell(format!("LiDAR: {line}"));
                    std::thread::sleep(Duration::from_millis(1));
                }
            }
            source
                .silent()
                .for_each(|why| self.teller.tell(format!("LiDAR: no message for a second: {why}")));
            self.state(&eyes);
        }
    }

    /// By a LiDAR's packets.
    fn lidar(&mut self, mut source: UdpSource, mut eyes: TorsoEyes, stop: &AtomicBool) {
        let (mut counts, mut counted_ns) = (Counts::default(), 0);
        while !stop.load(Ordering::Acquire) {
            let data = source.next(Duration::from_millis(5));
            let now_ns = self.desk.now_ns();
            match data {
                Ok(data) => self.measured(data.map(|(data, _)| data), &mut eyes, now_ns),
                Err(error) => {
                    self.teller.tell(format!("LiDAR: {error}"));
                    std::thread::sleep(Duration::from_millis(100));
                }
            }
            self.state(&eyes);
            if now_ns > counted_ns + COUNT_NS {
                counted_ns = now_ns;
                let bad =
                    |c: &Counts| [c.damaged, c.foreign, c.lost, c.doubled, c.out_of_order, c.wrong_time];
                let new = source.counts();
                if bad(&new) != bad(&counts) {
                    let [damaged, foreign, lost, doubled, early, late] = bad(&new);
                    self.teller.tell(format!(
                        "LiDAR: packets so far: {} taken, {damaged} damaged, {foreign} of another device, {lost} lost, {doubled} doubled, {early} out of order, {late} with a wrong time",
                        new.taken
                    ));
                    counts = new;
                }
            }
        }
    }

    /// By another odometry's topic.
    fn topic(
        &mut self,
        mut reader: RosReader,
        [name, child]: [&str; 2],
        clock: StampClock,
        stop: &AtomicBool,
    ) {
        let (mut eyes, mut own, mut came_ns) = (TorsoEyes::other(), DeviceClock::default(), 0);
        while !stop.load(Ordering::Acquire) {
            let now_ns = self.desk.now_ns();
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
                        self.teller.tell(format!(
                            "odometry: expected a pose at most 1 s old, found one of {:.1} s: a clock that is not this machine's? (clock = \"own\")",
                            age_ns as f64 * 1e-9
                        ));
                        continue;
                    }
                    if let Some(fix) = eyes.pose(pose, now_ns) {
                        self.fix(fix);
                    }
                    self.state(&eyes);
                }
                Ok(Some(Ok((_, found)))) => {
                    self.teller.tell(format!("odometry: expected the child frame {child}, found '{found}'"));
                }
                Ok(Some(Err(error))) => self.teller.tell(error.to_string()),
                Ok(None) => {
                    if now_ns > came_ns + SILENT_NS {
                        let why = reader.silent().map_or_else(String::new, |why| format!(": {why}"));
                        self.teller.tell(format!("odometry: no pose for a second on {name}{why}"));
                        self.state.clear();
                    }
                    std::thread::sleep(Duration::from_millis(1));
                }
                Err(error) => {
                    self.teller.tell(format!("odometry: {error}"));
                    std::thread::sleep(Duration::from_millis(10));
                }
            }
        }
    }
}

/// What the torso is followed by.
pub(super) enum Torso {
    Lidar(Box<(UdpSource, TorsoEyes)>),
    LidarTopics(Box<(LidarTopics, TorsoEyes)>),
    Topic { reader: Box<RosReader>, name: String, child: String, clock: StampClock },
}

impl Torso {
    /// Looks whether [`Self::open`] will work. No socket is kept: what waited in it would be old.
    pub fn check(input: &OdometryInput) -> Result<(), DeployError> {
        if let OdometryInput::Lidar { points, imu, .. } = input {
            UdpSource::bind(*points, *imu).map_err(DeployError::eyes)?;
        }
        match input {
            OdometryInput::Lidar { latency_s, .. } | OdometryInput::LidarTopics { latency_s, .. } => {
                TorsoEyes::lidar(paid_lidar::Config::g1(), *latency_s).map(drop)
            }
            OdometryInput::Topic { .. } => Ok(()),
        }
    }

    pub fn open(input: &OdometryInput, topics: &RosTopics) -> Result<Self, DeployError> {
        Ok(match input {
            OdometryInput::Lidar { points, imu, latency_s } => {
                let source = UdpSource::bind(*points, *imu).map_err(DeployError::eyes)?;
                Self::Lidar(Box::new((source, TorsoEyes::lidar(paid_lidar::Config::g1(), *latency_s)?)))
            }
            OdometryInput::LidarTopics { points_topic, imu_topic, latency_s } => {
                let source = LidarTopics::open(topics, points_topic, imu_topic)?;
                let eyes = TorsoEyes::lidar(paid_lidar::Config::g1(), *latency_s)?;
                Self::LidarTopics(Box::new((source, eyes)))
            }
            OdometryInput::Topic { topic, child, clock } => {
                let reader = Box::new(topics.reader(topic, ODOMETRY, false)?);
                Self::Topic { reader, name: topic.clone(), child: child.clone(), clock: *clock }
            }
        })
    }

    pub fn run(self, mut follow: Follow, stop: &AtomicBool) {
        match self {
            Self::Lidar(parts) => {
                let (source, eyes) = *parts;
                follow.lidar(source, eyes, stop);
            }
            Self::LidarTopics(parts) => {
                let (source, eyes) = *parts;
                follow.lidar_topics(source, eyes, stop);
            }
            Self::Topic { reader, name, child, clock } => follow.topic(*reader, [&name, &child], clock, stop),
        }
    }
}
