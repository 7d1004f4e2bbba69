//! How an episode begins: motion, phase, robot state, ball, goal and physical parameters.

use paid_lanes::rng::Rng;
use paid_lanes::{Quat, Vec3};
use paid_physics::{EnvParams, LaneState, Material, Simulator};

use crate::config::TaskConfig;
use crate::placement::{
    RollingBall, clear_ball, draw_ball_of_motion, draw_from_workspace, draw_goal, drawn_in, from_start_frame,
    moved_clear, nearest_motion, nominal_ball, nominal_goal, turned,
};
use crate::preset::{BallRule, Range, VelocityNoise};
use crate::rolling::roll_decay;
use crate::{BallCurriculum, InitialState, ReferenceLibrary, SamplerState};

/// Everything drawn for a new episode.
#[derive(Clone, Debug)]
pub(crate) struct Start {
    pub motion: usize,
    pub frame: usize,
    pub params: EnvParams,
    /// Delay of actions and of observations [control steps], 0 to 1.
    pub delays: [f64; 2],
    pub state: LaneState,
    pub joint_offset: Vec<f64>,
    pub goal: [f64; 3],
}

/// Motion, phase and ball of an episode.
struct EpisodePlan {
    motion: usize,
    frame: usize,
    /// Where the ball is to lie, world (x, y); `None` to let the placement draw it.
    ball: Option<[f64; 2]>,
}

/// A foot on the ground (x, y), world.
struct Sole {
    place: [f64; 2],
    /// Unit vector of the foot's x axis.
    along: [f64; 2],
}

/// What the draw depends on.
pub(crate) struct StartContext<'a> {
    pub config: &'a TaskConfig,
    pub library: &'a ReferenceLibrary,
    pub sampler: &'a SamplerState,
    pub curriculum: BallCurriculum,
    pub forced: Option<&'a InitialState>,
    /// Number of the environment over all shards.
    pub env: u32,
    /// False: nominal parameters whatever the preset says.
    pub randomize: bool,
}

/// A factor that changes nothing.
const NONE: Range = [1.0, 1.0];

fn draw(range: Range, rng: &mut Rng) -> f64 {
    rng.uniform(range[0], range[1])
}

/// Uniform linear `[m/s]` and angular `[rad/s]` velocity noise, world axes.
pub(crate) fn velocity_noise(noise: &VelocityNoise, rng: &mut Rng) -> ([f64; 3], [f64; 3]) {
    let mut symmetric = |half: f64| rng.uniform(-half, half);
    let linear = [symmetric(noise.xy), symmetric(noise.xy), symmetric(noise.z)];
    let angular = [symmetric(noise.roll_pitch), symmetric(noise.roll_pitch), symmetric(noise.yaw)];
    (linear, angular)
}

