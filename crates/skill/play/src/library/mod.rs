//! Reference motions, packed for gathering one frame a lane.

mod clip;

use std::collections::BTreeMap;

use paid_lanes::{Quat, Vec3};
use paid_motion::{MotionLibrary, ball_ahead};
use paid_robot::kinematics::forward;
use paid_robot::{Permutation, RobotModel, RobotSpec};

use crate::{OwnPlace, PlayError, PlayPreset};

pub use clip::{KickTimes, MotionFacts, ReferenceClip};

/// Positions of values in a packed frame: joint angles, joint velocities (policy order), then 13 numbers a followed body: position,
/// quaternion, center-of-mass velocity, angular velocity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameLayout {
    /// Number of joints.
    pub joints: usize,
    /// Number of followed bodies.
    pub bodies: usize,
}

impl FrameLayout {
    /// Numbers a followed body.
    pub const BODY: usize = 13;
    /// Numbers a frame.
    pub fn len(self) -> usize {
        2 * self.joints + Self::BODY * self.bodies
    }
    /// True if a frame holds nothing.
    pub fn is_empty(self) -> bool {
        self.len() == 0
    }
}

/// The motions of a policy. Each has one frame more than its clip: the last pose at rest, for holding it.
#[derive(Clone, Debug)]
pub struct ReferenceLibrary {
    clips: Vec<ReferenceClip>,
    facts: Vec<MotionFacts>,
    layout: FrameLayout,
    /// Model index of each followed body: the tracked bodies, then what else anchor, feet and end effectors add.
    followed: Vec<usize>,
    first_frame: Vec<usize>,
    packed: Vec<f32>,
    standing: bool,
}

/// Nominal place of the ball ahead of a robot without a reference: within the paper's workspace `[m]`.
pub const STANDING_BALL_M: f64 = 1.0;

/// Model index of a body. `role` is for the error.
///
/// # Errors
/// If the robot has none of this name.
pub fn body_index(robot: &RobotModel, role: &'static str, name: &str) -> Result<usize, PlayError> {
    robot.body_index(name).ok_or_else(|| PlayError::Name { role, name: name.to_owned() })
}

/// Model indices of the followed bodies: tracked bodies first, in the specification's order.
///
/// # Errors
/// If a name of `spec` is not in `robot`.
pub fn followed_bodies(robot: &RobotModel, spec: &RobotSpec) -> Result<Vec<usize>, PlayError> {
    let mut followed = Vec::new();
    for name in &spec.tracked_bodies {
        followed.push(body_index(robot, "tracked body", name)?);
    }
    let anchor = [("anchor body", &spec.anchor_body)];
    let feet = spec.feet.iter().map(|n| ("foot", n));
    let ends = spec.end_effectors.iter().map(|n| ("end effector", n));
    for (role, name) in anchor.into_iter().chain(feet).chain(ends) {
        let body = body_index(robot, role, name)?;
        if !followed.contains(&body) {
            followed.push(body);
        }
    }
    Ok(followed)
}

impl ReferenceLibrary {
    /// Packs clips for a robot.
    ///
    /// # Errors
    /// If there is no clip, an array has the wrong length or holds a number that is not finite, or a name of `spec` is
    /// not in `robot`.
    pub fn new(clips: Vec<ReferenceClip>, robot: &RobotModel, spec: &RobotSpec) -> Result<Self, PlayError> {
        if clips.is_empty() {
            return Err(PlayError::Library("expected at least one motion, found none".into()));
        }
        let followed = followed_bodies(robot, spec)?;
        let anchor = body_index(robot, "anchor body", &spec.anchor_body)?;
        let feet = [body_index(robot, "foot", &spec.feet[0])?, body_index(robot, "foot", &spec.feet[1])?];
        let to_policy = Permutation::between(&robot.joint_names(), &spec.policy_joint_order)
            .map_err(|e| PlayError::Robot(format!("policy_joint_order: {e}")))?;
        let layout = FrameLayout { joints: robot.joints.len(), bodies: followed.len() };
        let mut library = Self {
            facts: Vec::new(),
            layout,
            followed,
            first_frame: Vec::new(),
            packed: Vec::new(),
            standing: false,
            clips: Vec::new(),
        };
        for clip in clips {
            clip.check(robot)?;
            library.first_frame.push(library.packed.len() / layout.len());
            for t in 0..=clip.frames {
                library.pack(&clip, t.min(clip.frames - 1), t == clip.frames, to_policy.indices());
            }
            library.facts.push(MotionFacts::of(&clip, robot.bodies.len(), anchor, feet[clip.kick_foot]));
            library.clips.push(clip);
        }
        Ok(library)
    }

