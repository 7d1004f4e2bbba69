//! How well the torso's pose is known, and whether another odometry's poses can be trusted: late, jumping, silent.

use std::fmt;

use paid_lidar::{Health, LostReason, NotStill};
use paid_track::StampedPose;

/// How well the torso's pose is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OdometryState {
    /// No pose yet.
    Waiting,
    /// It follows.
    Tracking,
    /// Along this direction of its frame it does not know its place.
    Degenerate([f64; 3]),
    /// It has lost its place.
    Lost,
    /// Another odometry's last pose cannot be trusted.
    Refused(PoseFault),
}

/// Why LiDAR-inertial odometry has no pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NoPose {
    /// The sensor does not stand still, which it must to start.
    NotStill(NotStill),
    /// The scans do not give it.
    Lost(LostReason),
}

impl NoPose {
    /// Of the odometry's own health; `None`: there is a pose, or it just waits.
    pub fn of(health: &Health) -> Option<Self> {
        match health {
            Health::Initializing(why) => why.map(Self::NotStill),
            Health::Lost { reason, .. } => Some(Self::Lost(*reason)),
            Health::Tracking | Health::Degenerate { .. } => None,
        }
    }
}

impl fmt::Display for NoPose {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotStill(why) => why.fmt(f),
            Self::Lost(why) => why.fmt(f),
        }
    }
}

impl OdometryState {
    /// Of LiDAR-inertial odometry.
    pub fn of(health: &Health) -> Self {
        match health {
            Health::Initializing(_) => Self::Waiting,
            Health::Tracking => Self::Tracking,
            Health::Degenerate { direction } => Self::Degenerate((*direction).into()),
            Health::Lost { .. } => Self::Lost,
        }
    }

    /// In words, with the reason if there is one.
    pub fn with_reason(&self, why: Option<&NoPose>) -> String {
        why.map_or_else(|| self.to_string(), |why| format!("{self}: {why}"))
    }

    /// Whether a place may be taken from the pose.
    pub fn is_usable(&self) -> bool {
        matches!(self, Self::Tracking | Self::Degenerate(_))
    }
}

impl fmt::Display for OdometryState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Waiting => write!(f, "waiting"),
            Self::Tracking => write!(f, "tracking"),
            Self::Degenerate([x, y, z]) => write!(f, "unobservable along ({x:.2}, {y:.2}, {z:.2})"),
            Self::Lost => write!(f, "lost"),
            Self::Refused(fault) => write!(f, "lost: {fault}"),
        }
    }
}

/// What is wrong with the poses of another odometry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PoseFault {
    /// Not finite, or its quaternion is no rotation.
    Broken,
    /// It came too late, or from the future.
    Time {
        /// Its age at its arrival `[s]`.
        age_s: f64,
    },
    /// Its time is before that of the pose before.
    TimeBackwards {
        /// By this much `[s]`.
        by_s: f64,
    },
    /// No robot moves this far in the time between two poses.
    Jumped {
        /// Distance `[m]`.
        by_m: f64,
        /// Angle `[rad]`.
        by_rad: f64,
        /// In this time `[s]`.
        in_s: f64,
    },
    /// None came for too long.
    Silent {
        /// Age of the last one `[s]`.
        age_s: f64,
    },
}

impl fmt::Display for PoseFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Broken => write!(f, "pose with a number that is none"),
            Self::Time { age_s } => write!(f, "pose {age_s:.2} s old, expected 0 to {OLDEST_S} s"),
            Self::TimeBackwards { by_s } => {
                write!(f, "pose {by_s:.2} s before the last one, expected a later one")
            }
            Self::Jumped { by_m, by_rad, in_s } => write!(
                f,
                "pose jumps by {by_m:.2} m and {by_rad:.2} rad in {in_s:.3} s, expected {SPEED} m/s and {RATE} rad/s at most"
            ),
            Self::Silent { age_s } => write!(f, "last pose {age_s:.2} s old, expected 0 to {SILENT_S} s"),
        }
    }
}

