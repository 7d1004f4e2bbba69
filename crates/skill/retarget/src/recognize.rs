//! What files of human motion leave unsaid or wrong: the unit of length, the axis that points up, the frame rate, the bones' axes.
//!
//! A leg says the unit, the trunk the axis. Bones whose names nobody knows say nothing: such a motion stays as it is.

use core::ops::RangeInclusive;

use paid_lanes::stats::quantile;
use paid_lanes::{Quat, Vec3};

use crate::skeleton::about;
use crate::{HumanMotion, Naming, RetargetError, Role};

/// Length of a human's leg, hip to ankle over the knee `[m]`.
pub(crate) const LEG_M: RangeInclusive<f64> = 0.35..=1.4;
/// Units that are recognized: name, meters.
pub(crate) const UNITS: [(&str, f64); 3] = [("meters", 1.0), ("centimeters", 0.01), ("millimeters", 0.001)];
/// Cosine of the angle from an axis up to which a trunk points along it: 30 degrees.
const ALONG: f64 = 0.866;
/// Who lies on the file's floor has the lowest point this near to it `[m]` and the hips no higher than this over that `[m]`.
pub(crate) const ON_FLOOR_M: RangeInclusive<f64> = -0.1..=0.2;
pub(crate) const LOW_M: f64 = 0.45;

/// Half the time over which speeds and accelerations are taken `[s]`.
const PACE_S: f64 = 0.05;
const GRAVITY: f64 = 9.81;
/// In nearly all frames hips of real players fall with up to 1.2 times gravity, measured so; at twice their speed with 1.7 and more.
const MOST_FALL: f64 = 1.5;
/// One frame that is off says nothing about the rate.
const NEARLY_ALL: f64 = 0.99;
/// A foot that goes this far `[m]` and never this fast `[m/s]` is slow motion: real kicks at a quarter of their speed have 3.4 m/s.
const FAR_M: f64 = 0.6;
const SLOW_M_S: f64 = 3.5;

/// Where the parts are that unit and axis are told by.
struct Parts {
    hips: usize,
    torso: usize,
    /// Left, right: hip, knee, ankle.
    legs: [[usize; 3]; 2],
}

impl Parts {
    fn of(motion: &HumanMotion) -> Option<Self> {
        use Role::*;
        let naming = Naming::named(motion).ok()?;
        let bone = |role: Role| {
            let source = naming.sources.iter().find(|s| s.role == role)?;
            motion.skeleton.find(&source.position)
        };
        let leg = |roles: [Role; 3]| Some([bone(roles[0])?, bone(roles[1])?, bone(roles[2])?]);
        Some(Self {
            hips: bone(Hips)?,
            torso: bone(Torso)?,
            legs: [leg([LeftThigh, LeftShin, LeftFoot])?, leg([RightThigh, RightShin, RightFoot])?],
        })
    }

    /// The middle of the lengths of both legs in all frames `[m]`.
    fn leg(&self, motion: &HumanMotion) -> f64 {
        let way = |t: usize, [a, b]: [usize; 2]| (Vec3(motion.pos(t)[a]) - Vec3(motion.pos(t)[b])).norm();
        let frames = 0..motion.frames;
        let legs = frames.flat_map(|t| self.legs.map(|[a, b, c]| way(t, [a, b]) + way(t, [b, c])));
        let mut legs: Vec<f64> = legs.collect();
        legs.sort_by(f64::total_cmp);
        legs.get(legs.len() / 2).copied().unwrap_or(0.0)
    }

    /// Mean direction from the hips to the torso; zero without any.
    fn trunk(&self, motion: &HumanMotion) -> Vec3<f64> {
        let each = |t: usize| Vec3(motion.pos(t)[self.torso]) - Vec3(motion.pos(t)[self.hips]);
        let sum = (0..motion.frames).map(each).fold(Vec3::zero(), |sum, way| sum + way);
        sum.scale(1.0 / sum.norm().max(1e-12))
    }

