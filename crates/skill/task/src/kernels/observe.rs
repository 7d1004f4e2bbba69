//! Observations of a group: the views of the simulated task, and where the terms' numbers go.

use paid_lanes::rng::fill_symmetric;
use paid_lanes::{Kernel, Real, Vec3, store_f32};
use paid_physics::GroupState;
use paid_policy::observation::{Sink, observe};
use paid_policy::{Pose, PrivilegedView, RobotView, SceneView, Views};
use paid_track::predicted_displacement;

use crate::config::TaskConfig;
use crate::group::{Delays, GroupTask};
use crate::scene::eyes::seen_scene;

/// Purpose of the noise stream among an environment's random numbers.
pub(crate) const NOISE_STREAM: u32 = 2;

/// Robot and bodies of a group in the order of the views.
#[derive(Clone, Debug)]
pub(crate) struct RobotBuffer<V> {
    joint_pos_rel: Vec<V>,
    joint_vel: Vec<V>,
    bodies: Vec<Pose<V>>,
}

impl<V: Real> RobotBuffer<V> {
    pub(crate) fn new(config: &TaskConfig) -> Self {
        let zeros = vec![V::zero(); config.joints()];
        Self {
            joint_pos_rel: zeros.clone(),
            joint_vel: zeros,
            bodies: vec![Pose::identity(); config.tracked],
        }
    }

    /// Reads the joints; `joint_offset` is the error of the encoders, model order `[rad]`.
    #[inline(always)]
    pub(crate) fn fill_joints(&mut self, config: &TaskConfig, state: &GroupState<V>, joint_offset: &[V]) {
        for j in 0..config.joints() {
            let m = config.to_model[j];
            self.joint_pos_rel[j] =
                state.joint_pos[m] - (joint_offset[m] + V::c(config.control.default_pos[m]));
            self.joint_vel[j] = state.joint_vel[m];
        }
    }

    #[inline(always)]
    fn fill_bodies(&mut self, config: &TaskConfig, state: &GroupState<V>) {
        for i in 0..config.tracked {
            let body = &state.bodies[config.followed[i]];
            self.bodies[i] = Pose { pos: body.pos, rot: body.rot };
        }
    }

    /// The readings of the robot's sensors; the joints must have been read.
    #[inline(always)]
    pub(crate) fn view<'a>(&'a self, state: &GroupState<V>, last_action: &'a [V]) -> RobotView<'a, V> {
        let base = &state.bodies[0];
        RobotView {
            base_rot: base.rot,
            base_ang_vel: base.rot.tr_mul_vec(base.ang_vel),
            joint_pos_rel: &self.joint_pos_rel,
            joint_vel: &self.joint_vel,
            last_action,
        }
    }

    #[inline(always)]
    fn privileged(&self, config: &TaskConfig, state: &GroupState<V>) -> PrivilegedView<'_, V> {
        let (base, anchor) = (&state.bodies[0], &state.bodies[config.followed[config.anchor]]);
        PrivilegedView {
            base_lin_vel: base.rot.tr_mul_vec(base.lin_vel),
            anchor: Pose { pos: anchor.pos, rot: anchor.rot },
            bodies: &self.bodies,
        }
    }
}

/// The base's pose.
#[inline(always)]
fn base_pose<V: Real>(state: &GroupState<V>) -> Pose<V> {
    Pose { pos: state.bodies[0].pos, rot: state.bodies[0].rot }
}

/// A world point in the base frame.
#[inline(always)]
fn in_base<V: Real>(state: &GroupState<V>, point: Vec3<V>) -> Vec3<V> {
    let base = &state.bodies[0];
    base.rot.tr_mul_vec(point - base.pos)
}

/// True ball and goal.
#[inline(always)]
fn true_scene<V: Real>(config: &TaskConfig, state: &GroupState<V>, group: &GroupTask<V>) -> SceneView<V> {
    let mut scene = SceneView::new(in_base(state, state.ball.pos), in_base(state, group.goal));
    if config.observations.predicts {
        let displacement = predicted_displacement(state.ball.vel, group.prediction_s);
        scene.ball_at_strike = in_base(state, state.ball.pos + displacement);
    }
    scene
}

/// A feature-major matrix seen from one lane group: each number is the group's lanes of the next row.
struct Rows<'a> {
    out: &'a mut [f32],
    stride: usize,
    at: usize,
}

impl<V: Real> Sink<V> for Rows<'_> {
    #[inline(always)]
    fn push(&mut self, value: V) {
        store_f32(value, &mut self.out[self.at..self.at + V::LANES]);
        self.at += self.stride;
    }
}

