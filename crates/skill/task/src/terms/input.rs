//! What a reward or termination term reads.

use paid_lanes::{Real, Vec3};
use paid_physics::{BallState, BodyState, GroupState};
use paid_policy::{Pose, ReferenceView};

use crate::TaskPreset;
use crate::config::TaskConfig;
use crate::group::GroupTask;
use crate::references::tracking::TrackingErrors;
use crate::scene::kick::{KickStep, is_set};

/// A group of environments after a control step, one per lane.
#[derive(Clone, Copy, Debug)]
pub struct TermInput<'a, V: Real> {
    /// Indices and limits of the robot, and the preset.
    pub(crate) config: &'a TaskConfig,
    /// Robot and ball.
    pub(crate) state: &'a GroupState<V>,
    /// Actions, reference, goal and kick, this step's contact taken in.
    pub(crate) group: &'a GroupTask<V>,
    /// Differences between robot and reference; zeros in a task without a reference.
    pub(crate) tracking: &'a TrackingErrors<V>,
    /// What the step added to the kick; nothing in a scene without a ball.
    pub(crate) kick: KickStep<V>,
}

impl<'a, V: Real> TermInput<'a, V> {
    /// The preset.
    #[inline(always)]
    pub fn preset(&self) -> &'a TaskPreset {
        &self.config.preset
    }

    /// Control period `[s]`.
    #[inline(always)]
    pub fn dt_s(&self) -> f64 {
        self.config.dt_s
    }

    /// Joints, bodies, contact forces and the ball, in the order of the robot's model, world axes.
    #[inline(always)]
    pub fn state(&self) -> &'a GroupState<V> {
        self.state
    }

    /// The robot's base, world axes.
    #[inline(always)]
    pub fn base(&self) -> &'a BodyState<V> {
        &self.state.bodies[0]
    }

    /// The robot's anchor body (its torso), world axes.
    #[inline(always)]
    pub fn anchor(&self) -> &'a BodyState<V> {
        &self.state.bodies[self.config.followed[self.config.anchor]]
    }

    /// The left (0) or right (1) foot, world axes.
    #[inline(always)]
    pub fn foot(&self, side: usize) -> &'a BodyState<V> {
        self.config.foot(self.state, side)
    }

    /// Number of the left (0) or right (1) foot among the bodies and contact forces of [`TermInput::state`].
    #[inline(always)]
    pub fn foot_body(&self, side: usize) -> usize {
        self.config.foot_body(side)
    }

    /// The robot's end effector number `i`, in the order of `end_effectors` in its TOML (G1: left foot, right foot, left hand, right hand),
    /// world axes.
    ///
    /// # Panics
    /// If there are fewer.
    #[inline(always)]
    pub fn end_effector(&self, i: usize) -> &'a BodyState<V> {
        &self.state.bodies[self.config.followed[self.config.end_effectors[i]]]
    }

    /// For each joint of the policy its number in [`TermInput::state`].
    #[inline(always)]
    pub fn policy_joints(&self) -> &'a [usize] {
        &self.config.to_model
    }

    /// The action of this step, `[joints]`, policy order.
    #[inline(always)]
    pub fn action(&self) -> &'a [V] {
        &self.group.action
    }

    /// The action of the step before, `[joints]`, policy order; zeros in an episode's first step.
    #[inline(always)]
    pub fn previous_action(&self) -> &'a [V] {
        &self.group.previous
    }

    /// The reference's frame that the step is scored against, as the policy sees it. Without a reference the robot's default pose.
    #[inline(always)]
    pub fn reference(&self) -> ReferenceView<'a, V> {
        self.group.reference.view(self.config.anchor)
    }

    /// The left (0) or right (1) foot in the reference's frame: its pose, and the velocity of its center of mass `[m/s]`; world axes.
    #[inline(always)]
    pub fn reference_foot(&self, side: usize) -> (Pose<V>, Vec3<V>) {
        let (reference, foot) = (&self.group.reference, self.config.feet[side]);
        (Pose { pos: reference.pos(foot), rot: reference.rot(foot) }, reference.com_vel(foot))
    }

    /// Time from the frame that the step is scored against to the reference's strike, negative after it, infinite without a
    /// reference `[s]`.
    #[inline(always)]
    pub fn to_strike_s(&self) -> V {
        self.group.to_strike_s
    }

    /// The ball, world axes.
    #[inline(always)]
    pub fn ball(&self) -> &'a BallState<V> {
        &self.state.ball
    }

    /// Where the ball was before the robot touched it, world `[m]`.
    #[inline(always)]
    pub fn ball_before(&self) -> Vec3<V> {
        self.group.kick.before
    }

    /// Center of the goal, world `[m]`.
    #[inline(always)]
    pub fn goal(&self) -> Vec3<V> {
        self.group.goal
    }

    /// Where the robot has touched the ball in this episode.
    #[inline(always)]
    pub fn touched(&self) -> V::Mask {
        is_set(self.group.kick.touched)
    }

    /// Control steps since the first contact; 0 before it.
    #[inline(always)]
    pub fn steps_since_contact(&self) -> V {
        self.group.kick.since
    }

    /// The foot that should kick: -1 left, 1 right, 0 either.
    #[inline(always)]
    pub fn kicking_foot(&self) -> V {
        self.group.kick.label
    }

    /// What this step added to the kick.
    #[inline(always)]
    pub fn kick(&self) -> &KickStep<V> {
        &self.kick
    }
}
