//! Ball and goal as an evaluation shows them to the policy, in place of what the task derives from the simulator's scene.

use paid_lanes::{Real, Vec3};
use paid_policy::{Pose, SceneView};

use crate::TaskError;

/// Ball and goal as shown to a policy, estimated by another program.
#[derive(Clone, Copy, Debug)]
pub struct Shown {
    /// Ball, ball at the strike and goal in the base frame `[m]`.
    pub scene: SceneView<f64>,
    /// The base in the frame of the estimate: odometry's.
    pub base: Pose<f64>,
}

/// [`Shown`], one environment a lane.
#[derive(Clone, Debug)]
pub(crate) struct ShownScene<V> {
    pub scene: SceneView<V>,
    pub base: Pose<V>,
}

impl<V: Real> ShownScene<V> {
    /// Nothing yet: zeros.
    pub(crate) fn new() -> Self {
        Self { scene: SceneView::new(Vec3::zero(), Vec3::zero()), base: Pose::identity() }
    }

    /// Takes in what is shown to one lane.
    ///
    /// # Errors
    /// If a number is not finite.
    pub(crate) fn set_lane(&mut self, lane: usize, shown: &Shown) -> Result<(), TaskError> {
        let Shown { scene, base } = shown;
        let numbers = [scene.ball, scene.ball_at_strike, scene.goal, base.pos].map(|v| v.0);
        if !numbers.iter().chain(&base.rot.0).flatten().all(|x| x.is_finite()) {
            return Err(TaskError::Eval("a number of what is shown is not finite".into()));
        }
        self.scene.ball.set_lane(lane, scene.ball.0);
        self.scene.ball_at_strike.set_lane(lane, scene.ball_at_strike.0);
        self.scene.goal.set_lane(lane, scene.goal.0);
        self.base.pos.set_lane(lane, base.pos.0);
        for (to, from) in self.base.rot.0.iter_mut().flatten().zip(base.rot.0.iter().flatten()) {
            to.set_lane(lane, *from);
        }
        Ok(())
    }
}