/// The policy's copy of a term: delayed, then noisy.
struct Disturbed<'a, 'r, V> {
    rows: &'a mut Rows<'r>,
    /// Delays, and the number of the term's first value among the sensed ones.
    delays: Option<(&'a Delays<V>, usize)>,
    /// Random numbers of the term, uniform in (-1, 1); empty for none.
    noise: &'a [V],
    half_width: V,
    next: usize,
}

impl<V: Real> Sink<V> for Disturbed<'_, '_, V> {
    #[inline(always)]
    fn push(&mut self, value: V) {
        let mut value = value;
        if let Some((delays, first)) = self.delays {
            value = delays.delayed(first + self.next, value);
        }
        if !self.noise.is_empty() {
            value = self.noise[self.next].mul_add(self.half_width, value);
        }
        self.rows.push(value);
        self.next += 1;
    }
}

/// Whose noise, and which draw of it.
pub(crate) struct Draw<'a, V> {
    /// Environment numbers, one per lane; empty for no noise.
    pub envs: &'a [u32],
    pub seed: u64,
    pub count: u64,
    /// Room for [`ObservationConfig::noisy`] numbers; zeros if there is no noise.
    pub values: &'a mut [V],
}

/// Writes the observations of a group.
pub(crate) struct Observe<'a, V> {
    pub config: &'a TaskConfig,
    pub state: &'a GroupState<V>,
    pub group: &'a mut GroupTask<V>,
    pub robot: &'a mut RobotBuffer<V>,
    pub draw: Draw<'a, V>,
    pub policy: &'a mut [f32],
    pub critic: &'a mut [f32],
    /// Empty without a discriminator.
    pub style: &'a mut [f32],
    /// Empty without a teacher.
    pub teacher: &'a mut [f32],
    pub stride: usize,
    pub first: usize,
}

impl<V: Real> Kernel for Observe<'_, V> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let (config, state, group) = (self.config, self.state, self.group);
        self.robot.fill_joints(config, state, &group.joint_offset);
        self.robot.fill_bodies(config, state);
        let mut truth = true_scene(config, state, group);
        let base = base_pose(state);
        let (mut seen, estimated_base) = match (&group.shown, &group.eyes) {
            (Some(shown), _) => (shown.scene, shown.base),
            (None, Some(eyes)) => {
                // The state is a frame before the one that it will be scored against.
                let times = [group.to_strike_s, group.to_contact_s].map(|time| time + V::c(config.dt_s));
                let predicts = config.observations.predicts;
                seen_scene(eyes, &config.preset.eyes, &state.bodies[0], group.goal, times, predicts)
            }
            (None, None) => (truth, base),
        };
        // The state is a frame before the one that it will be scored against.
        let to_strike_s = group.to_strike_s + V::c(config.dt_s);
        let [of_truth, of_belief] = &mut group.scene_memory;
        of_truth.show(&base, to_strike_s, &mut truth);
        of_belief.show(&estimated_base, to_strike_s, &mut seen);
        let views = Views {
            robot: self.robot.view(state, &group.action),
            privileged: Some(self.robot.privileged(config, state)),
            reference: Some(group.reference.view(config.anchor)),
            scene: Some(truth),
        };
        let mut rows = Rows { out: self.critic, stride: self.stride, at: self.first };
        observe(&config.observations.critic, &views, &mut rows);
        if config.observations.style_dim > 0 {
            let mut rows = Rows { out: self.style, stride: self.stride, at: self.first };
            observe(&config.observations.style, &views, &mut rows);
        }
        if config.observations.teacher_dim > 0 {
            let mut rows = Rows { out: self.teacher, stride: self.stride, at: self.first };
            observe(&config.observations.teacher, &views, &mut rows);
        }

        let views = Views { scene: Some(seen), ..views };
        let draw = self.draw;
        if !draw.envs.is_empty() {
            fill_symmetric(draw.values, draw.envs, NOISE_STREAM, draw.seed, draw.count);
        }
        let mut rows = Rows { out: self.policy, stride: self.stride, at: self.first };
        let mut noise: &[V] = draw.values;
        let mut sensed = 0;
        for term in &config.observations.policy {
            let delays = if term.sensed { group.delays.as_ref() } else { None };
            let mut out = Disturbed {
                rows: &mut rows,
                delays: delays.map(|delays| (delays, sensed)),
                noise: if term.half_width > 0.0 { noise } else { &[] },
                half_width: V::c(term.half_width),
                next: 0,
            };
            term.id.write(&views, &mut out);
            let written = out.next;
            if term.half_width > 0.0 {
                noise = &noise[written..];
            }
            if term.sensed {
                sensed += written;
            }
        }
    }
}
