//! Ball and goal as a camera finds them: delayed, at the camera's rate, not always.

use paid_lanes::rng::Rng;
use paid_lanes::{Mat3, Real, Vec3};
use paid_physics::{BodyState, GroupState};
use paid_policy::Pose;

use crate::config::TaskConfig;
use crate::group::GroupTask;
use crate::observe::{base_pose, in_base};

/// What a group's cameras found, newest first.
#[derive(Clone, Debug)]
pub(crate) struct CameraState<V> {
    /// Ball and goal as they were last found, in the preset's [`crate::preset::MemoryFrame`] at capture time `[m]`; entry `k` is
    /// `k` control steps old.
    found: Vec<[Vec3<V>; 2]>,
    /// Age of what the policy sees `[control steps]`, a whole number.
    latency: V,
    /// Control steps until the next capture.
    next_capture: V,
}

impl<V: Real> CameraState<V> {
    /// Where the preset has a camera.
    pub(crate) fn new(config: &TaskConfig) -> Option<Self> {
        let preset = &config.preset.observations.perception;
        let oldest = (preset.latency_s[1] / config.dt_s).round() as usize;
        preset.has_camera().then(|| Self {
            found: vec![[Vec3::zero(); 2]; oldest + 1],
            latency: V::zero(),
            next_capture: V::zero(),
        })
    }

    pub(crate) fn fields(&mut self) -> Vec<&mut V> {
        let mut fields = vec![&mut self.latency, &mut self.next_capture];
        fields.extend(self.found.iter_mut().flatten().flat_map(|object| object.0.iter_mut()));
        fields
    }

    /// Begins an episode in one lane: ball and goal (base frame `[m]`) were found at rest before it.
    pub(crate) fn reset_lane(
        &mut self,
        lane: usize,
        objects: [[f64; 3]; 2],
        base: &Pose<f64>,
        config: &TaskConfig,
        rng: &mut Rng,
    ) {
        let preset = &config.preset.observations.perception;
        let latency = rng.uniform(preset.latency_s[0], preset.latency_s[1]);
        self.latency.set_lane(lane, (latency / config.dt_s).round().min((self.found.len() - 1) as f64));
        self.next_capture.set_lane(lane, rng.uniform(0.0, preset.frame_s / config.dt_s));
        for (k, object) in objects.into_iter().enumerate() {
            let sigma: f64 =
                if preset.gaussian { preset.noise().deviation(0.0, Vec3(object).norm()) } else { 0.0 };
            let seen = object.map(|x| x + sigma * rng.normal());
            let kept = preset.memory_frame.keep(base, Vec3(seen)).0;
            self.found.iter_mut().for_each(|found| found[k].set_lane(lane, kept));
        }
    }

    /// Ball and goal as the policy sees them now, as they were kept.
    pub(crate) fn seen(&self) -> [Vec3<V>; 2] {
        let mut seen = self.found[0];
        for lane in 0..V::LANES {
            let old = &self.found[self.latency.lane(lane) as usize];
            for k in 0..2 {
                seen[k].set_lane(lane, old[k].lane(lane));
            }
        }
        seen
    }
}

/// The pose of a body in one lane.
fn lane_pose<V: Real>(body: &BodyState<V>, lane: usize) -> Pose<f64> {
    Pose { pos: Vec3(body.pos.lane(lane)), rot: Mat3(body.rot.0.map(|row| row.map(|x| x.lane(lane)))) }
}

impl<V: Real> GroupTask<V> {
    /// A control step of the cameras, one random stream per lane.
    pub(crate) fn capture(&mut self, config: &TaskConfig, state: &GroupState<V>, rngs: &mut [Rng]) {
        let Some(camera) = &mut self.camera else { return };
        let preset = &config.preset.observations.perception;
        let view = preset.camera.geometry();
        let (base, anchor) = (&state.bodies[0], &state.bodies[config.followed[config.anchor]]);
        let truth = [in_base(state, state.ball.pos), in_base(state, self.goal)];
        let speeds = [(state.ball.vel - base.lin_vel).norm(), base.lin_vel.norm()];
        let in_anchor = anchor.rot.tr_mul_vec(state.ball.pos - anchor.pos);
        camera.found.rotate_right(1);
        camera.found[0] = camera.found[1.min(camera.found.len() - 1)];
        let period = (preset.frame_s / config.dt_s).max(1.0);
        for (lane, rng) in rngs.iter_mut().enumerate().take(V::LANES) {
            let wait = camera.next_capture.lane(lane) - 1.0;
            // Half a control step of play: a picture is taken at the control step nearest to its time.
            let captured = wait < 0.5;
            camera.next_capture.set_lane(lane, if captured { wait + period } else { wait });
            for k in 0..2 {
                let exact = truth[k].lane(lane);
                let distance = Vec3(exact).norm();
                let [near, far] = [self.memory.near, self.memory.far].map(|x| x.lane(lane));
                let hidden = k == 0
                    && (preset.blind_zone && !(near..=far).contains(&distance)
                        || preset.visible_band && !view.sees(Vec3(in_anchor.lane(lane))));
                // Drawn whether needed or not, so that one option does not shift the numbers of another.
                let lost = rng.unit() < preset.dropout;
                let noise = [rng.normal(), rng.normal(), rng.normal()];
                if !captured || hidden || lost || exact.iter().any(|x| !x.is_finite()) {
                    continue;
                }
                let sigma: f64 = if preset.gaussian {
                    preset.noise().deviation(speeds[k].lane(lane), distance)
                } else {
                    0.0
                };
                let seen = Vec3([0, 1, 2].map(|i| exact[i] + sigma * noise[i]));
                let kept = preset.memory_frame.keep(&lane_pose(base, lane), seen);
                camera.found[0][k].set_lane(lane, kept.0);
            }
        }
    }

    /// Ball and goal in the base frame `[m]`, as cameras or memory have them where the preset says so.
    pub(crate) fn remembered(&self, config: &TaskConfig, state: &GroupState<V>) -> [Vec3<V>; 2] {
        let preset = &config.preset.observations.perception;
        let base = base_pose(state);
        let mut objects = [in_base(state, state.ball.pos), in_base(state, self.goal)];
        if let Some(camera) = &self.camera {
            objects = camera.seen().map(|kept| preset.memory_frame.recall(&base, kept));
        } else if preset.blind_zone {
            objects[0] = self.memory.ball(&base, preset.memory_frame);
        }
        objects
    }
}
