//! Which axes a skeleton's bones have. Names say nothing about them. Where the joints are in the course of a motion does: it gives every part's
//! orientation, as for a motion of points, and each bone has its own axes at a constant turn from that.

use std::collections::BTreeMap;

use paid_lanes::{Quat, Vec3};
use paid_motion::rotation_log;

use crate::points::{Body, slopes, standing};
use crate::roles::SIDES;
use crate::{HumanMotion, Naming, RetargetError, Role, RoleSource, Table};

/// More frames than this say nothing more.
const ENOUGH: usize = 3000;
/// A limb that is straight, or a foot that does not stand, says little about its turn about itself.
const LITTLE: f64 = 1e-3;
/// A part of this mean weight says how it is turned about itself.
const SURE: f64 = 0.02;
/// Up to these angles [rad] bones have a table's axes: where the turn about the limb is known, for hands, and where it is not. Other axes are off by
/// 90 degrees or more.
const SAME: [f64; 3] = [1.05, 1.4, 2.1];
/// A part's shorter line has no direction `[m]`.
const SHORTEST_M: f64 = 0.01;

impl Naming {
    /// The name of axes that no table knows.
    const OWN: &str = "its own";

    /// The naming that fits a motion's bones, with the axes that they have: those of the names, those of another table, or what the motion shows.
    ///
    /// # Errors
    /// If no naming fits: the nearest one and the first bone that it lacks. A mirrored human.
    pub fn of(motion: &HumanMotion) -> Result<Self, RetargetError> {
        let named = Self::named(motion)?;
        let Some(shown) = Shown::of(motion, &named) else { return Ok(named) };
        let refuse = |place: &str, expected: &str, found: String| RetargetError::Points {
            path: motion.path.clone(),
            place: place.to_owned(),
            expected: expected.to_owned(),
            found,
        };
        if shown.mirrored {
            let found = "left and right exchanged, or left-handed axes: the toes point backward".to_owned();
            return Err(refuse("bones", "the left leg on the left", found));
        }
        if named.name != Self::WORDS && (shown.short.is_some() || shown.fits(motion, &named, &named)) {
            return Ok(named);
        }
        let others = [Self::lafan(), Self::bandai()].into_iter().filter(|other| other.name != named.name);
        if let Some(other) = others.into_iter().find(|other| shown.fits(motion, &named, other)) {
            return Ok(named.with(other.table, Some(other.name), |role| {
                let turn = other.source(role)?.turn;
                Some((named.bone(&other, role)?.to_owned(), turn))
            }));
        }
        if let Some(bone) = &shown.short {
            return Err(refuse(
                bone,
                "a line of 1 cm or more to the next joint, to see its axes",
                "less".to_owned(),
            ));
        }
        let plain = Self::points();
        let turned = |role: Role| {
            let bone = named.bone(&plain, role)?;
            let turn = shown.turn(motion, role, motion.skeleton.find(bone)?);
            turn.0.iter().all(|x| x.is_finite()).then(|| (bone.to_owned(), turn.0))
        };
        Ok(named.with(Table::points_to_g1, Some(Self::OWN), turned))
    }

    /// What has been recognized that the names do not say.
    pub(crate) fn note(&self) -> Option<String> {
        let names = match self.name {
            Self::WORDS => "names that were recognized".to_owned(),
            known => format!("the names of {known}"),
        };
        let axes = match self.axes? {
            Self::OWN => "axes that were derived from the motion".to_owned(),
            known => format!("the axes of {known}"),
        };
        Some(format!("the bones have {names} and {axes}"))
    }

    /// The same joints with other axes: a table, whose they are, and each part's bone and turn.
    fn with(
        &self,
        table: fn() -> Table,
        axes: Option<&'static str>,
        turned: impl Fn(Role) -> Option<(String, [f64; 4])>,
    ) -> Self {
        let source = |source: &RoleSource| match turned(source.role) {
            Some((orientation, turn)) => RoleSource { orientation, turn, ..source.clone() },
            None => source.clone(),
        };
        Self { sources: self.sources.iter().map(source).collect(), table, axes, ..self.clone() }
    }
}

/// Each part in the axes of the robot's body, and how much the frame says about it.
type Parts = BTreeMap<Role, (Quat<f64>, f64)>;

/// What the way of the joints shows.
struct Shown {
    /// Frames of the motion.
    frames: Vec<(usize, Parts)>,
    /// Left and right, or the axes, are exchanged.
    mirrored: bool,
    /// The first bone whose line to the next joint has no length.
    short: Option<String>,
}

