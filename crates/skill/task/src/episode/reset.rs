//! How an episode begins: motion, phase, robot state, ball, goal and physical parameters.

use paid_lanes::Quat;
use paid_lanes::rng::Rng;
use paid_physics::{EnvParams, LaneState, Simulator};
use paid_play::{ReferenceLibrary, RollingBall, from_start_frame, nearest_motion, nominal_ball, turned};

use crate::config::TaskConfig;
use crate::episode::stance::{EndStates, RobotState, Sole};
use crate::episode::starts::{Struck, gone, happens};
use crate::preset::{BallRule, Range, VelocityNoise};
use crate::scene::eyes::believed;
use crate::scene::placement::{
    clear_ball, draw_ball_about, draw_ball_of_motion, draw_from_workspace, draw_goal, drawn_in, moved_clear,
    nominal_goal,
};
use crate::scene::rolling::roll_decay;
use crate::{BallCurriculum, InitialState, SamplerState};

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
    /// How long the last frame is held after the motion's end [control steps].
    pub hold: usize,
    /// Where the ball lay at the strike, in an episode that begins after it `[m]`.
    pub struck: Option<Struck>,
}

/// Motion, phase and ball of an episode.
struct EpisodePlan {
    motion: usize,
    frame: usize,
    /// Where the ball is to lie, world (x, y); `None` to let the placement draw it.
    ball: Option<[f64; 2]>,
    /// How long the last frame is held [control steps].
    hold: usize,
    /// True if it begins after the strike.
    after_strike: bool,
    /// The robot's state, where that is not the frame's.
    state: Option<RobotState>,
}

/// What the draw depends on.
pub(crate) struct StartContext<'a> {
    pub config: &'a TaskConfig,
    pub library: &'a ReferenceLibrary,
    pub sampler: &'a SamplerState,
    pub curriculum: BallCurriculum,
    /// What earlier episodes of the shard ended in.
    pub end_states: &'a EndStates,
    pub forced: Option<&'a InitialState>,
    /// Number of the environment over all shards.
    pub env: u32,
    /// False: nominal parameters whatever the preset says.
    pub randomize: bool,
    /// Random numbers of onboard perception, where the preset's knowledge is perceived: to find out what it will show.
    pub eyes: Option<Rng>,
}

