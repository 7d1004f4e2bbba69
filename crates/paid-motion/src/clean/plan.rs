//! What is fixed before the optimization: which frames are used, what is added, where the feet stand and when.

use paid_lanes::{Quat, Vec3};

use super::figure::{Figure, Frame};
use super::stance::{self, Span};
use crate::generate::{Pose, bump, min_jerk};
use crate::{GRAVITY, hull, slerp};

/// Longest time before the kick that is kept `[s]`.
const LEAD: f64 = 4.5;
/// A base slower than this stands `[m/s]`.
const CALM: f64 = 0.15;
/// Added before and after the motion: from the stand, into the stand, and at rest `[s]`.
const RISE: f64 = 0.7;
const SETTLE: f64 = 0.7;
const REST: f64 = 0.3;
/// An added step: time in the air `[s]` and height `[m]`.
const STEP: f64 = 0.5;
const STEP_HEIGHT: f64 = 0.05;
/// Height over the floor that a foot in the air keeps `[m]`.
const CLEAR: f64 = 0.006;
/// Distance in which a step passes the other foot `[m]`.
const PASSING: f64 = 0.16;
/// Feet further than this from where a stand has them are brought there by a step `[m, rad]`.
const AWKWARD: [f64; 2] = [0.12, 0.35];
/// A stand's largest angle off the first heading `[rad]`; the check warns above 0.8.
const TURNED: f64 = 0.5;
/// Motions that turn by more than this are left to turn `[rad]`.
const TURNABLE: f64 = 1.7;
/// A stance is prolonged by at most this to shorten a flight `[s]`.
const FILL: f64 = 0.04;
/// A foot that the original tilts by less is flat, and the most by which it is tilted while it stands `[rad]`.
const FLAT: f64 = 0.12;
const ROLL: f64 = 0.6;
/// Half the depth of the floor's contact with heel or toes alone `[m]`: the check lets the pressure be 2 cm outside of the balls.
const EDGE: f64 = 0.012;
/// Joints that change their speed in a frame by more than this share of its limit are smoothed, over this many frames to both sides, at
/// most so many times.
const SPIKE: f64 = 0.40;
const SPIKE_REACH: usize = 3;
const SPIKE_ROUNDS: usize = 40;
/// Frames about the kick in which the foot's way is sacred `[s]`.
const STRIKE: f64 = 0.10;
/// Time beside a stance in which a foot may leave its way `[s]`.
const BLEND: f64 = 0.06;
/// Standing longer than this asks for a wider margin of the pressure `[s]`.
const LONG: f64 = 0.4;
/// Margin of the center of pressure inside the soles: in passing, on one foot for long, on two for long `[m]`.
const MARGINS: [f64; 3] = [0.004, 0.008, 0.015];

/// How closely a foot in the air follows the original.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Swing {
    /// At the kick.
    Strike,
    /// Elsewhere in the air.
    Free,
    /// Just before or after it stands.
    Near,
}

/// Where a foot shall be in a frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct FootGoal {
    /// The point of the foot that is meant, foot frame `[m]`.
    pub pivot: Vec3<f64>,
    /// Where it shall be, world `[m]`.
    pub pos: Vec3<f64>,
    pub quat: Quat<f64>,
    pub stands: bool,
    /// It stands on its heel or its toes alone.
    pub rolls: bool,
    pub width: Swing,
}

