//! Positions of points, as pipelines that find people in videos give them, to a human motion.

mod pose;
mod sheet;
mod world;

use std::path::Path;

use paid_lanes::stats::quantile;
use paid_lanes::{Quat, Vec3};
use paid_motion::{MotionError, Points};
use pose::Part;
pub(crate) use pose::{Body, slopes, standing};

use crate::recognize::{LEG_M, LOW_M, ON_FLOOR_M, UNITS};
use crate::retarget::SHORTEST_S;
use crate::skeleton::about;
use crate::{Bone, HumanMotion, HumanOptions, RetargetError, Skeleton};

pub(crate) use world::mirrored;

pub use sheet::{PointSkeleton, parse_skeleton};

/// The segments: name, parent, the point where each begins.
const SEGMENTS: [(&str, Option<usize>, Part); 16] = [
    ("hips", None, Part::Hips),
    ("torso", Some(0), Part::Neck),
    ("left_thigh", Some(0), Part::Hip(0)),
    ("left_shin", Some(2), Part::Knee(0)),
    ("left_foot", Some(3), Part::Ankle(0)),
    ("left_toe", Some(4), Part::Toe(0)),
    ("right_thigh", Some(0), Part::Hip(1)),
    ("right_shin", Some(6), Part::Knee(1)),
    ("right_foot", Some(7), Part::Ankle(1)),
    ("right_toe", Some(8), Part::Toe(1)),
    ("left_upper_arm", Some(1), Part::Shoulder(0)),
    ("left_forearm", Some(10), Part::Elbow(0)),
    ("left_hand", Some(11), Part::Wrist(0)),
    ("right_upper_arm", Some(1), Part::Shoulder(1)),
    ("right_forearm", Some(13), Part::Elbow(1)),
    ("right_hand", Some(14), Part::Wrist(1)),
];

/// A human motion of points: segments with the axes of the robot's bodies (x ahead, y left, z up in a stand with the forearms ahead).
///
/// # Errors
/// A point that the skeleton names and the file lacks, or that is at 0, 0, 0 in a frame; a frame rate that nothing states; a unit or an up axis that
/// cannot be; left-handed axes; hips that are the origin of every frame.
pub fn motion_of_points(
    path: &Path,
    points: &Points,
    skeleton: &PointSkeleton,
    options: &HumanOptions,
) -> Result<HumanMotion, RetargetError> {
    let refuse = |place: &str, expected: String, found: String| RetargetError::Points {
        path: path.to_owned(),
        place: place.to_owned(),
        expected,
        found,
    };
    let fps = options.fps.or(skeleton.fps).or(points.fps).ok_or_else(|| MotionError::Unstated {
        path: path.to_owned(),
        what: "the frame rate",
        remedy: "give --fps, 'fps' in the TOML, or the key 'fps'",
    })?;
    if ((points.frames - 1) as f64) < SHORTEST_S * fps {
        let found = format!("{} frames at {fps} Hz", points.frames);
        return Err(refuse("positions", format!("at least {SHORTEST_S} s"), found));
    }
    let indices = skeleton.indices(path, &points.names)?;
    world::whole(path, points, &indices)?;
    let raw = (0..points.frames).map(|t| Body::of(points.frame(t), &indices));
    // Along x, so that what is up stays.
    let sign = if skeleton.left_handed { -1.0 } else { 1.0 };
    let raw: Vec<Body> = raw.map(|body| body.moved(|Vec3([x, y, z])| Vec3([sign * x, y, z]))).collect();
    let mut notes = Vec::new();

    let mut legs: Vec<f64> = raw.iter().flat_map(Body::legs).collect();
    let leg = quantile(&mut legs, 0.5).unwrap_or(0.0);
    let fits = |unit: f64| LEG_M.contains(&(leg * unit));
    let recognized = UNITS.into_iter().find(|(_, unit)| fits(*unit));
    let legs = format!("{} to {} m", LEG_M.start(), LEG_M.end());
    let unit = match (options.unit_m.or(skeleton.unit_m), recognized) {
        (Some(unit), _) if fits(unit) => unit,
        (Some(unit), other) => {
            let hint =
                other.map_or(String::new(), |(name, m)| format!(": these look like {name} (unit_m = {m})"));
            return Err(refuse("unit_m", format!("legs of {legs}"), format!("{:.4} m{hint}", leg * unit)));
        }
        (None, Some((name, unit))) => {
            if unit < 1.0 {
                notes.push(format!("the lengths were taken for {name}: a leg has {leg:.4}"));
            }
            unit
        }
        (None, None) => {
            return Err(refuse(
                "positions",
                format!("legs of {legs}, or 'unit_m'"),
                format!("{leg:.4} units"),
            ));
        }
    };

    let up = match skeleton.up {
        Some(up) => up,
        None => {
            let trunk = raw.iter().fold(Vec3::zero(), |sum, body| sum + body.trunk());
            let axis = (1..3).max_by(|a, b| trunk.0[*a].abs().total_cmp(&trunk.0[*b].abs())).unwrap_or(2);
            if trunk.0[axis].abs() < trunk.0[0].abs() {
                let found = "a trunk along x".to_owned();
                return Err(refuse("positions", "y or z up".to_owned(), found));
            }
            let up = sheet::Up { axis, down: trunk.0[axis] < 0.0 };
            let other = 3 - axis;
            if let Some(hips) = hips_over_floor(&raw, other, unit) {
                let found = format!(
                    "a trunk along {} and hips {hips:.2} m above 0 along {}: a player who stands, or one who lies",
                    AXES[axis], AXES[other]
                );
                return Err(refuse("positions", "'up' in the TOML".to_owned(), found));
            }
            notes.push(format!("{up} was taken for up: the trunk points there"));
            up
        }
    };
    // About x, which keeps left and right.
    let quarter = std::f64::consts::FRAC_PI_2;
    let turn = match (up.axis, up.down) {
        (1, false) => about(0, quarter),
        (1, true) => about(0, -quarter),
        (_, false) => Quat::identity(),
        (_, true) => about(0, 2.0 * quarter),
    };
    let bodies: Vec<Body> = raw.iter().map(|body| body.moved(|p| turn.rotate(p).scale(unit))).collect();
    world::right_handed_world(path, &bodies, skeleton.left_handed)?;
    Ok(assemble(path, fps, &bodies, notes))
}

