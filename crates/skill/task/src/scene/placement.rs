//! Where ball and goal are put at the start of an episode.

use paid_lanes::rng::Rng;
use paid_play::{MotionFacts, nearest_motion, own_place, turned};

use crate::preset::{BallPlacement, GoalPreset};

/// How far from a motion's own place a ball about it lies at most, in x and in y `[m]`.
const ABOUT_M: f64 = 0.3;

/// Draws a ball from the workspace, start frame `[m]`.
pub(crate) fn draw_from_workspace(preset: &BallPlacement, rng: &mut Rng) -> [f64; 2] {
    let [near, far] = preset.ahead_m;
    let [right, left] = preset.left_m;
    let x = rng.uniform(near, far);
    [x, rng.uniform(right, left)]
}

/// Draws a ball that belongs to `motion` from the workspace, start frame `[m]`: up to 64 draws, then the motion's own place.
pub(crate) fn draw_ball_of_motion(
    motions: &[MotionFacts],
    motion: usize,
    preset: &BallPlacement,
    rng: &mut Rng,
) -> [f64; 2] {
    for _ in 0..64 {
        let ball = draw_from_workspace(preset, rng);
        if nearest_motion(motions, ball) == motion {
            return ball;
        }
    }
    own_place(&motions[motion])
}

/// Draws a ball about the motion's own place, start frame `[m]`.
pub(crate) fn draw_ball_about(facts: &MotionFacts, rng: &mut Rng) -> [f64; 2] {
    own_place(facts).map(|x| x + rng.uniform(-ABOUT_M, ABOUT_M))
}

/// A ball of the workspace (start frame) moved toward its motion's nominal place until `reach` of the way between is left.
/// Its nearest motion stays the same.
pub(crate) fn drawn_in(ball: [f64; 2], facts: &MotionFacts, reach: f64) -> [f64; 2] {
    let nominal = own_place(facts);
    [nominal[0] + reach * (ball[0] - nominal[0]), nominal[1] + reach * (ball[1] - nominal[1])]
}

/// Draws a ball from the arc around the nominal place: angle and radius of the displacement are offset uniformly.
pub(crate) fn draw_ball(facts: &MotionFacts, preset: &BallPlacement, rng: &mut Rng) -> [f64; 2] {
    let [dx, dy] = facts.displacement;
    let angle = dy.atan2(dx) + rng.uniform(-preset.angle_deg, preset.angle_deg).to_radians();
    let radius = dx.hypot(dy) + rng.uniform(-preset.radius_m, preset.radius_m);
    [facts.start_xy[0] + radius * angle.cos(), facts.start_xy[1] + radius * angle.sin()]
}

/// True if the ball is at least `clearance` away from both feet, horizontally.
pub(crate) fn is_clear(ball: [f64; 2], feet: &[[f64; 2]; 2], clearance: f64) -> bool {
    feet.iter().all(|f| (ball[0] - f[0]).hypot(ball[1] - f[1]) >= clearance)
}

/// A ball that is clear of the feet: up to 16 draws from the arc, then the last one moved straight away from the feet's
/// middle as far as needed.
pub(crate) fn clear_ball(
    facts: &MotionFacts,
    preset: &BallPlacement,
    clearance_m: f64,
    feet: &[[f64; 2]; 2],
    rng: &mut Rng,
) -> [f64; 2] {
    let mut ball = draw_ball(facts, preset, rng);
    for _ in 0..15 {
        if is_clear(ball, feet, clearance_m) {
            return ball;
        }
        ball = draw_ball(facts, preset, rng);
    }
    moved_clear(ball, facts.displacement, clearance_m, feet)
}

/// `ball` moved straight away from the feet's middle until it is clear of them; along `way` if it lies on the middle.
pub(crate) fn moved_clear(
    mut ball: [f64; 2],
    way: [f64; 2],
    clearance: f64,
    feet: &[[f64; 2]; 2],
) -> [f64; 2] {
    let middle = [f64::midpoint(feet[0][0], feet[1][0]), f64::midpoint(feet[0][1], feet[1][1])];
    let from = [ball[0] - middle[0], ball[1] - middle[1]];
    let length = from[0].hypot(from[1]);
    let heading = way[1].atan2(way[0]);
    let unit =
        if length > 1e-3 { [from[0] / length, from[1] / length] } else { [heading.cos(), heading.sin()] };
    let mut distance = length;
    while !is_clear(ball, feet, clearance) && distance < length + 2.0 {
        distance += 0.02;
        ball = [middle[0] + distance * unit[0], middle[1] + distance * unit[1]];
    }
    ball
}

/// The center of the goal rectangle: ahead of the motion's first base position, world `[m]`.
pub(crate) fn nominal_goal(facts: &MotionFacts, preset: &GoalPreset) -> [f64; 2] {
    let [x, y] = turned([preset.distance_m, 0.0], facts.heading);
    [facts.base_xy[0] + x, facts.base_xy[1] + y]
}

/// Draws a goal center from the rectangle, world `[m]`.
pub(crate) fn draw_goal(facts: &MotionFacts, preset: &GoalPreset, rng: &mut Rng) -> [f64; 2] {
    let along = preset.rectangle_along_m * (rng.unit() - 0.5);
    let across = preset.rectangle_across_m * (rng.unit() - 0.5);
    let [cx, cy] = nominal_goal(facts, preset);
    let [x, y] = turned([along, across], facts.heading);
    [cx + x, cy + y]
}

#[cfg(test)]
mod tests {
    use paid_play::{AfterStrikePreset, OwnPlace, nominal_ball};