/// The floor under the standing soles.
#[derive(Clone, Debug)]
pub(super) struct Support {
    /// Counterclockwise, world x, y `[m]`.
    pub corners: Vec<[f64; 2]>,
    /// `[m]`.
    pub margin: f64,
}

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
    pub fn new(figure: &Figure<'_>, original: &[Pose], fps: f64, side: usize, kick: usize) -> Self {
        let mut frames: Vec<Frame> = original.iter().map(|p| figure.frame(p)).collect();
        let floor = stance::floor(figure, &frames, fps);
        let spans = stance::find(figure, &frames, fps, floor);
        let mut poses = original.to_vec();
        poses.iter_mut().for_each(|p| p.base_pos[2] -= floor);
        despike(figure, &mut poses, fps);
        frames.iter_mut().for_each(|f| f.lower(floor));
        let kept = keep(figure, &frames, &spans, fps, kick);
        let spans = fill(spans, kept, fps);
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
        let before = Neutral::new(figure, begin, mover, (shot(&frames, figure.feet[side], kick), TURNABLE));
        let options =
            [0, 1].map(|mover| Neutral::new(figure, finish, mover, (before.yaw, std::f64::consts::PI)));
        let movers = [mover, usize::from(options[1].effort < options[0].effort)];
        let after = &options[movers[1]];
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
            goals(figure, &all, s, &holds, strike, [added[0], length - added[1]], fps)
        });
        let support = support(figure, &feet, fps);
        Self { fps, poses: all, kept, added, floor, feet, support }
    }

    /// Frames in the air.
    pub fn flight(&self) -> usize {
        self.support.iter().filter(|s| s.is_none()).count()
    }
}

/// Joints that jump from frame to frame are smoothed there and near there (weights 1, 2, 1, again and again), until they do not.
fn despike(figure: &Figure<'_>, poses: &mut [Pose], fps: f64) {
    let last = poses.len() - 1;
    for (j, limit) in figure.speed_limit.iter().enumerate() {
        for _ in 0..SPIKE_ROUNDS {
            let q: Vec<f64> = poses.iter().map(|p| p.joints[j]).collect();
            let jumps = (1..last).filter(|&t| (q[t + 1] - 2.0 * q[t] + q[t - 1]).abs() * fps > SPIKE * limit);
            let mut near = vec![false; q.len()];
            for t in jumps {
                near[t.saturating_sub(SPIKE_REACH)..=(t + SPIKE_REACH).min(last)].fill(true);
            }
            if !near.contains(&true) {
                break;
            }
            for t in 1..last {
                if near[t] {
                    poses[t].joints[j] = 0.25 * (q[t - 1] + 2.0 * q[t] + q[t + 1]);
                }
            }
        }
    }
}

impl Frame {
    fn lower(&mut self, by: f64) {
        let down = Vec3([0.0, 0.0, by]);
        self.pos.iter_mut().chain(&mut self.com).for_each(|p| *p = *p - down);
    }
}

/// A foot flat on the floor.
#[derive(Clone, Copy, Debug)]
struct Foothold {
    pos: Vec3<f64>,
    yaw: f64,
}

impl Foothold {
    /// Where a foot stands in a span: the median of its places while it is flattest.
    fn of(figure: &Figure<'_>, frames: &[Frame], side: usize, span: Span) -> Self {
        let foot = figure.feet[side];
        let tilt = |t: &usize| frames[*t].quat[foot].rotate(Vec3([0.0, 0.0, 1.0])).z();
        let mut order: Vec<usize> = (span[0]..span[1]).collect();
        order.sort_by(|a, b| tilt(b).total_cmp(&tilt(a)));
        order.truncate(order.len().div_ceil(2));
        let median = |of: &dyn Fn(usize) -> f64| {
            let mut values: Vec<f64> = order.iter().map(|t| of(*t)).collect();
            values.sort_by(f64::total_cmp);
            values.get(values.len() / 2).copied().unwrap_or(0.0)
        };
        // Angles about that of one frame, so that none wraps.
        let yaw = |t: usize| frames[t].quat[foot].to_mat().yaw();
        let about = order.first().map_or(0.0, |t| yaw(*t));
        let turn = median(&|t| {
            let (s, c) = (yaw(t) - about).sin_cos();
            s.atan2(c)
        });
        let at = |k: usize| median(&|t| frames[t].pos[foot].0[k]);
        Self { pos: Vec3([at(0), at(1), figure.sole_height(side)]), yaw: about + turn }
    }

    fn quat(&self) -> Quat<f64> {
        Quat::from_axis_angle(Vec3([0.0, 0.0, 1.0]), self.yaw)
    }

