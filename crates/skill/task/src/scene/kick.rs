//! What happened to the ball in an episode.

use paid_lanes::{Mask, Real, Vec3};
use paid_physics::BallState;

use crate::KickPreset;

/// Kick state of a group. Flags are 0 or 1.
#[derive(Clone, Debug)]
pub(crate) struct KickState<V> {
    /// Labeled foot: -1 left, +1 right, 0 either.
    pub label: V,
    /// The robot has touched the ball.
    pub touched: V,
    /// The first contact was the labeled foot's.
    pub correct: V,
    /// Control steps until a contact counts as a kick.
    pub wait: V,
    /// Control steps since the first contact.
    pub since: V,
    /// Control steps left for which the outcome is rewarded.
    pub window: V,
    /// The vertical-speed window has been opened.
    pub z_opened: V,
    /// Control steps left for which vertical speed is charged.
    pub z_window: V,
    /// Squared horizontal distance of the ball from anchor and base at the first contact `[m^2]`.
    pub distance2: [V; 2],
    /// Where the ball was before the first contact `[m]`.
    pub before: Vec3<V>,
    /// Largest horizontal ball speed within the window after the first contact `[m/s]`.
    pub best_speed: V,
    /// Cosine of the ball's direction to the goal's at that speed.
    pub best_cosine: V,
    /// At that speed the ball was heading into the goal.
    pub on_target: V,
    /// The ball has crossed the goal plane.
    pub crossed: V,
    /// It did so inside the goal.
    pub scored: V,
}

/// What a control step added.
#[derive(Clone, Copy, Debug)]
pub struct KickStep<V: Real> {
    /// First contact of the episode.
    pub first: V::Mask,
    /// The first contact, by the labeled foot.
    pub correct: V::Mask,
    /// The first contact, and it is rewarded.
    pub paid: V::Mask,
    /// The right foot is the nearer one.
    pub right: V::Mask,
    /// The outcome is rewarded in this step.
    pub window: V::Mask,
    /// Vertical speed is charged in this step.
    pub z_window: V::Mask,
}

impl<V: Real> KickStep<V> {
    /// Nothing happened.
    #[inline(always)]
    pub(crate) fn none() -> Self {
        let no = V::Mask::splat(false);
        Self { first: no, correct: no, paid: no, right: no, window: no, z_window: no }
    }
}

/// Squared horizontal length.
#[inline(always)]
pub(crate) fn horizontal2<V: Real>(v: Vec3<V>) -> V {
    v.x().mul_add(v.x(), v.y() * v.y())
}

#[inline(always)]
pub(crate) fn flag<V: Real>(mask: V::Mask) -> V {
    V::select(mask, V::one(), V::zero())
}

#[inline(always)]
pub(crate) fn is_set<V: Real>(flag: V) -> V::Mask {
    flag.gt(V::c(0.5))
}

impl<V: Real> KickState<V> {
    pub(crate) fn new() -> Self {
        let zero = V::zero();
        Self {
            label: V::one(),
            touched: zero,
            correct: zero,
            wait: zero,
            since: zero,
            window: zero,
            z_opened: zero,
            z_window: zero,
            distance2: [zero; 2],
            before: Vec3::zero(),
            best_speed: zero,
            best_cosine: zero,
            on_target: zero,
            crossed: zero,
            scored: zero,
        }
    }

    /// Every number, for reset and save.
    pub(crate) fn fields(&mut self) -> [&mut V; 18] {
        let [x, y, z] = &mut self.before.0;
        let [from_anchor, from_base] = &mut self.distance2;
        [
            &mut self.label,
            &mut self.touched,
            &mut self.correct,
            &mut self.wait,
            &mut self.since,
            &mut self.window,
            &mut self.z_opened,
            &mut self.z_window,
            from_anchor,
            from_base,
            x,
            y,
            z,
            &mut self.best_speed,
            &mut self.best_cosine,
            &mut self.on_target,
            &mut self.crossed,
            &mut self.scored,
        ]
    }

    /// Begins an episode in one lane, to be kicked with the given foot (0 left, 1 right) or with either. No contact counts as a kick
    /// for the first `wait` control steps.
    pub(crate) fn reset_lane(&mut self, lane: usize, kick_foot: Option<usize>, ball: [f64; 3], wait: usize) {
        for field in self.fields() {
            field.set_lane(lane, 0.0);
        }
        self.label.set_lane(lane, kick_foot.map_or(0.0, |foot| [-1.0, 1.0][foot]));
        self.before.set_lane(lane, ball);
        self.wait.set_lane(lane, wait as f64);
    }

