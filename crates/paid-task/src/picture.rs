//! Ball and goal from a camera's pictures: late, at the camera's rate, not always found.

use paid_lanes::rng::Rng;
use paid_lanes::{Real, Vec3};
use paid_physics::GroupState;

use crate::config::TaskConfig;
use crate::group::GroupTask;
use crate::observe::{Seen, in_base};
use crate::perception::deviation;

/// What a group's cameras saw, newest first.
#[derive(Clone, Debug)]
pub(crate) struct Pictures<V> {
    /// Ball and goal as they were last found, base frame of then [m]; entry `k` is `k` control steps old.
    found: Vec<[Vec3<V>; 2]>,
    /// Age of what the policy sees [control steps], a whole number.
    latency: V,
    /// Control steps until the next picture.
    due: V,
}

impl<V: Real> Pictures<V> {
    /// Where the preset has a camera.
    pub(crate) fn new(config: &TaskConfig) -> Option<Self> {
        let preset = &config.preset.observations.perception;
        let oldest = (preset.latency_s[1] / config.dt_s).round() as usize;
        preset.pictures().then(|| Self {
            found: vec![[Vec3::zero(); 2]; oldest + 1],
            latency: V::zero(),
            due: V::zero(),
        })
    }

    pub(crate) fn fields(&mut self) -> Vec<&mut V> {
        let mut fields = vec![&mut self.latency, &mut self.due];
        fields.extend(self.found.iter_mut().flatten().flat_map(|object| object.0.iter_mut()));
        fields
    }

    /// Begins an episode in one lane: ball and goal (base frame) were found at rest before it.
    pub(crate) fn reset_lane(
        &mut self,
        lane: usize,
        objects: [[f64; 3]; 2],
        config: &TaskConfig,
        rng: &mut Rng,
    ) {
        let preset = &config.preset.observations.perception;
        let latency = rng.uniform(preset.latency_s[0], preset.latency_s[1]);
        self.latency.set_lane(lane, (latency / config.dt_s).round().min((self.found.len() - 1) as f64));
        self.due.set_lane(lane, rng.uniform(0.0, preset.frame_s / config.dt_s));
        for (k, object) in objects.into_iter().enumerate() {
            let sigma: f64 = if preset.gaussian { deviation(0.0, Vec3(object).norm(), preset) } else { 0.0 };
            let seen = object.map(|x| x + sigma * rng.normal());
            self.found.iter_mut().for_each(|found| found[k].set_lane(lane, seen));
        }
    }

    /// What the policy sees now.
    pub(crate) fn seen(&self) -> Seen<V> {
        let [mut ball, mut goal] = self.found[0];
        for lane in 0..V::LANES {
            let [old_ball, old_goal] = &self.found[self.latency.lane(lane) as usize];
            ball.set_lane(lane, old_ball.lane(lane));
            goal.set_lane(lane, old_goal.lane(lane));
        }
        Seen { ball, goal }
    }
}

impl<V: Real> GroupTask<V> {
    /// A control step of the cameras, a random stream a lane.
    pub(crate) fn look(&mut self, config: &TaskConfig, state: &GroupState<V>, rngs: &mut [Rng]) {
        let Some(pictures) = &mut self.pictures else { return };
        let preset = &config.preset.observations.perception;
        let (base, anchor) = (&state.bodies[0], &state.bodies[config.followed[config.anchor]]);
        let truth = [in_base(state, state.ball.pos), in_base(state, self.goal)];
        let speeds = [(state.ball.vel - base.lin_vel).norm(), base.lin_vel.norm()];
        let in_anchor = anchor.rot.tr_mul_vec(state.ball.pos - anchor.pos);
        pictures.found.rotate_right(1);
        pictures.found[0] = pictures.found[1.min(pictures.found.len() - 1)];
        let period = (preset.frame_s / config.dt_s).max(1.0);
        for (lane, rng) in rngs.iter_mut().enumerate().take(V::LANES) {
            let due = pictures.due.lane(lane) - 1.0;
            // Half a control step of play: a picture is taken at the control step nearest to its time.
            let taken = due < 0.5;
            pictures.due.set_lane(lane, if taken { due + period } else { due });
            for k in 0..2 {
                let exact = truth[k].lane(lane);
                let distance = Vec3(exact).norm();
                let [near, far] = [self.perception.near, self.perception.far].map(|x| x.lane(lane));
                let hidden = k == 0
                    && (preset.blind_zone && !(near..=far).contains(&distance)
                        || preset.visible_band && !preset.camera.sees(in_anchor.lane(lane)));
                // Drawn whether needed or not, so that one option does not shift the numbers of another.
                let lost = rng.unit() < preset.dropout;
                let noise = [rng.normal(), rng.normal(), rng.normal()];
                if !taken || hidden || lost || exact.iter().any(|x| !x.is_finite()) {
                    continue;
                }
                let sigma: f64 =
                    if preset.gaussian { deviation(speeds[k].lane(lane), distance, preset) } else { 0.0 };
                pictures.found[0][k].set_lane(lane, [0, 1, 2].map(|i| exact[i] + sigma * noise[i]));
            }
        }
    }
}