    /// The foot on this place, toes down by `pitch` about its toes or up about its heel.
    fn goal(&self, figure: &Figure<'_>, side: usize, pitch: f64) -> FootGoal {
        let rolls = pitch != 0.0;
        let pivot = if rolls { edge(figure, side, pitch > 0.0) } else { Vec3::zero() };
        let quat = Quat::from_roll_pitch_yaw(0.0, pitch, self.yaw);
        let pos = self.pos + self.quat().rotate(pivot);
        FootGoal { pivot, pos, quat, stands: true, rolls, width: Swing::Near }
    }
}

/// The middle of the toes' or the heel's balls, foot frame `[m]`.
fn edge(figure: &Figure<'_>, side: usize, toes: bool) -> Vec3<f64> {
    let soles = figure.soles[side].iter().map(|(p, _)| *p);
    let (low, high) =
        soles.clone().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p.x()), h.max(p.x())));
    let x = if toes { high } else { low };
    let z = soles.map(|p| p.z()).fold(f64::INFINITY, f64::min);
    Vec3([x, 0.0, z])
}

/// Pitch of a foot that stands in `span`: flat, but on its toes before it leaves and on its heel after it comes down for as long as the
/// original is.
fn roll_over(pitches: &[f64], span: Span, t: usize) -> f64 {
    let most = |pitch: f64| (pitch - FLAT).min(ROLL);
    if span[1] < pitches.len() && pitches[t..span[1]].iter().all(|p| *p > FLAT) {
        most(pitches[t])
    } else if span[0] > 0 && pitches[span[0]..=t].iter().all(|p| *p < -FLAT) {
        -most(-pitches[t])
    } else {
        0.0
    }
}

/// The frames that are kept: from the first calm stand (or the first frame) to the first stand after the kick that can be held.
fn keep(figure: &Figure<'_>, frames: &[Frame], spans: &[Vec<Span>; 2], fps: f64, kick: usize) -> Span {
    let both = |t: usize| stance::stands(&spans[0], t) && stance::stands(&spans[1], t);
    let speed = |t: usize| {
        let (a, b) = (t.saturating_sub(1), (t + 1).min(frames.len() - 1));
        (frames[b].pos[0] - frames[a].pos[0]).scale(fps / (b - a).max(1) as f64)
    };
    let earliest = kick.saturating_sub((LEAD * fps) as usize);
    let latest = kick.saturating_sub((0.4 * fps) as usize);
    let start = (earliest..latest)
        .find(|&t| both(t) && speed(t).norm() < CALM)
        .filter(|&t| t < earliest + (1.5 * fps) as usize)
        .or_else(|| (earliest..latest).find(|&t| both(t)).filter(|&t| t < earliest + (0.5 * fps) as usize))
        .unwrap_or(earliest);
    // How far the point at which the robot comes to rest (LIPM) is from the middle of the feet.
    let reach = |t: usize| {
        let pos = frames[t].pos[0];
        let rest = pos + speed(t).scale((pos.z().max(0.1) / GRAVITY).sqrt());
        let [a, b] = figure.feet.map(|foot| frames[t].pos[foot]);
        let middle = (a + b).scale(0.5);
        let spread = 0.5 * (a - b).norm();
        (rest.x() - middle.x()).hypot(rest.y() - middle.y()) - spread
    };
    let after = (kick + (0.1 * fps) as usize).min(frames.len() - 1);
    let candidates: Vec<usize> = (after..frames.len()).filter(|&t| both(t)).collect();
    let end = candidates
        .iter()
        .copied()
        .find(|&t| reach(t) < 0.02)
        .or_else(|| candidates.iter().copied().min_by(|a, b| reach(*a).total_cmp(&reach(*b))))
        .unwrap_or(frames.len() - 1);
    [start, end + 1]
}