    /// Packs a library that was read from files.
    ///
    /// # Errors
    /// As [`ReferenceLibrary::new`].
    pub fn from_motions(
        motions: &MotionLibrary,
        robot: &RobotModel,
        spec: &RobotSpec,
    ) -> Result<Self, PlayError> {
        let clips = motions.clips.iter().map(|clip| ReferenceClip {
            name: clip.name.clone(),
            fps: clip.fps,
            kick_foot: clip.kick_leg.index(),
            strike_frame: clip.kick_frame,
            frames: clip.frames,
            joint_pos: clip.joint_pos.clone(),
            joint_vel: clip.joint_vel.clone(),
            body_pos: clip.body_pos.clone(),
            body_quat: clip.body_quat.clone(),
            body_com_vel: clip.body_lin_vel.clone(),
            body_ang_vel: clip.body_ang_vel.clone(),
        });
        Self::new(clips.collect(), robot, spec)
    }

    /// The same for a policy: its motions' own places ([`OwnPlace`]) and its contacts
    /// ([`ReferenceLibrary::with_contacts`]) are adopted.
    ///
    /// # Errors
    /// As [`ReferenceLibrary::from_motions`] and [`ReferenceLibrary::with_contacts`].
    pub fn for_play(
        motions: &MotionLibrary,
        robot: &RobotModel,
        spec: &RobotSpec,
        play: &PlayPreset,
    ) -> Result<Self, PlayError> {
        let library = Self::from_motions(motions, robot, spec)?;
        let library = match play.ball.own_place {
            OwnPlace::TorsoEnd => library,
            OwnPlace::Strike => library.with_balls_at_strike(robot, spec, play.ball_params.radius_m)?,
        };
        library.with_contacts(&play.ball.contact_s)
    }

    /// Puts each motion's nominal ball, of this radius `[m]`, ahead of its foot in the frame of the strike ([`ball_ahead`]).
    ///
    /// # Errors
    /// If a foot of `spec` is not in `robot`.
    pub fn with_balls_at_strike(
        mut self,
        robot: &RobotModel,
        spec: &RobotSpec,
        radius_m: f64,
    ) -> Result<Self, PlayError> {
        for (facts, clip) in self.facts.iter_mut().zip(&self.clips) {
            let foot = body_index(robot, "foot", &spec.feet[clip.kick_foot])?;
            let row = facts.strike_frame * robot.bodies.len() + foot;
            let (pos, quat, velocity) = (clip.body_pos[row], clip.body_quat[row], clip.body_com_vel[row]);
            let ball = ball_ahead(&robot.bodies[foot], pos, quat, velocity, radius_m);
            facts.displacement = [0, 1].map(|k| ball[k] - facts.start_xy[k]);
        }
        Ok(self)
    }

    /// The library of a task without a reference: the robot stands in its default pose, heading along x, with the nominal ball
    /// [`STANDING_BALL_M`] ahead. `dt_s` is the control period.
    ///
    /// # Errors
    /// If robot and specification do not fit.
    pub fn standing(robot: &RobotModel, spec: &RobotSpec, dt_s: f64) -> Result<Self, PlayError> {
        let control = spec.resolve(robot).map_err(|e| PlayError::Robot(e.to_string()))?;
        let base = Vec3([0.0, 0.0, spec.nominal_height_m]);
        let poses = forward(robot, base, Quat([1.0, 0.0, 0.0, 0.0]), &control.default_pos);
        // Two frames: an episode begins in the first one and leaves one to go to.
        let frames = 2;
        let clip = ReferenceClip {
            name: "standing".into(),
            fps: 1.0 / dt_s,
            kick_foot: 0,
            strike_frame: None,
            frames,
            joint_pos: control.default_pos.repeat(frames),
            joint_vel: vec![0.0; frames * robot.joints.len()],
            body_pos: poses.iter().map(|pose| pose.pos.0).collect::<Vec<_>>().repeat(frames),
            body_quat: poses.iter().map(|pose| pose.quat.0).collect::<Vec<_>>().repeat(frames),
            body_com_vel: vec![[0.0; 3]; frames * robot.bodies.len()],
            body_ang_vel: vec![[0.0; 3]; frames * robot.bodies.len()],
        };
        let mut library = Self::new(vec![clip], robot, spec)?;
        library.standing = true;
        let [facts] = &mut library.facts[..] else { unreachable!("one clip") };
        let (sin, cos) = facts.heading.sin_cos();
        facts.displacement = [STANDING_BALL_M * cos, STANDING_BALL_M * sin];
        Ok(library)
    }