/// Names of the axes.
const AXES: [&str; 3] = ["x", "y", "z"];

/// How high the hips are on average over a floor at 0 that `axis` points up from (or down, in files with that axis down), in files whose unit is
/// `unit` `[m]`, if the body lies low over such a floor.
fn hips_over_floor(bodies: &[Body], axis: usize, unit: f64) -> Option<f64> {
    [1.0, -1.0].into_iter().find_map(|sign| {
        let height = |p: Vec3<f64>| sign * unit * p.0[axis];
        let lowest = bodies.iter().flat_map(Body::points).map(height).fold(f64::INFINITY, f64::min);
        let hips = bodies.iter().map(|b| height(b.at(Part::Hips))).sum::<f64>() / bodies.len() as f64;
        (ON_FLOOR_M.contains(&lowest) && hips - lowest < LOW_M).then_some(hips)
    })
}

fn assemble(path: &Path, fps: f64, bodies: &[Body], notes: Vec<String>) -> HumanMotion {
    let slopes = slopes(bodies);
    let bones = SEGMENTS.map(|(name, parent, _)| Bone::new(name, parent));
    let mut motion = HumanMotion {
        name: path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default(),
        path: path.to_owned(),
        fps,
        frames: bodies.len(),
        skeleton: Skeleton { bones: bones.into(), channels: 0 },
        pos: Vec::with_capacity(bodies.len() * SEGMENTS.len()),
        quat: Vec::with_capacity(bodies.len() * SEGMENTS.len()),
        notes,
    };
    for body in bodies {
        let turns = body.orientations(slopes);
        motion.pos.extend(SEGMENTS.iter().map(|(.., part)| body.at(*part).0));
        let [hips, torso] = turns.trunk;
        motion.quat.extend([hips.0, torso.0]);
        for [thigh, shin, foot] in turns.legs {
            motion.quat.extend([thigh.0, shin.0, foot.0, foot.0]);
        }
        for [upper, forearm] in turns.arms {
            motion.quat.extend([upper.0, forearm.0, forearm.0]);
        }
    }
    motion
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHEET: &str = "[joints]\nleft_hip='lh'\nleft_knee='lk'\nleft_ankle='la'\nleft_toe='lt'\nleft_shoulder='ls'\n\
        left_elbow='le'\nleft_wrist='lw'\nright_hip='rh'\nright_knee='rk'\nright_ankle='ra'\nright_toe='rt'\n\
        right_shoulder='rs'\nright_elbow='re'\nright_wrist='rw'\n";

    /// A person in a stand with the forearms ahead, z up, in meters.
    fn person(frames: usize) -> Points {
        let side = |s: f64| {
            [
                [0.0, 0.1 * s, 0.9],
                [0.0, 0.1 * s, 0.5],
                [0.0, 0.1 * s, 0.1],
                [0.15, 0.1 * s, 0.03],
                [0.0, 0.2 * s, 1.4],
                [0.0, 0.2 * s, 1.1],
                [0.25, 0.2 * s, 1.1],
            ]
        };
        let one: Vec<[f64; 3]> = side(1.0).into_iter().chain(side(-1.0)).collect();
        let names = ["lh", "lk", "la", "lt", "ls", "le", "lw", "rh", "rk", "ra", "rt", "rs", "re", "rw"];
        Points {
            names: names.map(str::to_owned).into(),
            fps: Some(30.0),
            frames,
            pos: one.iter().copied().cycle().take(frames * one.len()).collect(),
        }
    }

    fn read(sheet: &str, points: &Points) -> Result<HumanMotion, RetargetError> {
        let skeleton = parse_skeleton(sheet, Path::new("s.toml"))?;
        motion_of_points(Path::new("p.npz"), points, &skeleton, &HumanOptions::default())
    }

    #[test]
    fn a_stand_has_the_axes_of_the_robots_bodies() {
        let motion = read(SHEET, &person(30)).expect("a person");
        assert_eq!(motion.notes, ["z was taken for up: the trunk points there"]);
        for (bone, q) in motion.skeleton.bones.iter().zip(motion.quat(3)) {
            assert!(q[0].abs() > 1.0 - 1e-9, "{}: {q:?}", bone.name);
        }
    }

    #[test]
    fn centimeters_with_y_up_are_recognized_and_said() {
        let mut other = person(30);
        other.pos.iter_mut().for_each(|[x, y, z]| [*x, *y, *z] = [100.0 * *x, 100.0 * *z, -100.0 * *y]);
        let motion = read(SHEET, &other).expect("a person");
        assert_eq!(motion.notes.len(), 2, "{:?}", motion.notes);
        assert!(motion.notes[0].starts_with("the lengths were taken for centimeters: a leg has 80"));
        assert!(motion.notes[1].starts_with("y was taken for up"));
        let stated = read(SHEET, &person(30)).expect("a person");
        for (a, b) in motion.pos.as_flattened().iter().zip(stated.pos.as_flattened()) {
            assert!((a - b).abs() < 1e-9, "{a} {b}");
        }
        let error = read(&format!("unit_m = 1\n{SHEET}"), &other).expect_err("refused").to_string();
        assert_eq!(
            error,
            "p.npz: unit_m: expected legs of 0.35 to 1.4 m, found 80.0000 m: these look like centimeters (unit_m = 0.01)"
        );
    }

    #[test]
    fn who_lies_is_not_stood_up_without_a_word_about_up() {
        // On the back: what was up points along y, the hips are 0.15 m above a floor at 0 along z.
        let mut lying = person(30);
        lying.pos.iter_mut().for_each(|[x, y, z]| [*x, *y, *z] = [*y, *z, 0.15 + *x]);
        let error = read(SHEET, &lying).expect_err("refused").to_string();
        assert_eq!(
            error,
            "p.npz: positions: expected 'up' in the TOML, found a trunk along y and hips 0.15 m above 0 along z: \
             a player who stands, or one who lies"
        );
        // The word decides: y is up, and this is a stand.
        let notes = read(&format!("up = 'y'\n{SHEET}"), &lying).expect("told").notes;
        assert_eq!(notes, [""; 0]);
        // With the other axis down, in centimeters.
        lying.pos.iter_mut().for_each(|[x, y, z]| [*x, *y, *z] = [100.0 * *x, -100.0 * *z, 100.0 * *y]);
        let error = read(SHEET, &lying).expect_err("refused").to_string();
        assert!(error.contains("a trunk along z and hips 0.15 m above 0 along y"), "{error}");
    }

    #[test]
    fn what_is_missing_is_named() {
        let refusal = |sheet: &str, points: &Points| read(sheet, points).expect_err("refused").to_string();
        let error = refusal(SHEET, &person(3));
        assert_eq!(error, "p.npz: positions: expected at least 0.5 s, found 3 frames at 30 Hz");
        let error = refusal(SHEET, &Points { fps: None, ..person(30) });
        assert!(error.starts_with("p.npz: the frame rate is not stated"), "{error}");
        let error = refusal(&SHEET.replace("'lk'", "'knee'"), &person(30));
        assert!(
            error.starts_with(
                "p.npz: joint_names: expected 'knee' (left_knee of the skeleton), found lh, lk,"
            )
        );
        let error = refusal(&SHEET.replace("right_toe='rt'\n", ""), &person(30));
        assert!(error.starts_with("s.toml: joints: expected 'right_toe'"), "{error}");
        let tiny = Points { pos: person(30).pos.iter().map(|p| p.map(|x| 1e-3 * x)).collect(), ..person(30) };
        let error = refusal(SHEET, &tiny);
        assert!(
            error.ends_with("expected legs of 0.35 to 1.4 m, or 'unit_m', found 0.0008 units"),
            "{error}"
        );
    }
}
