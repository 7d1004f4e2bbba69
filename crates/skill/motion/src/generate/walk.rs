//! The steps to the ball.

use super::Foothold;
use super::plan::{KICK, PLANT};

/// Longest distance of the two ankles along the feet when one comes down [m]: what the legs reach at walking height.
const LONGEST_STRIDE: f64 = 0.36;
/// Least and largest distance across [m]: shins that do not touch; ankles that lean no farther than they can.
const ACROSS: [f64; 2] = [0.165, 0.31];
/// Longest distance of one foot in one step `[m]`.
const LONGEST_STEP: f64 = 0.70;
/// Largest turn from one foothold to the next `[rad]`, and in the whole walk.
const TURNS: [f64; 2] = [0.45, 0.75];
/// Turns of the last pair before the plant foot's step that are tried `[rad]`; a large positive one would have the kicking foot
/// in the ball.
const TAKE_OFF_TURNS: [f64; 6] = [0.0, 0.15, -0.15, -0.30, -0.45, 0.25];
/// Most steps.
const MOST: usize = 14;
/// Rounds of pulling footholds to where steps are good, and how far a step may then still be off `[m]`.
const ROUNDS: usize = 200;
const GOOD: f64 = 2e-3;

/// A walk: which foot goes where, in order.
pub type Walk = Vec<(usize, Foothold)>;

/// The fewest good steps from `start` to the plant foot, the last; the kicking foot's last hold is `take_off` from it `[m]`, in the
/// axes of a pair that may be turned a little. Under way the feet may turn toward the ball, so that one at the side is walked
/// to and not only side-stepped to. `extra` more steps than the fewest make every one of them easier.
pub fn approach(start: [Foothold; 2], plant: Foothold, take_off: [f64; 2], extra: usize) -> Option<Walk> {
    let mut found = None;
    for count in 2..=MOST {
        let mut best: Option<(f64, Walk)> = None;
        for turn in TAKE_OFF_TURNS {
            let turned = Foothold { xy: plant.xy, yaw: plant.yaw + turn };
            let goal = [plant, Foothold { xy: turned.point(take_off), yaw: turned.yaw }];
            let middle =
                |feet: [Foothold; 2]| [0, 1].map(|i| f64::midpoint(feet[PLANT].xy[i], feet[KICK].xy[i]));
            let (from, to) = (middle(start), middle(goal));
            let way = (to[1] - from[1]).atan2(to[0] - from[0]);
            for share in [0.0, 0.3, 0.6, 0.9] {
                let heading = (share * way).clamp(-TURNS[1], TURNS[1]);
                let Some(walk) = walk(start, goal, heading, count) else { continue };
                let cost = longest(start, &walk) + 0.3 * (heading.abs() + turn.abs());
                if best.as_ref().is_none_or(|(least, _)| cost < *least) {
                    best = Some((cost, walk));
                }
            }
        }
        if let Some((_, walk)) = best {
            let (least, _) = found.get_or_insert((count, walk.clone()));
            if count >= *least + extra {
                return Some(walk);
            }
        }
    }
    found.map(|(_, walk)| walk)
}