/// A pose that is older at its arrival is not used `[s]`: a kicking torso goes 10 cm in that time.
const OLDEST_S: f64 = 0.1;
/// Clocks of odometry and computer may differ by this much `[s]`.
const FUTURE_S: f64 = 0.02;
/// Odometry at 10 Hz or more has sent two poses in this time `[s]`.
const SILENT_S: f64 = 0.2;
/// Time that runs back by more is a clock that was set `[s]`.
const SET_CLOCK_S: f64 = 1.0;
/// Faster than a robot's torso goes `[m/s]` ...
const SPEED: f64 = 4.0;
/// ... and turns `[rad/s]`, in addition to an odometry's own corrections of `STEP_M` and `STEP_RAD`.
const RATE: f64 = 10.0;
const STEP_M: f64 = 0.05;
const STEP_RAD: f64 = 0.1;
/// After a longer silence it may have moved as far as in this time `[s]`.
const LONGEST_S: f64 = 0.5;
/// This many poses in a row that agree with each other are a new frame, not an error.
const AGREEING: u32 = 5;

/// Watches the poses of another odometry.
#[derive(Clone, Debug, Default)]
pub struct PoseWatch {
    last: Option<StampedPose>,
    /// The newest of the poses elsewhere that agree with each other, and how many.
    elsewhere: Option<(StampedPose, u32)>,
    /// A clock was set: where the robot went meanwhile is not known.
    unsure: bool,
}

impl PoseWatch {
    /// Looks at a pose that came at `now_s` `[s]`. True: it is to be used, and begins a new frame, in which places of the old one mean nothing.
    ///
    /// # Errors
    /// The first fault; the pose is not to be used then. Poses that have jumped are refused until five in a row agree with each other.
    pub fn check(&mut self, pose: &StampedPose, now_s: f64) -> Result<bool, PoseFault> {
        let norm = pose.quat.0.iter().map(|v| v * v).sum::<f64>();
        let finite = pose.pos.0.iter().chain([&pose.time_s]).all(|v| v.is_finite());
        if !finite || !(0.9..1.1).contains(&norm) {
            return Err(PoseFault::Broken);
        }
        let age_s = now_s - pose.time_s;
        if !(-FUTURE_S..=OLDEST_S).contains(&age_s) {
            return Err(PoseFault::Time { age_s });
        }
        let Some(last) = self.last else {
            self.last = Some(*pose);
            return Ok(std::mem::take(&mut self.unsure));
        };
        let by_s = last.time_s - pose.time_s;
        if by_s > SET_CLOCK_S {
            *self = Self { unsure: true, ..Self::default() };
            return Err(PoseFault::TimeBackwards { by_s });
        }
        if by_s > 0.0 {
            return Err(PoseFault::TimeBackwards { by_s });
        }
        let Some(jump) = jump(&last, pose) else {
            (self.last, self.elsewhere) = (Some(*pose), None);
            return Ok(false);
        };
        let agreeing = match self.elsewhere {
            Some((other, count)) if self::jump(&other, pose).is_none() => count + 1,
            _ => 1,
        };
        self.elsewhere = Some((*pose, agreeing));
        if agreeing < AGREEING {
            return Err(jump);
        }
        (self.last, self.elsewhere) = (Some(*pose), None);
        Ok(true)
    }

    /// Whether poses have come to an end, at `now_s` `[s]`.
    pub fn silent(&self, now_s: f64) -> Option<PoseFault> {
        let age_s = now_s - self.last?.time_s;
        (age_s > SILENT_S).then_some(PoseFault::Silent { age_s })
    }
}