impl StartContext<'_> {
    /// Motion, frame and, by the workspace rule, ball: forced, or from the sampler. A start leaves at least one frame to
    /// track.
    fn plan(&self, rng: &mut Rng) -> EpisodePlan {
        if let Some(forced) = self.forced {
            return EpisodePlan { motion: forced.motion, frame: forced.frame, ball: None };
        }
        let preset = &self.config.preset;
        let by_workspace = preset.scene.ball && preset.ball.rule == BallRule::Workspace;
        let (mut motion, bin) = self.sampler.draw(rng.unit());
        let mut frame = self.frame(motion, bin, rng);
        if rng.unit() < preset.sampling.first_frame_share {
            frame = 0;
        }
        let motions = self.library.facts();
        let ball = by_workspace.then(|| {
            let by_motion = frame > 0 || (preset.sampling.miss_sampling_weight > 0.0 && rng.unit() < 0.5);
            let ball = if !by_motion {
                let ball = draw_from_workspace(&preset.ball, rng);
                motion = nearest_motion(motions, ball);
                ball
            } else {
                draw_ball_of_motion(motions, motion, &preset.ball, rng)
            };
            drawn_in(ball, &motions[motion], self.curriculum.reach(&preset.ball))
        });
        EpisodePlan { motion, frame, ball: ball.map(|xy| from_start_frame(&motions[motion], xy)) }
    }

    /// A frame of a bin, not too late for the ball.
    fn frame(&self, motion: usize, bin: usize, rng: &mut Rng) -> usize {
        let facts = &self.library.facts()[motion];
        let phase = (bin as f64 + rng.unit()) / self.sampler.bins as f64;
        let frame = ((phase * (facts.frames - 1) as f64) as usize).min(facts.frames - 2);
        let margin_s = self.config.preset.sampling.latest_start_before_strike_s;
        if margin_s < 0.0 {
            return frame;
        }
        let margin = (margin_s / self.config.dt_s).round() as usize;
        let latest = facts.strike_frame.saturating_sub(margin);
        let fallback = rng.below(latest + 1);
        if frame > latest { fallback } else { frame }
    }

    /// Factors of gains and masses, where the preset has them.
    fn scales(&self, params: &mut EnvParams, rng: &mut Rng) {
        let ranges = &self.config.preset.randomization;
        if ranges.gain_scale != NONE {
            params.gain_scale = [draw(ranges.gain_scale, rng), draw(ranges.gain_scale, rng)];
        }
        if ranges.link_mass_scale != NONE || ranges.base_mass_scale != NONE {
            params.mass_scale = (0..self.config.bodies).map(|_| draw(ranges.link_mass_scale, rng)).collect();
            params.mass_scale[0] = draw(ranges.base_mass_scale, rng);
        }
    }

    /// Delays of actions and observations [control steps].
    fn delays(&self, rng: &mut Rng) -> [f64; 2] {
        let ranges = &self.config.preset.randomization;
        if !self.randomize || !ranges.delays() {
            return [0.0; 2];
        }
        [ranges.action_delay_s, ranges.observation_delay_s].map(|r| draw(r, rng) / self.config.dt_s)
    }

    /// Physical parameters: nominal, or drawn from the preset's ranges.
    fn params(&self, rng: &mut Rng) -> (EnvParams, Vec<f64>) {
        let preset = &self.config.preset;
        let ranges = &preset.randomization;
        let mut params =
            EnvParams { robot: preset.robot_material, ball: preset.ball_params, ..EnvParams::default() };
        let mut offsets = vec![0.0; self.config.joints()];
        if !self.randomize {
            return (params, offsets);
        }
        if let (true, paid_physics::Terrain::Rough { cell_m, size, .. }) =
            (ranges.terrain_offset, &preset.scene.terrain)
        {
            let side = cell_m * *size as f64;
            params.terrain_offset = [rng.uniform(0.0, side), rng.uniform(0.0, side)];
        }
        if ranges.robot {
            let static_friction = draw(ranges.static_friction, rng);
            params.robot = Material {
                static_friction,
                dynamic_friction: draw(ranges.dynamic_friction, rng).min(static_friction),
                restitution: draw(ranges.restitution, rng),
            };
            params.base_com_offset =
                [ranges.base_com_x_m, ranges.base_com_yz_m, ranges.base_com_yz_m].map(|r| draw(r, rng));
            for offset in &mut offsets {
                *offset = draw(ranges.joint_default_rad, rng);
            }
        }
        if ranges.ball {
            let static_friction = draw(ranges.ball_static_friction, rng);
            params.ball.mass_kg = draw(ranges.ball_mass_kg, rng);
            params.ball.material = Material {
                static_friction,
                dynamic_friction: draw(ranges.ball_dynamic_friction, rng).min(static_friction),
                restitution: draw(ranges.ball_restitution, rng),
            };
            params.ball.linear_damping = draw(ranges.ball_linear_damping, rng);
            params.ball.angular_damping = draw(ranges.ball_angular_damping, rng);
        }
        if !ranges.surfaces.is_empty() {
            let surface = &ranges.surfaces[self.env as usize % ranges.surfaces.len()];
            surface.perturbed(ranges.surface_deviation, rng).apply(&mut params.ball);
        }
        self.scales(&mut params, rng);
        (params, offsets)
    }

    /// Draws an episode's start for one lane. The drawn parameters are set in the simulator at once, so that it knows the ground's
    /// height under the robot.
    pub(crate) fn draw<V, S>(&self, sim: &mut S, group: usize, lane: usize, rng: &mut Rng) -> Start
    where
        V: paid_lanes::Real,
        S: Simulator<V>,
    {
        let EpisodePlan { motion, frame, ball: planned } = self.plan(rng);
        let (params, joint_offset) = self.params(rng);
        let delays = self.delays(rng);
        sim.set_params(group, lane, &params);
        let facts = &self.library.facts()[motion];
        let noisy = self.forced.is_none_or(|f| f.noise);
        let shift = match self.forced {
            Some(forced) => turned(forced.displacement, facts.heading),
            None => planned.map_or([0.0; 2], |ball| {
                let nominal = nominal_ball(facts);
                let way = (frame as f64 / facts.strike_frame.max(1) as f64).min(1.0);
                [0, 1].map(|k| way * (ball[k] - nominal[k]))
            }),
        };
        let (mut state, feet) = self.robot(motion, frame, noisy, shift, rng);
        let ground = |xy: [f64; 2]| sim.ground_height(group, lane, xy);
        if self.config.preset.resets.lift_to_ground {
            // Three points of each sole, 8 cm apart along the foot.
            let mut lift = 0.0_f64;
            for Sole { place, along } in &feet {
                for k in [-0.08, 0.0, 0.08] {
                    lift = lift.max(ground([place[0] + k * along[0], place[1] + k * along[1]]));
                }
            }
            state.base_pos[2] += lift;
        }
        let radius = params.ball.radius_m;
        let feet = [feet[0].place, feet[1].place];
        let (ball, velocity) = self.ball([motion, frame], planned, &params.ball, &feet, rng);
        state.ball_pos = [ball[0], ball[1], ground(ball) + radius];
        if !self.config.preset.scene.ball {
            // A marker: at its height above the plane, whatever the terrain below.
            state.ball_pos[2] = radius;
        }
        state.ball_vel = [velocity[0], velocity[1], 0.0];
        // Rolling without sliding.
        state.ball_ang_vel = [-velocity[1] / radius, velocity[0] / radius, 0.0];
        let goal_preset = &self.config.preset.goal;
        let goal = match self.forced {
            Some(forced) => forced
                .goal_xy
                .map_or_else(|| nominal_goal(facts, goal_preset), |xy| from_start_frame(facts, xy)),
            None => draw_goal(facts, goal_preset, rng),
        };
        Start { motion, frame, params, delays, state, joint_offset, goal: [goal[0], goal[1], radius] }
    }

    /// Ball place and velocity (x, y), world. Where the policy sees rolling balls ahead of time, the place is where the ball will be
    /// when the motion strikes.
    fn ball(
        &self,
        [motion, frame]: [usize; 2],
        planned: Option<[f64; 2]>,
        params: &paid_physics::BallParams,
        feet: &[[f64; 2]; 2],
        rng: &mut Rng,
    ) -> ([f64; 2], [f64; 2]) {
        let facts = &self.library.facts()[motion];
        let preset = &self.config.preset.ball;
        if let Some(forced) = self.forced {
            let place = forced.ball_xy.map_or_else(|| nominal_ball(facts), |xy| from_start_frame(facts, xy));
            return (place, turned(forced.ball_velocity, facts.heading));
        }
        if !self.config.preset.scene.ball {
            return (nominal_ball(facts), [0.0; 2]);
        }
        let place = match planned {
            Some(ball) => moved_clear(ball, facts.displacement, preset.clearance_m, feet),
            None => clear_ball(facts, preset, feet, rng),
        };
        let rolls = rng.unit() < preset.rolling_share;
        let speed = if rolls { preset.velocity } else { 0.0 };
        let velocity = [rng.uniform(-speed, speed), rng.uniform(-speed, speed)];
        if !(rolls && self.config.preset.predicts_ball()) {
            return (place, velocity);
        }
        let back = RollingBall { place, velocity: velocity.map(|v| -v), decay: roll_decay(params) };
        let start = back.at_strike(facts, frame, self.config.dt_s);
        (moved_clear(start, facts.displacement, preset.clearance_m, feet), velocity)
    }

    /// The reference's state at a frame, displaced and with noise; and, for both feet, place and direction (x, y).
    fn robot(
        &self,
        motion: usize,
        frame: usize,
        noisy: bool,
        shift: [f64; 2],
        rng: &mut Rng,
    ) -> (LaneState, [Sole; 2]) {
        let config = self.config;
        let preset = &config.preset.resets;
        let clip = &self.library.clips()[motion];
        let joints = config.joints();
        let bodies = clip.body_pos.len() / clip.frames;
        let row = frame * bodies;
        let on = if noisy { 1.0 } else { 0.0 };
        let mut symmetric = |half: f64| on * rng.uniform(-half, half);
        let pos = clip.body_pos[row];
        let offset =
            [symmetric(preset.xy_m) + shift[0], symmetric(preset.xy_m) + shift[1], symmetric(preset.z_m)];
        let [roll, pitch] = [symmetric(preset.roll_pitch_rad), symmetric(preset.roll_pitch_rad)];
        let turn = Quat::from_roll_pitch_yaw(roll, pitch, symmetric(preset.yaw_rad));
        let reference_rot = Quat(clip.body_quat[row]);
        let rot = turn.mul(reference_rot).normalize();
        // The file's velocity is the center of mass's: v_origin = v_com - omega x (R com).
        let omega = Vec3(clip.body_ang_vel[row]);
        let arm = reference_rot.rotate(Vec3(config.base_com));
        let origin = Vec3(clip.body_com_vel[row]) - omega.cross(arm);
        let mut joint_pos = clip.joint_pos[frame * joints..][..joints].to_vec();
        for (q, [lo, hi]) in joint_pos.iter_mut().zip(&config.control.soft_range) {
            let noise = symmetric(preset.joint_rad);
            if noisy {
                *q = (*q + noise).clamp(*lo, *hi);
            }
        }
        let (linear, angular) = velocity_noise(&preset.velocity, rng);
        let (linear, angular) = (linear.map(|v| v * on), angular.map(|v| v * on));
        let feet = config.feet.map(|i| {
            let foot = row + config.followed[i];
            let p = clip.body_pos[foot];
            let x = Quat(clip.body_quat[foot]).rotate(Vec3([1.0, 0.0, 0.0])).0;
            let length = x[0].hypot(x[1]).max(1e-6);
            Sole { place: [p[0] + offset[0], p[1] + offset[1]], along: [x[0] / length, x[1] / length] }
        });
        let state = LaneState {
            base_pos: [pos[0] + offset[0], pos[1] + offset[1], pos[2] + offset[2]],
            base_quat: rot.0,
            base_lin_vel: [0, 1, 2].map(|k| origin.0[k] + linear[k]),
            base_ang_vel: [0, 1, 2].map(|k| omega.0[k] + angular[k]),
            joint_pos,
            joint_vel: clip.joint_vel[frame * joints..][..joints].to_vec(),
            ball_pos: [0.0; 3],
            ball_vel: [0.0; 3],
            ball_ang_vel: [0.0; 3],
            warm_start: Vec::new(),
        };
        (state, feet)
    }
}