/// Prolongs stances into flights.
fn fill(mut spans: [Vec<Span>; 2], kept: Span, fps: f64) -> [Vec<Span>; 2] {
    let most = (FILL * fps).round() as usize;
    let stands = |spans: &[Vec<Span>; 2], t: usize| (0..2).any(|s| stance::stands(&spans[s], t));
    let mut t = kept[0];
    while t < kept[1] {
        if stands(&spans, t) {
            t += 1;
            continue;
        }
        let from = t;
        while t < kept[1] && !stands(&spans, t) {
            t += 1;
        }
        // Two frames of both feet, if it is short enough.
        let each = ((t - from).div_ceil(2) + 1).min(most);
        for list in &mut spans {
            for span in list {
                if span[1] == from {
                    span[1] = (from + each).min(kept[1]);
                }
                if span[0] == t {
                    span[0] = t.saturating_sub(each).max(kept[0]);
                }
            }
        }
    }
    // The same foot's stances may have met.
    spans.map(|list| {
        let mut out: Vec<Span> = Vec::new();
        for span in list {
            match out.last_mut() {
                Some(before) if before[1] + 1 >= span[0] => before[1] = before[1].max(span[1]),
                _ => out.push(span),
            }
        }
        out
    })
}

/// A stand at an end of the motion.
struct Neutral {
    feet: [Foothold; 2],
    /// Heading of the base `[rad]`.
    yaw: f64,
    /// One foot is brought to its place by a step.
    step: bool,
    /// How long that step is, with a turn of one radian as bad as half a meter `[m]`.
    effort: f64,
}

impl Neutral {
    /// A stand for feet that are at `feet`: as they are, or with `mover` beside the other. The stand is turned at most
    /// [`TURNED`] from the heading `first`, if it is off by less than `turnable`.
    fn new(figure: &Figure<'_>, feet: [Foothold; 2], mover: usize, (first, turnable): (f64, f64)) -> Self {
        let wrap = |angle: f64| angle.sin().atan2(angle.cos());
        let near = |yaw: f64| {
            let off = wrap(yaw - first);
            if off.abs() > turnable { yaw } else { first + off.clamp(-TURNED, TURNED) }
        };
        let rest = figure.frame(&Pose {
            base_pos: [0.0; 3],
            base_quat: [1.0, 0.0, 0.0, 0.0],
            joints: figure.default_pos.clone(),
        });
        let anchor = feet[1 - mover];
        let yaw = near(anchor.yaw);
        let apart = rest.pos[figure.feet[mover]] - rest.pos[figure.feet[1 - mover]];
        let turn = Quat::from_axis_angle(Vec3([0.0, 0.0, 1.0]), yaw);
        let mut beside = feet;
        beside[mover].pos = anchor.pos + turn.rotate(Vec3([apart.x(), apart.y(), 0.0]));
        beside[mover].yaw = yaw;
        let off = (beside[mover].pos - feet[mover].pos).norm();
        let turned = wrap(feet[mover].yaw - anchor.yaw).abs();
        let middle = anchor.yaw + 0.5 * wrap(feet[mover].yaw - anchor.yaw);
        let far = (TURNED..turnable).contains(&wrap(middle - first).abs());
        if off > AWKWARD[0] || turned > AWKWARD[1] || far {
            let turned = wrap(anchor.yaw - yaw).abs() + wrap(feet[mover].yaw - yaw).abs();
            Self { feet: beside, yaw, step: true, effort: off + 0.5 * turned }
        } else {
            Self { feet, yaw: middle, step: false, effort: 0.0 }
        }
    }
}

/// Heading in which a foot moves `[rad]`.
fn shot(frames: &[Frame], foot: usize, kick: usize) -> f64 {
    let (a, b) = (kick.saturating_sub(1), (kick + 1).min(frames.len() - 1));
    let way = frames[b].com[foot] - frames[a].com[foot];
    way.y().atan2(way.x())
}

