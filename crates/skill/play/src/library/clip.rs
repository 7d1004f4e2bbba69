//! One motion, and what is derived from it.

use paid_robot::RobotModel;

use crate::PlayError;

/// One motion at the control rate, in model order. Row `t` of a `[T, N]` array is at `t * N ..`.
#[derive(Clone, Debug, PartialEq)]
pub struct ReferenceClip {
    /// Name.
    pub name: String,
    /// Frames a second; must be the control rate.
    pub fps: f64,
    /// Labeled kicking foot: 0 left, 1 right.
    pub kick_foot: usize,
    /// Frame in which the foot meets the ball, where the motion states it; else the fastest frame of the foot counts.
    pub strike_frame: Option<usize>,
    /// Number of frames T.
    pub frames: usize,
    /// Joint angles `[T, J]` `[rad]`.
    pub joint_pos: Vec<f64>,
    /// Joint velocities `[T, J]` `[rad/s]`.
    pub joint_vel: Vec<f64>,
    /// Body origins `[T, B]`, world `[m]`.
    pub body_pos: Vec<[f64; 3]>,
    /// Body orientations `[T, B]`, w, x, y, z.
    pub body_quat: Vec<[f64; 4]>,
    /// Velocities of the bodies' centers of mass `[T, B]`, world `[m/s]`.
    pub body_com_vel: Vec<[f64; 3]>,
    /// Angular velocities `[T, B]`, world `[rad/s]`.
    pub body_ang_vel: Vec<[f64; 3]>,
}

impl ReferenceClip {
    /// Refuses an array of the wrong length, a number that is not finite, a frame that does not exist.
    pub(super) fn check(&self, robot: &RobotModel) -> Result<(), PlayError> {
        let (t, joints, bodies) = (self.frames, robot.joints.len(), robot.bodies.len());
        let fail = |what: String| Err(PlayError::Library(format!("motion '{}': {what}", self.name)));
        if t < 2 || self.kick_foot > 1 || !(self.fps > 0.0 && self.fps.is_finite()) {
            return fail(format!(
                "expected at least 2 frames, a positive rate and kick foot 0 or 1, found {t}, {}, {}",
                self.fps, self.kick_foot
            ));
        }
        if let Some(strike) = self.strike_frame.filter(|strike| *strike >= t) {
            return fail(format!("expected a strike frame from 0 to {}, found {strike}", t - 1));
        }
        let lengths = [
            ("joint_pos", self.joint_pos.len(), t * joints),
            ("joint_vel", self.joint_vel.len(), t * joints),
            ("body_pos", self.body_pos.len(), t * bodies),
            ("body_quat", self.body_quat.len(), t * bodies),
            ("body_com_vel", self.body_com_vel.len(), t * bodies),
            ("body_ang_vel", self.body_ang_vel.len(), t * bodies),
        ];
        for (key, found, expected) in lengths {
            if found != expected {
                return fail(format!("'{key}' has {found} rows, expected {expected}"));
            }
        }
        let finite = self.joint_pos.iter().chain(&self.joint_vel).all(|x| x.is_finite())
            && self.body_quat.iter().flatten().all(|x| x.is_finite())
            && [&self.body_pos, &self.body_com_vel, &self.body_ang_vel]
                .iter()
                .all(|rows| rows.iter().flatten().all(|x| x.is_finite()));
        if finite { Ok(()) } else { fail("a value is not finite".into()) }
    }
}

/// What is derived from a motion.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionFacts {
    /// Name.
    pub name: String,
    /// Number of frames.
    pub frames: usize,
    /// Labeled kicking foot: 0 left, 1 right.
    pub kick_foot: usize,
    /// Frame of the strike: the stated one, or the one in which the kicking foot's center of mass is fastest.
    pub strike_frame: usize,
    /// Frame in which the policy's foot meets the ball: the strike's, unless it was measured ([`super::ReferenceLibrary::with_contacts`]).
    pub contact_frame: usize,
    /// Speed of the foot's center of mass in the frame of the strike `[m/s]`.
    pub strike_speed: f64,
    /// Anchor position (x, y) in the first frame, world `[m]`.
    pub start_xy: [f64; 2],
    /// Base position (x, y) in the first frame, world `[m]`.
    pub base_xy: [f64; 2],
    /// Heading of the anchor's x axis in the first frame `[rad]`.
    pub heading: f64,
    /// From `start_xy` to the nominal ball, world axes `[m]`: the anchor's displacement from the first to the last frame, unless
    /// [`super::ReferenceLibrary::with_balls_at_strike`] put it elsewhere.
    pub displacement: [f64; 2],
}

/// How far ahead a kick is, negative after it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KickTimes {
    /// Until the reference strikes `[s]`.
    pub to_strike_s: f64,
    /// Until the policy's foot meets the ball `[s]`.
    pub to_contact_s: f64,
}

impl MotionFacts {
    /// True for a kick by the left foot.
    pub fn kicks_left(&self) -> bool {
        self.kick_foot == 0
    }

    /// Times from frame `frame` on, which may lie after either; `dt_s` is the time between two frames `[s]`.
    pub fn times_from(&self, frame: usize, dt_s: f64) -> KickTimes {
        let until = |event: usize| (event as f64 - frame as f64) * dt_s;
        KickTimes { to_strike_s: until(self.strike_frame), to_contact_s: until(self.contact_frame) }
    }

    /// The facts of a clip of a robot with `bodies` bodies; `anchor` and `foot`, the labeled one, are bodies.
    pub(super) fn of(clip: &ReferenceClip, bodies: usize, anchor: usize, foot: usize) -> Self {
        let speed = |t: usize| clip.body_com_vel[t * bodies + foot].iter().map(|v| v * v).sum::<f64>().sqrt();
        let fastest = (1..clip.frames).fold(0, |best, t| if speed(t) > speed(best) { t } else { best });
        let strike = clip.strike_frame.unwrap_or(fastest);
        let start = clip.body_pos[anchor];
        let end = clip.body_pos[(clip.frames - 1) * bodies + anchor];
        let [w, x, y, z] = clip.body_quat[anchor];
        Self {
            name: clip.name.clone(),
            frames: clip.frames,
            kick_foot: clip.kick_foot,
            strike_frame: strike,
            contact_frame: strike,
            strike_speed: speed(strike),
            start_xy: [start[0], start[1]],
            base_xy: [clip.body_pos[0][0], clip.body_pos[0][1]],
            heading: (2.0 * (w * z + x * y)).atan2(1.0 - 2.0 * (y * y + z * z)),
            displacement: [end[0] - start[0], end[1] - start[1]],
        }
    }
}
