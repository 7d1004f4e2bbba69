//! The senses' reports, on their way to the runtime.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::Instant;

use crate::link::{Inlet, Link, LinkError, Outlet};
use crate::mailbox::Mailbox;
use crate::message::{EyesReport, Packet, TorsoPose};
use crate::wire::{LowCmd, LowState};

/// Joint angles are passed to onboard perception with one state in this many: a hundred times a second.
const STATES: u32 = 5;
/// The goal is set once the runtime has had this many poses of the torso: it is placed from there.
const POSES: u32 = 10;
/// Joint angles that may queue for perception: half a second.
const WAITING: usize = 64;

/// Motor angles of a state that came at a time of perception's clock.
#[derive(Clone, Copy, Debug)]
pub struct Joints {
    /// When it came `[ns]`.
    pub at_ns: u64,
    /// Motor order `[rad]`.
    pub angles: [f32; 35],
}

/// What travels between perception's threads and the runtime's. Neither side waits.
#[derive(Debug)]
pub struct Desk {
    begin: Instant,
    /// These two with the time at which they held `[ns]`.
    pub(crate) torso: Mailbox<(u64, TorsoPose)>,
    pub(crate) report: Mailbox<(u64, EyesReport)>,
    joints: SyncSender<Joints>,
    goal: Option<[f64; 2]>,
    /// The goal may be set over the network, too.
    hears_goal: bool,
}

impl Desk {
    /// A desk, and where joint angles come out.
    pub fn new(goal: Option<[f64; 2]>, hears_goal: bool) -> (Arc<Self>, Receiver<Joints>) {
        let (joints, from) = sync_channel(WAITING);
        let desk = Self {
            begin: Instant::now(),
            torso: Mailbox::default(),
            report: Mailbox::default(),
            joints,
            goal,
            hears_goal,
        };
        (Arc::new(desk), from)
    }

    /// Time since perception began `[ns]`.
    pub fn now_ns(&self) -> u64 {
        self.begin.elapsed().as_nanos() as u64
    }
}

/// Where ball and torso come from.
#[derive(Clone, Debug)]
pub enum Sensed {
    /// From nowhere: no kick is allowed.
    Nothing,
    /// From a virtual robot's detector and odometry: the ground truth plus random errors. They do not test a camera or a LiDAR.
    Virtual,
    /// From onboard perception.
    Eyes(Arc<Desk>),
}

/// A link to a robot with its senses.
pub struct SensedLink<L> {
    link: L,
    sensed: Sensed,
}

impl<L: Link> SensedLink<L> {
    /// Passes on what comes over `link`, and ball and torso from `sensed` alone.
    pub fn new(link: L, sensed: Sensed) -> Self {
        Self { link, sensed }
    }
}

/// Goes between the runtime and the link's own inlet.
#[derive(Debug)]
struct Tap {
    sensed: Sensed,
    states: u32,
    poses: u32,
}

impl Tap {
    fn new(sensed: Sensed) -> Self {
        Self { sensed, states: 0, poses: 0 }
    }

    /// Whether the runtime gets a packet of the link.
    fn passes(&mut self, packet: &Packet) -> bool {
        match packet {
            Packet::LowState(bytes) => {
                if let Sensed::Eyes(desk) = &self.sensed {
                    self.states += 1;
                    if self.states.is_multiple_of(STATES)
                        && let Ok(state) = LowState::from_cdr(bytes)
                    {
                        let angles = state.motors.each_ref().map(|motor| motor.q);
                        let _ = desk.joints.try_send(Joints { at_ns: desk.now_ns(), angles });
                    }
                }
                true
            }
            // From the robot's own topics.
            Packet::Battery(_) | Packet::OthersCommand => true,
            Packet::Detection(_) | Packet::Odometry(_) | Packet::Goal(_) => {
                matches!(self.sensed, Sensed::Virtual)
            }
            // Virtual senses place the goal themselves.
            Packet::GoalAhead(_) => matches!(&self.sensed, Sensed::Eyes(desk) if desk.hears_goal),
            // Nothing else may stand in for onboard perception, the motion switcher, the operator or this program.
            Packet::Torso(_)
            | Packet::Eyes(_)
            | Packet::Master(_)
            | Packet::Keys(_)
            | Packet::Broken(_)
            | Packet::LowCmd(_) => false,
        }
    }

    /// Messages of perception.
    fn own(&mut self) -> Option<Packet> {
        let Sensed::Eyes(desk) = &self.sensed else { return None };
        let now_ns = desk.now_ns();
        if self.poses == POSES {
            self.poses += 1;
            if let Some(goal) = desk.goal {
                return Some(Packet::GoalAhead(goal));
            }
        }
        let age_us = |at_ns: u64| now_ns.saturating_sub(at_ns) / 1000;
        if let Some((at_ns, pose)) = desk.torso.take() {
            self.poses = if self.poses < POSES { self.poses + 1 } else { self.poses };
            return Some(Packet::Torso(TorsoPose { age_us: age_us(at_ns), ..pose }));
        }
        if let Some((at_ns, report)) = desk.report.take() {
            return Some(Packet::Eyes(EyesReport { age_us: age_us(at_ns), ..report }));
        }
        None
    }