    /// What is implausible about how fast the motion goes.
    fn pace(&self, motion: &HumanMotion) -> Option<String> {
        let at = |t: usize, i: usize| Vec3(motion.pos(t)[i]);
        let k = ((PACE_S * motion.fps).round() as usize).max(1);
        let dt = k as f64 / motion.fps;
        let frames = || k..motion.frames.saturating_sub(k);
        let fall =
            |t| (at(t, self.hips).scale(2.0) - at(t - k, self.hips) - at(t + k, self.hips)).z() / (dt * dt);
        let mut falls: Vec<f64> = frames().map(fall).collect();
        let fall = quantile(&mut falls, NEARLY_ALL).unwrap_or(0.0) / GRAVITY;
        let rate = format!("at {:.1} frames a second", motion.fps);
        if fall > MOST_FALL {
            let note = "a human falls with 1; --fps states another frame rate";
            return Some(format!(
                "{rate} the hips fall with {fall:.1} times the acceleration of gravity: {note}"
            ));
        }
        let feet = self.legs.map(|[.., foot]| foot);
        let fastest = feet
            .into_iter()
            .flat_map(|foot| frames().map(move |t| (at(t + k, foot) - at(t - k, foot)).norm()));
        let fastest = fastest.fold(0.0, f64::max) / (2.0 * dt);
        let far = feet
            .into_iter()
            .any(|foot| (0..motion.frames).any(|t| (at(t, foot) - at(0, foot)).norm() > FAR_M));
        let note = "little for a kick; --fps states another frame rate";
        (far && fastest < SLOW_M_S).then(|| format!("{rate} the fastest foot has {fastest:.1} m/s: {note}"))
    }
}

/// Where the unit of length of a motion comes from.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Unit {
    /// Whoever reads the file said it `[m]`.
    Told(f64),
    /// The file or its format says it `[m]`.
    Usual(f64),
}

impl Unit {
    /// Meters of a unit.
    pub fn meters(self) -> f64 {
        let (Self::Told(meters) | Self::Usual(meters)) = self;
        meters
    }
}

/// Takes the lengths of `motion`, which was read in `unit`, for what a leg says they are, and turns it if its trunk points along the
/// file's z axis where y is up by the format. Both are noted in the motion.
///
/// # Errors
/// A unit that was told and cannot be; a leg that no known unit makes a human's.
pub(crate) fn recognize(mut motion: HumanMotion, unit: Unit) -> Result<HumanMotion, RetargetError> {
    let Some(parts) = Parts::of(&motion) else { return Ok(motion) };
    let leg = parts.leg(&motion);
    if !LEG_M.contains(&leg) && leg > 0.0 {
        let read = unit.meters();
        let raw = leg / read;
        let other = UNITS.into_iter().find(|(_, unit)| LEG_M.contains(&(raw * unit)));
        let hint = match (unit, other) {
            (Unit::Usual(_), Some((name, meters))) => {
                motion.pos.as_flattened_mut().iter_mut().for_each(|x| *x *= meters / read);
                motion.notes.push(format!("the lengths were taken for {name}: a leg has {raw:.4}"));
                None
            }
            (Unit::Told(_), Some((name, meters))) => {
                Some(format!("these look like {name} (--unit {meters})"))
            }
            (_, None) => Some(format!(
                "{raw:.4} units of {read:.6} m, and neither meters, centimeters nor millimeters fit; name the meters of a unit \
                 (--unit)"
            )),
        };
        if let Some(hint) = hint {
            return Err(RetargetError::Points {
                path: motion.path,
                place: "unit of length".to_owned(),
                expected: format!("legs of {} to {} m", LEG_M.start(), LEG_M.end()),
                found: format!("{leg:.4} m: {hint}"),
            });
        }
    }
    let trunk = parts.trunk(&motion);
    // Ours is x, -z, y of the file's: a trunk along the file's z points along our -y.
    if trunk.y().abs() > ALONG && !lies_on_the_floor(&motion, parts.hips) {
        let (name, angle) = if trunk.y() < 0.0 { ("z", -1.0) } else { ("-z", 1.0) };
        let turn = about(0, angle * std::f64::consts::FRAC_PI_2);
        motion.pos.iter_mut().for_each(|p| *p = turn.rotate(Vec3(*p)).0);
        motion.quat.iter_mut().for_each(|q| *q = turn.mul(Quat(*q)).normalize().0);
        motion.notes.push(format!("{name} was taken for up: the trunk points there"));
    }
    motion.notes.extend(parts.pace(&motion));
    // The code that needs the axes reports what is wrong with them.
    motion.notes.extend(Naming::of(&motion).ok().and_then(|naming| naming.note()));
    Ok(motion)
}

/// Whether the body is low over a floor that is where the format has it: at height 0.
fn lies_on_the_floor(motion: &HumanMotion, hips: usize) -> bool {
    let lowest = motion.pos.iter().map(|p| p[2]).fold(f64::INFINITY, f64::min);
    let hips = (0..motion.frames).map(|t| motion.pos(t)[hips][2]).sum::<f64>() / motion.frames as f64;
    ON_FLOOR_M.contains(&lowest) && hips - lowest < LOW_M
}
