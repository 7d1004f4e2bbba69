//! What is fixed before the optimization: which frames are used, what is added, where the feet stand and when.

mod despike;
mod foothold;
mod neutral;
mod spans;
mod support;
mod swing;

pub(super) use foothold::FootGoal;
pub(super) use support::Support;
pub(super) use swing::Swing;

use paid_lanes::Vec3;

use super::CleanOptions;
use super::figure::{Figure, Frame};
use super::stance::{self, Span};
use crate::generate::{Pose, min_jerk};
use crate::slerp;
use foothold::Foothold;
use neutral::{Facing, Neutral, shot, stand};

/// Added before and after the motion: from the stand, into the stand, and at rest `[s]`.
const RISE: f64 = 0.7;
const SETTLE: f64 = 0.7;
const REST: f64 = 0.3;
/// Time of an added step in the air `[s]`.
const STEP: f64 = 0.5;
/// Motions that turn by more than this are left to turn `[rad]`.
const TURNABLE: f64 = 1.7;
/// The last stand's largest angle off the first one's heading `[rad]`; the check warns above 0.8.
const TURNED: f64 = 0.5;

/// The whole plan.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    pub fps: f64,
    /// The original, on the floor, with what is added.
    pub poses: Vec<Pose>,
    /// The frames of the original: first, one past the last.
    pub kept: Span,
    /// Frames added before and after.
    pub added: [usize; 2],
    /// The original's floor `[m]`.
    pub floor: f64,
    pub feet: [Vec<FootGoal>; 2],
    /// `None` in the air.
    pub support: Vec<Option<Support>>,
}

impl Plan {
    pub fn is_added(&self, t: usize) -> bool {
        t < self.added[0] || t >= self.poses.len() - self.added[1]
    }

    /// The robot rests at one of the ends.
    pub fn is_rest(&self, t: usize) -> bool {
        let rest = (REST * self.fps).round() as usize;
        t < rest || t + rest >= self.poses.len()
    }

