//! What there is to see, independent of who shows it. World axes with z up, SI units, joints and bodies in model order.

use paid_lanes::{Quat, Vec3};
use paid_motion::Clip;
use paid_retarget::HumanMotion;
use paid_robot::{RobotModel, RobotSpec};

use paid_plot::Pose;

/// Where a human stands from the robot that follows `[m]`.
pub const BESIDE: [f64; 3] = [0.0, 1.2, 0.0];
/// Contact forces below this are not shown `[N]`.
pub const LEAST_FORCE_N: f64 = 5.0;
/// For how long the trail of a motion's kicking foot is shown `[s]`.
const FOOT_TRAIL_S: f64 = 0.5;

/// Origins `[m]` and frames (row-major) of the bodies.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BodyPoses {
    /// Origins, world `[m]`.
    pub pos: Vec<[f64; 3]>,
    /// Body frames in the world, row-major.
    pub rot: Vec<[[f64; 3]; 3]>,
}

impl BodyPoses {
    /// From origins and quaternions w, x, y, z.
    pub fn new(pos: &[[f64; 3]], quat: &[[f64; 4]]) -> Self {
        Self { pos: pos.to_vec(), rot: quat.iter().map(|q| Quat(*q).to_mat().0).collect() }
    }
}

/// One moment. Lists that were not measured are empty.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Robot, ball and goal; the latter two only mean something if the footage has a ball.
    pub pose: Pose,
    /// The reference motion at this moment.
    pub ghost: Option<BodyPoses>,
    /// The point whose trail is shown: the ball, or the kicking foot `[m]`.
    pub mark: [f64; 3],
    /// Its speed `[m/s]`.
    pub mark_speed: f64,
    /// Net contact force on each body, world axes `[N]`.
    pub contact_force: Vec<[f64; 3]>,
    /// Force of the robot on the ball `[N]`.
    pub ball_force: [f64; 3],
    /// Joint angles `[rad]`.
    pub joint_pos: Vec<f64>,
    /// Joint angles of the reference `[rad]`.
    pub reference_pos: Vec<f64>,
    /// Joint speeds `[rad/s]`.
    pub joint_vel: Vec<f64>,
    /// Actuator torques `[N m]`.
    pub joint_torque: Vec<f64>,
    /// Reward terms of the step, weighted, order of [`paid_task::reward_names`].
    pub rewards: Vec<f64>,
}

impl Frame {
    /// Forces as arrows: where, and how much `[N]`.
    pub fn arrows(&self) -> Vec<([f64; 3], [f64; 3])> {
        let bodies = self.pose.pos.iter().zip(&self.contact_force);
        let mut arrows: Vec<_> =
            bodies.filter(|(_, f)| Vec3(**f).norm() >= LEAST_FORCE_N).map(|(at, f)| (*at, *f)).collect();
        if Vec3(self.ball_force).norm() >= LEAST_FORCE_N {
            arrows.push((self.pose.ball, self.ball_force));
        }
        arrows
    }
}

/// A recording of a motion or of an episode.
#[derive(Clone, Debug)]
pub struct Footage {
    /// What it shows.
    pub name: String,
    /// The robot.
    pub model: RobotModel,
    /// Time between frames `[s]`.
    pub dt_s: f64,
    /// At least one.
    pub frames: Vec<Frame>,
    /// Radius of the ball `[m]`; `None` without ball and goal.
    pub ball_radius_m: Option<f64>,
    /// Half the goal's width `[m]`.
    pub goal_half_width_m: f64,
    /// True for an episode, false for a motion.
    pub episode: bool,
    /// For how long the mark's trail is shown `[s]`.
    pub trail_s: f64,
    /// The human that the robot follows, at the footage's frame rate.
    pub human: Option<HumanMotion>,
    /// What happened at which frame.
    pub events: Vec<(usize, String)>,
}

impl Footage {
    /// A motion, with the human that it was made from.
    pub fn of_motion(model: &RobotModel, spec: &RobotSpec, clip: &Clip, human: Option<HumanMotion>) -> Self {
        let foot = model.body_index(&spec.feet[clip.kick_leg.index()]).unwrap_or(0);
        let frame = |t: usize| {
            let BodyPoses { pos, rot } = BodyPoses::new(clip.body_pos(t), clip.body_quat(t));
            Frame {
                mark: pos[foot],
                mark_speed: Vec3(clip.body_lin_vel(t)[foot]).norm(),
                pose: Pose {
                    step: t as u32,
                    pos,
                    rot,
                    ball: [0.0; 3],
                    goal: [0.0; 3],
                    heading: 0.0,
                    kicked: clip.kick_frame.is_some_and(|kick| t >= kick),
                },
                ghost: None,
                contact_force: Vec::new(),
                ball_force: [0.0; 3],
                joint_pos: clip.joint_pos(t).to_vec(),
                reference_pos: Vec::new(),
                joint_vel: clip.joint_vel(t).to_vec(),
                joint_torque: Vec::new(),
                rewards: Vec::new(),
            }
        };
        let kick = clip.kick_frame.map(|t| (t, format!("kick, {} foot", clip.kick_leg)));
        Self {
            name: clip.name.clone(),
            model: model.clone(),
            dt_s: 1.0 / clip.fps,
            frames: (0..clip.frames).map(frame).collect(),
            ball_radius_m: None,
            goal_half_width_m: 0.0,
            episode: false,
            trail_s: FOOT_TRAIL_S,
            human,
            events: kick.into_iter().collect(),
        }
    }

    /// Time from the first to the last frame `[s]`.
    pub fn duration_s(&self) -> f64 {
        self.frames.len().saturating_sub(1) as f64 * self.dt_s
    }

    /// Time of a frame `[s]`.
    pub fn time_s(&self, t: usize) -> f64 {
        t as f64 * self.dt_s
    }

    /// The mark's way up to frame `t`, at most `longest_s` of it; empty if the mark is a ball that is not there.
    pub fn trail(&self, t: usize, longest_s: f64) -> Vec<[f64; 3]> {
        if self.episode && self.ball_radius_m.is_none() {
            return Vec::new();
        }
        let back = (self.trail_s.min(longest_s) / self.dt_s).round() as usize;
        self.frames[t.saturating_sub(back)..t].iter().map(|f| f.mark).collect()
    }

    /// The human's bones at frame `t`: both ends `[m]`, next to the robot, and whether the second is the head. Empty without a human.
    pub fn human(&self, t: usize) -> Vec<([[f64; 3]; 2], bool)> {
        let Some(human) = &self.human else { return Vec::new() };
        let pos = human.pos(t.min(human.frames - 1));
        let place = |p: [f64; 3]| (Vec3(p) + Vec3(BESIDE)).0;
        let mut bones = Vec::new();
        for (i, bone) in human.skeleton.bones.iter().enumerate() {
            let Some(parent) = bone.parent else { continue };
            // A root that lies on the floor below the hips is no part of the body.
            if parent == 0 && pos[parent][2] < 0.2 {
                continue;
            }
            bones.push(([place(pos[parent]), place(pos[i])], bone.name.eq_ignore_ascii_case("head")));
        }
        bones
    }
}
