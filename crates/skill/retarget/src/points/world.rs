//! Whether positions are those of a whole person in one fixed world with right-handed axes.

use std::path::Path;

use paid_lanes::Vec3;
use paid_motion::Points;

use super::pose::{Body, Part};
use super::sheet::Indices;
use crate::RetargetError;

/// Hips that stay within this on the floor `[m]` while both ankles leave a circle of the second radius `[m]` are the origin of each frame.
const STAYS_M: [f64; 2] = [0.03, 0.15];
/// A mean of the product of toes' way, left and up beyond this tells the axes' handedness: 0.17 is 10 degrees.
const HANDED: f64 = 0.17;

fn refuse(path: &Path, place: &str, expected: &str, found: String) -> RetargetError {
    RetargetError::Points {
        path: path.to_owned(),
        place: place.to_owned(),
        expected: expected.to_owned(),
        found,
    }
}

/// What is said where the hips are no way through a world.
fn no_world(path: &Path, found: String) -> RetargetError {
    let expected = "positions in one fixed world, with the way of the hips added to all points";
    refuse(path, "positions", expected, found)
}

/// Refuses points that are exactly at 0, 0, 0 in a frame: what was not found.
pub(super) fn whole(path: &Path, points: &Points, indices: &Indices) -> Result<(), RetargetError> {
    let zero = |t: usize, i: usize| points.frame(t)[i] == [0.0; 3];
    let hips = indices.get("hips").and_then(|list| list.first());
    if let Some(&hips) = hips.filter(|&&i| (0..points.frames).all(|t| zero(t, i))) {
        let found = format!("'{}' at 0, 0, 0 in every frame", points.names[hips]);
        return Err(no_world(path, found));
    }
    let gap = |t: usize| indices.values().flatten().find(|&&i| zero(t, i)).map(|&i| (t, i));
    match (0..points.frames).find_map(gap) {
        None => Ok(()),
        Some((t, i)) => {
            let found = format!("0, 0, 0 in frame {t} at '{}'", points.names[i]);
            Err(refuse(path, "positions", "no gaps (fill them before)", found))
        }
    }
}

/// Whether the toes point backward, with the trunk up and the left hip on the left.
pub(crate) fn mirrored(bodies: &[Body]) -> bool {
    bodies.iter().map(Body::handedness).sum::<f64>() < -HANDED * bodies.len() as f64
}

/// Refuses bodies `[m]`, z up, in left-handed axes, and those whose hips stay where they are while both feet walk. `said` is true if the
/// description asked for a mirror.
pub(super) fn right_handed_world(path: &Path, bodies: &[Body], said: bool) -> Result<(), RetargetError> {
    if mirrored(bodies) {
        let start = "with the trunk up and the toes ahead the left hip is on the right";
        let (expected, found) = if said {
            ("no 'left_handed = true' in the TOML", "right-handed axes".to_owned())
        } else {
            let remedy = "write 'left_handed = true' in the TOML, or exchange left and right there if only the names are wrong";
            ("right-handed axes", format!("left-handed ones: {start}; {remedy}"))
        };
        return Err(refuse(path, "positions", expected, found));
    }
    let hips = spread(bodies, Part::Hips);
    let ankles = [0, 1].map(|side| spread(bodies, Part::Ankle(side)));
    if hips < STAYS_M[0] && ankles.iter().all(|way| *way > STAYS_M[1]) {
        let [left, right] = ankles;
        let found = format!(
            "hips that stay within {hips:.3} m while the feet go {left:.2} and {right:.2} m from theirs"
        );
        return Err(no_world(path, found));
    }
    Ok(())
}

/// How far a part gets from its mean place on the floor `[m]`.
fn spread(bodies: &[Body], part: Part) -> f64 {
    let sum = bodies.iter().fold(Vec3::zero(), |sum, body| sum + body.at(part));
    let mean = sum.scale(1.0 / bodies.len().max(1) as f64);
    let far = |body: &Body| {
        let off = body.at(part) - mean;
        off.x().hypot(off.y())
    };
    bodies.iter().map(far).fold(0.0, f64::max)
}