impl Shown {
    /// Of the joints that `naming` names; `None` if the motion lacks a toe.
    fn of(motion: &HumanMotion, naming: &Naming) -> Option<Self> {
        let bone = |name: &str| motion.skeleton.find(name);
        let (mut joints, mut lines) = (BTreeMap::new(), Vec::new());
        for (side, name) in ["left", "right"].into_iter().enumerate() {
            let point = |role| bone(&naming.source(role)?.position);
            let [thigh, shin, _, upper_arm, forearm, hand] = SIDES[side];
            let [ankle, toe] = &naming.feet[side];
            let leg = [point(thigh)?, point(shin)?, bone(ankle)?, bone(toe)?];
            let arm = [point(upper_arm)?, point(forearm)?, point(hand)?];
            let leg_names = ["hip", "knee", "ankle", "toe"].into_iter().zip(leg);
            let names = leg_names.chain(["shoulder", "elbow", "wrist"].into_iter().zip(arm));
            joints.extend(names.map(|(part, i)| (format!("{name}_{part}"), vec![i])));
            lines.extend(leg.windows(2).chain(arm.windows(2)).map(|line| [line[0], line[1]]));
        }
        let step = motion.frames / ENOUGH + 1;
        let frames = || (0..motion.frames).step_by(step);
        let bodies: Vec<Body> = frames().map(|t| Body::of(motion.pos(t), &joints)).collect();
        let length = |t: usize, [a, b]: [usize; 2]| (Vec3(motion.pos(t)[a]) - Vec3(motion.pos(t)[b])).norm();
        let short = lines.iter().find(|&&line| frames().any(|t| length(t, line) < SHORTEST_M));
        let (slopes, stands) = (slopes(&bodies), [0, 1].map(|side| standing(&bodies, side)));
        let shown = |(k, body): (usize, &Body)| {
            let (turns, bends) = (body.orientations(slopes), body.bends());
            let mut parts =
                Parts::from([(Role::Hips, (turns.trunk[0], 1.0)), (Role::Torso, (turns.trunk[1], 1.0))]);
            for (side, [thigh, shin, foot, upper_arm, forearm, hand]) in SIDES.into_iter().enumerate() {
                let [leg, arm] = bends[side].map(|bend| LITTLE + bend * bend);
                let [upper, lower, sole] = turns.legs[side];
                let flat = if stands[side][k] { 1.0 } else { LITTLE };
                parts.extend([(thigh, (upper, leg)), (shin, (lower, leg)), (foot, (sole, flat))]);
                let [upper, lower] = turns.arms[side];
                parts.extend([(upper_arm, (upper, arm)), (forearm, (lower, arm)), (hand, (lower, arm))]);
            }
            parts
        };
        Some(Self {
            frames: frames().zip(bodies.iter().enumerate().map(shown)).collect(),
            mirrored: crate::points::mirrored(&bodies),
            short: short.map(|&[a, _]| motion.skeleton.bones[a].name.clone()),
        })
    }

    /// The mean turn that brings the axes of a bone (index `bone` of `motion`) to those of the robot's body that follows `role`.
    fn turn(&self, motion: &HumanMotion, role: Role, bone: usize) -> Quat<f64> {
        let mut sum = [0.0; 4];
        for (t, parts) in &self.frames {
            let Some((turn, weight)) = parts.get(&role) else { continue };
            let q = Quat(motion.quat(*t)[bone]).conj().mul(*turn);
            let dot: f64 = sum.iter().zip(q.0).map(|(a, b)| a * b).sum();
            let weight = if dot < 0.0 { -weight } else { *weight };
            sum.iter_mut().zip(q.0).for_each(|(a, b)| *a += weight * b);
        }
        Quat(sum).normalize()
    }

    /// Whether the bones of `named` have the axes of `known`.
    fn fits(&self, motion: &HumanMotion, named: &Naming, known: &Naming) -> bool {
        let table = (known.table)();
        table.tasks.iter().all(|task| {
            let bone = named.bone(known, task.role).and_then(|name| motion.skeleton.find(name));
            let (Some(bone), Some(source)) = (bone, known.source(task.role)) else { return false };
            let weights = self.frames.iter().filter_map(|(_, parts)| Some(parts.get(&task.role)?.1));
            let mean = weights.sum::<f64>() / self.frames.len().max(1) as f64;
            let most = match task.role {
                _ if mean < SURE => SAME[2],
                Role::LeftHand | Role::RightHand => SAME[1],
                _ => SAME[0],
            };
            let expected = Quat(source.turn).mul(Quat(task.turn));
            Vec3(rotation_log(expected.0, self.turn(motion, task.role, bone).0)).norm() < most
        })
    }
}
