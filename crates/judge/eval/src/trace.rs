//! The motion of robot and ball in one trial.

use paid_task::EnvSample;

use crate::episodes::{Ending, Observer};

/// The motion of robot and ball in one trial.
#[derive(Clone, Debug, Default)]
pub struct Trace {
    /// Every control step, the start first.
    pub rows: Vec<Row>,
}

/// One control step.
#[derive(Clone, Debug)]
pub struct Row {
    /// Place of the base, world `[m]`.
    pub base: [f64; 3],
    /// Base frame in the world, row-major.
    pub rot: [[f64; 3]; 3],
    /// Joint angles, model order `[rad]`.
    pub joints: Vec<f32>,
    /// Center of the ball, world `[m]`; zero without one.
    pub ball: [f64; 3],
    /// Velocity of the ball, world `[m/s]`; zero without one.
    pub ball_vel: [f64; 3],
}

/// Records a trace with another observer.
pub(crate) struct Traced<O> {
    pub watch: O,
    pub trace: Trace,
    /// Whether there is a ball.
    pub ball: bool,
}

impl<O: Observer> Observer for Traced<O> {
    fn observe(&mut self, sample: &EnvSample, ended: Option<Ending>) -> bool {
        let base = &sample.bodies[0];
        self.trace.rows.push(Row {
            base: base.pos,
            rot: base.rot,
            joints: sample.joint_pos.iter().map(|q| *q as f32).collect(),
            ball: if self.ball { sample.ball_pos } else { [0.0; 3] },
            ball_vel: if self.ball { sample.ball_vel } else { [0.0; 3] },
        });
        self.watch.observe(sample, ended)
    }
}