    use super::*;
    use crate::preset::BallRule;

    fn facts() -> MotionFacts {
        MotionFacts {
            name: "m".into(),
            frames: 100,
            kick_foot: 1,
            strike_frame: 70,
            contact_frame: 70,
            strike_speed: 5.0,
            start_xy: [1.0, 2.0],
            base_xy: [1.1, 2.0],
            heading: -core::f64::consts::FRAC_PI_2,
            displacement: [0.0, -0.8],
        }
    }

    fn arc() -> BallPlacement {
        BallPlacement {
            rule: BallRule::Arc,
            own_place: OwnPlace::TorsoEnd,
            ahead_m: [0.25, 2.25],
            left_m: [-1.25, 1.25],
            angle_deg: 20.0,
            radius_m: 0.25,
            own_place_share: 0.0,
            spread_from: 1.0,
            spread_at: 0.25,
            spread_iterations: 300,
            velocity: 0.3,
            rolling_share: 0.5,
            clearance_m: 0.3,
            contact_s: Default::default(),
            after_strike: AfterStrikePreset::default(),
        }
    }

    #[test]
    fn balls_fill_the_arc_around_the_nominal_place() {
        let mut rng = Rng::new(1, 0, 0);
        let (mut near, mut far, mut left, mut right) = (f64::MAX, 0.0_f64, 0.0_f64, 0.0_f64);
        for _ in 0..2000 {
            let ball = draw_ball(&facts(), &arc(), &mut rng);
            let (dx, dy) = (ball[0] - 1.0, ball[1] - 2.0);
            let (radius, angle) = (dx.hypot(dy), dx.atan2(-dy).to_degrees());
            (near, far) = (near.min(radius), far.max(radius));
            (left, right) = (left.min(angle), right.max(angle));
        }
        assert!((near - 0.55).abs() < 0.01 && (far - 1.05).abs() < 0.01, "{near} {far}");
        assert!((left + 20.0).abs() < 0.3 && (right - 20.0).abs() < 0.3, "{left} {right}");
        let nominal = nominal_ball(&facts());
        assert!((nominal[0] - 1.0).abs() < 1e-12 && (nominal[1] - 1.2).abs() < 1e-12);
    }

    #[test]
    fn a_workspace_ball_belongs_to_the_nearest_motion() {
        let far = MotionFacts { displacement: [0.4, -1.3], ..facts() };
        let motions = [facts(), far];
        // Heading -y: ahead is -y, left is +x.
        assert_eq!(nearest_motion(&motions, [0.9, 0.1]), 0);
        assert_eq!(nearest_motion(&motions, [1.2, 0.3]), 1);
        let mut rng = Rng::new(3, 0, 0);
        for motion in 0..2 {
            for _ in 0..200 {
                let ball = draw_ball_of_motion(&motions, motion, &arc(), &mut rng);
                assert_eq!(nearest_motion(&motions, ball), motion);
                assert!((0.25..2.25).contains(&ball[0]) && (-1.25..1.25).contains(&ball[1]), "{ball:?}");
            }
        }
        // No place of the workspace belongs to the second of two equal motions.
        let ball = draw_ball_of_motion(&[facts(), facts()], 1, &arc(), &mut rng);
        assert!((ball[0] - 0.8).abs() < 1e-12 && ball[1].abs() < 1e-12, "{ball:?}");
    }

    #[test]
    fn a_ball_about_a_motions_place_is_within_30_cm_also_where_another_is_nearer() {
        // In the start frame the motions' places are 0.1 m apart.
        let beside = MotionFacts { displacement: [0.1, -0.8], ..facts() };
        let mut rng = Rng::new(5, 0, 0);
        let balls: Vec<_> = (0..400).map(|_| draw_ball_about(&facts(), &mut rng)).collect();
        assert!(balls.iter().all(|[x, y]| (x - 0.8).abs() <= 0.3 && y.abs() <= 0.3));
        assert!(balls.iter().any(|ball| nearest_motion(&[facts(), beside.clone()], *ball) == 1));
        assert!(balls.iter().any(|[x, y]| (x - 0.8).abs() > 0.28 || y.abs() > 0.28));
    }

    #[test]
    fn goals_fill_the_rectangle_ahead() {
        let preset =
            GoalPreset { distance_m: 5.0, rectangle_across_m: 1.0, rectangle_along_m: 0.5, width_m: 2.0 };
        let mut rng = Rng::new(1, 0, 0);
        let (mut lo, mut hi) = ([f64::MAX; 2], [f64::MIN; 2]);
        for _ in 0..2000 {
            let goal = draw_goal(&facts(), &preset, &mut rng);
            for k in 0..2 {
                (lo[k], hi[k]) = (lo[k].min(goal[k]), hi[k].max(goal[k]));
            }
        }
        let expected = [(lo[0], 0.6), (hi[0], 1.6), (lo[1], -3.25), (hi[1], -2.75)];
        assert!(expected.iter().all(|(a, b)| (a - b).abs() < 0.01), "{lo:?} {hi:?}");
    }

    #[test]
    fn a_ball_under_a_foot_is_moved_clear() {
        let placement = BallPlacement { angle_deg: 0.0, radius_m: 0.0, ..arc() };
        let feet = [[1.1, 1.2], [0.9, 1.25]];
        let ball = clear_ball(&facts(), &placement, 0.3, &feet, &mut Rng::new(0, 0, 0));
        assert!(is_clear(ball, &feet, 0.3), "{ball:?}");
    }
}
