//! Disturbances of an environment from outside: push the robot, move the ball or the goal.

use paid_lanes::Real;
use paid_physics::Simulator;

use crate::{Task, TaskError};

/// A disturbance from outside. World axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Disturbance {
    /// An impulse on the robot `[N s]`: every body's velocity changes by impulse over the robot's mass.
    Push([f64; 3]),
    /// The ball elsewhere.
    Ball {
        /// Center `[m]`.
        pos: [f64; 3],
        /// Velocity `[m/s]`; it spins as if it rolled without sliding.
        vel: [f64; 3],
    },
    /// Goal center (x, y) `[m]`. The task's goal plane keeps its direction.
    Goal([f64; 2]),
}

impl Disturbance {
    fn is_finite(&self) -> bool {
        match self {
            Self::Push(impulse) => impulse.iter().all(|x| x.is_finite()),
            Self::Ball { pos, vel } => pos.iter().chain(vel).all(|x| x.is_finite()),
            Self::Goal(xy) => xy.iter().all(|x| x.is_finite()),
        }
    }
}

impl<V: Real, S: Simulator<V>> Task<V, S> {
    /// See [`crate::EvalControl::disturb`].
    pub(crate) fn take(
        &mut self,
        index: usize,
        [group, lane]: [usize; 2],
        disturbance: &Disturbance,
    ) -> Result<(), TaskError> {
        if !disturbance.is_finite() {
            return Err(TaskError::Eval("a number of the disturbance is not finite".into()));
        }
        let params = &self.envs[index].params;
        let radius = params.ball.radius_m;
        match *disturbance {
            Disturbance::Push(impulse) => {
                let scale = |body: usize| params.mass_scale.get(body).copied().unwrap_or(1.0);
                let bodies = self.sim.model().bodies.iter().enumerate();
                let mass: f64 = bodies.map(|(body, b)| b.mass * scale(body)).sum();
                self.sim.push_lane(group, lane, impulse.map(|x| x / mass), [0.0; 3]);
            }
            Disturbance::Ball { pos, vel } => {
                let spin = [-vel[1] / radius, vel[0] / radius, 0.0];
                self.sim.set_ball(group, lane, pos, vel, spin);
            }
            Disturbance::Goal([x, y]) => self.groups[group].goal.set_lane(lane, [x, y, radius]),
        }
        Ok(())
    }
}