    /// Marks a lane's kick as over, for an episode that begins after it: `distance2` is the ball's squared distance from anchor and
    /// base at the contact `[m^2]`. It earns no reward any more.
    pub(crate) fn set_struck(&mut self, lane: usize, distance2: [f64; 2]) {
        for flag in [&mut self.touched, &mut self.z_opened] {
            flag.set_lane(lane, 1.0);
        }
        for (kept, value) in self.distance2.iter_mut().zip(distance2) {
            kept.set_lane(lane, value);
        }
    }

    /// Updates with the state after a control step. `feet` are places and engine bodies of the left and right foot, `robot_points`
    /// anchor and base, world `[m]`.
    #[inline(always)]
    pub(crate) fn advance(
        &mut self,
        ball: &BallState<V>,
        feet: [(Vec3<V>, usize); 2],
        robot_points: [Vec3<V>; 2],
        preset: &KickPreset,
    ) -> KickStep<V> {
        let one = V::one();
        let untouched = is_set(self.touched).not();
        let first = ball.robot_force.norm().gt(V::c(preset.contact_force_n)).and(untouched);
        let [left_foot, right_foot] = feet;
        let right = (ball.pos - right_foot.0).norm2().lt((ball.pos - left_foot.0).norm2());
        let side = V::select(right, one, -one);
        let in_time = self.wait.lt(V::c(0.5));
        self.wait = (self.wait - one).max(V::zero());
        let mut kick = first.and(in_time);
        if preset.foot_only {
            let foot = V::select(right, V::c(right_foot.1 as f64), V::c(left_foot.1 as f64));
            kick = kick.and((ball.touched_by - foot).abs().lt(V::c(0.5)));
        }
        let correct = kick.and((side * self.label).ge(V::zero()));
        let paid = if preset.any_foot { kick } else { correct };
        self.since = V::select(untouched, V::zero(), self.since + one);
        self.touched = V::select(first, one, self.touched);
        self.correct = V::select(correct, one, self.correct);
        self.window = V::select(paid, V::c(preset.window_steps as f64), self.window);
        let window = self.window.gt(V::c(0.5));
        self.window = (self.window - one).max(V::zero());

        let fast = ball.vel.norm2().gt(V::c(preset.z_min_speed * preset.z_min_speed));
        let opens = fast.and(is_set(self.touched)).and(is_set(self.z_opened).not());
        self.z_opened = V::select(opens, one, self.z_opened);
        self.z_window = V::select(opens, V::c(preset.z_window_steps as f64), self.z_window);
        let z_window = self.z_window.gt(V::c(0.5));
        self.z_window = (self.z_window - one).max(V::zero());

        self.before = Vec3::select(is_set(self.touched), self.before, ball.pos);
        for (kept, point) in self.distance2.iter_mut().zip(robot_points) {
            *kept = V::select(first, horizontal2(ball.pos - point), *kept);
        }
        KickStep { first, correct, paid, right, window, z_window }
    }

    /// Statistics of the outcome: best speed and direction within `window_steps` of the first contact, and goals.
    #[inline(always)]
    pub(crate) fn observe_outcome(
        &mut self,
        ball: &BallState<V>,
        goal: Vec3<V>,
        heading: [V; 2],
        window_steps: usize,
        half_width: f64,
    ) {
        let one = V::one();
        let (vx, vy) = (ball.vel.x(), ball.vel.y());
        let speed = vx.mul_add(vx, vy * vy).sqrt();
        let counted = is_set(self.touched).and(self.since.lt(V::c(window_steps as f64)));
        let better = counted.and(speed.gt(self.best_speed));
        let (gx, gy) = (goal.x() - self.before.x(), goal.y() - self.before.y());
        let distance = gx.mul_add(gx, gy * gy).sqrt();
        let cosine = (gx * vx + gy * vy) / (distance * speed).max(V::c(1e-6));
        self.best_speed = V::select(better, speed, self.best_speed);
        self.best_cosine = V::select(better, cosine, self.best_cosine);
        // Where the ball would cross the goal plane on a straight line.
        let (dx, dy) = (ball.pos.x() - goal.x(), ball.pos.y() - goal.y());
        let along = dx * heading[0] + dy * heading[1];
        let across = dy * heading[0] - dx * heading[1];
        let v_along = vx * heading[0] + vy * heading[1];
        let v_across = vy * heading[0] - vx * heading[1];
        let time = -along / v_along.max(V::c(0.1));
        let hits = v_across.mul_add(time, across).abs().le(V::c(half_width)).and(v_along.gt(V::c(0.1)));
        self.on_target = V::select(better, flag::<V>(hits), self.on_target);
        let (past, inside) = past_goal_plane(ball.pos, goal, heading, half_width);
        let crosses = past.and(is_set(self.crossed).not());
        self.scored = V::select(crosses.and(inside), one, self.scored);
        self.crossed = V::select(crosses, one, self.crossed);
    }
}