    /// Adopts when a policy's foot meets the ball, in seconds from a motion's first frame, by the motion's name
    /// ([`crate::PlayedPlacement::contact_s`]). Names of other motions mean nothing here.
    ///
    /// # Errors
    /// If a time lies after its motion's end.
    pub fn with_contacts(mut self, contact_s: &BTreeMap<String, f64>) -> Result<Self, PlayError> {
        for (facts, clip) in self.facts.iter_mut().zip(&self.clips) {
            let Some(&time_s) = contact_s.get(&facts.name) else { continue };
            let frame = (time_s * clip.fps).round() as usize;
            if frame >= facts.frames {
                let end_s = (facts.frames - 1) as f64 / clip.fps;
                let expected = format!("times up to {end_s} s for '{}'", facts.name);
                return Err(PlayError::value("ball.contact_s", &expected, time_s));
            }
            facts.contact_frame = frame;
        }
        Ok(self)
    }

    /// True for [`ReferenceLibrary::standing`].
    pub fn is_standing(&self) -> bool {
        self.standing
    }

    fn pack(&mut self, clip: &ReferenceClip, t: usize, at_rest: bool, to_policy: &[usize]) {
        let joints = self.layout.joints;
        let bodies = clip.body_pos.len() / clip.frames;
        let speed = if at_rest { 0.0 } else { 1.0 };
        for &j in to_policy {
            self.packed.push(clip.joint_pos[t * joints + j] as f32);
        }
        for &j in to_policy {
            self.packed.push((clip.joint_vel[t * joints + j] * speed) as f32);
        }
        for &b in &self.followed {
            let row = t * bodies + b;
            self.packed.extend(clip.body_pos[row].map(|x| x as f32));
            self.packed.extend(clip.body_quat[row].map(|x| x as f32));
            self.packed.extend(clip.body_com_vel[row].map(|x| (x * speed) as f32));
            self.packed.extend(clip.body_ang_vel[row].map(|x| (x * speed) as f32));
        }
    }

    /// Number of motions.
    pub fn len(&self) -> usize {
        self.facts.len()
    }
    /// Never true: an empty library cannot be built.
    pub fn is_empty(&self) -> bool {
        self.facts.is_empty()
    }
    /// What is known of each motion.
    pub fn facts(&self) -> &[MotionFacts] {
        &self.facts
    }
    /// The clips as given.
    pub fn clips(&self) -> &[ReferenceClip] {
        &self.clips
    }
    /// Layout of a packed frame.
    pub fn layout(&self) -> FrameLayout {
        self.layout
    }
    /// Model indices of the followed bodies; the tracked ones come first.
    pub fn followed(&self) -> &[usize] {
        &self.followed
    }
    /// The packed frame `t` of a motion; beyond the last frame the last pose at rest.
    #[inline(always)]
    pub fn frame(&self, motion: usize, t: usize) -> &[f32] {
        let row = self.first_frame[motion] + t.min(self.facts[motion].frames);
        &self.packed[row * self.layout.len()..][..self.layout.len()]
    }
    /// Phase bins a motion: whole seconds of the longest clip, plus 1 (release).
    pub fn bins(&self) -> usize {
        let seconds = self.clips.iter().map(|c| (c.frames as f64 / c.fps) as usize).max();
        seconds.unwrap_or(0) + 1
    }
}