    /// The plan for a motion whose foot `side` meets the ball in frame `kick`.
    pub fn new(
        figure: &Figure<'_>,
        original: &[Pose],
        options: &CleanOptions,
        side: usize,
        kick: usize,
    ) -> Self {
        let fps = options.fps;
        let mut frames: Vec<Frame> = original.iter().map(|p| figure.frame(p)).collect();
        let floor = stance::floor(figure, &frames, fps);
        let spans = stance::find(figure, &frames, fps, floor);
        let mut poses = original.to_vec();
        poses.iter_mut().for_each(|p| p.base_pos[2] -= floor);
        despike::despike(figure, &mut poses, fps);
        frames.iter_mut().for_each(|f| f.lower(floor));
        let kept = spans::keep(figure, &frames, &spans, fps, (options.lead_s, kick));
        let spans = spans::fill(spans, kept, fps);
        let count = |s: f64| (s * fps).round() as usize;
        let [rise, settle, rest, step] = [RISE, SETTLE, REST, STEP].map(count);

        // Each foot's stances with their footholds, in the original's frames; the feet at both ends.
        let own: [Vec<(Span, Foothold)>; 2] = [0, 1].map(|side| {
            let inside = spans[side].iter().map(|s| [s[0].max(kept[0]), s[1].min(kept[1])]);
            inside.filter(|s| s[0] < s[1]).map(|s| (s, Foothold::of(figure, &frames, side, s))).collect()
        });
        let begin = [0, 1].map(|side| match own[side].first() {
            Some((span, hold)) if span[0] == kept[0] => *hold,
            _ => Foothold::of(figure, &frames, side, [kept[0], kept[0] + 1]),
        });
        let finish = [0, 1].map(|side| match own[side].last() {
            Some((span, hold)) if span[1] == kept[1] => *hold,
            _ => Foothold::of(figure, &frames, side, [kept[1] - 1, kept[1]]),
        });
        // The foot that stays longer on its place at the start came there by a step; at the end the shorter step is taken.
        let stay = |side: usize| own[side].first().map_or(0, |(s, _)| if s[0] == kept[0] { s[1] } else { 0 });
        let mover = usize::from(stay(1) > stay(0));
        let facing =
            Facing { first: shot(&frames, figure.feet[side], kick), within: options.facing, below: TURNABLE };
        let before = Neutral::new(figure, begin, mover, facing);
        let facing = Facing { first: before.yaw, within: TURNED, below: std::f64::consts::PI };
        let ends = [0, 1].map(|mover| Neutral::new(figure, finish, mover, facing));
        let movers = [mover, usize::from(ends[1].effort < ends[0].effort)];
        let after = &ends[movers[1]];
        let added = [
            rest + rise + if before.step { step + settle } else { 0 },
            settle + rest + if after.step { step + settle } else { 0 },
        ];
        let length = added[0] + kept[1] - kept[0] + added[1];
        let shift = |t: usize| t.clamp(kept[0], kept[1]) - kept[0] + added[0];

        let mut holds: [Vec<(Span, Foothold)>; 2] = Default::default();
        for side in 0..2 {
            let list = &mut holds[side];
            list.extend(own[side].iter().map(|(s, hold)| ([shift(s[0]), shift(s[1])], *hold)));
            let steps = before.step && side == movers[0];
            let lands = if steps { rest + settle + step } else { 0 };
            match list.first_mut() {
                Some((span, _)) if span[0] == added[0] => span[0] = lands,
                _ => list.insert(0, ([lands, added[0]], begin[side])),
            }
            if steps {
                list.insert(0, ([0, lands - step], before.feet[side]));
            }
            let steps = after.step && side == movers[1];
            let lifts = if steps { length - added[1] + settle } else { length };
            match list.last_mut() {
                Some((span, _)) if span[1] == length - added[1] => span[1] = lifts,
                _ => list.push(([length - added[1], lifts], finish[side])),
            }
            if steps {
                list.push(([lifts + step, length], after.feet[side]));
            }
        }

        let ends = [stand(figure, &before), stand(figure, after)];
        let mut all = Vec::with_capacity(length);
        let (first, last) = (&poses[kept[0]], &poses[kept[1] - 1]);
        all.extend((0..added[0]).map(|t| {
            let s = (t as f64 - rest as f64).max(0.0) / (added[0] - rest) as f64;
            mix(&ends[0], first, min_jerk(s))
        }));
        all.extend_from_slice(&poses[kept[0]..kept[1]]);
        let way = (added[1] - rest) as f64;
        all.extend((0..added[1]).map(|t| mix(last, &ends[1], min_jerk((t + 1) as f64 / way))));

        let kick = shift(kick);
        let feet = [0, 1].map(|s| {
            let strike = (s == side).then_some(kick);
            swing::goals(figure, &all, s, &holds, strike, [added[0], length - added[1]], fps)
        });
        let support = support::support(figure, &feet, fps);
        Self { fps, poses: all, kept, added, floor, feet, support }
    }

    /// Frames in the air.
    pub fn flight(&self) -> usize {
        self.support.iter().filter(|s| s.is_none()).count()
    }
}

impl Frame {
    fn lower(&mut self, by: f64) {
        let down = Vec3([0.0, 0.0, by]);
        self.pos.iter_mut().chain(&mut self.com).for_each(|p| *p = *p - down);
    }
}

/// The pose a share `s` of the way from `a` to `b`.
pub(super) fn mix(a: &Pose, b: &Pose, s: f64) -> Pose {
    let mid = |x: f64, y: f64| x + (y - x) * s;
    Pose {
        base_pos: std::array::from_fn(|k| mid(a.base_pos[k], b.base_pos[k])),
        base_quat: slerp(a.base_quat, b.base_quat, s),
        joints: a.joints.iter().zip(&b.joints).map(|(x, y)| mid(*x, *y)).collect(),
    }
}