    fn receive(&mut self, link: &mut (impl Inlet + ?Sized)) -> Result<Option<Packet>, LinkError> {
        while let Some(packet) = link.receive()? {
            if self.passes(&packet) {
                return Ok(Some(packet));
            }
        }
        Ok(self.own())
    }
}

struct SensedInlet {
    link: Box<dyn Inlet>,
    tap: Tap,
}

impl Inlet for SensedInlet {
    fn receive(&mut self) -> Result<Option<Packet>, LinkError> {
        self.tap.receive(&mut *self.link)
    }
}

impl<L: Link> Outlet for SensedLink<L> {
    fn send(&mut self, packet: Packet) -> Result<(), LinkError> {
        self.link.send(packet)
    }
    fn command(&mut self, command: &LowCmd) -> Result<(), LinkError> {
        self.link.command(command)
    }
}

impl<L: Link> Inlet for SensedLink<L> {
    fn receive(&mut self) -> Result<Option<Packet>, LinkError> {
        // Whoever does not split the link has the tap of this call alone: joint angles are not passed on.
        Tap::new(self.sensed.clone()).receive(&mut self.link)
    }
}

impl<L: Link> Link for SensedLink<L> {
    fn split(self) -> (Box<dyn Outlet>, Box<dyn Inlet>) {
        let (outlet, link) = self.link.split();
        (outlet, Box::new(SensedInlet { link, tap: Tap::new(self.sensed) }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ChannelLink;
    use crate::message::{BallDetection, OdometryPose};

    fn everything() -> [Packet; 8] {
        let quaternion = [1.0, 0.0, 0.0, 0.0];
        [
            Packet::Battery(80.0),
            Packet::Detection(BallDetection { captured_us: 1, ball: None, deviation_m: 0.01 }),
            Packet::Odometry(OdometryPose { stamp_us: 1, position: [0.0; 3], quaternion }),
            Packet::Goal([5.0, 0.0]),
            Packet::GoalAhead([4.0, 0.0]),
            Packet::Master(String::new()),
            Packet::Keys(1),
            Packet::Broken("no".to_owned()),
        ]
    }

    fn received(sensed: Sensed) -> Vec<Packet> {
        let (mut robot, runtime) = ChannelLink::pair();
        let (_, mut inlet) = SensedLink::new(runtime, sensed).split();
        everything().into_iter().for_each(|packet| robot.send(packet).expect("open"));
        std::iter::from_fn(|| inlet.receive().expect("open")).collect()
    }

    #[test]
    fn virtual_senses_are_heard_only_where_they_are_asked_for() {
        let [battery, sighting, pose, goal, ahead, ..] = everything();
        assert_eq!(received(Sensed::Nothing), std::slice::from_ref(&battery));
        assert_eq!(received(Sensed::Virtual), [battery.clone(), sighting, pose, goal]);
        let (desk, _joints) = Desk::new(None, false);
        assert_eq!(received(Sensed::Eyes(desk)), std::slice::from_ref(&battery));
        let (asked, _joints) = Desk::new(None, true);
        assert_eq!(received(Sensed::Eyes(asked)), [battery, ahead]);
    }

    #[test]
    fn the_eyes_get_joints_and_their_word_reaches_the_runtime_once() {
        let (desk, joints) = Desk::new(Some([5.0, 0.0]), false);
        let (mut robot, runtime) = ChannelLink::pair();
        let (_, mut inlet) = SensedLink::new(runtime, Sensed::Eyes(Arc::clone(&desk))).split();
        let mut state = LowState::default();
        state.motors[3].q = 0.25;
        for _ in 0..10 {
            robot.send(Packet::LowState(state.clone().sealed().to_cdr())).expect("open");
            assert!(matches!(inlet.receive(), Ok(Some(Packet::LowState(_)))));
        }
        assert_eq!(joints.try_iter().map(|joints| joints.angles[3]).collect::<Vec<_>>(), [0.25; 2]);
        let report = EyesReport { age_us: 0, picture_age_us: Some(3), frame: 2, floor_m: None, ball: None };
        desk.report.put((desk.now_ns(), report));
        assert!(matches!(inlet.receive(), Ok(Some(Packet::Eyes(EyesReport { frame: 2, .. })))));
        let quaternion = [1.0, 0.0, 0.0, 0.0];
        let pose = TorsoPose { age_us: 0, frame: 2, position: [0.0; 3], quaternion };
        for _ in 0..10 {
            desk.torso.put((0, pose));
            assert!(matches!(inlet.receive(), Ok(Some(Packet::Torso(TorsoPose { frame: 2, .. })))));
        }
        // From here on the runtime knows where it is.
        assert_eq!(inlet.receive(), Ok(Some(Packet::GoalAhead([5.0, 0.0]))));
        assert_eq!(inlet.receive(), Ok(None));
    }
}
