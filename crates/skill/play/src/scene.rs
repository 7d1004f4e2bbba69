//! From an estimate to what a policy is shown: the only place where ball and goal become a [`SceneView`].

use paid_lanes::{Real, Vec3};
use paid_policy::{Pose, SceneView};
use paid_track::{effective_time, predicted_displacement};

use crate::{AfterStrike, AfterStrikeTimes};

/// Ball and goal as known or estimated, in a fixed frame: the world's or odometry's.
#[derive(Clone, Copy, Debug)]
pub struct BelievedScene<V> {
    /// Center of the ball `[m]`.
    pub ball: Vec3<V>,
    /// Its horizontal velocity `[m/s]`.
    pub velocity: [V; 2],
    /// Rate at which it slows down `[1/s]`, see [`paid_track::roll_decay`].
    pub decay: V,
    /// Center of the goal `[m]`.
    pub goal: Vec3<V>,
}

impl<V: Real> BelievedScene<V> {
    /// Ball and goal in the frame of a robot whose base is at `base`. The policy's foot meets the ball `to_contact_s` later `[s]`; a
    /// policy that does not predict (`predicts` false) is shown the ball where it is.
    #[inline(always)]
    pub fn view(&self, base: &Pose<V>, to_contact_s: V, predicts: bool) -> SceneView<V> {
        let mut scene = SceneView::new(base.point_in_body(self.ball), base.point_in_body(self.goal));
        if predicts {
            let [vx, vy] = self.velocity;
            let time = effective_time(to_contact_s, self.decay);
            let met = self.ball + predicted_displacement(Vec3([vx, vy, V::zero()]), time);
            scene.ball_at_strike = base.point_in_body(met);
        }
        scene
    }
}

/// What is remembered between control steps of the scene that was shown: where the ball lay at the strike.
///
/// ```
/// use paid_lanes::{Mat3, Vec3};
/// use paid_play::{AfterStrikeTimes, BelievedScene, SceneMemory};
/// use paid_policy::Pose;
///
/// let goal = Vec3([5.0, 0.0, 0.1]);
/// let scene_at = |x: f64| BelievedScene { ball: Vec3([x, 0.0, 0.1]), velocity: [0.0; 2], decay: 1.0, goal };
/// let base = |x: f64| Pose { pos: Vec3([x, 0.0, 0.8]), rot: Mat3::identity() };
/// let mut memory = SceneMemory::new(Some(AfterStrikeTimes { captured_s: 0.2, from_s: 0.3 }));
/// // Half a second before the strike the ball lies 1 m ahead.
/// let mut scene = scene_at(1.0).view(&base(0.0), 0.5, true);
/// memory.show(&base(0.0), 0.5, &mut scene);
/// // Half a second after it the ball is 4 m away, and the robot half a meter ahead of where it was.
/// let mut scene = scene_at(4.0).view(&base(0.5), -0.5, true);
/// memory.show(&base(0.5), -0.5, &mut scene);
/// assert_eq!(scene.ball.0, [0.5, 0.0, -0.7000000000000001]);
/// ```
#[derive(Clone, Debug)]
pub struct SceneMemory<V> {
    /// Where the ball lay at the strike, and the times of the rule, where there is one.
    lay: Option<(AfterStrike<V>, AfterStrikeTimes)>,
}

impl<V: Real> SceneMemory<V> {
    /// Remembers what the rule for after the strike needs.
    pub fn new(rule: Option<AfterStrikeTimes>) -> Self {
        Self { lay: rule.map(|times| (AfterStrike::new(), times)) }
    }

    /// The numbers to save.
    pub fn fields(&mut self) -> impl Iterator<Item = &mut V> {
        self.lay.iter_mut().flat_map(|(lay, _)| lay.fields())
    }

    /// Begins an episode or a kick in one lane, whose ball lies or lay at `place` `[m]`.
    pub fn reset_lane(&mut self, lane: usize, place: [f64; 3]) {
        if let Some((lay, _)) = &mut self.lay {
            lay.reset_lane(lane, place);
        }
    }

    /// Completes what is about to be shown, `to_strike_s` before the reference's strike `[s]` (negative after it): after the strike with
    /// where the ball lay. `base` is the base's pose in the frame in which places are kept.
    #[inline(always)]
    pub fn show(&mut self, base: &Pose<V>, to_strike_s: V, scene: &mut SceneView<V>) {
        if let Some((lay, times)) = &mut self.lay {
            lay.advance(base.point_in_world(scene.ball_at_strike), to_strike_s, *times);
            for ball in [&mut scene.ball, &mut scene.ball_at_strike] {
                *ball = base.point_in_body(lay.shown(base.point_in_world(*ball), to_strike_s, *times));
            }
        }
    }
}