/// `count` steps, under way at `heading` as far as turns allow: spread evenly, then each foothold pulled to where the steps from
/// and to it are good. `None` if that does not converge.
fn walk(start: [Foothold; 2], goal: [Foothold; 2], heading: f64, count: usize) -> Option<Walk> {
    // The plant foot steps last, so the foot that steps first follows from the number of steps.
    let foot = |i: usize| if (count + i).is_multiple_of(2) { KICK } else { PLANT };
    // The holds in order, beginning with the two of the start; the foot that steps first is the older of them.
    let mut holds = vec![start[foot(0)], start[foot(1)]];
    for i in 0..count {
        let side = foot(i);
        if i + 2 >= count {
            holds.push(goal[side]);
            continue;
        }
        let share = (i + 1) as f64 / count as f64;
        let mix = |k: usize| start[side].xy[k] + share * (goal[side].xy[k] - start[side].xy[k]);
        let (end, before, after) =
            (goal[KICK].yaw, TURNS[0] * (i + 1) as f64, TURNS[0] * (count - 2 - i) as f64);
        let yaw = heading.clamp(-before, before).clamp(end - after, end + after);
        holds.push(Foothold { xy: [mix(0), mix(1)], yaw });
    }
    let free = 2..count;
    for _ in 0..ROUNDS {
        let mut off: f64 = 0.0;
        for k in 1..holds.len() - 1 {
            let push = correction(holds[k], foot(k), holds[k + 1]);
            off = off.max(push[0].hypot(push[1]));
            let (a, b) = (free.contains(&k), free.contains(&(k + 1)));
            let share = if a && b { 0.5 } else { 1.0 };
            for i in 0..2 {
                holds[k].xy[i] -= if a { share * push[i] } else { 0.0 };
                holds[k + 1].xy[i] += if b { share * push[i] } else { 0.0 };
            }
        }
        if off < GOOD {
            break;
        }
    }
    let good = (1..holds.len() - 1).all(|k| {
        let push = correction(holds[k], foot(k), holds[k + 1]);
        let way = (holds[k + 1].xy[0] - holds[k - 1].xy[0]).hypot(holds[k + 1].xy[1] - holds[k - 1].xy[1]);
        push[0].hypot(push[1]) < GOOD
            && way <= LONGEST_STEP
            && (holds[k + 1].yaw - holds[k].yaw).abs() <= TURNS[0] + 1e-9
    });
    good.then(|| (2..holds.len()).map(|k| (foot(k), holds[k])).collect())
}

/// How far `next` must move, world `[m]`, so that it and the standing foothold `hold` are neither too far apart nor too near.
fn correction(hold: Foothold, foot: usize, next: Foothold) -> [f64; 2] {
    let (s, c) = f64::midpoint(hold.yaw, next.yaw).sin_cos();
    let apart = [next.xy[0] - hold.xy[0], next.xy[1] - hold.xy[1]];
    let left = if foot == PLANT { -1.0 } else { 1.0 };
    let (along, across) = (c * apart[0] + s * apart[1], left * (c * apart[1] - s * apart[0]));
    let dx = along.clamp(-LONGEST_STRIDE, LONGEST_STRIDE) - along;
    let dy = left * (across.clamp(ACROSS[0], ACROSS[1]) - across);
    [c * dx - s * dy, s * dx + c * dy]
}

/// The longest distance of two successive holds `[m]`.
fn longest(start: [Foothold; 2], walk: &Walk) -> f64 {
    let mut at = start;
    let mut longest: f64 = 0.0;
    for &(foot, to) in walk {
        at[foot] = to;
        longest = longest.max((at[0].xy[0] - at[1].xy[0]).hypot(at[0].xy[1] - at[1].xy[1]));
    }
    longest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_leg_takes_a_stride_it_cannot() {
        let start = [0.12, -0.12].map(|y| Foothold { xy: [0.0, y], yaw: 0.0 });
        for (x, y, yaw) in [(0.5, 0.2, 0.0), (0.4, -0.3, 0.1), (1.2, -0.3, 0.2), (0.5, 0.6, -0.1)] {
            let plant = Foothold { xy: [x, y], yaw };
            let walk = approach(start, plant, [-0.25, -0.24], 0).expect("a way");
            assert_eq!(walk.last(), Some(&(PLANT, plant)));
            assert!(walk.windows(2).all(|pair| pair[0].0 != pair[1].0), "feet alternate");
            assert!(longest(start, &walk) <= LONGEST_STRIDE.hypot(ACROSS[1]) + 2.0 * GOOD);
        }
        let far = Foothold { xy: [4.5, 0.0], yaw: 0.0 };
        assert!(approach(start, far, [-0.25, -0.24], 0).is_none());
    }
}
