//! The next kick of a robot that is not reset.

use paid_lanes::Real;
use paid_physics::Simulator;

use super::begin_to_see;
use crate::episode::eyes::begin_lane;
use crate::episode::reset::Start;
use crate::references::anchoring::{Anchoring, LaneAnchoring};
use crate::scene::eyes::start_rng;
use crate::{NextKick, Task, TaskError};

impl<V: Real, S: Simulator<V>> Task<V, S> {
    /// See [`crate::EvalControl::next_kick`].
    pub(crate) fn begin_next_kick(
        &mut self,
        index: usize,
        [group, lane]: [usize; 2],
        next: &NextKick,
    ) -> Result<(), TaskError> {
        let facts =
            self.library.facts().get(next.motion).ok_or_else(|| {
                TaskError::Eval(format!("motion {} of {}", next.motion, self.library.len()))
            })?;
        let numbers = next.ball_xy.iter().chain(&next.ball_velocity).chain(&next.goal_xy);
        if numbers.into_iter().any(|x| !x.is_finite()) {
            return Err(TaskError::Eval("a number of the next kick is not finite".into()));
        }
        let anchor = &self.sim.state(group).bodies[self.config.followed[self.config.anchor]];
        let [x, y, _] = anchor.pos.lane(lane);
        let heading = anchor.rot.0[1][0].lane(lane).atan2(anchor.rot.0[0][0].lane(lane));
        let anchoring = Anchoring::new(facts, [x, y], heading);
        let world = |xy: [f64; 2]| anchoring.point(paid_play::from_start_frame(facts, xy));
        let env = &self.envs[index];
        let radius = env.params.ball.radius_m;
        let ([ball_x, ball_y], [goal_x, goal_y]) = (world(next.ball_xy), world(next.goal_xy));
        let [vx, vy] = paid_play::turned(next.ball_velocity, heading);
        let mut state = self.sim.save_lane(group, lane);
        let still = next.ball_velocity == [0.0; 2];
        state.ball_pos = self.sim.ball_on_ground(group, lane, [ball_x, ball_y], radius, still);
        // Rolling without sliding.
        (state.ball_vel, state.ball_ang_vel) = ([vx, vy, 0.0], [-vy / radius, vx / radius, 0.0]);
        self.sim.set_ball(group, lane, state.ball_pos, state.ball_vel, state.ball_ang_vel);
        let start = Start {
            motion: next.motion,
            frame: 0,
            params: env.params.clone(),
            delays: [0.0; 2],
            state,
            joint_offset: Vec::new(),
            goal: [goal_x, goal_y, radius],
            hold: 0,
            struck: None,
        };
        let wait = self.config.no_kick_before(facts, 0);
        let foot = self.config.has_reference.then_some(facts.kick_foot);
        self.set_anchoring(index, Some(anchoring));
        let env = &mut self.envs[index];
        (env.motion, env.frame, env.hold, env.after_strike) = (next.motion, 1, 0, false);
        (env.ended, env.kick) = (None, None);
        let task = &mut self.groups[group];
        task.goal.set_lane(lane, start.goal);
        task.heading[0].set_lane(lane, heading.cos());
        task.heading[1].set_lane(lane, heading.sin());
        task.kick.reset_lane(lane, foot, start.state.ball_pos, wait);
        begin_to_see(task, lane, &start, &mut env.reset_rng);
        if let Some(eyes) = &mut task.eyes {
            let mut rng = start_rng(self.seed, env.id, Some(next.look));
            begin_lane(eyes, lane, &start, heading, &self.config, &mut rng);
        }
        self.gather(group);
        Ok(())
    }

    /// Lets an environment's reference begin elsewhere, or where its clip does.
    pub(crate) fn set_anchoring(&mut self, index: usize, anchoring: Option<Anchoring>) {
        self.envs[index].anchoring = anchoring;
        let of_group = &mut self.groups[index / V::LANES].anchoring;
        if anchoring.is_some() || of_group.is_some() {
            of_group.get_or_insert_with(LaneAnchoring::none).set_lane(index % V::LANES, anchoring.as_ref());
        }
    }
}