/// The upright pose of a stand.
fn stand(figure: &Figure<'_>, at: &Neutral) -> Pose {
    let middle = (at.feet[0].pos + at.feet[1].pos).scale(0.5);
    let spread = (at.feet[0].pos - at.feet[1].pos).norm();
    let frame = figure.frame(&Pose {
        base_pos: [0.0; 3],
        base_quat: [1.0, 0.0, 0.0, 0.0],
        joints: figure.default_pos.clone(),
    });
    let leg = -frame.pos[figure.feet[0]].z();
    let wide = 0.5 * (spread - (frame.pos[figure.feet[0]] - frame.pos[figure.feet[1]]).norm()).max(0.0);
    let height = (leg * leg - wide * wide).max(0.25 * leg * leg).sqrt() + figure.sole_height(0);
    Pose {
        base_pos: [middle.x(), middle.y(), height],
        base_quat: Quat::from_axis_angle(Vec3([0.0, 0.0, 1.0]), at.yaw).0,
        joints: figure.default_pos.clone(),
    }
}

/// How far the middle of a step goes to the side, so that it passes the foot that stands.
fn around(from: Vec3<f64>, to: Vec3<f64>, other: Vec3<f64>) -> Vec3<f64> {
    let way = Vec3([to.x() - from.x(), to.y() - from.y(), 0.0]);
    let off = Vec3([other.x() - from.x(), other.y() - from.y(), 0.0]);
    let along = (off.dot(way) / way.norm2().max(1e-9)).clamp(0.0, 1.0);
    let near = way.scale(along) - off;
    // The side on which it ends is the side on which it passes.
    let end = Vec3([to.x() - other.x(), to.y() - other.y(), 0.0]);
    let distance = near.norm();
    if distance >= PASSING {
        return Vec3::zero();
    }
    let left = Vec3([-way.y(), way.x(), 0.0]);
    let left = left.scale(1.0 / left.norm().max(1e-9));
    let sign = if end.dot(left) + near.dot(left) >= 0.0 { 1.0 } else { -1.0 };
    left.scale(sign * (PASSING - sign * near.dot(left)))
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

/// A foot's way: its footholds, and between them the original, moved by as much as the footholds were.
fn goals(
    figure: &Figure<'_>,
    poses: &[Pose],
    side: usize,
    all_holds: &[Vec<(Span, Foothold)>; 2],
    strike: Option<usize>,
    kept: Span,
    fps: f64,
) -> Vec<FootGoal> {
    let foot = figure.feet[side];
    let holds = &all_holds[side];
    // The other foot, which stands while this one takes an added step.
    let beside = |t: usize| {
        let others = &all_holds[1 - side];
        others.iter().find(|(span, _)| span[1] > t).or(others.last()).map_or(holds[0].1, |(_, hold)| *hold)
    };
    let frames: Vec<Frame> = poses.iter().map(|p| figure.frame(p)).collect();
    let [blend, near] = [BLEND, STRIKE].map(|s| (s * fps).round() as usize);
    let pitches: Vec<f64> = frames
        .iter()
        .map(|f| {
            let ahead = f.quat[foot].rotate(Vec3([1.0, 0.0, 0.0]));
            (-ahead.z()).atan2(ahead.x().hypot(ahead.y()))
        })
        .collect();
    (0..poses.len())
        .map(|t| {
            if let Some((span, hold)) = holds.iter().find(|(span, _)| (span[0]..span[1]).contains(&t)) {
                let pitch = roll_over(&pitches, *span, t);
                return hold.goal(figure, side, pitch);
            }
            let before = holds.iter().rev().find(|(span, _)| span[1] <= t);
            let after = holds.iter().find(|(span, _)| span[0] > t);
            // An added step is on nobody's way.
            if let (Some((a, from)), Some((b, to))) = (before, after)
                && (b[0] <= kept[0] || a[1] >= kept[1])
            {
                let s = (t + 1 - a[1]) as f64 / (b[0] + 1 - a[1]) as f64;
                let mut pos = from.pos + (to.pos - from.pos).scale(min_jerk(s));
                pos.0[2] += STEP_HEIGHT * bump(s);
                pos += (around(from.pos, to.pos, beside(t).pos)).scale(bump(s));
                let quat = Quat(slerp(from.quat().0, to.quat().0, min_jerk(s)));
                return FootGoal {
                    pivot: Vec3::zero(),
                    pos,
                    quat,
                    stands: false,
                    rolls: false,
                    width: Swing::Free,
                };
            }
            let off = |at: usize, hold: &Foothold| {
                let off = hold.pos - frames[at].pos[foot];
                // Heights are the original's: a heel that rises is no reason to lower the whole way.
                Vec3([off.x(), off.y(), 0.0])
            };
            let shift = match (before, after) {
                (Some((a, from)), Some((b, to))) => {
                    let (x, y) = (off(a[1] - 1, from), off(b[0], to));
                    let s = min_jerk((t + 1 - a[1]) as f64 / (b[0] + 1 - a[1]) as f64);
                    x + (y - x).scale(s)
                }
                (Some((a, hold)), None) => off(a[1] - 1, hold),
                (None, Some((b, hold))) => off(b[0], hold),
                (None, None) => Vec3::zero(),
            };
            let close = before.is_some_and(|(a, _)| t < a[1] + blend)
                || after.is_some_and(|(b, _)| t + blend >= b[0]);
            let width = match strike {
                Some(kick) if t.abs_diff(kick) <= near => Swing::Strike,
                _ if close => Swing::Near,
                _ => Swing::Free,
            };
            let (mut pos, quat) = (frames[t].pos[foot] + shift, frames[t].quat[foot]);
            let lowest =
                figure.sole_points(&frames[t], side).iter().map(Vec3::z).fold(f64::INFINITY, f64::min);
            pos.0[2] += (CLEAR - lowest).max(0.0);
            FootGoal { pivot: Vec3::zero(), pos, quat, stands: false, rolls: false, width }
        })
        .collect()
}

/// The floor under the feet of each frame. A foot that has only just come down, or is about to leave, counts only if no other stands.
fn support(figure: &Figure<'_>, feet: &[Vec<FootGoal>; 2], fps: f64) -> Vec<Option<Support>> {
    let long = (LONG * fps).round() as usize;
    let length = feet[0].len();
    let stance = |side: usize, t: usize| {
        let goals = &feet[side];
        let from = (0..=t).rev().find(|&s| !goals[s].stands).map_or(0, |s| s + 1);
        let to = (t..length).find(|&s| !goals[s].stands).unwrap_or(length);
        [from, to]
    };
    let corners = |side: usize, goal: &FootGoal| -> Vec<[f64; 2]> {
        let place = |p: Vec3<f64>| {
            let at = goal.pos + goal.quat.rotate(p - goal.pivot);
            [at.x(), at.y()]
        };
        let balls = figure.soles[side].iter().map(|(p, _)| *p);
        if goal.rolls {
            let near = balls.filter(|p| (p.x() - goal.pivot.x()).abs() < 1e-6);
            near.flat_map(|p| [-EDGE, EDGE].map(|d| place(p + Vec3([d, 0.0, 0.0])))).collect()
        } else {
            balls.map(place).collect()
        }
    };
    (0..length)
        .map(|t| {
            let standing: Vec<(usize, Span)> =
                (0..2).filter(|&s| feet[s][t].stands).map(|s| (s, stance(s, t))).collect();
            let firm = |span: Span| (span[0] == 0 || t > span[0]) && (span[1] == length || t + 1 < span[1]);
            let mut found: Vec<_> = standing.iter().copied().filter(|(_, span)| firm(*span)).collect();
            if found.is_empty() {
                found = standing;
            }
            let enduring = found.iter().all(|(s, span)| span[1] - span[0] >= long && !feet[*s][t].rolls);
            let margin = match (enduring, found.len()) {
                (_, 0) => return None,
                (false, _) => MARGINS[0],
                (true, 1) => MARGINS[1],
                (true, _) => MARGINS[2],
            };
            let points: Vec<[f64; 2]> = found.iter().flat_map(|(s, _)| corners(*s, &feet[*s][t])).collect();
            Some(Support { corners: hull(&points), margin })
        })
        .collect()
}