pub(crate) fn draw(range: Range, rng: &mut Rng) -> f64 {
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
    ///
    /// `extra` is the stream of the preset's other options: holding and other starts.
    fn plan(&self, rng: &mut Rng, extra: &mut Rng) -> EpisodePlan {
        if let Some(forced) = self.forced {
            return EpisodePlan {
                motion: forced.motion,
                frame: forced.frame,
                ball: None,
                hold: 0,
                after_strike: false,
                state: None,
            };
        }
        let preset = &self.config.preset;
        let hold = self.hold(extra);
        let by_workspace = preset.scene.ball && preset.ball.rule == BallRule::Workspace;
        let (mut motion, bin) = self.sampler.draw(rng.unit());
        let mut frame = self.frame(motion, bin, rng);
        if rng.unit() < preset.sampling.first_frame_share {
            frame = 0;
        }
        let motions = self.library.facts();
        let after_strike = happens(preset.sampling.after_strike_share, extra);
        if after_strike {
            let strike = motions[motion].strike_frame;
            frame = strike + extra.below((motions[motion].frames - 1 + hold).saturating_sub(strike).max(1));
        }
        let ball = by_workspace.then(|| {
            let by_motion = frame > 0 || (preset.sampling.miss_sampling_weight > 0.0 && rng.unit() < 0.5);
            let ball = if !by_motion {
                let ball = draw_from_workspace(&preset.ball, rng);
                motion = nearest_motion(motions, self.believed(ball));
                ball
            } else if happens(preset.ball.own_place_share, extra) {
                draw_ball_about(&motions[motion], rng)
            } else {
                draw_ball_of_motion(motions, motion, &preset.ball, rng)
            };
            drawn_in(ball, &motions[motion], self.curriculum.reach(&preset.ball))
        });
        let state = if frame == 0 { self.other_start(motion, extra) } else { None };
        let ball = ball.map(|xy| from_start_frame(&motions[motion], xy));
        EpisodePlan { motion, frame, ball, hold, after_strike, state }
    }

    /// The robot's estimate, at its motion's strike, of a ball that comes to `place`; both in the start frame `[m]`.
    fn believed(&self, place: [f64; 2]) -> [f64; 2] {
        let Some(mut rng) = self.eyes else { return place };
        let preset = &self.config.preset;
        // The error for a ball that rolls to this place is that for one that lies there: the error of a linear filter is that of its images.
        let ball = RollingBall { place, velocity: [0.0; 2], decay: roll_decay(&preset.ball_params) };
        let seen = believed(&preset.eyes, &ball, self.config.nominal_height_m, &mut rng);
        let motions = self.library.facts();
        seen.as_chosen_by(preset.predicts_ball()).at_strike(
            &motions[nearest_motion(motions, place)],
            0,
            self.config.dt_s,
        )
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

    /// Draws an episode's start for one lane. The drawn parameters are set in the simulator at once, so that it knows the ground's
    /// height under the robot.
    pub(crate) fn draw<V, S>(
        &self,
        sim: &mut S,
        [group, lane]: [usize; 2],
        rng: &mut Rng,
        extra: &mut Rng,
    ) -> Start
    where
        V: paid_lanes::Real,
        S: Simulator<V>,
    {
        let plan = self.plan(rng, extra);
        let EpisodePlan { motion, frame, ball: planned, hold, .. } = plan;
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
        let from = plan.state.unwrap_or_else(|| self.reference_state(motion, frame));
        let (mut state, feet) = self.robot(&from, noisy, shift, rng);
        let ground = |xy: [f64; 2]| sim.ground_height(group, lane, xy);
        if self.config.preset.resets.lift_to_ground {
            // Three points of each sole, 8 cm apart along the foot.
            // Training only lifts; an evaluation's robot stands on the ground also where that is lower.
            let mut lift = if self.forced.is_some() { f64::NEG_INFINITY } else { 0.0 };
            for Sole { place, along } in &feet {
                for k in [-0.08, 0.0, 0.08] {
                    lift = lift.max(ground([place[0] + k * along[0], place[1] + k * along[1]]));
                }
            }
            state.base_pos[2] += lift;
        }
        let radius = params.ball.radius_m;
        let feet = [feet[0].place, feet[1].place];
        let clearance = if plan.after_strike { 0.0 } else { self.config.preset.ball.clearance_m };
        let (ball, velocity) = self.ball([motion, frame], planned, clearance, &params.ball, &feet, rng);
        state.ball_pos = sim.ball_on_ground(group, lane, ball, radius, velocity == [0.0; 2]);
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
        let goal = [goal[0], goal[1], radius];
        let struck = (plan.after_strike && self.config.preset.scene.ball).then(|| {
            let struck = self.struck(motion, shift, state.ball_pos);
            let since_s = frame.saturating_sub(facts.strike_frame) as f64 * self.config.dt_s;
            let (ball, velocity) = gone(ball, [goal[0], goal[1]], since_s);
            state.ball_pos = [ball[0], ball[1], ground(ball) + radius];
            state.ball_vel = [velocity[0], velocity[1], 0.0];
            state.ball_ang_vel = [-velocity[1] / radius, velocity[0] / radius, 0.0];
            struck
        });
        Start { motion, frame, params, delays, state, joint_offset, goal, hold, struck }
    }

    /// Ball place and velocity (x, y), world. Where the policy sees rolling balls ahead of time, the place is where the ball will be
    /// when the motion strikes.
    fn ball(
        &self,
        [motion, frame]: [usize; 2],
        planned: Option<[f64; 2]>,
        clearance_m: f64,
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
            Some(ball) => moved_clear(ball, facts.displacement, clearance_m, feet),
            None => clear_ball(facts, preset, clearance_m, feet, rng),
        };
        let rolls = rng.unit() < preset.rolling_share;
        let speed = if rolls { preset.velocity } else { 0.0 };
        let velocity = [rng.uniform(-speed, speed), rng.uniform(-speed, speed)];
        if !(rolls && self.config.preset.predicts_ball()) {
            return (place, velocity);
        }
        let back = RollingBall { place, velocity: velocity.map(|v| -v), decay: roll_decay(params) };
        let start = back.at_strike(facts, frame, self.config.dt_s);
        (moved_clear(start, facts.displacement, clearance_m, feet), velocity)
    }

    /// A state displaced and with noise; and, for both feet, place and direction (x, y).
    fn robot(
        &self,
        from: &RobotState,
        noisy: bool,
        shift: [f64; 2],
        rng: &mut Rng,
    ) -> (LaneState, [Sole; 2]) {
        let config = self.config;
        let preset = &config.preset.resets;
        let on = if noisy { 1.0 } else { 0.0 };
        let mut symmetric = |half: f64| on * rng.uniform(-half, half);
        let pos = from.base_pos;
        let offset =
            [symmetric(preset.xy_m) + shift[0], symmetric(preset.xy_m) + shift[1], symmetric(preset.z_m)];
        let [roll, pitch] = [symmetric(preset.roll_pitch_rad), symmetric(preset.roll_pitch_rad)];
        let turn = Quat::from_roll_pitch_yaw(roll, pitch, symmetric(preset.yaw_rad));
        let rot = turn.mul(Quat(from.base_quat)).normalize();
        let mut joint_pos = from.joint_pos.clone();
        for (q, [lo, hi]) in joint_pos.iter_mut().zip(&config.control.soft_range) {
            let noise = symmetric(preset.joint_rad);
            if noisy {
                *q = (*q + noise).clamp(*lo, *hi);
            }
        }
        let (linear, angular) = velocity_noise(&preset.velocity, rng);
        let (linear, angular) = (linear.map(|v| v * on), angular.map(|v| v * on));
        let feet = from
            .soles
            .map(|Sole { place: [x, y], along }| Sole { place: [x + offset[0], y + offset[1]], along });
        let state = LaneState {
            base_pos: [pos[0] + offset[0], pos[1] + offset[1], pos[2] + offset[2]],
            base_quat: rot.0,
            base_lin_vel: [0, 1, 2].map(|k| from.lin_vel[k] + linear[k]),
            base_ang_vel: [0, 1, 2].map(|k| from.ang_vel[k] + angular[k]),
            joint_pos,
            joint_vel: from.joint_vel.clone(),
            ball_pos: [0.0; 3],
            ball_vel: [0.0; 3],
            ball_ang_vel: [0.0; 3],
            warm_start: Vec::new(),
        };
        (state, feet)
    }
}
