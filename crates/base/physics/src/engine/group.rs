//! The state and parameters of one group of lanes, and the scratch memory of a step.

use paid_lanes::{Quat, Real, Vec3};

use super::articulated::{Articulated, BaseFactor};
use super::ball::BallWork;
use super::foot::Foot;
use super::forces::BodyForces;
use super::layout::ModelLayout;
use super::pairs::PairTouch;
use super::params::GroupParams;
use super::sole::Sole;
use super::spatial::{Kin, Motion, Rigid};
use super::touch::BallTouch;
use crate::GroupState;

/// Dynamic state of `LANES` environments.
#[derive(Clone, Debug)]
pub(crate) struct Group<V: Real> {
    pub pos: Vec3<V>,
    pub quat: Quat<V>,
    /// Velocity of the base origin, and angular velocity, world axes.
    pub vel: Vec3<V>,
    pub omega: Vec3<V>,
    pub q: Vec<V>,
    pub qd: Vec<V>,
    pub ball_pos: Vec3<V>,
    pub ball_vel: Vec3<V>,
    pub ball_omega: Vec3<V>,
    /// Sole impulses in the contact frames of the last step, per point, left and right.
    pub warm: Vec<[[V; 3]; 2]>,
    pub params: GroupParams<V>,
    pub state: GroupState<V>,
    /// One bit per lane: reset since the last step.
    pub reset: u32,
}

/// What the inward pass leaves of a joint.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JointWork<V> {
    pub axis: Motion<V>,
    /// `I S / D`, six numbers, angular first.
    pub gain: [V; 6],
    /// `1 / D`, the joint's reciprocal articulated inertia.
    pub inv: V,
    /// Joint torque less bias `[N m]`.
    pub torque: V,
    /// Half-solved impulse on this joint of all contacts but the soles' (at the end of the step: of all).
    pub impulse: V,
    /// The part of it that the feet's velocities do not yet contain.
    pub pending: V,
    /// Half-solved impulse of the soles, while other contacts need it.
    pub sole_impulse: V,
}

/// Scratch memory of one physics step; one for all groups.
#[derive(Clone, Debug)]
pub(crate) struct Work<V: Real> {
    /// Joint targets of a physics step.
    pub targets: Vec<V>,
    pub base: Kin<V>,
    /// Of each chain's last link.
    pub kin: Vec<Kin<V>>,
    pub joints: Vec<JointWork<V>>,
    /// Of the links on the current path, by the number of joints before theirs.
    pub rigid: Vec<Rigid<V>>,
    /// Sine and cosine of each joint angle.
    pub trig: Vec<[V; 2]>,
    pub art: Vec<Articulated<V>>,
    pub base_art: Articulated<V>,
    pub factor: BaseFactor<V>,
    /// Half-solved free impulse of the base.
    pub base_free: [V; 6],
    /// Half-solved contact impulses of the base, see [`JointWork::impulse`].
    pub base_impulse: [V; 6],
    /// See [`JointWork::pending`].
    pub base_pending: [V; 6],
    /// See [`JointWork::sole_impulse`].
    pub base_sole_impulse: [V; 6],
    /// Base acceleration change from turning axes, times the step: added to the base's linear velocity.
    pub gyro: Vec3<V>,
    /// Velocity change of each chain's last link over the step.
    pub change: Vec<Motion<V>>,
    /// Velocity of each body.
    pub vel: Vec<Motion<V>>,
    /// Ends of the capsules, relative to the base.
    pub ends: Vec<[Vec3<V>; 2]>,
    pub feet: [Foot<V>; 2],
    /// Velocity of foot 1 (columns) per impulse on foot 0 (rows).
    pub cross: [[V; 6]; 6],
    pub soles: Vec<[Sole<V>; 2]>,
    /// The ball's velocity, on its way to the end of the step.
    pub ball: BallWork<V>,
    /// Contacts of the ball with the base, then one per chain, then a second one per leg.
    pub touches: Vec<BallTouch<V>>,
    pub pairs: Vec<PairTouch<V>>,
    /// Net contact forces over the physics step.
    pub forces: BodyForces<V>,
}

impl<V: Real> Work<V> {
    pub fn new(layout: &ModelLayout<V::Scalar>) -> Self {
        let joint = JointWork {
            axis: Motion::zero(),
            gain: [V::zero(); 6],
            inv: V::zero(),
            torque: V::zero(),
            impulse: V::zero(),
            pending: V::zero(),
            sole_impulse: V::zero(),
        };
        let z = V::zero();
        let rigid = Rigid {
            mass: z,
            first: Vec3::zero(),
            second: super::spatial::Sym3([z; 6]),
            bias: super::spatial::Force::zero(),
        };
        let n = layout.links.len();
        let foot = |f: usize| Foot::new(layout.paths[layout.legs[f]].len());
        let mut touches = vec![BallTouch::new(0)];
        let legs = layout.legs.iter().map(|&leg| &layout.paths[leg]);
        touches.extend(layout.paths.iter().chain(legs).map(|p| BallTouch::new(p.len())));
        Self {
            targets: vec![z; n],
            base: Kin::zero(),
            kin: vec![Kin::zero(); layout.chains.len()],
            joints: vec![joint; n],
            rigid: vec![rigid; layout.paths.iter().map(Vec::len).max().unwrap_or(0)],
            trig: vec![[z; 2]; n],
            art: vec![Articulated::zero(); layout.chains.len()],
            base_art: Articulated::zero(),
            factor: BaseFactor::zero(),
            base_free: [z; 6],
            base_impulse: [z; 6],
            base_pending: [z; 6],
            base_sole_impulse: [z; 6],
            gyro: Vec3::zero(),
            change: vec![Motion::zero(); layout.chains.len()],
            vel: vec![Motion::zero(); n + 1],
            ends: vec![[Vec3::zero(); 2]; layout.capsules.len()],
            feet: [foot(0), foot(1)],
            cross: [[z; 6]; 6],
            soles: vec![[Sole::new(), Sole::new()]; layout.soles.len()],
            ball: BallWork::new(),
            touches,
            pairs: layout
                .pairs
                .iter()
                .map(|g| PairTouch::new(layout.paths[g.chains[0]].len(), layout.paths[g.chains[1]].len()))
                .collect(),
            forces: BodyForces::new(n + 1),
        }
    }
}
