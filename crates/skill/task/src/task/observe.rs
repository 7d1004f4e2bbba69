//! What the environments show: observations, and where ball and goal seem to be.

use paid_lanes::rng::Rng;
use paid_lanes::{MAX_LANES, Real};
use paid_physics::Simulator;
use paid_policy::SceneView;
use paid_track::predicted_displacement;

use super::{BLOCK_GROUPS, Task};
use crate::delay::Remember;
use crate::eyes::Look;
use crate::observe::{Draw, Observe};

/// Purposes of an environment's random streams.
const PERCEPTION_STREAM: u32 = 3;
const VELOCITY_STREAM: u32 = 4;

impl<V: Real, S: Simulator<V>> Task<V, S> {
    /// Writes observations, see [`paid_policy::VecEnv::observe`].
    pub(crate) fn observe_all(&mut self, out: &mut [&mut [f32]]) {
        let envs = self.envs.len();
        let layout = &self.config.layout;
        let sizes = [layout.policy_dim(), layout.critic_dim(), self.config.observations.style_dim];
        assert!(out.len() <= sizes.len(), "at most {} observation groups, found {}", sizes.len(), out.len());
        for (k, (out, size)) in out.iter().zip(sizes).enumerate() {
            assert_eq!(out.len(), size * envs, "observation group {k}");
        }
        let disturbed = self.disturbed();
        if !disturbed {
            self.noise.fill(V::zero());
        }
        // A group's rows are 32 or 64 bytes, `envs` numbers apart: written through a small matrix of a few groups, so that
        // the large one receives longer runs and its rows do not fight for the same cache sets.
        let width = BLOCK_GROUPS * V::LANES;
        for block in 0..self.groups.len().div_ceil(BLOCK_GROUPS) {
            let first = block * BLOCK_GROUPS;
            let groups = BLOCK_GROUPS.min(self.groups.len() - first);
            for group in first..first + groups {
                self.observe_group(group, disturbed, (group - first) * V::LANES, width);
            }
            let used = groups * V::LANES;
            for (out, rows) in out.iter_mut().zip([&self.policy_rows, &self.critic_rows, &self.style_rows]) {
                for (to, from) in out.chunks_exact_mut(envs).zip(rows.chunks_exact(width)) {
                    to[first * V::LANES..][..used].copy_from_slice(&from[..used]);
                }
            }
        }
        self.observations += 1;
    }

    /// Numbers of a group's environments, one per lane.
    fn ids(&self, group: usize) -> [u32; MAX_LANES] {
        let mut ids = [0; MAX_LANES];
        for lane in 0..V::LANES {
            ids[lane] = self.envs[group * V::LANES + lane].id;
        }
        ids
    }

    fn observe_group(&mut self, group: usize, disturbed: bool, first: usize, stride: usize) {
        let ids = self.ids(group);
        let perceived = self.perceived(group);
        V::run(Observe {
            config: &self.config,
            state: self.sim.state(group),
            group: &mut self.groups[group],
            robot: &mut self.robot,
            perceived,
            draw: Draw {
                envs: if disturbed { &ids[..V::LANES] } else { &[] },
                seed: self.seed,
                count: self.observations,
                values: &mut self.noise,
            },
            policy: &mut self.policy_rows,
            critic: &mut self.critic_rows,
            style: &mut self.style_rows,
            stride,
            first,
        });
    }

    /// True if the policy does not see ball and goal as they are.
    fn misperceives(&self) -> bool {
        let preset = &self.config.preset.observations.perception;
        (self.disturbed() || preset.in_evaluation) && preset.errs()
    }

    /// The random numbers of an environment's present observation for one purpose, which uses at most `words` an observation.
    fn numbers(&self, group: usize, lane: usize, stream: u32, words: u64) -> Rng {
        let mut rng = Rng::new(self.seed, self.envs[group * V::LANES + lane].id, stream);
        rng.seek(self.observations * words);
        rng
    }

    /// Remembers the sensed terms of the lanes whose bit is set, where the preset has delays.
    pub(super) fn remember(&mut self, group: usize, lanes: u32) {
        if self.groups[group].delays.is_none() {
            return;
        }
        V::run(Remember {
            config: &self.config,
            state: self.sim.state(group),
            group: &mut self.groups[group],
            robot: &mut self.robot,
            lanes,
        });
    }

    /// Takes the cameras' pictures of this control step.
    pub(super) fn capture(&mut self, group: usize) {
        if !self.misperceives() || self.groups[group].camera.is_none() {
            return;
        }
        let mut rngs = Vec::with_capacity(V::LANES);
        for lane in 0..V::LANES {
            rngs.push(self.numbers(group, lane, PERCEPTION_STREAM, 16));
        }
        self.groups[group].capture(&self.config, self.sim.state(group), &mut rngs);
    }

    /// A control step of the eyes, where the policy's knowledge is perceived.
    pub(super) fn look(&mut self, group: usize) {
        let ids = self.ids(group);
        let task = &mut self.groups[group];
        let Some(eyes) = &mut task.eyes else { return };
        V::run(Look {
            config: &self.config,
            state: self.sim.state(group),
            eyes,
            to_strike_s: task.to_strike_s,
            envs: &ids[..V::LANES],
            seed: self.seed,
            count: self.observations,
        });
    }

    /// Ball and goal with the errors of `observations.perception`: remembered while out of sight, delayed, both with
    /// Gaussian noise. The ball's velocity, which a prediction needs, is the simulator's with the preset's noise.
    fn perceived(&self, group: usize) -> Option<SceneView<V>> {
        let preset = &self.config.preset.observations.perception;
        if !self.misperceives() {
            return None;
        }
        let (state, task) = (self.sim.state(group), &self.groups[group]);
        let [ball, goal] = task.remembered(&self.config, state);
        let mut scene = SceneView::new(ball, goal);
        if self.config.observations.predicts {
            let mut velocity = state.ball.vel;
            if preset.gaussian {
                for lane in 0..V::LANES {
                    let mut rng = self.numbers(group, lane, VELOCITY_STREAM, 4);
                    let [x, y, z] = velocity.lane(lane);
                    let mut estimate = |v: f64| v + preset.ball_velocity_m_s * rng.normal();
                    velocity.set_lane(lane, [estimate(x), estimate(y), z]);
                }
            }
            let displacement = predicted_displacement(velocity, task.prediction_s);
            scene.ball_at_strike += state.bodies[0].rot.tr_mul_vec(displacement);
        }
        if preset.gaussian && task.camera.is_none() {
            let (noise, base) = (preset.noise(), &state.bodies[0]);
            let ball_speed = (state.ball.vel - base.lin_vel).norm();
            let base_speed = base.lin_vel.norm();
            let deviations = [
                noise.deviation(ball_speed, scene.ball.norm()),
                noise.deviation(ball_speed, scene.ball_at_strike.norm()),
                noise.deviation(base_speed, scene.goal.norm()),
            ];
            for lane in 0..V::LANES {
                // Six normal numbers use 12 words.
                let mut rng = self.numbers(group, lane, PERCEPTION_STREAM, 16);
                let [ball, goal] = [(); 2].map(|()| [(); 3].map(|()| rng.normal()));
                let objects =
                    [(&mut scene.ball, ball), (&mut scene.ball_at_strike, ball), (&mut scene.goal, goal)];
                for ((object, normal), sigma) in objects.into_iter().zip(&deviations) {
                    let (exact, sigma) = (object.lane(lane), sigma.lane(lane));
                    object.set_lane(lane, [0, 1, 2].map(|k| exact[k] + sigma * normal[k]));
                }
            }
        }
        Some(scene)
    }
}