/// How one pose jumps to the next, if it does.
fn jump(from: &StampedPose, to: &StampedPose) -> Option<PoseFault> {
    let in_s = to.time_s - from.time_s;
    let by_m = (to.pos - from.pos).norm();
    let cosine: f64 = (0..4).map(|k| from.quat.0[k] * to.quat.0[k]).sum();
    let by_rad = 2.0 * cosine.abs().min(1.0).acos();
    let time = in_s.clamp(0.0, LONGEST_S);
    (by_m > STEP_M + SPEED * time || by_rad > STEP_RAD + RATE * time).then_some(PoseFault::Jumped {
        by_m,
        by_rad,
        in_s,
    })
}

#[cfg(test)]
mod tests {
    use paid_lanes::{Quat, Vec3};

    use super::*;

    fn pose(time_s: f64, x: f64, yaw: f64) -> StampedPose {
        let quat = Quat::from_axis_angle(Vec3([0.0, 0.0, 1.0]), yaw);
        StampedPose { time_s, quat, pos: Vec3([x, 0.0, 0.8]) }
    }

    #[test]
    fn a_jump_is_refused_and_five_poses_that_agree_are_a_new_frame() {
        let mut watch = PoseWatch::default();
        let mut see = |time_s: f64, x: f64, yaw: f64| watch.check(&pose(time_s, x, yaw), time_s + 0.01);
        // 0.05 m + 4 m/s * 0.02 s = 0.13 m; 0.1 + 10 * 0.02 = 0.3 rad.
        assert_eq!([see(1.0, 0.0, 0.0), see(1.02, 0.12, 0.29), see(1.04, 0.0, 0.0)], [Ok(false); 3]);
        let error = see(1.06, 0.2, 0.0).expect_err("too far");
        let text = "pose jumps by 0.20 m and 0.00 rad in 0.020 s, expected 4 m/s and 10 rad/s at most";
        assert_eq!(error.to_string(), text);
        // A single wrong one changes nothing; a turn counts as well.
        assert_eq!(see(1.08, 0.0, 0.0), Ok(false));
        assert!(matches!(see(1.10, 0.0, 0.5), Err(PoseFault::Jumped { .. })));
        assert_eq!(see(1.12, 0.0, 0.0), Ok(false));
        // Another place for good: four are refused, the fifth begins a frame.
        let answers = [0, 1, 2, 3, 4, 5].map(|k| see(1.14 + 0.02 * f64::from(k), 2.0, 0.0).ok());
        assert_eq!(answers, [None, None, None, None, Some(true), Some(false)]);
    }

    #[test]
    fn late_broken_and_backward_poses_are_refused_and_silence_is_noticed() {
        let mut watch = PoseWatch::default();
        assert_eq!(watch.silent(100.0), None);
        assert_eq!(watch.check(&pose(5.0, 0.0, 0.0), 5.09), Ok(false));
        let late = watch.check(&pose(5.1, 0.0, 0.0), 5.22).expect_err("0.12 s");
        assert_eq!(late.to_string(), "pose 0.12 s old, expected 0 to 0.1 s");
        assert!(matches!(watch.check(&pose(5.3, 0.0, 0.0), 5.22), Err(PoseFault::Time { .. })));
        assert_eq!(watch.check(&pose(5.2, f64::NAN, 0.0), 5.22), Err(PoseFault::Broken));
        let early = watch.check(&pose(4.98, 0.0, 0.0), 5.01).expect_err("older than the last");
        assert_eq!(early.to_string(), "pose 0.02 s before the last one, expected a later one");
        assert_eq!(watch.silent(5.19), None);
        let silent = watch.silent(5.25).expect("a quarter of a second");
        assert_eq!(silent.to_string(), "last pose 0.25 s old, expected 0 to 0.2 s");
        // A clock that is set is reported once; what comes then is a new frame.
        assert!(matches!(watch.check(&pose(1.0, 0.0, 0.0), 1.0), Err(PoseFault::TimeBackwards { .. })));
        assert_eq!(watch.check(&pose(1.02, 0.0, 0.0), 1.02), Ok(true));
        assert_eq!(watch.check(&pose(1.04, 0.0, 0.0), 1.04), Ok(false));
    }
}