/// True if `ball` is past the plane through `goal` perpendicular to the heading, and within `half_width` of its center.
#[inline(always)]
fn past_goal_plane<V: Real>(
    ball: Vec3<V>,
    goal: Vec3<V>,
    heading: [V; 2],
    half_width: f64,
) -> (V::Mask, V::Mask) {
    let (dx, dy) = (ball.x() - goal.x(), ball.y() - goal.y());
    let along = dx * heading[0] + dy * heading[1];
    let across = dy * heading[0] - dx * heading[1];
    let past = along.ge(V::zero());
    (past, past.and(across.abs().le(V::c(half_width))))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn preset() -> KickPreset {
        KickPreset {
            contact_force_n: 10.0,
            window_steps: 2,
            z_window_steps: 1,
            z_min_speed: 0.5,
            min_ball_speed: 0.5,
            full_ball_speed: 0.0,
            early_s: 0.0,
            foot_only: false,
            any_foot: false,
        }
    }

    fn ball(force: f64, vel: [f64; 3], y: f64) -> BallState<f64> {
        BallState {
            pos: Vec3([0.0, y, 0.11]),
            vel: Vec3(vel),
            ang_vel: Vec3([0.0; 3]),
            robot_force: Vec3([force, 0.0, 0.0]),
            ground_force: Vec3([0.0, 0.0, 4.0]),
            touched_by: -1.0,
        }
    }

    const FEET: [(Vec3<f64>, usize); 2] = [(Vec3([0.2, 0.2, 0.0]), 6), (Vec3([-0.1, 0.2, 0.0]), 12)];

    /// Anchor and base.
    const POINTS: [Vec3<f64>; 2] = [Vec3([0.0, 3.0, 0.8]), Vec3([2.0, 0.0, 0.8])];

    #[test]
    fn the_first_hard_contact_with_the_labeled_foot_is_rewarded_once() {
        let mut kick = KickState::<f64>::new();
        kick.reset_lane(0, Some(1), [0.0, 0.0, 0.11], 0);
        let soft = kick.advance(&ball(9.9, [0.0; 3], 0.0), FEET, POINTS, &preset());
        assert!(!soft.first && !soft.window);
        let hit = kick.advance(&ball(50.0, [0.0, -2.0, 0.1], -0.01), FEET, POINTS, &preset());
        assert!(hit.first && hit.correct && hit.right && hit.window && hit.z_window);
        assert_eq!(kick.before.0, [0.0, 0.0, 0.11]);
        let again = kick.advance(&ball(50.0, [0.0, -2.0, 0.1], -0.1), FEET, POINTS, &preset());
        assert!(!again.first && !again.correct && again.window && !again.z_window);
        // Frozen at the first contact: the ball at y = -0.01.
        assert!(
            (kick.distance2[0] - 3.01 * 3.01).abs() < 1e-12 && (kick.distance2[1] - 4.0001).abs() < 1e-12
        );
        assert!(!kick.advance(&ball(0.0, [0.0, -2.0, 0.1], -0.2), FEET, POINTS, &preset()).window);
        assert_eq!(kick.since, 2.0);
    }

    #[test]
    fn a_touch_before_its_time_is_no_kick_and_spoils_the_later_one() {
        for (soft_steps, rewarded) in [(1, false), (2, true)] {
            let mut kick = KickState::<f64>::new();
            kick.reset_lane(0, Some(1), [0.0, 0.0, 0.11], 2);
            for _ in 0..soft_steps {
                kick.advance(&ball(0.0, [0.0; 3], 0.0), FEET, POINTS, &preset());
            }
            let hit = kick.advance(&ball(50.0, [0.0, -2.0, 0.1], 0.0), FEET, POINTS, &preset());
            assert_eq!((hit.first, hit.correct, hit.window), (true, rewarded, rewarded), "{soft_steps}");
            let later = kick.advance(&ball(50.0, [0.0, -5.0, 0.1], 0.0), FEET, POINTS, &preset());
            assert_eq!((later.first, later.window), (false, rewarded), "{soft_steps}");
        }
    }

    #[test]
    fn the_wrong_foot_touches_but_is_not_rewarded() {
        let mut kick = KickState::<f64>::new();
        kick.reset_lane(0, Some(0), [0.0, 0.0, 0.11], 0);
        let hit = kick.advance(&ball(50.0, [0.0, -2.0, 0.1], 0.0), FEET, POINTS, &preset());
        assert!(hit.first && !hit.correct && !hit.window && kick.touched == 1.0 && kick.correct == 0.0);
    }

    #[test]
    fn without_the_gate_the_wrong_foot_is_rewarded_and_still_counts_as_wrong() {
        let mut kick = KickState::<f64>::new();
        kick.reset_lane(0, Some(0), [0.0, 0.0, 0.11], 0);
        let preset = KickPreset { any_foot: true, ..preset() };
        let hit = kick.advance(&ball(50.0, [0.0, -2.0, 0.1], 0.0), FEET, POINTS, &preset);
        assert!(hit.first && hit.paid && hit.window && !hit.correct && kick.correct == 0.0);
    }

    #[test]
    fn a_shin_is_rewarded_only_where_the_nearer_foot_counts_for_it() {
        // Bodies 6 and 12 are the feet, 11 is the right shin; the right foot is the nearer one.
        for (foot_only, body, rewarded) in
            [(false, 11.0, true), (true, 11.0, false), (true, 6.0, false), (true, 12.0, true)]
        {
            let mut kick = KickState::<f64>::new();
            kick.reset_lane(0, Some(1), [0.0, 0.0, 0.11], 0);
            let touched = BallState { touched_by: body, ..ball(50.0, [0.0, -2.0, 0.0], 0.0) };
            let hit = kick.advance(&touched, FEET, POINTS, &KickPreset { foot_only, ..preset() });
            assert_eq!((hit.first, hit.correct), (true, rewarded), "{foot_only} {body}");
        }
    }

    #[test]
    fn either_foot_is_rewarded_where_none_is_labeled() {
        for ball_y in [0.1, -0.1] {
            let mut kick = KickState::<f64>::new();
            kick.reset_lane(0, None, [0.0, 0.0, 0.11], 0);
            let feet = [(Vec3([0.0, 0.2, 0.0]), 6), (Vec3([0.0, -0.2, 0.0]), 12)];
            let hit = kick.advance(&ball(50.0, [0.0, -2.0, 0.1], ball_y), feet, POINTS, &preset());
            assert!(hit.correct && hit.window && hit.right == (ball_y < 0.0), "{ball_y}");
        }
    }

    #[test]
    fn outcome_keeps_the_best_speed_and_the_goal() {
        let (goal, heading) = (Vec3([0.0, -5.0, 0.11]), [0.0, -1.0]);
        let mut kick = KickState::<f64>::new();
        kick.reset_lane(0, Some(1), [0.0, 0.0, 0.11], 0);
        let hit = ball(50.0, [0.3, -3.0, 0.0], -0.01);
        kick.advance(&hit, FEET, POINTS, &preset());
        kick.observe_outcome(&hit, goal, heading, 5, 1.0);
        assert!((kick.best_speed - 9.09_f64.sqrt()).abs() < 1e-12);
        assert!((kick.best_cosine - 3.0 / 9.09_f64.sqrt()).abs() < 1e-12);
        // After 4.99 / 3 s the ball is 0.499 m from the center.
        assert_eq!((kick.on_target, kick.scored), (1.0, 0.0));
        let far = ball(0.0, [0.0, -1.0, 0.0], -5.1);
        kick.observe_outcome(&far, goal, heading, 5, 1.0);
        assert_eq!((kick.crossed, kick.scored), (1.0, 1.0));
    }

    #[test]
    fn the_goal_is_crossed_within_its_width_only() {
        // Heading -y, goal at (0, -5).
        let (goal, heading) = (Vec3([0.0, -5.0, 0.1]), [0.0, -1.0]);
        assert_eq!(past_goal_plane(Vec3([0.9, -5.1, 0.1]), goal, heading, 1.0), (true, true));
        assert_eq!(past_goal_plane(Vec3([1.1, -5.1, 0.1]), goal, heading, 1.0), (true, false));
        assert_eq!(past_goal_plane(Vec3([0.0, -4.9, 0.1]), goal, heading, 1.0), (false, false));
    }
}
